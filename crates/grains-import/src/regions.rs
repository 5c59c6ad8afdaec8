//! Regions of a script: where particles are inserted, and walls of `wall/gran/region`.

use grains_case::{Side, WallKind, Window};
use std::f64::consts::PI;

/// A region, in SI units.
#[derive(Clone, Debug, PartialEq)]
pub struct Region {
    /// Its form.
    pub form: RegionForm,
    /// Whether the inside counts.
    pub is_inside: bool,
    /// Faces that a wall does not have, from 1.
    pub open: Vec<usize>,
    /// Whether it moves.
    pub moves: bool,
}

/// The form of a region.
#[derive(Clone, Debug, PartialEq)]
pub enum RegionForm {
    /// Box between two corners (m).
    Block {
        /// Lower corner.
        lower: [f64; 3],
        /// Upper corner.
        upper: [f64; 3],
    },
    /// Cylinder, or cone, along an axis.
    Cone {
        /// Axis of the domain, 0 to 2.
        axis: usize,
        /// Place of the axis (m), with any number along it.
        center: [f64; 3],
        /// Radii at both ends (m).
        radii: [f64; 2],
        /// Ends along the axis (m).
        ends: [f64; 2],
    },
    /// Sphere.
    Sphere {
        /// Centre (m).
        center: [f64; 3],
        /// Radius (m).
        radius: f64,
    },
    /// Half space in front of a plane.
    Plane {
        /// A point (m).
        point: [f64; 3],
        /// Normal into the region.
        normal: [f64; 3],
    },
}

impl Region {
    /// Reads the words from the style on; `number` gives numbers as they are, `infinite` the borders for INF and EDGE.
    ///
    /// # Errors
    /// Styles without a counterpart and numbers that are missing.
    pub fn parse(
        words: &[String],
        length: impl Fn(&str) -> Result<f64, String>,
        plain: impl Fn(&str) -> Result<f64, String>,
        domain: [[f64; 3]; 2],
    ) -> Result<Self, String> {
        let style = words.first().ok_or("the style is missing")?.as_str();
        let word = |k: usize| {
            words.get(k).map(String::as_str).ok_or_else(|| format!("region {style} takes more numbers"))
        };
        let end = |k: usize, axis: usize, side: usize| match word(k)? {
            "INF" | "EDGE" => Ok(domain[side][axis]),
            other => length(other),
        };
        let (form, used) = match style {
            "block" => {
                let mut corners = [[0.0; 3]; 2];
                for axis in 0..3 {
                    for (side, corner) in corners.iter_mut().enumerate() {
                        corner[axis] = end(1 + 2 * axis + side, axis, side)?;
                    }
                }
                (RegionForm::Block { lower: corners[0], upper: corners[1] }, 7)
            }
            "cylinder" | "cone" => {
                let axis = ["x", "y", "z"].iter().position(|a| *a == word(1).unwrap_or_default());
                let axis = axis.ok_or("the axis must be x, y or z")?;
                let mut center = [0.0; 3];
                let across: Vec<usize> = (0..3).filter(|a| *a != axis).collect();
                center[across[0]] = length(word(2)?)?;
                center[across[1]] = length(word(3)?)?;
                let (radii, at) = match style {
                    "cone" => ([length(word(4)?)?, length(word(5)?)?], 6),
                    _ => ([length(word(4)?)?; 2], 5),
                };
                let ends = [end(at, axis, 0)?, end(at + 1, axis, 1)?];
                (RegionForm::Cone { axis, center, radii, ends }, at + 2)
            }
            "sphere" => {
                let center = [length(word(1)?)?, length(word(2)?)?, length(word(3)?)?];
                (RegionForm::Sphere { center, radius: length(word(4)?)? }, 5)
            }
            "plane" => {
                let point = [length(word(1)?)?, length(word(2)?)?, length(word(3)?)?];
                (
                    RegionForm::Plane {
                        point,
                        normal: [plain(word(4)?)?, plain(word(5)?)?, plain(word(6)?)?],
                    },
                    7,
                )
            }
            other => {
                return Err(format!(
                    "region style {other} has no counterpart; block, cylinder, cone, sphere and plane do"
                ));
            }
        };
        let mut region = Self { form, is_inside: true, open: Vec::new(), moves: false };
        let mut rest = words[used..].iter().map(String::as_str);
        while let Some(key) = rest.next() {
            match (key, rest.next()) {
                ("side", Some(side)) => region.is_inside = side == "in",
                ("open", Some(face)) => region.open.extend(face.parse::<usize>().ok()),
                ("units", Some("lattice")) => {
                    return Err("units lattice: give the region in units box".into());
                }
                ("move" | "rotate", _) => region.moves = true,
                _ => {}
            }
        }
        Ok(region)
    }

    /// Its volume (m³) that centres of particles have which keep `margin` (m) from its surface.
    pub fn volume(&self, margin: f64) -> f64 {
        match &self.form {
            RegionForm::Block { lower, upper } => {
                (0..3).map(|a| (upper[a] - lower[a] - 2.0 * margin).max(0.0)).product()
            }
            RegionForm::Cone { radii, ends, .. } => {
                let [a, b] = radii.map(|r| (r - margin).max(0.0));
                PI / 3.0 * (a * a + a * b + b * b) * (ends[1] - ends[0] - 2.0 * margin).max(0.0)
            }
            RegionForm::Sphere { radius, .. } => 4.0 / 3.0 * PI * (radius - margin).max(0.0).powi(3),
            RegionForm::Plane { .. } => 0.0,
        }
    }

    /// The window of centres that keep `margin` (m) from its surface, and whether that is all of them.
    ///
    /// # Errors
    /// Regions without an inside, and those that are too small.
    pub fn window(&self, margin: f64) -> Result<(Window, bool), String> {
        if !self.is_inside {
            return Err("the outside of a region holds no insertion".into());
        }
        let (window, is_whole) = match &self.form {
            RegionForm::Block { lower, upper } => {
                (Window::Box { lower: lower.map(|x| x + margin), upper: upper.map(|x| x - margin) }, true)
            }
            RegionForm::Cone { axis, center, radii, ends }
                if ends[1] - ends[0] <= 2.0 * margin && radii[0] == radii[1] =>
            {
                let mut middle = *center;
                middle[*axis] = 0.5 * (ends[0] + ends[1]);
                let normal = std::array::from_fn(|a| f64::from(u8::from(a == *axis)));
                let radius = radii[0] - margin;
                if radius <= 0.0 {
                    return Err("the region is too small for its particles".into());
                }
                return Ok((Window::Disc { center: middle, normal, radius }, true));
            }
            RegionForm::Cone { axis, center, radii, ends } => {
                let half = (radii[0].min(radii[1]) - margin) / 2.0_f64.sqrt();
                let corner = |side: usize, sign: f64| {
                    std::array::from_fn(|a| match a == *axis {
                        true => ends[side] - sign * margin,
                        false => center[a] + sign * half,
                    })
                };
                (Window::Box { lower: corner(0, -1.0), upper: corner(1, 1.0) }, false)
            }
            RegionForm::Sphere { center, radius } => {
                let half = (radius - margin) / 3.0_f64.sqrt();
                (Window::Box { lower: center.map(|x| x - half), upper: center.map(|x| x + half) }, false)
            }
            RegionForm::Plane { .. } => return Err("a half space holds no insertion".into()),
        };
        match &window {
            Window::Box { lower, upper } if (0..3).any(|a| lower[a] > upper[a]) => {
                Err("the region is too small for its particles".into())
            }
            _ => Ok((window, is_whole)),
        }
    }

    /// The wall that particles meet.
    ///
    /// # Errors
    /// Forms that are no walls of a case.
    pub fn wall(&self) -> Result<WallKind, String> {
        let side = if self.is_inside { Side::Inside } else { Side::Outside };
        match &self.form {
            RegionForm::Block { .. } if !self.open.is_empty() => {
                Err("a box with open faces: give its sides as planes or polygons".into())
            }
            RegionForm::Block { lower, upper } => Ok(WallKind::Box { lower: *lower, upper: *upper, side }),
            RegionForm::Plane { point, normal } => {
                let sign = if self.is_inside { 1.0 } else { -1.0 };
                Ok(WallKind::Plane { point: *point, normal: normal.map(|x| sign * x) })
            }
            RegionForm::Cone { axis, center, radii, ends } => {
                let direction: [f64; 3] = std::array::from_fn(|a| f64::from(u8::from(a == *axis)));
                let mut middle = *center;
                middle[*axis] = 0.5 * (ends[0] + ends[1]);
                let height = ends[1] - ends[0];
                let [is_lower_open, is_upper_open] = [1, 2].map(|face| self.open.contains(&face));
                if self.open.contains(&3) || is_lower_open != is_upper_open {
                    return self.profile(*axis, middle, *radii, height);
                }
                let caps = !is_lower_open;
                Ok(match radii[0] == radii[1] {
                    true => WallKind::Cylinder {
                        center: middle,
                        axis: direction,
                        radius: radii[0],
                        height,
                        side,
                        caps,
                    },
                    false => WallKind::Cone {
                        center: middle,
                        axis: direction,
                        bottom_radius: radii[0],
                        top_radius: radii[1],
                        height,
                        caps,
                        side,
                        facets: 96,
                    },
                })
            }
            RegionForm::Sphere { .. } => {
                Err("a case has no spherical wall: give a mesh, or a profile of kind revolution".into())
            }
        }
    }

    /// A tube that is open at one end.
    fn profile(
        &self,
        axis: usize,
        middle: [f64; 3],
        radii: [f64; 2],
        height: f64,
    ) -> Result<WallKind, String> {
        if self.open.contains(&3) {
            return Err("the ends of a tube without its side: give them as polygons or a mesh".into());
        }
        let half = 0.5 * height;
        let mut profile = vec![[-half, radii[0]], [half, radii[1]]];
        match self.open.contains(&1) {
            true => profile.push([half, 0.0]),
            false => profile.insert(0, [-half, 0.0]),
        }
        let direction = std::array::from_fn(|a| f64::from(u8::from(a == axis)));
        let side = if self.is_inside { Side::Inside } else { Side::Outside };
        Ok(WallKind::Revolution { origin: middle, axis: direction, profile, side, facets: 96 })
    }
}
