//! Walls: surfaces with a material, fixed or moving, present for all or part of a run.

mod contacts;
mod facets;
mod list;
mod loading;
mod loads;
mod motion;
mod open_tube;
mod pairs;
mod seams;
mod sphere_batch;
mod surface;
mod surface_contact;
mod table;
mod wall;
mod wall_point;
mod wear;

pub(crate) use contacts::{WallMeeting, for_each_contact, meet, not_found};
pub(crate) use facets::{facet_element, may_stand, stands, triangle_of_facet};
pub(crate) use list::{WallList, apart_until};
pub use loading::{Loading, Travel};
pub(crate) use loads::add_forces;
pub use motion::{Motion, WallPlace, WallState};
pub use open_tube::OpenTube;
pub(crate) use pairs::{WallPair, WallScene};
pub use surface::Surface;
pub use table::MotionTable;
pub(crate) use wall::WallSums;
pub use wall::{Wall, WallHeat, WallLoad};
pub(crate) use wear::SlidingSums;
pub use wear::{Wear, WornElement, WornWall};
