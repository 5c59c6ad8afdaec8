//! Text dumps: frames of particles with any columns.

use crate::error::ImportError;
use crate::particles::{Particle, Superquadric, Volumes};
use crate::units::{DENSITY, LENGTH, MASS, RATE, TIME, Units, VELOCITY};
use std::f64::consts::PI;
use std::io::{BufRead, Lines};
use std::path::{Path, PathBuf};

/// One frame.
#[derive(Clone, Debug, Default)]
pub struct Frame {
    /// Number of the step.
    pub step: u64,
    /// Time (s), if the dump has it.
    pub time: Option<f64>,
    /// Lower corner of the box (m).
    pub lower: [f64; 3],
    /// Upper corner of the box (m).
    pub upper: [f64; 3],
    /// Whether the box is periodic along each axis.
    pub periodic: [bool; 3],
    /// Names of the columns.
    pub columns: Vec<String>,
    /// The numbers of each particle, in units of the file; sorted by `id` if there is one.
    pub rows: Vec<Vec<f64>>,
}

/// The frames of a dump, one after the other.
pub struct Frames<R> {
    lines: Lines<R>,
    path: PathBuf,
    line: usize,
    units: Units,
}

impl<R: BufRead> Frames<R> {
    /// The frames of a dump named `path`.
    pub fn new(input: R, path: &Path, units: Units) -> Self {
        Self { lines: input.lines(), path: path.to_path_buf(), line: 0, units }
    }

    fn wrong(&self, message: impl Into<String>) -> ImportError {
        ImportError::at(&self.path, self.line, message)
    }

    fn next_line(&mut self) -> Result<Option<String>, ImportError> {
        self.line += 1;
        self.lines.next().transpose().map_err(ImportError::read(&self.path))
    }

    fn line(&mut self) -> Result<String, ImportError> {
        let line = self.next_line()?;
        line.ok_or_else(|| self.wrong("the file ends within a frame: was the run killed while it wrote?"))
    }

    fn numbers(&mut self) -> Result<Vec<f64>, ImportError> {
        let line = self.line()?;
        // A column of words, such as `element`, is none of numbers.
        let parsed = line.split_whitespace().map(|word| word.parse().unwrap_or(f64::NAN)).collect();
        Ok(parsed)
    }

    fn frame(&mut self) -> Result<Option<Frame>, ImportError> {
        let mut frame = Frame::default();
        let mut count = 0;
        loop {
            let Some(line) = self.next_line()? else {
                return match frame.step {
                    0 if count == 0 => Ok(None),
                    _ => Err(self.wrong("the file ends within a frame: was the run killed while it wrote?")),
                };
            };
            if line.trim().is_empty() {
                continue;
            }
            let Some(item) = line.trim_start_matches('\u{feff}').trim().strip_prefix("ITEM:") else {
                return Err(self.wrong(format!("`{}` where `ITEM:` must begin a section", shortened(&line))));
            };
            let words: Vec<&str> = item.split_whitespace().collect();
            match words[..] {
                ["TIMESTEP"] => frame.step = self.count("number of the step")?,
                ["TIME"] => frame.time = self.numbers()?.first().map(|t| self.units.si(*t, TIME)),
                ["UNITS"] => {
                    let name = self.line()?;
                    let units = Units::named(name.trim());
                    self.units = units.ok_or_else(|| self.wrong(unit_error(name.trim())))?;
                }
                ["NUMBER", "OF", "ATOMS"] => count = self.count("number of atoms")? as usize,
                ["BOX", "BOUNDS", ref borders @ ..] => self.bounds(&mut frame, borders)?,
                ["ATOMS", ref columns @ ..] => {
                    frame.columns = columns.iter().map(|name| (*name).to_owned()).collect();
                    self.atoms(&mut frame, count)?;
                    return Ok(Some(frame));
                }
                // Such as LABEL of LIGGGHTS.
                _ => drop(self.line()?),
            }
        }
    }

    fn count(&mut self, what: &str) -> Result<u64, ImportError> {
        let line = self.line()?;
        line.trim().parse().map_err(|_| self.wrong(format!("`{}` is no {what}", shortened(&line))))
    }

    fn bounds(&mut self, frame: &mut Frame, borders: &[&str]) -> Result<(), ImportError> {
        if borders.contains(&"xy") {
            return Err(self.wrong("the box is tilted, and a domain is upright"));
        }
        for axis in 0..3 {
            frame.periodic[axis] = borders.get(axis).is_some_and(|b| b.starts_with('p'));
            let ends = self.numbers()?;
            let [lower, upper] = ends[..] else {
                return Err(self.wrong("two numbers must bound the box along each axis"));
            };
            frame.lower[axis] = self.units.si(lower, LENGTH);
            frame.upper[axis] = self.units.si(upper, LENGTH);
        }
        Ok(())
    }

    fn atoms(&mut self, frame: &mut Frame, count: usize) -> Result<(), ImportError> {
        let wanted = frame.columns.len();
        for _ in 0..count {
            let row = self.numbers()?;
            if row.len() != wanted {
                return Err(self.wrong(format!("{} columns, but {wanted} are named", row.len())));
            }
            frame.rows.push(row);
        }
        if let Some(id) = frame.column("id") {
            frame.rows.sort_by(|a, b| a[id].total_cmp(&b[id]));
        }
        Ok(())
    }

    /// The units of the file, which it may name itself.
    pub fn units(&self) -> Units {
        self.units
    }
}

impl<R: BufRead> Iterator for Frames<R> {
    type Item = Result<Frame, ImportError>;

    fn next(&mut self) -> Option<Self::Item> {
        self.frame().transpose()
    }
}

/// What to do about units that are not consistent.
pub(crate) fn unit_error(name: &str) -> String {
    format!(
        "units {name} are no consistent mechanical units; si, cgs, micro, nano and lj are read: convert its numbers, or they make another case"
    )
}

fn shortened(line: &str) -> String {
    line.chars().take(60).collect()
}

impl Frame {
    /// Place of a column.
    pub fn column(&self, name: &str) -> Option<usize> {
        self.columns.iter().position(|column| column == name)
    }

    /// Places of three or more columns that belong together.
    fn group<const N: usize>(&self, names: [&str; N]) -> Option<[usize; N]> {
        let mut places = [0; N];
        for (place, name) in places.iter_mut().zip(names) {
            *place = self.column(name)?;
        }
        Some(places)
    }

    /// The particles in SI units.
    ///
    /// # Errors
    /// Frames without coordinates or with numbers that are none.
    pub fn particles(&self, units: &Units) -> Result<Vec<Particle>, String> {
        let plain = self.group(["x", "y", "z"]).or_else(|| self.group(["xu", "yu", "zu"]));
        let scaled = self.group(["xs", "ys", "zs"]).or_else(|| self.group(["xsu", "ysu", "zsu"]));
        if plain.is_none() && scaled.is_none() {
            return Err(format!("no coordinates among the columns {}; dump x y z", self.columns.join(" ")));
        }
        let groups = [
            self.group(["vx", "vy", "vz"]),
            self.group(["omegax", "omegay", "omegaz"]),
            self.group(["shapex", "shapey", "shapez"]),
        ];
        let quaternion = self
            .group(["quat1", "quat2", "quat3", "quat4"])
            .or_else(|| self.group(["quatw", "quati", "quatj", "quatk"]))
            .or_else(|| self.group(["c_quat[1]", "c_quat[2]", "c_quat[3]", "c_quat[4]"]));
        let blockiness =
            self.group(["blockiness1", "blockiness2"]).or_else(|| self.group(["roundness1", "roundness2"]));
        let mut volumes = Volumes::default();
        let particles = self.rows.iter().enumerate().map(|(index, row)| {
            let at = |places: [usize; 3]| places.map(|k| row[k]);
            let value = |name: &str| self.column(name).map(|k| row[k]);
            let id = value("id").unwrap_or((index + 1) as f64) as u64;
            let mut particle = Particle::new(id, value("type").unwrap_or(1.0) as usize);
            particle.position = match (plain, scaled) {
                (Some(places), _) => units.vector(at(places), LENGTH),
                (None, Some(places)) => {
                    let share = at(places);
                    std::array::from_fn(|a| self.lower[a] + share[a] * (self.upper[a] - self.lower[a]))
                }
                (None, None) => [f64::NAN; 3],
            };
            for axis in (0..3).filter(|a| self.periodic[*a]) {
                if (self.lower[axis]..=self.upper[axis]).contains(&particle.position[axis]) {
                    continue;
                }
                let width = self.upper[axis] - self.lower[axis];
                let inside = (particle.position[axis] - self.lower[axis]).rem_euclid(width);
                particle.position[axis] = self.lower[axis] + inside;
            }
            particle.velocity = groups[0].map_or([0.0; 3], |g| units.vector(at(g), VELOCITY));
            particle.angular_velocity = groups[1].map_or([0.0; 3], |g| units.vector(at(g), RATE));
            let radius = value("radius").or(value("diameter").map(|d| 0.5 * d));
            particle.radius = radius.map(|r| units.si(r, LENGTH));
            particle.orientation = quaternion.map(|places| places.map(|k| row[k]));
            particle.shape = groups[2].map(|g| Superquadric {
                semi_axes: units.vector(at(g), LENGTH),
                blockiness: blockiness.map_or([2.0; 2], |places| places.map(|k| row[k])),
            });
            particle.density = value("density").map(|d| units.si(d, DENSITY)).or_else(|| {
                let mass = units.si(value("mass")?, MASS);
                let volume = match particle.shape {
                    Some(shape) => volumes.of(shape)?,
                    None => 4.0 / 3.0 * PI * particle.radius?.powi(3),
                };
                Some(mass / volume)
            });
            particle.check()?;
            let numbers = [particle.position, particle.velocity, particle.angular_velocity].concat();
            match numbers.iter().all(|x| x.is_finite()) {
                true => Ok(particle),
                false => Err(format!(
                    "atom {id} of step {} has a place or motion that is no number; decimals have a point",
                    self.step
                )),
            }
        });
        particles.collect()
    }
}
