//! Tables of the fields along lines and over planes.

use super::observe::{Observation, cell_of};
use grains_case::{Profile, ProfileKind};
use grains_domain::Transport;
use grains_fluid::Flow;

/// A point of a profile on this rank.
struct Point {
    /// Number of the point in the profile.
    number: usize,
    /// Its place (m).
    position: [f64; 3],
    /// Places in the arrays and weights (-) of the cells it is interpolated from.
    cells: Vec<(usize, f64)>,
}

/// The points of a profile that lie in this rank's cells.
pub struct Sampler {
    /// Name of the profile.
    pub name: String,
    points: Vec<Point>,
}

impl Sampler {
    /// Finds the own points of a profile.
    pub fn new(profile: &Profile, flow: &Flow) -> Self {
        let own = |(number, position): (usize, [f64; 3])| {
            let cells = cells(flow, position)?;
            Some(Point { number, position, cells })
        };
        let points = match &profile.kind {
            ProfileKind::Line { from, to, points } => {
                let at = |k: u64, a: usize| from[a] + (to[a] - from[a]) * (k as f64 / (points - 1) as f64);
                let positions = (0..*points).map(|k| (k as usize, std::array::from_fn(|a| at(k, a))));
                positions.filter_map(own).collect()
            }
            ProfileKind::Plane { axis, at } => {
                plane(flow, *axis as usize, *at).into_iter().filter_map(own).collect()
            }
        };
        Self { name: profile.name.clone(), points }
    }

    /// Rows of x, y, z (m) and all components, in the order of the points, on rank 0; collective.
    pub fn rows(&self, fields: &[Observation], transport: &dyn Transport) -> Vec<Vec<f64>> {
        let components: Vec<&[f64]> =
            fields.iter().flat_map(|f| f.components.iter().map(|c| c.data())).collect();
        let mut own = Vec::new();
        for point in &self.points {
            own.push(point.number as f64);
            own.extend(point.position);
            own.extend(
                components.iter().map(|data| point.cells.iter().map(|&(p, w)| w * data[p]).sum::<f64>()),
            );
        }
        let width = 4 + components.len();
        let received = transport.exchange_sparse(vec![(0, own)]);
        let rows = received.iter().flat_map(|(_, message)| message.chunks_exact(width));
        let mut rows: Vec<&[f64]> = rows.collect();
        rows.sort_by(|a, b| a[0].total_cmp(&b[0]));
        rows.into_iter().map(|row| row[1..].to_vec()).collect()
    }
}

/// Numbers and centres (m) of the own cells in the layer that a plane cuts, the lower axis fastest; the layer itself may
/// be another rank's.
fn plane(flow: &Flow, axis: usize, at: f64) -> Vec<(usize, [f64; 3])> {
    let (grid, layout, first_cell) = (&flow.setup.grid, flow.layout(), flow.first_cell());
    let normal = grid.axis(axis).centre(cell_of(grid, axis, at) as isize);
    let [first, second] = [[1, 2], [0, 2], [0, 1]][axis];
    let own = |a: usize| first_cell[a]..first_cell[a] + layout.cells[a];
    let mut positions = Vec::new();
    for j in own(second) {
        for i in own(first) {
            let mut position = [normal; 3];
            position[first] = grid.axis(first).centre(i as isize);
            position[second] = grid.axis(second).centre(j as isize);
            positions.push((j * grid.axis(first).cells() + i, position));
        }
    }
    positions
}

/// Cells and weights of the linear interpolation between centres, if this rank owns the cell of the position; next to a
/// boundary of the domain the value of the last cell holds.
fn cells(flow: &Flow, position: [f64; 3]) -> Option<Vec<(usize, f64)>> {
    let (grid, layout, first) = (&flow.setup.grid, flow.layout(), flow.first_cell());
    let mut cells = vec![(layout.index(0, 0, 0), 1.0)];
    for a in 0..3 {
        let axis = grid.axis(a);
        let global = cell_of(grid, a, position[a]);
        let own = global.checked_sub(first[a]).filter(|&own| own < layout.cells[a])?;
        let centre = axis.centre(global as isize);
        let towards: isize = if position[a] < centre { -1 } else { 1 };
        let next = global as isize + towards;
        let is_inside = axis.is_periodic() || (0..axis.cells() as isize).contains(&next);
        let share = if is_inside { (position[a] - centre) / (axis.centre(next) - centre) } else { 0.0 };
        let stride = layout.strides()[a];
        let place =
            |p: usize, offset: isize| (p as isize + (own as isize + offset) * stride as isize) as usize;
        cells = cells
            .iter()
            .flat_map(|&(p, w)| [(place(p, 0), w * (1.0 - share)), (place(p, towards), w * share)])
            .filter(|&(_, w)| w != 0.0)
            .collect();
    }
    Some(cells)
}
