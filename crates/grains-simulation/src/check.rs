//! `grains-mpi check`: what a case is and what it will cost, before it runs.

use crate::composites::describe;
use crate::cost::Cost;
use crate::duration::duration;
use crate::fluid;
use crate::plausibility;
use crate::population::Population;
use crate::system::{self, System};
use crate::timestep::{Encounter, Partner, TimeStepChoice};
use crate::wall_surfaces::{WallTriangles, triangles_of};
use grains_case::{Case, Face, Insert, Motion, ParticleMotion, TimeStep};
use grains_contact::{ImpulseScheme, Sharing};
use grains_dem::{Catalogue, CollisionModel, FaceContact, Failure};
use grains_domain::{Decomposition, SerialTransport};
use std::fmt::Write;

/// Seconds per particle and step on one core, for spheres and for other shapes; measured, see scaling/.
const COST: [f64; 2] = [0.8e-7, 0.9e-6];

/// Explains a case for a number of ranks, and places what is inserted at the beginning; returns also what is odd about it.
///
/// # Errors
/// Whatever would stop the run before its first step.
pub fn explain(case: &Case, ranks: usize) -> Result<(String, Vec<String>), String> {
    let catalogue = system::catalogue(case)?;
    let population = Population::read(case, &catalogue, &SerialTransport).map_err(|e| e.message)?;
    let system = system::build(case, ranks, catalogue.clone(), population.kinds())?;
    let warnings = plausibility::warnings(case, &system, &population);
    let System { setup, step } = system;
    let range = setup.interaction_range();
    let size: usize = setup.ranks.iter().product();
    if size != ranks && case.domain.ranks.is_none() {
        return Err(format!("no decomposition for {ranks} ranks"));
    }
    let mut decomposition = Decomposition::new(setup.global.clone(), setup.ranks, 0, range)
        .map_err(|e| case.about("domain", e.to_string()))?;
    if let Some(nodes) = fluid::shared_nodes(case)? {
        decomposition.share_cells(&nodes);
    }
    let (placed, drawn) = place(case, catalogue, population.clone())?;
    let cost = Cost::of(case, &setup.catalogue, &population, &drawn, size);
    let mut text = String::new();
    let out = &mut text;
    let count = population.total() as f64;
    let kind = usize::from(!setup.catalogue.all_spheres());
    let _ = writeln!(out, "case           {}", case.name);
    fluid::verify(case, (&setup, population.kinds()), &decomposition)?;
    let of_fluid = fluid::check::explain(case, &setup.catalogue, &population)?;
    if case.inserts.is_empty() {
        let _ = writeln!(out, "{}", of_fluid.join("\n"));
        let _ = writeln!(out, "decomposition  {}", subdomains(&decomposition));
        let _ = writeln!(out, "{}", memory(&cost, size));
        if let Some(seconds) = fluid::check::least_seconds(case) {
            let seconds = duration(seconds / size as f64);
            let _ = writeln!(out, "time needed    at least {seconds} on {size} rank(s)");
        }
        let _ = writeln!(
            out,
            "disk           about {:.0} MB in {}",
            cost.disk / 1e6,
            case.output.directory.display()
        );
        return Ok((text, warnings));
    }
    let _ = writeln!(
        out,
        "particles      {} in {} insertion(s), {placed} of them at the beginning, none inside another",
        population.total(),
        case.inserts.len()
    );
    let _ = writeln!(out, "mass           {:.6e} kg", population.mass(case, &setup.catalogue));
    for insert in &case.inserts {
        let motion = match &insert.motion {
            None | Some(ParticleMotion::Free) => continue,
            Some(ParticleMotion::Fixed) => "stay where they are inserted".to_string(),
            Some(ParticleMotion::Prescribed(motion)) => {
                let how = match motion {
                    Motion::Translation { .. } => "translation",
                    Motion::Oscillation { .. } => "oscillation",
                    Motion::Rotation { point: Some(_), .. } => "rotation about one axis",
                    Motion::Rotation { point: None, .. } => "rotation, each about its own centre",
                };
                let (start, end) = motion.interval();
                let end = if end.is_finite() { format!("{end} s") } else { "the end".into() };
                format!("move by {how}, from {start} s to {end}")
            }
        };
        let _ = writeln!(out, "  motion       {}: {motion}; to others of infinite mass", insert.name);
    }
    for shape in &setup.catalogue.shapes {
        let _ = writeln!(
            out,
            "  shape        {}: volume {:.4e} m3, equivalent diameter {:.4e} m, bounding radius {:.4e} m, crust {:.2e} m",
            shape.name,
            shape.volume,
            shape.sphere_equivalent_diameter(),
            shape.bounding_radius,
            shape.parts[0].crust
        );
        out.push_str(&describe(shape)?);
    }
    if kind == 1 {
        let _ = writeln!(out, "contacts       {}", contact_points(&setup.catalogue));
    }
    for wall in &setup.walls {
        for surface in &wall.surfaces {
            if let grains_dem::Surface::Mesh(mesh) = surface {
                let report = &mesh.report().mesh;
                let _ = writeln!(
                    out,
                    "  wall         {}: {} triangles, {} open edges, {} non-manifold edges, smallest triangle {:.2e} m2",
                    wall.name,
                    mesh.mesh().triangles.len(),
                    report.open_edges,
                    report.non_manifold_edges,
                    report.smallest_area
                );
            }
        }
    }
    let bare = plausibility::bare_faces(case, &setup.walls);
    let is_still = !case.inserts.is_empty() && case.inserts.iter().all(Insert::is_fixed);
    if !bare.is_empty() && !is_still {
        let names: Vec<&str> = bare.into_iter().map(Face::name).collect();
        let names = names.join(", ");
        let _ = writeln!(
            out,
            "open faces     {names}: no wall, no outlet, not periodic; a particle there ends the run"
        );
    }
    let _ = writeln!(out, "decomposition  {}; interaction range {range:.4e} m", subdomains(&decomposition));
    let _ = writeln!(out, "{}", memory(&cost, size));
    if case.collisions.is_hard() {
        hard_collisions(out, case, &setup.collisions, &step);
    } else {
        soft_collisions(out, case, &step);
    }
    if !of_fluid.is_empty() {
        let _ = writeln!(out, "\n{}", of_fluid.join("\n"));
    }
    let chosen = if case.time.dt == TimeStep::Auto { "auto" } else { "given" };
    let _ = writeln!(out, "\ntime step      {:e} s ({chosen}); {}", step.dt, step.resolution(case));
    let _ = writeln!(out, "  recommended  {:.3e} s: {}", step.recommended, step.reason);
    if let Some(warning) = &step.warning {
        let _ = writeln!(out, "warning: {warning}");
    }
    if let Some([force, torque]) = system::quanta_of_weight(case, &setup, population.kinds()) {
        let _ = writeln!(
            out,
            "rounding       the smallest particle's weight is {force:.1e} multiples of what forces are rounded to, its torque {torque:.1e}"
        );
    }
    let steps = case.time.end / step.dt;
    let seconds = steps * count * COST[kind] / size as f64;
    let _ = writeln!(out, "steps          {steps:.3e} to t = {} s", case.time.end);
    let _ = writeln!(
        out,
        "time needed    about {} on {size} rank(s), at {:.2} microseconds per particle and step and core",
        duration(seconds),
        1e6 * COST[kind]
    );
    if let Some(seconds) = fluid::check::least_seconds(case) {
        let _ = writeln!(out, "               at least {} for the fluid", duration(seconds / size as f64));
    }
    let _ = writeln!(
        out,
        "disk           about {:.0} MB in {} ({} snapshots, {} checkpoint(s))",
        cost.disk / 1e6,
        case.output.directory.display(),
        cost.snapshots,
        cost.checkpoints
    );
    Ok((text, warnings))
}

/// Memory of all processes, and of each.
fn memory(cost: &Cost, ranks: usize) -> String {
    let all = cost.memory / 1e6;
    format!("memory         about {all:.0} MB in all, {:.0} MB per rank", all / ranks as f64)
}

/// Ranks per axis and the size of a subdomain.
fn subdomains(decomposition: &Decomposition) -> String {
    let ([px, py, pz], lower, upper) = (decomposition.ranks, decomposition.lower(), decomposition.upper());
    let [x, y, z] = [0, 1, 2].map(|a| upper[a] - lower[a]);
    format!("{px} x {py} x {pz} ranks, each {x:.4e} x {y:.4e} x {z:.4e} m")
}

/// What touching faces and composites do, by the keys that choose it.
fn contact_points(catalogue: &Catalogue) -> String {
    let mut text = match catalogue.faces {
        FaceContact::Point => "faces touch in one point (contact_points.faces = \"point\")",
        FaceContact::MultiPoint => "faces and lines touch all over (contact_points.faces = \"spread\")",
    }
    .to_string();
    if catalogue.shapes.iter().any(|shape| shape.parts.len() > 1) {
        text += match catalogue.sharing {
            Sharing::Mean => {
                "; several contacts of two bodies count as their mean (contact_points.composite = \"mean\")"
            }
            Sharing::Sum => "; several contacts of two bodies add up (contact_points.composite = \"sum\")",
        };
    }
    text
}

/// The table of what collisions under forces come to.
fn soft_collisions(out: &mut String, case: &Case, step: &TimeStepChoice) {
    let _ = writeln!(
        out,
        "\ncollisions at {} m/s (time.impact_speed), lightest bodies of each pair:",
        case.time.impact_speed
    );
    let _ = writeln!(
        out,
        "  {:<24} {:>6} {:>11} {:>11} {:>11} {:>11} {:>9} {:>8}",
        "pair", "e_n", "m_ij (kg)", "gamma (1/s)", "T_c (s)", "d_max (m)", "d_max/R", "T_c/dt"
    );
    for encounter in &step.encounters {
        let _ = writeln!(out, "  {}", row(encounter, case.time.impact_speed, step.dt));
    }
    let deepest = step
        .encounters
        .iter()
        .map(|e| e.collision.largest_overlap(case.time.impact_speed) / e.radius)
        .fold(0.0, f64::max);
    if deepest > case.limits.overlap {
        let _ = writeln!(
            out,
            "warning: an impact at time.impact_speed would overlap by {:.1} % of the radius, beyond limits.overlap = {:.1} %: raise normal_stiffness by {:.1} times",
            100.0 * deepest,
            100.0 * case.limits.overlap,
            (deepest / case.limits.overlap).powi(2)
        );
    }
}

/// The table of collisions by impulses.
fn hard_collisions(out: &mut String, case: &Case, model: &CollisionModel, step: &TimeStepChoice) {
    let CollisionModel::Hard(model) = model else { return };
    let _ = writeln!(
        out,
        "\nhard collisions: impulses, {} scheme, {} sweep(s) per step, restitution 0 below {:.3e} m/s",
        if model.scheme == ImpulseScheme::Exact { "exact" } else { "sequential" },
        model.sweeps,
        model.rest_speed
    );
    let _ = writeln!(out, "  {:<24} {:>6} {:>6} {:>11} {:>11}", "pair", "e_n", "mu", "m_ij (kg)", "v dt/R");
    for e in &step.encounters {
        let way = case.time.impact_speed * step.dt / e.radius;
        let _ = writeln!(
            out,
            "  {:<24} {:>6.3} {:>6.3} {:>11.4e} {way:>11.4}",
            pair(e),
            e.restitution,
            e.friction,
            e.collision.reduced_mass
        );
    }
}

fn pair(e: &Encounter) -> String {
    format!(
        "{} - {}{}",
        e.materials[0],
        e.materials[1],
        match e.partner {
            Partner::Free => "",
            Partner::Wall => " (wall)",
            Partner::Prescribed => " (of prescribed motion)",
        }
    )
}

/// Inserts what a run would insert at its first step; returns how many, and the walls as they are then.
fn place(
    case: &Case,
    catalogue: Catalogue,
    mut population: Population,
) -> Result<(u64, WallTriangles), String> {
    let mut setup = system::build(case, 1, catalogue, population.kinds())?.setup;
    setup.ranks = [1; 3];
    let mut dem = system::dem(case, setup, 0)?;
    population.insert_due(case, &mut dem, &SerialTransport)?;
    dem.refresh(&SerialTransport).map_err(|failure| match failure {
        Failure::Here(error) => error.to_string(),
        Failure::Elsewhere => String::new(),
    })?;
    match population.starting_overlap(case, &dem) {
        Some(message) => Err(message),
        None => Ok((dem.particles.owned as u64, triangles_of(&dem))),
    }
}

fn row(e: &Encounter, impact_speed: f64, dt: f64) -> String {
    let deepest = e.collision.largest_overlap(impact_speed);
    format!(
        "{:<24} {:>6.3} {:>11.4e} {:>11.4e} {:>11.4e} {:>11.4e} {:>9.4} {:>8.2}",
        pair(e),
        e.restitution,
        e.collision.reduced_mass,
        e.collision.damping_rate,
        e.shortest_contact,
        deepest,
        deepest / e.radius,
        e.shortest_contact / dt
    )
}
