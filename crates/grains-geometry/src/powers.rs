//! Powers of several numbers at once: plain arithmetic on lanes, so that the compiler vectorises it and
//! every machine gets the same bits, which the mathematical libraries of systems do not promise.

/// 1.5 · 2⁵²: adding it rounds a number to an integer, found in the low bits.
const ROUNDER: f64 = 6_755_399_441_055_744.0;
/// Bits that hold the exponent.
const EXPONENT: u64 = 0xfff0_0000_0000_0000;
const ONE: u64 = 0x3ff0_0000_0000_0000;
/// From √½ up to 1, in units of the last bit: mantissas are taken from [√½, √2).
const TO_ROOT_HALF: u64 = ONE - 0x3fe6_a09e_667f_3bcd;
/// Bits of 2⁵²: or-ed with an integer below they make 2⁵² + integer.
const TWO_52: u64 = 0x4330_0000_0000_0000;
/// Powers of two below which a result counts as zero, and its opposite.
const LARGEST_EXPONENT: f64 = 1000.0;

/// Chebyshev interpolation of log₂((1 + s)/(1 − s))/s in s² up to the square of (√2 − 1)/(√2 + 1).
const LOG: [f64; 8] = [
    2.885_390_081_777_926_8,
    0.961_796_693_925_989_8,
    0.577_078_016_345_520_3,
    0.412_198_585_840_900_5,
    0.320_598_534_913_959_84,
    0.262_334_352_504_183,
    0.220_913_084_231_176_8,
    0.213_658_956_943_192_7,
];

/// Chebyshev interpolation of 2^f for |f| ≤ ½.
const EXP: [f64; 12] = [
    1.0,
    std::f64::consts::LN_2,
    0.240_226_506_959_101_58,
    0.055_504_108_664_821_625,
    0.009_618_129_107_587_256,
    0.001_333_355_814_640_647,
    0.000_154_035_304_637_243_53,
    1.525_273_384_155_677_3e-5,
    1.321_543_253_591_237e-6,
    1.017_805_708_773_394_1e-7,
    7.074_194_297_288_521e-9,
    4.455_817_908_336_064_5e-10,
];

/// Binary logarithms of positive normal numbers, to one or two units in the last place of the larger of
/// the result and 1.
#[inline(always)]
pub(crate) fn log2<const N: usize>(x: [f64; N]) -> [f64; N] {
    std::array::from_fn(|i| {
        let bits = x[i].to_bits();
        let shifted = bits.wrapping_add(TO_ROOT_HALF);
        let exponent = f64::from_bits((shifted >> 52) | TWO_52) - (4_503_599_627_370_496.0 + 1023.0);
        let m = f64::from_bits(bits.wrapping_sub(shifted & EXPONENT).wrapping_add(ONE));
        let s = (m - 1.0) / (m + 1.0);
        let z = s * s;
        let (z2, c) = (z * z, &LOG);
        let low = (c[0] + c[1] * z) + (c[2] + c[3] * z) * z2;
        let high = (c[4] + c[5] * z) + (c[6] + c[7] * z) * z2;
        exponent + s * (low + high * (z2 * z2))
    })
}

/// Powers of two, exact to about two units in the last place; zero stands for less than 2⁻¹⁰⁰⁰.
#[inline(always)]
pub(crate) fn exp2<const N: usize>(y: [f64; N]) -> [f64; N] {
    std::array::from_fn(|i| {
        let y = if y[i] > -LARGEST_EXPONENT { y[i] } else { -LARGEST_EXPONENT };
        let y = if y < LARGEST_EXPONENT { y } else { LARGEST_EXPONENT };
        let rounded = y + ROUNDER;
        let f = y - (rounded - ROUNDER);
        let (f2, c) = (f * f, &EXP);
        let f4 = f2 * f2;
        let low = (c[0] + c[1] * f) + (c[2] + c[3] * f) * f2;
        let middle = (c[4] + c[5] * f) + (c[6] + c[7] * f) * f2;
        let high = (c[8] + c[9] * f) + (c[10] + c[11] * f) * f2;
        let power = low + (middle + high * f4) * f4;
        f64::from_bits(power.to_bits().wrapping_add(rounded.to_bits() << 52))
    })
}

/// Numbers, none negative, to positive powers; relative error 1e-15 per binary digit of the logarithm.
#[inline(always)]
pub(crate) fn pow<const N: usize>(x: [f64; N], exponent: [f64; N]) -> [f64; N] {
    let logarithm: [f64; N] = log2(x.map(|x| if x > f64::MIN_POSITIVE { x } else { f64::MIN_POSITIVE }));
    let power: [f64; N] = exp2(std::array::from_fn(|i| logarithm[i] * exponent[i]));
    std::array::from_fn(|i| if x[i] > 0.0 { power[i] } else { 0.0 })
}

/// Numbers to a natural power, by repeated squaring.
#[inline(always)]
pub(crate) fn natural<const N: usize>(x: [f64; N], mut exponent: u32) -> [f64; N] {
    let mut power = [1.0; N];
    let mut square = x;
    while exponent > 0 {
        if exponent & 1 == 1 {
            power = std::array::from_fn(|i| power[i] * square[i]);
        }
        square = std::array::from_fn(|i| square[i] * square[i]);
        exponent >>= 1;
    }
    power
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn powers_agree_with_the_library() {
        let mut worst = 0.0f64;
        for i in 0..200_000 {
            let x = (f64::from(i) + 0.5) / 2e5;
            let exponents = [0.026, 1.0 / 7.0, 1.5, 7.0];
            let ours = pow([x; 4], exponents);
            for (ours, e) in ours.into_iter().zip(exponents) {
                let size = 1.0 + (e * x.log2()).abs();
                worst = worst.max((ours / libm::pow(x, e) - 1.0).abs() / size);
            }
        }
        assert!(worst < 6e-16, "{worst:e}");
        assert_eq!(pow([0.0, 1.0, 1e-300], [0.1, 3.0, 2.0]), [0.0, 1.0, exp2([-2000.0])[0]]);
        assert!((pow([8.0, 1e3], [1.0 / 3.0, 0.5])[1] - 1e3f64.sqrt()).abs() < 1e-13);
    }

    #[test]
    fn natural_powers_multiply() {
        assert_eq!(natural([2.0, 3.0], 0), [1.0, 1.0]);
        assert_eq!(natural([2.0, 3.0], 13), [8192.0, 1_594_323.0]);
    }
}
