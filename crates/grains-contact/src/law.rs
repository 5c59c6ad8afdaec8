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
    /// Reduced mass (kg): M1 M2/(M1+M2), or M1 against a wall.
    pub reduced_mass: f64,
}

/// Reduced mass of a pair of bodies, M1 M2/(M1 + M2) (kg).
#[inline(always)]
pub fn reduced_mass(mass_1: f64, mass_2: f64) -> f64 {
    mass_1 * mass_2 / (mass_1 + mass_2)
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

    /// Force on body 1 (N): F1 = −(kn δ + 2 γn m dδ/dt) n + Ft, with |Ft| ≤ μ kn δ.
    ///
    /// `spring` is the tangential displacement ξ (m) of the contact, zero when it begins; it is turned
    /// into the contact plane, advanced by Vrt `dt`, and shortened while the contact slides so that
    /// kt ξ + 2 γt m Vrt stays on the friction cone (Wachs 2009, eqs 15-17; errata W09-2).
    #[inline(always)]
    pub fn force(&self, contact: &Contact, spring: &mut Vec3, dt: f64) -> Vec3 {
        let Contact { normal, overlap, velocity, reduced_mass } = *contact;
        let opening = velocity.dot(&normal);
        let elastic = self.normal_stiffness * overlap;
        let dashpot = 2.0 * self.damping * (self.normal_stiffness * reduced_mass).sqrt();
        let normal_force = normal * (dashpot * opening - elastic);
        let sliding = velocity - normal * opening;
        let limit = self.friction * elastic;
        let tangential_force = match self.tangential {
            Tangential::Viscous { rate } => capped(sliding * (2.0 * rate * reduced_mass), limit).0,
            Tangential::Spring { stiffness_ratio, damping_ratio } => {
                let stiffness = stiffness_ratio * self.normal_stiffness;
                let viscous = sliding * (damping_ratio * dashpot);
                *spring += sliding * dt;
                *spring -= normal * spring.dot(&normal);
                let (force, slides) = capped(*spring * stiffness + viscous, limit);
                if slides && stiffness > 0.0 {
                    *spring = (force - viscous) / stiffness;
                }
                force
            }
        };
        normal_force + tangential_force
    }

    /// Rolling resistance on body 1 (N m): against the relative spin ω1 − ω2, at most μr R kn δ.
    ///
    /// `spin` is ω1 − ω2 (rad/s), `arm` the effective radius R1 R2/(R1 + R2) (m), R1 against a wall.
    /// Below the cap the torque is viscous, 2 γt m R² (ω1 − ω2), so that a body at rest stays at rest.
    #[inline(always)]
    pub fn rolling_torque(&self, contact: &Contact, spin: &Vec3, arm: f64) -> Vec3 {
        let rate = self.tangential_rate(contact.reduced_mass);
        let viscous = -spin * (2.0 * rate * contact.reduced_mass * arm * arm);
        capped(viscous, self.rolling_friction * arm * self.normal_stiffness * contact.overlap).0
    }
}

/// The vector shortened to `limit` if it is longer, and whether it was.
#[inline(always)]
fn capped(vector: Vec3, limit: f64) -> (Vec3, bool) {
    let square = vector.norm_squared();
    if square > limit * limit { (vector * (limit / square.sqrt()), true) } else { (vector, false) }
}
