//! Values of cells on the faces between them, row by row.

use crate::boundary::BoundaryData;
use crate::metrics::Local;
use crate::openings::Openings;
use crate::{Centre, Faces, Field, Halo};
use grains_domain::Transport;

/// A row of upper faces normal to an axis, halo included, with the shares of the cells below and above.
pub(super) struct FaceRow<'a> {
    pub axis: usize,
    pub start: usize,
    pub length: usize,
    stride: usize,
    /// One number for all faces, or one for each.
    shares: [&'a [f64]; 2],
}

impl FaceRow<'_> {
    /// Adds what open faces gain from closed ones beside them.
    pub fn gain(&self, openings: Option<&Openings>, faces: &mut [f64]) {
        let Some(openings) = openings else { return };
        let own = self.start..self.start + self.length;
        let gains = &openings.gains.component(self.axis)[own.clone()];
        faces[own].iter_mut().zip(gains).for_each(|(face, gain)| *face *= gain);
    }

    /// Linear interpolation of centre values to the faces.
    pub fn interpolate(&self, centre: &Field<Centre>, faces: &mut [f64]) {
        let n = self.length;
        let (below, above) =
            (&centre.data()[self.start..][..n], &centre.data()[self.start + self.stride..][..n]);
        let out = faces[self.start..][..n].iter_mut().zip(below.iter().zip(above));
        match self.shares {
            [[low], [high]] => out.for_each(|(face, (below, above))| *face = low * below + high * above),
            [low, high] => {
                let shares = low.iter().zip(high);
                out.zip(shares).for_each(|((face, (a, b)), (low, high))| *face = low * a + high * b);
            }
        }
    }
}

/// Fills a field with its halo and ghosts, and interpolates it to the faces; collective.
pub(super) fn on_faces(
    field: &mut Field<Centre>,
    faces: &mut Faces,
    openings: Option<&Openings>,
    (local, boundary_data, halo): (&Local, &[BoundaryData], &mut Halo),
    transport: &dyn Transport,
) {
    halo.fill(&mut [field.data_mut()], transport);
    boundary_data.iter().for_each(|face_data| face_data.fill_even(field));
    for axis in 0..3 {
        for_rows(local, axis, |row| {
            row.interpolate(field, faces.component_mut(axis));
            row.gain(openings, faces.component_mut(axis));
        });
    }
}

/// All rows of faces normal to an axis, but those of the last layer: they have no neighbour above, no stencil reads them.
pub(super) fn for_rows(local: &Local, axis: usize, mut job: impl FnMut(FaceRow<'_>)) {
    let (mut dims, strides, m) = (local.layout.dims(), local.layout.strides(), &local.axes[axis]);
    dims[axis] -= 1;
    for k in 0..dims[2] {
        for j in 0..dims[1] {
            let entries = match axis {
                0 => 0..dims[0],
                1 => j..j + 1,
                _ => k..k + 1,
            };
            // The share of the cell below a face in its value is that of the cell above in its control volume.
            let shares = [&m.upper_share[entries.clone()], &m.lower_share[entries]];
            let start = j * strides[1] + k * strides[2];
            job(FaceRow { axis, start, length: dims[0], stride: strides[axis], shares });
        }
    }
}
