//! Verlet lists with a skin per particle, built from linked cells.
//!
//! A particle may move by its *reach* before the lists must be rebuilt; fast particles get a larger reach,
//! so that a few falling grains do not force a dense bed to rebuild. Reaches, and so the times of rebuilds,
//! cannot change a result: a pair remembers something only while its positions in consecutive steps say so.

mod allowances;
mod cell_list;
mod list_context;
mod lists;
mod pair_search;
mod save_history;
mod skin;
mod wall_search;
mod work;

pub(crate) use cell_list::{Sorted, widest};
pub(crate) use list_context::Surroundings;
pub(crate) use lists::{Inner, Neighbours};
pub(crate) use skin::Reference;
pub use skin::Skin;
