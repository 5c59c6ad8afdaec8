//! Hierarchy of axis-aligned boxes for finding the triangles in a box.

use crate::Vec3;
use crate::table::{Table, TableReader, write_table};
use bytemuck::{Pod, Zeroable};

/// Boxes in a leaf.
const LEAF: usize = 4;
/// Nodes waiting during a traversal: one a level, and halving the boxes gives at most 32 levels.
const STACK: usize = 64;

/// Relative difference of squares of distances that counts as rounding.
const TIE: f64 = 1e-14;

/// An axis-aligned box.
#[derive(Clone, Copy, Debug, PartialEq, Pod, Zeroable)]
#[repr(C)]
pub struct Aabb {
    /// Lower corner (m).
    pub lower: Vec3,
    /// Upper corner (m).
    pub upper: Vec3,
}

impl Aabb {
    /// Smallest box around points (m).
    pub fn around<'a>(points: impl IntoIterator<Item = &'a Vec3>) -> Self {
        let empty = Aabb { lower: Vec3::repeat(f64::INFINITY), upper: Vec3::repeat(f64::NEG_INFINITY) };
        points.into_iter().fold(empty, |b, p| Aabb { lower: b.lower.inf(p), upper: b.upper.sup(p) })
    }

    /// Smallest box around both.
    fn union(&self, other: &Aabb) -> Self {
        Aabb { lower: self.lower.inf(&other.lower), upper: self.upper.sup(&other.upper) }
    }

    /// Whether the boxes share a point.
    #[inline]
    fn meets(&self, lower: &Vec3, upper: &Vec3) -> bool {
        // Without branches: their outcome is as good as random in the middle of the tree.
        let along = |k: usize| (self.lower[k] <= upper[k]) & (lower[k] <= self.upper[k]);
        along(0) & along(1) & along(2)
    }

    /// Square (m²) of the distance of a point from the box.
    fn squared_distance(&self, point: &Vec3) -> f64 {
        (point - point.sup(&self.lower).inf(&self.upper)).norm_squared()
    }
}

/// Node of the tree; its left child follows it.
#[derive(Clone, Copy, Debug, Pod, Zeroable)]
#[repr(C)]
struct Node {
    bounds: Aabb,
    /// Right child, or first item of a leaf.
    next: u32,
    /// Items of a leaf, 0 for an inner node.
    count: u32,
}

/// A box of a leaf.
#[derive(Clone, Copy, Debug, Pod, Zeroable)]
#[repr(C)]
struct Item {
    bounds: Aabb,
    /// The index it was given under.
    index: u64,
}

/// A static tree over boxes, halved at the median of their centres along the longest axis.
#[derive(Clone, Debug, Default)]
pub struct Bvh {
    nodes: Table<Node>,
    /// Boxes in the order of the leaves.
    items: Table<Item>,
}

impl Bvh {
    /// Tree over the given boxes.
    pub fn new(boxes: &[Aabb]) -> Self {
        let mut items: Vec<Item> =
            boxes.iter().zip(0..).map(|(&bounds, index)| Item { bounds, index }).collect();
        let mut nodes = Vec::new();
        if !boxes.is_empty() {
            split(&mut nodes, &mut items, 0);
        }
        Bvh { nodes: nodes.into(), items: items.into() }
    }

    /// Appends its arrays to bytes that [`Bvh::read`] reads.
    pub(crate) fn write(&self, bytes: &mut Vec<u8>) {
        write_table(&self.nodes, bytes);
        write_table(&self.items, bytes);
    }

    /// The tree that [`Bvh::write`] wrote.
    pub(crate) fn read(reader: &mut TableReader) -> Option<Self> {
        Some(Self { nodes: reader.next()?, items: reader.next()? })
    }

    /// Calls `f` with the index of every box that meets the box `lower..upper` (m), each once, in an
    /// order that depends on nothing but the boxes.
    #[inline]
    pub fn for_each_in_box(&self, lower: &Vec3, upper: &Vec3, mut f: impl FnMut(u32)) {
        if self.nodes.is_empty() {
            return;
        }
        let mut stack = [0u32; STACK];
        let mut waiting = 1;
        while waiting > 0 {
            waiting -= 1;
            let index = stack[waiting];
            let node = &self.nodes[index as usize];
            if !node.bounds.meets(lower, upper) {
                continue;
            }
            if node.count == 0 {
                stack[waiting] = node.next;
                stack[waiting + 1] = index + 1;
                waiting += 2;
                continue;
            }
            let leaf = node.next as usize..(node.next + node.count) as usize;
            self.items[leaf]
                .iter()
                .filter(|item| item.bounds.meets(lower, upper))
                .for_each(|item| f(item.index as u32));
        }
    }

    /// Index of what lies nearest to a point (m) in a box and the square of its distance (m²), which `squared` tells by the
    /// index; of several as near, but for rounding, the lowest index.
    pub fn nearest(&self, point: &Vec3, squared: impl Fn(u32) -> f64) -> Option<(u32, f64)> {
        let mut best: Option<(u32, f64)> = None;
        let mut stack = [(0u32, 0.0); STACK];
        let mut waiting = usize::from(!self.nodes.is_empty());
        while waiting > 0 {
            waiting -= 1;
            let (index, bound) = stack[waiting];
            if best.is_some_and(|(_, min)| bound > min * (1.0 + TIE)) {
                continue;
            }
            let node = &self.nodes[index as usize];
            if node.count == 0 {
                let child = |i: u32| (i, self.nodes[i as usize].bounds.squared_distance(point));
                let (a, b) = (child(index + 1), child(node.next));
                // The nearer one is looked at first.
                [stack[waiting], stack[waiting + 1]] = if a.1 < b.1 { [b, a] } else { [a, b] };
                waiting += 2;
                continue;
            }
            for item in &self.items[node.next as usize..(node.next + node.count) as usize] {
                let i = item.index as u32;
                let found = squared(i);
                let is_nearer = |(first, min): (u32, f64)| {
                    found * (1.0 + TIE) < min || found <= min * (1.0 + TIE) && i < first
                };
                if best.is_none_or(is_nearer) {
                    best = Some((i, found));
                }
            }
        }
        best
    }
}

/// Appends the subtree over items that come after `before` others, and sorts them as its leaves are.
fn split(nodes: &mut Vec<Node>, items: &mut [Item], before: usize) {
    let bounds = items.iter().fold(items[0].bounds, |b, other| b.union(&other.bounds));
    let (node, count) = (nodes.len(), items.len());
    if count <= LEAF {
        nodes.push(Node { bounds, next: before as u32, count: count as u32 });
        return;
    }
    nodes.push(Node { bounds, next: 0, count: 0 });
    let axis = centre_extent(items).imax();
    let centre = |b: &Aabb| b.lower[axis] + b.upper[axis];
    // The index breaks ties, so that equal boxes always end up in the same order.
    items.select_nth_unstable_by(count / 2, |a, b| {
        centre(&a.bounds).total_cmp(&centre(&b.bounds)).then(a.index.cmp(&b.index))
    });
    let (left, right) = items.split_at_mut(count / 2);
    split(nodes, left, before);
    nodes[node].next = nodes.len() as u32;
    split(nodes, right, before + count / 2);
}

/// Extent of twice the centres of the boxes (m).
fn centre_extent(items: &[Item]) -> Vec3 {
    let first = items[0].bounds.lower + items[0].bounds.upper;
    let spread = items.iter().fold((first, first), |(lower, upper), item| {
        let centre = item.bounds.lower + item.bounds.upper;
        (lower.inf(&centre), upper.sup(&centre))
    });
    spread.1 - spread.0
}
