//! The granular phase: particles, walls, Verlet lists, contact forces and the leap-frog step.
//!
//! # Flow of one step
//!
//! ```text
//! refresh     own lists stale: migrate, sort by cell, clone, rebuild     otherwise: send what clones need
//! add_forces  pairs within the rank | walls | wait for the clones | pairs with clones; one load per particle
//! advance     kick, drift, and the velocity of the next contact evaluation
//! ```
//!
//! # Where things are
//!
//! ```text
//! dem            state of one rank, its step, rebuild and observation
//! particles      a particle as contacts see it, the arrays, and the records in which particles travel
//! verlet         cell lists, Verlet lists, skin, and the contact history saved from them
//! exchange       migration, clones, and their updates
//! films          liquid on particles and in bridges: shared out, given back, counted
//! heat           temperatures, heat through contacts, gaps and from walls
//! bonds          bonds between particles: made, found again, loads
//! contacts       loads of a contact, batches in lanes, exact sums; spheres
//! narrow_phase   convex parts where they are, distance, separating planes, contact patches
//! non_spherical  contacts between particles that are not both spheres
//! walls          surfaces, their motion, and contacts with them
//! hard           collisions by impulses
//! ```
//!
//! # Whom a step waits for
//!
//! For its neighbours. Each rank rebuilds its lists when its own particles need it; neighbours take its new clones and rebuild the lists of
//! their pairs with clones alone. A pair is listed by where its particles were when their owners last rebuilt, and how far each may go from
//! there. Errors and stops are agreed on by reductions that are read later.
//!
//! # Data
//!
//! Position, velocity, angular velocity, radius and mass of a particle share one 96-byte [`Body`], because a contact
//! needs all of them of a neighbour that is not in cache. Data of the owner alone lives in separate arrays. Particles
//! are sorted by size class and cell, owned ones first, clones after. A pair of spheres is one 32-byte record:
//! indices and tangential displacement. Touching pairs of spheres are evaluated several at a time. A pair of parts of
//! other particles holds a separating plane and the path that the two may travel before it is checked again; the
//! history of touching pairs is stored apart. Distances of ellipsoids, cylinders and boxes that touched are found several
//! at a time.
//! A pair with an element of a wall holds the way that its particle may go, as seen from the wall, before it is looked at again:
//! so motions of walls need no bound, and a triangle that owns no minimum of the distance is left alone as long as that lasts.
//!
//! # Same bits on any number of ranks
//!
//! * Positions are multiples of a power of two, so separations are exact in every periodic image.
//! * Every contribution to a force or torque is rounded to a quantum of which sums are exact, so the
//!   order of contacts, and with it the number of ranks and the order of particles, cannot matter.
//! * Contact history (tangential displacement, GJK simplex) lives only while a pair touches, with a wall while it is
//!   near, in consecutive steps, which the positions alone decide; so it does not matter when lists are rebuilt,
//!   where a particle lives, or where a run was stopped and continued.
//! * Images of a sheared box slide by multiples of the quantum of positions, and velocities along the flow are multiples of a
//!   quantum as well, so both sides of the border see the same separations and relative velocities. A particle crosses in the
//!   step in which it meets the border.
//! * The force on a wall that a load moves is summed exactly over all ranks.
//! * Flows of heat are rounded as forces are.
//! * Volumes of liquid are whole quanta. Bridges claim shares of films as they were at the beginning of a step, and take them in the next.
//!
//! # Hard collisions
//!
//! With [`CollisionModel::Hard`] `add_forces` gives impulses instead of loads, in an order that depends on the
//! identities of the bodies alone.
//!
//! References: Rakotonirina 2016 ("thesis"), ch. 3 and ch. 5; Wachs 2009; Srinivasan 2019, ch. 3.

#![cfg_attr(not(test), warn(clippy::disallowed_methods))]

mod bonds;
mod catalogue;
mod clock;
mod contact_history;
mod contacts;
mod dem;
mod error;
mod exchange;
mod films;
mod flow_planes;
mod hard;
mod heat;
mod history_check;
mod insertion;
mod integrate;
mod lubrication;
mod memory_use;
mod mobility;
mod narrow_phase;
mod non_spherical;
mod particles;
mod periodic_images;
mod prescribed;
mod rotation;
mod shear;
mod stress;
mod totals;
mod tunnelling;
mod verlet;
mod walls;

pub use bonds::{BondKind, BondLedger, BondRadius, Bonded};
pub use catalogue::{Catalogue, ContactTable, FaceContact};
pub use clock::{Clock, Phase};
pub use contact_history::{renumber_walls, without_bridges};
pub use dem::{
    Dem, DemSetup, Failure, Ledger, Origin, Partner, Passages, Species, SpeciesContent, SpeciesLedger,
    StepReport, Touch,
};
pub use error::StepError;
pub use exchange::{ExchangeStrategy, Traffic};
pub use films::{BodyFilm, FILM_LENGTH, Liquid, LiquidLedger, MaterialFilms};
pub use flow_planes::{Crossings, FlowPlane};
pub use hard::{CollisionModel, HardModel};
pub use heat::{Heat, HeatLedger, Thermal};
pub use history_check::HistoryBounds;
pub use insertion::{NewParticle, Occupancy, is_wall_in_the_way};
pub use integrate::{StepParameters, half_step_back, other_half_step};
pub use memory_use::MemoryUse;
pub use mobility::SurfaceMobility;
pub use particles::{Body, CARGO_LENGTH, Cargo, Kind, Load, ParticleRecord, Particles};
pub use prescribed::PrescribedMotion;
pub use shear::Shear;
pub use stress::{Stress, StressSums};
pub use totals::Totals;
pub use verlet::Skin;
pub use walls::{
    Loading, Motion, MotionTable, OpenTube, Surface, Travel, Wall, WallHeat, WallLoad, WallPlace, WallState,
    Wear, WornElement, WornWall,
};
