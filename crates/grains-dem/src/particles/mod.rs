//! The particles of one rank, and the records in which they travel.

mod body;
mod record;
mod store;

pub use body::{Body, CARGO_LENGTH, Cargo, Kind, Load};
pub use record::ParticleRecord;
pub(crate) use record::{
    CLONE_LENGTH, Image, SPHERE_UPDATE_LENGTH, UPDATE_LENGTH, clone_update, read_clone, read_motion,
    read_orientation, write_clone,
};
pub use store::Particles;
