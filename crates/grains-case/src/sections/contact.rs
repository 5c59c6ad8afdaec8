//! `[[contact]]`: the contact law of a pair of materials.

use schemars::JsonSchema;
use serde::{Deserialize, Serialize};

use crate::check::{Checker, Names};

/// How a contact resists sliding; friction caps the force either way.
#[derive(Clone, Copy, Debug, PartialEq, Serialize, Deserialize, JsonSchema)]
#[serde(tag = "kind", rename_all = "snake_case", deny_unknown_fields)]
pub enum Tangential {
    /// Spring and dashpot with a memory of the displacement (Wachs 2009, eqs 15-17).
    Spring {
        /// Tangential over normal stiffness k_t/k_n (-); 2/7 gives equal periods for spheres.
        #[serde(default = "two_sevenths")]
        #[schemars(extend("exclusiveMinimum" = 0, "x-plausible" = [0.01, 2]))]
        stiffness_ratio: f64,
        /// Tangential over normal damping rate γ_t/γ_n (-).
        #[serde(default = "half")]
        #[schemars(extend("minimum" = 0, "x-plausible" = [0, 10]))]
        damping_ratio: f64,
    },
    /// Memoryless viscous force −2 γ_t m v_t (Rakotonirina 2016, eqs 3.20-3.21).
    Viscous {
        /// Tangential damping rate γ_t (1/s).
        #[schemars(extend("minimum" = 0))]
        gamma_t: f64,
    },
    /// Memoryless force −(k_t τ_c + η_t) v_t, τ_c the contact time (Srinivasan 2019, eqs 3.43-3.47).
    ContactTime {
        /// Tangential over normal stiffness k_t/k_n (-).
        #[serde(default = "two_sevenths")]
        #[schemars(extend("exclusiveMinimum" = 0, "x-plausible" = [0.01, 2]))]
        stiffness_ratio: f64,
    },
}

/// How a contact resists rolling, up to a torque of the rolling friction.
#[derive(Clone, Copy, Debug, PartialEq, Serialize, Deserialize, JsonSchema)]
#[serde(tag = "kind", rename_all = "snake_case", deny_unknown_fields)]
pub enum Rolling {
    /// Spring and dashpot with a memory of the angle rolled: bodies stand on slopes (Ai et al. 2011, model C).
    Spring {
        /// Squared frequency of the rolling spring over that of the normal spring (-).
        #[serde(default = "two_sevenths")]
        #[schemars(extend("exclusiveMinimum" = 0, "maximum" = 1, "x-plausible" = [0.01, 1]))]
        stiffness_ratio: f64,
        /// Share of the critical damping (-).
        #[serde(default = "rolling_damping")]
        #[schemars(extend("minimum" = 0, "maximum" = 1))]
        damping_ratio: f64,
    },
    /// Memoryless viscous torque −2 γ_t m R² ω: bodies creep down slopes.
    Viscous {},
}

impl Default for Rolling {
    fn default() -> Self {
        Self::Spring { stiffness_ratio: two_sevenths(), damping_ratio: rolling_damping() }
    }
}

fn rolling_damping() -> f64 {
    0.3
}

fn two_sevenths() -> f64 {
    2.0 / 7.0
}

fn half() -> f64 {
    0.5
}

impl Default for Tangential {
    fn default() -> Self {
        Self::Spring { stiffness_ratio: two_sevenths(), damping_ratio: half() }
    }
}

/// The law between two materials: linear spring and dashpot, Coulomb friction, rolling resistance.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize, JsonSchema)]
#[serde(deny_unknown_fields)]
#[schemars(rename = "Contact")]
pub struct Contact<Name = usize> {
    /// The two materials, in any order; the same one twice for a material with itself.
    pub between: [Name; 2],
    /// Normal stiffness k_n (N/m); soft collisions need it, hard ones do without.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    #[schemars(extend("exclusiveMinimum" = 0, "x-plausible" = [1e2, 1e11]))]
    pub normal_stiffness: Option<f64>,
    /// Coefficient of restitution e_n (-); 1 is perfectly elastic, 0.1 very dissipative.
    #[schemars(extend("exclusiveMinimum" = 0, "maximum" = 1, "x-plausible" = [0.05, 1]))]
    pub restitution: f64,
    /// Coulomb friction coefficient (-).
    #[schemars(extend("minimum" = 0, "x-plausible" = [0, 2]))]
    pub friction: f64,
    /// Resistance to sliding.
    #[serde(default)]
    pub tangential: Tangential,
    /// Rolling friction coefficient (-): rolling torque over (effective radius × normal force).
    #[serde(default)]
    #[schemars(extend("minimum" = 0, "x-plausible" = [0, 1]))]
    pub rolling_friction: f64,
    /// Resistance to rolling below that torque.
    #[serde(default)]
    pub rolling: Rolling,
}

impl<Name> Contact<Name> {
    /// Whether rolling resistance is that of a tangential damping which is zero.
    pub(crate) fn is_rolling_undamped(&self) -> bool {
        let is_undamped = match self.tangential {
            Tangential::Spring { damping_ratio, .. } => damping_ratio == 0.0 || self.restitution == 1.0,
            Tangential::Viscous { gamma_t } => gamma_t == 0.0,
            Tangential::ContactTime { .. } => false,
        };
        matches!(self.rolling, Rolling::Viscous {}) && is_undamped
    }

    /// The same contact with its two materials named otherwise.
    pub(crate) fn rename<Other>(self, mut name: impl FnMut(usize, Name) -> Other) -> Contact<Other> {
        let Self { between, normal_stiffness, restitution, friction, tangential, rolling_friction, rolling } =
            self;
        let mut side = 0..;
        let between = between.map(|n| name(side.next().unwrap_or_default(), n));
        Contact { between, normal_stiffness, restitution, friction, tangential, rolling_friction, rolling }
    }
}

/// Resolves the names and refuses a pair that is described twice.
pub(crate) fn check(raw: Vec<Contact<String>>, names: &Names, checker: &mut Checker) -> Vec<Contact> {
    let mut contacts: Vec<Contact> = Vec::new();
    for (i, contact) in raw.into_iter().enumerate() {
        let errors_before = checker.error_count();
        let contact = contact.rename(|side, name| {
            checker.reference(&format!("contact[{i}].between[{side}]"), &name, "material", &names.materials)
        });
        if let Some(first) = find(&contacts, contact.between[0], contact.between[1])
            && checker.error_count() == errors_before
        {
            checker.error(
                &format!("contact[{i}].between"),
                format!("this pair is already described by contact[{first}]; remove one of them"),
            );
        }
        contacts.push(contact);
    }
    contacts
}

/// Index of the law between two materials, in either order.
pub(crate) fn find(contacts: &[Contact], a: usize, b: usize) -> Option<usize> {
    contacts.iter().position(|c| c.between == [a, b] || c.between == [b, a])
}
