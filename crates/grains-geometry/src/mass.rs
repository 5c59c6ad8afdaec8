//! Volume, centre of mass, inertia and principal axes of solids of unit density.

mod chord;
mod chords;
mod clip;
pub(crate) mod union;

use crate::{Mat3, Rotation, TriMesh, Vec3};
use std::f64::consts::PI;

/// Off-diagonal inertia below this fraction of the trace is rounding.
const DIAGONAL: f64 = 1e-12;

/// Mass properties of a solid of unit density.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct MassProperties {
    /// Volume (m^3).
    pub volume: f64,
    /// Centre of mass (m).
    pub center: Vec3,
    /// Inertia tensor about the centre of mass, `∫ (|r|² 1 - r rᵀ) dV` (m^5).
    pub inertia: Mat3,
}

impl MassProperties {
    /// Of the solid bounded by a closed mesh with outward triangles: sum over the signed tetrahedra
    /// spanned by the triangles and a point, with `∫ r rᵀ dV = V/20 (Σ aᵢaᵢᵀ + (Σ aᵢ)(Σ aᵢ)ᵀ)`.
    pub fn of_closed_mesh(mesh: &TriMesh) -> Self {
        // About a point amid the vertices and in units of the size, so that nothing cancels or underflows.
        let origin = mesh.vertices.iter().sum::<Vec3>() / mesh.vertices.len().max(1) as f64;
        let size = mesh.diagonal();
        let (mut volume, mut first, mut second) = (0.0, Vec3::zeros(), Mat3::zeros());
        for t in 0..mesh.triangles.len() {
            let [a, b, c] = mesh.corners(t).map(|p| (p - origin) / size);
            let v = a.dot(&b.cross(&c)) / 6.0;
            let sum = a + b + c;
            volume += v;
            first += sum * (v / 4.0);
            second += (a * a.transpose() + b * b.transpose() + c * c.transpose() + sum * sum.transpose())
                * (v / 20.0);
        }
        let center = first / volume;
        let second = second - center * center.transpose() * volume;
        let inertia = Mat3::identity() * second.trace() - second;
        MassProperties {
            volume: volume * size.powi(3),
            center: center * size + origin,
            inertia: inertia * size.powi(5),
        }
    }

    /// Of a solid whose frame is along the principal axes at the centre of mass.
    pub fn in_body_frame(volume: f64, inertia: &Vec3) -> Self {
        MassProperties { volume, center: Vec3::zeros(), inertia: Mat3::from_diagonal(inertia) }
    }

    /// Of the solid turned about the origin, then moved (m).
    pub fn placed(&self, rotation: &Rotation, position: &Vec3) -> Self {
        let turn = rotation.to_rotation_matrix().into_inner();
        MassProperties {
            volume: self.volume,
            center: turn * self.center + position,
            inertia: turn * self.inertia * turn.transpose(),
        }
    }

    /// Of several solids that do not overlap: J = Σ J_i + V_i (|d_i|² 1 − d_i d_iᵀ) with d_i the centre
    /// of the i-th less that of all.
    pub fn sum(solids: &[Self]) -> Self {
        let volume: f64 = solids.iter().map(|s| s.volume).sum();
        let center = solids.iter().map(|s| s.center * (s.volume / volume)).sum::<Vec3>();
        let about_center = |s: &Self| {
            let d = s.center - center;
            s.inertia + (Mat3::identity() * d.norm_squared() - d * d.transpose()) * s.volume
        };
        MassProperties { volume, center, inertia: solids.iter().map(about_center).sum() }
    }
}

/// Principal axes of a symmetric tensor by Jacobi rotations: `(R, m)` with `R diag(m) Rᵀ = tensor`.
///
/// R is a proper rotation near the given axes, for each step turns by at most 45°. A tensor that is
/// diagonal to rounding keeps its axes.
pub fn principal_axes(tensor: &Mat3) -> (Mat3, Vec3) {
    let mut a = (tensor + tensor.transpose()) / 2.0;
    let mut axes = Mat3::identity();
    let off_diagonal = |a: &Mat3| a[(0, 1)].abs().max(a[(0, 2)].abs()).max(a[(1, 2)].abs());
    if off_diagonal(&a) <= DIAGONAL * a.trace().abs() {
        return (axes, a.diagonal());
    }
    // Converges quadratically; ten sweeps are more than any 3 x 3 tensor needs.
    for _ in 0..10 {
        for (p, q) in [(0, 1), (0, 2), (1, 2)] {
            if a[(p, q)] == 0.0 {
                continue;
            }
            let tau = (a[(q, q)] - a[(p, p)]) / (2.0 * a[(p, q)]);
            let tangent = 1.0f64.copysign(tau) / (tau.abs() + libm::hypot(tau, 1.0));
            let cosine = 1.0 / libm::hypot(tangent, 1.0);
            let mut turn = Mat3::identity();
            turn[(p, p)] = cosine;
            turn[(q, q)] = cosine;
            turn[(p, q)] = tangent * cosine;
            turn[(q, p)] = -tangent * cosine;
            a = turn.transpose() * a * turn;
            axes *= turn;
        }
    }
    (axes, a.diagonal())
}

/// Diameter of the sphere of the given volume, `(6 V/π)^(1/3)` (m).
pub fn sphere_equivalent_diameter(volume: f64) -> f64 {
    libm::cbrt(6.0 * volume / PI)
}
