//! The granular phase: particles, walls, neighbour lists, contact forces and the leap-frog step.
//!
//! # Flow of one step
//!
//! ```text
//! refresh     stale lists: migrate, sort by cell, clone, rebuild     otherwise: send what clones need
//! add_forces  pairs within the rank | walls | wait for the clones | pairs with clones; one load per particle
//! advance     kick, drift, and the velocity of the next contact evaluation
//! ```
//!
//! # Data
//!
//! A particle's position, velocity, spin, radius and mass sit in one 96-byte [`Body`], because a contact
//! needs all of them of a neighbour that is not in cache; what only the owner needs lives in separate
//! arrays. Particles are sorted by class of sizes and cell, owned ones first, clones after. A pair of spheres is one
//! 32-byte record, neighbour and tangential spring, read in sequence; those that touch are worked on several at a time. A pair of other bodies is a plane that parts them and
//! how far the two may go before it is looked at again; what touching pairs remember lies apart.
//!
//! # Same bits on any number of ranks
//!
//! * Positions are multiples of a power of two, so separations are exact in every periodic image.
//! * Every contribution to a force or torque is rounded to a lattice on which sums are exact, so the
//!   order of contacts, and with it the number of ranks and the order of particles, cannot matter.
//! * What a pair remembers (tangential spring, GJK simplex) lives only while it touches, with a wall while it is
//!   near, in consecutive steps, which the positions alone decide; so it does not matter when lists are rebuilt,
//!   where a particle lives, or where a run was stopped and continued.
//!
//! # Hard collisions
//!
//! With [`CollisionModel::Hard`] `add_forces` gives impulses instead of loads, in an order that depends on the
//! identities of the bodies alone.
//!
//! References: Rakotonirina 2016 ("thesis"), ch. 3 and ch. 5; Wachs 2009; Srinivasan 2019, ch. 3.

mod bodies;
mod catalogue;
mod clock;
mod columns;
mod dem;
mod error;
mod exchange;
mod forces;
mod guide;
mod hard;
mod images;
mod insertion;
mod integrate;
mod lubrication;
mod measure;
mod memory;
mod mobility;
mod neighbours;
mod passing;
mod record;
mod rotation;
mod spheres;
mod store;
mod updates;
mod walls;

pub use catalogue::{Catalogue, ContactTable, FaceContact, Kind};
pub use clock::{Clock, Phase};
pub use dem::{Dem, DemSetup, Failure, Ledger, MemoryUse, Origin, Partner, Passages, StepReport, Touch};
pub use error::StepError;
pub use guide::Guide;
pub use hard::{CollisionModel, HardModel};
pub use insertion::{NewParticle, Occupancy, wall_in_the_way};
pub use integrate::{Rates, half_step_back, inertia, other_half_step};
pub use measure::{FlowPlane, Totals};
pub use memory::renumber_walls;
pub use mobility::SurfaceMobility;
pub use neighbours::Skin;
pub use record::ParticleRecord;
pub use store::{Body, CARGO_LENGTH, Cargo, Load, Particles};
pub use updates::{ExchangeStrategy, Traffic};
pub use walls::{Motion, MotionTable, OpenTube, Surface, Wall, WallLoad, WallPlace, WallState};
