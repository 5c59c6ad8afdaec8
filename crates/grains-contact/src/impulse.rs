//! Impulses between bodies that do not deform: a collision is an instant (Srinivasan 2019, ch. 3.1, app. A).
//!
//! An impulse J on body 2, −J on body 1, changes the relative velocity at the contact point by K J, where K is
//! the sum of both bodies' [`Mobility::matrix`]. Both schemes keep momentum and angular momentum exactly, and
//! neither ever adds energy: J·(Vr + ½ K J) ≤ 0. A wall has no mobility but may have a velocity.

use nalgebra::{Matrix3, Vector3};

type Vec3 = Vector3<f64>;
type Mat3 = Matrix3<f64>;

/// How easily a body is moved at a contact point.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Mobility {
    /// Inverse mass (1/kg).
    pub inverse_mass: f64,
    /// Inverse of the moment of inertia, in the world frame (1/(kg m²)).
    pub inverse_inertia: Mat3,
    /// Contact point from the centre of mass (m).
    pub arm: Vec3,
}

impl Mobility {
    /// Velocity that the contact point gains per impulse, 1/M − R I⁻¹ R with R v = r × v (1/kg).
    pub fn matrix(&self) -> Mat3 {
        let arm = self.arm.cross_matrix();
        Mat3::from_diagonal_element(self.inverse_mass) - arm * self.inverse_inertia * arm
    }
}

/// Two bodies about to collide, with the normal from body 1 to body 2.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Impact {
    /// Unit normal from body 1 to body 2 (-).
    pub normal: Vec3,
    /// Relative velocity Vr = V2 − V1 at the contact point (m/s); Vr·n < 0 when they approach.
    pub velocity: Vec3,
    /// Restitution e (-), in [0, 1].
    pub restitution: f64,
    /// Coulomb friction coefficient μ (-).
    pub friction: f64,
}

/// How friction and restitution are brought together.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
pub enum ImpulseScheme {
    /// The frictionless normal impulse (eq. 3.24, errata S19-18), then a sliding impulse against the slip
    /// (eq. 3.33, S19-20) of at most μ jₙ and at most what stops the slip (S19-21).
    ///
    /// Friction turns bodies that are not spheres, so the restitution obtained differs from the one set.
    Sequential,
    /// Restitution exact with friction: Vr'·n = −e Vr·n at the contact point (S19-20b).
    ///
    /// The impulse that stops the slip, K⁻¹(−e (Vr·n) n − Vr), if it lies in the friction cone (S19-19); else
    /// that of sliding, j (n − μ t) with j = −(1+e) Vr·n/(n·K(n − μ t)) and t along the slip.
    #[default]
    Exact,
}

impl ImpulseScheme {
    /// Impulse on body 2 (N s), body 1 gets the opposite; zero if the bodies do not approach.
    ///
    /// `mobility` is K, the sum of [`Mobility::matrix`] of both bodies (1/kg).
    pub fn impulse(self, impact: &Impact, mobility: &Mat3) -> Vec3 {
        let approach = -impact.velocity.dot(&impact.normal);
        let along_normal = impact.normal.dot(&(mobility * impact.normal));
        if !(approach > 0.0 && along_normal > 0.0) {
            return Vec3::zeros();
        }
        let frictionless = impact.normal * ((1.0 + impact.restitution) * approach / along_normal);
        if impact.friction == 0.0 {
            return frictionless;
        }
        match self {
            Self::Sequential => sequential(impact, mobility, &frictionless),
            Self::Exact => exact(impact, mobility, &frictionless),
        }
    }
}

/// Slip: the part of the relative velocity along the contact plane (m/s).
fn slip(impact: &Impact) -> Vec3 {
    impact.velocity - impact.normal * impact.velocity.dot(&impact.normal)
}

fn sequential(impact: &Impact, mobility: &Mat3, frictionless: &Vec3) -> Vec3 {
    let Some(tangent) = slip(impact).try_normalize(0.0) else { return *frictionless };
    // The normal impulse has already changed the slip of bodies that are not spheres.
    let left = tangent.dot(&(impact.velocity + mobility * frictionless));
    let stopping = (left / tangent.dot(&(mobility * tangent))).max(0.0);
    frictionless - tangent * stopping.min(impact.friction * frictionless.norm())
}

/// All impulses that give the set restitution differ by what moves the contact point along its plane only, so
/// any mean of one of them and the frictionless one gives it too. Friction is what is added to the latter; it
/// is shortened where it would leave the cone, reverse the slip, or add energy, as Newton's restitution
/// may when friction turns a body (Kane's paradox).
fn exact(impact: &Impact, mobility: &Mat3, frictionless: &Vec3) -> Vec3 {
    let Impact { normal, velocity, friction, .. } = *impact;
    let after = velocity + mobility * frictionless;
    let Some(inverse) = mobility.cholesky() else { return *frictionless };
    let wanted = normal * after.dot(&normal) - velocity;
    let stopping = inverse.solve(&wanted) - frictionless;
    // In the cone a share λ fulfils |λ T| ≤ μ (j₀ + λ N): T and N are the parts of `stopping`.
    let along = stopping.dot(&normal);
    let excess = (stopping - normal * along).norm() - friction * along;
    let limit = friction * frictionless.norm();
    let sticks = excess <= limit;
    let added = match sliding(impact, mobility, frictionless) {
        _ if sticks => stopping,
        Some(added) => added,
        None => stopping * (limit / excess),
    };
    frictionless + added * harmless_share(&added, mobility, &after, (after + velocity).dot(frictionless))
}

/// What friction adds to the frictionless impulse of bodies that slide throughout.
///
/// `None` without a slip to oppose, and where friction would press the bodies together more than it parts
/// them (n·K(n − μ t) ≤ 0, Painlevé's paradox).
fn sliding(impact: &Impact, mobility: &Mat3, frictionless: &Vec3) -> Option<Vec3> {
    const MIN: f64 = 1e-12;
    let Impact { normal, velocity, friction, .. } = *impact;
    let slip = slip(impact);
    let tangent = slip.try_normalize(MIN * velocity.norm())?;
    let direction = normal - tangent * friction;
    let (pushing, plain) = (normal.dot(&(mobility * direction)), normal.dot(&(mobility * normal)));
    if pushing <= MIN * plain {
        return None;
    }
    let added = direction * (frictionless.norm() * plain / pushing) - frictionless;
    let before = tangent.dot(&(velocity + mobility * frictionless));
    let after = before + tangent.dot(&(mobility * added));
    let reverses = before > 0.0 && after < 0.0;
    Some(if reverses { added * (before / (before - after)) } else { added })
}

/// Largest share of `added`, at most all of it, with which the collision does not add energy.
///
/// `after` is the relative velocity the frictionless impulse leaves (m/s), `twice` twice its change of energy (J).
fn harmless_share(added: &Vec3, mobility: &Mat3, after: &Vec3, twice: f64) -> f64 {
    // Twice the change of energy with a share λ is `twice` + 2 slope λ + curve λ², and `twice` ≤ 0.
    let (slope, curve) = (added.dot(after), added.dot(&(mobility * added)));
    if twice + 2.0 * slope + curve <= 0.0 {
        return 1.0;
    }
    let root = (slope * slope - curve * twice.min(0.0)).sqrt();
    let share = if slope > 0.0 { -twice / (slope + root) } else { (root - slope) / curve };
    share.clamp(0.0, 1.0)
}

#[cfg(test)]
mod tests;
