//! Breakage of a bond by stress.

/// Largest stresses in a bond.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Stress {
    /// σ (Pa), positive in tension.
    pub tensile: f64,
    /// τ (Pa).
    pub shear: f64,
}

/// Stresses at which a bond breaks; infinite where it does not.
///
/// Elastic stresses at mid-length count, as in the calibrations of Potyondy and Cundall; dashpots do not. At its ends the moment
/// of a beam under shear Q is larger by Q l/2: the root of a chain holds less than by this, to first order in l.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Strength {
    /// Tensile strength (Pa).
    pub tensile: f64,
    /// Shear strength (Pa).
    pub shear: f64,
}

impl Strength {
    /// That of a bond that never breaks.
    pub const UNBREAKABLE: Self = Self { tensile: f64::INFINITY, shear: f64::INFINITY };

    /// Whether a bond under this stress breaks; one under a stress that is no number does.
    #[inline(always)]
    pub fn is_exceeded(&self, stress: &Stress) -> bool {
        let holds = (stress.tensile < self.tensile) & (stress.shear < self.shear);
        !holds
    }
}
