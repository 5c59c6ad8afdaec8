//! Wall meshes in memory that the processes of a node share: one builds it, the others read it where it is.

use super::{WallMesh, WallReport};
use crate::bvh::Bvh;
use crate::mesh::{MeshReport, TriMesh, WeldReport};
use crate::surface::facets::Facets;
use crate::table::{TableReader, write_table};
use memmap2::Mmap;
use std::sync::Arc;

impl WallMesh {
    /// The arrays of the mesh, for [`WallMesh::in_memory`] of the same program on the same machine.
    pub fn bytes(&self) -> Vec<u8> {
        let WallReport { weld, duplicate_triangles, split_triangles, mesh } = &self.report;
        let counts = [
            weld.merged_vertices,
            weld.degenerate_triangles,
            *duplicate_triangles,
            *split_triangles,
            mesh.open_edges,
            mesh.non_manifold_edges,
            mesh.smallest_triangle,
        ];
        let tolerances = [self.side_tolerance, self.corner_tolerance, self.smooth_sine, self.smooth_cosine];
        let mut bytes = Vec::new();
        write_table(&counts.map(|count| count as u64), &mut bytes);
        write_table(&[mesh.lower, mesh.upper], &mut bytes);
        write_table(&[mesh.smallest_area, mesh.area], &mut bytes);
        write_table(&tolerances, &mut bytes);
        write_table(&self.mesh.vertices, &mut bytes);
        write_table(&self.mesh.triangles, &mut bytes);
        write_table(&self.triangles, &mut bytes);
        write_table(&self.edges, &mut bytes);
        write_table(&self.vertices, &mut bytes);
        write_table(&self.sides, &mut bytes);
        write_table(&self.spokes, &mut bytes);
        write_table(&self.spoke_edges, &mut bytes);
        write_table(&self.neighbours, &mut bytes);
        self.facets.write(&mut bytes);
        self.bvh.write(&mut bytes);
        bytes
    }

    /// The mesh whose bytes these are, read where they are; `None` of others.
    ///
    /// A process keeps vertices and corners of the triangles of its own.
    pub fn in_memory(bytes: &Arc<Mmap>) -> Option<Self> {
        let mut reader = TableReader::new(bytes);
        let counts = reader.next::<u64>()?;
        let counts: [u64; 7] = counts.as_ref().try_into().ok()?;
        let [merged, degenerate, duplicates, splits, open, non_manifold, smallest] =
            counts.map(|count| count as usize);
        let extents = reader.next()?;
        let [lower, upper] = extents.as_ref().try_into().ok()?;
        let areas = reader.next()?;
        let [smallest_area, area] = areas.as_ref().try_into().ok()?;
        let tolerances = reader.next()?;
        let [side_tolerance, corner_tolerance, smooth_sine, smooth_cosine] =
            tolerances.as_ref().try_into().ok()?;
        Some(Self {
            report: WallReport {
                weld: WeldReport { merged_vertices: merged, degenerate_triangles: degenerate },
                duplicate_triangles: duplicates,
                split_triangles: splits,
                mesh: MeshReport {
                    open_edges: open,
                    non_manifold_edges: non_manifold,
                    lower,
                    upper,
                    smallest_triangle: smallest,
                    smallest_area,
                    area,
                },
            },
            mesh: TriMesh { vertices: reader.next()?.to_vec(), triangles: reader.next()?.to_vec() },
            triangles: reader.next()?,
            edges: reader.next()?,
            vertices: reader.next()?,
            sides: reader.next()?,
            spokes: reader.next()?,
            spoke_edges: reader.next()?,
            neighbours: reader.next()?,
            facets: Facets::read(&mut reader)?,
            bvh: Bvh::read(&mut reader)?,
            side_tolerance,
            corner_tolerance,
            smooth_sine,
            smooth_cosine,
        })
    }
}
