//! Faces of cells that walls cut: what flows through them beyond the velocity in their middle.
//!
//! A velocity in the middle of a face stands for the flow through all of it, and one in a wall for none. Where the surface cuts
//! the face the flow is that of its open part: along the normal, with the polynomial p of the interface stencil, s the distance
//! from the surface and s₀ that of the middle of the face (negative in the wall),
//!
//! ```text
//! flow/area = u + c,   c = ∫ p(s⁺) dA/A − p(s₀⁺)
//! ```
//!
//! so that steady flow along a slanted wall goes through the cells beside it as if these were cut (Seo & Mittal 2011), while the
//! pressure keeps its constant coefficients. c is at most an eighth of the velocity a cell away, and that of the last step.
//! In cells without a velocity that is free nothing could make up for what the faces disagree about: one of their faces
//! takes what the others leave. Where two walls meet some have neighbours of their kind only: nothing flows through these, or their
//! pressure would rise without end.

use crate::body::others;
use crate::interface_stencil::InterfaceStencil;
use crate::profile::{Normals, Profile, Target, pitch};
use crate::solid_mask::Holders;
use crate::wall::{ClosestPoint, Solids};
use crate::wall_load::turning;
use crate::{Extrapolation, RigidBody, Subgrid};
use grains_domain::Transport;
use grains_fluid::Flow;
use grains_geometry::Vec3;
use grains_geometry::lanes::Vector;
use std::collections::HashMap;

/// Widths of a face along the normal, over that of a cell, below which the surface counts as parallel to its edges (-).
const PARALLEL: f64 = 1e-4;

/// What rounding may make of open shares (-): all ranks choose one face.
const TIE: f64 = 1e-9;

/// A face that the surface of a wall cuts.
#[derive(Clone, Copy, Debug)]
pub(crate) struct CutFace {
    /// Place in the arrays.
    pub place: u32,
    /// Number of the wall.
    pub wall: u32,
    /// The surface point closest to its middle; its distance is negative in the fluid.
    pub out: ClosestPoint,
    /// Open share of its area (-).
    open: f64,
    /// Means of s⁺, s⁺², s⁺³ over the face less their values in its middle (m, m², m³).
    moments: Vec3,
}

/// A cell without a free velocity, and the face that takes what its others leave.
#[derive(Clone, Copy, Debug)]
struct ClosedCell {
    cell: u32,
    axis: usize,
    face: u32,
}

/// What passes a face beyond its velocity.
#[derive(Clone, Debug)]
struct Passed {
    place: u32,
    body: u32,
    stencil: InterfaceStencil,
    /// Along the normal, as long as c of the distance from the surface (m): what turns with the wall passes by itself.
    offset: Vec3,
}

/// All cut faces of a rank.
#[derive(Clone, Debug, Default)]
pub(crate) struct CutFaces {
    /// Those with a c, per component.
    passed: [Vec<Passed>; 3],
    closed: Vec<ClosedCell>,
    /// Faces through which something was last noted to pass, per component.
    noted: [Vec<u32>; 3],
    /// Faces of cells without a free velocity that have no such face, per component, in ascending order.
    shut: [Vec<u32>; 3],
}

impl CutFace {
    /// The face about a velocity, given the closest point of the surface; none if that does not cut it.
    pub fn new(
        component: usize,
        place: usize,
        (wall, out): (u32, ClosestPoint),
        subgrid: &Subgrid,
    ) -> Option<Self> {
        let [b, c] = others(component).map(|a| match subgrid.active[a] {
            true => (out.surface.direction[a] * subgrid.spacing[a]).abs(),
            false => 0.0,
        });
        let middle = -out.surface.distance;
        if middle.abs() >= 0.5 * (b + c) {
            return None;
        }
        let mean = |k: i32| mean_of_positive(middle, [b.max(c), b.min(c)], k);
        let moments = Vec3::from_fn(|k, _| mean(k as i32 + 1) - middle.max(0.0).powi(k as i32 + 1));
        Some(Self { place: place as u32, wall, out, open: mean(0), moments })
    }
}

/// Mean over a rectangle of (s⁺)^k, of s that changes linearly by `wide` and `narrow` from edge to edge and is `middle` in the
/// middle.
fn mean_of_positive(middle: f64, [wide, narrow]: [f64; 2], k: i32) -> f64 {
    let n = f64::from(k);
    let along = |s: f64| s.max(0.0).powi(k + 1) / (n + 1.0);
    let over = |s: f64| s.max(0.0).powi(k + 2) / ((n + 1.0) * (n + 2.0));
    let (p, q) = (0.5 * wide, 0.5 * narrow);
    match narrow > PARALLEL * wide {
        true => {
            (over(middle + p + q) - over(middle - p + q) - over(middle + p - q) + over(middle - p - q))
                / (wide * narrow)
        }
        false => (along(middle + p) - along(middle - p)) / wide,
    }
}

impl CutFaces {
    /// The stencils of cut faces, own and halo, with who holds the velocities.
    pub fn find(
        &mut self,
        faces: [&[CutFace]; 3],
        holders: [Holders; 3],
        solids: &Solids,
        extrapolation: Extrapolation,
    ) {
        let (subgrid, first_wall) = (solids.subgrid, (solids.bodies.len() - solids.walls.len()) as u32);
        let is_cut = |component: usize, face: &CutFace| {
            holders[component].body(face.place as usize).is_none_or(|body| body == first_wall + face.wall)
        };
        self.close_cells(faces, holders, subgrid);
        for (component, faces) in faces.into_iter().enumerate() {
            let passed = &mut self.passed[component];
            passed.clear();
            for face in faces.iter().filter(|face| is_cut(component, face)) {
                let place = face.place as usize;
                if !subgrid.is_own(component, subgrid.indices(place)) {
                    continue;
                }
                let Some(rule) = extrapolation.rule() else { continue };
                let surface = &face.out.surface;
                let direction = Vector::<f64>::of(&surface.direction);
                let unit = pitch(&direction, subgrid);
                let start = subgrid.position(component, place) + surface.direction * surface.distance;
                let wanted = Vec3::from_fn(|k, _| face.moments[k] / unit.powi(k as i32 + 1));
                let (start, wanted) = (Vector::of(&start), Vector::of(&wanted));
                let profile = Profile {
                    target: Target { subgrid, place, holders: holders[component], rule, out: &face.out },
                    component,
                    solids,
                    normal: Normals { start, direction, unit, wanted },
                };
                let (body, offset) = (first_wall + face.wall, surface.direction * face.moments[0]);
                let mut stencil = InterfaceStencil::default();
                if profile.find(&mut stencil) {
                    passed.push(Passed { place: face.place, body, stencil, offset });
                }
            }
        }
    }

    /// Finds the cells without a free velocity beside cut faces, own ones and those next to them.
    fn close_cells(&mut self, faces: [&[CutFace]; 3], holders: [Holders; 3], subgrid: &Subgrid) {
        let strides = subgrid.layout.strides();
        let axes: Vec<usize> = (0..3).filter(|&a| subgrid.active[a]).collect();
        let open: HashMap<(usize, u32), f64> = (faces.iter().enumerate())
            .flat_map(|(a, faces)| faces.iter().map(move |face| ((a, face.place), face.open)))
            .collect();
        let is_closed =
            |cell: usize| axes.iter().all(|&a| holders[a].holds(cell) && holders[a].holds(cell - strides[a]));
        let beside = |a: usize, faces: &[CutFace]| -> Vec<u32> {
            let near = faces.iter().filter(|face| subgrid.is_beside_own(face.place as usize));
            near.flat_map(|face| [face.place, face.place + strides[a] as u32]).collect()
        };
        let mut cells: Vec<u32> = axes.iter().flat_map(|&a| beside(a, faces[a])).collect();
        cells.sort_unstable();
        cells.dedup();
        self.closed.clear();
        self.shut.iter_mut().for_each(Vec::clear);
        for cell in cells.into_iter().filter(|&cell| is_closed(cell as usize)) {
            let mut best: Option<(f64, ClosedCell)> = None;
            for &axis in &axes {
                let stride = strides[axis] as u32;
                for (face, other) in [(cell, cell + stride), (cell - stride, cell - stride)] {
                    let Some(&share) = open.get(&(axis, face)) else { continue };
                    if !subgrid.is_unknown(axis, face as usize) {
                        continue;
                    }
                    if best.is_none_or(|(max, _)| share > max + TIE) && !is_closed(other as usize) {
                        best = Some((share, ClosedCell { cell, axis, face }));
                    }
                }
            }
            match best {
                Some((_, closed)) => self.closed.push(closed),
                None => axes.iter().for_each(|&a| self.shut[a].extend([cell - strides[a] as u32, cell])),
            }
        }
        self.shut.iter_mut().for_each(|faces| faces.sort_unstable());
    }

    /// Tells the flow what passes beyond its velocities; collective.
    pub fn note(
        &mut self,
        bodies: &[RigidBody],
        subgrid: &Subgrid,
        flow: &mut Flow,
        transport: &dyn Transport,
    ) {
        let strides = subgrid.layout.strides();
        let Some(passing) = flow.immersed.as_mut().and_then(|immersed| immersed.passing.as_mut()) else {
            return;
        };
        for (component, noted) in self.noted.iter_mut().enumerate() {
            let passing = passing.component_mut(component);
            noted.drain(..).for_each(|place| passing[place as usize] = 0.0);
        }
        for (component, passed) in self.passed.iter().enumerate() {
            let velocity = flow.state.velocity.component(component);
            let passing = passing.component_mut(component);
            let shut = &self.shut[component];
            for Passed { place, body, stencil, offset } in passed {
                if shut.binary_search(place).is_ok() {
                    continue;
                }
                let at = |body: u32, foot: &Vec3| bodies[body as usize].component_at(component, foot);
                let surface = at(*body, &stencil.foot);
                let opposite = stencil.opposite().map(|o| (o.weight, at(o.body, &o.foot)));
                let beyond = stencil.extrapolated(surface, opposite, velocity, strides) - surface;
                passing[*place as usize] = beyond - turning(&bodies[*body as usize], component, offset);
                self.noted[component].push(*place);
            }
        }
        flow.refresh_passing(transport);
        let Some(passing) = flow.immersed.as_mut().and_then(|immersed| immersed.passing.as_mut()) else {
            return;
        };
        let volume = subgrid.cell_volume();
        let left = |closed: &ClosedCell| {
            let cell = closed.cell as usize;
            let through = |a: usize| {
                let p = passing.component(a);
                volume / subgrid.spacing[a] * (p[cell] - p[cell - strides[a]])
            };
            (0..3).filter(|&a| subgrid.active[a]).map(through).sum::<f64>()
        };
        let left: Vec<f64> = self.closed.iter().map(left).collect();
        for (ClosedCell { cell, axis, face }, left) in self.closed.iter().zip(left) {
            let outward = if cell == face { 1.0 } else { -1.0 };
            passing.component_mut(*axis)[*face as usize] -= outward * left * subgrid.spacing[*axis] / volume;
            self.noted[*axis].push(*face);
        }
        flow.refresh_passing(transport);
    }
}
