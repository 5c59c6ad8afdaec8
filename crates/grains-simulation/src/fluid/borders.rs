//! The fluid follows the borders between subdomains: cells change hands as at a restart, by messages instead of a file.

use super::FluidPhase;
use super::restart::block;
use crate::error::RunError;
use crate::insertion::KindRange;
use grains_case::Case;
use grains_comm::MpiTransport;
use grains_dem::Dem;
use grains_domain::Transport;
use grains_fluid::CellPartition;
use grains_output::{GridArray, GridBlock};
use std::convert::Infallible;
use std::time::Instant;

/// Gives each rank the cells of the fluid that lie within its borders, if they have moved; returns whether they had.
/// Collective.
///
/// # Errors
/// As of [`FluidPhase::new`].
pub fn rebalance(
    fluid: &mut Option<FluidPhase>,
    given: (&Case, &[String]),
    dem: &mut Dem,
    kinds: &[KindRange],
    transport: &MpiTransport,
) -> Result<bool, RunError> {
    let Some(outside) = fluid.take_if(|fluid| fluid.moves != dem.report.moves) else { return Ok(false) };
    *fluid = Some(outside.within_borders(given, dem, kinds, transport)?);
    Ok(true)
}

impl FluidPhase {
    /// The same fluid on the cells that the borders now give to each rank.
    fn within_borders(
        mut self,
        (case, petsc): (&Case, &[String]),
        dem: &mut Dem,
        kinds: &[KindRange],
        transport: &MpiTransport,
    ) -> Result<Self, RunError> {
        self.moves = dem.report.moves;
        let setup = &self.flow.setup;
        let now = CellPartition::new(&setup.grid, &dem.decomposition)
            .map_err(|e| RunError::case(case.about("fluid", e.to_string())))?;
        if now == setup.partition {
            return Ok(self);
        }
        let begun = Instant::now();
        self.settle_passages(transport)?;
        let setup = &self.flow.setup;
        let (cells, before) = (setup.grid.cells(), setup.partition.clone());
        let (arrays, clocks) = (self.arrays().collect(), self.clocks());
        let on_walls = self.on_walls().to_vec();
        // Nothing is held twice: the old fields go before the new ones come.
        let Self {
            flow,
            exchange,
            report,
            sampled,
            steps,
            iterations,
            seconds,
            rule,
            is_told_of_backflow,
            ..
        } = self;
        let (clock, account) = (flow.clock.clone(), exchange.map(|exchange| exchange.account));
        drop(flow);
        let arrays = exchanged(arrays, cells, (&before, &now), transport);
        let Some(mut fluid) = Self::new(case, petsc, dem, kinds, transport)? else {
            unreachable!("the case has a fluid")
        };
        let array = |name: &str, _: &GridBlock| {
            let found = arrays.iter().find(|array| array.name == name);
            Ok::<_, Infallible>(found.map_or_else(Vec::new, |array| array.values.clone()))
        };
        let Ok(()) = fluid.take(array, &clocks);
        fluid.resume(dem, transport);
        fluid.flow.clock = clock;
        if let (Some(exchange), Some(account)) = (&mut fluid.exchange, account) {
            exchange.account = account;
        }
        fluid.resume_on_walls(on_walls);
        (fluid.report, fluid.sampled, fluid.rule) = (report, sampled, rule);
        fluid.is_told_of_backflow = is_told_of_backflow;
        (fluid.steps, fluid.iterations, fluid.seconds) = (steps, iterations, seconds);
        fluid.seconds.exchange += begun.elapsed().as_secs_f64();
        Ok(fluid)
    }
}

/// The blocks that ranks have of some arrays after cells have changed hands; collective.
fn exchanged(
    arrays: Vec<GridArray>,
    cells: [usize; 3],
    (before, now): (&CellPartition, &CellPartition),
    transport: &impl Transport,
) -> Vec<GridArray> {
    let to = sharing(before, now);
    let sent = to.map(|place| {
        let blocks = arrays.iter().map(|array| (array, block(array.block.all, cells, now, place)));
        let values = blocks
            .flat_map(|(array, theirs)| common(&array.block, &theirs).map(|[own, _]| array.values[own]));
        (now.rank_at(place), values.collect())
    });
    let received = transport.exchange_sparse(sent.collect());
    let renewed = |array: GridArray| {
        let block = block(array.block.all, cells, now, now.coordinates);
        GridArray { block, values: vec![0.0; block.count()], ..array }
    };
    let mut arrays: Vec<GridArray> = arrays.into_iter().map(renewed).collect();
    for (rank, values) in received {
        let mut values = values.into_iter();
        for array in &mut arrays {
            let theirs = block(array.block.all, cells, before, before.place_of(rank));
            common(&array.block, &theirs).zip(&mut values).for_each(|([own, _], x)| array.values[own] = x);
        }
    }
    arrays
}

/// Places of the ranks that now own cells which were this rank's.
fn sharing(before: &CellPartition, now: &CellPartition) -> impl Iterator<Item = [usize; 3]> {
    let [xs, ys, zs] = [0, 1, 2].map(|a| {
        let column = before.coordinates[a];
        let own = before.starts[a][column]..before.starts[a][column + 1];
        let meets = |w: &[usize]| w[0] < own.end && own.start < w[1];
        let columns = now.starts[a].windows(2).enumerate();
        columns.filter(|(_, w)| meets(w)).map(|(column, _)| column).collect::<Vec<_>>()
    });
    let rows = zs.into_iter().flat_map(move |z| ys.clone().into_iter().map(move |y| (y, z)));
    rows.flat_map(move |(y, z)| xs.clone().into_iter().map(move |x| [x, y, z]))
}

/// Where the values that two blocks of an array share lie in either, x fastest.
fn common(a: &GridBlock, b: &GridBlock) -> impl Iterator<Item = [usize; 2]> + use<> {
    let (a, b) = (*a, *b);
    let [xs, ys, zs] = [0, 1, 2].map(|k| {
        let end = (a.first[k] + a.own[k]).min(b.first[k] + b.own[k]);
        a.first[k].max(b.first[k])..end
    });
    let rows = zs.flat_map(move |z| ys.clone().map(move |y| (y, z)));
    rows.flat_map(move |(y, z)| xs.clone().map(move |x| [&a, &b].map(|block| block.index([x, y, z]))))
}

#[cfg(test)]
mod tests {
    use super::{common, exchanged, sharing};
    use crate::fluid::restart::block;
    use grains_domain::SerialTransport;
    use grains_fluid::CellPartition;
    use grains_output::{GridArray, GridBlock};

    fn partition(starts: [Vec<usize>; 3], coordinates: [usize; 3]) -> CellPartition {
        CellPartition { ranks: starts.each_ref().map(|s| s.len() - 1), coordinates, starts }
    }

    /// A value that tells the place.
    fn value([x, y, z]: [usize; 3]) -> f64 {
        (x + 100 * y + 10_000 * z) as f64
    }

    fn places(block: &GridBlock) -> Vec<[usize; 3]> {
        let range = |a: usize| block.first[a]..block.first[a] + block.own[a];
        let rows = range(2).flat_map(|z| range(1).map(move |y| (y, z)));
        rows.flat_map(|(y, z)| range(0).map(move |x| [x, y, z])).collect()
    }

    #[test]
    fn every_value_of_cells_and_faces_has_one_new_owner() {
        let cells = [9, 5, 7];
        let before = [vec![0, 2, 9], vec![0, 5], vec![0, 3, 5, 7]];
        let now = [vec![0, 6, 9], vec![0, 5], vec![0, 2, 6, 7]];
        // Cells, faces normal to z between boundaries, and normal to y where it is periodic.
        for all in [cells, [9, 5, 8], [10, 5, 7]] {
            let mut found = std::collections::BTreeSet::new();
            for from in 0..6 {
                let own = [from % 2, 0, from / 2];
                let (old, new) = (partition(before.clone(), own), partition(now.clone(), own));
                let mine = block(all, cells, &old, own);
                for place in sharing(&old, &new) {
                    let theirs = block(all, cells, &new, place);
                    let of_mine = places(&mine);
                    let of_theirs = places(&theirs);
                    for [a, b] in common(&mine, &theirs) {
                        assert_eq!(of_mine[a], of_theirs[b]);
                        assert!(found.insert(of_mine[a]), "{:?} twice", of_mine[a]);
                    }
                }
            }
            assert_eq!(found.len(), all.iter().product::<usize>(), "{all:?}");
        }
    }

    #[test]
    fn a_rank_alone_keeps_what_it_has() {
        let all = [3, 4, 2];
        let alone = partition(all.map(|n| vec![0, n]), [0; 3]);
        let block = block(all, all, &alone, [0; 3]);
        let values: Vec<f64> = places(&block).into_iter().map(value).collect();
        let array = GridArray { name: "pressure", unit: "Pa", width: 1, block, values };
        assert_eq!(exchanged(vec![array.clone()], all, (&alone, &alone), &SerialTransport), [array]);
    }
}
