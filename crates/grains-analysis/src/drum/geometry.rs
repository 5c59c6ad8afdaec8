//! Where the drum is and how it turns.

use super::super::region::Triple;
use grains_case::{Case, Motion, Side, Wall, WallKind};
use grains_geometry::Vec3;
use grains_simulation::RunError;

/// Options that say where the drum is; what is absent comes from the rotating wall of the case.
#[derive(Clone, Debug, Default)]
#[cfg_attr(feature = "clap", derive(clap::Args))]
pub struct DrumOptions {
    /// The rotating wall, if the case has several.
    #[cfg_attr(feature = "clap", arg(long, value_name = "NAME"))]
    pub wall: Option<String>,
    /// A point of the drum's axis (m).
    #[cfg_attr(feature = "clap", arg(long, value_name = "X,Y,Z", allow_hyphen_values = true))]
    pub center: Option<Triple>,
    /// Direction of the axis.
    #[cfg_attr(feature = "clap", arg(long, value_name = "X,Y,Z", allow_hyphen_values = true))]
    pub axis: Option<Triple>,
    /// Inner radius of the drum (m).
    #[cfg_attr(feature = "clap", arg(long, value_name = "M"))]
    pub radius: Option<f64>,
    /// Angular velocity about the axis (rad/s).
    #[cfg_attr(feature = "clap", arg(long, value_name = "RAD/S", allow_hyphen_values = true))]
    pub omega: Option<f64>,
}

/// A drum that turns about an axis across gravity.
#[derive(Clone, Copy, Debug)]
pub struct Drum {
    /// A point of the axis (m).
    pub center: Vec3,
    /// Direction of the axis (-).
    pub axis: Vec3,
    /// Inner radius (m).
    pub radius: f64,
    /// Angular velocity about the axis (rad/s).
    pub rate: f64,
    /// Times (s) between which it turns.
    pub interval: (f64, f64),
    /// Direction against gravity, across the axis (-).
    pub up: Vec3,
    /// Direction in which the lowest point of the drum moves (-).
    pub forward: Vec3,
    /// Gravity across the axis (m/s²).
    pub gravity: f64,
}

impl Drum {
    /// A drum about an axis through a point.
    ///
    /// # Errors
    /// Numbers that make no drum.
    pub fn new(center: Vec3, axis: Vec3, radius: f64, rate: f64, gravity: Vec3) -> Result<Self, RunError> {
        let refuse = |what: &str| Err(RunError::case(what));
        let Some(axis) = axis.try_normalize(0.0) else { return refuse("--axis: must not be zero") };
        if !(radius > 0.0 && radius.is_finite()) {
            return Err(RunError::case(format!("--radius: is {radius}; it must be positive")));
        }
        if !(rate != 0.0 && rate.is_finite()) {
            return Err(RunError::case(format!("--omega: is {rate} rad/s; the drum must turn")));
        }
        let across = gravity - axis * gravity.dot(&axis);
        if across.norm() <= 1e-9 * gravity.norm() {
            return refuse("--axis: gravity is zero or along the axis; the axis of a drum lies across it");
        }
        let up = -across.normalize();
        let forward = (axis * rate).cross(&-up).normalize();
        let interval = (0.0, f64::INFINITY);
        Ok(Self { center, axis, radius, rate, interval, up, forward, gravity: across.norm() })
    }

    /// The drum of a case, or what the options say.
    ///
    /// # Errors
    /// A drum that can neither be found in the case nor is given.
    pub fn chosen(case: &Case, options: &DrumOptions) -> Result<Self, RunError> {
        let wall = rotating_wall(case, options)?;
        let motion = wall.and_then(|w| match &w.motion {
            Some(Motion::Rotation { point, axis, angular_velocity, .. }) => {
                Some((*point, *axis, *angular_velocity))
            }
            _ => None,
        });
        let radius_of = |w: &Wall| match &w.kind {
            WallKind::Cylinder { radius, .. } => Some(*radius),
            _ => None,
        };
        let triple = |given: Option<Triple>| given.map(|Triple(t)| t);
        let needed = |value: Option<[f64; 3]>, key: &str| value.ok_or_else(|| missing(key));
        let center = needed(triple(options.center).or(motion.and_then(|m| m.0)), "center")?;
        let axis = needed(triple(options.axis).or(motion.map(|m| m.1)), "axis")?;
        let rate = options.omega.or(motion.map(|m| m.2)).ok_or_else(|| missing("omega"))?;
        let radius = options.radius.or(wall.and_then(radius_of)).ok_or_else(|| missing("radius"))?;
        let drum = Self::new(Vec3::from(center), Vec3::from(axis), radius, rate, Vec3::from(case.gravity))?;
        let given = wall.and_then(|w| w.motion.as_ref()).filter(|_| options.omega.is_none());
        Ok(Self { interval: given.map_or(drum.interval, Motion::interval), ..drum })
    }

    /// Angle (rad) through which it has turned at a time (s).
    pub fn turned(&self, time: f64) -> f64 {
        let (start, end) = self.interval;
        (time.min(end) - start).max(0.0) * self.rate.abs()
    }

    /// Froude number Ω² R / g (-).
    pub fn froude(&self) -> f64 {
        self.rate * self.rate * self.radius / self.gravity
    }

    /// Place in the cross-section (m): forward and up from the axis.
    pub fn place(&self, point: &Vec3) -> [f64; 2] {
        let from_axis = point - self.center;
        [from_axis.dot(&self.forward), from_axis.dot(&self.up)]
    }

    /// Velocity Ω × r of a point that moves with the drum (m/s).
    pub fn velocity_at(&self, point: &Vec3) -> Vec3 {
        (self.axis * self.rate).cross(&(point - self.center))
    }
}

fn missing(key: &str) -> RunError {
    RunError::case(format!("--{key}: the case has no rotating wall that tells it; give it"))
}

/// The wall the options name, else the only rotating cylinder, else the only rotating wall.
fn rotating_wall<'a>(case: &'a Case, options: &DrumOptions) -> Result<Option<&'a Wall>, RunError> {
    let turns = |wall: &&Wall| matches!(wall.motion, Some(Motion::Rotation { .. }));
    let is_drum = |wall: &&Wall| matches!(wall.kind, WallKind::Cylinder { side: Side::Inside, .. });
    let rotating: Vec<&Wall> = case.walls.iter().filter(turns).collect();
    if let Some(name) = &options.wall {
        let names = rotating.iter().map(|w| w.name.as_str()).collect::<Vec<_>>().join(", ");
        let found = rotating.iter().find(|w| w.name == *name);
        let message =
            format!("--wall {name}: the case has no such rotating wall; those that rotate: {names}");
        return found.map(|w| Some(*w)).ok_or_else(|| RunError::case(message));
    }
    let cylinders: Vec<&Wall> = rotating.iter().copied().filter(is_drum).collect();
    let candidates = if cylinders.is_empty() { rotating } else { cylinders };
    match candidates[..] {
        [] => Ok(None),
        [wall] => Ok(Some(wall)),
        _ => {
            let names = candidates.iter().map(|w| w.name.as_str()).collect::<Vec<_>>().join(", ");
            Err(RunError::case(format!("--wall: several walls rotate ({names}); name the drum")))
        }
    }
}
