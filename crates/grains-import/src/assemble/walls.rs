//! Walls of a case.

use super::Assembly;
use crate::case_text::Section;
use crate::meshes::PlacedMesh;
use crate::scene::{WallForm, WallLaw, WallPlan};
use grains_case::{Face, Side, Wall, WallKind};
use std::path::PathBuf;
use toml::{Table, Value};

impl Assembly<'_> {
    /// The materials of walls: one for each law.
    pub(super) fn wall_materials(&self) -> Vec<(WallLaw, String)> {
        let mut found: Vec<(WallLaw, String)> = Vec::new();
        for wall in &self.scene.walls {
            if found.iter().any(|(law, _)| is_same(law, &wall.law)) {
                continue;
            }
            let stem = match &wall.law {
                WallLaw::Style(kind, _) => format!("wall{kind}"),
                WallLaw::Law(_) => "wall".to_owned(),
            };
            let count = found
                .iter()
                .filter(|(_, name)| *name == stem || name.starts_with(&format!("{stem}-")))
                .count();
            let name = if count == 0 { stem } else { format!("{stem}-{}", count + 1) };
            found.push((wall.law.clone(), name));
        }
        found
    }

    pub(super) fn walls(
        &mut self,
        materials: &[(WallLaw, String)],
        sections: &mut Vec<Section>,
    ) -> Result<Vec<(PathBuf, PlacedMesh)>, String> {
        let mut meshes = Vec::new();
        for wall in &self.scene.walls {
            let material = materials.iter().find(|(law, _)| is_same(law, &wall.law));
            let kind = match &wall.form {
                WallForm::Kind(kind) => kind.clone(),
                WallForm::Mesh(placed) => {
                    let extension =
                        placed.path.extension().unwrap_or_default().to_string_lossy().to_lowercase();
                    let path = PathBuf::from("meshes").join(format!("{}.{extension}", wall.name));
                    let turned = placed.rotation.angle() != 0.0;
                    let path = if turned { path.with_extension("stl") } else { path };
                    meshes.push((path.clone(), placed.clone()));
                    let (scale, translate) = match turned {
                        true => (1.0, [0.0; 3]),
                        false => (placed.scale, placed.translation.into()),
                    };
                    WallKind::Mesh { path, scale, translate }
                }
            };
            let wall_of_case = Wall {
                name: wall.name.clone(),
                material: material.map_or_else(String::new, |(_, name)| name.clone()),
                from: wall.times[0],
                until: wall.times[1],
                kind,
                motion: wall.motion.clone(),
                wear: None,
                temperature: wall.temperature.filter(|_| self.scene.heat.is_some()),
                heating: None,
                fluid: None,
                slip: false,
            };
            let mut table = Table::try_from(&wall_of_case).map_err(|e| e.to_string())?;
            // At rest after the wall has gone is at rest.
            if let Some(Value::Table(motion)) = table.get_mut("motion")
                && motion.get("end").and_then(Value::as_float) == Some(wall.times[1])
            {
                motion.remove("end");
            }
            sections.push(Section::new("[[wall]]", &table)?.from(&wall.sources));
        }
        Ok(meshes)
    }
}

/// Whether a wall that is always there and at rest lets no particle through a face of the box.
pub(super) fn closes(wall: &WallPlan, face: Face, corners: [[f64; 3]; 2]) -> bool {
    let (axis, is_upper) = (face.axis(), face.is_upper());
    let is_inside = |at: f64| if is_upper { at <= corners[1][axis] } else { at >= corners[0][axis] };
    if wall.motion.is_some() || wall.times != [0.0, f64::INFINITY] {
        return false;
    }
    match &wall.form {
        WallForm::Kind(WallKind::Plane { point, normal }) => {
            let along = if is_upper { -normal[axis] } else { normal[axis] };
            along == normal.iter().map(|x| x.abs()).sum::<f64>() && is_inside(point[axis])
        }
        WallForm::Kind(WallKind::Cylinder {
            center,
            axis: along,
            radius,
            height,
            side: Side::Inside,
            ..
        }) => {
            let reach = if is_upper { *radius } else { -radius };
            *height == f64::INFINITY && along[axis] == 0.0 && is_inside(center[axis] + reach)
        }
        WallForm::Kind(WallKind::Box { lower, upper, side: Side::Inside }) => {
            is_inside(if is_upper { upper[axis] } else { lower[axis] })
        }
        _ => false,
    }
}

pub(super) fn is_same(a: &WallLaw, b: &WallLaw) -> bool {
    match (a, b) {
        (WallLaw::Style(a, one), WallLaw::Style(b, other)) => a == b && one == other,
        (WallLaw::Law(a), WallLaw::Law(b)) => a == b,
        _ => false,
    }
}
