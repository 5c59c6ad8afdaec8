//! Lobed extrudates: trilobes, quadralobes and their kin (Rakotonirina 2016, ch. 4, section 2.4).

use crate::error::check_length;
use crate::glued::{Component, glue};
use crate::{MassProperties, MassSource, Shape, ShapeError, Vec3, rotation_about};
use std::f64::consts::PI;

/// Bisections of the offset that gives an area fraction: one for each digit of an f64.
const BISECTIONS: usize = 60;

/// Cross-section of a lobed body: `count` discs of radius R − c with centres at the distance c from the
/// axis, and the regular polygon through these centres. The first lobe is on the x axis.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Lobes {
    /// Number of lobes, at least 3.
    pub count: u32,
    /// Radius R of the circumscribed circle (m).
    pub radius: f64,
    /// Distance c of the lobes' centres from the axis (m).
    pub offset: f64,
}

impl Lobes {
    /// Lobes that fill a given fraction of the circumscribed circle (-).
    ///
    /// Errors: a fraction so small that neighbouring lobes would not meet, or not below 1; radius or
    /// count out of range.
    pub fn with_area_fraction(count: u32, radius: f64, fraction: f64) -> Result<Self, ShapeError> {
        check_count(count)?;
        check_length("radius of lobes", radius)?;
        let at = |offset| Self { count, radius, offset };
        let (mut low, mut high) = (0.0, at(0.0).largest_offset());
        if !(fraction >= at(high).area_fraction() && fraction < 1.0) {
            return Err(ShapeError::AreaFraction { count, fraction, lowest: at(high).area_fraction() });
        }
        for _ in 0..BISECTIONS {
            let middle = 0.5 * (low + high);
            if at(middle).area_fraction() > fraction { low = middle } else { high = middle }
        }
        Ok(at(high))
    }

    /// Radius R − c of a lobe (m).
    pub fn lobe_radius(&self) -> f64 {
        self.radius - self.offset
    }

    /// Offset at which neighbouring lobes just meet, c sin(π/n) = R − c (m).
    pub fn largest_offset(&self) -> f64 {
        self.radius / (1.0 + libm::sin(self.half_angle()))
    }

    /// Cross-section over that of the circumscribed cylinder (-).
    pub fn area_fraction(&self) -> f64 {
        self.area() / (PI * self.radius * self.radius)
    }

    /// Angle between a lobe and the neck beside it.
    fn half_angle(&self) -> f64 {
        PI / f64::from(self.count)
    }

    /// Distance of the necks, where neighbouring lobes meet, from the axis (m).
    fn neck(&self) -> f64 {
        let (sine, cosine) = libm::sincos(self.half_angle());
        let half_chord = self.lobe_radius().powi(2) - (self.offset * sine).powi(2);
        self.offset * cosine + half_chord.max(0.0).sqrt()
    }

    /// Angle φ at a lobe's centre from the outward direction to the neck.
    fn arc(&self) -> f64 {
        let (sine, cosine) = libm::sincos(self.half_angle());
        libm::atan2(self.neck() * sine, self.neck() * cosine - self.offset)
    }

    /// Area (m²): 2n times a triangle from axis, lobe centre and neck and a sector of the lobe,
    /// c y/2 + ρ² φ/2 with y the height of the neck over the lobe's axis and ρ the lobe's radius.
    fn area(&self) -> f64 {
        let height = self.neck() * libm::sin(self.half_angle());
        f64::from(self.count) * (self.offset * height + self.lobe_radius().powi(2) * self.arc())
    }

    /// Polar second moment ∫ r² dA about the axis (m⁴), from the same triangles and sectors:
    /// A (c² + p² + c·p)/6 and c² ρ² φ/2 + 2 c ρ³ sin φ/3 + ρ⁴ φ/4, with p the neck.
    fn polar_moment(&self) -> f64 {
        let (c, rho, p, phi) = (self.offset, self.lobe_radius(), self.neck(), self.arc());
        let (sine, cosine) = libm::sincos(self.half_angle());
        let triangle = 0.5 * c * p * sine * (c * c + p * p + c * p * cosine) / 6.0;
        let sector = rho.powi(2) * phi / 2.0 * c * c
            + 2.0 * c * rho.powi(3) * libm::sin(phi) / 3.0
            + rho.powi(4) * phi / 4.0;
        2.0 * f64::from(self.count) * (triangle + sector)
    }

    /// Mass properties at unit density of the body of a given length (m) along z, centred: V = A L,
    /// I_z = J L, I_x = I_y = J L/2 + A L³/12.
    fn mass(&self, length: f64) -> MassProperties {
        let (area, polar) = (self.area(), self.polar_moment());
        let across = polar * length / 2.0 + area * length.powi(3) / 12.0;
        MassProperties::in_body_frame(area * length, &Vec3::new(across, across, polar * length))
    }

    /// Errors: fewer than three lobes, lengths out of range, neighbouring lobes that do not meet.
    fn check(&self) -> Result<(), ShapeError> {
        let (count, radius, offset) = (self.count, self.radius, self.offset);
        check_count(count)?;
        check_length("radius of lobes", radius)?;
        check_length("offset of lobes", offset)?;
        let largest = self.largest_offset();
        // At the limit itself rounding must not decide.
        if offset <= largest * (1.0 + 1e-12) {
            return Ok(());
        }
        Err(ShapeError::OpenLobes {
            count,
            offset,
            lobe_radius: self.lobe_radius(),
            radius,
            spacing: 2.0 * offset * libm::sin(self.half_angle()),
            largest,
            lowest: Self { offset: largest, ..*self }.area_fraction(),
        })
    }
}

fn check_count(count: u32) -> Result<(), ShapeError> {
    if (3..=100).contains(&count) {
        return Ok(());
    }
    let remedy = "take 3 for a trilobe, 4 for a quadralobe";
    let value = f64::from(count);
    Err(ShapeError::OutOfRange { quantity: "number of lobes", value, allowed: "3 to 100", remedy })
}

impl Shape {
    /// Lobed body of a given length (m) along z: a cylinder for each lobe, and the prism through their
    /// axes.
    ///
    /// Errors: neighbouring lobes that do not meet, fewer than three; lengths or crust out of range.
    pub fn lobes(lobes: Lobes, length: f64, crust_fraction: f64) -> Result<Self, ShapeError> {
        lobes.check()?;
        check_length("length of lobes", length)?;
        let corner = |k: u32| {
            let angle = 2.0 * lobes.half_angle() * f64::from(k);
            Vec3::new(lobes.offset * libm::cos(angle), lobes.offset * libm::sin(angle), 0.0)
        };
        let cylinder = Shape::cylinder(lobes.lobe_radius(), length, crust_fraction)?.named("lobe");
        let mut components: Vec<Component> =
            (0..lobes.count).map(|k| Component::new(cylinder.clone(), corner(k))).collect();
        components.push(if lobes.count == 4 {
            // The box core costs less than its eight vertices.
            let edge = lobes.offset * 2f64.sqrt();
            let quarter = rotation_about(&Vec3::z(), PI / 4.0);
            let middle = Shape::cuboid(Vec3::new(edge, edge, length), crust_fraction)?;
            Component::new(middle.named("middle"), Vec3::zeros()).turned(quarter)
        } else {
            let half = Vec3::new(0.0, 0.0, length / 2.0);
            let ends: Vec<Vec3> =
                (0..lobes.count).flat_map(|k| [corner(k) - half, corner(k) + half]).collect();
            Component::new(Shape::hull(&ends, crust_fraction)?.named("middle"), Vec3::zeros())
        });
        let mass = (lobes.mass(length), MassSource::ClosedForm);
        Ok(glue(&components, crust_fraction, Some(mass))?.named("lobes"))
    }
}
