//! What a case says without effect, or says twice.

use super::setting::{Remark, Setting};
use grains_case::{Contact, Motion, ParticleMotion, Place, Rolling, TimeStep, Wall, WallKind};

/// Whether particles of a file may be of any material and shape.
fn has_files(s: &Setting) -> bool {
    s.case.inserts.iter().any(|insert| matches!(insert.place, Place::File { .. }))
}

pub(super) fn materials_of_nothing(s: &Setting) -> Vec<Remark> {
    if has_files(s) {
        return Vec::new();
    }
    let components = s.case.inserts.iter().flat_map(|insert| &insert.particles);
    let mut used: Vec<usize> = components.map(|component| component.material).collect();
    used.extend(s.case.walls.iter().map(|wall| wall.material));
    let idle = s.case.materials.iter().enumerate().filter(|(k, _)| !used.contains(k));
    let message = "without effect: neither particles nor walls are of it; name it in insert.particles or wall.material, or remove it";
    idle.map(|(k, _)| (format!("material[{k}].name"), message.to_string())).collect()
}

pub(super) fn shapes_of_nothing(s: &Setting) -> Vec<Remark> {
    if has_files(s) {
        return Vec::new();
    }
    let components = || s.case.inserts.iter().flat_map(|insert| &insert.particles);
    let idle = (0..s.case.shapes.len()).filter(|&k| components().all(|component| component.shape != k));
    let message = "without effect: no particles have it; name it in insert.particles, or remove it";
    idle.map(|k| (format!("shape[{k}].name"), message.to_string())).collect()
}

/// Thermal properties where nothing has a temperature.
pub(super) fn heat_of_nothing(s: &Setting) -> Vec<Remark> {
    let has_scalars = s.case.fluid.as_ref().is_some_and(|fluid| !fluid.scalar.is_empty());
    if s.case.heat.is_some() || has_scalars {
        return Vec::new();
    }
    let message =
        "without effect: particles have no temperatures; add [heat] with a temperature (K), or remove it";
    let of_material = |(k, material): (usize, &grains_case::Material)| {
        let key = match (material.heat_capacity, material.conductivity) {
            (Some(_), _) => "heat_capacity",
            (None, Some(_)) => "conductivity",
            _ => return None,
        };
        Some((format!("material[{k}].{key}"), message.to_string()))
    };
    s.case.materials.iter().enumerate().filter_map(of_material).collect()
}

pub(super) fn rolling_without_friction(s: &Setting) -> Vec<Remark> {
    let is_idle =
        |contact: &Contact| contact.rolling != Rolling::default() && contact.rolling_friction == 0.0;
    let idle = s.case.contacts.iter().enumerate().filter(|(_, contact)| is_idle(contact));
    let message = "without effect: rolling_friction is 0, and so is the largest torque; give rolling_friction (-), or remove it";
    idle.map(|(k, _)| (format!("contact[{k}].rolling"), message.to_string())).collect()
}

pub(super) fn steps_per_contact_beside_a_step(s: &Setting) -> Vec<Remark> {
    /// The default (-).
    const DEFAULT: f64 = 20.0;
    if s.case.time.dt == TimeStep::Auto || s.case.time.steps_per_contact == DEFAULT {
        return Vec::new();
    }
    let message = "without effect: time.dt is given as a number; take dt = \"auto\", or remove it";
    vec![("time.steps_per_contact".into(), message.into())]
}

/// Corners of polygons that are of no face, as where faces count them from 1.
pub(super) fn loose_vertices(s: &Setting) -> Vec<Remark> {
    let remark = |(i, wall): (usize, &Wall)| {
        let WallKind::Polygons { vertices, faces } = &wall.kind else { return None };
        let loose =
            (0..vertices.len()).find(|&k| faces.iter().flatten().all(|&corner| corner != k as u64))?;
        let message = format!(
            "vertex {loose} at {:?} m is of no face, so the wall is not there; faces count vertices from 0: mend them, or remove the vertex",
            vertices[loose]
        );
        Some((format!("wall[{i}].vertices"), message))
    };
    s.case.walls.iter().enumerate().filter_map(remark).collect()
}

/// Walls in the same place at the same time.
pub(super) fn doubled_walls(s: &Setting) -> Vec<Remark> {
    let walls = &s.case.walls;
    let remark = |(i, wall): (usize, &Wall)| {
        let is_same = |other: &&Wall| {
            other.kind == wall.kind
                && other.motion == wall.motion
                && other.from < wall.until
                && wall.from < other.until
        };
        let first = walls[..i].iter().find(is_same)?;
        let message = format!(
            "in the place of wall \"{}\": particles meet both, and are pushed back twice as hard; remove one, or part them by from and until",
            first.name
        );
        Some((format!("wall[{i}].name"), message))
    };
    walls.iter().enumerate().filter_map(remark).collect()
}

/// Motions that begin when their wall is gone.
pub(super) fn motions_of_gone_walls(s: &Setting) -> Vec<Remark> {
    let remark = |(i, wall): (usize, &Wall)| {
        let motion = wall.motion.as_ref()?;
        let (start, _) = motion.interval();
        let message = format!(
            "the wall is there until {} s and never moves; raise wall.until, or lower it (s)",
            wall.until
        );
        (wall.until <= start).then(|| (format!("wall[{i}].motion.{}", motion.start_key()), message))
    };
    s.case.walls.iter().enumerate().filter_map(remark).collect()
}

/// Phases of more than a turn.
pub(super) fn phases_in_degrees(s: &Setting) -> Vec<Remark> {
    let walls = s.case.walls.iter().enumerate();
    let walls = walls.filter_map(|(i, wall)| Some((format!("wall[{i}].motion"), wall.motion.as_ref()?)));
    let inserts = s.case.inserts.iter().enumerate().filter_map(|(i, insert)| match &insert.motion {
        Some(ParticleMotion::Prescribed(motion)) => Some((format!("insert[{i}].motion"), motion)),
        _ => None,
    });
    let remark = |(key, motion): (String, &Motion)| {
        let Motion::Oscillation { phase, .. } = motion else { return None };
        let message = format!(
            "more than a turn of 2 pi: the oscillation begins elsewhere than meant; the unit is rad: {phase} degrees are {:.4}",
            phase.to_radians()
        );
        (phase.abs() > std::f64::consts::TAU * (1.0 + 1e-6)).then(|| (format!("{key}.phase"), message))
    };
    walls.chain(inserts).filter_map(remark).collect()
}
