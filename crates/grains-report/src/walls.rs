//! Walls in the states of a page: their triangles once, and how they have moved since.

use crate::block::{Array, Block};
use grains_output::{FileError, SurfaceFile, Triangles};
use nalgebra::{Matrix3, Rotation3, Vector3};
use serde::Serialize;
use std::path::Path;

/// Triangles of all walls in all states at most.
const TRIANGLES: usize = 60_000;
/// Distance, over the size of a wall, up to which it counts as moved without deforming.
const RIGID: f64 = 1e-5;

/// A wall as the page reads it.
#[derive(Debug, Serialize)]
pub struct Wall {
    name: String,
    /// Its surfaces: one, unless it deforms.
    surfaces: Vec<Surface>,
    /// Of each state the number of its surface, and how this has moved; none where there is no wall.
    poses: Vec<Option<Pose>>,
}

#[derive(Debug, Serialize)]
struct Surface {
    vertices: Array,
    triangles: Array,
}

#[derive(Clone, Debug, PartialEq, Serialize)]
struct Pose {
    surface: usize,
    /// Rows of the rotation, then the displacement (m), rounded to 32 bits.
    motion: [f32; 12],
}

/// Reads the walls at some times (s), each in the stored state that is nearest; what is left out goes to the notes.
///
/// # Errors
/// A file that cannot be read.
pub fn read(
    path: &Path,
    times: &[f64],
    names: &[String],
    (block, notes): (&mut Block, &mut Vec<String>),
) -> Result<Vec<Wall>, FileError> {
    let file = SurfaceFile::open(path)?;
    let stored = file.times();
    let mut walls: Vec<(Wall, Vec<Vec<Vector3<f64>>>)> = Vec::new();
    let (mut triangles, mut left_out) = (0, false);
    for (state, time) in times.iter().enumerate() {
        let Some(step) = nearest(&stored, *time) else { break };
        let parts = split(&file.triangles(step)?, &file.integer(step, "wall")?);
        for (number, (points, corners)) in
            parts.into_iter().enumerate().filter(|(_, part)| !part.1.is_empty())
        {
            while walls.len() <= number {
                let name = names.get(walls.len()).cloned().unwrap_or_default();
                walls.push((Wall { name, surfaces: Vec::new(), poses: vec![None; times.len()] }, Vec::new()));
            }
            let (wall, surfaces) = &mut walls[number];
            let moved = surfaces.last().and_then(|points_before| motion(points_before, &points));
            let motion = match moved {
                Some(motion) => motion,
                None if triangles + corners.len() > TRIANGLES => {
                    left_out = true;
                    continue;
                }
                None => {
                    triangles += corners.len();
                    wall.surfaces.push(Surface {
                        vertices: block.reals(
                            points.iter().flat_map(|p| [p.x, p.y, p.z]).collect::<Vec<_>>().into_iter(),
                        ),
                        triangles: block.integers(corners.as_flattened().iter().copied()),
                    });
                    surfaces.push(points);
                    REST
                }
            };
            wall.poses[state] = Some(Pose { surface: wall.surfaces.len() - 1, motion });
        }
    }
    if left_out {
        notes.push(format!(
            "Of the walls {TRIANGLES} triangles are here at most; some walls or states lack theirs."
        ));
    }
    Ok(walls.into_iter().map(|(wall, _)| wall).collect())
}

const REST: [f32; 12] = [1.0, 0.0, 0.0, 0.0, 1.0, 0.0, 0.0, 0.0, 1.0, 0.0, 0.0, 0.0];

/// Number of the time that is nearest to another; none of none.
pub fn nearest(times: &[f64], time: f64) -> Option<usize> {
    let distance = |k: &usize| (times[*k] - time).abs();
    (0..times.len()).min_by(|a, b| distance(a).total_cmp(&distance(b)))
}

/// Points (m) and triangles of a wall.
type WallTriangles = (Vec<Vector3<f64>>, Vec<[u32; 3]>);

/// Points and triangles of each wall.
fn split(all: &Triangles, walls: &[i64]) -> Vec<WallTriangles> {
    let mut parts: Vec<WallTriangles> = Vec::new();
    let mut place_of = vec![u32::MAX; all.points.len() / 3];
    for (corners, &wall) in all.corners.chunks_exact(3).zip(walls) {
        let wall = wall.clamp(0, 65_535) as usize;
        parts.resize_with(parts.len().max(wall + 1), Default::default);
        let (points, triangles) = &mut parts[wall];
        let corner = |k: &i64| {
            let k = (*k).max(0) as usize;
            // Walls share no points.
            if place_of[k] == u32::MAX {
                place_of[k] = points.len() as u32;
                points.push(Vector3::from_column_slice(&all.points[3 * k..3 * k + 3]));
            }
            place_of[k]
        };
        let corners: Vec<u32> = corners.iter().map(corner).collect();
        triangles.push([corners[0], corners[1], corners[2]]);
    }
    parts
}

/// The rotation and displacement that take points to others, if they do so without deforming (Kabsch 1976).
fn motion(before: &[Vector3<f64>], now: &[Vector3<f64>]) -> Option<[f32; 12]> {
    if before.len() != now.len() || before.is_empty() {
        return None;
    }
    if before == now {
        return Some(REST);
    }
    let middle = |points: &[Vector3<f64>]| points.iter().sum::<Vector3<f64>>() / points.len() as f64;
    let (from, to) = (middle(before), middle(now));
    let correlation =
        before.iter().zip(now).map(|(p, q)| (q - to) * (p - from).transpose()).sum::<Matrix3<f64>>();
    let rotation = Rotation3::from_matrix_eps(&best_rotation(&correlation)?, 1e-15, 0, Rotation3::identity());
    let rotation = rotation.matrix();
    let displacement = to - rotation * from;
    let size = before.iter().map(|p| (p - from).norm()).fold(0.0, f64::max);
    let is_near =
        |(p, q): (&Vector3<f64>, &Vector3<f64>)| (rotation * p + displacement - q).norm() <= RIGID * size;
    if !before.iter().zip(now).all(is_near) {
        return None;
    }
    let rows = rotation.transpose();
    let mut numbers = rows.as_slice().iter().chain(displacement.as_slice()).map(|&x| x as f32);
    Some(std::array::from_fn(|_| numbers.next().unwrap_or_default()))
}

/// The rotation nearest to a correlation of directions.
fn best_rotation(correlation: &Matrix3<f64>) -> Option<Matrix3<f64>> {
    let svd = correlation.svd(true, true);
    let (u, v_t) = (svd.u?, svd.v_t?);
    let mut sign = Matrix3::identity();
    sign[(2, 2)] = (u * v_t).determinant().signum();
    Some(u * sign * v_t)
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn a_plate_that_turns_and_shifts_is_stored_once() {
        let plate = [[0.0, 0.0, 0.0], [1.0, 0.0, 0.0], [1.0, 2.0, 0.0], [0.0, 2.0, 0.0]].map(Vector3::from);
        let rotation = Rotation3::from_euler_angles(0.3, -1.2, 2.0);
        let shift = Vector3::new(0.1, -5.0, 3.0);
        let moved: Vec<_> = plate.iter().map(|p| rotation * p + shift).collect();
        let found = motion(&plate, &moved).expect("it is rigid");
        for (k, row) in found[..9].chunks(3).enumerate() {
            for (j, x) in row.iter().enumerate() {
                assert!((f64::from(*x) - rotation.matrix()[(k, j)]).abs() < 1e-6, "{found:?}");
            }
        }
        assert!(
            (Vector3::new(found[9], found[10], found[11]).cast::<f64>() - shift).norm() < 1e-6,
            "{found:?}"
        );
        let stretched: Vec<_> = plate.iter().map(|p| 1.01 * p).collect();
        assert_eq!(motion(&plate, &stretched), None);
        assert_eq!(motion(&plate, &plate), Some(REST));
    }
}
