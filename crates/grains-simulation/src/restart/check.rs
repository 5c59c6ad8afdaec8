//! Which states of a checkpoint have a meaning in another case.

use crate::changes::{self, Change};
use crate::insertion::Insertions;
use crate::numbering::Numbering;
use grains_comm::MpiTransport;
use grains_dem::{Dem, Kind, ParticleRecord};
use grains_domain::Transport;
use grains_output::CheckpointFile;
use toml::{Table, Value};

/// Refuses bonds that have other places among all of the case than at the checkpoint.
fn check_bonds(cases: [&Table; 2]) -> Result<(), String> {
    let [old, new] = cases.map(|case| changes::names(case, "bond"));
    if !new.starts_with(&old) {
        return Err(format!(
            "its particles are joined by the bonds {old:?}, and the case has {new:?}: keep these first, in their order"
        ));
    }
    Ok(())
}

/// Refuses a state that has no meaning in the case.
pub fn check_state(
    file: &CheckpointFile,
    dem: &Dem,
    (before, now, changes): (&Table, &Table, &[Change]),
    numbering: &Numbering,
    insertions: &Insertions,
    transport: &MpiTransport,
) -> Result<(), String> {
    let box_keys = [["domain", "lower"], ["domain", "upper"], ["domain", "periodic"]];
    if let Some(change) = changes.iter().find(|c| box_keys.iter().any(|key| c.is_within(key))) {
        return Err(format!(
            "{change}: positions have a meaning in their box alone; insert the particles of a snapshot instead (insert.place = {{ kind = \"file\", path = \"....vtkhdf\" }})"
        ));
    }
    let of_shear =
        |c: &&Change| c.is_within(&["domain", "shear"]) && !c.is_within(&["domain", "shear", "rate"]);
    if let Some(change) = changes.iter().find(of_shear) {
        return Err(format!(
            "{change}: the particles are where the images of that shear have brought them; change its rate alone"
        ));
    }
    check_bonds([before, now])?;
    let tables = [before, now].map(|case| case.get("fluid").and_then(Value::as_table));
    if let [Some(old), Some(new)] = tables {
        let grid =
            changes.iter().find(|c| ["cells", "refinement"].iter().any(|k| c.is_within(&["fluid", k])));
        let modes = ["coupling", "resolved"].iter().find(|k| old.contains_key(**k) != new.contains_key(**k));
        let particles = [before, now].map(|case| changes::names(case, "insert").is_empty());
        let other = grid.map(ToString::to_string).or(modes.map(|mode| format!("fluid.{mode} comes or goes")));
        let other =
            other.or((particles[0] != particles[1]).then(|| "particles come to a fluid alone, or go".into()));
        if let Some(other) = other {
            return Err(format!(
                "{other}: the fields have a meaning on their grid alone; continue without [fluid] first, and from there with the new one"
            ));
        }
    }
    // Of each kind in the state the negative smallest and the largest radius (m).
    let (shapes, materials) = (numbering.shapes.len(), numbering.materials.len());
    let mut used = vec![[f64::NEG_INFINITY; 2]; shapes * materials];
    for row in file.real("particle").map_err(|e| e.to_string())?.chunks_exact(ParticleRecord::LENGTH) {
        let body = ParticleRecord::read(row).body;
        let place = usize::from(body.kind.shape) * materials + usize::from(body.kind.material);
        let entry = used.get_mut(place).ok_or("it holds particles of shapes that its case has not")?;
        *entry = [entry[0].max(-body.radius), entry[1].max(body.radius)];
    }
    transport.max(used.as_flattened_mut());
    let names = ["shape", "material"].map(|section| changes::names(before, section));
    for (place, [smallest, largest]) in used.into_iter().enumerate().filter(|(_, [_, r])| r.is_finite()) {
        let old = Kind { shape: (place / materials) as u16, material: (place % materials) as u16 };
        let (shape, material) = (&names[0][usize::from(old.shape)], &names[1][usize::from(old.material)]);
        // Particles that have come keep the film that they have.
        let is_film = |change: &Change| change.is_within(&["material", material, "film"]);
        let differs =
            |section: &str, name: &str| changes.iter().find(|c| c.is_within(&[section, name]) && !is_film(c));
        if let Some(change) = differs("shape", shape).or(differs("material", material)) {
            return Err(format!(
                "{change}: particles of it are there, and would not be what they were; give a new shape or material another name"
            ));
        }
        let kind = numbering.kind(old).ok_or("a name of a shape or material is lost")?;
        let unit = dem.setup.catalogue.shape(kind).bounding_radius;
        let (smallest, largest) = (-smallest / unit, largest / unit);
        if !insertions.covers(kind, smallest, largest) {
            return Err(format!(
                "particles of shape `{shape}` and material `{material}`, of scales {smallest:.6} to {largest:.6}, are there, and no [[insert]] of the case names them: keep the one that brought them; what an insertion of the same name has inserted does not come again"
            ));
        }
    }
    Ok(())
}
