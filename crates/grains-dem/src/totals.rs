//! Sums over all particles: mass, energies, momenta.

use crate::catalogue::Catalogue;
use crate::particles::Particles;
use grains_domain::GlobalBox;
use grains_geometry::Vec3;

/// Sums over all particles of all ranks.
#[derive(Clone, Copy, Debug, Default, PartialEq)]
pub struct Totals {
    /// Particles inside.
    pub particles: u64,
    /// Mass (kg).
    pub mass: f64,
    /// Kinetic energy of translation (J).
    pub kinetic_translation: f64,
    /// Kinetic energy of rotation (J).
    pub kinetic_rotation: f64,
    /// Potential energy in gravity, −M g·x (J).
    pub potential: f64,
    /// Momentum (kg m/s).
    pub momentum: Vec3,
    /// Angular momentum about the origin (kg m²/s), of the images in the box where axes are periodic.
    pub angular_momentum: Vec3,
    /// Largest speed (m/s).
    pub max_speed: f64,
}

impl Totals {
    /// Sums over the owned particles of one rank.
    pub(crate) fn of(
        particles: &Particles,
        catalogue: &Catalogue,
        gravity: &Vec3,
        global: &GlobalBox,
    ) -> Self {
        let mut totals = Totals { particles: particles.owned as u64, ..Totals::default() };
        for (i, body) in particles.bodies[..particles.owned].iter().enumerate() {
            let (m, v, w) = (body.mass, body.velocity, body.angular_velocity);
            // Which image a rank holds depends on when lists were rebuilt.
            let position = Vec3::from(global.wrap(body.position.into()));
            let inertia = catalogue.inertia(body);
            let spin = match particles.frames.get(i) {
                Some(frame) => frame * inertia.component_mul(&frame.tr_mul(&w)),
                None => inertia.component_mul(&w),
            };
            totals.mass += m;
            totals.kinetic_translation += 0.5 * m * v.norm_squared();
            totals.kinetic_rotation += 0.5 * w.dot(&spin);
            totals.potential -= m * gravity.dot(&position);
            totals.momentum += v * m;
            totals.angular_momentum += position.cross(&v) * m + spin;
            totals.max_speed = totals.max_speed.max(v.norm());
        }
        totals
    }

    /// The sums as plain numbers, without the maximum.
    pub(crate) fn sums(&self) -> [f64; 11] {
        let (p, l) = (self.momentum, self.angular_momentum);
        let t = self;
        [
            t.particles as f64,
            t.mass,
            t.kinetic_translation,
            t.kinetic_rotation,
            t.potential,
            p.x,
            p.y,
            p.z,
            l.x,
            l.y,
            l.z,
        ]
    }

    pub(crate) fn from_sums(s: [f64; 11], max_speed: f64) -> Self {
        Self {
            particles: s[0] as u64,
            mass: s[1],
            kinetic_translation: s[2],
            kinetic_rotation: s[3],
            potential: s[4],
            momentum: Vec3::new(s[5], s[6], s[7]),
            angular_momentum: Vec3::new(s[8], s[9], s[10]),
            max_speed,
        }
    }
}
