//! Soft adhesive spheres.

use super::{Approach, Hertz, NormalLaw, Response};
use crate::cube_root::cube_root;
use schemars::JsonSchema;
use serde::{Deserialize, Serialize};
use std::f64::consts::PI;

/// Up to where two bodies that are pulled apart hold on to each other; both forms lose the energy beyond.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq, Serialize, Deserialize, JsonSchema)]
#[serde(rename_all = "snake_case")]
pub enum Tear {
    /// To where no equilibrium is left at a given distance, at 5/9 of the pull-off force.
    #[default]
    Displacement,
    /// To the pull-off force, where bodies under a given load part (LAMMPS).
    Load,
}

/// F = 4 E* a³/(3 R*) − √(8π w E* a³), δ = a²/R* − √(2π w a/E*) (Johnson, Kendall and Roberts 1971).
///
/// The contact begins where the surfaces touch, with a > 0 and a pull of 8/9 of the pull-off force (3/2) π w R*, and ends
/// at a gap: what was gained at the first is lost at the second. With a = a0 t², a0³ = 2π w R*²/E*, the overlap is
/// δ = (a0²/R*)(t⁴ − t) and the force F = (E* a0³/R*)((4/3) t⁶ − 2 t³).
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Jkr {
    /// Effective modulus E* (Pa).
    pub modulus: f64,
    /// Work of adhesion w (J/m²), twice the surface energy of a material on itself.
    pub work: f64,
    /// Where it ends.
    pub tear: Tear,
}

/// t of the smallest overlap, (1/4)^(1/3), and t⁴ − t there.
const SMALLEST_T: f64 = 0.629_960_524_947_436_6;
const SMALLEST: f64 = -0.472_470_393_710_577_4;
/// t⁴ − t of the pull-off force, where t³ = 3/4.
const AT_PULL_OFF: f64 = -0.227_140_074_120_675_6;

/// The larger root t of t⁴ − t = d, for d not below its smallest value.
///
/// Newton's steps descend from two bounds above: the smaller of 1 + d^(1/4) and that of the parabola at the double root.
#[inline(always)]
fn root(d: f64) -> f64 {
    let above = 1.0 + d.max(0.0).sqrt().sqrt();
    let beside = SMALLEST_T + ((d - SMALLEST).max(0.0) / (6.0 * SMALLEST_T * SMALLEST_T)).sqrt();
    let mut t = above.min(beside);
    for _ in 0..6 {
        let cube = t * t * t;
        t -= (t * (cube - 1.0) - d) / (4.0 * cube - 1.0).max(1e-9);
    }
    t
}

impl Jkr {
    /// a0³ = 2π w R*²/E* (m³), and a0²/R* (m).
    #[inline(always)]
    fn scales(&self, radius: f64) -> (f64, f64, f64) {
        let cube = 2.0 * PI * self.work * radius * radius / self.modulus;
        let length = cube_root(cube);
        (cube, length, length * length / radius)
    }

    /// Overlap over a0²/R* at which the contact ends (-), negative.
    #[inline(always)]
    fn end(&self) -> f64 {
        match self.tear {
            Tear::Displacement => SMALLEST,
            Tear::Load => AT_PULL_OFF,
        }
    }
}

impl NormalLaw for Jkr {
    const NAME: &'static str = "jkr";
    const KEEPS_MEMORY: bool = true;
    const DAMPING: f64 = Hertz::DAMPING;

    #[inline(always)]
    fn respond(&self, approach: &Approach, memory: &mut f64) -> Response {
        let &Approach { overlap, opening, radius, dt } = approach;
        let (cube, length, depth) = self.scales(radius);
        let d = overlap / depth;
        let adhered = *memory > 0.0;
        let is_contact = (d > 0.0) | (adhered & (d > self.end()));
        *memory = if is_contact { 1.0 } else { 0.0 };
        let t = root(d.max(SMALLEST));
        let (t2, t3) = (t * t, t * t * t);
        let force = self.modulus * cube / radius;
        let elastic = force * (4.0 / 3.0 * t3 - 2.0) * t3;
        let contact_radius = length * t2;
        // a over the half step: da/dδ = 2 a0 t/((a0²/R*)(4 t³ − 1)), no more than halved or doubled.
        let change = (opening * dt / depth) / (t * (4.0 * t3 - 1.0).max(1e-3));
        let change = change.clamp(-0.5, 0.5);
        let stiffness = 2.0 * self.modulus * contact_radius;
        let pull_off = 0.75 * force;
        Response {
            is_contact,
            elastic,
            // Of the order of the force at either end, where it begins or ceases.
            jump: elastic.min(0.0),
            stiffness,
            pressing: (elastic + 2.0 * pull_off).abs(),
            contact_radius,
            radii_around: [contact_radius * (1.0 + change), contact_radius * (1.0 - change)],
            margin: if adhered { overlap - self.end() * depth } else { overlap },
        }
    }

    fn reach(&self, radius: f64) -> f64 {
        let (_, _, depth) = self.scales(radius);
        -self.end() * depth
    }

    fn force_bound(&self, radius: f64, overlap: f64) -> f64 {
        Hertz { modulus: self.modulus }.force_bound(radius, overlap) + self.pull_off(radius)
    }

    fn pull_off(&self, radius: f64) -> f64 {
        1.5 * PI * self.work * radius
    }
}
