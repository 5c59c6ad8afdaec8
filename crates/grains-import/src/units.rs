//! Units of LAMMPS that are consistent for mechanics, and SI.

/// Exponents of length, mass and time.
pub type Dimension = [i32; 3];

/// m
pub const LENGTH: Dimension = [1, 0, 0];
/// s
pub const TIME: Dimension = [0, 0, 1];
/// kg
pub const MASS: Dimension = [0, 1, 0];
/// m/s
pub const VELOCITY: Dimension = [1, 0, -1];
/// m/s²
pub const ACCELERATION: Dimension = [1, 0, -2];
/// 1/s
pub const RATE: Dimension = [0, 0, -1];
/// kg/m³
pub const DENSITY: Dimension = [-3, 1, 0];
/// Pa, J/m³
pub const PRESSURE: Dimension = [-1, 1, -2];
/// N/m, J/m²
pub const STIFFNESS: Dimension = [0, 1, -2];
/// N s/m
pub const DASHPOT: Dimension = [0, 1, -1];
/// 1/(m s)
pub const RATE_PER_LENGTH: Dimension = [-1, 0, -1];
/// kg/s
pub const MASS_RATE: Dimension = [0, 1, -1];

/// A consistent system of units.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Units {
    /// Its name in LAMMPS.
    pub name: &'static str,
    /// Its unit of length (m), of mass (kg) and of time (s).
    scales: [f64; 3],
}

/// Systems whose unit of force is that of mass times that of length over the square of that of time.
const SYSTEMS: [Units; 5] = [
    Units { name: "si", scales: [1.0, 1.0, 1.0] },
    Units { name: "lj", scales: [1.0, 1.0, 1.0] },
    Units { name: "cgs", scales: [1e-2, 1e-3, 1.0] },
    Units { name: "micro", scales: [1e-6, 1e-15, 1e-6] },
    Units { name: "nano", scales: [1e-9, 1e-21, 1e-9] },
];

impl Default for Units {
    fn default() -> Self {
        SYSTEMS[0]
    }
}

impl Units {
    /// The system of this name, if it is a consistent one.
    pub fn named(name: &str) -> Option<Self> {
        SYSTEMS.into_iter().find(|units| units.name == name)
    }

    /// A quantity in SI units.
    pub fn si(&self, value: f64, dimension: Dimension) -> f64 {
        let factors = self.scales.iter().zip(dimension);
        // Dividing by whole powers of ten keeps 1 g/cm³ exactly 1000 kg/m³.
        factors.fold(value, |value, (scale, exponent)| match *scale < 1.0 {
            true => value / (1.0 / scale).round().powi(exponent),
            false => value * scale.powi(exponent),
        })
    }

    /// A vector in SI units.
    pub fn vector(&self, value: [f64; 3], dimension: Dimension) -> [f64; 3] {
        value.map(|x| self.si(x, dimension))
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn cgs_converts_exactly_and_others_are_consistent() {
        let cgs = Units::named("cgs").unwrap();
        let rows = [
            (2.5, DENSITY, 2500.0),
            (5e7, PRESSURE, 5e6),
            (981.0, ACCELERATION, 9.81),
            (0.15, LENGTH, 1.5e-3),
            (1e5, STIFFNESS, 100.0),
            (3.0, RATE_PER_LENGTH, 300.0),
        ];
        for (value, dimension, si) in rows {
            assert_eq!(cgs.si(value, dimension), si);
        }
        assert!(Units::named("real").is_none());
        // pg/µm³ is g/cm³.
        let micro = Units::named("micro").unwrap();
        assert!((micro.si(2.5, DENSITY) - 2500.0).abs() < 1e-9);
    }
}
