//! How bodies resist rolling.

/// How a contact resists rolling.
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
            Self::Viscous { friction } | Self::Spring { friction, .. } => friction,
        }
    }
}

/// What a torque against rolling takes.
#[derive(Clone, Copy, Debug, Default)]
pub(crate) struct RollingCoefficients {
    /// Coefficient of rolling friction μr (-).
    pub(crate) friction: f64,
    /// Squared frequency of the rolling spring over that of the normal spring (-); 0 without a spring.
    pub(crate) stiffness_ratio: f64,
    /// Share of the critical damping (-).
    pub(crate) damping_ratio: f64,
}

impl From<Rolling> for RollingCoefficients {
    fn from(rolling: Rolling) -> Self {
        let friction = rolling.friction();
        match rolling {
            Rolling::None | Rolling::Viscous { .. } => Self { friction, ..Self::default() },
            Rolling::Spring { stiffness_ratio, damping_ratio, .. } => {
                Self { friction, stiffness_ratio, damping_ratio }
            }
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
        self.stiffness_ratio > 0.0 && self.is_active()
    }
}
