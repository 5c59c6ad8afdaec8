//! The share of a step in which bodies touch.

/// Share of the step around this instant for which the bodies touch (-), from 1/2 to 3/2.
///
/// The dashpot force jumps when a contact begins or ends. The first and the last evaluation of a contact
/// stand for all of it since, or until, the overlap is zero; without this the restitution would depend
/// to first order in dt on where between two steps the bodies meet.
#[inline(always)]
pub(crate) fn share_in_contact(overlap: f64, opening: f64, dt: f64) -> f64 {
    let way = opening.abs() * dt;
    if overlap < way { 0.5 + overlap / way } else { 1.0 }
}

/// Whether a contact begins in this step: it is less than its share of it, less 1/2, old.
#[inline(always)]
pub(crate) fn begins(share: f64, opening: f64) -> bool {
    (opening < 0.0) & (share != 1.0)
}

/// The share of [`share_in_contact`] of a contact that ends, else 1.
#[inline(always)]
pub(crate) fn share_at_end(share: f64, opening: f64) -> f64 {
    if opening < 0.0 { 1.0 } else { share }
}
