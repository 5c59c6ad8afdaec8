//! Composites: convex bodies glued into one, which need not be convex (Rakotonirina 2016, ch. 3, section 2).

mod contact;
mod surface;

use crate::core::Crusted;
use crate::error::crust_thickness;
use crate::mass::union::{principal_moments, union_mass};
use crate::report::{MassSource, ShapeReport};
use crate::shapes::polyhedron_part_of;
use crate::{ConvexHull, MassProperties, Mat3, Part, Rotation, Shape, ShapeError, Vec3};
use contact::Contacts;
use nalgebra::Rotation3;

/// A crust takes at most this share of a part's inscribed radius, so that slices keep a core.
const MOST_CRUST: f64 = 0.5;
/// Crust of the parts where it is sought which of them touch, relative to the size of the composite: their
/// edges are sharp, and parts that only touch still have separate cores.
const SHARP: f64 = 1e-7;

/// A convex body of a composite, where it is: x_composite = rotation x_user + position, with x_user the
/// coordinates in which the body itself was given.
#[derive(Clone, Debug)]
pub struct Component {
    /// The body; of one part.
    pub shape: Shape,
    /// Rotation to the frame of the composite.
    pub rotation: Rotation,
    /// Place in the frame of the composite (m).
    pub position: Vec3,
}

impl Component {
    /// A body at `position` (m), not turned.
    pub fn new(shape: Shape, position: Vec3) -> Self {
        Self { shape, rotation: Rotation::identity(), position }
    }

    /// The same body turned about the origin of its own coordinates.
    pub fn turned(mut self, rotation: Rotation) -> Self {
        self.rotation = rotation;
        self
    }

    /// `(R, c)` with `x_composite = R x_body + c`.
    fn frame(&self) -> (Rotation, Vec3) {
        let (turn, center) = &self.shape.user_to_body;
        (self.rotation * turn, self.rotation * center + self.position)
    }

    /// Mass properties in the frame of the composite.
    fn mass(&self) -> MassProperties {
        let (rotation, position) = self.frame();
        MassProperties::in_body_frame(self.shape.volume, &self.shape.inertia).placed(&rotation, &position)
    }

    /// The body itself in the frame of the composite, if it is a polyhedron.
    fn hull(&self) -> Option<ConvexHull> {
        if !self.shape.parts[0].core.is_solid_polyhedron() {
            return None;
        }
        let (rotation, position) = self.frame();
        let corners: Vec<Vec3> =
            self.shape.surface.vertices.iter().map(|v| rotation * v + position).collect();
        ConvexHull::new(&corners).ok()
    }

    /// The part under a crust of the given thickness (m), in the frame of the composite.
    fn part(&self, crust: f64) -> Result<Part, ShapeError> {
        let (rotation, position) = self.frame();
        let turn = rotation.to_rotation_matrix().into_inner();
        let part = crusted(&self.shape, crust.min(MOST_CRUST * self.shape.inscribed_radius))?;
        let (center, rotation) = (turn * part.center + position, turn * part.rotation);
        Ok(part.placed(center, rotation))
    }
}

/// The part of a convex body, in its body frame, under another crust (m), if the crust can be chosen.
fn crusted(shape: &Shape, crust: f64) -> Result<Part, ShapeError> {
    let part = &shape.parts[0];
    match part.core.with_crust(part.crust, crust) {
        Crusted::Fixed => Ok(part.clone()),
        Crusted::Core(core) => {
            Ok(Part { bounding_radius: core.radius() + crust, core, crust, ..part.clone() })
        }
        // The surface of a polyhedron is its exact hull, the core its erosion.
        Crusted::Eroded => Ok(polyhedron_part_of(&ConvexHull::new(&shape.surface.vertices)?, crust)?),
    }
}

impl Shape {
    /// Composite of convex bodies, which may overlap, in the frame of its principal axes at its centre
    /// of mass.
    ///
    /// All parts have one crust, `crust_fraction` times the largest inscribed radius of the components,
    /// or half of their own inscribed radius where that is less; spheres are all crust.
    /// The mass properties are exact where no components overlap and where all are boxes or polyhedra, which are
    /// cut along each other's faces; else those of chords ([`MassProperties::of_chords`]), refined until they agree.
    ///
    /// Errors: no component, one that is not convex, components that do not all hang together; a union so thin that
    /// chords leave more than 0.2 % of its mass properties open; crust out of (0, 0.5].
    pub fn glued(components: &[Component], crust_fraction: f64) -> Result<Self, ShapeError> {
        glue(components, crust_fraction, None)
    }
}

/// Composite with mass properties known in its user frame, or to be found.
pub(crate) fn glue(
    components: &[Component],
    crust_fraction: f64,
    mass: Option<(MassProperties, MassSource)>,
) -> Result<Shape, ShapeError> {
    check_components(components)?;
    let inscribed_radius = components.iter().map(|c| c.shape.inscribed_radius).fold(0.0, f64::max);
    let crust = crust_thickness(crust_fraction, inscribed_radius)?;
    if let ([only], None) = (components, &mass) {
        return alone(only, crust);
    }
    let size = components.iter().map(|c| c.frame().1.norm() + c.shape.bounding_radius).fold(0.0, f64::max);
    let sharp = components.iter().map(|c| c.part(SHARP * size)).collect::<Result<Vec<_>, _>>()?;
    let contacts = Contacts::of(components, &sharp, size)?;
    contacts.check_connected()?;
    let placed = components.iter().map(|c| c.part(crust)).collect::<Result<Vec<_>, _>>()?;
    let (mass, source) = match mass {
        Some(known) => known,
        None if contacts.are_overlapping() => {
            let hulls: Option<Vec<_>> = components.iter().map(Component::hull).collect();
            union_mass(hulls.as_deref(), &sharp, size)?
        }
        None => {
            let all: Vec<_> = components.iter().map(Component::mass).collect();
            (MassProperties::sum(&all), MassSource::Parts)
        }
    };
    let (axes, inertia) = principal_moments(&mass)?;
    let surfaces: Vec<_> = components.iter().map(|c| (&c.shape.surface, c.frame())).collect();
    let user_to_body = (as_rotation(axes), mass.center);
    let surface = surface::union(&surfaces, &placed, size).transformed(
        &user_to_body.0.inverse(),
        1.0,
        &-axes.tr_mul(&mass.center),
    );
    let in_body = |part: Part| {
        let (center, rotation) = (axes.tr_mul(&(part.center - mass.center)), axes.tr_mul(&part.rotation));
        part.placed(center, rotation)
    };
    let parts: Vec<Part> = placed.into_iter().map(in_body).collect();
    Ok(Shape {
        name: "glued".to_string(),
        volume: mass.volume,
        inertia,
        bounding_radius: parts.iter().map(largest_distance).fold(0.0, f64::max),
        inscribed_radius,
        surface,
        user_to_body,
        parts,
        report: ShapeReport { mass: source, decomposition: None },
        discrete: None,
    })
}

/// A composite of one: the body itself, in its own body frame.
fn alone(only: &Component, crust: f64) -> Result<Shape, ShapeError> {
    let part = crusted(&only.shape, crust)?;
    let bounding_radius = largest_distance(&part);
    Ok(Shape { parts: vec![part], bounding_radius, user_to_body: only.frame(), ..only.shape.clone() })
}

fn as_rotation(axes: Mat3) -> Rotation {
    Rotation::from_rotation_matrix(&Rotation3::from_matrix_unchecked(axes))
}

fn check_components(components: &[Component]) -> Result<(), ShapeError> {
    if components.is_empty() {
        return Err(ShapeError::NoComponents);
    }
    match components.iter().position(|c| c.shape.parts.len() != 1) {
        Some(k) => Err(ShapeError::NotConvex { component: label(components, k) }),
        None => Ok(()),
    }
}

/// How messages call a component: its number from 0 and its name.
fn label(components: &[Component], k: usize) -> String {
    format!("parts[{k}] ({})", components[k].shape.name)
}

/// Largest distance of a point of the part from the origin of the frame it is placed in (m).
fn largest_distance(part: &Part) -> f64 {
    part.core.largest_distance(part.crust, &part.rotation, &part.center)
}
