//! Data files: what `read_data` reads.

use crate::error::ImportError;
use crate::particles::{Particle, Superquadric};
use crate::units::{DENSITY, LENGTH, RATE, Units, VELOCITY};
use std::collections::BTreeMap;
use std::io::BufRead;
use std::path::Path;

/// Columns of the section `Atoms`.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum AtomStyle {
    /// id type diameter density x y z
    Sphere,
    /// id type flag density x y z, with axes and quaternions in the section `Ellipsoids`
    Ellipsoid,
    /// id type density semi-axes blockiness x y z
    Superquadric,
}

impl AtomStyle {
    /// The style of this name.
    ///
    /// # Errors
    /// Styles that have no particles of a size.
    pub fn named(name: &str) -> Result<Self, String> {
        match name {
            "sphere" | "granular" => Ok(Self::Sphere),
            "ellipsoid" => Ok(Self::Ellipsoid),
            "superquadric" => Ok(Self::Superquadric),
            "hybrid" => Err("columns of atom_style hybrid depend on its parts: write the state with `dump custom` and give that file".into()),
            other => Err(format!("atom_style {other} is not read, but sphere, granular, ellipsoid and superquadric are")),
        }
    }

    /// Numbers of columns without those of periodic images, and of the first coordinate.
    fn columns(self) -> (usize, usize) {
        match self {
            Self::Sphere | Self::Ellipsoid => (7, 4),
            Self::Superquadric => (11, 8),
        }
    }
}

/// What a data file holds.
#[derive(Clone, Debug, Default)]
pub struct DataFile {
    /// Lower corner of the box (m).
    pub lower: [f64; 3],
    /// Upper corner of the box (m).
    pub upper: [f64; 3],
    /// Number of types.
    pub types: usize,
    /// The particles, by their numbers.
    pub particles: Vec<Particle>,
}

/// The words with which sections begin, of those that say nothing of particles too.
const SECTIONS: [&str; 10] = [
    "Atoms",
    "Velocities",
    "Ellipsoids",
    "Masses",
    "Pair Coeffs",
    "PairIJ Coeffs",
    "Bodies",
    "Lines",
    "Bonds",
    "Triangles",
];

/// Reads a data file named `path`.
///
/// # Errors
/// An unreadable file, sections that are short, columns that are missing, and what is no number.
pub fn read(
    input: impl BufRead,
    path: &Path,
    style: Option<AtomStyle>,
    units: &Units,
) -> Result<DataFile, ImportError> {
    let mut reader =
        Reader { path, style, units, data: DataFile::default(), rows: BTreeMap::new(), count: 0 };
    let mut section: Option<String> = None;
    for (index, line) in input.lines().enumerate() {
        let line = line.map_err(ImportError::read(path))?;
        let (text, comment) = line.split_once('#').unwrap_or((&line, ""));
        let text = text.trim();
        // The first line is a title.
        if index == 0 || text.is_empty() {
            continue;
        }
        if SECTIONS.contains(&text) {
            if text == "Atoms" && reader.style.is_none() && !comment.trim().is_empty() {
                let style = AtomStyle::named(comment.trim());
                reader.style = Some(style.map_err(|e| ImportError::at(path, index + 1, e))?);
            }
            section = Some(text.to_owned());
            continue;
        }
        let read = match section.as_deref() {
            None => reader.header(text),
            Some("Atoms") => reader.atom(text),
            Some("Velocities") => reader.velocity(text),
            Some("Ellipsoids") => reader.ellipsoid(text),
            Some(_) => Ok(()),
        };
        read.map_err(|message| ImportError::at(path, index + 1, message))?;
    }
    reader.finish()
}

/// A data file as far as it is read.
struct Reader<'a> {
    path: &'a Path,
    style: Option<AtomStyle>,
    units: &'a Units,
    data: DataFile,
    rows: BTreeMap<u64, Particle>,
    count: usize,
}

fn no_number(word: &str) -> String {
    let remedy = if word.contains(',') { "; decimals have a point, as in 0.005" } else { "" };
    format!("`{word}` is no number{remedy}")
}

/// Numbers of a line.
fn numbers(text: &str) -> Result<Vec<f64>, String> {
    text.split_whitespace().map(|word| word.parse().map_err(|_| no_number(word))).collect()
}

impl Reader<'_> {
    fn header(&mut self, text: &str) -> Result<(), String> {
        let words: Vec<&str> = text.split_whitespace().collect();
        if text.ends_with("xy xz yz") {
            return Err("the box is tilted, and a domain is upright".into());
        }
        match words[..] {
            [count, "atoms"] => self.count = count.parse().map_err(|_| format!("`{count}` is no number"))?,
            [count, "atom", "types"] => {
                self.data.types = count.parse().map_err(|_| format!("`{count}` is no number"))?;
            }
            [lower, upper, "xlo" | "ylo" | "zlo", high] => {
                let axis = ["xhi", "yhi", "zhi"].iter().position(|name| *name == high);
                let axis = axis.ok_or_else(|| format!("`{text}` is no border of the box"))?;
                let ends = numbers(&format!("{lower} {upper}"))?;
                self.data.lower[axis] = self.units.si(ends[0], LENGTH);
                self.data.upper[axis] = self.units.si(ends[1], LENGTH);
            }
            _ => {}
        }
        Ok(())
    }

    fn atom(&mut self, text: &str) -> Result<(), String> {
        let row = numbers(text)?;
        let style = self.style.unwrap_or(match row.len() {
            11 | 14 => AtomStyle::Superquadric,
            _ => AtomStyle::Sphere,
        });
        self.style = Some(style);
        let (columns, at) = style.columns();
        if row.len() != columns && row.len() != columns + 3 {
            return Err(format!(
                "{} columns, but atoms of style {style:?} have {columns}, and 3 more with periodic images",
                row.len()
            ));
        }
        let mut particle = Particle::new(row[0] as u64, row[1] as usize);
        particle.position = self.units.vector([row[at], row[at + 1], row[at + 2]], LENGTH);
        match style {
            AtomStyle::Sphere => {
                particle.radius = Some(self.units.si(0.5 * row[2], LENGTH));
                particle.density = Some(self.units.si(row[3], DENSITY));
            }
            AtomStyle::Ellipsoid => particle.density = Some(self.units.si(row[3], DENSITY)),
            AtomStyle::Superquadric => {
                particle.density = Some(self.units.si(row[2], DENSITY));
                let semi_axes = self.units.vector([row[3], row[4], row[5]], LENGTH);
                particle.shape = Some(Superquadric { semi_axes, blockiness: [row[6], row[7]] });
            }
        }
        particle.check()?;
        match self.rows.insert(particle.id, particle) {
            Some(first) => Err(format!("atom {} is there twice", first.id)),
            None => Ok(()),
        }
    }

    fn row(&mut self, id: f64) -> Result<&mut Particle, String> {
        self.rows
            .get_mut(&(id as u64))
            .ok_or_else(|| format!("there is no atom {id} in the section Atoms before"))
    }

    fn velocity(&mut self, text: &str) -> Result<(), String> {
        let (row, units) = (numbers(text)?, *self.units);
        let [id, vx, vy, vz, wx, wy, wz] = row[..] else {
            return Err(format!("{} columns, but a velocity has 7: id vx vy vz wx wy wz", row.len()));
        };
        let is_momentum = self.style == Some(AtomStyle::Ellipsoid);
        let particle = self.row(id)?;
        particle.velocity = units.vector([vx, vy, vz], VELOCITY);
        if !is_momentum {
            particle.angular_velocity = units.vector([wx, wy, wz], RATE);
        } else if [wx, wy, wz] != [0.0; 3] {
            return Err("angular momenta of ellipsoids are not read: write the state with `dump custom` and give that file".into());
        }
        Ok(())
    }

    fn ellipsoid(&mut self, text: &str) -> Result<(), String> {
        let (row, units) = (numbers(text)?, *self.units);
        let [id, a, b, c, qw, qx, qy, qz] = row[..] else {
            return Err(format!("{} columns, but an ellipsoid has 8: id, diameters, quaternion", row.len()));
        };
        let particle = self.row(id)?;
        let semi_axes = units.vector([0.5 * a, 0.5 * b, 0.5 * c], LENGTH);
        match semi_axes.iter().all(|x| *x == semi_axes[0]) {
            true => particle.radius = Some(semi_axes[0]),
            false => particle.shape = Some(Superquadric { semi_axes, blockiness: [2.0; 2] }),
        }
        particle.orientation = Some([qw, qx, qy, qz]);
        particle.check()?;
        Ok(())
    }

    fn finish(mut self) -> Result<DataFile, ImportError> {
        let wrong = |message: String| Err(ImportError::at(self.path, 1, message));
        if self.rows.len() != self.count {
            return wrong(format!("{} atoms are announced, and {} are there", self.count, self.rows.len()));
        }
        if (0..3).any(|a| self.data.lower[a] >= self.data.upper[a]) {
            return wrong("the box (xlo xhi, ylo yhi, zlo zhi) is missing or empty".into());
        }
        if let Some(point) = self.rows.values().find(|p| p.radius.is_none() && p.shape.is_none()) {
            return wrong(format!("atom {} has no size: the section Ellipsoids does not name it", point.id));
        }
        self.data.particles = self.rows.into_values().collect();
        Ok(self.data)
    }
}
