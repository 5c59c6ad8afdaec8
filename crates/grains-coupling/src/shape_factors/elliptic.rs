//! The elliptic integrals of ellipses and ellipsoids, by means that converge quadratically.

use std::f64::consts::FRAC_2_PI;

/// Below this ratio of axes the ellipse is a line to all digits.
const FLAT: f64 = 1e-9;

/// Mean over all angles of √(a² cos² + b² sin²), the circumference of an ellipse over 2π, for a ≥ b ≥ 0.
///
/// By the arithmetic-geometric mean: (a² − Σ 2^(n−1) cₙ²)/M(a, b), c₀² = a² − b².
pub(super) fn ellipse_mean(a: f64, b: f64) -> f64 {
    if b <= FLAT * a {
        return FRAC_2_PI * a;
    }
    let (mut mean, mut root) = (a, b);
    let mut sum = a * a - 0.5 * (a * a - b * b);
    let mut weight = 0.5;
    while mean - root > 1e-8 * mean {
        let difference = 0.5 * (mean - root);
        (mean, root) = (0.5 * (mean + root), (mean * root).sqrt());
        weight *= 2.0;
        sum -= weight * difference * difference;
    }
    sum / (0.5 * (mean + root))
}

/// Mean over the unit sphere of √(x n₁² + y n₂² + z n₃²) for positive numbers: Carlson's R_G.
///
/// The surface of an ellipsoid is 4π times that of (b²c², a²c², a²b²).
pub(super) fn symmetric_integral(numbers: [f64; 3]) -> f64 {
    let [x, y, z] = {
        let mut sorted = numbers;
        sorted.sort_by(f64::total_cmp);
        sorted
    };
    if z - x <= 1e-15 * z {
        return z.sqrt();
    }
    // R_G = ½ (z R_F − (x−z)(y−z)/3 R_D + √(xy/z)), all terms positive with the middle number in the place of z.
    let (p, q, middle) = (x, z, y);
    let (first, second) = degree_half(p, q, middle);
    0.5 * (middle * first - (p - middle) * (q - middle) * second / 3.0 + (p * q / middle).sqrt())
}

/// Carlson's R_F and R_D(x, y, z), by duplication down to a spread at which five terms of the series suffice.
fn degree_half(mut x: f64, mut y: f64, mut z: f64) -> (f64, f64) {
    let (mut sum, mut quarter) = (0.0, 1.0);
    loop {
        let mean = (x + y + 3.0 * z) / 5.0;
        let spread = (mean - x).abs().max((mean - y).abs()).max((mean - z).abs());
        if spread < 1e-3 * mean {
            let (dx, dy, dz) = ((mean - x) / mean, (mean - y) / mean, (mean - z) / mean);
            let (ea, eb) = (dx * dy, dz * dz);
            let (ec, ed) = (ea - eb, ea - 6.0 * eb);
            let ee = ed + ec + ec;
            let series = 1.0
                + ed * (-3.0 / 14.0 + 9.0 / 88.0 * ed - 9.0 / 52.0 * dz * ee)
                + dz * (ee / 6.0 + dz * (-9.0 / 22.0 * ec + 3.0 / 26.0 * dz * ea));
            let second = 3.0 * sum + quarter * series / (mean * mean.sqrt());
            let third = (x + y + z) / 3.0;
            let (ex, ey) = ((third - x) / third, (third - y) / third);
            let ez = -(ex + ey);
            let (e2, e3) = (ex * ey - ez * ez, ex * ey * ez);
            let first = (1.0 - e2 / 10.0 + e3 / 14.0 + e2 * e2 / 24.0 - 3.0 / 44.0 * e2 * e3) / third.sqrt();
            return (first, second);
        }
        let (rx, ry, rz) = (x.sqrt(), y.sqrt(), z.sqrt());
        let lambda = rx * (ry + rz) + ry * rz;
        sum += quarter / (rz * (z + lambda));
        quarter *= 0.25;
        (x, y, z) = (0.25 * (x + lambda), 0.25 * (y + lambda), 0.25 * (z + lambda));
    }
}
