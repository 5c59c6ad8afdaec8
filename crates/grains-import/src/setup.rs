//! Commands that set up box, particles, time and output.

use crate::data_file::{self, AtomStyle};
use crate::dump_file::unit_error;
use crate::error::ImportError;
use crate::particles::{Particle, Superquadric};
use crate::regions::{Region, RegionForm};
use crate::report::{Outcome, Source};
use crate::script::{Answer, Group, Script};
use crate::units::{DENSITY, LENGTH, RATE, TIME, Units, VELOCITY};
use std::fs::File;
use std::io::BufReader;

/// Types of particles that a script may have: more are a slip.
const MOST_TYPES: usize = 10_000;

/// Steps that a command may ask for: the integers that an f64 tells apart end here.
const MAX_STEPS: f64 = 9e15;

fn checked_types(types: usize) -> Result<usize, String> {
    match types <= MOST_TYPES {
        true => Ok(types),
        false => {
            Err(format!("{types} types of particles are more than {MOST_TYPES}; correct the number of types"))
        }
    }
}

impl Script {
    pub(crate) fn set_units(&mut self, words: &[String]) -> Answer {
        let name = words.first().map_or("", String::as_str);
        self.units = Units::named(name).ok_or_else(|| unit_error(name))?;
        match name {
            "lj" => {
                self.report.remark("units lj: numbers without dimension were taken for m, kg and s, in which the equations are the same");
            }
            "si" => {}
            other => self.report.remark(format!("units {other} were converted to SI")),
        }
        Ok(Outcome::Translated)
    }

    pub(crate) fn set_boundary(&mut self, words: &[String]) -> Answer {
        if words.len() < 3 {
            return Err("three boundaries are wanted".into());
        }
        for (axis, word) in words.iter().take(3).enumerate() {
            let mut ends = word.chars();
            let first = ends.next().unwrap_or('p');
            self.scene.boundary[axis] = [first, ends.next().unwrap_or(first)];
        }
        if self.scene.boundary.iter().flatten().any(|c| matches!(c, 's' | 'm')) {
            self.report.remark("boundaries s and m follow the particles there; a domain is as large as the box of the script, and what leaves it ends the run unless its face is an outlet");
        }
        Ok(Outcome::Translated)
    }

    pub(crate) fn set_atom_style(&mut self, words: &[String]) -> Answer {
        let name = words.first().map_or("", String::as_str);
        self.style = Some(AtomStyle::named(name)?);
        Ok(Outcome::Translated)
    }

    pub(crate) fn define_region(&mut self, words: &[String]) -> Answer {
        let (id, rest) = words.split_first().ok_or("the name is missing")?;
        let nowhere = [[f64::NEG_INFINITY; 3], [f64::INFINITY; 3]];
        let domain = self.scene.corners.as_ref().map_or(nowhere, |(corners, _)| *corners);
        let region = Region::parse(rest, |w| self.length(w), |w| self.number(w), domain)?;
        self.regions.insert(id.clone(), region);
        Ok(Outcome::Translated)
    }

    pub(crate) fn region(&self, id: &str) -> Result<&Region, String> {
        self.regions.get(id).ok_or_else(|| format!("region {id} is unknown or was not translated"))
    }

    pub(crate) fn create_box(&mut self, words: &[String], source: &Source) -> Answer {
        let [types, id, ..] = words else { return Err("number of types and region are missing".into()) };
        self.types = checked_types(self.number(types)? as usize)?;
        let RegionForm::Block { lower, upper } = self.region(id)?.form.clone() else {
            return Err("the box must be a region of style block".into());
        };
        if lower.iter().chain(&upper).any(|x| !x.is_finite()) {
            return Err("the box must be finite".into());
        }
        self.scene.corners = Some(([lower, upper], source.clone()));
        Ok(Outcome::Translated)
    }

    pub(crate) fn read_data(&mut self, words: &[String], source: &Source) -> Result<Answer, ImportError> {
        let Some(name) = words.first() else { return Ok(Err("the file is missing".into())) };
        let path = self.file(name);
        let file = File::open(&path).map_err(ImportError::read(&path))?;
        let data = data_file::read(BufReader::new(file), &path, self.style, &self.units)?;
        if self.scene.corners.is_none() {
            self.scene.corners = Some(([data.lower, data.upper], source.clone()));
        }
        match checked_types(data.types) {
            Ok(types) => self.types = self.types.max(types),
            Err(why) => return Ok(Err(why)),
        }
        self.scene.start.extend(data.particles);
        self.scene.start_source.get_or_insert_with(|| source.clone());
        let is_plain = !words.iter().any(|word| matches!(word.as_str(), "add" | "offset" | "shift"));
        Ok(Ok(match is_plain {
            true => Outcome::Translated,
            false => Outcome::Partly("add, offset and shift were not followed".into()),
        }))
    }

    pub(crate) fn create_atoms(&mut self, words: &[String], source: &Source) -> Answer {
        let [kind, style, ..] = words else { return Err("type and style are missing".into()) };
        if style != "single" {
            return Err(format!("create_atoms {style}: give the particles in a data file, or insert them"));
        }
        let id = self.scene.start.iter().map(|p| p.id).max().unwrap_or(0) + 1;
        let mut particle = Particle::new(id, self.number(kind)? as usize);
        particle.position = self.units.vector(self.vector(words, 2)?, LENGTH);
        // What LAMMPS gives a sphere of which nothing more is said.
        particle.radius = Some(self.units.si(0.5, LENGTH));
        particle.density = Some(self.units.si(1.0, DENSITY));
        self.scene.start.push(particle);
        self.scene.start_source.get_or_insert_with(|| source.clone());
        Ok(Outcome::Translated)
    }

    /// The particles that a group or `set` chooses.
    fn chosen(&self, group: &Group) -> Vec<usize> {
        let is_in = |p: &Particle| match group {
            Group::All => true,
            Group::Types(kinds) => kinds.contains(&p.kind),
            Group::Ids(ids) => ids.contains(&p.id),
        };
        let start = self.scene.start.iter().enumerate();
        start.filter(|(_, p)| is_in(p)).map(|(index, _)| index).collect()
    }

    pub(crate) fn group(&self, name: &str) -> Result<Group, String> {
        self.groups.get(name).cloned().ok_or_else(|| format!("group {name} is unknown or was not translated"))
    }

    pub(crate) fn define_group(&mut self, words: &[String]) -> Answer {
        let [name, style, values @ ..] = words else { return Err("name and style are missing".into()) };
        let numbers = || self.numbers(values).map(|n| n.into_iter().map(|x| x as u64).collect::<Vec<_>>());
        let group = match style.as_str() {
            "type" => Group::Types(numbers()?.into_iter().map(|k| k as usize).collect()),
            "id" => Group::Ids(numbers()?),
            // Of use to integrators alone, in nearly all scripts.
            "region" | "union" | "empty" => Group::All,
            "subtract" => {
                let all = (1..=self.types.max(1)).collect::<Vec<_>>();
                let taken = values.iter().skip(1).filter_map(|name| self.groups.get(name));
                let taken: Vec<usize> = taken
                    .flat_map(|g| if let Group::Types(k) = g { k.clone() } else { Vec::new() })
                    .collect();
                Group::Types(all.into_iter().filter(|k| !taken.contains(k)).collect())
            }
            other => return Err(format!("groups of style {other} are not followed")),
        };
        self.groups.insert(name.clone(), group);
        Ok(Outcome::Translated)
    }

    pub(crate) fn set_particles(&mut self, words: &[String]) -> Answer {
        let [style, which, keys @ ..] = words else { return Err("what is set is missing".into()) };
        let group = match style.as_str() {
            "group" => self.group(which)?,
            "type" => Group::Types(vec![self.number(which)? as usize]),
            "atom" => Group::Ids(vec![self.number(which)? as u64]),
            other => return Err(format!("set {other} is not followed")),
        };
        let chosen = self.chosen(&group);
        let mut left = Vec::new();
        let mut rest = keys;
        while let Some((key, values)) = rest.split_first() {
            let used = self.set_key(key, values, &chosen)?;
            if used == 0 {
                left.push(key.clone());
            }
            rest = values.get(used.max(1)..).unwrap_or_default();
        }
        match left.is_empty() {
            true => Ok(Outcome::Translated),
            false => Err(format!("set {} is not followed", left.join(", "))),
        }
    }

    /// Sets a key of particles; returns how many words it took, 0 if it is unknown.
    fn set_key(&mut self, key: &str, values: &[String], chosen: &[usize]) -> Result<usize, String> {
        let value = |k: usize| self.number(values.get(k).map_or("", String::as_str));
        type Change = Box<dyn Fn(&mut Particle)>;
        let (used, change): (usize, Change) = match key {
            "type" => {
                let kind = value(0)? as usize;
                (1, Box::new(move |p| p.kind = kind))
            }
            "density" => {
                let density = self.units.si(value(0)?, DENSITY);
                (1, Box::new(move |p| p.density = Some(density)))
            }
            "diameter" => {
                let radius = self.units.si(0.5 * value(0)?, LENGTH);
                (1, Box::new(move |p| p.radius = Some(radius)))
            }
            "x" | "y" | "z" | "vx" | "vy" | "vz" | "omegax" | "omegay" | "omegaz" => {
                let axis = usize::from(key.as_bytes()[key.len() - 1] - b'x');
                let number = value(0)?;
                match key.len() {
                    1 => {
                        let x = self.units.si(number, LENGTH);
                        (1, Box::new(move |p| p.position[axis] = x))
                    }
                    2 => {
                        let v = self.units.si(number, VELOCITY);
                        (1, Box::new(move |p| p.velocity[axis] = v))
                    }
                    _ => {
                        let w = self.units.si(number, RATE);
                        (1, Box::new(move |p| p.angular_velocity[axis] = w))
                    }
                }
            }
            "omega" => {
                let omega = self.units.vector(self.vector(values, 0)?, RATE);
                (3, Box::new(move |p| p.angular_velocity = omega))
            }
            "shape" => {
                let given = self.units.vector(self.vector(values, 0)?, LENGTH);
                let is_diameter = self.style == Some(AtomStyle::Ellipsoid);
                let semi_axes = given.map(|x| if is_diameter { 0.5 * x } else { x });
                (
                    3,
                    Box::new(move |p| {
                        let blockiness = p.shape.map_or([2.0; 2], |s| s.blockiness);
                        p.shape = Some(Superquadric { semi_axes, blockiness });
                    }),
                )
            }
            "blockiness" | "roundness" => {
                let given = [value(0)?, value(1)?];
                (
                    2,
                    Box::new(move |p| {
                        if let Some(shape) = &mut p.shape {
                            shape.blockiness = given;
                        }
                    }),
                )
            }
            "quat" => {
                let ([x, y, z], degrees) = (self.vector(values, 0)?, value(3)?);
                let (sin, cos) = (0.5 * degrees.to_radians()).sin_cos();
                let length = (x * x + y * y + z * z).sqrt();
                if length == 0.0 {
                    return Err("set quat: the axis has no direction".into());
                }
                let turn = [cos, sin * x / length, sin * y / length, sin * z / length];
                (4, Box::new(move |p| p.orientation = Some(turn)))
            }
            _ => return Ok(0),
        };
        for index in chosen {
            let mut particle = self.scene.start[*index].clone();
            change(&mut particle);
            particle.check()?;
            self.scene.start[*index] = particle;
        }
        Ok(used)
    }

    pub(crate) fn set_velocity(&mut self, words: &[String]) -> Answer {
        let [group, style, values @ ..] = words else { return Err("group and style are missing".into()) };
        if style != "set" {
            return Err(format!("velocity {style} is not followed"));
        }
        let chosen = self.chosen(&self.group(group)?);
        if self.step > 0 {
            return Err("velocities are set at the beginning alone".into());
        }
        for (axis, word) in values.iter().take(3).enumerate().filter(|(_, w)| w.as_str() != "NULL") {
            let speed = self.units.si(self.number(word)?, VELOCITY);
            chosen.iter().for_each(|index| self.scene.start[*index].velocity[axis] = speed);
        }
        Ok(Outcome::Translated)
    }

    pub(crate) fn set_timestep(&mut self, words: &[String]) -> Answer {
        let dt = self.number(words.first().ok_or("the step is missing")?)?;
        self.dt = Some(self.units.si(dt, TIME));
        Ok(Outcome::Translated)
    }

    pub(crate) fn run(&mut self, words: &[String]) -> Answer {
        let word = words.first().ok_or("the number of steps is missing")?;
        let steps = self.number(word)?.round();
        if !(0.0..=MAX_STEPS).contains(&steps) {
            return Err(format!("{word} steps: must be between 0 and {MAX_STEPS:e}"));
        }
        let steps = steps as u64;
        let is_upto = words.iter().any(|word| word == "upto");
        let steps = if is_upto { steps.saturating_sub(self.step) } else { steps };
        // LAMMPS' own for units si and cgs.
        let dt = self.dt.unwrap_or(1e-5);
        self.scene.runs.push((steps, dt));
        self.step = self.step.saturating_add(steps);
        self.time += steps as f64 * dt;
        Ok(Outcome::Translated)
    }

    pub(crate) fn dump(&mut self, words: &[String]) -> Answer {
        let [_, _, style, every, ..] = words else {
            return Err("style and number of steps are missing".into());
        };
        if style.starts_with("mesh") || style.starts_with("euler") {
            return Ok(Outcome::Unneeded(
                "walls.vtkhdf has all walls, with loads and wear, at each snapshot",
            ));
        }
        if style == "local" || style.starts_with("local") {
            return Err("contacts are not written one by one".into());
        }
        let interval = self.number(every)? * self.step_length()?;
        let shortest = self.scene.intervals[0].map_or(interval, |other| other.min(interval));
        self.scene.intervals[0] = Some(shortest);
        Ok(Outcome::Translated)
    }

    pub(crate) fn thermo(&mut self, words: &[String]) -> Answer {
        let every = self.number(words.first().ok_or("the number of steps is missing")?)?;
        // `thermo` may come before `timestep`.
        self.series_steps = Some(every);
        Ok(Outcome::Translated)
    }

    pub(crate) fn restart(&mut self, words: &[String]) -> Answer {
        let every = self.number(words.first().ok_or("the number of steps is missing")?)?;
        self.scene.intervals[2] = Some(every * self.step_length()?);
        Ok(Outcome::Translated)
    }
}
