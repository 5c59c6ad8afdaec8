//! Where solids lie among the cells, as scalars see them.

/// A place of [`SolidCells::holder`] beyond the ends of the box.
pub const BEYOND: u32 = u32::MAX;

/// A face between cells whose middles different solids hold, or a solid and the fluid.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct CutFace {
    /// Place in the arrays, that of the cell below.
    pub place: u32,
    /// Shares of the way between the middles that lie in the solid of the cell below and in that of the cell above (-); the rest is
    /// fluid.
    pub solid: [f64; 2],
}

/// A cell that the surface of a solid may cut.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct NearCell {
    /// Place in the arrays.
    pub place: u32,
    /// Number of the solid.
    pub solid: u32,
    /// Share of the cell's volume in the solid (-).
    pub share: f64,
    /// Distance of the middle from the surface (m), negative in the solid.
    pub distance: f64,
    /// Unit normal of the surface, out of the solid.
    pub normal: [f64; 3],
}

/// A face that the surface of a solid may cut.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct NearFace {
    /// Place in the arrays.
    pub place: u32,
    /// Number of the solid.
    pub solid: u32,
    /// Share of its area in the solid (-).
    pub share: f64,
    /// Unit normal of the surface, out of the solid.
    pub normal: [f64; 3],
}

/// The solids among the cells of a rank: bodies, then walls, by their numbers.
#[derive(Clone, Debug, PartialEq)]
pub struct SolidCells {
    /// 1 plus the number of the solid that holds the middle of each cell, 0 in the fluid, [`BEYOND`] outside the box; halo included.
    pub holder: Vec<u32>,
    /// Cut faces of the own cells per axis, in ascending order of their places.
    pub cut: [Vec<CutFace>; 3],
    /// Cells at surfaces, those next to own ones included, in ascending order; empty if nobody asks for shares.
    pub near_cells: Vec<NearCell>,
    /// Faces of own cells at surfaces per axis, in ascending order; empty if nobody asks for shares.
    pub near_faces: [Vec<NearFace>; 3],
    /// Whether shares that walls take of cells and faces are in volumes and volume fluxes of the fluid already, as in flows averaged over
    /// particles.
    pub is_averaged: bool,
    /// Number of bodies, which is that of the first wall.
    pub bodies: usize,
    /// Number of all solids.
    pub count: usize,
}

impl SolidCells {
    /// Frees what only conditions are made of.
    pub(super) fn forget_cuts(&mut self) {
        self.cut = Default::default();
        self.near_cells = Vec::new();
        self.near_faces = Default::default();
    }
}

/// Share of a cell of widths `w` (m) in front of a plane at a distance `d` (m) behind its middle, of unit normal `n`: of that
/// which n·x > −d.
///
/// With s = Σ |n_a| w_a /2 the plane cuts the cell where |d| < s; the volume is that of a corner cut off, less those beyond the
/// edges (Scardovelli & Zaleski 2000, for any box). Widths of axes along which nothing varies are 0.
pub fn share_in_front(d: f64, normal: &[f64; 3], widths: &[f64; 3]) -> f64 {
    let m: [f64; 3] = std::array::from_fn(|a| (normal[a] * widths[a]).abs());
    let total = m[0] + m[1] + m[2];
    if total <= 0.0 {
        return if d > 0.0 { 1.0 } else { 0.0 };
    }
    let alpha = (0.5 * total + d) / total;
    if alpha <= 0.0 {
        return 0.0;
    }
    if alpha >= 1.0 {
        return 1.0;
    }
    // In order, over their sum; those next to nothing do not divide.
    let mut m = m.map(|m| m / total);
    m.sort_unstable_by(f64::total_cmp);
    let is_mirrored = alpha > 0.5;
    let a = if is_mirrored { 1.0 - alpha } else { alpha };
    let [m1, m2, m3] = m;
    let thin = 1e-6;
    let volume = if m1 > thin {
        let cube = |x: f64| x.max(0.0).powi(3);
        (cube(a) - cube(a - m1) - cube(a - m2) - cube(a - m3) + cube(a - m1 - m2)) / (6.0 * m1 * m2 * m3)
    } else if m2 > thin {
        let square = |x: f64| x.max(0.0).powi(2);
        (square(a) - square(a - m2) - square(a - m3)) / (2.0 * m2 * m3)
    } else {
        a / m3
    };
    let volume = volume.clamp(0.0, 1.0);
    if is_mirrored { 1.0 - volume } else { volume }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn shares_are_those_of_points() {
        // Halton points against the formula, over random planes and boxes, flat ones among them.
        let halton = |mut i: u32, base: u32| {
            let (mut f, mut x) = (1.0, 0.0);
            while i > 0 {
                f /= f64::from(base);
                x += f * f64::from(i % base);
                i /= base;
            }
            x
        };
        for k in 1..60 {
            let r: Vec<f64> = [2, 3, 5, 7, 11, 13].iter().map(|&b| halton(k, b)).collect();
            let mut normal = [r[0] - 0.5, r[1] - 0.5, r[2] - 0.5];
            if k % 5 == 0 {
                normal[k as usize % 3] = 0.0;
            }
            let size = normal.iter().map(|x| x * x).sum::<f64>().sqrt();
            let normal = normal.map(|x| x / size);
            let widths = [1.0, 0.5 + r[3], if k % 7 == 0 { 0.0 } else { 0.5 + r[4] }];
            let d = 1.2 * (r[5] - 0.5);
            let count = 20_000;
            let inside = (1..=count).filter(|&i| {
                let x: [f64; 3] = std::array::from_fn(|a| (halton(i, [2, 3, 5][a]) - 0.5) * widths[a]);
                (0..3).map(|a| normal[a] * x[a]).sum::<f64>() > -d
            });
            let counted = inside.count() as f64 / f64::from(count);
            let found = share_in_front(d, &normal, &widths);
            assert!((found - counted).abs() < 2e-3, "{k}: {found} {counted}");
            let behind = share_in_front(-d, &normal.map(|x| -x), &widths);
            assert!((found + behind - 1.0).abs() < 1e-9);
        }
    }
}
