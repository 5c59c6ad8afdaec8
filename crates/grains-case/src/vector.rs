//! The few vector operations the checks need; the core has its own algebra.

pub(crate) type Vector = [f64; 3];

pub(crate) fn sub(a: Vector, b: Vector) -> Vector {
    [a[0] - b[0], a[1] - b[1], a[2] - b[2]]
}

pub(crate) fn dot(a: Vector, b: Vector) -> f64 {
    a[0] * b[0] + a[1] * b[1] + a[2] * b[2]
}

pub(crate) fn cross(a: Vector, b: Vector) -> Vector {
    [a[1] * b[2] - a[2] * b[1], a[2] * b[0] - a[0] * b[2], a[0] * b[1] - a[1] * b[0]]
}

/// Euclidean length, safe from overflow and underflow.
pub(crate) fn norm<const N: usize>(v: [f64; N]) -> f64 {
    let largest = v.iter().fold(0.0_f64, |m, x| m.max(x.abs()));
    if largest == 0.0 || !largest.is_finite() {
        return largest;
    }
    largest * v.iter().map(|x| (x / largest) * (x / largest)).sum::<f64>().sqrt()
}

/// The vector scaled to length one, or `None` for a zero vector.
///
/// A vector that is already of unit length to rounding is returned unchanged, so that writing and
/// reading a checked value gives the same bits.
pub(crate) fn unit<const N: usize>(v: [f64; N]) -> Option<[f64; N]> {
    let length = norm(v);
    if !(length > 0.0 && length.is_finite()) {
        return None;
    }
    if (length - 1.0).abs() < 1e-14 { Some(v) } else { Some(v.map(|x| x / length)) }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn unit_vectors_survive_being_normalised_again() {
        for v in [[1.0, 2.0, 3.0], [1e-200, 1e-200, 0.0], [-0.3, 1e5, 7.0]] {
            let once = unit(v).expect("not zero");
            assert_eq!(unit(once), Some(once));
            assert!((norm(once) - 1.0).abs() < 1e-15);
        }
        assert_eq!(unit([0.0; 3]), None);
    }
}
