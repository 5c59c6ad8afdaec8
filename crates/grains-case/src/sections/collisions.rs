//! `[collisions]`: whether bodies deform when they meet.

use schemars::JsonSchema;
use serde::{Deserialize, Serialize};

use crate::check::Checker;
use crate::sections::contact::Contact;
use crate::sections::contact_law::Attraction;

/// What happens when bodies meet.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq, Serialize, Deserialize, JsonSchema)]
#[serde(rename_all = "snake_case")]
pub enum Model {
    /// They overlap, and the overlap makes a force.
    #[default]
    Soft,
    /// They do not deform: an instant impulse (Srinivasan 2019, ch. 3.1).
    Hard,
}

/// How an impulse brings friction and restitution together.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq, Serialize, Deserialize, JsonSchema)]
#[serde(rename_all = "snake_case")]
pub enum Scheme {
    /// The normal impulse of smooth bodies, then sliding friction, as in the source.
    Sequential,
    /// Restitution as given, also with friction.
    #[default]
    Exact,
}

/// The collision model; all keys but `model` belong to the hard one.
#[derive(Clone, Debug, Default, PartialEq, Serialize, Deserialize, JsonSchema)]
#[serde(deny_unknown_fields)]
pub struct Collisions {
    /// Soft or hard collisions. Hard ones take restitution and friction of the contacts, no stiffness.
    #[serde(default)]
    pub model: Model,
    /// Scheme of the impulses of hard collisions; "exact" by default.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub scheme: Option<Scheme>,
    /// How often hard collisions work off all contacts of a step (-), 1 by default; more carry the weight of a
    /// deep bed farther per step.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    #[schemars(extend("minimum" = 1, "maximum" = 1000, "x-plausible" = [1, 50]))]
    pub sweeps: Option<u64>,
    /// Approach speed (m/s) below which hard collisions take restitution as 0; 2 |gravity| dt if absent.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    #[schemars(extend("minimum" = 0))]
    pub rest_speed: Option<f64>,
}

impl Collisions {
    /// Whether collisions are impulses.
    pub fn is_hard(&self) -> bool {
        self.model == Model::Hard
    }

    /// Spells out the defaults of hard collisions; refuses their keys for soft ones.
    pub(crate) fn check(mut self, checker: &mut Checker) -> Self {
        if self.is_hard() {
            self.scheme.get_or_insert_default();
            self.sweeps.get_or_insert(1);
            return self;
        }
        let given = [
            ("scheme", self.scheme.is_some()),
            ("sweeps", self.sweeps.is_some()),
            ("rest_speed", self.rest_speed.is_some()),
        ];
        for (key, _) in given.iter().filter(|(_, is_given)| *is_given) {
            checker.error(
                &format!("collisions.{key}"),
                "belongs to hard collisions; remove it, or set collisions.model = \"hard\"".into(),
            );
        }
        self
    }

    /// Refuses contacts without what the model needs, and warns about what it leaves out.
    pub(crate) fn check_contacts(&self, contacts: &[Contact], checker: &mut Checker) {
        for (i, contact) in contacts.iter().enumerate() {
            if self.is_hard() && contact.attraction != Attraction::None {
                checker.warn(
                    &format!("contact[{i}].attraction.kind"),
                    "has no effect: hard collisions know no forces over a gap".into(),
                );
            }
            if self.is_hard() && contact.rolling_friction > 0.0 {
                checker.warn(
                    &format!("contact[{i}].rolling_friction"),
                    "has no effect: hard collisions know no rolling resistance".into(),
                );
            } else if contact.rolling_friction > 0.0 && contact.is_rolling_undamped() {
                checker.warn(
                    &format!("contact[{i}].rolling.kind"),
                    "has no effect: \"viscous\" takes the tangential damping, which is zero; \"spring\" does without".into(),
                );
            }
        }
    }
}
