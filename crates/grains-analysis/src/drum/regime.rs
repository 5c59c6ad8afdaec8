//! The regime of motion of a bed in a drum, told from what it does.
//!
//! Mellmann (2001) bounds the regimes by the Froude number, but the bounds overlap (slumping 1e-5 to 1e-3,
//! rolling 1e-4 to 1e-2, cascading 1e-3 to 0.1, cataracting 0.1 to 1, centrifuging from 1) and shift with
//! the shape of the particles. So the state decides, in this order:
//!
//! | regime | sign |
//! |---|---|
//! | centrifuging | Fr > 0.5 and more than 90 % of the particles move with the drum |
//! | sliding | the mean speed is below a tenth of that of the rim: the wall slips under the bed |
//! | cataracting | more than 3 % of the particles fly higher than two diameters above the surface |
//! | cascading | the surface is bent: it leaves the fitted line by more than a diameter and 5 % of the radius (rms) |
//! | slumping | the angle of the surface varies by more than 2° (standard deviation over the states) |
//! | rolling | none of these |
//!
//! With fewer than five states no variation is known; slumping is then told from Fr < 3e-4.

/// What the regime is told from, means over the states.
#[derive(Clone, Copy, Debug)]
pub struct Signs {
    /// Froude number (-).
    pub froude: f64,
    /// Mean speed over that of the rim (-).
    pub speed: f64,
    /// Share of the particles that move with the drum (-).
    pub order: f64,
    /// Root mean square distance of the surface from its line over the radius (-).
    pub roughness: f64,
    /// Mean diameter of the particles over the radius (-).
    pub grain: f64,
    /// Share of the particles that fly above the surface (-).
    pub thrown: f64,
    /// Standard deviation of the angle of the surface over the states (degrees), if there are enough.
    pub angle_deviation: Option<f64>,
}

impl Signs {
    /// States from which on a variation is known.
    pub const ENOUGH: usize = 5;
}

/// A regime of motion.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Regime {
    /// The wall slips under the bed.
    Sliding,
    /// Avalanches one by one.
    Slumping,
    /// A steady flow down a flat surface.
    Rolling,
    /// A steady flow down a bent surface.
    Cascading,
    /// Particles thrown over the bed.
    Cataracting,
    /// Particles that go round with the drum.
    Centrifuging,
}

/// The regime by the table above; a sign that is not a number counts as absent.
pub fn regime(signs: &Signs) -> Regime {
    let is_slumping = match signs.angle_deviation {
        Some(deviation) => deviation > 2.0,
        None => signs.froude < 3e-4,
    };
    if signs.froude > 0.5 && signs.order > 0.9 {
        Regime::Centrifuging
    } else if signs.speed < 0.1 {
        Regime::Sliding
    } else if signs.thrown > 0.03 {
        Regime::Cataracting
    } else if signs.roughness > signs.grain.max(0.05) {
        Regime::Cascading
    } else if is_slumping {
        Regime::Slumping
    } else {
        Regime::Rolling
    }
}

impl Regime {
    /// Its name.
    pub fn name(self) -> &'static str {
        match self {
            Self::Sliding => "sliding",
            Self::Slumping => "slumping",
            Self::Rolling => "rolling",
            Self::Cascading => "cascading",
            Self::Cataracting => "cataracting",
            Self::Centrifuging => "centrifuging",
        }
    }

    /// Why it is the one.
    pub fn reason(self, signs: &Signs) -> String {
        match self {
            Self::Sliding => format!("mean speed {:.3} of the rim", signs.speed),
            Self::Slumping | Self::Rolling => match signs.angle_deviation {
                Some(deviation) => format!("the angle varies by {deviation:.2} degrees"),
                None => "by the Froude number, as there are fewer than five states".into(),
            },
            Self::Cascading => format!("surface bent by {:.3} R", signs.roughness),
            Self::Cataracting => format!("{:.1} % fly", 100.0 * signs.thrown),
            Self::Centrifuging => format!("{:.1} % move with the drum", 100.0 * signs.order),
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn each_sign_decides_in_turn() {
        let base = Signs {
            froude: 0.01,
            speed: 0.5,
            order: 0.4,
            roughness: 0.01,
            grain: 0.06,
            thrown: 0.0,
            angle_deviation: Some(0.5),
        };
        assert_eq!(regime(&base), Regime::Rolling);
        assert_eq!(regime(&Signs { angle_deviation: Some(4.0), ..base }), Regime::Slumping);
        assert_eq!(regime(&Signs { angle_deviation: None, froude: 1e-4, ..base }), Regime::Slumping);
        assert_eq!(regime(&Signs { roughness: 0.08, ..base }), Regime::Cascading);
        assert_eq!(regime(&Signs { thrown: 0.2, roughness: 0.08, ..base }), Regime::Cataracting);
        assert_eq!(regime(&Signs { speed: 0.02, ..base }), Regime::Sliding);
        assert_eq!(
            regime(&Signs { froude: 2.7, order: 0.99, thrown: f64::NAN, ..base }),
            Regime::Centrifuging
        );
        // A slow bed between two avalanches also moves with the drum.
        assert_eq!(regime(&Signs { order: 1.0, ..base }), Regime::Rolling);
    }
}
