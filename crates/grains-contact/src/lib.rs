//! Contact laws: forces as pure functions of the relative motion of two bodies at one contact.
//!
//! The same [`Coefficients::force`] serves particle against particle, wall and mesh; a wall is a body of
//! infinite mass. Nothing here knows of cells, ranks or arrays of particles.
//!
//! Conventions: the normal n points from body 1 to body 2, the overlap δ is positive in contact, the
//! relative velocity is Vr = V2 − V1 at the contact point, so dδ/dt = −Vr·n. Forces are those on body 1.
//! The dashpot may pull near the end of a contact (no clipping), as the closed forms of
//! [`Collision`] assume.
//!
//! Some laws act at a distance, between two radii and a gap: [`LiquidBridge`], [`VanDerWaals`]; and a [`Bond`] joins two bodies.
//!
//! Bodies that do not deform meet by impulses instead: [`ImpulseScheme`].
//!
//! References: Rakotonirina 2016, ch. 3, eqs 3.17-3.27 ("thesis"); Wachs 2009, eqs 13-17; Srinivasan 2019,
//! ch. 3 and app. A.

#![cfg_attr(not(test), warn(clippy::disallowed_methods))]

mod attraction;
mod bond;
mod collision;
mod conduction;
mod contact_patch;
mod couple;
mod cube_root;
mod elasticity;
mod encounter;
mod impulse;
mod law;
mod liquid_bridge;
mod lubrication;
mod normal;
mod rolling;
mod sharing;
mod step_share;
mod tangential;
mod twisting;
mod van_der_waals;

pub use attraction::{Attraction, Neighbourhood};
pub use bond::{BeamShear, Bond, BondLoad, BondState, BondedPair, Section, Stiffness, Strength, Stress};
pub use collision::Collision;
pub use conduction::{Conduction, GasLens, patch_radius};
pub use couple::{RollingContact, WoundAngles};
pub use elasticity::{Elastic, effective_modulus, effective_shear_modulus, work_of_adhesion};
pub use encounter::Encounter;
pub use impulse::{Impact, ImpulseScheme, Mobility};
pub use law::{Coefficients, ContactLaw, Damping, PreparedLaw, reduced_mass};
pub use liquid_bridge::{
    BridgeChange, BridgeEnd, BridgeViscosity, Capillary, Film, FilmAmount, FilmShare, FilmSupply, Formation,
    LiquidBridge, Rabinovich, Rupture, Supply, Willett, WillettShort, film_thickness, halves, sphere_radius,
    whole_quanta,
};
pub use lubrication::Lubrication;
pub use normal::{
    Approach, CohesionArea, Dmt, ElasticPlastic, Hertz, Jkr, Linear, Normal, NormalLaw, NormalVisitor,
    Response, Sjkr, Tear,
};
pub use rolling::Rolling;
pub use sharing::Sharing;
pub use tangential::{Memory, Tangential};
pub use twisting::Twisting;
pub use van_der_waals::VanDerWaals;
