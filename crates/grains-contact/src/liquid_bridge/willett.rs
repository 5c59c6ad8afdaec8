//! The fit of Willett to the Young-Laplace equation.

/// F = 2π R γ exp(f1 − f2 exp(f3 ln s + f4 ln² s)), s = (h/2) √(R/V) (Willett et al. 2000).
///
/// The f are polynomials in θ (rad) and L = ln(V/R³). For θ up to 50° and V/R³ from 1e-5 to 0.1; beyond these volumes L is
/// that of the nearer end. Within 0.03 × 2π R γ of the Young-Laplace equation for V/R³ from 1e-4 and θ to 40°. At h = 0 the force is 2π R γ exp(f1).
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Willett {
    /// Coefficients of 1, L, L², L³ in f1 to f4, for the contact angle.
    polynomials: [[f64; 4]; 4],
}

/// Coefficients of 1, θ, θ², for each power of L, of f1 to f4.
const COEFFICIENTS: [[[f64; 3]; 4]; 4] = [
    [
        [-0.44507, 0.050832, -1.1466],
        [-0.1119, -0.000411, -0.1490],
        [-0.012101, -0.0036456, -0.01255],
        [-0.0005, -0.0003505, -0.00029076],
    ],
    [[1.9222, -0.57473, -1.2918], [-0.0668, -0.1201, -0.22574], [-0.0013375, -0.0068988, -0.01137], [0.0; 3]],
    [
        [1.268, -0.01396, -0.23566],
        [0.198, 0.092, -0.06418],
        [0.02232, 0.02238, -0.009853],
        [0.0008585, 0.001318, -0.00053],
    ],
    [
        [-0.010703, 0.073776, -0.34742],
        [0.03345, 0.04543, -0.09056],
        [0.0018574, 0.004456, -0.006257],
        [0.0; 3],
    ],
];

/// ln 1e-5 and ln 0.1, between which the fit holds.
const LOG_VOLUMES: [f64; 2] = [-11.512_925_464_970_229, -2.302_585_092_994_045_5];
/// The s up to which bodies count as touching: the inner exponential is below 1e-10 there.
const CONTACT: f64 = 1e-7;

impl Willett {
    /// The fit for a contact angle θ (rad).
    pub fn new(contact_angle: f64) -> Self {
        let at_angle = |[a, b, c]: [f64; 3]| a + (b + c * contact_angle) * contact_angle;
        Self { polynomials: COEFFICIENTS.map(|powers| powers.map(at_angle)) }
    }

    /// F/(2π R γ) (-) at a gap h (m), a volume V (m³) and a radius R (m).
    #[inline]
    pub fn scaled_force(&self, gap: f64, volume: f64, radius: f64) -> f64 {
        let [low, high] = LOG_VOLUMES;
        let log_volume = libm::log(volume / (radius * radius * radius)).max(low).min(high);
        let [f1, f2, f3, f4] =
            self.polynomials.map(|[a, b, c, d]| a + (b + (c + d * log_volume) * log_volume) * log_volume);
        let s = 0.5 * gap * (radius / volume).sqrt();
        if s <= CONTACT {
            return libm::exp(f1);
        }
        // From the s of the smallest force on, of volumes below the range alone, the fit would grow again.
        let log_s = libm::log(s).min(-0.5 * f3 / f4);
        libm::exp(f1 - f2 * libm::exp((f3 + f4 * log_s) * log_s))
    }
}
