//! Where the ranks of a node lie in the grid of ranks.
//!
//! Ranks numbered along x put a node into a row of subdomains, whose neighbours are nearly all on other nodes. In a brick more of
//! them are on the same node, and less has to pass through the network adapter that its ranks share.

/// The ranks of all nodes as like bricks of a grid of ranks.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub struct Bricks {
    /// Ranks per axis.
    pub ranks: [usize; 3],
    /// Ranks per axis of one node.
    pub edges: [usize; 3],
}

impl Bricks {
    /// Bricks of minimum surface within a grid of subdomains that are `widths` (m) wide, for `per_node` ranks on each node; none if
    /// they do not fill the grid.
    pub fn of(ranks: [usize; 3], widths: [f64; 3], per_node: usize) -> Option<Self> {
        let divides = |n: &usize, of: usize| of.is_multiple_of(*n);
        let edges = (1..=per_node).filter(|x| divides(x, per_node)).flat_map(|x| {
            let rest = per_node / x;
            (1..=rest).filter(move |y| divides(y, rest)).map(move |y| [x, y, rest / y])
        });
        let fitting = edges.filter(|edges| (0..3).all(|a| divides(&edges[a], ranks[a])));
        // Per volume; a brick has no border where it spans the grid.
        let surface = |edges: &[usize; 3]| -> f64 {
            let cut = (0..3).filter(|&a| edges[a] < ranks[a]);
            cut.map(|a| 1.0 / (edges[a] as f64 * widths[a])).sum()
        };
        let edges = fitting.min_by(|a, b| surface(a).total_cmp(&surface(b)))?;
        Some(Self { ranks, edges })
    }

    /// Number in the grid, x fastest, of a rank of a node.
    pub fn rank(&self, node: usize, rank_of_node: usize) -> usize {
        let place = |k: usize, n: [usize; 3]| [k % n[0], k / n[0] % n[1], k / (n[0] * n[1])];
        let bricks = std::array::from_fn(|a| self.ranks[a] / self.edges[a]);
        let (brick, within) = (place(node, bricks), place(rank_of_node, self.edges));
        let [x, y, z]: [usize; 3] = std::array::from_fn(|a| brick[a] * self.edges[a] + within[a]);
        (z * self.ranks[1] + y) * self.ranks[0] + x
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn ranks_of_bricks_are_each_there_once_and_the_first_is_the_first() {
        for (ranks, per_node) in
            [([4, 4, 4], 8), ([6, 2, 5], 12), ([16, 16, 8], 128), ([3, 1, 1], 1), ([2, 3, 2], 12)]
        {
            let all: usize = ranks.iter().product();
            let bricks = Bricks::of(ranks, [1.0; 3], per_node).unwrap();
            assert_eq!(bricks.edges.iter().product::<usize>(), per_node);
            let mut numbers: Vec<usize> = (0..all).map(|k| bricks.rank(k / per_node, k % per_node)).collect();
            assert_eq!(numbers[0], 0);
            numbers.sort_unstable();
            assert_eq!(numbers, (0..all).collect::<Vec<_>>(), "{ranks:?}");
        }
    }

    #[test]
    fn bricks_have_the_minimum_surface_and_must_fill_the_grid() {
        assert_eq!(Bricks::of([8, 8, 8], [1.0; 3], 8).unwrap().edges, [2, 2, 2]);
        // Flat subdomains: the wide faces are those across the short axis.
        assert_eq!(Bricks::of([16, 16, 16], [3.0, 3.0, 1.0], 16).unwrap().edges, [2, 2, 4]);
        // A column is not cut along z.
        assert_eq!(Bricks::of([16, 8, 1], [1.0, 2.0, 9.0], 8).unwrap().edges, [4, 2, 1]);
        assert_eq!(Bricks::of([5, 5, 1], [1.0; 3], 4), None);
    }
}
