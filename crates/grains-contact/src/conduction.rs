//! Heat between two bodies at rest against each other or near: through the contact, and through the gas around it.

use crate::normal::Response;
use std::f64::consts::PI;

/// How heat passes from one material into another where they touch.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Conduction {
    /// 2 k_m = 4 k1 k2/(k1 + k2) (W/(m K)) of the conductivities of both.
    pub conductivity: f64,
    /// Effective modulus E* (Pa) of the materials as they are, where that of the law is softened.
    pub true_modulus: Option<f64>,
}

impl Conduction {
    /// That between materials of two conductivities (W/(m K)).
    pub fn between(a: f64, b: f64, true_modulus: Option<f64>) -> Self {
        Self { conductivity: 4.0 * a * b / (a + b), true_modulus }
    }

    /// Radius a (m) of the contact through which heat passes.
    ///
    /// It is that of the law, or where the law is softened that of elastic bodies under the same force N,
    /// a³ = 3 N R*/(4 E*) (Hertz 1882), `radius` being R* (m).
    #[inline]
    pub fn contact_radius(&self, response: &Response, radius: f64) -> f64 {
        match self.true_modulus {
            _ if !response.is_contact => 0.0,
            Some(modulus) => libm::cbrt(0.75 * response.pressing.max(0.0) * radius / modulus),
            None => response.contact_radius,
        }
    }

    /// Conductance 2 k_m a (W/K) of a contact of this radius (m), Q = 2 k_m a ΔT (Batchelor and O'Brien 1977).
    #[inline]
    pub fn conductance(&self, contact_radius: f64) -> f64 {
        self.conductivity * contact_radius
    }
}

/// Radius (m) of the circle of the area over which bodies touch along a face or a line.
///
/// The corners of the patch have the second moments s1, s2 (m²) about its centre. A rectangle of the same moments has the sides 2 √s1
/// and 2 √s2; it is taken wider by the radius a (m) that a point contact would have:
///
/// ```text
/// r² = (a + c √s1)(a + c √s2),   c² = 4/π
/// ```
///
/// so that a line touches over a strip and a point over its own circle. `trace` is s1 + s2 (m²), `determinant` s1 s2 (m⁴).
#[inline]
pub fn patch_radius(contact_radius: f64, trace: f64, determinant: f64) -> f64 {
    let product = determinant.max(0.0).sqrt();
    let sum = (trace.max(0.0) + 2.0 * product).sqrt();
    let c = (4.0 / PI).sqrt();
    (contact_radius * contact_radius + c * contact_radius * sum + c * c * product).sqrt()
}

/// Gas around a contact, or in a narrow gap (Rong and Horio 1999).
///
/// A layer of the thickness δ = `thickness` R surrounds every sphere. Heat passes straight through the gas between two spheres
/// within r_o of the line of their centres, where their layers meet,
///
/// ```text
/// Q = k_g ΔT ∫ 2π r dr/max(l(r), s)   from the contact to r_o,
/// ```
///
/// with the gap l(r) at the distance r from that line, and a smallest gap s of the order of the mean free path of the gas. Spheres
/// of unlike radii count as two of the radius 2 R1 R2/(R1 + R2) with the same gap between them.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct GasLens {
    /// Conductivity k_g of the gas (W/(m K)).
    pub conductivity: f64,
    /// Thickness of the layer over the radius (-).
    pub thickness: f64,
    /// Smallest gap s (m).
    pub smallest_gap: f64,
}

impl GasLens {
    /// Largest gap (m) over which spheres up to this radius (m) exchange heat.
    pub fn reach(&self, radius: f64) -> f64 {
        2.0 * self.thickness * radius
    }

    /// Conductance (W/K) between two spheres of these radii (m), or one and a plane wall where the second is infinite, at a gap (m),
    /// negative where they overlap, around a contact of this radius (m).
    pub fn conductance(&self, gap: f64, radii: [f64; 2], contact_radius: f64) -> f64 {
        let [a, b] = radii;
        let (radius, sides) = match b.is_finite() {
            true => (2.0 * a * b / (a + b), 2.0),
            false => (a, 1.0),
        };
        self.between_alike(gap, radius, sides, contact_radius)
    }

    /// The same between two spheres of one radius R (m), `sides` = 2, or one and a plane, `sides` = 1.
    fn between_alike(&self, gap: f64, radius: f64, sides: f64, contact_radius: f64) -> f64 {
        // u = √(R² − r²), l = h + n (R − u), and r dr = −u du.
        let depth = gap + sides * radius;
        let layer = radius * (1.0 + self.thickness);
        let half = depth / sides;
        let outer = (layer * layer - half * half).min(radius * radius);
        let inner = contact_radius * contact_radius;
        if outer <= inner {
            return 0.0;
        }
        let at = |square: f64| (radius * radius - square).max(0.0).sqrt();
        // Where the gap is the smallest one.
        let narrow = (depth - self.smallest_gap) / sides;
        let square = (radius * radius - narrow * narrow).min(outer);
        let square = if narrow > radius { inner } else { square.max(inner) };
        let flat = (square - inner) / (2.0 * self.smallest_gap);
        let primitive = |u: f64| -u / sides - depth / (sides * sides) * libm::log(depth - sides * u);
        let curved = if outer > square { primitive(at(square)) - primitive(at(outer)) } else { 0.0 };
        2.0 * PI * self.conductivity * (flat + curved)
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn a_contact_conducts_as_a_circular_spot_between_half_spaces() {
        let alike = Conduction::between(2.0, 2.0, None);
        assert_eq!(alike.conductance(1e-3), 2.0 * 2.0 * 1e-3);
        assert!((Conduction::between(1.0, 3.0, None).conductivity - 2.0 * 1.5).abs() < 1e-15);
    }

    /// Simpson's rule over the gap in the square of the distance.
    fn by_quadrature(lens: &GasLens, gap: f64, radii: [f64; 2], contact_radius: f64) -> f64 {
        let [a, b] = radii;
        let (radius, sides) = if b.is_finite() { (2.0 * a * b / (a + b), 2.0) } else { (a, 1.0) };
        let layer = radius * (1.0 + lens.thickness);
        let half = gap / sides + radius;
        let outer = (layer * layer - half * half).min(radius * radius).max(0.0);
        let inner = contact_radius * contact_radius;
        let (n, mut sum) = (2_000_000, 0.0);
        let width = (outer - inner).max(0.0) / f64::from(n);
        for k in 0..n {
            let square = inner + (f64::from(k) + 0.5) * width;
            let distance = gap + sides * (radius - (radius * radius - square).sqrt());
            sum += PI * width / distance.max(lens.smallest_gap);
        }
        lens.conductivity * sum
    }

    #[test]
    fn the_gas_lens_is_the_integral_over_the_gap() {
        let lens = GasLens { conductivity: 0.026, thickness: 0.2, smallest_gap: 1e-7 };
        for radii in [[1e-3, 1e-3], [1e-3, 3e-3], [2e-3, f64::INFINITY]] {
            for (gap, contact) in
                [(-1e-6, 3e-5), (0.0, 0.0), (5e-8, 0.0), (1e-6, 0.0), (2e-4, 0.0), (3.5e-4, 0.0)]
            {
                let [exact, sum] =
                    [lens.conductance(gap, radii, contact), by_quadrature(&lens, gap, radii, contact)];
                assert!((exact - sum).abs() <= 1e-4 * sum.max(1e-12), "{radii:?} {gap} {exact} {sum}");
            }
            assert_eq!(lens.conductance(lens.reach(3e-3), radii, 0.0), 0.0);
        }
    }

    #[test]
    fn a_patch_is_a_circle_of_its_area_and_a_point_its_own() {
        assert_eq!(patch_radius(0.3, 0.0, 0.0), 0.3);
        // The corners of a square of the side 2 lie √2 from its centre: s1 = s2 = 1.
        assert!((PI * patch_radius(0.0, 2.0, 1.0).powi(2) - 4.0).abs() < 1e-12);
        let line = patch_radius(0.01, 1.0, 0.0);
        assert!((PI * line * line - PI * 0.01 * (0.01 + (4.0 / PI).sqrt())).abs() < 1e-12);
    }
}
