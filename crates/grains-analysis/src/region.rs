//! The part of space an analysis looks at.

use super::snapshots::Snapshot;
use super::sums::exact_sum;
use grains_case::{Case, Motion, Side, WallKind};
use grains_domain::Transport;
use grains_geometry::{Shape, Vec3};
use grains_simulation::RunError;
use std::f64::consts::PI;
use std::fmt;
use std::str::FromStr;

/// Three numbers on the command line: `x,y,z`.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Triple(pub [f64; 3]);

impl FromStr for Triple {
    type Err = String;

    fn from_str(text: &str) -> Result<Self, String> {
        let numbers: Vec<f64> = text.split(',').filter_map(|word| word.trim().parse().ok()).collect();
        match (numbers[..].try_into(), text.split(',').count()) {
            (Ok(triple), 3) => Ok(Self(triple)),
            _ => Err(format!("`{text}` is not three numbers with commas between, such as 0,0,0.1")),
        }
    }
}

/// An axis of the domain.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
#[cfg_attr(feature = "clap", derive(clap::ValueEnum))]
pub enum Axis {
    /// The first.
    X,
    /// The second.
    Y,
    /// The third.
    Z,
}

/// What is left out at the lower and the upper end of a bed.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Crop([Length; 2]);

#[derive(Clone, Copy, Debug, PartialEq)]
enum Length {
    Layers(f64),
    Fraction(f64),
    Metres(f64),
}

impl Crop {
    /// Nothing.
    pub const NOTHING: Self = Self([Length::Metres(0.0); 2]);
    /// A tenth at either end.
    pub const TENTH: Self = Self([Length::Fraction(0.1); 2]);

    /// What is left out below and above (m) of a bed of a height of particles of a diameter (m).
    fn metres(self, height: f64, diameter: f64) -> [f64; 2] {
        self.0.map(|length| match length {
            Length::Layers(count) => count * diameter,
            Length::Fraction(part) => part * height,
            Length::Metres(metres) => metres,
        })
    }
}

impl FromStr for Crop {
    type Err = String;

    fn from_str(text: &str) -> Result<Self, String> {
        let length = |word: &str| {
            let word = word.trim();
            let number = |text: &str| text.parse().ok().filter(|x| (0.0..f64::INFINITY).contains(x));
            if let Some(percent) = word.strip_suffix('%') {
                return number(percent).map(|p| Length::Fraction(0.01 * p));
            }
            match word.strip_suffix('m') {
                Some(metres) => number(metres).map(Length::Metres),
                None => number(word).map(Length::Layers),
            }
        };
        let (below, above) = text.split_once(',').unwrap_or((text, text));
        match (length(below), length(above)) {
            (Some(below), Some(above)) => Ok(Self([below, above])),
            _ => Err(format!(
                "`{text}` is no amount to crop: give layers (3), a part (10%) or a length (0.005m), or two with a comma between for bottom and top"
            )),
        }
    }
}

/// Options that choose the part of space.
#[derive(Clone, Debug, Default)]
#[cfg_attr(feature = "clap", derive(clap::Args))]
pub struct RegionOptions {
    /// Lower corner of the region (m): x,y,z; that of the container if absent.
    #[cfg_attr(feature = "clap", arg(long, value_name = "X,Y,Z", allow_hyphen_values = true))]
    pub lower: Option<Triple>,
    /// Upper corner of the region (m): x,y,z.
    #[cfg_attr(feature = "clap", arg(long, value_name = "X,Y,Z", allow_hyphen_values = true))]
    pub upper: Option<Triple>,
    /// Cylinder along the axis instead of a box (m): the two coordinates of its centre, and its radius.
    #[cfg_attr(feature = "clap", arg(long, value_name = "CX,CY,R", allow_hyphen_values = true))]
    pub cylinder: Option<Triple>,
    /// Axis of profiles and cylinders; that of gravity if absent.
    #[cfg_attr(feature = "clap", arg(long))]
    pub axis: Option<Axis>,
    /// What to leave out at the bottom and top of the bed: layers (3), a part (10%) or a length (0.005m), or
    /// one for either with a comma between.
    #[cfg_attr(feature = "clap", arg(long))]
    pub crop: Option<Crop>,
}

impl RegionOptions {
    /// Whether nothing limits the region.
    pub fn is_empty(&self) -> bool {
        self.lower.is_none() && self.upper.is_none() && self.cylinder.is_none() && self.crop.is_none()
    }
}

/// A box, or a cylinder along an axis.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Region {
    /// Lower corner (m).
    pub lower: Vec3,
    /// Upper corner (m).
    pub upper: Vec3,
    /// Axis of profiles and of the cylinder: 0, 1 or 2.
    pub axis: usize,
    /// Centre across the axis, in the order of [`across`], and radius (m) of the cylinder.
    pub cylinder: Option<([f64; 2], f64)>,
}

/// The two axes across one, in rising order.
pub fn across(axis: usize) -> [usize; 2] {
    [[1, 2], [0, 2], [0, 1]][axis]
}

impl Region {
    /// Whether a point (m) lies inside: lower faces count, upper ones do not.
    pub fn contains(&self, point: &Vec3) -> bool {
        (0..3).all(|a| self.lower[a] <= point[a] && point[a] < self.upper[a])
            && self.cylinder.is_none_or(|(_, radius)| self.distance(point) <= radius)
    }

    /// Distance of a point from the axis of the cylinder, or from the middle of the box (m).
    pub fn distance(&self, point: &Vec3) -> f64 {
        let ([a, b], middle) = (across(self.axis), self.middle());
        (point[a] - middle[0]).hypot(point[b] - middle[1])
    }

    /// Centre across the axis (m).
    pub fn middle(&self) -> [f64; 2] {
        match self.cylinder {
            Some((center, _)) => center,
            None => across(self.axis).map(|a| 0.5 * (self.lower[a] + self.upper[a])),
        }
    }

    /// Area across the axis (m²).
    pub fn cross_section(&self) -> f64 {
        match self.cylinder {
            Some((_, radius)) => PI * radius * radius,
            None => across(self.axis).map(|a| self.upper[a] - self.lower[a]).iter().product(),
        }
    }

    /// Length along the axis (m).
    pub fn height(&self) -> f64 {
        self.upper[self.axis] - self.lower[self.axis]
    }

    /// The region an analysis looks at: the container of the case, or what the options say.
    ///
    /// # Errors
    /// An option that does not fit the domain.
    pub fn chosen(case: &Case, time: f64, options: &RegionOptions) -> Result<Self, RunError> {
        let axis = options.axis.map_or_else(|| vertical(case), |axis| axis as usize);
        let mut region = container(case, time, axis);
        if let Some(Triple([x, y, radius])) = options.cylinder {
            if !(radius > 0.0 && radius.is_finite() && x.is_finite() && y.is_finite()) {
                return Err(RunError::case(format!("--cylinder: the radius {radius} must be positive")));
            }
            region.cylinder = Some(([x, y], radius));
        }
        let explicit = options.lower.is_some() || options.upper.is_some();
        if explicit && options.cylinder.is_none() {
            region.cylinder = None;
        }
        for (given, corner) in [(options.lower, &mut region.lower), (options.upper, &mut region.upper)] {
            if let Some(Triple(given)) = given {
                *corner = Vec3::from(given);
            }
        }
        if let Some((center, radius)) = region.cylinder {
            for (k, a) in across(axis).into_iter().enumerate() {
                (region.lower[a], region.upper[a]) = (center[k] - radius, center[k] + radius);
            }
        }
        region.check(case)?;
        Ok(region)
    }

    /// The region of a state: what the options say, cut to the bed in it if they crop.
    ///
    /// # Errors
    /// Options that do not fit the domain or the bed.
    pub fn of_state(
        case: &Case,
        (snapshot, shapes): (&Snapshot, &[Shape]),
        options: &RegionOptions,
        transport: &impl Transport,
    ) -> Result<Self, RunError> {
        let region = Self::chosen(case, snapshot.time, options)?;
        match options.crop {
            Some(crop) => region.cropped(snapshot, shapes, crop, transport),
            None => Ok(region),
        }
    }

    fn check(&self, case: &Case) -> Result<(), RunError> {
        let slack = case.domain.extents().map(|extent| 1e-9 * extent);
        for a in 0..3 {
            let (name, lower, upper) = (["x", "y", "z"][a], self.lower[a], self.upper[a]);
            if lower.is_nan() || upper.is_nan() || lower >= upper {
                return Err(RunError::case(format!(
                    "--lower, --upper: the region from {lower} to {upper} m along {name} is empty; let the upper corner be above the lower one"
                )));
            }
            let (first, last) = (case.domain.lower[a], case.domain.upper[a]);
            let is_round = self.cylinder.is_some() && a != self.axis;
            // A cylinder may reach beyond: there is nothing there, and it is part of the tube.
            let is_beyond = lower < first - slack[a] || upper > last + slack[a];
            if is_beyond && (!is_round || case.domain.periodic[a]) {
                return Err(RunError::case(format!(
                    "--lower, --upper, --cylinder: the region from {lower} to {upper} m along {name} leaves the domain, which is from {first} to {last} m; make it smaller"
                )));
            }
        }
        Ok(())
    }

    /// The region cut along its axis to the bed in it, from the lowest to the highest surface of a particle
    /// whose centre lies inside, and cropped; as it is where there are no particles.
    ///
    /// # Errors
    /// A crop that leaves nothing.
    pub fn cropped(
        mut self,
        snapshot: &Snapshot,
        shapes: &[Shape],
        crop: Crop,
        transport: &impl Transport,
    ) -> Result<Self, RunError> {
        let axis = self.axis;
        let inside = || (0..snapshot.len()).filter(|&i| self.contains(&snapshot.position[i]));
        let mut ends = [f64::NEG_INFINITY; 2];
        for i in inside() {
            let (x, reach) = (snapshot.position[i][axis], snapshot.reach(i, axis, shapes));
            ends = [ends[0].max(reach[0] - x), ends[1].max(x + reach[1])];
        }
        transport.max(&mut ends);
        let [lowest, highest] = [(-ends[0]).max(self.lower[axis]), ends[1].min(self.upper[axis])];
        if lowest < highest {
            let diameter = mean_diameter(snapshot, shapes, inside(), transport);
            let cut = crop.metres(highest - lowest, diameter);
            let [lower, upper] = [lowest + cut[0], highest - cut[1]];
            if lower >= upper {
                return Err(RunError::case(format!(
                    "--crop: nothing is left of a bed {} m high after {} m below and {} m above; crop less",
                    highest - lowest,
                    cut[0],
                    cut[1]
                )));
            }
            (self.lower[axis], self.upper[axis]) = (lower, upper);
        }
        Ok(self)
    }

    /// The region as the user gave it; else, along the vertical, cut to the bed and cropped.
    ///
    /// # Errors
    /// Options that do not fit the domain or the bed.
    pub fn of_bed(
        case: &Case,
        shapes: &[Shape],
        snapshot: &Snapshot,
        (options, crop): (&RegionOptions, Crop),
        transport: &impl Transport,
    ) -> Result<Self, RunError> {
        let region = Self::chosen(case, snapshot.time, options)?;
        let is_given = options.lower.is_some() || options.upper.is_some();
        match options.crop {
            None if is_given || region.axis != vertical(case) => Ok(region),
            given => region.cropped(snapshot, shapes, given.unwrap_or(crop), transport),
        }
    }
}

impl fmt::Display for Region {
    fn fmt(&self, f: &mut fmt::Formatter) -> fmt::Result {
        let name = |a: usize| ["x", "y", "z"][a];
        if let Some((center, radius)) = self.cylinder {
            let ([a, b], axis) = (across(self.axis), self.axis);
            let [p, q] = center;
            let (lower, upper) = (self.lower[axis], self.upper[axis]);
            return write!(
                f,
                "cylinder of radius {radius:.6} m about {} = {p:.6}, {} = {q:.6} m, {} from {lower:.6} to {upper:.6} m",
                name(a),
                name(b),
                name(axis)
            );
        }
        let (l, u) = (self.lower, self.upper);
        write!(f, "box from ({:.6}, {:.6}, {:.6}) to ({:.6}, {:.6}, {:.6}) m", l.x, l.y, l.z, u.x, u.y, u.z)
    }
}

/// Diameter of the sphere of the mean volume of some particles of every rank (m); NaN without particles.
pub fn mean_diameter(
    snapshot: &Snapshot,
    shapes: &[Shape],
    which: impl Iterator<Item = usize> + Clone,
    transport: &impl Transport,
) -> f64 {
    let mut count = [which.clone().count() as u64];
    transport.sum_counts(&mut count);
    let volume = exact_sum(transport, which.map(|i| snapshot.volume(i, shapes)));
    grains_geometry::sphere_equivalent_diameter(volume / count[0] as f64)
}

/// The axis along which gravity acts most, z without gravity.
pub fn vertical(case: &Case) -> usize {
    let g = case.gravity.map(f64::abs);
    if g == [0.0; 3] {
        return 2;
    }
    (0..3).rev().max_by(|&a, &b| g[a].total_cmp(&g[b])).unwrap_or(2)
}

/// The domain, narrowed to what flat walls along the axes, boxes and a cylinder along `axis` enclose at a
/// time (s); walls that travel do not count.
pub fn container(case: &Case, time: f64, axis: usize) -> Region {
    let domain = &case.domain;
    let (lower, upper) = (Vec3::from(domain.lower), Vec3::from(domain.upper));
    let mut region = Region { lower, upper, axis, cylinder: None };
    let is_along = |n: &[f64; 3], a: usize| n[a].abs() > 1.0 - 1e-9;
    for wall in case.walls.iter().filter(|w| w.from <= time && time < w.until) {
        // A surface of revolution that turns about its own axis stays what it is.
        let turns = match &wall.motion {
            None => None,
            Some(Motion::Rotation { axis, .. }) => Some(axis),
            Some(_) => continue,
        };
        let stays = |a: usize| turns.is_none_or(|turn| is_along(turn, a));
        match &wall.kind {
            WallKind::Plane { point, normal } => {
                for a in (0..3).filter(|&a| is_along(normal, a) && stays(a)) {
                    if normal[a] > 0.0 {
                        region.lower[a] = region.lower[a].max(point[a]);
                    } else {
                        region.upper[a] = region.upper[a].min(point[a]);
                    }
                }
            }
            WallKind::Box { lower, upper, side: Side::Inside } if turns.is_none() => {
                region.lower = region.lower.sup(&Vec3::from(*lower));
                region.upper = region.upper.inf(&Vec3::from(*upper));
            }
            WallKind::Cylinder { center, axis: along, radius, height, side: Side::Inside, caps }
                if is_along(along, axis) && stays(axis) =>
            {
                region.cylinder = Some((across(axis).map(|a| center[a]), *radius));
                if *caps {
                    region.lower[axis] = region.lower[axis].max(center[axis] - 0.5 * height);
                    region.upper[axis] = region.upper[axis].min(center[axis] + 0.5 * height);
                }
            }
            _ => {}
        }
    }
    region
}
