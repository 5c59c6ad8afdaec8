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
/// Q = ΔT ∫ 2π r dr/(max(l(r), s)/k_g + p(r)/k)   from the contact to r_o,   p(r) = √(R² − r²) − r √(R² − r_o²)/r_o
/// ```
///
/// with the gap l(r) at the distance r from that line, a smallest gap s of the order of the mean free path of the gas, and the ways p(r)
/// of both spheres (1/k adds up) from the gap to the cone between the centre and the edge of the lens (Cheng, Yu and Zulli 1999).
/// Without these, p = 0, spheres are of one temperature up to their surface, as Rong and Horio take them. Spheres of unlike radii
/// count as two of the radius 2 R1 R2/(R1 + R2) with the same gap between them.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct GasLens {
    /// Conductivity k_g of the gas (W/(m K)).
    pub conductivity: f64,
    /// Thickness of the layer over the radius (-).
    pub thickness: f64,
    /// Smallest gap s (m).
    pub smallest_gap: f64,
}

/// Nodes and weights of Gauss and Legendre's rule from 0 to 1.
const NODES: [(f64, f64); 12] = [
    (0.009_219_682_876_640, 0.023_587_668_193_256),
    (0.047_941_371_814_763, 0.053_469_662_997_660),
    (0.115_048_662_902_848, 0.080_039_164_271_673),
    (0.206_341_022_856_691, 0.101_583_713_361_533),
    (0.316_084_250_500_910, 0.116_746_268_269_177),
    (0.437_383_295_744_266, 0.124_573_522_906_701),
    (0.562_616_704_255_734, 0.124_573_522_906_701),
    (0.683_915_749_499_090, 0.116_746_268_269_177),
    (0.793_658_977_143_309, 0.101_583_713_361_533),
    (0.884_951_337_097_152, 0.080_039_164_271_673),
    (0.952_058_628_185_237, 0.053_469_662_997_660),
    (0.990_780_317_123_360, 0.023_587_668_193_256),
];

/// The lens between two spheres of one radius, or between one and a plane wall.
#[derive(Clone, Copy)]
struct Lens {
    /// Radius R (m).
    radius: f64,
    /// 2 of spheres, 1 at a wall.
    sides: f64,
    /// Gap at the line of the centres (m).
    gap: f64,
    /// Squares of the radii where the lens begins and ends (m²).
    from: f64,
    to: f64,
}

impl GasLens {
    /// Largest gap (m) over which spheres up to this radius (m) exchange heat.
    pub fn reach(&self, radius: f64) -> f64 {
        2.0 * self.thickness * radius
    }

    /// Conductance (W/K) between two spheres of these radii (m), or one and a plane wall where the second is infinite, at a gap (m),
    /// negative where they overlap, around a contact of this radius (m).
    ///
    /// `resistivity` is the sum of 1/k (m K/W) of the spheres, zero where they have one temperature up to their surface.
    pub fn conductance(&self, gap: f64, radii: [f64; 2], contact_radius: f64, resistivity: f64) -> f64 {
        let [a, b] = radii;
        let (radius, sides) = match b.is_finite() {
            true => (2.0 * a * b / (a + b), 2.0),
            false => (a, 1.0),
        };
        let (layer, half) = (radius * (1.0 + self.thickness), gap / sides + radius);
        let to = (layer * layer - half * half).min(radius * radius);
        let from = contact_radius * contact_radius;
        if to <= from {
            return 0.0;
        }
        let lens = Lens { radius, sides, gap, from, to };
        match resistivity > 0.0 {
            true => self.through_spheres(&lens, resistivity),
            false => self.isothermal(&lens),
        }
    }

    /// That of spheres of one temperature, in closed form.
    fn isothermal(&self, &Lens { radius, sides, gap, from, to }: &Lens) -> f64 {
        // u = √(R² − r²), l = h + n (R − u), and r dr = −u du.
        let depth = gap + sides * radius;
        let at = |square: f64| (radius * radius - square).max(0.0).sqrt();
        // Where the gap is the smallest one.
        let narrow = (depth - self.smallest_gap) / sides;
        let square = (radius * radius - narrow * narrow).min(to);
        let square = if narrow > radius { from } else { square.max(from) };
        let flat = (square - from) / (2.0 * self.smallest_gap);
        let primitive = |u: f64| -u / sides - depth / (sides * sides) * libm::log(depth - sides * u);
        let curved = if to > square { primitive(at(square)) - primitive(at(to)) } else { 0.0 };
        2.0 * PI * self.conductivity * (flat + curved)
    }

    /// That with the ways through the spheres, by a rule that is finer near the contact: to some per cent where these conduct up to 10⁴
    /// times as well as the gas.
    fn through_spheres(&self, &Lens { radius, sides, gap, from, to }: &Lens, resistivity: f64) -> f64 {
        let [first, last] = [from, to].map(f64::sqrt);
        let slope = (radius * radius - to).max(0.0).sqrt() / last;
        let width = last - first;
        let ring = |&(y, weight): &(f64, f64)| {
            let r = first + width * y * y * y;
            let u = (radius * radius - r * r).max(0.0).sqrt();
            let of_gas = (gap + sides * (radius - u)).max(self.smallest_gap) / self.conductivity;
            let of_spheres = (u - r * slope).max(0.0) * resistivity;
            weight * 3.0 * width * y * y * r / (of_gas + of_spheres)
        };
        2.0 * PI * NODES.iter().map(ring).sum::<f64>()
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
                    [lens.conductance(gap, radii, contact, 0.0), by_quadrature(&lens, gap, radii, contact)];
                assert!((exact - sum).abs() <= 1e-4 * sum.max(1e-12), "{radii:?} {gap} {exact} {sum}");
            }
            assert_eq!(lens.conductance(lens.reach(3e-3), radii, 0.0, 0.0), 0.0);
        }
    }

    /// With the ways through the spheres it is the sum over many thin rings, and falls from that without these to nothing as they
    /// conduct worse.
    #[test]
    fn the_way_through_the_spheres_adds_to_that_through_the_gas() {
        let lens = GasLens { conductivity: 0.026, thickness: 0.2, smallest_gap: 7e-8 };
        for (gap, contact) in [(0.0, 0.0), (-1e-7, 1e-5), (1e-6, 0.0), (1e-4, 0.0)] {
            let radii = [1e-3, 1e-3];
            let mut last = lens.conductance(gap, radii, contact, 0.0);
            for conductivity in [260.0, 15.0, 1.0, 0.1] {
                let found = lens.conductance(gap, radii, contact, 2.0 / conductivity);
                let to = (1.2e-3_f64.powi(2) - (1e-3 + 0.5 * gap).powi(2)).sqrt();
                let slope = (1e-6 - to * to).sqrt() / to;
                let rings = 200_000;
                let ring = |k: i32| {
                    let [low, high] = [0, 1].map(|end| {
                        contact + (to - contact) * (f64::from(k + end) / f64::from(rings)).powi(3)
                    });
                    let r = 0.5 * (low + high);
                    let u = (1e-6 - r * r).sqrt();
                    let gas = (gap + 2.0 * (1e-3 - u)).max(7e-8) / 0.026;
                    2.0 * PI * r * (high - low) / (gas + (u - r * slope) * 2.0 / conductivity)
                };
                let sum: f64 = (0..rings).map(ring).sum();
                assert!((found / sum - 1.0).abs() < 1e-2, "{gap} {conductivity}: {found} instead of {sum}");
                assert!(found < last, "{gap} {conductivity}: {found} above {last}");
                last = found;
            }
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
