//! Hierarchy of axis-aligned boxes for finding the triangles in a box.

use crate::Vec3;

/// Boxes in a leaf.
const LEAF: usize = 4;
/// Nodes waiting during a traversal: one a level, and halving the boxes gives at most 32 levels.
const STACK: usize = 64;

/// Relative difference of squares of distances that counts as rounding.
const TIE: f64 = 1e-14;

/// An axis-aligned box.
#[derive(Clone, Copy, Debug, PartialEq)]
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
#[derive(Clone, Debug)]
struct Node {
    bounds: Aabb,
    /// Right child, or first item of a leaf.
    next: u32,
    /// Items of a leaf, 0 for an inner node.
    count: u32,
}

/// A static tree over boxes, halved at the median of their centres along the longest axis.
#[derive(Clone, Debug, Default)]
pub struct Bvh {
    nodes: Vec<Node>,
    /// Boxes in the order of the leaves, with the index each was given under.
    items: Vec<(Aabb, u32)>,
}

impl Bvh {
    /// Tree over the given boxes.
    pub fn new(boxes: &[Aabb]) -> Self {
        let mut bvh =
            Bvh { nodes: Vec::new(), items: boxes.iter().enumerate().map(|(i, b)| (*b, i as u32)).collect() };
        if !boxes.is_empty() {
            bvh.split(0, boxes.len());
        }
        bvh
    }

    /// Builds the subtree over the items `start..end`.
    fn split(&mut self, start: usize, end: usize) {
        let items = &mut self.items[start..end];
        let bounds = items.iter().fold(items[0].0, |b, (other, _)| b.union(other));
        let node = self.nodes.len();
        let count = end - start;
        if count <= LEAF {
            self.nodes.push(Node { bounds, next: start as u32, count: count as u32 });
            return;
        }
        self.nodes.push(Node { bounds, next: 0, count: 0 });
        let axis = centre_extent(items).imax();
        let centre = |b: &Aabb| b.lower[axis] + b.upper[axis];
        // The index breaks ties, so that equal boxes always end up in the same order.
        items.select_nth_unstable_by(count / 2, |a, b| {
            centre(&a.0).total_cmp(&centre(&b.0)).then(a.1.cmp(&b.1))
        });
        self.split(start, start + count / 2);
        self.nodes[node].next = self.nodes.len() as u32;
        self.split(start + count / 2, end);
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
            self.items[leaf].iter().filter(|(b, _)| b.meets(lower, upper)).for_each(|(_, i)| f(*i));
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
            for (_, i) in &self.items[node.next as usize..(node.next + node.count) as usize] {
                let found = squared(*i);
                let is_nearer = |(first, min): (u32, f64)| {
                    found * (1.0 + TIE) < min || found <= min * (1.0 + TIE) && *i < first
                };
                if best.is_none_or(is_nearer) {
                    best = Some((*i, found));
                }
            }
        }
        best
    }
}

/// Extent of twice the centres of the boxes (m).
fn centre_extent(items: &[(Aabb, u32)]) -> Vec3 {
    let first = items[0].0.lower + items[0].0.upper;
    let spread = items.iter().fold((first, first), |(lower, upper), (b, _)| {
        let centre = b.lower + b.upper;
        (lower.inf(&centre), upper.sup(&centre))
    });
    spread.1 - spread.0
}
