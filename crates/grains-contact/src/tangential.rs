//! How contacts resist sliding.

use nalgebra::Vector3;
use schemars::JsonSchema;
use serde::{Deserialize, Serialize};

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
        /// Tangential over normal stiffness, kt over dF/dδ (-).
        stiffness_ratio: f64,
        /// Tangential over normal damping rate γt/γn (-).
        damping_ratio: f64,
    },
    /// Memoryless force −(kt τc + ηt) Urt: the displacement is taken for that of a whole contact at the
    /// present speed, τc Urt (Srinivasan 2019, eqs 3.43-3.47; errata S19-22, S19-23).
    ///
    /// τc is the contact time of a pair under linear springs and ηt = 2 γ √(m kt), γ the damping ratio of the normal direction.
    /// Without a history there is no static friction. The cap is μ |Fn| with the dashpot in Fn (eq. 3.47), where
    /// the other laws take μ times the elastic force. The form with a history, eq. 3.42, is [`Tangential::Spring`] with a damping
    /// ratio √(kt/kn), but for that cap.
    ContactTime {
        /// Tangential over normal stiffness kt/kn (-).
        stiffness_ratio: f64,
    },
    /// Spring of stiffness 8 G* a and dashpot, for Hertzian contacts: kt is the share 4 G*/E* of dF/dδ (Mindlin 1949).
    Mindlin {
        /// 4 G*/E* (-).
        stiffness_ratio: f64,
        /// Tangential over normal damping rate γt/γn (-).
        damping_ratio: f64,
        /// What a change of the contact radius does to the force.
        memory: Memory,
    },
}

impl Tangential {
    /// Damping ratio with which both directions have the same share of the critical, √(kt/(dF/dδ)).
    pub fn equal_damping(stiffness_ratio: f64) -> f64 {
        stiffness_ratio.sqrt()
    }
}

/// What a contact remembers of its sliding while its radius a, and with it the tangential stiffness, changes.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq, Serialize, Deserialize, JsonSchema)]
#[serde(rename_all = "snake_case")]
pub enum Memory {
    /// The force while the bodies approach, the displacement while they part, so that the force falls with the radius
    /// (Thornton, Cummins and Cleary 2013; LAMMPS mindlin_rescale/force): no cycle gains energy.
    #[default]
    ForceRescaled,
    /// The force (LAMMPS mindlin/force).
    Force,
    /// The displacement (LAMMPS mindlin): a force grows with the load without any slip.
    Displacement,
    /// The displacement, which falls with the radius while the bodies part (LAMMPS mindlin_rescale).
    DisplacementRescaled,
}

impl Memory {
    /// Exponents p of the displacement ξ ∝ a^−p that leaves what is remembered as it is, while the bodies approach and part.
    pub(crate) fn exponents(self) -> [f64; 2] {
        match self {
            Self::ForceRescaled => [1.0, 0.0],
            Self::Force => [1.0, 1.0],
            Self::Displacement => [0.0, 0.0],
            Self::DisplacementRescaled => [0.0, -1.0],
        }
    }
}

/// a^p of a ratio of radii for p of −1, 0 or 1.
#[inline(always)]
pub(crate) fn power(ratio: [f64; 2], exponent: f64) -> f64 {
    let [above, below] = ratio;
    if exponent > 0.0 {
        above / below
    } else if exponent < 0.0 {
        below / above
    } else {
        1.0
    }
}

/// Whether a vector is longer than `limit`, and its share that is not.
#[inline(always)]
pub(crate) fn on_cone(vector: &Vector3<f64>, limit: f64) -> (bool, f64) {
    let square = vector.norm_squared();
    (square > limit * limit, limit / square.sqrt())
}
