//! Places of the grid to which multipliers of other ranks reach, or which lie deep inside a body.

use crate::Subgrid;
use crate::constraints::Constraints;
use crate::multiplier::REACH;
use crate::nodes::Nodes;
use crate::point_stencil::PointStencil;

/// Places that a byte tells of.
pub(crate) const CHUNK: usize = 8;

/// Where rows share places with what is more than other rows of this rank: a bit for each place.
#[derive(Default)]
pub(crate) struct SharedPlaces {
    /// Whether other ranks reach there.
    at_border: Vec<u8>,
    /// Whether other ranks do or a body has it deep inside, per component.
    shared: [Vec<u8>; 3],
    /// Whether shared rows of any rank may reach there, per component.
    reached: [Vec<u8>; 3],
    /// [`CHUNK`]s per component, halo included, that shared rows of any rank may reach to.
    pub chunks: [Vec<u32>; 3],
    /// Numbers of the own deep nodes that these rows may reach to.
    pub deep: [Vec<u32>; 3],
}

fn is_set(bits: &[u8], place: usize) -> bool {
    bits[place / CHUNK] >> (place % CHUNK) & 1 == 1
}

fn set(bits: &mut [u8], place: usize) {
    bits[place / CHUNK] |= 1 << (place % CHUNK);
}

impl SharedPlaces {
    /// Marks where other ranks reach and what bodies have deep inside.
    pub fn mark(&mut self, nodes: &Nodes, subgrid: &Subgrid) {
        if self.at_border.is_empty() {
            let places = subgrid.layout.len();
            let room = vec![0; places.div_ceil(CHUNK)];
            self.at_border = room.clone();
            (0..places).filter(|&p| is_at_border(subgrid, p)).for_each(|p| set(&mut self.at_border, p));
            self.shared = std::array::from_fn(|_| room.clone());
            self.reached = std::array::from_fn(|_| room.clone());
        }
        for component in (0..3).filter(|&c| subgrid.active[c]) {
            let shared = &mut self.shared[component];
            shared.copy_from_slice(&self.at_border);
            deep(nodes, component).for_each(|(_, place)| set(shared, place));
        }
    }

    /// Whether a row of a component reaches to places that are marked.
    pub fn is_shared(&self, component: usize, stencil: &PointStencil, strides: [usize; 3]) -> bool {
        stencil.places(strides).any(|place| is_set(&self.shared[component], place))
    }

    /// Finds what shared rows reach to.
    pub fn find_reached(&mut self, constraints: &Constraints, nodes: &Nodes, subgrid: &Subgrid) {
        let Self { at_border, reached, chunks, .. } = self;
        let strides = subgrid.layout.strides();
        for (reached, chunks) in reached.iter_mut().zip(&mut *chunks) {
            reached.copy_from_slice(at_border);
            chunks.clear();
            chunks.extend(at_border.iter().zip(0..).filter(|(bits, _)| **bits != 0).map(|(_, chunk)| chunk));
        }
        for block in &constraints.blocks {
            let component = usize::from(block.component);
            let (reached, chunks) = (&mut reached[component], &mut chunks[component]);
            for place in constraints.stencils[block.shared.clone()].iter().flat_map(|s| s.places(strides)) {
                if reached[place / CHUNK] == 0 {
                    chunks.push((place / CHUNK) as u32);
                }
                set(reached, place);
            }
        }
        for component in (0..3).filter(|&c| subgrid.active[c]) {
            let in_reach = deep(nodes, component).filter(|(_, place)| is_set(&reached[component], *place));
            self.deep[component].clear();
            self.deep[component].extend(in_reach.map(|(number, _)| number));
        }
    }
}

/// Numbers and places of the own nodes of a component that are deep.
fn deep(nodes: &Nodes, component: usize) -> impl Iterator<Item = (u32, usize)> {
    let numbered = (0..).zip(&nodes.of[component]).filter(|(_, node)| node.is_deep());
    numbered.map(|(number, node)| (number, node.place as usize))
}

/// Whether multipliers of other ranks, or of this one across a periodic side, reach to a place.
fn is_at_border(subgrid: &Subgrid, place: usize) -> bool {
    let (indices, reach) = (subgrid.indices(place), REACH as isize);
    let cells = |a: usize| subgrid.layout.cells[a] as isize;
    let is_within = |a: usize| !subgrid.active[a] || (-reach..cells(a) + reach).contains(&indices[a]);
    let is_near = |a: usize| {
        let [low, high] = subgrid.neighbours[a].map(|neighbour| neighbour.is_some());
        subgrid.active[a] && (low && indices[a] < reach || high && indices[a] >= cells(a) - reach)
    };
    (0..3).all(is_within) && (0..3).any(is_near)
}
