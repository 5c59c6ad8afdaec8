//! Velocities next to a surface: how each follows those in the fluid.

use crate::extrapolation::Rule;
use crate::interface_stencil::InterfaceStencil;
use crate::node::{Node, RIGID};
use crate::profile::{Normals, Profile, Target};
use crate::solid_mask::{Holders, SolidMask};
use crate::wall::{ClosestPoint, Solids};
use grains_geometry::Vec3;
use grains_geometry::lanes::{LANES, Lanes, Number, Vector};
use multiversion::multiversion;

/// What interface stencils of a component are found from.
pub(crate) struct Near<'a> {
    pub component: usize,
    pub mask: &'a SolidMask,
    /// Closest points of the surfaces, by the number of the interface.
    pub out: &'a [ClosestPoint],
    pub rule: Rule,
}

/// Finds how velocities next to a surface are extrapolated, and numbers those that are anew.
#[multiversion(targets("x86_64+avx512f+avx512vl+avx512dq+avx2", "x86_64+avx2"))]
pub(crate) fn extrapolate(
    nodes: &mut [Node],
    near: &Near,
    interfaces: &mut [InterfaceStencil],
    solids: &Solids,
) {
    match near.rule.samples {
        1 => extrapolate_from::<1>(nodes, near, interfaces, solids),
        2 => extrapolate_from::<2>(nodes, near, interfaces, solids),
        _ => extrapolate_from::<3>(nodes, near, interfaces, solids),
    }
}

/// The same from a number of points in the fluid, of as many velocities side by side as the processor has lanes.
#[inline(always)]
fn extrapolate_from<const N: usize>(
    nodes: &mut [Node],
    &Near { component, mask, out, rule }: &Near,
    interfaces: &mut [InterfaceStencil],
    solids: &Solids,
) {
    let subgrid = solids.subgrid;
    let (mut positions, mut made) = (subgrid.positions(component), 0);
    let zero = Vector::of(&Vec3::zeros());
    let (mut velocities, mut directions, mut distances) = (zero, zero, Lanes::of(0.0));
    let (mut members, mut numbers) = ([0; LANES], 0..nodes.len());
    loop {
        let mut count = 0;
        for number in numbers.by_ref().filter(|&number| !nodes[number].is_deep()) {
            let (node, lane) = (&nodes[number], count);
            let surface = &out[node.interface as usize].surface;
            velocities.set(lane, &positions.at(node.place as usize));
            directions.set(lane, &surface.direction);
            distances.0[lane] = surface.distance;
            members[lane] = number;
            count += 1;
            if count == LANES {
                break;
            }
        }
        if count == 0 {
            return;
        }
        let normals = Normals::through(&velocities, (&directions, distances), subgrid);
        let samples = normals.samples::<N>(rule, component, subgrid);
        for (lane, &number) in members[..count].iter().enumerate() {
            let node = &nodes[number];
            let holders = Holders { mask, nodes };
            let (place, out) = (node.place as usize, &out[node.interface as usize]);
            let (target, found) = (Target { subgrid, place, holders, rule, out }, &mut interfaces[made]);
            let is_made = target.take(&samples, lane, found)
                || Profile { target, component, solids, normal: normals.get(lane) }.partial(found);
            nodes[number].interface = if is_made { made as u32 } else { RIGID };
            made += usize::from(is_made);
        }
    }
}
