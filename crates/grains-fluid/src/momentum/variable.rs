//! The implicit factors where void fraction, drag or kinds of boundary differ from place to place.

use crate::boundary::{FaceTable, Kind};
use crate::metrics::Local;
use crate::reduced::{RowGather, Segment, values_around};
use crate::{Faces, Ownership, Side};
use grains_domain::Transport;

/// Coefficients of (m − ½ ν ∇·ε∇) δ = r.
#[derive(Clone, Copy)]
pub(crate) struct Capacity<'a> {
    /// 1/m on the faces (s): 1/(ε/Δt + β/ρ); none where m = 1/Δt.
    pub inverse: Option<&'a Faces>,
    /// Time step Δt (s).
    pub dt: f64,
    /// ε at the centres with ghosts; none where it is 1.
    pub void_fraction: Option<&'a [f64]>,
    /// Kinematic viscosity ν (m²/s).
    pub viscosity: f64,
}

impl Capacity<'_> {
    /// 1/m of a face (s).
    #[inline(always)]
    pub fn inverse_at(&self, component: usize, p: usize) -> f64 {
        self.inverse.map_or(self.dt, |faces| faces.component(component)[p])
    }

    /// ε where the stress of a component on a face normal to `axis` acts; `p` is the unknown below it.
    #[inline(always)]
    fn void_fraction_above(&self, p: usize, component: usize, axis: usize, strides: [usize; 3]) -> f64 {
        let Some(eps) = self.void_fraction else { return 1.0 };
        let (sa, sb) = (strides[component], strides[axis]);
        if component == axis {
            eps[p + sa]
        } else {
            0.25 * (eps[p] + eps[p + sa] + eps[p + sb] + eps[p + sa + sb])
        }
    }
}

/// Lines side by side: unknown i of line l at start + i stride + l step.
#[derive(Clone, Copy)]
struct Panel {
    start: usize,
    stride: usize,
    lines: usize,
    step: usize,
}

/// Rows along x solved side by side.
const ROWS: usize = 8;

/// Solver of the factors, one component and axis at a time.
#[derive(Clone)]
pub(crate) struct VariableLines {
    gathers: [RowGather; 3],
    coupled: [bool; 3],
    /// ½ ν ε / distance at the upper side of every unknown.
    conductance: Vec<f64>,
    carried: Vec<f64>,
    before: Vec<f64>,
    after: Vec<f64>,
    ends: Vec<f64>,
}

impl VariableLines {
    pub fn new(local: &Local, ownership: &Ownership, periodic: [bool; 3]) -> Self {
        let coupled = std::array::from_fn(|a| ownership.is_split(a) || periodic[a]);
        let answers = if coupled.contains(&true) { local.layout.len() } else { 0 };
        Self {
            gathers: std::array::from_fn(|a| RowGather::new(&ownership.row(a), ownership.coordinates[a])),
            coupled,
            conductance: vec![0.0; local.layout.len()],
            carried: Vec::new(),
            before: vec![0.0; answers],
            after: vec![0.0; answers],
            ends: Vec::new(),
        }
    }

    /// Solves the factor of one axis for all lines of a component, in place.
    pub fn solve(
        &mut self,
        local: &Local,
        tables: &[FaceTable],
        [component, axis]: [usize; 2],
        capacity: Capacity<'_>,
        data: &mut [f64],
        transport: &dyn Transport,
    ) {
        self.set_conductance(local, tables, [component, axis], capacity);
        let system = System { local, component, axis, capacity };
        self.ends.clear();
        for_panels(local, component, axis, |panel| self.eliminate(&system, panel, data));
        if self.coupled[axis] {
            self.gathers[axis].gather(&self.ends, transport);
            let mut number = 0;
            for_panels(local, component, axis, |panel| {
                self.correct(&system, panel, number, data);
                number += panel.lines;
            });
        }
    }

    fn set_conductance(
        &mut self,
        local: &Local,
        tables: &[FaceTable],
        [component, axis]: [usize; 2],
        capacity: Capacity<'_>,
    ) {
        let (layout, n) = (local.layout, local.unknowns(component));
        let (strides, h) = (layout.strides(), layout.halo as isize);
        let m = &local.axes[axis];
        let mut from = [0_isize; 3];
        from[axis] = -1;
        for k in from[2]..n[2] as isize {
            for j in from[1]..n[1] as isize {
                for i in from[0]..n[0] as isize {
                    let (p, e) = (layout.index(i, j, k), ([i, j, k][axis] + h) as usize);
                    let inverse =
                        if component == axis { m.inverse_width[e + 1] } else { m.inverse_distance[e] };
                    let eps = capacity.void_fraction_above(p, component, axis, strides);
                    self.conductance[p] = 0.5 * capacity.viscosity * eps * inverse;
                }
            }
        }
        if component == axis {
            return;
        }
        // Beyond the box there is no neighbour unless it is imposed.
        for table in tables.iter().filter(|t| t.face.axis == axis) {
            for m2 in layout.halo..table.extents[1] - layout.halo {
                for m1 in layout.halo..table.extents[0] - layout.halo {
                    let inside = table.inside(layout, m1, m2);
                    let upper = if table.face.side == Side::High { inside } else { inside - strides[axis] };
                    if table.kinds[component][m2 * table.extents[0] + m1] != Kind::Fixed {
                        self.conductance[upper] = 0.0;
                    }
                }
            }
        }
    }

    fn eliminate(&mut self, system: &System<'_>, panel: Panel, data: &mut [f64]) {
        let (n, lines) = (system.len(), panel.lines);
        let coupled = self.coupled[system.axis];
        self.carried.resize(n * lines, 0.0);
        for i in 0..n {
            for l in 0..lines {
                let p = panel.start + i * panel.stride + l * panel.step;
                let [low, high, diagonal] = system.row(&self.conductance, i, p, panel.stride);
                let carried = if i == 0 { 0.0 } else { self.carried[(i - 1) * lines + l] };
                let before = p.wrapping_sub(panel.stride);
                let inverse = 1.0 / if i == 0 { diagonal } else { diagonal - low * carried };
                self.carried[i * lines + l] = high * inverse;
                data[p] = if i == 0 { data[p] } else { data[p] + low * data[before] } * inverse;
                if coupled {
                    self.before[p] = if i == 0 { -low } else { low * self.before[before] } * inverse;
                    let unit = if i + 1 == n { -high } else { 0.0 };
                    self.after[p] = if i == 0 { unit } else { unit + low * self.after[before] } * inverse;
                }
            }
        }
        for i in (0..n.saturating_sub(1)).rev() {
            for l in 0..lines {
                let p = panel.start + i * panel.stride + l * panel.step;
                let carried = self.carried[i * lines + l];
                data[p] += carried * data[p + panel.stride];
                if coupled {
                    self.before[p] += carried * self.before[p + panel.stride];
                    self.after[p] += carried * self.after[p + panel.stride];
                }
            }
        }
        if coupled {
            for l in 0..lines {
                let first = panel.start + l * panel.step;
                let last = first + (n - 1) * panel.stride;
                let both = |x: &[f64]| [x[first], x[last]];
                let ends = [both(data), both(&self.before), both(&self.after)];
                self.ends.extend(ends.as_flattened());
            }
        }
    }

    fn correct(&mut self, system: &System<'_>, panel: Panel, first: usize, data: &mut [f64]) {
        let gather = &self.gathers[system.axis];
        for l in 0..panel.lines {
            let part = |k: usize| {
                let e = &gather.message(k, &self.ends)[6 * (first + l)..][..6];
                Segment { y: [e[0], e[1]], v: [e[2], e[3]], w: [e[4], e[5]] }
            };
            let [before, after] = values_around(gather.len(), gather.own, part);
            for i in 0..system.len() {
                let p = panel.start + i * panel.stride + l * panel.step;
                data[p] -= self.before[p] * before + self.after[p] * after;
            }
        }
    }
}

/// The factor of one component and axis: row i is diagonal x − low x₋ − high x₊.
struct System<'a> {
    local: &'a Local,
    component: usize,
    axis: usize,
    capacity: Capacity<'a>,
}

impl System<'_> {
    fn len(&self) -> usize {
        self.local.unknowns(self.component)[self.axis]
    }

    #[inline(always)]
    fn row(&self, conductance: &[f64], i: usize, p: usize, stride: usize) -> [f64; 3] {
        let m = &self.local.axes[self.axis];
        let e = self.local.entry(i);
        let inverse = if self.component == self.axis { m.inverse_distance[e] } else { m.inverse_width[e] };
        let factor = self.capacity.inverse_at(self.component, p) * inverse;
        let (low, high) = (factor * conductance[p - stride], factor * conductance[p]);
        let ends = self.local.ends[self.axis];
        let is_first = i == 0 && ends[0];
        let is_last = i + 1 == self.len() && ends[1];
        if !is_first && !is_last {
            return [low, high, 1.0 + low + high];
        }
        // [diagonal, coupling to the second cell] of the ghost beyond an end.
        let ghost = |side: usize| match self.component == self.axis {
            true => [1.0, 0.0],
            false => [1.0 - self.local.walls[self.axis][side][1], self.local.walls[self.axis][side][2]],
        };
        let (mut row, g) = ([low, high, 1.0], [ghost(0), ghost(1)]);
        row[2] += if is_first { low * g[0][0] } else { low } + if is_last { high * g[1][0] } else { high };
        if is_first {
            row[0] = 0.0;
            row[1] += low * g[0][1];
        }
        if is_last {
            row[0] += if is_first { 0.0 } else { high * g[1][1] };
            row[1] = 0.0;
        }
        row
    }
}

fn for_panels(local: &Local, component: usize, axis: usize, mut job: impl FnMut(Panel)) {
    let (layout, [nx, ny, nz]) = (local.layout, local.unknowns(component));
    let [_, sy, sz] = layout.strides();
    match axis {
        0 => {
            for k in 0..nz {
                for j in (0..ny).step_by(ROWS) {
                    let lines = ROWS.min(ny - j);
                    job(Panel { start: layout.row(j, k), stride: 1, lines, step: sy });
                }
            }
        }
        1 => (0..nz).for_each(|k| {
            job(Panel { start: layout.row(0, k), stride: sy, lines: nx, step: 1 });
        }),
        _ => (0..ny).for_each(|j| {
            job(Panel { start: layout.row(j, 0), stride: sz, lines: nx, step: 1 });
        }),
    }
}
