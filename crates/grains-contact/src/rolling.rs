//! How bodies resist rolling.

/// How a contact resists rolling. The torque is at most μr R times the force that presses the bodies together, R the effective
/// radius R1 R2/(R1 + R2).
#[derive(Clone, Copy, Debug, Default, PartialEq)]
pub enum Rolling {
    /// Not at all.
    #[default]
    None,
    /// Torque 2 γt m R² ω against the relative angular velocity, up to its limit: a body on a slope creeps, and without
    /// tangential damping there is none.
    Viscous {
        /// Coefficient of rolling friction μr (-).
        friction: f64,
    },
    /// Spring, dashpot and slider in the angle rolled (Iwashita and Oda 1998; Ai et al. 2011, model C): bodies stand.
    Spring {
        /// Coefficient of rolling friction μr (-).
        friction: f64,
        /// Squared frequency of the rolling spring over that of the normal spring, (kr/I)/(kn/m) (-).
        stiffness_ratio: f64,
        /// Share of the critical damping (-).
        damping_ratio: f64,
    },
    /// The same with a given spring k and dashpot γ in the displacement rolled, kr = k R² (Luding 2008; LAMMPS sds).
    Given {
        /// Coefficient of rolling friction μr (-).
        friction: f64,
        /// Stiffness k (N/m).
        stiffness: f64,
        /// Dashpot γ (N s/m).
        dashpot: f64,
    },
    /// Spring with the tangential stiffness, kr = kt R², and slider without a dashpot (LIGGGHTS epsd2).
    Tangential {
        /// Coefficient of rolling friction μr (-).
        friction: f64,
    },
    /// The whole torque against the relative angular velocity, however small (Zhou et al. 1999, model A): heaps creep.
    Constant {
        /// Coefficient of rolling friction μr (-).
        friction: f64,
    },
}

impl Rolling {
    /// Spring and dashpot with the ratios that a case takes where it gives none.
    pub fn spring(friction: f64) -> Self {
        Self::Spring { friction, stiffness_ratio: 2.0 / 7.0, damping_ratio: 0.3 }
    }

    /// Coefficient of rolling friction μr (-).
    pub fn friction(&self) -> f64 {
        match *self {
            Self::None => 0.0,
            Self::Viscous { friction }
            | Self::Spring { friction, .. }
            | Self::Given { friction, .. }
            | Self::Tangential { friction }
            | Self::Constant { friction } => friction,
        }
    }
}

/// What a torque against rolling takes; a body of moment of inertia I at the radius R.
#[derive(Clone, Copy, Debug, Default)]
pub(crate) struct RollingCoefficients {
    /// Coefficient of rolling friction μr (-).
    pub(crate) friction: f64,
    /// Whether rolling winds a spring.
    pub(crate) has_spring: bool,
    /// Squared frequency of the rolling spring over that of the normal spring (-), and share of the critical damping (-).
    pub(crate) stiffness_ratio: f64,
    pub(crate) damping_ratio: f64,
    /// Spring over R² (N/m): given, and as a share of the tangential stiffness (-).
    pub(crate) stiffness: f64,
    pub(crate) tangential_share: f64,
    /// Dashpot over R² (N s/m): given, and as a share of the tangential dashpot (-).
    pub(crate) dashpot: f64,
    pub(crate) tangential_dashpot_share: f64,
}

impl From<Rolling> for RollingCoefficients {
    fn from(rolling: Rolling) -> Self {
        /// Dashpot (N s/m) that turns any rolling into the whole torque.
        const STIFF: f64 = 1e100;
        let plain = Self { friction: rolling.friction(), ..Self::default() };
        let spring = Self { has_spring: true, ..plain };
        match rolling {
            Rolling::None => plain,
            Rolling::Viscous { .. } => Self { tangential_dashpot_share: 1.0, ..plain },
            Rolling::Constant { .. } => Self { dashpot: STIFF, ..plain },
            Rolling::Spring { stiffness_ratio, damping_ratio, .. } => {
                Self { stiffness_ratio, damping_ratio, ..spring }
            }
            Rolling::Given { stiffness, dashpot, .. } => Self { stiffness, dashpot, ..spring },
            Rolling::Tangential { .. } => Self { tangential_share: 1.0, ..spring },
        }
    }
}

impl RollingCoefficients {
    #[inline(always)]
    pub(crate) fn is_active(&self) -> bool {
        self.friction > 0.0
    }

    /// Whether contacts keep the angle rolled.
    #[inline(always)]
    pub(crate) fn keeps_angle(&self) -> bool {
        self.has_spring && self.is_active()
    }
}
