//! The particles of one rank, and the records in which they travel.

mod body;
mod record;
mod store;

pub use body::{Body, CARGO_LENGTH, Cargo, Kind, Load};
pub use record::ParticleRecord;
pub(crate) use record::{
    CLONE_LENGTH, NEWS_LENGTH, NEWS_OF_SPHERES, news, read_clone, read_motion, read_orientation, write_clone,
};
pub use store::Particles;
