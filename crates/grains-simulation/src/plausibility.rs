//! Values that may stand together and yet are seldom meant: each is named with its consequence and a remedy, by `check`
//! and when a run begins.

mod endings;
mod flow;
mod fluids;
mod idle;
mod laws;
mod loads;
mod openings;
mod room;
mod setting;
mod sizes;
mod tables;
mod walls;

use crate::insertion::Insertions;
use crate::law_report::LawReport;
use crate::system::System;
use grains_case::{Case, Insert, Place, TimeStep};
use grains_geometry::Vec3;
use setting::{LONG_DISPLACEMENT, Remark, Setting};
pub use walls::bare_faces;

/// Every rule; each looks at one kind of mistake.
const RULES: &[fn(&Setting) -> Vec<Remark>] = &[
    walls::mesh_of_another_size,
    walls::wall_outside,
    walls::wall_too_late,
    walls::flow_plane_outside,
    stop_at_once,
    flow::inlet_outwards,
    flow::outlet_alone,
    flow::fine_cells,
    flow::cfl_exceeded,
    flow::endless_acceleration,
    walls::body_wider_than_its_tube,
    empty_domain,
    sheared_lattice,
    walls::closed_outlet,
    walls::bare_face,
    slow_impact,
    fast_insertion,
    sizes::wide_sizes,
    sizes::deep_cut_offs,
    walls::fast_wall,
    walls::light_wall,
    laws::properties_without_effect,
    laws::rayleigh_outrun,
    laws::glued,
    laws::softened_adhesion,
    laws::odd_bridges,
    laws::films_without_effect,
    laws::restitution_without_effect,
    idle::materials_of_nothing,
    idle::shapes_of_nothing,
    idle::heat_of_nothing,
    idle::rolling_without_friction,
    idle::steps_per_contact_beside_a_step,
    idle::loose_vertices,
    idle::doubled_walls,
    idle::motions_of_gone_walls,
    idle::phases_in_degrees,
    endings::stop_without_condition,
    endings::stop_never_looked_at,
    endings::passed_already,
    endings::energy_always_below,
    endings::interval_below_step,
    room::domain_too_full,
    room::crowded_batches,
    room::fast_spin,
    room::wide_skin,
    room::sweeping_planes,
    fluids::odd_viscosity,
    fluids::celsius_beside_kelvin,
    fluids::idle_inlets,
    fluids::few_cells,
    fluids::rise_out,
    fluids::fast_inlet,
    endings::stop_without_moving_particles,
    loads::slow_fall,
    loads::soft_bed,
    openings::narrow_funnels,
    tables::fast_rows,
    tables::spinning_rows,
    tables::angles_for_quaternions,
    tables::temperatures_of_nothing,
    tables::files_without_rows,
    fine_step,
    many_steps,
];

/// What is odd about a case, with file, line, key, value, consequence and remedy.
pub fn warnings(case: &Case, system: &System, insertions: &Insertions) -> Vec<String> {
    let setup = &system.setup;
    let steps = [system.step.dt, system.step.recommended];
    let has_contacts = !system.step.encounters.is_empty();
    let (walls, catalogue) = (&setup.walls, &setup.catalogue);
    let laws = LawReport::of_all(case, setup, insertions.kinds(), &system.step);
    let laws = &laws;
    let setting = Setting { case, walls, catalogue, insertions, steps, has_contacts, laws };
    let remarks = RULES.iter().flat_map(|rule| rule(&setting));
    remarks.map(|(key, message)| case.about(&key, message)).collect()
}

fn stop_at_once(s: &Setting) -> Vec<Remark> {
    let stop = &s.case.stop;
    let is_at_rest = |insert: &Insert| {
        let starts = insert.start == 0.0 && insert.batch.is_none_or(|batch| Some(batch) == insert.count);
        // A file may bring velocities, and a window may have to wait for room.
        let is_sure = matches!(
            insert.place,
            grains_case::Place::Lattice { .. } | grains_case::Place::Window { retry: None, .. }
        );
        let rests = [insert.velocity, insert.angular_velocity] == [[0.0; 3]; 2];
        starts && (insert.is_fixed() || is_sure && rests && !insert.is_prescribed())
    };
    let is_met = stop.kinetic_energy_below.is_some() && stop.after == 0.0 && !s.case.inserts.is_empty();
    if !is_met
        || !s.has_free_particles()
        || !s.case.inserts.iter().all(is_at_rest)
        || s.case.output.series == 0.0
    {
        return Vec::new();
    }
    let message = "particles start at rest, so the run ends at t = 0; give stop.after (s), the time they need to get moving";
    vec![("stop.kinetic_energy_below".into(), message.into())]
}

fn empty_domain(s: &Setting) -> Vec<Remark> {
    /// Longest edge of the domain over that of the bed, for beds and for a few particles.
    const USUAL: [f64; 2] = [300.0, 3000.0];
    let [smallest, largest] = s.diameters();
    if s.case.inserts.is_empty() || smallest.is_infinite() {
        return Vec::new();
    }
    let edge = |[lower, upper]: [[f64; 3]; 2]| (0..3).map(|a| upper[a] - lower[a]).fold(0.0, f64::max);
    let regions = s.case.inserts.iter().filter_map(|insert| insert.place.extents());
    let packed = libm::cbrt(s.count() as f64) * largest;
    let bed = regions.map(edge).fold(packed, f64::max);
    let extents = s.domain().extents();
    let axis = (0..3).fold(0, |best, a| if extents[a] > extents[best] { a } else { best });
    let ratio = extents[axis] / bed;
    if ratio < USUAL[usize::from(s.count() < 10)] {
        return Vec::new();
    }
    let message = format!(
        "the domain is {:.3e} m long there, {ratio:.0} times the particles' region ({bed:.3e} m): ranks get empty space, and places are rounded to {:.0e} of a diameter; lengths are in metres (80 mm are 0.08)",
        extents[axis],
        extents[axis] * f64::EPSILON / smallest
    );
    vec![(format!("domain.upper[{axis}]"), message)]
}

/// Layers of a lattice at rest slide past each other in a shear, and never touch.
fn sheared_lattice(s: &Setting) -> Vec<Remark> {
    let is_still = |insert: &Insert| {
        matches!(insert.place, Place::Lattice { .. }) && Vec3::from(insert.velocity) == Vec3::zeros()
    };
    if s.domain().shear.is_none() || !s.case.inserts.iter().all(is_still) {
        return Vec::new();
    }
    let message = "layers of a lattice may slide past each other in a shear without a contact; place particles through a window or from a file";
    vec![("insert[0].place".into(), message.to_string())]
}

fn slow_impact(s: &Setting) -> Vec<Remark> {
    let (speed, index) = s.fastest_insertion();
    let given = s.case.time.impact_speed;
    if !s.has_moving_particles() || given >= 0.5 * speed {
        return Vec::new();
    }
    let message = format!(
        "insert[{index}] moves at {speed:.3} m/s: overlaps will be {:.1} times those that check foresees; raise it, or leave it out",
        speed / given
    );
    vec![("time.impact_speed".into(), message)]
}

fn fast_insertion(s: &Setting) -> Vec<Remark> {
    let (speed, index) = s.fastest_insertion();
    let way = speed * s.steps[0] / s.smallest_radius();
    if !s.has_contacts || way <= LONG_DISPLACEMENT {
        return Vec::new();
    }
    let message = format!(
        "particles go {way:.1} radii per time step ({:.2e} s): contacts begin deep or are missed; velocities are in m/s, or lower time.dt",
        s.steps[0]
    );
    vec![(format!("insert[{index}].velocity"), message)]
}

fn fine_step(s: &Setting) -> Vec<Remark> {
    /// "auto" over the step given.
    const USUAL: f64 = 1000.0;
    let [dt, recommended] = s.steps;
    let (TimeStep::Seconds(_), true) = (s.case.time.dt, s.has_moving_particles()) else { return Vec::new() };
    if recommended / dt <= USUAL {
        return Vec::new();
    }
    let message = format!(
        "{:.0} times shorter than \"auto\" ({recommended:.2e} s), and the run that much longer; times are in seconds",
        recommended / dt
    );
    vec![("time.dt".into(), message)]
}

fn many_steps(s: &Setting) -> Vec<Remark> {
    /// Steps of a run of years.
    const USUAL: f64 = 1e11;
    let steps = s.case.time.end / s.steps[0];
    if steps <= USUAL || !s.has_moving_particles() {
        return Vec::new();
    }
    vec![(
        "time.end".into(),
        format!("{steps:.1e} time steps of {:.1e} s take years; times are in seconds", s.steps[0]),
    )]
}
