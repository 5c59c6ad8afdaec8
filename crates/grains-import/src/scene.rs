//! What a script sets up, in SI units and without the words of any code.

use crate::laws::PairLaw;
use crate::liggghts_law::Style;
use crate::meshes::PlacedMesh;
use crate::particles::{Particle, Superquadric, check_sizes};
use crate::report::Source;
use grains_case::{Motion, Place, WallKind};
use std::collections::BTreeSet;
use std::f64::consts::PI;

/// A domain, particles, walls and laws.
#[derive(Clone, Debug, Default)]
pub struct Scene {
    /// Lower and upper corner of the box (m), and what gave it.
    pub corners: Option<([[f64; 3]; 2], Source)>,
    /// Boundary of either face of each axis, as LAMMPS names them: p, f, s or m.
    pub boundary: [[char; 2]; 3],
    /// Whether particles may leave the box.
    pub loses: bool,
    /// Acceleration of gravity (m/s²), and what gave it.
    pub gravity: Option<([f64; 3], Source)>,
    /// Walls.
    pub walls: Vec<WallPlan>,
    /// Insertions.
    pub inserts: Vec<InsertPlan>,
    /// Particles at the beginning, and what gave them.
    pub start: Vec<Particle>,
    /// What gave them.
    pub start_source: Option<Source>,
    /// Types of particles that stay where they are.
    pub frozen: BTreeSet<usize>,
    /// Runs: steps, and the length of a step (s).
    pub runs: Vec<(u64, f64)>,
    /// Times (s) between snapshots, rows of the series, and checkpoints.
    pub intervals: [Option<f64>; 3],
    /// Laws of pairs of particles.
    pub laws: Laws,
    /// Temperature of particles (K), and what gave it.
    pub heat: Option<(f64, Source)>,
}

/// Laws of pairs of particles.
#[derive(Clone, Debug, Default)]
pub enum Laws {
    /// Nothing has been said yet.
    #[default]
    None,
    /// LIGGGHTS: a style, whose coefficients are properties of types.
    Style(Style, Source),
    /// LAMMPS: laws of ranges of types (from 1, both ends included); the last one that holds counts.
    Coefficients(Vec<([[usize; 2]; 2], PairLaw, Source)>),
}

/// Properties of the types, with the style of walls that takes them.
#[derive(Clone, Debug)]
pub enum WallLaw {
    /// LIGGGHTS: the type of the wall and a style.
    Style(usize, Style),
    /// LAMMPS: a law of the wall.
    Law(PairLaw),
}

/// The form of a wall.
#[derive(Clone, Debug)]
pub enum WallForm {
    /// As a case has it.
    Kind(WallKind),
    /// A mesh.
    Mesh(PlacedMesh),
}

/// A wall.
#[derive(Clone, Debug)]
pub struct WallPlan {
    /// Its name.
    pub name: String,
    /// What gave it.
    pub sources: Vec<Source>,
    /// Its form.
    pub form: WallForm,
    /// Its motion.
    pub motion: Option<Motion>,
    /// Times (s) from which and until which it exists.
    pub times: [f64; 2],
    /// Its law.
    pub law: WallLaw,
    /// Its temperature (K).
    pub temperature: Option<f64>,
}

/// The form of a template.
#[derive(Clone, Debug, PartialEq)]
pub enum Form {
    /// Sphere of a radius (m).
    Sphere(f64),
    /// Sphere of radii (m) equally likely between two.
    SphereRange([f64; 2]),
    /// Superellipsoid.
    Superquadric(Superquadric),
    /// Spheres with centres and radii (m).
    Spheres(Vec<([f64; 3], f64)>),
}

impl Form {
    /// Radius (m) of a sphere around it.
    pub fn bounding_radius(&self) -> f64 {
        match self {
            Self::Sphere(radius) | Self::SphereRange([_, radius]) => *radius,
            Self::Superquadric(shape) => {
                let round = shape.blockiness == [2.0; 2];
                let [a, b, c] = shape.semi_axes;
                if round { a.max(b).max(c) } else { (a * a + b * b + c * c).sqrt() }
            }
            Self::Spheres(spheres) => {
                let middle = middle(spheres);
                let reach = |(at, r): &([f64; 3], f64)| {
                    (0..3).map(|a| (at[a] - middle[a]).powi(2)).sum::<f64>().sqrt() + r
                };
                spheres.iter().map(reach).fold(0.0, f64::max)
            }
        }
    }

    /// Volume (m³); of spheres that overlap by counting points of a grid.
    pub fn volume(&self) -> f64 {
        let ball = |r: f64| 4.0 / 3.0 * PI * r.powi(3);
        match self {
            Self::Sphere(radius) => ball(*radius),
            Self::SphereRange([low, high]) => {
                // The mean of r³ over an even distribution of radii.
                let mean = (low + high) * (low * low + high * high) / 4.0;
                4.0 / 3.0 * PI * mean
            }
            Self::Superquadric(shape) => {
                shape.volume().unwrap_or_else(|| ball(1.0) * shape.semi_axes.iter().product::<f64>())
            }
            Self::Spheres(spheres) => volume_of_union(spheres),
        }
    }
}

fn middle(spheres: &[([f64; 3], f64)]) -> [f64; 3] {
    std::array::from_fn(|a| spheres.iter().map(|(at, _)| at[a]).sum::<f64>() / spheres.len().max(1) as f64)
}

fn volume_of_union(spheres: &[([f64; 3], f64)]) -> f64 {
    const CELLS: usize = 60;
    let ends = |sign: f64| {
        let end = |a: usize| spheres.iter().map(|(at, r)| sign * at[a] + r).fold(f64::MIN, f64::max) * sign;
        [end(0), end(1), end(2)]
    };
    let (lower, upper) = (ends(-1.0), ends(1.0));
    let edge: [f64; 3] = std::array::from_fn(|a| (upper[a] - lower[a]) / CELLS as f64);
    let is_inside = |point: [f64; 3]| {
        spheres.iter().any(|(at, r)| (0..3).map(|a| (point[a] - at[a]).powi(2)).sum::<f64>() < r * r)
    };
    let cells = 0..CELLS.pow(3);
    let count = cells.filter(|i| {
        let place = [i % CELLS, i / CELLS % CELLS, i / (CELLS * CELLS)];
        is_inside(std::array::from_fn(|a| lower[a] + (place[a] as f64 + 0.5) * edge[a]))
    });
    count.count() as f64 * edge.iter().product::<f64>()
}

/// A kind of particle.
#[derive(Clone, Debug, PartialEq)]
pub struct Template {
    /// Its name.
    pub name: String,
    /// Its type, from 1.
    pub kind: usize,
    /// Its density (kg/m³).
    pub density: f64,
    /// Its form.
    pub form: Form,
    /// What gave it.
    pub source: Source,
}

impl Template {
    /// The kind of particle, if there can be one.
    ///
    /// # Errors
    /// Sizes and densities that are not above 0.
    pub fn checked(self) -> Result<Self, String> {
        let density = Some(self.density);
        match &self.form {
            Form::Sphere(radius) => check_sizes([*radius], density),
            Form::SphereRange(radii) => check_sizes(*radii, density),
            Form::Superquadric(shape) => check_sizes(shape.semi_axes, density),
            Form::Spheres(spheres) => check_sizes(spheres.iter().map(|(_, radius)| *radius), density),
        }?;
        Ok(self)
    }

    /// Its expected mass (kg).
    pub fn mass(&self) -> f64 {
        self.density * self.form.volume()
    }
}

/// An insertion.
#[derive(Clone, Debug)]
pub struct InsertPlan {
    /// Its name.
    pub name: String,
    /// What gave it.
    pub source: Source,
    /// The kinds of particles and their shares by number.
    pub mixture: Vec<(Template, f64)>,
    /// Number of particles in all, if the script says one.
    pub limit: Option<u64>,
    /// Number in a batch.
    pub batch: u64,
    /// Time between batches (s); 0 for one batch.
    pub interval: f64,
    /// Time of the first batch (s).
    pub start: f64,
    /// Time at which it ends (s), if it does before the run.
    pub until: Option<f64>,
    /// Where.
    pub place: Place,
    /// Velocity (m/s).
    pub velocity: [f64; 3],
    /// Angular velocity (rad/s).
    pub angular_velocity: [f64; 3],
}

impl InsertPlan {
    /// Number of particles in all, in a run that ends at a time (s).
    pub fn count(&self, end: f64) -> u64 {
        let time = (self.until.unwrap_or(end) - self.start).max(0.0);
        let batches = match self.interval > 0.0 {
            // A hair less, so that a whole number of intervals is one.
            true => (time / self.interval - 1e-9).ceil().max(1.0) as u64,
            false => 1,
        };
        let possible = self.batch.saturating_mul(batches);
        self.limit.map_or(possible, |limit| limit.min(possible)).max(1)
    }
}

impl Scene {
    /// The time at which the script ends (s).
    pub fn end(&self) -> f64 {
        self.runs.iter().map(|(steps, dt)| *steps as f64 * dt).sum()
    }

    /// Whether an axis is periodic.
    pub fn periodic(&self) -> [bool; 3] {
        self.boundary.map(|ends| ends[0] == 'p')
    }
}
