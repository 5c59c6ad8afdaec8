//! What an array of a snapshot holds.

/// Floating-point format of the arrays.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Precision {
    /// 64 bits.
    F64,
    /// 32 bits.
    F32,
}

/// Type of a field's values.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Kind {
    /// Floating point.
    Real,
    /// Whole numbers, 64 bits.
    Integer,
}

/// An array that goes with every step.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub struct FieldSpec {
    /// Name.
    pub name: &'static str,
    /// SI unit, `-` for pure numbers.
    pub unit: &'static str,
    /// Values per point or triangle.
    pub components: usize,
    /// Type.
    pub kind: Kind,
}

impl FieldSpec {
    /// Field of floating-point numbers.
    pub const fn real(name: &'static str, unit: &'static str, components: usize) -> Self {
        Self { name, unit, components, kind: Kind::Real }
    }

    /// Field of whole numbers without unit.
    pub const fn integer(name: &'static str) -> Self {
        Self { name, unit: "-", components: 1, kind: Kind::Integer }
    }
}
