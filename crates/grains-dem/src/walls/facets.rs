//! Facets of a mesh as elements of their own.
//!
//! The triangles of a facet and the facet itself are listed side by side, and one or the other is met. A facet stands for its
//! triangles where a ball about the particle that holds it, over the facet, is clear of the rim: the particle then touches it as it
//! would touch a plane. Which of both is met depends on where the particle is alone. It is looked at again once the particle has gone
//! as far as the ball is from being clear, or from not being so; what is not met meanwhile is set aside.

use super::list::WallList;
use super::surface_contact::PartMeeting;
use crate::narrow_phase::PlacedPart;
use grains_geometry::{Facet, OverFacet, Vec3, WallMesh};

/// Marks the element of a facet, whose other bits are the number of its first triangle.
const FACET: u32 = 1 << 31;
/// Way (m), as a group counts it, up to which what is set aside is apart.
const ASIDE: f64 = f64::INFINITY;
/// How far the rim is looked for, in clearances.
const RANGE: f64 = 1.5;

/// The element of the facet whose first triangle has this number.
pub(crate) fn facet_element(first: u32) -> u32 {
    FACET | first
}

/// A triangle of the facet that an element of a mesh is; none of a triangle.
#[inline(always)]
pub(crate) fn triangle_of_facet(element: u32) -> Option<u32> {
    (element & FACET != 0).then_some(element & !FACET)
}

/// Whether a facet may stand for its triangles: where it is no wider than the particle of this radius (m) it seldom could.
pub(crate) fn may_stand(facet: &Facet, radius: f64) -> bool {
    facet.width > radius
}

/// Whether a facet over which a particle lies so stands for its triangles, and how far (m) the particle may go, wherever to, until that
/// changes for a particle that touches it.
///
/// Until it has gone so far from the rim, or to it, the ball about it may pass over the rim only while it touches nothing there.
pub(crate) fn stands(over: &OverFacet, clearance: f64) -> (bool, f64) {
    let margin = over.from_rim - clearance;
    (over.is_inside && margin > 0.0, margin.abs())
}

impl WallList {
    /// Finds which facets of a mesh stand for their triangles, for a group whose particle is at `center`, in the mesh's frame, and
    /// acts within `radius` of it (m); `until` tells the way of the group after a free path (m).
    pub(super) fn choose_facets(
        &mut self,
        group: usize,
        (mesh, center, radius): (&WallMesh, &Vec3, f64),
        until: impl Fn(f64) -> f64,
    ) {
        let pairs = self.groups[group].pairs();
        let clearance = mesh.clearance(radius);
        let mut rim_until = f64::INFINITY;
        // All parts are listed with the same elements.
        for k in pairs.start..self.part_end(pairs.start, pairs.end) {
            let Some(triangle) = triangle_of_facet(self.pairs[k].element) else { continue };
            let (facet, over) = (mesh.facet(triangle), mesh.over_facet(triangle, center, RANGE * clearance));
            let (is_met, way) = stands(&over, clearance);
            rim_until = rim_until.min(until(way));
            for k in pairs.clone() {
                match triangle_of_facet(self.pairs[k].element) {
                    Some(other) if other == triangle => self.set_aside(k, !is_met),
                    None if mesh.facet(self.pairs[k].element).first == facet.first => {
                        self.set_aside(k, is_met)
                    }
                    _ => {}
                }
            }
        }
        self.groups[group].rim_until = rim_until;
    }

    /// Sets a pair aside, or takes it back.
    fn set_aside(&mut self, pair: usize, is_aside: bool) {
        let until = &mut self.apart_until[pair];
        if !is_aside {
            if *until == ASIDE {
                *until = f64::NEG_INFINITY;
            }
            return;
        }
        *until = ASIDE;
        if let Some(simplex) = self.simplexes.get_mut(self.pairs[pair].simplex as usize) {
            simplex.len = 0;
        }
    }
}

/// How a part at `center` (m) meets the plane of a facet, on the side on which most of it lies.
///
/// Its core meets it, as it meets triangles.
pub(super) fn facet_meets_part(
    facet: &Facet,
    center: &Vec3,
    part: &PlacedPart,
    meets_plane: impl Fn((&Vec3, &Vec3), &PlacedPart) -> PartMeeting,
) -> PartMeeting {
    let part = PlacedPart { vertices: None, ..*part };
    let height = facet.height(center);
    let normal = match height.abs() < part.bounding_radius {
        // The lowest and the highest point are as far from the middle.
        true => {
            let lowest = part.farthest(&-facet.normal).dot(&facet.normal);
            let highest = part.farthest(&facet.normal).dot(&facet.normal);
            facet.normal * 1.0_f64.copysign(2.0 * height + lowest + highest)
        }
        false => facet.normal * 1.0_f64.copysign(height),
    };
    meets_plane((&facet.origin, &normal), &part)
}

#[cfg(test)]
#[allow(clippy::unwrap_used)]
mod tests {
    use super::*;
    use crate::catalogue::FaceContact;
    use crate::narrow_phase::Pose;
    use crate::walls::Surface;
    use crate::walls::contacts::join_flat_patches;
    use crate::walls::surface_contact::SurfaceContact;
    use grains_geometry::{Mat3, Rotation, SMOOTH_ANGLE, Shape, Simplex, TriMesh};
    use std::sync::Arc;

    /// Numbers that look random.
    struct Random(u64);

    impl Random {
        fn unit(&mut self) -> f64 {
            self.0 = self.0.wrapping_mul(6364136223846793005).wrapping_add(1442695040888963407);
            (self.0 >> 11) as f64 / (1_u64 << 53) as f64
        }

        fn vector(&mut self) -> Vec3 {
            Vec3::from_fn(|_, _| 2.0 * self.unit() - 1.0)
        }
    }

    /// A sheet of side 1 with a hole, cut at random, between two slopes; how it is turned.
    fn sheet(random: &mut Random) -> (Arc<WallMesh>, Mat3) {
        let n = 6 + 3 * (4.0 * random.unit()) as usize;
        let is_hole = |i: usize, j: usize| (i, j) == (n / 2, n / 2);
        let corner = |random: &mut Random, k: usize| {
            let (i, j) = (k % (n + 1), k / (n + 1));
            let is_fixed =
                i == 0 || j == 0 || i == n || j == n || [i, j].iter().all(|k| (n / 2..n / 2 + 2).contains(k));
            let shift = if is_fixed { Vec3::zeros() } else { random.vector() * 0.3 };
            let slope = if i == 0 || i == n { 1.0 } else { 0.0 };
            (Vec3::new(i as f64, j as f64, slope) + Vec3::new(shift.x, shift.y, 0.0) * (1.0 - slope))
                / n as f64
        };
        let vertices: Vec<Vec3> = (0..(n + 1) * (n + 1)).map(|k| corner(random, k)).collect();
        let mut triangles = Vec::new();
        for k in (0..n * n).filter(|k| !is_hole(k % n, k / n)) {
            let a = (k / n * (n + 1) + k % n) as u32;
            let [b, c, d] = [a + 1, a + n as u32 + 2, a + n as u32 + 1];
            triangles.extend(if random.unit() < 0.5 {
                [[a, b, c], [a, c, d]]
            } else {
                [[a, b, d], [b, c, d]]
            });
        }
        let turn = Rotation::new(random.vector() * 3.0);
        let mesh = TriMesh { vertices, triangles }.transformed(&turn, 1.0, &random.vector());
        (Arc::new(WallMesh::new(&mesh, SMOOTH_ANGLE).unwrap()), turn.to_rotation_matrix().into_inner())
    }

    fn shapes() -> Vec<Shape> {
        let edges = Vec3::new(0.1, 0.12, 0.08);
        vec![
            Shape::cuboid(edges, 0.1).unwrap(),
            Shape::cylinder(0.05, 0.12, 0.1).unwrap(),
            Shape::cone([0.06, 0.02], 0.1, 0.1).unwrap(),
            Shape::regular(grains_geometry::RegularSolid::Icosahedron, 0.06, 0.1).unwrap(),
            Shape::regular(grains_geometry::RegularSolid::Tetrahedron, 0.06, 0.1).unwrap(),
            Shape::capsule(0.04, 0.12).unwrap(),
            Shape::superellipsoid(edges * 0.6, [0.4, 0.7], 0.1).unwrap(),
            Shape::sphere(0.05).unwrap(),
        ]
    }

    /// Of each facet that stands for its triangles, what these make of a part together, and what it makes of it.
    fn contacts(
        mesh: &Arc<WallMesh>,
        center: &Vec3,
        part: &PlacedPart,
        faces: FaceContact,
    ) -> Vec<(Vec<SurfaceContact>, Option<SurfaceContact>)> {
        let surface = Surface::Mesh(mesh.clone());
        let found = |element: u32| {
            surface.meets_part(element, center, part, &mut Simplex::default(), faces).unwrap().contact()
        };
        let triangles = 0..mesh.mesh().triangles.len() as u32;
        let (clearance, range) = (mesh.clearance(part.bounding_radius), 3.0 * part.bounding_radius);
        let facets = triangles.clone().filter(|&t| mesh.facet(t).first == t);
        let standing = facets.filter(|&t| stands(&mesh.over_facet(t, center, range), clearance).0);
        let both = standing.map(|first| {
            let own = triangles.clone().filter(|&t| mesh.facet(t).first == first);
            let mut of_triangles: Vec<_> = own.map(found).collect();
            join_flat_patches(&mut of_triangles);
            (of_triangles.into_iter().flatten().collect(), found(facet_element(first)))
        });
        both.collect()
    }

    #[test]
    fn a_facet_that_stands_for_its_triangles_has_the_contact_that_they_had() {
        let mut random = Random(4);
        let (mut standing, mut patches) = (0, 0);
        for round in 0..4000 {
            let (mesh, turn) = sheet(&mut random);
            let shapes = shapes();
            let shape = &shapes[round % shapes.len()];
            let faces = [FaceContact::Point, FaceContact::MultiPoint][round / 8 % 2];
            // Flush, nearly so, or any way.
            let tilt = [0.0, 1e-3, 0.05, 3.0][round / 16 % 4];
            let frame = turn * Rotation::new(random.vector() * tilt).to_rotation_matrix().into_inner();
            let side = if random.unit() < 0.5 { 1.0 } else { -1.0 };
            let part = PlacedPart::of(&Pose { shape, frame: &frame, scale: 1.0 }, 0);
            let lowest = part.farthest(&(turn * Vec3::z() * -side)).dot(&(turn * Vec3::z()));
            let origin = mesh.mesh().vertices[0] - turn * Vec3::z() * mesh_slope(&mesh, &turn);
            let depth = part.crust * (0.02 + 0.8 * random.unit());
            let place = Vec3::new(random.unit(), random.unit(), 0.0);
            let center = origin + turn * place + turn * Vec3::z() * (side * (part.crust - depth) - lowest);
            for (of_triangles, facet) in contacts(&mesh, &center, &part, faces) {
                let what = format!("round {round}: {of_triangles:?}, {facet:?}");
                let Some(facet) = facet else {
                    assert!(of_triangles.iter().all(|contact| contact.overlap < 1e-9 * part.crust), "{what}");
                    continue;
                };
                standing += 1;
                let &[triangles] = &of_triangles[..] else { panic!("{what}") };
                let size = part.bounding_radius;
                // Distances are found by iteration.
                assert!((triangles.normal - facet.normal).norm() < 1e-6, "{what}");
                assert!((triangles.overlap - facet.overlap).abs() < 1e-6 * part.crust, "{what}");
                let along = facet.normal;
                if let (Some(a), Some(b)) = (&triangles.footprint, &facet.footprint) {
                    patches += 1;
                    let pitches = (a.pitch - b.pitch).abs();
                    assert!((a.weight - b.weight).abs() < 1e-4 && pitches < 1e-4 * size, "{what}");
                    // That of a triangle is across the normal of its nearest points, which is oblique beside a tilted body.
                    let seconds = (a.second - b.second).norm();
                    assert!(tilt > 0.01 || seconds < 1e-3 * size * size, "{what}");
                    let between = a.center - b.center;
                    assert!((between - along * between.dot(&along)).norm() < 1e-4 * size, "{what}");
                }
                assert!(
                    (triangles.point - facet.point).dot(&along).abs() < 0.3 * triangles.overlap,
                    "{what}"
                );
            }
        }
        assert!(standing > 1000 && patches > 300, "{standing} {patches}");
    }

    /// Height of the first corner of a sheet over its flat middle (m).
    fn mesh_slope(mesh: &WallMesh, turn: &Mat3) -> f64 {
        let heights = mesh.mesh().vertices.iter().map(|v| v.dot(&(turn * Vec3::z())));
        let first = mesh.mesh().vertices[0].dot(&(turn * Vec3::z()));
        first - heights.fold(f64::INFINITY, f64::min)
    }
}
