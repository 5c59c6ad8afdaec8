//! The normal direction: one law, one file.
//!
//! A law answers with its elastic force for one approach of two bodies. Everything else is written once: damping, friction,
//! rolling and twisting build on the [`Response`], and lists, lanes, walls, ranks and restarts do not know which law it was.
//! To add a law, write its file and its line in `normal_laws!`.

mod dmt;
mod elastic_plastic;
mod hertz;
mod jkr;
mod linear;
mod sjkr;
#[cfg(test)]
mod tests;

pub use dmt::Dmt;
pub use elastic_plastic::ElasticPlastic;
pub use hertz::Hertz;
pub use jkr::{Jkr, Tear};
pub use linear::Linear;
pub use sjkr::{CohesionArea, Sjkr};

use crate::encounter::Encounter;

/// Two bodies near each other, as the law of their normal direction sees them.
#[derive(Clone, Copy, Debug)]
pub struct Approach {
    /// Overlap δ (m); negative while they are apart.
    pub overlap: f64,
    /// −dδ/dt (m/s), positive while they separate.
    pub opening: f64,
    /// Effective radius R* = R1 R2/(R1 + R2) (m); R1 against a wall.
    pub radius: f64,
    /// Time step (s).
    pub dt: f64,
}

impl Approach {
    /// That of an encounter of bodies of this effective radius (m), in steps of `dt` (s).
    #[inline(always)]
    pub fn of(encounter: &Encounter, radius: f64, dt: f64) -> Self {
        let Encounter { normal, overlap, velocity, .. } = encounter;
        Self { overlap: *overlap, opening: velocity.dot(normal), radius, dt }
    }
}

/// What a law answers in the normal direction.
#[derive(Clone, Copy, Debug)]
pub struct Response {
    /// Whether the bodies are in contact; if not they exert no force and the contact keeps nothing.
    pub is_contact: bool,
    /// Elastic force (N), attraction included; positive pushes the bodies apart.
    pub elastic: f64,
    /// The part of it that is there at once when the contact begins, and until it ends (N).
    pub jump: f64,
    /// dF/dδ of the repulsion (N/m), on which dashpot and tangential stiffness depend.
    pub stiffness: f64,
    /// Force of which friction and rolling resistance are shares (N).
    pub pressing: f64,
    /// Contact radius a (m).
    pub contact_radius: f64,
    /// The same half a step before and after (m).
    pub radii_around: [f64; 2],
    /// How far the bodies may still separate until the contact ends, or have overlapped since it began (m).
    pub margin: f64,
}

/// A law of the normal direction.
pub trait NormalLaw: Copy {
    /// Name in a case.
    const NAME: &'static str;
    /// Whether a contact keeps a number from one step to the next.
    const KEEPS_MEMORY: bool = false;
    /// Dashpot over √(m dF/dδ) per damping ratio (-): 2 for a linear spring, 2 √(5/6) for a Hertzian one, with which the bodies
    /// part with the restitution asked for; 0 where the law dissipates by itself.
    const DAMPING: f64;

    /// Whether stiffness and contact radius grow with the overlap.
    const HERTZIAN: bool = true;

    /// Force of one contact. `memory` is the number that the contact keeps, 0 before it begins.
    fn respond(&self, approach: &Approach, memory: &mut f64) -> Response;

    /// Largest gap (m) at which bodies of this effective radius (m) that touched still act on each other.
    fn reach(&self, _radius: f64) -> f64 {
        0.0
    }

    /// Largest force (N) of bodies of this effective radius (m) up to an overlap (m).
    fn force_bound(&self, radius: f64, overlap: f64) -> f64;

    /// Largest derivative of the force (N/m) where that of the repulsion is `stiffness` (N/m).
    fn steepest(&self, stiffness: f64) -> f64 {
        stiffness
    }

    /// Force that separates bodies of this effective radius (m) that touched (N).
    fn pull_off(&self, _radius: f64) -> f64 {
        0.0
    }
}

/// What is done with a law whichever it is; see [`Normal::visit`].
pub trait NormalVisitor {
    /// What comes of it.
    type Output;

    /// Does it with this law.
    fn with<L: NormalLaw>(self, law: &L) -> Self::Output;
}

/// Makes one type of the laws.
macro_rules! normal_laws {
    ($($law:ident),* $(,)?) => {
        /// A law of the normal direction, whichever it is.
        #[derive(Clone, Copy, Debug, PartialEq)]
        pub enum Normal {
            $(#[doc = concat!("See [`struct@", stringify!($law), "`].")] $law($law)),*
        }

        $(impl From<$law> for Normal {
            fn from(law: $law) -> Self {
                Self::$law(law)
            }
        })*

        impl Normal {
            /// Does something with the law, compiled for each.
            #[inline(always)]
            pub fn visit<V: NormalVisitor>(&self, visitor: V) -> V::Output {
                match self { $(Self::$law(law) => visitor.with(law)),* }
            }

            /// See [`NormalLaw::NAME`].
            pub fn name(&self) -> &'static str {
                match self { $(Self::$law(_) => $law::NAME),* }
            }

            /// See [`NormalLaw::KEEPS_MEMORY`].
            pub fn keeps_memory(&self) -> bool {
                match self { $(Self::$law(_) => $law::KEEPS_MEMORY),* }
            }

            /// See [`NormalLaw::HERTZIAN`].
            pub fn is_hertzian(&self) -> bool {
                match self { $(Self::$law(_) => $law::HERTZIAN),* }
            }

            /// See [`NormalLaw::DAMPING`].
            pub(crate) fn damping(&self) -> f64 {
                match self { $(Self::$law(_) => $law::DAMPING),* }
            }

            /// See [`NormalLaw::respond`].
            #[inline(always)]
            pub fn respond(&self, approach: &Approach, memory: &mut f64) -> Response {
                match self { $(Self::$law(law) => law.respond(approach, memory)),* }
            }

            /// See [`NormalLaw::reach`].
            pub fn reach(&self, radius: f64) -> f64 {
                match self { $(Self::$law(law) => law.reach(radius)),* }
            }

            /// See [`NormalLaw::force_bound`].
            pub fn force_bound(&self, radius: f64, overlap: f64) -> f64 {
                match self { $(Self::$law(law) => law.force_bound(radius, overlap)),* }
            }

            /// See [`NormalLaw::steepest`].
            pub(crate) fn steepest(&self, stiffness: f64) -> f64 {
                match self { $(Self::$law(law) => law.steepest(stiffness)),* }
            }

            /// See [`NormalLaw::pull_off`].
            pub fn pull_off(&self, radius: f64) -> f64 {
                match self { $(Self::$law(law) => law.pull_off(radius)),* }
            }
        }
    };
}

normal_laws!(Linear, Hertz, Dmt, Jkr, Sjkr, ElasticPlastic);
