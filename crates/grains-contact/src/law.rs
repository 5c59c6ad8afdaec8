//! The damped linear spring with Coulomb friction and rolling resistance.

use nalgebra::Vector3;

type Vec3 = Vector3<f64>;

/// Kinematics of one contact, with the normal from body 1 to body 2.
#[derive(Clone, Copy, Debug)]
pub struct Contact {
    /// Unit normal from body 1 to body 2 (-).
    pub normal: Vec3,
    /// Overlap δ (m), positive in contact.
    pub overlap: f64,
    /// Relative velocity V2 − V1 at the contact point (m/s).
    pub velocity: Vec3,
}

/// Reduced mass of a pair of bodies, M1 M2/(M1 + M2) (kg); M1 against a wall.
#[inline(always)]
pub fn reduced_mass(mass_1: f64, mass_2: f64) -> f64 {
    mass_1 * mass_2 / (mass_1 + mass_2)
}

/// The coefficients of a law for one reduced mass, computed once for bodies of equal masses.
#[derive(Clone, Copy, Debug)]
pub struct Coefficients {
    pub(crate) stiffness: f64,
    /// 2 γn m (N s/m).
    pub(crate) dashpot: f64,
    pub(crate) tangential_stiffness: f64,
    /// 2 γt m (N s/m).
    pub(crate) tangential_dashpot: f64,
    pub(crate) friction: f64,
    pub(crate) rolling_friction: f64,
}

/// How a contact resists sliding.
#[derive(Clone, Copy, Debug, PartialEq)]
pub enum Tangential {
    /// Memoryless viscous force −2 γt m Urt, capped by friction (thesis eqs 3.20-3.21).
    Viscous {
        /// Rate γt (1/s).
        rate: f64,
    },
    /// Spring and dashpot, capped by friction (Wachs 2009, eqs 15-17).
    Spring {
        /// Tangential over normal stiffness kt/kn (-).
        stiffness_ratio: f64,
        /// Tangential over normal damping rate γt/γn (-).
        damping_ratio: f64,
    },
}

/// Contact law of one pair of materials.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct ContactLaw {
    /// Normal stiffness kn (N/m).
    pub normal_stiffness: f64,
    /// Restitution en (-), in (0, 1].
    pub restitution: f64,
    /// Coulomb friction coefficient μ (-).
    pub friction: f64,
    /// Tangential resistance.
    pub tangential: Tangential,
    /// Rolling friction coefficient (-); 0 switches rolling resistance off.
    pub rolling_friction: f64,
    damping: f64,
}

impl ContactLaw {
    /// Law with the given stiffness (N/m), restitution, friction, and tangential resistance.
    pub fn new(normal_stiffness: f64, restitution: f64, friction: f64, tangential: Tangential) -> Self {
        let log = restitution.ln();
        let damping = -log / (std::f64::consts::PI.powi(2) + log * log).sqrt();
        Self { normal_stiffness, restitution, friction, tangential, rolling_friction: 0.0, damping }
    }

    /// The same law with rolling friction switched on.
    pub fn with_rolling_friction(self, rolling_friction: f64) -> Self {
        Self { rolling_friction, ..self }
    }

    /// Damping rate γn = −ω0 ln en/√(π² + ln² en) (1/s) for a reduced mass (kg); thesis eq. 3.27.
    pub fn damping_rate(&self, reduced_mass: f64) -> f64 {
        self.damping * (self.normal_stiffness / reduced_mass).sqrt()
    }

    /// Tangential damping rate γt (1/s) for a reduced mass (kg).
    pub fn tangential_rate(&self, reduced_mass: f64) -> f64 {
        match self.tangential {
            Tangential::Viscous { rate } => rate,
            Tangential::Spring { damping_ratio, .. } => damping_ratio * self.damping_rate(reduced_mass),
        }
    }

    /// Coefficients of the law for a reduced mass (kg).
    #[inline]
    pub fn coefficients(&self, reduced_mass: f64) -> Coefficients {
        let dashpot = 2.0 * self.damping * (self.normal_stiffness * reduced_mass).sqrt();
        let (tangential_stiffness, tangential_dashpot) = match self.tangential {
            Tangential::Viscous { rate } => (0.0, 2.0 * rate * reduced_mass),
            Tangential::Spring { stiffness_ratio, damping_ratio } => {
                (stiffness_ratio * self.normal_stiffness, damping_ratio * dashpot)
            }
        };
        Coefficients {
            stiffness: self.normal_stiffness,
            dashpot,
            tangential_stiffness,
            tangential_dashpot,
            friction: self.friction,
            rolling_friction: self.rolling_friction,
        }
    }
}

impl Coefficients {
    /// Force on body 1 (N): F1 = −(kn δ + 2 γn m dδ/dt) n + Ft, with |Ft| ≤ μ kn δ.
    ///
    /// `spring` is the tangential displacement ξ (m) of the contact, zero when it begins; it is turned
    /// into the contact plane, advanced by Vrt `dt`, and shortened while the contact slides so that
    /// kt ξ + 2 γt m Vrt stays on the friction cone (Wachs 2009, eqs 15-17; errata W09-2). Without a
    /// tangential stiffness the force is the memoryless one of thesis eqs 3.20-3.21 and ξ stays zero.
    #[inline(always)]
    pub fn force(&self, contact: &Contact, spring: &mut Vec3, dt: f64) -> Vec3 {
        let Contact { normal, overlap, velocity } = *contact;
        let opening = velocity.dot(&normal);
        let elastic = self.stiffness * overlap;
        let normal_force =
            normal * (self.dashpot * share_in_contact(overlap, opening, dt) * opening - elastic);
        let sliding = velocity - normal * opening;
        let viscous = sliding * self.tangential_dashpot;
        let limit = self.friction * elastic;
        if self.tangential_stiffness == 0.0 {
            return normal_force + capped(viscous, limit).0;
        }
        let mut stretched = *spring + sliding * dt;
        stretched -= normal * stretched.dot(&normal);
        let (force, slides) = capped(stretched * self.tangential_stiffness + viscous, limit);
        *spring = if slides { (force - viscous) / self.tangential_stiffness } else { stretched };
        normal_force + force
    }

    /// Whether bodies resist rolling.
    #[inline(always)]
    pub fn resists_rolling(&self) -> bool {
        self.rolling_friction > 0.0
    }

    /// Rolling resistance on body 1 (N m): against the relative spin ω1 − ω2, at most μr R kn δ.
    ///
    /// `spin` is ω1 − ω2 (rad/s), `arm` the effective radius R1 R2/(R1 + R2) (m), R1 against a wall.
    /// Below the cap the torque is viscous, 2 γt m R² (ω1 − ω2), so that a body at rest stays at rest.
    #[inline(always)]
    pub fn rolling_torque(&self, contact: &Contact, spin: &Vec3, arm: f64) -> Vec3 {
        let viscous = -spin * (self.tangential_dashpot * arm * arm);
        capped(viscous, self.rolling_friction * arm * self.stiffness * contact.overlap).0
    }
}

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

/// The vector shortened to `limit` if it is longer, and whether it was.
#[inline(always)]
fn capped(vector: Vec3, limit: f64) -> (Vec3, bool) {
    let square = vector.norm_squared();
    if square > limit * limit { (vector * (limit / square.sqrt()), true) } else { (vector, false) }
}
