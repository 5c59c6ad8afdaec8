//! The convex pieces of a mesh of unit size: cut along voxels, then united as far as that is wanted.

use super::DecompositionOptions;
use crate::mesh::leaders;
use crate::{ConvexHull, MassProperties, TriMesh, Vec3};
use parry3d_f64::math::Vector;
use parry3d_f64::transformation::try_convex_hull;
use parry3d_f64::transformation::vhacd::{VHACD, VHACDParameters};
use parry3d_f64::transformation::voxelization::{FillMode, Voxel, VoxelSet, VoxelizedVolume};
use std::cell::Cell;
use std::collections::BTreeSet;
use std::panic::{UnwindSafe, catch_unwind};

/// Points of a piece closer than this become one (voxels).
const WELD: f64 = 0.05;
/// Pieces whose inscribed radius is less are united with a neighbour (voxels).
const THIN: f64 = 0.25;
/// Unions that add less than this to the volume, relative to the whole, are always made.
const FREE: f64 = 2e-3;
/// A mesh is convex if its hull exceeds its volume by less than this, relative to the volume.
const FILLED: f64 = 1e-6;
/// Concavity up to which a piece is not cut further: hull less piece, relative to the hull of the whole.
const CONCAVITY: f64 = 0.0025;

/// Corners of the convex pieces of a mesh, and how they came about.
#[derive(Clone, Debug, Default, PartialEq)]
pub(crate) struct Pieces {
    /// Corners of each piece.
    pub hulls: Vec<Vec<Vec3>>,
    /// Pieces cut.
    pub found: usize,
    /// Pieces united with others.
    pub merged: usize,
    /// Flat pieces dropped.
    pub dropped: usize,
}

/// A convex piece.
#[derive(Clone)]
struct Piece {
    hull: ConvexHull,
    volume: f64,
    /// Depth of its centre of mass.
    inscribed: f64,
    lower: Vec3,
    upper: Vec3,
}

impl Piece {
    /// The hull of points; `None` if they are flat.
    fn new(points: &[Vec3], weld: f64) -> Option<Self> {
        let leader = leaders(points, weld);
        let kept = points.iter().zip(&leader).enumerate().filter(|(i, (_, l))| *i as u32 == **l);
        let kept: Vec<Vec3> = kept.map(|(_, (p, _))| *p).collect();
        let hull = ConvexHull::new(&kept).ok()?;
        let triangles = hull.triangles();
        let mass = MassProperties::of_closed_mesh(&triangles);
        let (lower, upper) = triangles.extents();
        Some(Self { volume: mass.volume, inscribed: hull.depth_of(&mass.center), hull, lower, upper })
    }

    /// Whether the boxes around two pieces meet.
    fn is_near(&self, other: &Self, margin: f64) -> bool {
        (0..3).all(|a| self.lower[a] <= other.upper[a] + margin && other.lower[a] <= self.upper[a] + margin)
    }

    fn union(&self, other: &Self, weld: f64) -> Option<Self> {
        let points: Vec<Vec3> = self.hull.vertices.iter().chain(&other.hull.vertices).copied().collect();
        Self::new(&points, weld)
    }
}

impl Pieces {
    /// Of a closed mesh of unit size; `None` if the decomposition fails.
    pub(super) fn of(unit: &TriMesh, options: &DecompositionOptions) -> Option<Self> {
        if let Some(hull) = convex(unit) {
            return Some(Self { hulls: vec![hull.vertices], found: 1, ..Self::default() });
        }
        let voxel = 1.0 / f64::from(options.resolution);
        let weld = WELD * voxel;
        let cut = cut(unit, options)?;
        let pieces: Vec<Piece> = cut.iter().filter_map(|points| Piece::new(points, weld)).collect();
        let (found, dropped) = (cut.len(), cut.len() - pieces.len());
        let united = unite(pieces, options.max_parts as usize, voxel);
        let merged = found - dropped - united.len();
        let hulls: Vec<_> = united.into_iter().map(|p| p.hull.vertices).collect();
        (!hulls.is_empty()).then_some(Self { hulls, found, merged, dropped })
    }
}

/// The hull of a mesh that fills its hull.
fn convex(unit: &TriMesh) -> Option<ConvexHull> {
    let hull = ConvexHull::new(&unit.vertices).ok()?;
    let volume = |mesh: &TriMesh| MassProperties::of_closed_mesh(mesh).volume;
    (volume(&hull.triangles()) <= volume(unit) * (1.0 + FILLED)).then_some(hull)
}

thread_local! {
    /// Whether a panic of this thread would be caught here.
    static CATCHES: Cell<bool> = const { Cell::new(false) };
}

/// Whether a panic of this thread is caught by this crate and becomes an error: a panic hook that ends the program must
/// not do so then.
pub fn catches_panics() -> bool {
    CATCHES.get()
}

/// The result of `work`, none if it panics.
fn caught<T>(work: impl FnOnce() -> T + UnwindSafe) -> Option<T> {
    CATCHES.set(true);
    let result = catch_unwind(work);
    CATCHES.set(false);
    result.ok()
}

/// Points that span each piece: where the mesh crosses its voxels, and the corners of its voxels that lie
/// inside the mesh along a cut.
fn cut(unit: &TriMesh, options: &DecompositionOptions) -> Option<Vec<Vec<Vec3>>> {
    let points: Vec<Vector> = unit.vertices.iter().map(|v| Vector::new(v.x, v.y, v.z)).collect();
    let parameters = VHACDParameters {
        resolution: options.resolution,
        max_convex_hulls: options.max_parts,
        concavity: CONCAVITY,
        ..VHACDParameters::default()
    };
    // The library asserts where it meets a set of points without a hull.
    let found = caught(|| {
        let fill = FillMode::FloodFill { detect_cavities: false };
        let volume = VoxelizedVolume::voxelize(&points, &unit.triangles, options.resolution, fill, true);
        let voxels = VoxelSet::from(volume);
        let place = |v: &Voxel| [v.coords.x, v.coords.y, v.coords.z];
        let crossed: BTreeSet<_> = voxels.voxels().iter().filter(|v| v.is_on_surface).map(place).collect();
        let cut = VHACD::from_voxels(&parameters, voxels);
        let pieces = cut.voxel_parts().iter().map(|piece| {
            let mut corners = piece.compute_primitive_intersections(&points, &unit.triangles);
            let along_cut = piece.voxels().iter().filter(|v| v.is_on_surface && !crossed.contains(&place(v)));
            corners.extend(along_cut.flat_map(|v| voxel_corners(piece, v)));
            // Its hulls are quick but not exact to rounding: they only sort out most of the points inside.
            try_convex_hull(&corners).map_or(corners, |(hull, _)| hull)
        });
        pieces.collect::<Vec<_>>()
    });
    let vector = |p: &Vector| Vec3::new(p.x, p.y, p.z);
    Some(found?.iter().map(|piece| piece.iter().map(vector).collect()).collect())
}

fn voxel_corners(set: &VoxelSet, voxel: &Voxel) -> impl Iterator<Item = Vector> + use<> {
    let (half, middle) = (set.scale / 2.0, set.get_voxel_point(voxel));
    let sign = move |bits: u32, k: u32| if bits >> k & 1 == 1 { half } else { -half };
    (0..8).map(move |bits| middle + Vector::new(sign(bits, 0), sign(bits, 1), sign(bits, 2)))
}

/// Unites pieces, always the pair whose common hull adds the smallest volume: until there are no more
/// than `most` and none is thin, and as long as it costs nearly nothing.
fn unite(mut pieces: Vec<Piece>, max: usize, voxel: f64) -> Vec<Piece> {
    let total: f64 = pieces.iter().map(|p| p.volume).sum();
    let mut unions: Vec<Union> = Vec::new();
    for j in 1..pieces.len() {
        unions.extend((0..j).filter_map(|i| Union::of(&pieces, i, j, voxel)));
    }
    loop {
        let is_thin = |k: usize| pieces[k].inscribed < THIN * voxel;
        let must = pieces.len() > max;
        let candidate = |u: &&Union| must || u.cost <= FREE * total || is_thin(u.first) || is_thin(u.second);
        let Some(best) = unions.iter().filter(candidate).min_by(|a, b| a.cost.total_cmp(&b.cost)) else {
            return pieces;
        };
        let (first, second, piece) = (best.first, best.second, best.piece.clone());
        pieces[first] = piece;
        pieces.remove(second);
        unions.retain(|u| ![u.first, u.second].iter().any(|k| *k == first || *k == second));
        for union in &mut unions {
            union.first -= usize::from(union.first > second);
            union.second -= usize::from(union.second > second);
        }
        let others = (0..pieces.len()).filter(|&k| k != first);
        let fresh: Vec<_> =
            others.filter_map(|k| Union::of(&pieces, first.min(k), first.max(k), voxel)).collect();
        unions.extend(fresh);
    }
}

/// The common hull of two pieces.
struct Union {
    first: usize,
    second: usize,
    piece: Piece,
    /// Volume it adds.
    cost: f64,
}

impl Union {
    /// Of pieces `first` < `second`, if they are neighbours.
    fn of(pieces: &[Piece], first: usize, second: usize, voxel: f64) -> Option<Self> {
        let (a, b) = (&pieces[first], &pieces[second]);
        let piece = a.is_near(b, voxel).then(|| a.union(b, WELD * voxel))??;
        Some(Self { first, second, cost: piece.volume - a.volume - b.volume, piece })
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use std::sync::atomic::{AtomicU32, Ordering};

    /// Panics that a hook sees as caught, and others.
    static SEEN: [AtomicU32; 2] = [const { AtomicU32::new(0) }; 2];

    #[test]
    fn a_hook_can_tell_the_panics_that_become_errors() {
        std::panic::set_hook(Box::new(|_| {
            SEEN[usize::from(catches_panics())].fetch_add(1, Ordering::Relaxed);
        }));
        assert_eq!(caught(|| 3), Some(3));
        assert_eq!(caught(|| -> u32 { panic!("no hull") }), None);
        let _ = catch_unwind(|| panic!("a bug"));
        let _ = std::panic::take_hook();
        assert_eq!(SEEN.each_ref().map(|n| n.load(Ordering::Relaxed)), [1, 1]);
    }
}
