//! Walls of a script: primitives, regions, meshes and their motion.

use crate::fixes::but;
use crate::lammps_law;
use crate::laws::PairLaw;
use crate::liggghts_law::Style;
use crate::meshes::PlacedMesh;
use crate::report::{Outcome, Source};
use crate::scene::{WallForm, WallLaw, WallPlan};
use crate::script::{Answer, Effect, Mesh, MeshWall, Script};
use crate::units::{LENGTH, TIME, VELOCITY};
use grains_case::{Motion, Side, WallKind};
use std::f64::consts::TAU;

/// A wall that a word such as `zplane` names, without its sizes.
fn primitive(word: &str) -> Option<(usize, bool)> {
    let axis = ["x", "y", "z"].iter().position(|axis| word.starts_with(axis))?;
    match &word[1..] {
        "plane" => Some((axis, true)),
        "cylinder" => Some((axis, false)),
        _ => None,
    }
}

fn direction(axis: usize, size: f64) -> [f64; 3] {
    std::array::from_fn(|a| if a == axis { size } else { 0.0 })
}

/// Ends a motion at a time (s).
pub(crate) fn end_motion(motion: &mut Motion, now: f64) {
    match motion {
        Motion::Translation { end, .. }
        | Motion::Oscillation { end, .. }
        | Motion::Rotation { end, .. }
        | Motion::Load { end, .. } => *end = now,
        Motion::Table { times, angles, displacements, .. } => {
            let kept = times.iter().take_while(|t| **t <= now).count().max(2);
            times.truncate(kept);
            angles.truncate(kept);
            displacements.truncate(kept);
        }
    }
}

impl Script {
    /// The middle of the box (m) along an axis.
    fn middle(&self, axis: usize) -> f64 {
        self.scene.corners.as_ref().map_or(0.0, |([lower, upper], _)| 0.5 * (lower[axis] + upper[axis]))
    }

    fn plane(&self, axis: usize, at: f64) -> WallKind {
        let side = if at > self.middle(axis) { -1.0 } else { 1.0 };
        WallKind::Plane { point: direction(axis, at), normal: direction(axis, side) }
    }

    /// `fix wall/gran`.
    pub(crate) fn wall(
        &mut self,
        id: &str,
        words: &[String],
        source: &Source,
    ) -> Result<(Outcome, Effect), String> {
        if words.first().is_some_and(|word| word == "model") {
            return self.wall_of_liggghts(id, words, source);
        }
        let (law, rest, without) = self.law_of_wall(words)?;
        let (word, rest) = rest.split_first().ok_or("the wall is missing behind its law")?;
        let (axis, is_plane) =
            primitive(word).ok_or_else(|| format!("a wall `{word}` has no counterpart"))?;
        let mut walls: Vec<(String, WallKind)> = Vec::new();
        let used = if is_plane {
            for (side, word) in rest.iter().take(2).enumerate().filter(|(_, w)| w.as_str() != "NULL") {
                let normal = if side == 0 { 1.0 } else { -1.0 };
                let kind = WallKind::Plane {
                    point: direction(axis, self.length(word)?),
                    normal: direction(axis, normal),
                };
                let both = rest.iter().take(2).all(|w| w != "NULL");
                let suffix = if !both { "" } else { ["-lower", "-upper"][side] };
                walls.push((format!("{id}{suffix}"), kind));
            }
            2
        } else {
            let radius = self.length(rest.first().ok_or("the radius is missing")?)?;
            walls.push((id.to_owned(), self.cylinder(axis, radius, [0.0; 3])));
            1
        };
        let keys = rest.get(used..).unwrap_or_default();
        let motion = self.primitive_motion(keys, axis, is_plane, -1.0, &walls)?;
        let mut effect = Effect::None;
        for (name, kind) in walls {
            effect = self.add_wall(WallPlan {
                name,
                sources: vec![source.clone()],
                form: WallForm::Kind(kind),
                motion: motion.clone(),
                times: [self.time, f64::INFINITY],
                law: WallLaw::Law(law.clone()),
                temperature: None,
            });
        }
        Ok((but(&without), effect))
    }

    fn cylinder(&self, axis: usize, radius: f64, center: [f64; 3]) -> WallKind {
        WallKind::Cylinder {
            center,
            axis: direction(axis, 1.0),
            radius,
            height: f64::INFINITY,
            side: Side::Inside,
            caps: true,
        }
    }

    /// The law of a wall of LAMMPS, the words behind it, and what it does without.
    fn law_of_wall<'a>(
        &'a self,
        words: &'a [String],
    ) -> Result<(PairLaw, &'a [String], Vec<String>), String> {
        // In early versions the style is that of the pairs.
        let is_given = words.first().is_some_and(|word| word.parse::<f64>().is_err());
        let (style, rest) = match (&self.pair_name, words) {
            (Some(name), rest) if !is_given => (name, rest),
            (_, [style, rest @ ..]) => (style, rest),
            _ => return Err("the law is missing".into()),
        };
        if style == "granular" {
            return lammps_law::granular(rest, &self.units, &|w| self.number(w));
        }
        let (law, rest) = lammps_law::gran(style, rest, &self.units, &|w| self.number(w))?;
        Ok((law, rest, Vec::new()))
    }

    fn wall_of_liggghts(
        &mut self,
        id: &str,
        words: &[String],
        source: &Source,
    ) -> Result<(Outcome, Effect), String> {
        let style = Style::parse(words)?;
        let outcome = but(&style.without);
        let temperature = self.number_behind(words, "temperature")?;
        let times = [self.time, f64::INFINITY];
        if let Some(rest) = Self::behind(words, "meshes") {
            let count = self.number_behind(words, "n_meshes")?.unwrap_or(1.0) as usize;
            let meshes =
                rest.get(..count).ok_or_else(|| format!("{count} meshes are announced, and fewer named"))?;
            if let Some(name) = meshes.iter().find(|name| !self.meshes.contains_key(*name)) {
                return Err(format!("mesh {name} is unknown or was not translated"));
            }
            let wall =
                MeshWall { meshes: meshes.to_vec(), style, times, source: source.clone(), temperature };
            self.mesh_walls.push(wall);
            return Ok((outcome, Effect::MeshWall(self.mesh_walls.len() - 1)));
        }
        let rest = Self::behind(words, "primitive").ok_or("neither primitive nor meshes are given")?;
        let kind = self.number_behind(rest, "type")?.ok_or("the type of the wall is missing")? as usize;
        let at = rest.iter().position(|word| primitive(word).is_some()).ok_or("the primitive is unknown")?;
        let (axis, is_plane) = primitive(&rest[at]).ok_or("the primitive is unknown")?;
        let numbers = &rest[at + 1..];
        let form = if is_plane {
            self.plane(axis, self.length(numbers.first().ok_or("the place of the plane is missing")?)?)
        } else {
            let three = self.units.vector(self.vector(numbers, 0)?, LENGTH);
            // The axes go round: that of y has its coordinates z and x.
            let mut center = [0.0; 3];
            center[(axis + 1) % 3] = three[1];
            center[(axis + 2) % 3] = three[2];
            self.cylinder(axis, three[0], center)
        };
        let walls = vec![(id.to_owned(), form)];
        let keys = numbers.get(if is_plane { 1 } else { 3 }..).unwrap_or_default();
        let motion = self.primitive_motion(keys, axis, is_plane, 1.0, &walls)?;
        let [(name, form)] = <[_; 1]>::try_from(walls).map_err(|_| "one wall is wanted")?;
        let effect = self.add_wall(WallPlan {
            name,
            sources: vec![source.clone()],
            form: WallForm::Kind(form),
            motion,
            times,
            law: WallLaw::Style(kind, style),
            temperature,
        });
        Ok((outcome, effect))
    }

    /// Motion of a primitive by the words `shear` and `wiggle`; `sense` is that of a turning cylinder.
    fn primitive_motion(
        &self,
        words: &[String],
        axis: usize,
        is_plane: bool,
        sense: f64,
        walls: &[(String, WallKind)],
    ) -> Result<Option<Motion>, String> {
        let along = |word: Option<&String>| {
            let along = word.and_then(|w| ["x", "y", "z"].iter().position(|a| a == w));
            along.ok_or_else(|| "the axis of the motion must be x, y or z".to_owned())
        };
        let (start, end) = (self.time, f64::INFINITY);
        if let Some(rest) = Self::behind(words, "shear") {
            let shear = along(rest.first())?;
            let given = self.number(rest.get(1).ok_or("the speed is missing")?)?;
            let speed = self.units.si(given, VELOCITY);
            if is_plane && shear == axis {
                return Err("a plane does not shear along its normal".into());
            }
            if is_plane || shear == axis {
                return Ok(Some(Motion::Translation { velocity: direction(shear, speed), start, end }));
            }
            let Some((_, WallKind::Cylinder { radius, center, .. })) = walls.first() else {
                return Err("only planes and cylinders shear".into());
            };
            // LIGGGHTS gives the angular velocity, LAMMPS the speed of the surface, clockwise.
            let angular_velocity = match sense > 0.0 {
                true => given / self.units.si(1.0, TIME),
                false => -speed / radius,
            };
            let axis = direction(axis, 1.0);
            return Ok(Some(Motion::Rotation { point: Some(*center), axis, angular_velocity, start, end }));
        }
        if let Some(rest) = Self::behind(words, "wiggle") {
            let along = along(rest.first())?;
            let amplitude = self.length(rest.get(1).ok_or("the amplitude is missing")?)?;
            let period = self.units.si(self.number(rest.get(2).ok_or("the period is missing")?)?, TIME);
            // The displacement A (1 − cos ω t) of LAMMPS, which begins at rest.
            return Ok(Some(Motion::Oscillation {
                amplitude: direction(along, amplitude),
                frequency: 1.0 / period,
                phase: -0.25 * TAU,
                start,
                end,
            }));
        }
        Ok(None)
    }

    /// `fix wall/gran/region`.
    pub(crate) fn wall_of_region(
        &mut self,
        id: &str,
        words: &[String],
        source: &Source,
    ) -> Result<(Outcome, Effect), String> {
        let (law, rest, mut without) = self.law_of_wall(words)?;
        let region = match rest {
            [key, name, ..] if key == "region" => self.region(name)?,
            _ => return Err("the region is missing behind the law".into()),
        };
        let form = region.wall()?;
        if region.moves {
            without.push("the motion of the region, which variables give: see wall.motion".into());
        }
        if matches!(
            form,
            WallKind::Box { .. } | WallKind::Cylinder { height: 0.0..f64::INFINITY, caps: true, .. }
        ) {
            let remark = "a closed region is a wall to particles inside alone there, and to all here: insert inside it, or open its faces";
            self.report.remark(format!("{id}: {remark}"));
        }
        let effect = self.add_wall(WallPlan {
            name: id.to_owned(),
            sources: vec![source.clone()],
            form: WallForm::Kind(form),
            motion: None,
            times: [self.time, f64::INFINITY],
            law: WallLaw::Law(law),
            temperature: None,
        });
        Ok((but(&without), effect))
    }

    /// `fix mesh/surface`.
    pub(crate) fn mesh(&mut self, id: &str, style: &str, words: &[String], source: &Source) -> Answer {
        let file = Self::behind(words, "file").and_then(|w| w.first()).ok_or("the file is missing")?;
        let path = self.file(file);
        let is_read =
            path.extension().is_some_and(|e| e.eq_ignore_ascii_case("stl") || e.eq_ignore_ascii_case("obj"));
        if !is_read {
            return Err(format!("{file}: meshes are STL or OBJ files"));
        }
        if !path.is_file() {
            return Err(format!("{}: there is no such file", path.display()));
        }
        let mut placed = PlacedMesh::new(path, self.units.si(1.0, LENGTH));
        let (mut kind, mut temperature, mut without) = (1, None, Vec::new());
        let mut rest = words;
        while let Some((key, values)) = rest.split_first() {
            let number = |k: usize| self.number(values.get(k).map_or("", String::as_str));
            let used = match key.as_str() {
                "file" | "heal" | "precision" | "min_feature_length" | "curvature" | "curvature_tolerant"
                | "verbose" => 1,
                "element_exclusion_list" => 2,
                "type" => {
                    kind = number(0)? as usize;
                    1
                }
                "scale" => {
                    placed.magnify(number(0)?);
                    1
                }
                "move" => {
                    placed.shift(self.units.vector(self.vector(values, 0)?, LENGTH));
                    3
                }
                "rotate" => {
                    let angle = number(5)?.to_radians();
                    placed.turn([0.0; 3], self.vector(values, 1)?, angle);
                    6
                }
                "temperature" => {
                    temperature = Some(number(0)?);
                    1
                }
                "surface_vel" => {
                    without.push("surface_vel: a wall that stays has no velocity of its surface; let it move, or turn rollers of a mesh".to_owned());
                    3
                }
                "surface_ang_vel" => {
                    without.push("surface_ang_vel: turn the wall by move/mesh rotate".to_owned());
                    9
                }
                "wear" => {
                    without.push("wear finnie: wall.wear of a case is Archard's".to_owned());
                    1
                }
                "stress" | "reference_point" => {
                    // Loads on walls are columns of series.csv.
                    if key == "stress" { 1 } else { 3 }
                }
                other => {
                    without.push(other.to_owned());
                    values.len()
                }
            };
            rest = values.get(used..).unwrap_or_default();
        }
        if style.contains("servo") || style.contains("6dof") {
            without.push(format!("{style}: see motion = {{ kind = \"load\" }}"));
        }
        let mesh = Mesh { placed, kind, source: source.clone(), temperature, moves: Vec::new() };
        self.meshes.insert(id.to_owned(), mesh);
        Ok(but(&without))
    }

    /// `fix move/mesh`.
    pub(crate) fn move_mesh(
        &mut self,
        words: &[String],
        source: &Source,
    ) -> Result<(Outcome, Effect), String> {
        let [key, name, style, rest @ ..] = words else { return Err("mesh and style are missing".into()) };
        if key != "mesh" {
            return Err("`mesh` and its name must come first".into());
        }
        let motion = self.motion(style, rest)?;
        let mesh = self
            .meshes
            .get_mut(name)
            .ok_or_else(|| format!("mesh {name} is unknown or was not translated"))?;
        if let Some((last, _)) = mesh.moves.last()
            && last.interval().1 > motion.interval().0
            && !matches!(last, Motion::Table { .. })
        {
            return Err("a wall has one motion at a time: two at once are a table of times".into());
        }
        mesh.moves.push((motion, source.clone()));
        Ok((Outcome::Translated, Effect::Move(name.clone(), mesh.moves.len() - 1)))
    }

    fn motion(&self, style: &str, words: &[String]) -> Result<Motion, String> {
        let (start, end) = (self.time, f64::INFINITY);
        let seconds = |key: &str| {
            let value = self.number_behind(words, key)?.ok_or_else(|| format!("{key} is missing"))?;
            Ok::<_, String>(self.units.si(value, TIME))
        };
        let vector = |key: &str| {
            let behind = Self::behind(words, key).ok_or_else(|| format!("{key} is missing"))?;
            self.vector(behind, 0)
        };
        match style {
            "linear" => {
                let velocity = self.units.vector(self.vector(words, 0)?, VELOCITY);
                Ok(Motion::Translation { velocity, start, end })
            }
            "wiggle" => {
                let amplitude = self.units.vector(vector("amplitude")?, LENGTH);
                Ok(Motion::Oscillation {
                    amplitude,
                    frequency: 1.0 / seconds("period")?,
                    phase: 0.0,
                    start,
                    end,
                })
            }
            "rotate" => {
                let point = Some(self.units.vector(vector("origin")?, LENGTH));
                let angular_velocity = TAU / seconds("period")?;
                Ok(Motion::Rotation { point, axis: vector("axis")?, angular_velocity, start, end })
            }
            "riggle" => {
                let point = self.units.vector(vector("origin")?, LENGTH);
                let amplitude =
                    self.number_behind(words, "amplitude")?.ok_or("amplitude is missing")?.to_radians();
                Ok(swing(point, vector("axis")?, seconds("period")?, amplitude, start))
            }
            other => {
                Err(format!("move/mesh {other} has no counterpart; linear, wiggle, rotate and riggle do"))
            }
        }
    }

    /// Makes walls of meshes, one for each of their motions.
    pub(crate) fn finish_walls(&mut self) {
        for wall in std::mem::take(&mut self.mesh_walls) {
            for name in &wall.meshes {
                let Some(mesh) = self.meshes.get(name).cloned() else { continue };
                self.walls_of_mesh(name, &mesh, &wall);
            }
        }
    }

    fn walls_of_mesh(&mut self, name: &str, mesh: &Mesh, wall: &MeshWall) {
        let mut placed = mesh.placed.clone();
        let mut from = wall.times[0];
        let pieces = mesh.moves.len().max(1);
        for piece in 0..pieces {
            let motion = mesh.moves.get(piece);
            let next = mesh.moves.get(piece + 1).map_or(f64::INFINITY, |(m, _)| m.interval().0);
            let until = next.min(wall.times[1]);
            let mut sources = vec![mesh.source.clone(), wall.source.clone()];
            sources.extend(motion.map(|(_, source)| source.clone()));
            if until > from {
                self.add_wall(WallPlan {
                    name: if piece == 0 { name.to_owned() } else { format!("{name}-{}", piece + 1) },
                    sources,
                    form: WallForm::Mesh(placed.clone()),
                    motion: motion.map(|(motion, _)| motion.clone()),
                    times: [from, until],
                    law: WallLaw::Style(mesh.kind, wall.style.clone()),
                    temperature: wall.temperature.or(mesh.temperature),
                });
                from = until;
            }
            if let Some((motion, _)) = motion {
                displace(&mut placed, motion, next);
            }
        }
    }
}

/// Moves a mesh to where a motion has it at a time (s).
fn displace(mesh: &mut PlacedMesh, motion: &Motion, now: f64) {
    let (start, end) = motion.interval();
    let time = (now.min(end) - start).max(0.0);
    match motion {
        Motion::Translation { velocity, .. } => mesh.shift(velocity.map(|v| v * time)),
        Motion::Oscillation { amplitude, frequency, phase, .. } => {
            let way = (TAU * frequency * time + phase).sin() - phase.sin();
            mesh.shift(amplitude.map(|a| a * way));
        }
        Motion::Rotation { point, axis, angular_velocity, .. } => {
            mesh.turn(point.unwrap_or_default(), *axis, angular_velocity * time);
        }
        Motion::Table { point: Some(point), axis: Some(axis), angles, .. } => {
            mesh.turn(*point, *axis, angles.last().copied().unwrap_or(0.0));
        }
        Motion::Table { .. } | Motion::Load { .. } => {}
    }
}

/// A swing by an amplitude (rad) about an axis: a table of times, as a case has no word for it.
fn swing(point: [f64; 3], axis: [f64; 3], period: f64, amplitude: f64, start: f64) -> Motion {
    /// Rows of a period, and periods.
    const ROWS: usize = 32;
    const PERIODS: usize = 100;
    let rows = 0..=ROWS * PERIODS;
    let share = |row: usize| row as f64 / ROWS as f64;
    Motion::Table {
        path: None,
        times: rows.clone().map(|row| start + period * share(row)).collect(),
        displacements: Vec::new(),
        angles: rows.map(|row| amplitude * (TAU * share(row)).sin()).collect(),
        point: Some(point),
        axis: Some(axis),
        rows: Vec::new(),
    }
}
