//! One axis of a grid: cells, their widths, and who owns them.

/// Cells along one axis, divided among the ranks along it.
#[derive(Clone, Debug, PartialEq)]
pub(crate) struct Axis {
    /// First cell of each rank, and the number of cells at the end.
    pub starts: Vec<usize>,
    /// Width of each cell (m).
    pub widths: Vec<f64>,
    /// Whether the last cell is followed by the first.
    pub is_periodic: bool,
}

impl Axis {
    /// An axis whose ranks own `owned` cells each; widths are 1 until they are known.
    pub fn new(owned: &[usize], is_periodic: bool) -> Self {
        let mut starts = vec![0];
        starts.extend(owned.iter().scan(0, |sum, n| {
            *sum += n;
            Some(*sum)
        }));
        let cells = starts[owned.len()];
        Self { starts, widths: vec![1.0; cells], is_periodic }
    }

    /// Number of cells.
    pub fn cells(&self) -> usize {
        self.widths.len()
    }

    /// Place along the axis of the rank that owns a cell.
    pub fn owner(&self, cell: usize) -> usize {
        self.starts[1..].partition_point(|&end| end <= cell)
    }

    /// Number of cells of a rank along the axis.
    pub fn owned(&self, rank: usize) -> usize {
        self.starts[rank + 1] - self.starts[rank]
    }

    /// Mean width of a cell (m).
    pub fn mean_width(&self) -> f64 {
        self.widths.iter().sum::<f64>() / self.cells() as f64
    }

    /// Distance (m) of the points on both sides of each face, cells + 1 of them: cell centres, and at the
    /// ends of an axis that is not periodic a centre and the face itself.
    pub fn distances(&self) -> Vec<f64> {
        let (n, w) = (self.cells(), &self.widths);
        let beyond = |other: usize| if self.is_periodic { w[other] } else { 0.0 };
        let mut distances = vec![0.5 * (w[0] + beyond(n - 1))];
        distances.extend(w.windows(2).map(|pair| 0.5 * (pair[0] + pair[1])));
        distances.push(0.5 * (w[n - 1] + beyond(0)));
        distances
    }

    /// The axis with its cells joined in pairs, and the new cell of each old one.
    ///
    /// Of an odd number the wider one of the end cells stays alone, so that widths even out from level to
    /// level. A pair belongs to the owner of its first cell.
    pub fn paired(&self) -> (Self, Vec<usize>) {
        let (n, w) = (self.cells(), &self.widths);
        let shift = usize::from(n % 2 == 1 && w[0] > w[n - 1]);
        let parents: Vec<usize> = (0..n).map(|cell| (cell + shift) / 2).collect();
        let mut widths = vec![0.0; parents[n - 1] + 1];
        for (cell, &parent) in parents.iter().enumerate() {
            widths[parent] += w[cell];
        }
        let coarse_start = |start: usize| match start {
            0 => 0,
            cell => parents[cell - 1] + 1,
        };
        let starts = self.starts.iter().map(|&start| coarse_start(start)).collect();
        (Self { starts, widths, is_periodic: self.is_periodic }, parents)
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn pairs_keep_the_length_and_belong_to_the_owner_of_their_first_cell() {
        let axis = Axis::new(&[37, 27], false);
        let (coarse, parents) = axis.paired();
        assert_eq!((coarse.cells(), &coarse.starts[..]), (32, &[0, 19, 32][..]));
        assert_eq!((parents[36], parents[37]), (18, 18));
        assert_eq!(coarse.owner(18), 0);
        assert_eq!(coarse.owner(19), 1);
    }

    #[test]
    fn odd_numbers_of_cells_do_not_grow_uneven() {
        let mut axis = Axis::new(&[50], false);
        while axis.cells() > 2 {
            axis = axis.paired().0;
            let widest = axis.widths.iter().fold(0.0, |a: f64, &b| a.max(b));
            let thinnest = axis.widths.iter().fold(f64::INFINITY, |a, &b| a.min(b));
            assert_eq!(axis.widths.iter().sum::<f64>(), 50.0);
            assert!(widest <= 3.0 * thinnest, "{:?}", axis.widths);
        }
    }

    #[test]
    fn ranks_may_run_out_of_cells() {
        let (coarse, _) = Axis::new(&[1, 1, 1], true).paired();
        assert_eq!(coarse.starts, [0, 1, 1, 2]);
        assert_eq!([coarse.owner(0), coarse.owner(1)], [0, 2]);
    }

    #[test]
    fn distances_end_at_walls_and_wrap_around_periods() {
        let mut axis = Axis::new(&[3], false);
        axis.widths = vec![1.0, 2.0, 4.0];
        assert_eq!(axis.distances(), [0.5, 1.5, 3.0, 2.0]);
        axis.is_periodic = true;
        assert_eq!(axis.distances(), [2.5, 1.5, 3.0, 2.5]);
    }
}
