//! `[[insert]]`: particles, at the start or during the run.

use schemars::JsonSchema;
use serde::{Deserialize, Serialize};

use crate::check::{Checker, Names};
use crate::diagnostic::rounded;
use crate::sections::motion::ParticleMotion;
use crate::sections::place::{MOST_PLACES, Place, default_spacing, lattice_sites};
use crate::sections::shape::{Shape, ShapeKind};
use crate::sections::size_distribution::SizeDistribution;
use crate::sections::{domain::Domain, material::Material};
use crate::vector::norm;

/// One kind of particle in a mixture.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize, JsonSchema)]
#[serde(deny_unknown_fields)]
#[schemars(rename = "Component")]
pub struct Component<Name = usize> {
    /// Shape of the particles.
    pub shape: Name,
    /// Material of the particles; it needs a density.
    pub material: Name,
    /// Share by number in the mixture (-); shares need not sum to 1.
    #[serde(default = "super::one")]
    #[schemars(extend("exclusiveMinimum" = 0))]
    pub share: f64,
    /// Size distribution: the factor on all lengths of the shape (-).
    #[serde(default)]
    pub scale: SizeDistribution,
    /// Size distribution of spheres instead: their diameters (m), whatever the radius of the shape is.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub diameter: Option<SizeDistribution>,
}

/// How inserted particles are turned.
#[derive(Clone, Copy, Debug, PartialEq, Serialize, Deserialize, JsonSchema)]
#[serde(rename_all = "snake_case")]
pub enum Orientation {
    /// All orientations equally likely.
    Random,
    /// Body axes along the axes of the domain.
    Aligned,
    /// Quaternion (w, x, y, z), body to world (-).
    #[serde(untagged)]
    Quaternion([f64; 4]),
}

/// Particles inserted in one or several batches.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize, JsonSchema)]
#[serde(deny_unknown_fields)]
#[schemars(rename = "Insert")]
pub struct Insert<Name = usize> {
    /// Name of the group, for messages and output.
    pub name: String,
    /// The mixture: one entry per kind of particle.
    #[schemars(length(min = 1))]
    pub particles: Vec<Component<Name>>,
    /// Number of particles in all (-); may be left out for a file, of which all rows are then taken.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    #[schemars(extend("minimum" = 1, "maximum" = 1_000_000_000_000_u64))]
    pub count: Option<u64>,
    /// Where the particles appear.
    pub place: Place,
    /// "random", "aligned", or a quaternion [w, x, y, z] (-), body to world. By default random, and aligned where a
    /// file gives the places but no quaternions.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub orientation: Option<Orientation>,
    /// "free", "fixed" (they stay where they are inserted), or a prescribed motion as of walls, which begins where they are
    /// inserted; by default fluid.resolved.motion, else "free".
    #[serde(default, skip_serializing_if = "is_free")]
    pub motion: Option<ParticleMotion>,
    /// Initial velocity (m/s).
    #[serde(default)]
    pub velocity: [f64; 3],
    /// Initial angular velocity (rad/s).
    #[serde(default)]
    pub angular_velocity: [f64; 3],
    /// Temperature (K); heat.temperature if absent.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    #[schemars(extend("minimum" = 0, "x-plausible" = [2, 4000]))]
    pub temperature: Option<f64>,
    /// Time of the first batch (s).
    #[serde(default)]
    #[schemars(extend("minimum" = 0))]
    pub start: f64,
    /// Time between batches (s).
    #[serde(default)]
    #[schemars(extend("minimum" = 0))]
    pub interval: f64,
    /// Number of particles per batch (-), by default all of them.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    #[schemars(extend("minimum" = 1))]
    pub batch: Option<u64>,
}

/// Whether particles move by the forces on them, which needs no word.
fn is_free(motion: &Option<ParticleMotion>) -> bool {
    !motion.as_ref().is_some_and(ParticleMotion::is_prescribed)
}

/// What an insertion is checked against.
pub(crate) struct Context<'a> {
    pub domain: &'a Domain,
    pub materials: &'a [Material],
    pub shapes: &'a [Shape],
    pub names: &'a Names,
    pub end: f64,
    /// What particles do whose insertion does not say.
    pub motion: ParticleMotion,
}

impl<Name> Insert<Name> {
    /// The same insertion with shapes and materials named otherwise.
    ///
    /// `name` receives the index of the component, the key and the old name.
    pub(crate) fn rename<Other>(self, mut name: impl FnMut(usize, &str, Name) -> Other) -> Insert<Other> {
        let particles = self.particles.into_iter().enumerate().map(|(i, component)| Component {
            shape: name(i, "shape", component.shape),
            material: name(i, "material", component.material),
            share: component.share,
            scale: component.scale,
            diameter: component.diameter,
        });
        Insert {
            particles: particles.collect(),
            name: self.name,
            count: self.count,
            place: self.place,
            orientation: self.orientation,
            motion: self.motion,
            velocity: self.velocity,
            angular_velocity: self.angular_velocity,
            temperature: self.temperature,
            start: self.start,
            interval: self.interval,
            batch: self.batch,
        }
    }
}

/// Resolves names, fills in defaults and checks the insertions.
pub(crate) fn check(raw: Vec<Insert<String>>, context: &Context<'_>, checker: &mut Checker) -> Vec<Insert> {
    let inserts = raw.into_iter().enumerate();
    inserts.map(|(i, insert)| check_one(insert, &format!("insert[{i}]"), context, checker)).collect()
}

/// Largest speed (m/s) of particles that are inserted: ten times that of what falls from space.
const FASTEST: f64 = 1e5;
/// Largest angular speed (rad/s) of particles that are inserted: that of 1e5 m/s at a radius of 0.1 µm.
const FASTEST_TURN: f64 = 1e12;

/// Plausible diameters (m), as of radii.
const USUAL: [f64; 2] = [2e-7, 1.0];

fn check_one(raw: Insert<String>, path: &str, context: &Context<'_>, checker: &mut Checker) -> Insert {
    let errors_before = checker.error_count();
    let mut insert = raw.rename(|i, key, name| {
        let known = if key == "shape" { &context.names.shapes } else { &context.names.materials };
        checker.reference(&format!("{path}.particles[{i}].{key}"), &name, key, known)
    });
    let is_resolved = checker.error_count() == errors_before;
    for (i, component) in insert.particles.iter_mut().enumerate() {
        let path = format!("{path}.particles[{i}]");
        component.check_sizes(&path, is_resolved.then(|| &context.shapes[component.shape].kind), checker);
        if is_resolved && context.materials[component.material].density.is_none() {
            let material = &context.names.materials[component.material];
            checker.error(
                &format!("{path}.material"),
                format!("`{material}` has no density; add density (kg/m³) to that [[material]]"),
            );
        }
    }
    insert.place.check(&format!("{path}.place"), context.domain, checker);
    let usual = if insert.place.extents().is_some() { Orientation::Random } else { Orientation::Aligned };
    if let Orientation::Quaternion(q) = insert.orientation.get_or_insert(usual) {
        *q = checker.direction(&format!("{path}.orientation"), *q);
    }
    if norm(insert.velocity) > FASTEST {
        let message = format!(
            "{:e} m/s, but no grain is faster than {FASTEST:e} m/s; is the unit right?",
            norm(insert.velocity)
        );
        checker.error(&format!("{path}.velocity"), message);
    }
    if norm(insert.angular_velocity) > FASTEST_TURN {
        let message = format!(
            "{:e} rad/s, but no grain turns faster than {FASTEST_TURN:e} rad/s; is the unit right?",
            norm(insert.angular_velocity)
        );
        checker.error(&format!("{path}.angular_velocity"), message);
    }
    insert.check_motion(path, &context.motion, checker);
    insert.check_batches(path, checker);
    insert.check_times(path, context.end, checker);
    insert
}

impl Component {
    /// Checks the distribution of its sizes; one of diameters becomes one of factors on the shape, if that is known.
    fn check_sizes(&mut self, path: &str, shape: Option<&ShapeKind>, checker: &mut Checker) {
        let Some(mut diameter) = self.diameter.take() else {
            return self.scale.check(&format!("{path}.scale"), checker);
        };
        let path = format!("{path}.diameter");
        if self.scale != SizeDistribution::default() {
            checker.error(&path, "excludes scale; remove one of them".into());
        }
        let errors = checker.error_count();
        diameter.check(&path, checker);
        match shape {
            Some(ShapeKind::Sphere { radius }) => {
                let [smallest, largest] = [diameter.smallest(), diameter.largest()];
                if checker.error_count() == errors && !(USUAL[0] <= smallest && largest <= USUAL[1]) {
                    let [smallest, largest] = [smallest, largest].map(rounded);
                    let message = format!(
                        "from {smallest} to {largest} m, unusual, mostly between {:?} and {:?}: check its unit",
                        USUAL[0], USUAL[1]
                    );
                    checker.warn(&path, message);
                }
                self.scale = diameter.in_units_of(2.0 * radius);
            }
            Some(_) => {
                let message =
                    "only spheres have a diameter; give scale, the factor on all lengths of the shape";
                checker.error(&path, message.into());
            }
            None => {}
        }
    }
}

impl Insert {
    /// Whether the motion of its particles is prescribed.
    pub fn is_prescribed(&self) -> bool {
        self.motion.as_ref().is_some_and(ParticleMotion::is_prescribed)
    }

    /// Whether its particles stay where they are inserted.
    pub fn is_fixed(&self) -> bool {
        self.motion == Some(ParticleMotion::Fixed)
    }

    /// The motion, and velocities that it makes meaningless.
    fn check_motion(&mut self, path: &str, usual: &ParticleMotion, checker: &mut Checker) {
        let is_given = self.motion.is_some();
        let motion = self.motion.get_or_insert_with(|| usual.clone());
        if let ParticleMotion::Prescribed(motion) = motion {
            motion.check(&format!("{path}.motion"), checker);
            motion.check_of_particles(&format!("{path}.motion"), checker);
        }
        if !(is_given && motion.is_prescribed()) {
            return;
        }
        for (key, value) in [("velocity", self.velocity), ("angular_velocity", self.angular_velocity)] {
            if value != [0.0; 3] {
                let message = "without effect: the motion of these particles is prescribed; remove it, or take motion = \"free\"";
                checker.warn(&format!("{path}.{key}"), message.into());
            }
        }
    }

    /// Count and batches.
    fn check_batches(&mut self, path: &str, checker: &mut Checker) {
        if self.count.is_none() && !matches!(self.place, Place::File { .. }) {
            checker.error(
                &format!("{path}.count"),
                "missing key; give the number of particles (only a file brings its own)".into(),
            );
        }
        self.batch = self.batch.or(self.count);
        let Some(batch) = self.batch else { return };
        match self.count {
            Some(count) if batch > count => checker.error(
                &format!("{path}.batch"),
                format!("more than count = {count}; lower it or leave it out"),
            ),
            Some(count) if batch == count => {}
            _ if self.interval == 0.0 => checker.error(
                &format!("{path}.interval"),
                "must be above 0 when particles come in several batches; give the time between them (s)"
                    .into(),
            ),
            _ => {}
        }
    }

    /// Warns of particles whose time never comes.
    fn check_times(&self, path: &str, end: f64, checker: &mut Checker) {
        if self.start > end {
            let message = format!("after the end of the run ({end} s): these particles never appear");
            checker.warn(&format!("{path}.start"), message);
        } else if let (Some(count), Some(batch)) = (self.count, self.batch) {
            let last = self.start + self.interval * (count.div_ceil(batch) - 1) as f64;
            if last > end {
                let last = rounded(last);
                let message =
                    format!("the last batch would come at {last} s, after the end of the run ({end} s)");
                checker.warn(&format!("{path}.interval"), message);
            }
        }
    }

    /// Fills in the spacing of a lattice and checks that the particles fit.
    pub(crate) fn check_lattice(&mut self, path: &str, shapes: &[Shape], checker: &mut Checker) {
        let batch = self.batch.unwrap_or(1);
        let largest = self.largest_radius(shapes);
        let smallest = self.smallest_inscribed(shapes);
        let Place::Lattice { lower, upper, spacing, noise } = &mut self.place else { return };
        if spacing.is_none() {
            *spacing = largest.map(|radius| default_spacing(radius, *noise));
        }
        let Some(spacing) = *spacing else { return };
        let longest = (0..3).map(|a| upper[a] - lower[a]).fold(0.0, f64::max);
        if longest / spacing > MOST_PLACES {
            let message = format!(
                "{:.3e} places along {} m, more than {MOST_PLACES}; raise the spacing or shorten the region",
                longest / spacing,
                rounded(longest)
            );
            return checker.error(&format!("{path}.place.spacing"), message);
        }
        let [x, y, z] = lattice_sites(*lower, *upper, spacing);
        if x.saturating_mul(y).saturating_mul(z) < batch {
            checker.error(
                &format!("{path}.place"),
                format!(
                    "room for {x} x {y} x {z} particles at a spacing of {} m, but {batch} are wanted \
                     at once; enlarge the region, lower the spacing or insert in batches",
                    rounded(spacing)
                ),
            );
        }
        let key = format!("{path}.place.spacing");
        if batch > 1 && spacing < 2.0 * smallest {
            checker.error(
                &key,
                format!("neighbours would overlap: even the smallest needs {} m", rounded(2.0 * smallest)),
            );
        } else if let Some(radius) = largest
            && batch > 1
            && spacing * (1.0 - 2.0 * *noise) < 2.0 * radius
        {
            let safe = rounded(default_spacing(radius, *noise));
            checker.warn(&key, format!("neighbours may overlap when turned or displaced; {safe} m is safe"));
        }
    }

    /// Largest bounding radius in the mixture (m), if closed forms give all of them.
    fn largest_radius(&self, shapes: &[Shape]) -> Option<f64> {
        self.particles.iter().try_fold(0.0_f64, |largest, component| {
            let radius = shapes[component.shape].bounding_radius()?;
            Some(largest.max(radius * component.scale.largest()))
        })
    }

    /// Smallest inscribed radius in the mixture (m); 0 if it is unknown.
    fn smallest_inscribed(&self, shapes: &[Shape]) -> f64 {
        let radius = |c: &Component| shapes[c.shape].inscribed_radius().unwrap_or(0.0) * c.scale.smallest();
        self.particles.iter().map(radius).fold(f64::INFINITY, f64::min)
    }
}
