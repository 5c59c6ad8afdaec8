//! Lubrication forces in gaps too narrow for the grid of the fluid.

/// The lubrication force between two spheres, or a sphere and a wall, along their normal.
///
/// ```text
/// F = 6 π μ a² v (1/h − 1/H),   h = max(gap, ε a),   0 < gap < H
/// ```
///
/// is what a grid leaves out that resolves gaps down to H; v is the speed of approach, a the radius of the sphere at a
/// wall and a₁ a₂/(a₁ + a₂) of two, ε their roughness over it (Cox and Brenner 1967; Simeonov and Calantoni 2012). Bodies that touch
/// have none.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Lubrication {
    /// Viscosity μ of the fluid (Pa s).
    pub viscosity: f64,
    /// Lubrication range H, the smallest gap that the grid resolves (m).
    pub range: f64,
    /// Smallest gap over the radius, the roughness ε (-).
    pub min_gap: f64,
}

impl Lubrication {
    /// Force (N) that keeps bodies apart, for a gap (m), a speed of approach (m/s), a radius (m), and the sum of the inverse
    /// masses (1/kg) that the force moves in a step (s).
    ///
    /// A gap takes no more than a quarter of the speed in a step: with as many as twelve of them about a sphere the leap-frog
    /// step stays stable, however narrow they are.
    #[inline]
    pub fn force(&self, gap: f64, approach: f64, radius: f64, inverse_mass: f64, dt: f64) -> f64 {
        if gap <= 0.0 || gap >= self.range {
            return 0.0;
        }
        let film = gap.max(self.min_gap * radius);
        let resistance = 6.0 * std::f64::consts::PI * self.viscosity * radius * radius;
        let rate = (resistance * (1.0 / film - 1.0 / self.range)).max(0.0);
        rate.min(0.25 / (inverse_mass * dt)) * approach
    }
}
