//! Commands `pair_style`, `pair_coeff`, `fix` and `unfix`.

use crate::lammps_law;
use crate::liggghts_law::Style;
use crate::report::{Outcome, Source};
use crate::scene::{Laws, WallPlan};
use crate::script::{Answer, Effect, Group, Script};
use crate::units::ACCELERATION;

/// Translated, unless something was left out.
pub(crate) fn but(without: &[String]) -> Outcome {
    match without.is_empty() {
        true => Outcome::Translated,
        false => Outcome::Partly(format!("without {}", without.join(", "))),
    }
}

impl Script {
    pub(crate) fn pair_style(&mut self, words: &[String], source: &Source) -> Answer {
        let (style, rest) = words.split_first().ok_or("the style is missing")?;
        match style.as_str() {
            "gran" => {
                let style = Style::parse(rest)?;
                let outcome = but(&style.without);
                if let Laws::Style(first, _) = &self.scene.laws
                    && *first != style
                {
                    return Err("the law changes during the run; a restart of a case may have another".into());
                }
                self.scene.laws = Laws::Style(style, source.clone());
                Ok(outcome)
            }
            "granular" => {
                self.scene.laws = Laws::Coefficients(Vec::new());
                Ok(Outcome::Translated)
            }
            name if name.starts_with("gran/") => {
                if matches!(self.scene.laws, Laws::Coefficients(_)) && self.step > 0 {
                    return Err("the law changes during the run; a restart of a case may have another".into());
                }
                let (law, _) = lammps_law::gran(name, rest, &self.units, &|w| self.number(w))?;
                let all = [[1, usize::MAX]; 2];
                self.pair_name = Some(name.to_owned());
                self.scene.laws = Laws::Coefficients(vec![(all, law, source.clone())]);
                Ok(Outcome::Translated)
            }
            "hybrid" | "hybrid/overlay" => Err("several styles at once: give the one of contacts".into()),
            other => Err(format!("pair_style {other} is no law of contacts")),
        }
    }

    pub(crate) fn pair_coeff(&mut self, words: &[String], source: &Source) -> Answer {
        let [first, second, rest @ ..] = words else { return Err("two types are missing".into()) };
        if rest.is_empty() {
            return Ok(Outcome::Unneeded("the coefficients are those of the style"));
        }
        let ranges = [range(first)?, range(second)?];
        let (law, _, without) = lammps_law::granular(rest, &self.units, &|w| self.number(w))?;
        match &mut self.scene.laws {
            Laws::Coefficients(laws) => laws.push((ranges, law, source.clone())),
            _ => return Err("it goes with pair_style granular".into()),
        }
        Ok(but(&without))
    }

    pub(crate) fn fix(&mut self, words: &[String], source: &Source) -> Answer {
        let [id, group, style, rest @ ..] = words else {
            return Err("name, group and style are missing".into());
        };
        if self.fixes.contains_key(id) {
            // A fix of the same name takes the place of the first.
            self.unfix(std::slice::from_ref(id))?;
        }
        let (outcome, effect) = self.fix_of_style(id, group, style, rest, source)?;
        self.fixes.insert(id.clone(), effect);
        Ok(outcome)
    }

    fn fix_of_style(
        &mut self,
        id: &str,
        group: &str,
        style: &str,
        rest: &[String],
        source: &Source,
    ) -> Result<(Outcome, Effect), String> {
        let plain = |outcome: Outcome| Ok((outcome, Effect::None));
        let unneeded = |why| Ok((Outcome::Unneeded(why), Effect::None));
        match style {
            "gravity" => self.gravity(rest, source).and_then(plain),
            "property/global" => {
                let numbers = self.numbers(rest.get(2..).unwrap_or_default())?;
                self.properties.set(rest, &numbers)?;
                plain(Outcome::Translated)
            }
            "heat/gran" | "heat/gran/conduction" => self.heat(rest, source).and_then(plain),
            "freeze" => {
                let Group::Types(kinds) = self.group(group)? else {
                    return Err("only groups of types are frozen here".into());
                };
                self.scene.frozen.extend(kinds);
                plain(Outcome::Translated)
            }
            _ if style.starts_with("mesh/surface") => self.mesh(id, style, rest, source).and_then(plain),
            "move/mesh" => self.move_mesh(rest, source),
            "wall/gran" => self.wall(id, rest, source),
            "wall/gran/region" => self.wall_of_region(id, rest, source),
            _ if style.starts_with("particletemplate/") => {
                self.template(id, style, rest, source).and_then(plain)
            }
            _ if style.starts_with("particledistribution/discrete") => {
                self.distribution(id, style, rest).and_then(plain)
            }
            "insert/pack" => self.insert_pack(id, rest, source),
            "insert/rate/region" => self.insert_rate(id, rest, source),
            "insert/stream" => self.insert_stream(id, rest, source),
            "pour" => self.pour(id, rest, source),
            "nve/sphere" | "nve" | "nve/asphere" | "nve/superquadric" | "nve/gran" | "multisphere"
            | "rigid/small" => unneeded("all particles move by the forces on them"),
            "check/timestep/gran" => unneeded("`grains-mpi check` judges the step before the run"),
            "balance" => unneeded("how ranks share the work is chosen by the program"),
            _ if style.starts_with("ave/") || style == "print" || style.starts_with("store/") => {
                Err("means and tables of a run: see `grains-mpi analyse` and [[flow_plane]]".into())
            }
            "massflow/mesh" => {
                Err("flow through a mesh: a [[flow_plane]] counts particles through a plane".into())
            }
            "property/atom" => Err("values of each particle are not carried along".into()),
            "viscous" => {
                Err("a drag on all particles: a case has dashpots of contacts and of fluids alone".into())
            }
            "adapt" => Err("sizes do not change during a run".into()),
            "enforce2d" | "dt/reset" | "momentum" | "setforce" | "addforce" => {
                Err(format!("no word of a case is {style}"))
            }
            _ if style.starts_with("couple/") => {
                Err("coupling to another code: see [fluid] of a case".into())
            }
            _ => Err(format!("no word of a case is fix {style}")),
        }
    }

    fn gravity(&mut self, words: &[String], source: &Source) -> Answer {
        let [size, style, ..] = words else { return Err("size and style are missing".into()) };
        let size = self.units.si(self.number(size)?, ACCELERATION);
        let direction = match style.as_str() {
            "vector" => {
                let v = self.vector(words, 2)?;
                let length = v.iter().map(|x| x * x).sum::<f64>().sqrt();
                if length == 0.0 {
                    return Err("the direction is none".into());
                }
                v.map(|x| x / length)
            }
            "chute" => {
                let angle = self.number(words.get(2).ok_or("the angle is missing")?)?.to_radians();
                [angle.sin(), 0.0, -angle.cos()]
            }
            "spherical" => {
                let [phi, theta] = [2, 3].map(|k| self.number(words.get(k).map_or("", String::as_str)));
                let (phi, theta) = (phi?.to_radians(), theta?.to_radians());
                [theta.sin() * phi.cos(), theta.sin() * phi.sin(), theta.cos()]
            }
            other => return Err(format!("gravity of style {other} has no counterpart")),
        };
        // Cosines of right angles are zero.
        let gravity = direction.map(|x| if x.abs() < 1e-15 { 0.0 } else { size * x });
        match &self.scene.gravity {
            Some((first, _)) if *first != gravity && self.step > 0 => Err(
                "gravity changes during the run: end the case here, and restart one with the other gravity"
                    .into(),
            ),
            _ => {
                self.scene.gravity = Some((gravity, source.clone()));
                Ok(Outcome::Translated)
            }
        }
    }

    fn heat(&mut self, words: &[String], source: &Source) -> Answer {
        let initial = self.number_behind(words, "initial_temperature")?;
        let temperature = initial.ok_or("initial_temperature is missing")?;
        if self.units.name != "si" {
            return Err("heat is read in units si alone".into());
        }
        self.scene.heat = Some((temperature, source.clone()));
        self.report.remark("heat: LIGGGHTS has Q = 4 k1 k2/(k1 + k2) √A ΔT with the area A in which the spheres intersect, here Q = 4 k1 k2/(k1 + k2) a ΔT with the contact radius a (Batchelor and O'Brien 1977): √(2π) = 2.5 times less, as A is 2π a² for Hertzian contacts");
        Ok(Outcome::Translated)
    }

    pub(crate) fn unfix(&mut self, words: &[String]) -> Answer {
        let id = words.first().ok_or("the name is missing")?;
        let now = self.time;
        match self.fixes.remove(id) {
            Some(Effect::Wall(index)) => self.scene.walls[index].times[1] = now,
            Some(Effect::MeshWall(index)) => self.mesh_walls[index].times[1] = now,
            Some(Effect::Insert(index)) => self.scene.inserts[index].until = Some(now),
            Some(Effect::Move(mesh, index)) => {
                if let Some((motion, _)) = self.meshes.get_mut(&mesh).and_then(|m| m.moves.get_mut(index)) {
                    crate::walls::end_motion(motion, now);
                }
            }
            Some(Effect::None) => return Ok(Outcome::Unneeded("what it ends needs no word, or lasts")),
            None => return Ok(Outcome::Unneeded("it ends what was not translated")),
        }
        Ok(Outcome::Translated)
    }

    /// Adds a wall to the scene.
    pub(crate) fn add_wall(&mut self, wall: WallPlan) -> Effect {
        self.scene.walls.push(wall);
        Effect::Wall(self.scene.walls.len() - 1)
    }
}

/// Types of a word such as `2`, `*`, `1*3` or `2*`.
fn range(word: &str) -> Result<[usize; 2], String> {
    let number = |text: &str, usual: usize| match text {
        "" => Ok(usual),
        text => text.parse().map_err(|_| format!("`{word}` is no range of types")),
    };
    match word.split_once('*') {
        Some((low, high)) => Ok([number(low, 1)?, number(high, usize::MAX)?]),
        None => number(word, 1).map(|kind| [kind; 2]),
    }
}
