//! What patches cover of the faces of cells.
//!
//! Along one tangential axis, the corners of the outlines and the crossings of their edges, with one another and with the edges
//! of the cell, cut its face into strips. In a strip no edges cross: between two of them lies a trapezoid under one condition. Gauss's
//! two points along each axis give its area exactly, and so the integrals of parabolas.

use super::outline::{Point, crossing, encloses, tangents_of};
use super::{Boundaries, BoxFace, Condition, Profile};
use crate::Grid;

/// Part of a cell's face that counts as nothing (-).
const SLIVER: f64 = 1e-9;

/// Places of Gauss's two points on an interval (-).
const GAUSS: [f64; 2] = [0.211_324_865_405_187_13, 0.788_675_134_594_812_9];

/// The part of a cell's boundary face under one condition.
#[derive(Clone, Debug, PartialEq)]
pub(super) struct Piece {
    /// Its number, see [`Boundaries::condition`].
    pub condition: usize,
    /// Share of the area of the cell's face (-).
    pub share: f64,
    /// Its middle (m).
    pub at: [f64; 3],
    /// Mean of the parabola across the inlet, whose mean over the whole is 1 (-); 1 where there is none.
    pub parabola: f64,
}

/// The outlines on a face and their images along periodic axes, in the order of the patches.
pub(super) struct Outlines<'a> {
    grid: &'a Grid,
    boundaries: &'a Boundaries,
    face: BoxFace,
    tangents: [usize; 2],
    placed: Vec<Placed>,
}

struct Placed {
    condition: usize,
    bounds: [[f64; 2]; 2],
    /// From the outline to this image (m).
    shift: Point,
    edges: Vec<[Point; 2]>,
}

/// A line that bounds a trapezoid: an edge, or one along the strip.
#[derive(Clone, Copy)]
struct Line([Point; 2]);

impl Line {
    fn at(self, x: f64) -> f64 {
        let [[x0, y0], [x1, y1]] = self.0;
        if x1 == x0 { y0 } else { y0 + (x - x0) / (x1 - x0) * (y1 - y0) }
    }
}

/// Integrals over what one condition covers: of 1, of both coordinates, and of the parabola.
struct Integrals {
    condition: usize,
    sums: [f64; 4],
}

impl<'a> Outlines<'a> {
    pub fn new(grid: &'a Grid, boundaries: &'a Boundaries, face: BoxFace) -> Self {
        let tangents = tangents_of(face.axis);
        let mut placed = Vec::new();
        for (k, patch) in boundaries.patches.iter().enumerate().filter(|(_, patch)| patch.face == face) {
            let (bounds, edges) = (patch.outline.bounds(tangents), patch.outline.edges(tangents));
            let images = [0, 1].map(|m| {
                let axis = grid.axis(tangents[m]);
                let ([begin, end], nodes) = (bounds[m], axis.nodes());
                let period = |room: f64| if axis.is_periodic() { room / axis.length() } else { 0.0 };
                let first = period(nodes[0] - end).ceil() as i64;
                first..=period(nodes[axis.cells()] - begin).floor() as i64
            });
            for (i, j) in images[0].clone().flat_map(|i| images[1].clone().map(move |j| (i, j))) {
                let shift = [i, j].into_iter().zip(tangents).map(|(n, t)| n as f64 * grid.axis(t).length());
                let shift: Vec<f64> = shift.collect();
                let shift = [shift[0], shift[1]];
                let moved = |[x, y]: Point| [x + shift[0], y + shift[1]];
                placed.push(Placed {
                    condition: 6 + k,
                    bounds: [0, 1].map(|m| bounds[m].map(|x| x + shift[m])),
                    shift,
                    edges: edges.iter().map(|edge| edge.map(moved)).collect(),
                });
            }
        }
        Self { grid, boundaries, face, tangents, placed }
    }

    /// The number of the condition at a point (m) of the face.
    pub fn condition_at(&self, at: [f64; 3]) -> usize {
        let patches = self.boundaries.patches.iter().enumerate().rev();
        let mut here = patches.filter(|(_, patch)| patch.face == self.face);
        let found = here.find(|(_, patch)| patch.outline.contains(self.grid, self.face.axis, at));
        found.map_or(self.face.index(), |(k, _)| 6 + k)
    }

    /// The pieces of the face of a cell, given with its middle (m).
    pub fn pieces(&self, cell: [isize; 3], at: [f64; 3]) -> Vec<Piece> {
        let [x, y] =
            self.tangents.map(|t| [self.grid.axis(t).node(cell[t]), self.grid.axis(t).node(cell[t] + 1)]);
        let room = [x, y].map(|[begin, end]| SLIVER * (end - begin));
        let meets = |bounds: &[[f64; 2]; 2]| {
            (0..2).all(|m| bounds[m][0] < [x, y][m][1] - room[m] && bounds[m][1] > [x, y][m][0] + room[m])
        };
        let near: Vec<&Placed> = self.placed.iter().filter(|outline| meets(&outline.bounds)).collect();
        let mut found: Vec<Integrals> = Vec::new();
        let edges = edges_in(&near, [x, y]);
        let cuts = cuts(&edges, [x, y], room[0]);
        for strip in cuts.windows(2) {
            let middle = 0.5 * (strip[0] + strip[1]);
            let lines = lines_in(&near, y, middle, room[1]);
            for pair in lines.windows(2) {
                let [low, high] = [pair[0], pair[1]];
                let condition = self.condition_in(&near, [middle, 0.5 * (low.at(middle) + high.at(middle))]);
                let shift =
                    near.iter().rev().find(|o| o.condition == condition && o.holds(middle, low, high));
                let sums =
                    self.integrals(condition, shift.map_or([0.0; 2], |o| o.shift), strip, [low, high], y);
                match found.iter_mut().find(|known| known.condition == condition) {
                    Some(known) => known.sums.iter_mut().zip(sums).for_each(|(sum, more)| *sum += more),
                    None => found.push(Integrals { condition, sums }),
                }
            }
        }
        let (is_whole, whole) = (found.len() == 1, (x[1] - x[0]) * (y[1] - y[0]));
        let piece = |Integrals { condition, sums: [area, first, second, parabola] }: Integrals| {
            let mut middle = at;
            if !is_whole {
                (middle[self.tangents[0]], middle[self.tangents[1]]) = (first / area, second / area);
            }
            Piece {
                condition,
                share: if is_whole { 1.0 } else { area / whole },
                at: middle,
                parabola: parabola / area,
            }
        };
        found.into_iter().map(piece).collect()
    }

    fn condition_in(&self, near: &[&Placed], at: Point) -> usize {
        let holds = near.iter().rev().find(|outline| encloses(&outline.edges, at));
        holds.map_or(self.face.index(), |outline| outline.condition)
    }

    /// Integrals over the trapezoid between two lines, within the cell, of a strip.
    fn integrals(
        &self,
        condition: usize,
        shift: Point,
        strip: &[f64],
        [low, high]: [Line; 2],
        [begin, end]: [f64; 2],
    ) -> [f64; 4] {
        let is_parabola = matches!(
            self.boundaries.condition(condition),
            Condition::Inlet {
                profile: Profile::Parabolic { .. } | Profile::FlowRate { is_parabolic: true, .. }
            }
        );
        let mut sums = [0.0; 4];
        for share in GAUSS {
            let x = strip[0] + share * (strip[1] - strip[0]);
            let [y0, y1] = [low, high].map(|line| line.at(x).clamp(begin, end));
            let weight = 0.25 * (strip[1] - strip[0]) * (y1 - y0);
            for share in GAUSS {
                let y = y0 + share * (y1 - y0);
                let parabola = match is_parabola {
                    true => self.boundaries.parabola(self.grid, condition, [x - shift[0], y - shift[1]]),
                    false => 1.0,
                };
                let values = [1.0, x, y, parabola];
                sums.iter_mut().zip(values).for_each(|(sum, value)| *sum += weight * value);
            }
        }
        sums
    }
}

impl Placed {
    /// Whether the middle of a trapezoid lies in it.
    fn holds(&self, x: f64, low: Line, high: Line) -> bool {
        encloses(&self.edges, [x, 0.5 * (low.at(x) + high.at(x))])
    }
}

/// Edges that meet a cell, each with the number of its outline.
fn edges_in(near: &[&Placed], [x, y]: [[f64; 2]; 2]) -> Vec<(usize, [Point; 2])> {
    let meets = |[p, q]: &[Point; 2]| {
        p[0].min(q[0]) <= x[1] && p[0].max(q[0]) >= x[0] && p[1].min(q[1]) <= y[1] && p[1].max(q[1]) >= y[0]
    };
    let edges = near.iter().enumerate().flat_map(|(k, outline)| outline.edges.iter().map(move |e| (k, *e)));
    edges.filter(|(_, edge)| meets(edge)).collect()
}

/// Where strips of a cell begin and end (m).
fn cuts(edges: &[(usize, [Point; 2])], [x, y]: [[f64; 2]; 2], room: f64) -> Vec<f64> {
    let mut cuts = Vec::new();
    for (number, (outline, edge)) in edges.iter().enumerate() {
        cuts.extend(edge.map(|corner| corner[0]));
        for level in y {
            cuts.extend(crossing(*edge, [[x[0], level], [x[1], level]]));
        }
        let others = edges[number + 1..].iter().filter(|(other, _)| other != outline);
        cuts.extend(others.filter_map(|(_, other)| crossing(*edge, *other)));
    }
    cuts.retain(|&cut| x[0] + room < cut && cut < x[1] - room);
    ordered(cuts, x, room, |cut| *cut)
}

/// The lines between which the trapezoids of a strip lie.
fn lines_in(near: &[&Placed], y: [f64; 2], middle: f64, room: f64) -> Vec<Line> {
    let level = |y: f64| Line([[middle, y], [middle, y]]);
    let edges = near.iter().flat_map(|outline| outline.edges.iter());
    let spans = |edge: &&[Point; 2]| (edge[0][0] <= middle) != (edge[1][0] <= middle);
    let lines = edges.filter(spans).map(|edge| Line(*edge));
    let within = |line: &Line| y[0] + room < line.at(middle) && line.at(middle) < y[1] - room;
    let lines: Vec<Line> = lines.filter(within).collect();
    ordered(lines, y.map(level), room, |line| line.at(middle))
}

/// Items between two ends in order, without those that lie closer together than some room.
fn ordered<T: Copy>(mut items: Vec<T>, [begin, end]: [T; 2], room: f64, place: impl Fn(&T) -> f64) -> Vec<T> {
    items.sort_by(|a, b| place(a).total_cmp(&place(b)));
    let mut kept = vec![begin];
    for item in items {
        if kept.last().is_some_and(|last| place(&item) - place(last) > room) {
            kept.push(item);
        }
    }
    kept.push(end);
    kept
}
