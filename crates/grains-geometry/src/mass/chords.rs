//! Mass properties of a union of convex parts by chords: along each line of a square grid the union is integrated in
//! closed form.
//!
//! Lines are parallel to no axis a body is likely to have, so that no face or edge lies along them: chords then vary
//! without jumps from line to line, and the rule converges to second order, 3/2 where a round outline ends. Finer and
//! finer grids are taken until two agree.

use super::chord::Solid;
use super::{MassProperties, principal_axes};
use crate::{Mat3, Part, Vec3, rotation_about};
use std::thread;

/// Lines along either edge of the first grid.
const FIRST: u32 = 128;
/// Lines along either edge of the last grid.
const LAST: u32 = 4096;
/// Difference of two grids in volume and moments at which the finer is taken.
const AGREED: f64 = 2e-5;
/// Roll, pitch and yaw of the lines (rad): no simple fractions of a turn.
const TURN: [f64; 3] = [0.618_034, 0.414_214, 0.732_051];

/// ∫ dV, ∫ x dV and ∫ x xᵀ dV in units of the size.
#[derive(Clone, Copy)]
struct Moments {
    volume: f64,
    first: Vec3,
    second: Mat3,
}

impl MassProperties {
    /// Of the union of parts with sharp edges; lines per edge of the last grid; and the larger relative difference
    /// in volume and principal moments from the grid of half as many.
    ///
    /// The result does not depend on the number of threads. Without parts all is NaN.
    pub fn of_chords(parts: &[Part]) -> (Self, u32, f64) {
        let [roll, pitch, yaw] = TURN;
        let turn = rotation_about(&Vec3::z(), yaw)
            * rotation_about(&Vec3::y(), pitch)
            * rotation_about(&Vec3::x(), roll);
        let matrix = turn.to_rotation_matrix().into_inner();
        let in_lines =
            |part: &Part| part.clone().placed(matrix.tr_mul(&part.center), matrix.tr_mul(&part.rotation));
        let turned: Vec<Part> = parts.iter().map(in_lines).collect();
        let solids: Vec<Solid> = turned.iter().map(Solid::new).collect();
        let grid = |lines: u32| integrate(&solids, lines).placed(&turn, &Vec3::zeros());
        let mut lines = FIRST;
        let mut coarse = grid(lines / 2);
        loop {
            let fine = grid(lines);
            let error = difference(&fine, &coarse);
            // Not the opposite comparison: NaN has no end.
            if error.partial_cmp(&AGREED) != Some(std::cmp::Ordering::Greater) || lines >= LAST {
                return (fine, lines, error);
            }
            (coarse, lines) = (fine, 2 * lines);
        }
    }
}

/// Cores for this process: those it may run on, shared with the other ranks that a launcher of MPI has started on this machine.
fn share_of_cores() -> usize {
    let given = ["OMPI_COMM_WORLD_LOCAL_SIZE", "MPI_LOCALNRANKS", "SLURM_STEP_TASKS_PER_NODE"];
    let ranks = given.iter().find_map(|name| std::env::var(name).ok()?.parse::<usize>().ok());
    thread::available_parallelism().map_or(1, usize::from) / ranks.unwrap_or(1).max(1)
}

/// Larger relative difference of volume and principal moments.
fn difference(a: &MassProperties, b: &MassProperties) -> f64 {
    let (of_a, of_b) = (principal_axes(&a.inertia).1, principal_axes(&b.inertia).1);
    let sorted = |mut m: Vec3| {
        m.as_mut_slice().sort_by(f64::total_cmp);
        m
    };
    let off = sorted(of_a).component_div(&sorted(of_b)).add_scalar(-1.0).amax();
    let off = if off.is_nan() { f64::NAN } else { off };
    let volume = (a.volume / b.volume - 1.0).abs();
    if volume.is_nan() || off.is_nan() { f64::NAN } else { volume.max(off) }
}

/// Sums over a grid of lines along x, slabs of them on each core.
fn integrate(solids: &[Solid], lines: u32) -> MassProperties {
    let start = (Vec3::repeat(f64::INFINITY), Vec3::repeat(f64::NEG_INFINITY));
    let (lower, upper) = solids.iter().fold(start, |(l, u), s| (l.inf(&s.lower), u.sup(&s.upper)));
    let middle = (lower + upper) / 2.0;
    let size = (upper - lower).max();
    let step = (upper - lower) / f64::from(lines);
    let slab = |k: u32| {
        let mut sum = Moments { volume: 0.0, first: Vec3::zeros(), second: Mat3::zeros() };
        let mut chords = Vec::with_capacity(solids.len());
        let z = lower.z + step.z * (f64::from(k) + 0.5);
        let near: Vec<&Solid> = solids.iter().filter(|s| s.lower.z <= z && z <= s.upper.z).collect();
        for j in 0..lines {
            let origin = Vec3::new(middle.x, lower.y + step.y * (f64::from(j) + 0.5), z);
            chords.clear();
            chords.extend(near.iter().filter(|s| s.meets_row(&origin)).filter_map(|s| s.chord(&origin)));
            sum.add_line(&mut chords, (origin - middle) / size, size);
        }
        sum
    };
    let threads = (share_of_cores() as u32).clamp(1, lines);
    let mut slabs: Vec<(u32, Moments)> = Vec::with_capacity(lines as usize);
    thread::scope(|scope| {
        let slab = &slab;
        // Every n-th slab, for the middle ones cost more than the outer.
        let own =
            move |t: u32| (t..lines).step_by(threads as usize).map(|k| (k, slab(k))).collect::<Vec<_>>();
        let workers: Vec<_> = (1..threads).map(|t| scope.spawn(move || own(t))).collect();
        slabs.extend(own(0));
        for worker in workers {
            match worker.join() {
                Ok(some) => slabs.extend(some),
                Err(panic) => std::panic::resume_unwind(panic),
            }
        }
    });
    slabs.sort_by_key(|(k, _)| *k);
    let weight = step.y / size * (step.z / size);
    let total = slabs.iter().fold((0.0, Vec3::zeros(), Mat3::zeros()), |(v, f, s), (_, m)| {
        (v + m.volume, f + m.first, s + m.second)
    });
    let (volume, first, second) = (total.0 * weight, total.1 * weight, total.2 * weight);
    let center = first / volume;
    let second = second - center * center.transpose() * volume;
    MassProperties {
        volume: volume * size.powi(3),
        center: center * size + middle,
        inertia: (Mat3::identity() * second.trace() - second) * size.powi(5),
    }
}

impl Moments {
    /// Adds the union of the chords (m) of a line through `at`, in units of `size`: each is a rod of length l, whose
    /// second moment about its middle is l³/12.
    fn add_line(&mut self, chords: &mut [(f64, f64)], at: Vec3, size: f64) {
        chords.sort_unstable_by(|a, b| a.0.total_cmp(&b.0));
        let mut covered = f64::NEG_INFINITY;
        for &(from, to) in chords.iter() {
            let (a, b) = (from.max(covered) / size, to / size);
            covered = covered.max(to);
            if b > a {
                let (length, middle) = (b - a, 0.5 * (a + b));
                let center = Vec3::new(middle, at.y, at.z);
                self.volume += length;
                self.first += center * length;
                self.second += center * center.transpose() * length;
                self.second[(0, 0)] += length.powi(3) / 12.0;
            }
        }
    }
}
