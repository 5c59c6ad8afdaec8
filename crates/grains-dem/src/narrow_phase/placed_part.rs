//! Parts of particles where they are now.

use crate::catalogue::Catalogue;
use crate::particles::{Body, Particles};
use grains_geometry::{ContactPatch, Core, DiscreteSurface, Mat3, Part, PartFrame, Placement, Shape, Vec3};

/// How the core of a part lies and is swept.
#[derive(Clone, Copy, Debug)]
pub(crate) struct SweptFrame {
    /// Rotation from the part's frame.
    pub(crate) rotation: Mat3,
    pub(crate) scale: f64,
    /// Crust (m), scaled.
    pub(crate) crust: f64,
}

/// A part of a particle where it is now.
#[derive(Clone, Copy, Debug)]
pub(crate) struct PlacedPart<'a> {
    pub(crate) core: &'a Core,
    /// Rotation from the part's frame.
    pub(crate) rotation: Mat3,
    pub(crate) scale: f64,
    /// Part centre from the particle's centre of mass, in the world frame (m).
    pub(crate) offset: Vec3,
    /// Crust (m), scaled.
    pub(crate) crust: f64,
    /// Radius of a ball about the part's centre that holds it (m), scaled.
    pub(crate) bounding_radius: f64,
    /// Vertices that find contacts in place of the core (Srinivasan 2019, section 2.4).
    pub(crate) vertices: Option<&'a DiscreteSurface>,
}

/// How a particle lies: its shape, rotation from its frame, and scale.
#[derive(Clone, Copy)]
pub(crate) struct Pose<'a> {
    pub(crate) shape: &'a Shape,
    pub(crate) frame: &'a Mat3,
    pub(crate) scale: f64,
}

impl<'a> Pose<'a> {
    /// How particle `i` lies.
    #[inline(always)]
    pub(crate) fn of(particles: &'a Particles, i: usize, catalogue: &'a Catalogue) -> Self {
        Self::of_body(&particles.bodies[i], &particles.frames[i], catalogue)
    }

    /// How a body with a frame lies.
    #[inline(always)]
    pub(crate) fn of_body(body: &Body, frame: &'a Mat3, catalogue: &'a Catalogue) -> Self {
        let shape = catalogue.shape(body.kind);
        Self { shape, frame, scale: ratio(body.radius, shape.bounding_radius) }
    }

    /// Radius of the largest ball about the centre within the body (m).
    #[inline(always)]
    pub(crate) fn inscribed_radius(&self) -> f64 {
        self.shape.inscribed_radius * self.scale
    }

    /// Inverse of the mass (1/kg) that a body of `mass` (kg) sets against a push along the unit `normal` at `arm` (m) from its
    /// centre of mass: 1/m + (r × n)·I⁻¹(r × n).
    ///
    /// Damping by this mass, not by m itself, gives an off-centre hit the restitution of the law.
    #[inline(always)]
    pub(crate) fn inverse_effective_mass(&self, mass: f64, arm: &Vec3, normal: &Vec3) -> f64 {
        self.inverse_mass(mass, 1.0, &arm.cross(normal))
    }

    /// The same along the generalised direction (push, turn): |p|²/m + t·I⁻¹ t.
    #[inline]
    pub(crate) fn inverse_generalised_mass(&self, mass: f64, push: &Vec3, turn: &Vec3) -> f64 {
        self.inverse_mass(mass, push.norm_squared(), turn)
    }

    #[inline(always)]
    fn inverse_mass(&self, mass: f64, push_squared: f64, turn: &Vec3) -> f64 {
        let lever = self.frame.tr_mul(turn);
        // Σ l²/I on one denominator: divisions are what this costs. I is that of the shape at unit density, I m/V s².
        let [p, q, r] = self.shape.inertia.into();
        let squares = lever.component_mul(&lever);
        let turned = (squares.x * q + squares.y * p) * r + squares.z * (p * q);
        let whole = p * q * r * (self.scale * self.scale);
        (whole * push_squared + self.shape.volume * turned) / (whole * mass)
    }

    /// Support value of a part about the particle's centre along a unit direction (m).
    #[inline(always)]
    pub(super) fn support_value(&self, part: &Part, direction: &Vec3) -> f64 {
        let direction = self.frame.tr_mul(direction);
        let of_core = match part.frame {
            PartFrame::OfBody => part.core.support_value(&direction),
            PartFrame::Shifted => direction.dot(&part.center) + part.core.support_value(&direction),
            PartFrame::Turned => {
                direction.dot(&part.center) + part.core.support_value(&part.rotation.tr_mul(&direction))
            }
        };
        (of_core + part.crust) * self.scale
    }

    /// Support value of the body of surface vertices, whose edges and tips no crust rounds (m).
    pub(super) fn support_value_of_vertices(&self, vertices: &DiscreteSurface, direction: &Vec3) -> f64 {
        vertices.reach(&self.frame.tr_mul(direction)) * self.scale
    }
}

impl<'a> PlacedPart<'a> {
    #[inline(always)]
    pub(crate) fn of(pose: &Pose<'a>, part: u16) -> Self {
        let Pose { shape, frame, scale } = *pose;
        let part = &shape.parts[part as usize];
        let (rotation, offset) = match part.frame {
            PartFrame::OfBody => (*frame, Vec3::zeros()),
            PartFrame::Shifted => (*frame, frame * part.center * scale),
            PartFrame::Turned => (frame * part.rotation, frame * part.center * scale),
        };
        let crust = part.crust * scale;
        let (bounding_radius, vertices) = (part.bounding_radius * scale, shape.discrete.as_deref());
        Self { core: &part.core, rotation, scale, offset, crust, bounding_radius, vertices }
    }

    /// How its core lies and is swept.
    #[inline(always)]
    pub(crate) fn swept_frame(&self) -> SweptFrame {
        let Self { rotation, scale, crust, .. } = *self;
        SweptFrame { rotation, scale, crust }
    }

    /// The same with a crust thicker by `reach` (m), which touches what is within reach.
    pub(crate) fn swollen(&self, reach: f64) -> Self {
        Self { crust: self.crust + reach, bounding_radius: self.bounding_radius + reach, ..*self }
    }

    /// Point of the core farthest along a direction, from the part's centre (m).
    pub(crate) fn farthest(&self, direction: &Vec3) -> Vec3 {
        self.rotation * self.core.support(&self.rotation.tr_mul(direction)) * self.scale
    }

    /// Point of the core farthest from an axis through the origin, the part's centre being at `center`:
    /// the point from that centre, its unit direction away from the axis, and its distance (m).
    pub(crate) fn farthest_from_axis(&self, center: &Vec3, axis: &Vec3) -> (Vec3, Vec3, f64) {
        let local = self.rotation.tr_mul(center) / self.scale;
        let point =
            self.rotation * self.core.farthest_from_axis(&local, &self.rotation.tr_mul(axis)) * self.scale;
        let from = center + point;
        let off = from - axis * from.dot(axis);
        let distance = off.norm();
        (point, if distance > 0.0 { off / distance } else { Vec3::zeros() }, distance)
    }

    /// ContactPatch on a wall deepest along `normal`, where `gap` is the distance (m) before it of a point given
    /// from the part's centre; the footprint's centre is on the core, in the frame `center` (m) is in.
    pub(crate) fn footprint(
        &self,
        center: &Vec3,
        normal: &Vec3,
        gap: impl Fn(&Vec3) -> f64,
    ) -> Option<ContactPatch> {
        let local = |p: &Vec3| gap(&(self.rotation * p * self.scale)) / self.scale;
        let direction = self.rotation.tr_mul(normal);
        let found = ContactPatch::on_surface(self.core, &direction, self.crust / self.scale, local)?;
        Some(found.moved(&self.rotation, self.scale, center))
    }

    /// Placement of another frame (its rotation, scale, and centre from ours in the world) in this part's.
    #[inline]
    pub(crate) fn placement(&self, rotation: &Mat3, scale: f64, separation: &Vec3) -> Placement {
        let inverse = ratio(1.0, self.scale);
        Placement {
            matrix: self.rotation.tr_mul(rotation) * (scale * inverse),
            translation: self.rotation.tr_mul(separation) * inverse,
        }
    }
}

/// x/y; bodies of the size of their shape are the rule, and a comparison is quicker than a division.
#[inline(always)]
fn ratio(x: f64, y: f64) -> f64 {
    if x == y { 1.0 } else { x / y }
}
