//! The cube root by arithmetic that goes through the lanes of the processor and gives the same bits on any machine.

/// x^(1/3) of a positive number, to two units in the last place.
///
/// The exponent divided by three is right to 5 %; each step of Halley's rule triples the digits.
#[inline(always)]
pub(crate) fn cube_root(x: f64) -> f64 {
    const EXPONENT: u32 = 715_094_163;
    let high = (x.to_bits() >> 32) as u32;
    let mut y = f64::from_bits(u64::from(high / 3 + EXPONENT) << 32);
    for _ in 0..3 {
        let cube = y * y * y;
        y *= (cube + 2.0 * x) / (2.0 * cube + x);
    }
    y
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn its_cube_is_the_number() {
        let mut x = 1e-280;
        while x < 1e280 {
            let y = cube_root(x);
            assert!((y * y * y / x - 1.0).abs() < 2e-15, "{x}");
            x *= 1.0371;
        }
    }
}
