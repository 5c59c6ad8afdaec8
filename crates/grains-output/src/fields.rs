//! What an array of a snapshot holds.

/// Floating-point format of the arrays.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Precision {
    /// 64 bits.
    F64,
    /// 32 bits.
    F32,
}

impl Precision {
    /// Refuses a file of another precision.
    ///
    /// # Errors
    /// A precision other than that of the run.
    pub(crate) fn require(self, found: Self) -> hdf5::Result<()> {
        if found == self {
            return Ok(());
        }
        Err(format!("its precision is {found:?}, this run writes {self:?}").into())
    }

    /// Bytes of a number.
    pub(crate) fn bytes(self) -> usize {
        match self {
            Self::F64 => 8,
            Self::F32 => 4,
        }
    }
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
    /// Values per point, triangle or cell.
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

/// Values of a field on this rank, `[points, triangles or cells][components]`.
#[derive(Clone, Copy, Debug)]
pub enum Data<'a> {
    /// Floating point.
    Real(&'a [f64]),
    /// Whole numbers.
    Integer(&'a [i64]),
}

/// Whether fields are those of the specifications, with `rows` rows each.
///
/// # Errors
/// The first that is not.
pub(crate) fn fit(specs: &[FieldSpec], fields: &[Data], rows: usize) -> Result<(), String> {
    if fields.len() != specs.len() {
        return Err(format!("{} fields given, {} wanted", fields.len(), specs.len()));
    }
    for (spec, data) in specs.iter().zip(fields) {
        let (kind, length) = match data {
            Data::Real(values) => (Kind::Real, values.len()),
            Data::Integer(values) => (Kind::Integer, values.len()),
        };
        if (kind, length) != (spec.kind, rows * spec.components) {
            let (name, wanted) = (spec.name, rows * spec.components);
            return Err(format!(
                "`{name}` has {length} values of type {kind:?}, wanted are {wanted} of {:?}",
                spec.kind
            ));
        }
    }
    Ok(())
}
