//! What the terminal shows of a case before it runs: `grains-mpi check`.

mod fluid;
mod heat;

use grains_case::{Case, Face, Motion, ParticleMotion, Shear, TimeStep, Wear};
use grains_simulation::check::{
    Basis, BondReport, CollisionModel, CompositeReport, FaceContact, FilmReport, ImpulseScheme, LawReport,
    MassSource, MotionTableReport, ParticleReport, Partner, Report, ShapeReport, Sharing, SizeReport,
};
use grains_simulation::duration;

/// Prints a report.
pub fn tell(case: &Case, report: &Report) {
    say!("case           {}", case.name);
    match &report.particles {
        Some(particles) => with_particles(case, report, particles),
        None => without_particles(case, report),
    }
}

fn without_particles(case: &Case, report: &Report) {
    if let Some(found) = &report.fluid {
        fluid::tell(case, found);
    }
    say!("decomposition  {}", subdomains(report));
    memory(report);
    time_of_fluid(case, report);
    say!("disk           about {:.0} MB in {}", report.cost.disk / 1e6, case.output.directory.display());
}

fn with_particles(case: &Case, report: &Report, particles: &ParticleReport) {
    say!(
        "particles      {} in {} insertion(s), {} of them at the beginning, none inside another",
        particles.count,
        case.inserts.len(),
        particles.placed
    );
    say!("mass           {:.6e} kg", particles.mass);
    motions(case);
    particles.shapes.iter().for_each(shape);
    particles.sizes.iter().for_each(sizes);
    contact_points(particles);
    walls(particles);
    loaded_walls(case);
    wear(case);
    shear(case);
    say!("decomposition  {}; interaction range {:.4e} m", subdomains(report), particles.interaction_range);
    memory(report);
    match &particles.collisions {
        // Nothing collides.
        _ if case.holds_particles() => {}
        CollisionModel::Hard(_) => hard_collisions(case, particles),
        _ if case.collisions.is_hard() => {}
        _ => soft_collisions(case, particles),
    }
    if let Some(found) = &report.heat {
        say!("");
        heat::tell(case, found);
    }
    if let Some(found) = &report.fluid {
        say!("");
        fluid::tell(case, found);
    }
    if !case.holds_particles() {
        time_step(case, particles);
    }
    if case.fluid.as_ref().is_none_or(|fluid| fluid.steady.is_none()) {
        say!("steps          {:.3e} to t = {} s", particles.steps, case.time.end);
    }
    if !case.holds_particles() {
        time_of_particles(report, particles);
    }
    time_of_fluid(case, report);
    disk(case, report);
}

/// Prints how the particles of insertions move if not freely.
fn motions(case: &Case) {
    for insert in &case.inserts {
        let motion = match &insert.motion {
            None | Some(ParticleMotion::Free) => continue,
            Some(ParticleMotion::Fixed) => "stay where they are inserted".to_string(),
            Some(ParticleMotion::Prescribed(motion)) => {
                let about = match motion.axis() {
                    Some((Some(_), _)) => " about one axis",
                    Some((None, _)) => ", each about its own centre",
                    None => "",
                };
                let (start, end) = motion.interval();
                let end = if end.is_finite() { format!("{end} s") } else { "the end".into() };
                format!("move by {}{about}, from {start} s to {end}", motion.name())
            }
        };
        say!("  motion       {}: {motion}; to others of infinite mass", insert.name);
    }
}

fn shape(shape: &ShapeReport) {
    say!(
        "  shape        {}: volume {:.4e} m3, equivalent diameter {:.4e} m, bounding radius {:.4e} m, crust {:.2e} m",
        shape.name,
        shape.volume,
        shape.equivalent_diameter,
        shape.bounding_radius,
        shape.crust
    );
    shape.composite.iter().for_each(composite);
}

/// Prints what a size distribution comes to, as diameters of the spheres of the same volume.
fn sizes(sizes: &SizeReport) {
    let SizeReport { insert, kind: [shape, material], name, basis, kept, range, means, by_mass } = sizes;
    let basis = match basis {
        Basis::Number => "number",
        Basis::Mass => "mass",
    };
    let kept = kept.map(|kept| format!("; the cut-offs keep {:.2} % of the {basis}", 100.0 * kept));
    say!(
        "  sizes        {insert}: {shape} of {material}, {name} by {basis}, {:.4e} to {:.4e} m{}",
        range[0],
        range[1],
        kept.unwrap_or_default()
    );
    say!(
        "    mean {:.4e} m by number, {:.4e} m by mass; d10 {:.4e} m, d50 {:.4e} m, d90 {:.4e} m by mass",
        means[0],
        means[1],
        by_mass[0],
        by_mass[1],
        by_mass[2]
    );
}

/// Prints parts, mass properties and decomposition of a shape.
fn composite(shape: &CompositeReport) {
    let source = match shape.mass.source {
        MassSource::ClosedForm => "in closed form".to_string(),
        MassSource::ClosedMesh => "by integrals over the closed surface".to_string(),
        MassSource::Parts => "as the sum of the parts, which do not overlap".to_string(),
        MassSource::Clipped => "of the union of the parts, exact".to_string(),
        MassSource::Chords { lines, error } => {
            format!("of the union of the parts, by {lines} x {lines} chords (error about {error:.0e})")
        }
    };
    say!(
        "    {} part{}; mass properties {source}; those of the parts by chords differ by {:+.1e} in volume, {:+.1e} in inertia",
        shape.parts,
        if shape.parts == 1 { "" } else { "s" },
        shape.mass.volume_difference,
        shape.mass.inertia_difference
    );
    if let Some(difference) = shape.notable_difference {
        say!(
            "    warning: the parts that make contact differ from the body that has the mass by {:.2} %: choose a smaller `crust`",
            100.0 * difference
        );
    }
    let Some(cut) = &shape.decomposition else { return };
    say!(
        "    mesh of {} triangles cut into {} pieces, {} united with others, {} flat ones dropped{}; volume error of the parts {:+.2} %",
        cut.triangles,
        cut.pieces,
        cut.merged,
        cut.dropped,
        if cut.cached { " (kept from an earlier run)" } else { "" },
        100.0 * cut.volume_error
    );
    if shape.is_coarse {
        say!("    warning: the parts approximate the mesh coarsely: raise `max_parts` or `resolution`");
    }
}

/// Prints what touching faces and composites do, by the keys that choose it.
fn contact_points(particles: &ParticleReport) {
    let faces = match particles.faces {
        None => return,
        Some(FaceContact::Point) => "faces touch in one point (contact_points.faces = \"point\")",
        Some(FaceContact::MultiPoint) => "faces and lines touch all over (contact_points.faces = \"patch\")",
    };
    let composites = match particles.composites {
        None => "",
        Some(Sharing::Potential) => {
            "; several contacts of two bodies have one potential (contact_points.composite = \"potential\")"
        }
        Some(Sharing::Mean) => {
            "; several contacts of two bodies count as their mean (contact_points.composite = \"mean\")"
        }
        Some(Sharing::Sum) => "; several contacts of two bodies add up (contact_points.composite = \"sum\")",
    };
    say!("contacts       {faces}{composites}");
}

fn walls(particles: &ParticleReport) {
    for mesh in &particles.meshes {
        say!(
            "  wall         {}: {} triangles, {} open edges, {} non-manifold edges, smallest triangle {:.2e} m2",
            mesh.name,
            mesh.triangles,
            mesh.open_edges,
            mesh.non_manifold_edges,
            mesh.min_area
        );
    }
    for table in &particles.tables {
        let MotionTableReport { wall, rows, interval: [start, end], max_speed, max_rate } = table;
        let turning = if *max_rate > 0.0 { format!(" and {max_rate:.3e} rad/s") } else { String::new() };
        say!(
            "  motion       {wall}: by a table of {rows} times, from {start} s to {end} s, at up to {max_speed:.3e} m/s{turning}"
        );
    }
    if !particles.open_faces.is_empty() {
        let names: Vec<&str> = particles.open_faces.iter().copied().map(Face::name).collect();
        let names = names.join(", ");
        say!("open faces     {names}: no wall, no outlet, not periodic; a particle there ends the run");
    }
}

/// Prints how walls wear.
fn wear(case: &Case) {
    for wall in &case.walls {
        let Some(Wear { coefficient, hardness }) = wall.wear else { continue };
        say!(
            "  wear         {}: K = {coefficient:.3e}, H = {hardness:.3e} Pa: {:.3e} m3 per N of normal force and m of sliding",
            wall.name,
            coefficient / hardness
        );
    }
}

/// Prints what moves the walls that are under a load.
fn loaded_walls(case: &Case) {
    for wall in &case.walls {
        let Some(Motion::Load { axis: [x, y, z], area, mass, damping, max_speed, velocity, .. }) =
            &wall.motion
        else {
            continue;
        };
        let load = wall.motion.as_ref().and_then(Motion::load).unwrap_or(0.0);
        let pressure =
            area.map_or(String::new(), |area| format!(" ({:.4e} Pa on {area:.4e} m2)", load / area));
        let limit = if max_speed.is_finite() { format!(", at up to {max_speed} m/s") } else { String::new() };
        let damping = if *damping > 0.0 { format!(", damped by {damping:.3e} kg/s") } else { String::new() };
        say!(
            "  motion       {}: by a load of {load:.4e} N{pressure} along ({x:.4}, {y:.4}, {z:.4}), as a body of {mass:.3e} kg{damping}{limit}",
            wall.name
        );
        let [u, v, w] = velocity;
        if *velocity != [0.0; 3] {
            say!("               and across it at ({u:.4e}, {v:.4e}, {w:.4e}) m/s");
        }
    }
}

/// Prints the shear of the box.
fn shear(case: &Case) {
    let Some(Shear { flow, gradient, rate }) = case.domain.shear else { return };
    let height = case.domain.extents()[gradient as usize];
    say!(
        "shear          v_{} = {rate} 1/s x {}: images across {} slide at {:.4e} m/s along {}, which is not divided",
        flow.name(),
        gradient.name(),
        gradient.name(),
        rate * height,
        flow.name()
    );
}

/// Ranks per axis and the size of a subdomain.
fn subdomains(report: &Report) -> String {
    let ([px, py, pz], [x, y, z]) = (report.subdomains, report.subdomain);
    format!("{px} x {py} x {pz} ranks, each {x:.4e} x {y:.4e} x {z:.4e} m")
}

/// Prints the memory of all processes, and of each.
fn memory(report: &Report) {
    let all = report.cost.memory / 1e6;
    say!("memory         about {all:.0} MB in all, {:.0} MB per rank", all / report.ranks as f64);
}

/// Prints the table of what collisions under forces come to.
fn soft_collisions(case: &Case, particles: &ParticleReport) {
    let speed = case.time.impact_speed;
    say!("\ncollisions at {speed} m/s (time.impact_speed), lightest bodies of each pair:");
    say!(
        "  {:<24} {:>6} {:>11} {:>11} {:>11} {:>11} {:>9} {:>8}",
        "pair",
        "e_n",
        "m_ij (kg)",
        "gamma (1/s)",
        "T_c (s)",
        "d_max (m)",
        "d_max/R",
        "T_c/dt"
    );
    for e in &particles.step.encounters {
        let deepest = e.collision.max_overlap;
        say!(
            "  {:<24} {:>6.3} {:>11.4e} {:>11.4e} {:>11.4e} {:>11.4e} {:>9.4} {:>8.2}",
            pair(&e.materials, e.partner),
            e.restitution,
            e.reduced_mass,
            e.damping_rate,
            e.shortest_contact,
            deepest,
            deepest / e.radius,
            e.shortest_contact / particles.step.dt
        );
    }
    particles.laws.iter().for_each(|law| contact_law(law, particles.step.dt));
    particles.step.bonds.iter().for_each(|bond| bonds(bond, particles));
    let (deepest, limit) = (particles.max_overlap, case.limits.overlap);
    if deepest > limit {
        say!(
            "warning: an impact at time.impact_speed would overlap by {:.1} % of the radius, beyond limits.overlap = {:.1} %: {}",
            100.0 * deepest,
            100.0 * limit,
            stiffer(particles, deepest / limit)
        );
    }
}

/// Which key to change, and by how much, to overlap so many times less.
fn stiffer(particles: &ParticleReport, times: f64) -> String {
    let is_hertzian = particles.laws.iter().any(|law| law.modulus.is_some());
    let is_softened = particles.laws.iter().any(|law| law.softening > 1.0);
    match (is_hertzian, is_softened) {
        (true, true) => format!("lower softening by {:.1} times", times.powf(2.5)),
        (true, false) => format!("raise youngs_modulus by {:.1} times", times.powf(2.5)),
        (false, _) => format!("raise normal_stiffness by {:.1} times", times.powi(2)),
    }
}

/// Prints what a law comes to beside the collisions.
fn contact_law(report: &LawReport, dt: f64) {
    let mut parts = vec![report.parts.join(", ")];
    if let Some(modulus) = report.modulus {
        let softened = match report.softening {
            1.0 => String::new(),
            times => format!(", {times} times softer than the materials"),
        };
        parts.push(format!("E* = {modulus:.3e} Pa{softened}"));
    }
    if let Some(time) = report.rayleigh_time.filter(|_| report.modulus.is_some()) {
        parts.push(format!("Rayleigh time {time:.3e} s, of which dt is {:.0} %", 100.0 * dt / time));
    }
    if report.pull_off > 0.0 {
        let weights = report.bond_number.map(|n| format!(", {n:.3} weights of the smallest (Bond number)"));
        parts.push(format!("pull-off force {:.3e} N{}", report.pull_off, weights.unwrap_or_default()));
    }
    parts.extend(report.films.as_ref().map(films));
    if report.reach > 0.0 {
        parts.push(format!("holds on over gaps up to {:.2e} m", report.reach));
    }
    if let Some(speed) = report.sticking_speed {
        parts.push(format!("bodies stay together below {speed:.2e} m/s"));
    }
    say!("  law          {}: {}", pair(&report.materials, report.partner), parts.join("; "));
}

/// What films and the bridges that they feed come to.
fn films(report: &FilmReport) -> String {
    let FilmReport { films: [small, large], bridges: [of_small, of_large], largest, .. } = report;
    let range = |low: f64, high: f64| match low == high {
        true => format!("{low:.3e}"),
        false => format!("{low:.3e} to {high:.3e}"),
    };
    format!(
        "films of {} m3, {} m thick, {} of the particles' volume; bridges of {} m3 at the beginning break at {} m, none is above {largest:.3e} m3",
        range(small[0], large[0]),
        range(small[1], large[1]),
        range(small[2], large[2]),
        range(of_small[0], of_large[0]),
        range(of_small[1], of_large[1])
    )
}

/// Prints what bonds come to.
fn bonds(report: &BondReport, particles: &ParticleReport) {
    let [axial, shear, bending, torsion] = report.stiffnesses;
    let strength = match report.strength.is_finite() {
        true => format!("tears at {:.3e} N", report.strength),
        false => "no tensile strength".to_string(),
    };
    let weights = report.weights.filter(|weights| weights.is_finite());
    let weights = weights.map(|n| format!(", {n:.3e} weights of the lightest")).unwrap_or_default();
    say!(
        "  bonds        {}: radius {:.3e} m, {strength}{weights}; half its shortest period {:.3e} s, {:.1} steps",
        report.name,
        report.radius,
        report.half_period,
        report.half_period / particles.step.dt
    );
    say!(
        "               stiffness {axial:.3e} N/m along, {shear:.3e} N/m across, {bending:.3e} N m bending, {torsion:.3e} N m torsion"
    );
    if particles.placed_bonds > 0 {
        say!("               {} bonds at the beginning", particles.placed_bonds);
    }
}

/// Prints the table of collisions by impulses.
fn hard_collisions(case: &Case, particles: &ParticleReport) {
    let CollisionModel::Hard(model) = &particles.collisions else { return };
    say!(
        "\nhard collisions: impulses, {} scheme, {} sweep(s) per step, restitution 0 below {:.3e} m/s",
        if model.scheme == ImpulseScheme::Exact { "exact" } else { "sequential" },
        model.sweeps,
        model.rest_speed
    );
    say!("  {:<24} {:>6} {:>6} {:>11} {:>11}", "pair", "e_n", "mu", "m_ij (kg)", "v dt/R");
    for e in &particles.step.encounters {
        say!(
            "  {:<24} {:>6.3} {:>6.3} {:>11.4e} {:>11.4}",
            pair(&e.materials, e.partner),
            e.restitution,
            e.friction,
            e.reduced_mass,
            case.time.impact_speed * particles.step.dt / e.radius
        );
    }
}

fn pair([a, b]: &[String; 2], partner: Partner) -> String {
    let what = match partner {
        Partner::Free => "",
        Partner::Wall => " (wall)",
        Partner::Prescribed => " (of prescribed motion)",
    };
    format!("{a} - {b}{what}")
}

fn time_step(case: &Case, particles: &ParticleReport) {
    let step = &particles.step;
    let chosen = if case.time.dt == TimeStep::Auto { "auto" } else { "given" };
    say!("\ntime step      {:e} s ({chosen}); {}", step.dt, step.resolution(case));
    say!("  recommended  {:.3e} s: {}", step.recommended, step.reason);
    if let Some(coarser) = particles.step_without_fines.filter(|coarser| *coarser > 1.005 * step.recommended)
    {
        say!(
            "  sizes        the smallest decide: without the finest tenth of the mass of each kind {coarser:.3e} s, {:.2} times that",
            coarser / step.recommended
        );
    }
    if let Some(warning) = &step.warning {
        say!("warning: {warning}");
    }
    if let Some([force, torque]) = particles.weight_in_quanta {
        say!(
            "rounding       the smallest particle's weight is {force:.1e} multiples of what forces are rounded to, its torque {torque:.1e}"
        );
    }
}

fn time_of_particles(report: &Report, particles: &ParticleReport) {
    say!(
        "time needed    about {} on {} rank(s), at {:.2} microseconds per particle and step and core",
        duration(particles.seconds),
        report.ranks,
        1e6 * particles.seconds_per_step
    );
}

fn time_of_fluid(case: &Case, report: &Report) {
    let Some(seconds) = report.fluid.as_ref().and_then(|fluid| fluid.min_seconds) else { return };
    let seconds = seconds / report.ranks as f64;
    let (ranks, has_particles) = (report.ranks, !case.inserts.is_empty() && !case.holds_particles());
    match case.fluid.as_ref().is_some_and(|fluid| fluid.steady.is_some()) {
        true => say!(
            "time needed    at least {} on {ranks} rank(s) if the flow has not settled before t = {} s",
            duration(seconds),
            case.time.end
        ),
        false if has_particles => say!("               at least {} for the fluid", duration(seconds)),
        false => say!("time needed    at least {} on {ranks} rank(s)", duration(seconds)),
    }
}

fn disk(case: &Case, report: &Report) {
    say!(
        "disk           about {:.0} MB in {} ({} snapshots, {} checkpoint(s))",
        report.cost.disk / 1e6,
        case.output.directory.display(),
        report.cost.snapshots,
        report.cost.checkpoints
    );
}
