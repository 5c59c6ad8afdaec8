//! Several contacts of two bodies, or one over a patch, as the contact of one depth.
//!
//! With the norm D of all overlaps and W_i = ∂D/∂δ_i the normal force at contact i is W_i F(D, dD/dt), F the contact law
//! of one contact. Its elastic part is the gradient of ∫F dD over the positions of both bodies. Its dashpot acts on
//! dD/dt, for the mass 1/(J M⁻¹ Jᵀ) of the pair along the generalised direction J = Σ W_i (n_i, r_i × n_i), so that D has
//! the restitution of the law. What the contacts do beside, such as rocking, is braked by the same dashpot at each,
//! W_i (dδ_i/dt less their mean); all of it takes energy and none brings any.
//!
//! Springs along the surface share W_i/ΣW of their stiffness. A contact that begins beside others begins with the mean
//! of their displacements and angles, as its weight then is none: so the force goes on where a body rolls or slides from
//! one of its parts onto the next.

use super::load_quanta::LoadQuanta;
use super::loads::{ContactLoads, ContactPoint};
use crate::contact_history::LawHistory;
use crate::narrow_phase::Pose;
use grains_contact::{Approach, Coefficients, Encounter, Neighbourhood, PreparedLaw, Sharing, WoundAngles};
use grains_geometry::{ContactPatch, DepthNorm, Mat3, Vec3};

/// The law of two bodies.
pub(crate) struct PairLaw<'a> {
    pub(crate) law: &'a PreparedLaw,
    /// Their effective mass (kg).
    pub(crate) mass: f64,
    /// R1 R2/(R1 + R2) (m).
    pub(crate) effective_radius: f64,
    /// Time step (s).
    pub(crate) dt: f64,
    /// Sum of the thicknesses of their films (m), where bridges take liquid from these.
    pub(crate) films: f64,
}

/// The contacts of two bodies together.
pub(crate) struct SeveralContacts {
    sharing: Sharing,
    /// Contacts, and parts of a body among which they count as one (model A and B).
    count: usize,
    parts: usize,
    norm: DepthNorm,
    /// Σ W_i, and Σ W_i² (-).
    total: f64,
    squares: f64,
    /// −dD/dt (m/s).
    opening: f64,
    /// Σ W_i n_i (-), and the torques about both bodies of W_i n_i at all points (m).
    push: Vec3,
    turns: [Vec3; 2],
}

impl SeveralContacts {
    /// All contact points of two bodies, of so many pairs of parts, each with the screw along which it presses.
    #[inline]
    pub(crate) fn of<P: ContactPoint>(
        sharing: Sharing,
        parts: usize,
        points: impl Iterator<Item = (P, Screw)> + Clone,
    ) -> Self {
        let count = points.clone().count();
        let sharing = if count == 1 { Sharing::Potential } else { sharing };
        let norm = DepthNorm::of(points.clone().map(|(point, _)| point.encounter().overlap));
        let (push, turns) = (Vec3::zeros(), [Vec3::zeros(); 2]);
        let mut all =
            Self { sharing, count, parts, norm, total: 0.0, squares: 0.0, opening: 0.0, push, turns };
        for (point, screw) in points {
            let encounter = point.encounter();
            let weight = all.weight(encounter.overlap, screw.weight);
            all.total += weight;
            all.squares += weight * weight;
            all.opening += weight * screw.opening(&encounter);
            let force = encounter.normal * weight;
            all.push += force;
            let ([torque, other], couple) = (point.torques(&force), force * screw.pitch);
            all.turns[0] += torque + couple;
            all.turns[1] += other - couple;
        }
        all
    }

    /// W of one contact: its derivative of D, or its share in a mean.
    #[inline]
    fn weight(&self, overlap: f64, patch: f64) -> f64 {
        match self.sharing {
            Sharing::Potential => self.norm.weight(overlap) * patch,
            Sharing::Mean | Sharing::Sum => patch / self.count as f64,
        }
    }

    /// Inverse of the mass (1/kg) that one of the bodies sets against all its contacts.
    ///
    /// Contacts that push against each other leave none; it is that of their lengths then, so that dashpots stay bounded.
    #[inline]
    pub(crate) fn inverse_mass(&self, pose: &Pose, mass: f64, side: usize) -> f64 {
        pose.inverse_generalised_mass(mass, &self.push, &self.turns[side]).max(self.squares / mass)
    }

    /// Whether a contact of this overlap (m) bears no share of the force.
    #[inline]
    pub(crate) fn is_idle(&self, overlap: f64) -> bool {
        self.sharing == Sharing::Potential && self.norm.weight(overlap) == 0.0
    }

    /// What the law of the pair keeps, of what its contacts have: all have the same, or are new.
    #[inline]
    pub(crate) fn kept(&self, histories: impl Iterator<Item = LawHistory>) -> [f64; 2] {
        histories.fold([0.0; 2], |[memory, bridge], law| [memory.max(law.memory), either(bridge, law.bridge)])
    }

    /// What contacts of these overlaps (m) and weights of patches have wound up, their mean by weight.
    pub(crate) fn wound(&self, contacts: impl Iterator<Item = (f64, f64, Wound)>) -> Wound {
        let (mut mean, mut total) = (Wound::default(), 0.0);
        if self.count == 1 {
            return mean;
        }
        for (overlap, patch, wound) in contacts.filter(|(.., wound)| !wound.is_none()) {
            let weight = self.weight(overlap, patch);
            mean.add(&wound, weight);
            total += weight;
        }
        let mut wound = Wound::default();
        if total > 0.0 {
            wound.add(&mean, 1.0 / total);
        }
        wound
    }

    /// Whether its contacts are one to the law, and keep the same.
    #[inline]
    pub(crate) fn is_one(&self) -> bool {
        self.sharing == Sharing::Potential
    }

    /// What one of the contacts sees of the law of the pair; the number it keeps is advanced by the step.
    #[inline]
    fn one(
        &self,
        point: &impl ContactPoint,
        screw: &Screw,
        law: &PairLaw,
        memory: &mut f64,
    ) -> (Encounter, Coefficients) {
        let mut encounter = point.encounter();
        let (overlap, patch) = (encounter.overlap, screw.weight);
        let opening = screw.opening(&encounter);
        let seen = match self.sharing {
            Sharing::Potential => {
                encounter.overlap = self.norm.depth;
                self.opening + (opening - self.opening / self.total)
            }
            Sharing::Mean | Sharing::Sum => patch * opening,
        };
        let normal = encounter.normal;
        encounter.velocity += normal * (seen - encounter.velocity.dot(&normal));
        let weight = self.weight(overlap, patch);
        let of_pair = Approach {
            overlap: encounter.overlap,
            opening: if self.is_one() { self.opening } else { opening },
            radius: law.effective_radius,
            dt: law.dt,
        };
        let one = law.law.at(law.mass, &of_pair, memory).shared(self.parts, self.sharing);
        let law = match self.sharing {
            Sharing::Potential => one.weighted(weight, weight / self.total),
            Sharing::Mean | Sharing::Sum => one.weighted(patch, 1.0),
        };
        (encounter, law)
    }

    /// Loads of one of the contacts, of a patch if it is not a point; what it keeps is advanced by the step.
    #[inline]
    pub(crate) fn loads(
        &self,
        point: &impl ContactPoint,
        patch: Option<PatchShare>,
        law: &PairLaw,
        kept: Kept,
        quanta: &LoadQuanta,
    ) -> ContactLoads {
        let (dt, Kept { displacement, torsional_angle, history }) = (law.dt, kept);
        let screw = patch.as_ref().map_or(Screw::POINT, |patch| patch.screw);
        let (encounter, one) = self.one(point, &screw, law, &mut history.memory);
        let mut force = one.force(&encounter, displacement, dt);
        let attraction = &law.law.attraction;
        if attraction.is_active() {
            let at = Neighbourhood { radius: law.effective_radius, mass: law.mass, dt, films: law.films };
            let weight = self.weight(point.encounter().overlap, screw.weight);
            force += attraction.force(&encounter, &at, &mut history.bridge) * weight;
        }
        let mut loads = ContactLoads::of(point, &force, quanta);
        if screw.pitch != 0.0 {
            let normal = encounter.normal;
            loads.add_torque(&(normal * (screw.pitch * force.dot(&normal))), quanta);
        }
        if one.has_couples() {
            loads.add_couple(&encounter, &one, (&point.rolling(), &mut history.angles), quanta, dt);
        }
        match patch {
            Some(patch) if patch.second.trace() > 0.0 => {
                loads.add_patch(&encounter, &one, (&patch.second, torsional_angle), quanta, dt);
            }
            // A point, or one corner, holds no torsion.
            _ => *torsional_angle = 0.0,
        }
        loads
    }
}

/// That of two volumes of one bridge which is not zero.
#[inline]
pub(crate) fn either(one: f64, other: f64) -> f64 {
    if one == 0.0 { other } else { one }
}

/// Along what the bodies press each other at a contact: its normal, about which they also turn each other.
#[derive(Clone, Copy, Debug)]
pub(crate) struct Screw {
    /// Weight of its patch (-).
    pub(crate) weight: f64,
    /// Couple over force (m).
    pub(crate) pitch: f64,
}

impl Screw {
    /// That of a point.
    pub(crate) const POINT: Self = Self { weight: 1.0, pitch: 0.0 };

    pub(crate) fn of(patch: Option<&ContactPatch>) -> Self {
        patch.map_or(Self::POINT, |patch| Self { weight: patch.weight, pitch: patch.pitch })
    }

    /// Velocity (m/s) with which the bodies part along it.
    #[inline]
    fn opening(&self, encounter: &Encounter) -> f64 {
        let Encounter { normal, velocity, spin, .. } = encounter;
        (velocity - spin * self.pitch).dot(normal)
    }
}

/// The part of a patch in the contacts of two bodies.
pub(crate) struct PatchShare {
    pub(crate) screw: Screw,
    /// Second moment of its corners (m²), in the world.
    pub(crate) second: Mat3,
}

/// What the springs of a contact along the surface have wound up; nothing where it begins.
#[derive(Clone, Copy, Debug, Default, PartialEq)]
pub(crate) struct Wound {
    /// Tangential displacement (m).
    pub(crate) displacement: Vec3,
    /// Torsional angle of a patch (rad).
    pub(crate) torsional_angle: f64,
    /// Angles rolled and twisted (rad).
    pub(crate) angles: WoundAngles,
}

impl Wound {
    pub(crate) fn is_none(&self) -> bool {
        *self == Self::default()
    }

    fn add(&mut self, other: &Self, factor: f64) {
        self.displacement += other.displacement * factor;
        self.torsional_angle += other.torsional_angle * factor;
        self.angles.rolling += other.angles.rolling * factor;
        self.angles.twisting += other.angles.twisting * factor;
    }
}

/// What a contact keeps from one step to the next.
pub(crate) struct Kept<'a> {
    /// Tangential displacement (m).
    pub(crate) displacement: &'a mut Vec3,
    /// Torsional angle of a patch (rad).
    pub(crate) torsional_angle: &'a mut f64,
    pub(crate) history: &'a mut LawHistory,
}

impl Kept<'_> {
    /// What the contact has wound up.
    pub(crate) fn wound(&self) -> Wound {
        Wound {
            displacement: *self.displacement,
            torsional_angle: *self.torsional_angle,
            angles: self.history.angles,
        }
    }

    /// Lets a contact that begins go on with what others have wound up.
    pub(crate) fn begin_with(&mut self, others: &Wound) {
        if self.wound().is_none() {
            *self.displacement = others.displacement;
            *self.torsional_angle = others.torsional_angle;
            self.history.angles = others.angles;
        }
    }
}
