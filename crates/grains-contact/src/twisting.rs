//! Resistance to twisting: to relative rotation about the normal.

/// How a contact resists twisting.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
pub enum Twisting {
    /// Not at all.
    #[default]
    None,
    /// By the tangential spring, dashpot and slider over the circle of contact (Marshall 2009).
    Marshall,
}
