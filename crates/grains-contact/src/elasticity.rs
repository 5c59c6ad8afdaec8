//! Elastic constants of a pair from those of its materials.

/// Elastic constants of a material.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Elastic {
    /// Young's modulus E (Pa).
    pub youngs_modulus: f64,
    /// Poisson's ratio ν (-).
    pub poissons_ratio: f64,
}

/// E* (Pa) of two bodies in contact: 1/E* = (1 − ν1²)/E1 + (1 − ν2²)/E2.
pub fn effective_modulus(a: Elastic, b: Elastic) -> f64 {
    let compliance = |m: Elastic| (1.0 - m.poissons_ratio * m.poissons_ratio) / m.youngs_modulus;
    1.0 / (compliance(a) + compliance(b))
}

/// G* (Pa) of two bodies in contact: 1/G* = (2 − ν1)/G1 + (2 − ν2)/G2 with G = E/(2 (1 + ν)).
pub fn effective_shear_modulus(a: Elastic, b: Elastic) -> f64 {
    let compliance =
        |m: Elastic| 2.0 * (2.0 - m.poissons_ratio) * (1.0 + m.poissons_ratio) / m.youngs_modulus;
    1.0 / (compliance(a) + compliance(b))
}

/// Work of adhesion w (J/m²) of two materials of these surface energies γ (J/m²): 2 √(γ1 γ2), 2 γ for a material on itself.
pub fn work_of_adhesion(a: f64, b: f64) -> f64 {
    2.0 * (a * b).sqrt()
}
