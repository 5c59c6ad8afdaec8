//! The velocities of the fluid inside walls.

use crate::Subgrid;
use crate::cut_faces::CutFace;
use crate::node::{Depth, Node};
use crate::solid_mask::SolidMask;
use crate::wall::{ClosestPoint, WallRun};
use grains_geometry::Vec3;

/// Velocities of a component inside walls, kept while these stay where they are, wall by wall; bodies are numbers of walls.
#[derive(Clone, Debug, Default)]
pub(crate) struct WallNodes {
    /// Where each wall begins in the lists below.
    begins: Vec<WallBegin>,
    pub own: Vec<Node>,
    /// From the centre of the wall, or of its image, to each of these (m).
    pub arms: Vec<Vec3>,
    pub closest_points: Vec<ClosestPoint>,
    /// Places in the halo, and their walls.
    pub halo: Vec<(u32, u32)>,
    /// Faces that walls cut, halo included.
    pub cut: Vec<CutFace>,
}

/// Where a wall begins in the lists of [`WallNodes`].
#[derive(Clone, Copy, Debug)]
struct WallBegin {
    own: usize,
    closest_points: usize,
    halo: usize,
    cut: usize,
}

impl WallNodes {
    /// Notes that what is added from here on is of the next wall.
    pub fn begin_wall(&mut self) {
        self.begins.push(WallBegin {
            own: self.own.len(),
            closest_points: self.closest_points.len(),
            halo: self.halo.len(),
            cut: self.cut.len(),
        });
    }

    /// Forgets what walls from one on hold.
    pub fn forget_from(&mut self, wall: usize) {
        let Some(begin) = self.begins.get(wall).copied() else { return };
        self.begins.truncate(wall);
        self.own.truncate(begin.own);
        self.arms.truncate(begin.own);
        self.closest_points.truncate(begin.closest_points);
        self.halo.truncate(begin.halo);
        self.cut.truncate(begin.cut);
    }

    /// Adds what no earlier wall holds of a run of velocities in a wall; all but the first are deep.
    pub fn add(
        &mut self,
        run: &WallRun,
        (component, wall): (usize, u32),
        subgrid: &Subgrid,
        mask: &mut SolidMask,
    ) {
        let [first, j, k] = run.first;
        let place = subgrid.layout.index(first, j, k);
        self.cut.extend(CutFace::new(component, place, (wall, run.out), subgrid));
        if !run.is_solid {
            return;
        }
        for (m, i) in (first..first + run.count as isize).enumerate() {
            let place = subgrid.layout.index(i, j, k);
            if mask.contains(place) {
                continue;
            }
            mask.set_halo(place, 0);
            if !subgrid.is_own(component, [i, j, k]) {
                self.halo.push((place as u32, wall));
                continue;
            }
            let mut out = run.out;
            out.arm.x += m as f64 * subgrid.spacing.x;
            let node = Node::new(place, wall, &Depth::of(&out, subgrid), &mut self.closest_points);
            self.own.push(node);
            self.arms.push(out.arm);
        }
    }
}
