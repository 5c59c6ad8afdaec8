//! What `check` finds of particles, walls and their contacts.

use super::sizes::SizeReport;
use crate::insertion::Insertions;
use crate::law_report::LawReport;
use crate::plausibility;
use crate::system;
use crate::timestep::{Encounter, TimeStepChoice, recommended_without_fines};
use grains_case::{Case, Face, Insert};
use grains_contact::Sharing;
use grains_dem::{Catalogue, CollisionModel, DemSetup, FaceContact, Motion, Surface, Wall};
use grains_domain::Transport;
use grains_geometry::{DecompositionReport, MassReport, MassSource, Shape};

/// Seconds per particle and step on one core, for spheres, for other convex bodies and for composites; measured in beds, see scaling/.
const COST: [f64; 3] = [0.8e-7, 0.9e-6, 1.8e-6];
/// What hard collisions add to it (s): beads in a heap take 0.3 to 1 microseconds.
const COST_OF_HARD: f64 = 0.6e-6;

/// Difference of mass properties that is worth a warning (-).
const NOTABLE_DIFFERENCE: f64 = 2e-3;

/// Volume error of a decomposition that is worth a warning (-).
const LARGE_ERROR: f64 = 0.05;

/// Time per particle and step on one core (s).
pub fn seconds_per_step(case: &Case, catalogue: &Catalogue) -> f64 {
    let is_composite = catalogue.shapes.iter().any(|shape| shape.parts.len() > 1);
    let kind = usize::from(!catalogue.all_spheres()) + usize::from(is_composite);
    COST[kind] + if case.collisions.is_hard() { COST_OF_HARD } else { 0.0 }
}

/// Largest overlap at `time.impact_speed` over the radius (-), of soft contacts.
pub fn max_overlap(step: &TimeStepChoice) -> f64 {
    let overlap = |e: &Encounter| e.collision.max_overlap / e.radius;
    step.encounters.iter().map(overlap).fold(0.0, f64::max)
}

/// The particles of a case, and what they meet.
#[derive(Clone, Debug)]
pub struct ParticleReport {
    /// Particles of all insertions.
    pub count: u64,
    /// Those inserted at the beginning.
    pub placed: u64,
    /// Bonds made at the beginning.
    pub placed_bonds: u64,
    /// Mass of all (kg).
    pub mass: f64,
    /// The shapes of the case.
    pub shapes: Vec<ShapeReport>,
    /// The sizes of insertions that draw different ones.
    pub sizes: Vec<SizeReport>,
    /// How touching faces and edges count, if any shape has them.
    pub faces: Option<FaceContact>,
    /// How several contacts of two bodies count, if any shape has several parts.
    pub composites: Option<Sharing>,
    /// The walls of triangles.
    pub meshes: Vec<MeshReport>,
    /// The walls that a table of times moves.
    pub tables: Vec<MotionTableReport>,
    /// Faces of the domain without wall, outlet or periodicity, if particles move.
    pub open_faces: Vec<Face>,
    /// Distance within which particles may interact (m).
    pub interaction_range: f64,
    /// How bodies collide.
    pub collisions: CollisionModel,
    /// The time step, what limits it and the collisions that can happen.
    pub step: TimeStepChoice,
    /// What the laws of soft collisions come to.
    pub laws: Vec<LawReport>,
    /// The step (s) that would be recommended without the finest tenth of the mass of each kind.
    pub step_without_fines: Option<f64>,
    /// Largest overlap at `time.impact_speed` over the radius (-), of soft contacts.
    pub max_overlap: f64,
    /// The weight of the smallest particle, and its torque, in multiples of what these are rounded to, if they are.
    pub weight_in_quanta: Option<[f64; 2]>,
    /// Steps to the end.
    pub steps: f64,
    /// Time per particle and step on one core (s).
    pub seconds_per_step: f64,
    /// Time of all steps on all ranks (s).
    pub seconds: f64,
}

impl ParticleReport {
    /// The particles of a system, of which some are placed at the beginning, on a number of ranks.
    ///
    /// # Errors
    /// Parts without mass properties to compare with.
    pub(super) fn of(
        case: &Case,
        (setup, insertions): (&DemSetup, &Insertions),
        step: TimeStepChoice,
        ([placed, placed_bonds], ranks): ([u64; 2], usize),
        transport: &impl Transport,
    ) -> Result<Self, String> {
        let catalogue = &setup.catalogue;
        let is_mixed = !catalogue.all_spheres();
        let is_composite = is_mixed && catalogue.shapes.iter().any(|shape| shape.parts.len() > 1);
        let steps = case.time.end / step.dt;
        let seconds_per_step = seconds_per_step(case, catalogue);
        let open_faces = match case.inserts.iter().all(Insert::is_fixed) {
            true => Vec::new(),
            false => plausibility::bare_faces(case, &setup.walls),
        };
        Ok(Self {
            count: insertions.total(),
            placed,
            placed_bonds,
            mass: insertions.mass(case, catalogue, transport),
            shapes: catalogue.shapes.iter().map(ShapeReport::of).collect::<Result<_, _>>()?,
            sizes: SizeReport::of_all(case, catalogue, insertions),
            faces: is_mixed.then_some(catalogue.faces),
            composites: is_composite.then_some(catalogue.sharing),
            meshes: setup.walls.iter().flat_map(MeshReport::of).collect(),
            tables: setup.walls.iter().filter_map(MotionTableReport::of).collect(),
            open_faces,
            interaction_range: setup.interaction_range(),
            collisions: setup.collisions,
            laws: LawReport::of_all(case, setup, insertions.kinds(), &step),
            max_overlap: max_overlap(&step),
            step_without_fines: recommended_without_fines(case, catalogue, insertions.kinds()),
            weight_in_quanta: system::quanta_of_weight(case, setup, insertions.kinds()),
            steps,
            seconds_per_step,
            seconds: steps * insertions.total() as f64 * seconds_per_step / ranks as f64,
            step,
        })
    }
}

/// A shape of particles.
#[derive(Clone, Debug)]
pub struct ShapeReport {
    /// Its name in the case.
    pub name: String,
    /// Volume (m³).
    pub volume: f64,
    /// Diameter of the sphere of its volume (m).
    pub equivalent_diameter: f64,
    /// Radius of the ball about its centre that holds it (m).
    pub bounding_radius: f64,
    /// Thickness of the crust of its first part (m).
    pub crust: f64,
    /// Its parts and mass properties, unless it is a simple convex body.
    pub composite: Option<CompositeReport>,
}

/// A shape that is no simple convex body.
#[derive(Clone, Debug)]
pub struct CompositeReport {
    /// Convex parts.
    pub parts: usize,
    /// Its mass properties beside those of the parts by chords.
    pub mass: MassReport,
    /// Difference of these (-), where it is worth a warning.
    pub notable_difference: Option<f64>,
    /// How a mesh was cut into the parts, if one was.
    pub decomposition: Option<DecompositionReport>,
    /// Whether the parts differ from the mesh by as much as is worth a warning.
    pub is_coarse: bool,
}

impl ShapeReport {
    fn of(shape: &Shape) -> Result<Self, String> {
        Ok(Self {
            name: shape.name.clone(),
            volume: shape.volume,
            equivalent_diameter: shape.sphere_equivalent_diameter(),
            bounding_radius: shape.bounding_radius,
            crust: shape.parts[0].crust,
            composite: CompositeReport::of(shape)?,
        })
    }
}

impl CompositeReport {
    fn of(shape: &Shape) -> Result<Option<Self>, String> {
        if shape.parts.len() == 1 && shape.report.mass == MassSource::ClosedForm {
            return Ok(None);
        }
        let mass = MassReport { source: shape.report.mass, ..shape.mass_report() };
        if mass.volume_difference.is_nan() || mass.inertia_difference.is_nan() {
            return Err(format!(
                "shape \"{}\": its parts under the crust bound no volume, so that its contacts would be wrong: choose a smaller `crust`, or vertices farther apart",
                shape.name
            ));
        }
        let difference = mass.volume_difference.abs().max(mass.inertia_difference.abs());
        let decomposition = shape.report.decomposition.clone();
        let is_notable = difference > NOTABLE_DIFFERENCE && decomposition.is_none();
        Ok(Some(Self {
            parts: shape.parts.len(),
            mass,
            notable_difference: is_notable.then_some(difference),
            is_coarse: decomposition.as_ref().is_some_and(|cut| cut.volume_error.abs() > LARGE_ERROR),
            decomposition,
        }))
    }
}

/// A wall of triangles.
#[derive(Clone, Debug, PartialEq)]
pub struct MeshReport {
    /// Its name in the case.
    pub name: String,
    /// Triangles.
    pub triangles: usize,
    /// Edges of one triangle only.
    pub open_edges: usize,
    /// Edges of three triangles and more.
    pub non_manifold_edges: usize,
    /// Area of the smallest triangle (m²).
    pub min_area: f64,
}

impl MeshReport {
    fn of(wall: &Wall) -> impl Iterator<Item = Self> {
        wall.surfaces.iter().filter_map(|surface| {
            let Surface::Mesh(mesh) = surface else { return None };
            let report = &mesh.report().mesh;
            Some(Self {
                name: wall.name.clone(),
                triangles: mesh.mesh().triangles.len(),
                open_edges: report.open_edges,
                non_manifold_edges: report.non_manifold_edges,
                min_area: report.smallest_area,
            })
        })
    }
}

/// The motion of a wall by a table of times.
#[derive(Clone, Debug, PartialEq)]
pub struct MotionTableReport {
    /// Name of the wall in the case.
    pub wall: String,
    /// Rows of the table.
    pub rows: usize,
    /// Times of the first and the last row (s), before and after which the wall rests.
    pub interval: [f64; 2],
    /// Bound on the speed of the axis (m/s).
    pub max_speed: f64,
    /// Bound on the angular speed (rad/s).
    pub max_rate: f64,
}

impl MotionTableReport {
    fn of(wall: &Wall) -> Option<Self> {
        let Motion::Table(table) = &wall.motion else { return None };
        let [max_speed, max_rate, _] = table.bounds();
        Some(Self {
            wall: wall.name.clone(),
            rows: table.len(),
            interval: table.interval(),
            max_speed,
            max_rate,
        })
    }
}
