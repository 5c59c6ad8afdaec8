//! Verlet lists with a skin per particle, built from linked cells.
//!
//! A particle may move by its *allowance* before the lists must be rebuilt; fast particles get a larger allowance,
//! so that a few falling grains do not force a dense bed to rebuild. Allowances, and so the times of rebuilds,
//! cannot change a result: a contact keeps its history only while its positions in consecutive steps say so.

mod cell_list;
mod list_context;
mod lists;
mod pair_search;
mod references;
mod save_history;
mod skin;
mod wall_search;
mod work;

pub(crate) use cell_list::{CellList, cutoffs, sort};
pub(crate) use list_context::ListContext;
pub(crate) use lists::{Inner, RestingPairs, VerletLists};
pub(crate) use pair_search::BondChanges;
pub(crate) use references::{Reference, References, Stray};
pub(crate) use save_history::Extent;
pub use skin::Skin;
