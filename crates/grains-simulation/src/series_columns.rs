//! Columns of `series.csv`.

use crate::heat;
use crate::species;
use grains_dem::Dem;

/// Columns of the time series and their units.
pub fn series_columns(dem: &Dem) -> Vec<(String, &'static str)> {
    const FIXED: [(&str, &str); 19] = [
        ("step", "-"),
        ("time", "s"),
        ("particles", "-"),
        ("inserted", "-"),
        ("left", "-"),
        ("contacts", "-"),
        ("wall_contacts", "-"),
        ("kinetic_translation", "J"),
        ("kinetic_rotation", "J"),
        ("potential", "J"),
        ("momentum_x", "kg m/s"),
        ("momentum_y", "kg m/s"),
        ("momentum_z", "kg m/s"),
        ("angular_momentum_x", "kg m2/s"),
        ("angular_momentum_y", "kg m2/s"),
        ("angular_momentum_z", "kg m2/s"),
        ("max_overlap", "-"),
        ("max_speed", "m/s"),
        ("deep_penetrations", "-"),
    ];
    const OF_PLANE: [(&str, &str); 2] = [("count", "-"), ("mass", "kg")];
    const OF_WALL: [(&str, &str); 6] =
        [("fx", "N"), ("fy", "N"), ("fz", "N"), ("tx", "N m"), ("ty", "N m"), ("tz", "N m")];
    const OF_LOADED_WALL: [(&str, &str); 2] = [("displacement", "m"), ("speed", "m/s")];
    const OF_WORN_WALL: [(&str, &str); 2] = [("worn_volume", "m3"), ("sliding_power", "W")];
    let mut columns: Vec<_> = FIXED.iter().map(|&(name, unit)| (name.to_string(), unit)).collect();
    if !dem.setup.bonds.is_empty() {
        columns.extend(["bonds", "broken_bonds"].map(|name| (name.to_string(), "-")));
    }
    if dem.particles.is_wet() {
        columns.extend(["bridges", "broken_bridges"].map(|name| (name.to_string(), "-")));
        let places = ["films", "bridges", "walls", "inserted", "left"];
        columns.extend(places.map(|place| (format!("liquid_{place}"), "m3")));
    }
    for plane in &dem.setup.planes {
        columns.extend(OF_PLANE.map(|(what, unit)| (format!("{}_{what}", plane.name), unit)));
    }
    for wall in &dem.setup.walls {
        columns.extend(OF_WALL.map(|(what, unit)| (format!("{}_{what}", wall.name), unit)));
        if wall.motion.loading().is_some() {
            columns.extend(OF_LOADED_WALL.map(|(what, unit)| (format!("{}_{what}", wall.name), unit)));
        }
        if wall.wear.is_some() {
            columns.extend(OF_WORN_WALL.map(|(what, unit)| (format!("{}_{what}", wall.name), unit)));
        }
    }
    for motion in &dem.setup.prescribed {
        columns.extend(OF_WALL.map(|(what, unit)| (format!("insert_{}_{what}", motion.name), unit)));
    }
    if dem.setup.shear.is_some() {
        const COMPONENTS: [&str; 6] = ["xx", "yy", "zz", "xy", "xz", "yz"];
        for part in ["stress", "kinetic_stress"] {
            columns.extend(COMPONENTS.map(|component| (format!("{part}_{component}"), "Pa")));
        }
        columns.push(("granular_temperature".to_string(), "m2/s2"));
    }
    columns.extend(heat::columns(dem));
    columns.extend(species::columns(dem));
    columns
}
