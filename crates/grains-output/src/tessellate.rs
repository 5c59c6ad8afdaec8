//! True surfaces of particles: reference surfaces turned, scaled and moved to each body.

use crate::shapes::ReferenceSurface;

/// Where bodies are and which shape they have.
#[derive(Clone, Copy, Debug)]
pub struct Bodies<'a> {
    /// Number of the reference surface, `[bodies]`.
    pub shape: &'a [i64],
    /// Position (m), `[bodies][3]`.
    pub position: &'a [f64],
    /// Unit quaternion w, x, y, z from body to world, `[bodies][4]`.
    pub orientation_wxyz: &'a [f64],
    /// Size over that of the reference surface (-), `[bodies]`.
    pub scale: &'a [f64],
}

/// Triangles of all bodies, ready for a surface file; keep it to reuse its memory.
#[derive(Clone, Debug, Default)]
pub struct Tessellation {
    /// Positions (m), `[points][3]`.
    pub points: Vec<f64>,
    /// Point numbers, `[triangles][3]`.
    pub triangles: Vec<i64>,
    /// Body of each triangle, `[triangles]`.
    pub owner: Vec<usize>,
}

impl Tessellation {
    /// Places the surface of every body: x = scale · R(q) v + position for each vertex v.
    ///
    /// A body whose shape has no reference surface gets no triangles.
    pub fn fill(&mut self, surfaces: &[ReferenceSurface], bodies: &Bodies) {
        self.points.clear();
        self.triangles.clear();
        self.owner.clear();
        for (body, &shape) in bodies.shape.iter().enumerate() {
            let Some(surface) = usize::try_from(shape).ok().and_then(|s| surfaces.get(s)) else { continue };
            let q = &bodies.orientation_wxyz[4 * body..4 * body + 4];
            let rotation = rotation_matrix([q[0], q[1], q[2], q[3]]);
            let (position, scale) = (&bodies.position[3 * body..3 * body + 3], bodies.scale[body]);
            let first = (self.points.len() / 3) as i64;
            for v in surface.vertices {
                let place = |row: &[f64; 3]| scale * (row[0] * v[0] + row[1] * v[1] + row[2] * v[2]);
                self.points.extend(rotation.iter().zip(position).map(|(row, x)| place(row) + x));
            }
            self.triangles.extend(surface.triangles.iter().flatten().map(|&k| first + i64::from(k)));
            self.owner.extend(surface.triangles.iter().map(|_| body));
        }
    }

    /// A value per triangle from values per body, `[bodies][components]`.
    pub fn per_triangle<T: Copy>(&self, values: &[T], components: usize) -> Vec<T> {
        let row = |&body: &usize| values[body * components..(body + 1) * components].iter().copied();
        self.owner.iter().flat_map(row).collect()
    }
}

/// Rows of the rotation matrix of a unit quaternion w, x, y, z.
fn rotation_matrix([w, x, y, z]: [f64; 4]) -> [[f64; 3]; 3] {
    [
        [1.0 - 2.0 * (y * y + z * z), 2.0 * (x * y - w * z), 2.0 * (x * z + w * y)],
        [2.0 * (x * y + w * z), 1.0 - 2.0 * (x * x + z * z), 2.0 * (y * z - w * x)],
        [2.0 * (x * z - w * y), 2.0 * (y * z + w * x), 1.0 - 2.0 * (x * x + y * y)],
    ]
}

#[cfg(test)]
mod tests {
    use super::{Bodies, Tessellation};
    use crate::shapes::ReferenceSurface;

    #[test]
    fn a_quarter_turn_about_z_takes_x_to_y() {
        let half = std::f64::consts::FRAC_1_SQRT_2;
        let surface = ReferenceSurface {
            vertices: &[[1.0, 0.0, 0.0], [0.0, 1.0, 0.0], [0.0, 0.0, 1.0]],
            triangles: &[[0, 1, 2]],
        };
        let bodies = Bodies {
            shape: &[5, 0],
            position: &[0.0, 0.0, 0.0, 10.0, 20.0, 30.0],
            orientation_wxyz: &[1.0, 0.0, 0.0, 0.0, half, 0.0, 0.0, half],
            scale: &[1.0, 2.0],
        };
        let mut all = Tessellation::default();
        all.fill(&[surface], &bodies);
        let expected = [10.0, 22.0, 30.0, 8.0, 20.0, 30.0, 10.0, 20.0, 32.0];
        assert!(all.points.iter().zip(expected).all(|(a, b)| (a - b).abs() < 1e-12), "{:?}", all.points);
        assert_eq!((all.triangles.clone(), all.owner.clone()), (vec![0, 1, 2], vec![1]));
        assert_eq!(all.per_triangle(&[1, 2, 3, 4], 2), [3, 4]);
    }
}
