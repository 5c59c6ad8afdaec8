#![no_main]

grains_fuzz::target!(grains_inputs::table);
