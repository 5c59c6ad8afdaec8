//! What flows along a surface with another conductivity on either side.
//!
//! With fluxes q₁ = D₁ ∂φ₁/∂x and q₂ on the two sides of a surface that crosses the way between two middles at a share θ of it in
//! side 1, and an open share f of the face,
//!
//! ```text
//! q₁ − q₂ = J = (D₁ − D₂) g,   g = e_x·(1 − n n)·∇φ                   the tangential gradient is that of both sides
//! Δφ/Δx = θ q₁/D₁ + (1 − θ) q₂/D₂,   q = f q₁ + (1 − f) q₂
//! q = [Δφ/Δx − J (θ (1 − f)/D₁ − (1 − θ) f/D₂)] / (θ/D₁ + (1 − θ)/D₂)
//! ```
//!
//! and q = q₁ − (1 − f) J, q₂ + f J where both middles lie on one side. Without J, fluxes through surfaces that follow no grid line
//! are of first order. g comes from the side that conducts better, by differences that do not cross the surface; it is that of the
//! beginning of the step, but for the part along the axis where that is a resistance.

/// The tangential flux through a face.
#[derive(Clone, Copy, Debug)]
pub(in super::super) struct Jump {
    pub face: usize,
    /// The cell whose gradient tells the tangential one.
    pub cell: usize,
    /// Unit normal of the surface.
    pub normal: [f64; 3],
    /// What multiplies the tangential gradient along the axis (m⁴/s).
    pub tangential: f64,
    /// Part of the conductance of the face (m³/s) that stands for it in the implicit terms.
    pub implicit: f64,
}

impl Jump {
    /// The flux along the axis beyond what the conductance of the face carries (unit m³/s), of the gradient of φ at the cell and the
    /// difference of φ across the face.
    #[inline]
    pub fn flux(&self, axis: usize, gradient: [f64; 3], difference: f64) -> f64 {
        let along: f64 = (0..3).map(|a| gradient[a] * self.normal[a]).sum();
        let tangential = gradient[axis] - self.normal[axis] * along;
        self.implicit * difference - self.tangential * tangential
    }
}
