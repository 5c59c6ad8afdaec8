//! How easily a body is moved where it is touched: what the shortest contact and the stiffest friction of a shape ask of the
//! time step.

use grains_geometry::{Part, Shape, Vec3};

/// Directions in which the surface is looked at first, before the best is improved.
const DIRECTIONS: usize = 2000;

/// The largest mobility of a shape at its surface, over that of its centre of mass (-).
///
/// A push along n at r moves the point by K n with K = 1/m − R I⁻¹ R, R v = r × v ([`grains_contact::Mobility`]), so the effective
/// mass is 1/(n·K n). Both numbers are of bodies of any size and density.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct SurfaceMobility {
    /// Largest m n·K n, for points and normals of the surface: contacts are its root shorter than central ones.
    pub along_normal: f64,
    /// Largest t·K t/(n·K n), for t ⊥ n: slip decays so many times faster than a dashpot of the effective mass says.
    pub along_surface: f64,
}

impl SurfaceMobility {
    /// That of a shape; points inside other parts of it do not count.
    pub fn of(shape: &Shape) -> Self {
        if shape.is_sphere() {
            // I = 2/5 m R²: r × n = 0, and 1 + m R²/I along the surface.
            return Self { along_normal: 1.0, along_surface: 3.5 };
        }
        let largest = |value: &dyn Fn(&Vec3, &Vec3) -> f64| {
            let of_part = |number| largest_on(shape, number, value);
            (0..shape.parts.len()).map(of_part).fold(1.0, f64::max)
        };
        Self {
            along_normal: largest(&|arm, normal| along(shape, arm, normal)),
            along_surface: largest(&|arm, normal| across(shape, arm, normal) / along(shape, arm, normal)),
        }
    }
}

/// m d·K d of a point of the body frame (m) along a unit vector (-).
fn along(shape: &Shape, arm: &Vec3, direction: &Vec3) -> f64 {
    let lever = arm.cross(direction);
    1.0 + shape.volume * lever.component_mul(&lever).component_div(&shape.inertia).sum()
}

/// Largest m t·K t for t ⊥ n: the larger root of K restricted to the plane (-).
fn across(shape: &Shape, arm: &Vec3, normal: &Vec3) -> f64 {
    let first = normal.cross(&Vec3::ith(normal.iamin(), 1.0)).normalize();
    let second = normal.cross(&first);
    let levers = [first, second].map(|t| arm.cross(&t));
    let [p, q] = [first, second].map(|t| along(shape, arm, &t));
    let mixed = shape.volume * levers[0].component_mul(&levers[1]).component_div(&shape.inertia).sum();
    0.5 * (p + q) + (0.25 * (p - q) * (p - q) + mixed * mixed).sqrt()
}

/// Largest value of a function of point (m, body frame) and outward normal on the free surface of a part; 0 if it has none.
fn largest_on(shape: &Shape, number: usize, value: &dyn Fn(&Vec3, &Vec3) -> f64) -> f64 {
    let part = &shape.parts[number];
    let at = |normal: &Vec3| value(&surface_point(part, normal), normal);
    let is_free = |normal: &Vec3| {
        let point = surface_point(part, normal) + normal * (1e-6 * shape.inscribed_radius);
        let holds = |other: &Part| other.contains(&other.rotation.tr_mul(&(point - other.center)));
        !shape.parts.iter().enumerate().any(|(k, other)| k != number && holds(other))
    };
    let mut best = (0.0, Vec3::z());
    let mut try_normal = |normal: Vec3| {
        let found = at(&normal);
        let is_better = found > best.0 && is_free(&normal);
        if is_better {
            best = (found, normal);
        }
        (is_better, best)
    };
    let axes = (0..3).flat_map(|a| [1.0, -1.0].map(|sign| part.rotation.column(a) * sign));
    for normal in axes.chain(spiral(DIRECTIONS)) {
        try_normal(normal);
    }
    // Uphill from the best direction, in steps that shrink.
    let (mut step, mut best) = ((4.0 / DIRECTIONS as f64).sqrt(), try_normal(Vec3::z()).1);
    while step > 1e-4 && best.0 > 0.0 {
        let first = best.1.cross(&Vec3::ith(best.1.iamin(), 1.0)).normalize();
        let second = best.1.cross(&first);
        let center = best.1;
        let mut is_better = false;
        for k in 0..8 {
            let (sin, cos) = libm::sincos(f64::from(k) * std::f64::consts::FRAC_PI_4);
            let found = try_normal((center + (first * cos + second * sin) * step).normalize());
            is_better |= found.0;
            best = found.1;
        }
        if !is_better {
            step *= 0.5;
        }
    }
    best.0
}

/// Point of a part's surface with an outward normal, in the body frame (m).
fn surface_point(part: &Part, normal: &Vec3) -> Vec3 {
    let deepest = part.core.support(&part.rotation.tr_mul(normal));
    part.center + part.rotation * deepest + normal * part.crust
}

/// Directions spread evenly over the sphere, along a golden spiral.
fn spiral(count: usize) -> impl Iterator<Item = Vec3> {
    let golden = std::f64::consts::PI * (3.0 - 5.0_f64.sqrt());
    (0..count).map(move |k| {
        let z = 1.0 - (2.0 * k as f64 + 1.0) / count as f64;
        let (sin, cos) = libm::sincos(golden * k as f64);
        let radius = (1.0 - z * z).sqrt();
        Vec3::new(radius * cos, radius * sin, z)
    })
}

#[cfg(test)]
mod tests {
    use super::*;
    use grains_geometry::RegularSolid;

    /// A cylinder is lightest at the end of its side: 1 + m (L/2)²/I with I = m (3 R² + L²)/12.
    #[test]
    fn cylinders_of_any_length_are_lightest_at_the_ends_of_their_sides() {
        for aspect in [1.0_f64, 3.0, 10.0, 30.0, 200.0] {
            let (radius, height) = (0.5e-3, 1e-3 * aspect);
            let shape = Shape::cylinder(radius, height, 1e-3).unwrap();
            let got = SurfaceMobility::of(&shape).along_normal;
            // Or on the rim of a disc, pushed along the axis: 1 + m R²/I.
            let inertia = (3.0 * radius * radius + height * height) / 12.0;
            let wanted = 1.0 + (0.5 * height).max(radius).powi(2) / inertia;
            assert!((got / wanted - 1.0).abs() < 5e-3, "L/d {aspect}: {got} for {wanted}");
        }
    }

    /// No point of the surface is lighter than what was found, and some are nearly as light.
    #[test]
    fn no_point_of_a_surface_is_lighter() {
        let shapes = [
            Shape::sphere(1e-3).unwrap().named("sphere"),
            Shape::cuboid(Vec3::new(1e-3, 2e-3, 7e-3), 0.02).unwrap().named("box"),
            Shape::regular(RegularSolid::Tetrahedron, 1e-3, 0.02).unwrap().named("tetrahedron"),
            Shape::superellipsoid(Vec3::new(1e-3, 0.3e-3, 0.4e-3), [0.5, 1.0], 0.02).unwrap().named("oval"),
            Shape::cross(3, 0.5e-3, 3e-3, 0.02).unwrap().named("cross"),
        ];
        for shape in &shapes {
            let found = SurfaceMobility::of(shape);
            let (mut lightest, mut slippery) = (0.0_f64, 0.0_f64);
            for normal in spiral(30_011) {
                for (k, part) in shape.parts.iter().enumerate() {
                    let arm = surface_point(part, &normal);
                    let inside = |p: &Part| p.contains(&p.rotation.tr_mul(&(arm - p.center)));
                    if shape.parts.iter().enumerate().any(|(other, p)| other != k && inside(p)) {
                        continue;
                    }
                    let here = along(shape, &arm, &normal);
                    lightest = lightest.max(here);
                    slippery = slippery.max(across(shape, &arm, &normal) / here);
                }
            }
            let SurfaceMobility { along_normal, along_surface } = found;
            let name = &shape.name;
            for (got, seen) in [(along_normal, lightest), (along_surface, slippery)] {
                assert!(got > seen * (1.0 - 2e-3) && got < seen * 1.02, "{name}: {got}, but {seen} was seen");
            }
        }
    }
}
