//! Flat faces of a wall mesh: triangles of one plane, joined across the edges they share.
//!
//! A body that touches a facet and not its rim has the contact that a plane would give, however the facet is cut into triangles.

use super::topology::Triangle;
use crate::Vec3;
use crate::table::{Table, TableReader, write_table};
use bytemuck::{Pod, Zeroable};

/// A flat face of a wall mesh.
#[derive(Clone, Copy, Debug, PartialEq, Pod, Zeroable)]
#[repr(C)]
pub struct Facet {
    /// A point of its plane (m).
    pub origin: Vec3,
    /// Unit normal, that of its largest triangle.
    pub normal: Vec3,
    /// Mean width: twice the area over the length of the rim (m).
    pub width: f64,
    /// Its triangle of the lowest number.
    pub first: u32,
    padding: u32,
}

impl Facet {
    /// Distance of a point before its plane (m).
    #[inline]
    pub fn height(&self, point: &Vec3) -> f64 {
        self.normal.dot(&(point - self.origin))
    }
}

/// Where a point lies over some triangles of a facet.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct OverFacet {
    /// Whether the foot of its perpendicular lies on one of them.
    pub is_inside: bool,
    /// Distance from the rim of the facet as far as they have it (m).
    pub from_rim: f64,
}

impl OverFacet {
    /// Over no triangle, with the rim `distance` (m) away.
    pub fn outside(distance: f64) -> Self {
        Self { is_inside: false, from_rim: distance }
    }

    /// The same over the triangles of both.
    #[inline]
    pub fn joined(&self, other: &Self) -> Self {
        Self { is_inside: self.is_inside || other.is_inside, from_rim: self.from_rim.min(other.from_rim) }
    }
}

/// The facets of a mesh.
#[derive(Clone, Debug)]
pub(super) struct Facets {
    pub all: Table<Facet>,
    /// Facet of each triangle.
    pub of_triangle: Table<u32>,
    /// Bits of the edges of each triangle that are on the rim of its facet.
    rims: Table<u8>,
}

/// The plane that a facet grows in.
#[derive(Clone, Copy)]
struct Plane {
    origin: Vec3,
    normal: Vec3,
}

impl Plane {
    fn of(triangle: &Triangle) -> Self {
        Self { origin: triangle.corners[0], normal: triangle.normal }
    }

    /// The plane of the vector area, each triangle counted towards the normal of the first, and of the middle of some triangles.
    fn through(triangles: &[Triangle], members: &[u32]) -> Option<Self> {
        let Triangle { corners: [first, ..], normal, .. } = triangles[members[0] as usize];
        let (mut area, mut moment, mut total) = (Vec3::zeros(), Vec3::zeros(), 0.0);
        for &t in members {
            let [a, b, c] = triangles[t as usize].corners.map(|corner| corner - first);
            let cross = (b - a).cross(&(c - a));
            let size = cross.norm();
            area += cross * 1.0_f64.copysign(cross.dot(&normal));
            moment += (a + b + c) * (size / 3.0);
            total += size;
        }
        Some(Self { origin: first + moment / total, normal: area.try_normalize(0.0)? })
    }

    fn holds(&self, triangle: &Triangle, tolerance: f64) -> bool {
        triangle.corners.iter().all(|corner| self.normal.dot(&(corner - self.origin)).abs() <= tolerance)
    }
}

/// Passes in which the plane of a facet is found from what grew in the one before.
const PASSES: usize = 4;

impl Facets {
    /// Facets of triangles whose corners lie within `tolerance` (m) of one plane.
    pub fn of(triangles: &[Triangle], edges: usize, tolerance: f64) -> Self {
        let across = neighbours_across_edges(triangles, edges);
        const NONE: u32 = u32::MAX;
        let mut of_triangle = vec![NONE; triangles.len()];
        let mut all = Vec::new();
        let mut members = Vec::new();
        // The largest know best how their plane lies.
        let mut seeds: Vec<(f64, u32)> = triangles.iter().map(area).zip(0..).collect();
        seeds.sort_unstable_by(|a, b| b.0.total_cmp(&a.0).then(a.1.cmp(&b.1)));
        for (_, seed) in seeds {
            if of_triangle[seed as usize] != NONE {
                continue;
            }
            let number = all.len() as u32;
            let mut grow = |plane: &Plane, members: &mut Vec<u32>| {
                members.iter().for_each(|&t| of_triangle[t as usize] = NONE);
                members.clear();
                members.push(seed);
                of_triangle[seed as usize] = number;
                let mut next = 0;
                while let Some(&t) = members.get(next) {
                    next += 1;
                    for other in across[t as usize].into_iter().flatten() {
                        let place = &mut of_triangle[other as usize];
                        if *place == NONE && plane.holds(&triangles[other as usize], tolerance) {
                            *place = number;
                            members.push(other);
                        }
                    }
                }
            };
            members.clear();
            let mut plane = Plane::of(&triangles[seed as usize]);
            grow(&plane, &mut members);
            for _ in 0..PASSES {
                let count = members.len();
                let Some(next) = Plane::through(triangles, &members).filter(|_| count > 1) else { break };
                if !members.iter().all(|&t| next.holds(&triangles[t as usize], tolerance)) {
                    break;
                }
                plane = next;
                grow(&plane, &mut members);
                if members.len() == count {
                    break;
                }
            }
            let first = members.iter().fold(seed, |first, &t| first.min(t));
            all.push(Facet { origin: plane.origin, normal: plane.normal, width: 0.0, first, padding: 0 });
        }
        let rims = rims(&across, &of_triangle);
        measure(&mut all, triangles, (&rims, &of_triangle));
        Self { all: all.into(), of_triangle: of_triangle.into(), rims: rims.into() }
    }

    /// Whether edge `k` of a triangle is on the rim of its facet.
    #[inline]
    pub fn is_rim(&self, triangle: u32, k: usize) -> bool {
        is_bit(self.rims[triangle as usize], k)
    }

    /// Appends its arrays to bytes that [`Facets::read`] reads.
    pub fn write(&self, bytes: &mut Vec<u8>) {
        write_table(&self.all, bytes);
        write_table(&self.of_triangle, bytes);
        write_table(&self.rims, bytes);
    }

    /// The facets that [`Facets::write`] wrote.
    pub fn read(reader: &mut TableReader) -> Option<Self> {
        Some(Self { all: reader.next()?, of_triangle: reader.next()?, rims: reader.next()? })
    }
}

/// Finds the widths of facets by the rims of triangles and their facets.
fn measure(facets: &mut [Facet], triangles: &[Triangle], (rims, of_triangle): (&[u8], &[u32])) {
    let mut sizes = vec![[0.0; 2]; facets.len()];
    for ((triangle, &rims), &facet) in triangles.iter().zip(rims).zip(of_triangle) {
        let [a, b, c] = triangle.corners;
        let [sum, rim] = &mut sizes[facet as usize];
        *sum += area(triangle);
        let lengths = [(b - a).norm(), (c - b).norm(), (a - c).norm()];
        *rim += (0..3).filter(|&k| is_bit(rims, k)).map(|k| lengths[k]).sum::<f64>();
    }
    for (facet, [area, rim]) in facets.iter_mut().zip(sizes) {
        facet.width = if rim > 0.0 { 2.0 * area / rim } else { f64::INFINITY };
    }
}

fn is_bit(bits: u8, k: usize) -> bool {
    bits >> k & 1 == 1
}

/// Area (m²).
fn area(triangle: &Triangle) -> f64 {
    let [a, b, c] = triangle.corners;
    0.5 * (b - a).cross(&(c - a)).norm()
}

/// The triangle on the other side of each edge of each triangle, where there is no third one.
fn neighbours_across_edges(triangles: &[Triangle], edges: usize) -> Vec<[Option<u32>; 3]> {
    let mut users = vec![[u32::MAX; 2]; edges];
    let mut counts = vec![0_u32; edges];
    for (t, triangle) in triangles.iter().enumerate() {
        for edge in triangle.edges.map(|edge| edge as usize) {
            if let Some(place) = users[edge].get_mut(counts[edge] as usize) {
                *place = t as u32;
            }
            counts[edge] += 1;
        }
    }
    let inward = |t: u32, edge: u32| {
        let Triangle { inward, edges, .. } = &triangles[t as usize];
        edges
            .iter()
            .zip(inward)
            .find(|(other, _)| **other == edge)
            .map_or(Vec3::zeros(), |(_, inward)| *inward)
    };
    let other = |t: usize, edge: u32| {
        let [a, b] = users[edge as usize];
        let goes_on = counts[edge as usize] == 2 && inward(a, edge).dot(&inward(b, edge)) < 0.0;
        goes_on.then_some(if a == t as u32 { b } else { a })
    };
    triangles.iter().enumerate().map(|(t, triangle)| triangle.edges.map(|edge| other(t, edge))).collect()
}

/// Bits of the edges of each triangle that have no other triangle of the same facet.
fn rims(across: &[[Option<u32>; 3]], of_triangle: &[u32]) -> Vec<u8> {
    let is_rim = |t: usize, other: Option<u32>| {
        other.is_none_or(|other| of_triangle[other as usize] != of_triangle[t])
    };
    across
        .iter()
        .enumerate()
        .map(|(t, others)| (0..3).map(|k| u8::from(is_rim(t, others[k])) << k).sum())
        .collect()
}
