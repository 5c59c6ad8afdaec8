//! Scripts of LAMMPS and LIGGGHTS, command by command.

use crate::data_file::AtomStyle;
use crate::error::ImportError;
use crate::liggghts_law::{Properties, Style};
use crate::lines;
use crate::meshes::PlacedMesh;
use crate::regions::Region;
use crate::report::{Outcome, Report, Source};
use crate::scene::{Scene, Template};
use crate::units::{LENGTH, Units};
use crate::variables::Variables;
use grains_case::Motion;
use std::collections::BTreeMap;
use std::fs;
use std::path::{Path, PathBuf};

/// What a command comes to, or why it is not translated.
pub(crate) type Answer = Result<Outcome, String>;

/// A mesh of a script, the type of its material, and its motions one after the other.
#[derive(Clone, Debug)]
pub(crate) struct Mesh {
    pub(crate) placed: PlacedMesh,
    pub(crate) kind: usize,
    pub(crate) source: Source,
    pub(crate) temperature: Option<f64>,
    pub(crate) moves: Vec<(Motion, Source)>,
}

/// Walls that are meshes: a fix, its meshes, its style, and times (s).
#[derive(Clone, Debug)]
pub(crate) struct MeshWall {
    pub(crate) meshes: Vec<String>,
    pub(crate) style: Style,
    pub(crate) times: [f64; 2],
    pub(crate) source: Source,
    pub(crate) temperature: Option<f64>,
}

/// What a fix has set up, which `unfix` ends.
#[derive(Clone, Debug)]
pub(crate) enum Effect {
    /// A wall of the scene.
    Wall(usize),
    /// Walls that are meshes.
    MeshWall(usize),
    /// A motion of a mesh.
    Move(String, usize),
    /// An insertion.
    Insert(usize),
    /// Nothing that lasts only until then.
    None,
}

/// Which particles a group has.
#[derive(Clone, Debug, PartialEq, Eq)]
pub(crate) enum Group {
    /// All.
    All,
    /// Those of some types.
    Types(Vec<usize>),
    /// Those of some numbers.
    Ids(Vec<u64>),
}

/// A script as far as it has been read.
pub struct Script {
    /// What it has set up.
    pub scene: Scene,
    /// What became of its commands.
    pub report: Report,
    /// Properties of its types.
    pub properties: Properties,
    /// Its units.
    pub units: Units,
    pub(crate) variables: Variables,
    pub(crate) folder: PathBuf,
    pub(crate) step: u64,
    pub(crate) time: f64,
    /// Length of a step (s).
    pub(crate) dt: Option<f64>,
    pub(crate) style: Option<AtomStyle>,
    pub(crate) types: usize,
    pub(crate) regions: BTreeMap<String, Region>,
    pub(crate) meshes: BTreeMap<String, Mesh>,
    pub(crate) mesh_walls: Vec<MeshWall>,
    pub(crate) templates: BTreeMap<String, Template>,
    /// Distributions: templates and their shares by number.
    pub(crate) distributions: BTreeMap<String, Vec<(Template, f64)>>,
    pub(crate) fixes: BTreeMap<String, Effect>,
    pub(crate) groups: BTreeMap<String, Group>,
    /// Style of `pair_style gran/…`, which walls of early versions have too.
    pub(crate) pair_name: Option<String>,
    /// Steps between rows of the series.
    pub(crate) series_steps: Option<f64>,
    /// Names of variables that the user gives and no script has named so far.
    unused: Vec<String>,
    /// Whether it says its units.
    has_units: bool,
    depth: usize,
}

impl Script {
    /// A script that has not been read, with values of variables that the user gives.
    pub fn new(given: &[(String, String)]) -> Self {
        let mut variables = Variables::default();
        given.iter().for_each(|(name, value)| variables.give(name, value));
        Self {
            scene: Scene { boundary: [['p'; 2]; 3], ..Scene::default() },
            report: Report::default(),
            properties: Properties::default(),
            units: Units::default(),
            variables,
            folder: PathBuf::new(),
            step: 0,
            time: 0.0,
            dt: None,
            style: None,
            types: 1,
            regions: BTreeMap::new(),
            meshes: BTreeMap::new(),
            mesh_walls: Vec::new(),
            templates: BTreeMap::new(),
            distributions: BTreeMap::new(),
            fixes: BTreeMap::new(),
            groups: BTreeMap::from([("all".to_owned(), Group::All)]),
            pair_name: None,
            series_steps: None,
            unused: given.iter().map(|(name, _)| name.clone()).collect(),
            has_units: false,
            depth: 0,
        }
    }

    /// Reads a script; files in it are relative to its folder.
    ///
    /// # Errors
    /// A script, or data that it needs, that cannot be read.
    pub fn read(&mut self, path: &Path) -> Result<(), ImportError> {
        self.folder = path.parent().map(Path::to_path_buf).unwrap_or_default();
        self.read_commands(path)?;
        self.finish_walls();
        if let (Some(steps), Some((_, dt))) = (self.series_steps, self.scene.runs.first()) {
            self.scene.intervals[1] = Some(steps * dt);
        }
        Ok(())
    }

    /// Looks at scripts that have been read: whether they are any, and what was given in vain.
    ///
    /// # Errors
    /// A file none of whose commands is known.
    pub fn check(&mut self, path: &Path) -> Result<(), ImportError> {
        let is_known = |(_, outcome): &(Source, Outcome)| !matches!(outcome, Outcome::Untranslated(_));
        let commands = &self.report.commands;
        if let Some((source, _)) = commands.first().filter(|_| !commands.iter().any(is_known)) {
            let message = format!(
                "`{}` is no command of LAMMPS or LIGGGHTS, and none of the {} others is one that is translated: give a script, a data file or a text dump",
                source.text.chars().take(40).collect::<String>(),
                commands.len() - 1
            );
            return Err(ImportError::at(path, source.line, message));
        }
        for name in &self.unused {
            self.report.remark(format!(
                "--var {name}: without effect, as the script names no such variable; check its spelling"
            ));
        }
        if !self.has_units {
            self.report.remark("the script has no `units`: its numbers were taken for SI units; add `units si`, or cgs, micro, nano or lj");
        }
        Ok(())
    }

    pub(crate) fn read_commands(&mut self, path: &Path) -> Result<(), ImportError> {
        let bytes = fs::read(path).map_err(ImportError::read(path))?;
        let text = String::from_utf8_lossy(&bytes);
        let text = text.trim_start_matches('\u{feff}');
        self.unused.retain(|name| !text.contains(name.as_str()));
        self.depth += 1;
        if self.depth > 20 {
            return Err(ImportError::Case(format!("{}: scripts include each other", path.display())));
        }
        for (line, text) in lines::commands(text) {
            let source = Source { file: path.display().to_string(), line, text: text.clone() };
            let outcome = match self.words(&text) {
                Ok(words) => self.command(&words, &source)?.unwrap_or_else(Outcome::Untranslated),
                Err(why) => Outcome::Untranslated(why),
            };
            self.report.commands.push((source, outcome));
        }
        self.depth -= 1;
        Ok(())
    }

    /// Words of a command with the values of variables; formulas of variables stay as they are.
    fn words(&mut self, text: &str) -> Result<Vec<String>, String> {
        self.variables.clock = (self.step, self.dt.map(|dt| dt / self.units.si(1.0, crate::units::TIME)));
        // What these say is read later, or not at all.
        const LATE: [&str; 8] =
            ["variable", "if", "print", "log", "shell", "thermo_style", "compute", "dump_modify"];
        if text.split(' ').next().is_some_and(|name| LATE.contains(&name)) {
            return Ok(lines::words(text));
        }
        Ok(lines::words(&self.variables.substitute(text)?))
    }

    /// A number of a command.
    pub(crate) fn number(&self, word: &str) -> Result<f64, String> {
        self.variables.value(word)
    }

    /// A length (m) of a command.
    pub(crate) fn length(&self, word: &str) -> Result<f64, String> {
        Ok(self.units.si(self.number(word)?, LENGTH))
    }

    /// Numbers of a command.
    pub(crate) fn numbers(&self, words: &[String]) -> Result<Vec<f64>, String> {
        words.iter().map(|word| self.number(word)).collect()
    }

    /// Three numbers from a place of a command on.
    pub(crate) fn vector(&self, words: &[String], at: usize) -> Result<[f64; 3], String> {
        let three = words.get(at..at + 3).ok_or("three numbers are wanted")?;
        Ok([self.number(&three[0])?, self.number(&three[1])?, self.number(&three[2])?])
    }

    /// The words behind a key, if it is there.
    pub(crate) fn behind<'a>(words: &'a [String], key: &str) -> Option<&'a [String]> {
        words.iter().position(|word| word == key).map(|at| &words[at + 1..])
    }

    /// The number behind a key, if it is there.
    pub(crate) fn number_behind(&self, words: &[String], key: &str) -> Result<Option<f64>, String> {
        let Some(rest) = Self::behind(words, key) else { return Ok(None) };
        let word = rest.first().ok_or_else(|| format!("the number behind {key} is missing"))?;
        self.number(word).map(Some)
    }

    /// A file that a command names.
    pub(crate) fn file(&self, name: &str) -> PathBuf {
        self.folder.join(name)
    }

    /// The length of a step (s).
    pub(crate) fn step_length(&self) -> Result<f64, String> {
        self.dt
            .ok_or_else(|| "it needs the timestep, which is set later; move `timestep` before it".to_owned())
    }

    fn command(&mut self, words: &[String], source: &Source) -> Result<Answer, ImportError> {
        let Some((name, rest)) = words.split_first() else { return Ok(Ok(Outcome::Unneeded("nothing"))) };
        let unneeded = |why: &'static str| Ok(Outcome::Unneeded(why));
        Ok(match name.as_str() {
            "include" => {
                let Some(file) = rest.first() else { return Ok(Err("the file is missing".into())) };
                // Paths of LAMMPS are relative to where it runs, which is here the folder of the script.
                let path = self.file(file);
                self.read_commands(&path)?;
                Ok(Outcome::Translated)
            }
            "read_data" => return self.read_data(rest, source),
            "variable" => self.variables.define(rest).map(|()| Outcome::Translated),
            "units" => {
                self.has_units = true;
                // Numbers of other units would make another case.
                let line = |why| ImportError::at(Path::new(&source.file), source.line, why);
                Ok(self.set_units(rest).map_err(line)?)
            }
            "boundary" => self.set_boundary(rest),
            "change_box" => match Self::behind(rest, "boundary") {
                Some(faces) => self.set_boundary(faces),
                None => Err("a box does not change during a run".into()),
            },
            "dimension" if rest.first().is_some_and(|d| d == "3") => unneeded("a domain has three dimensions"),
            "dimension" => Err("discs: a case has spheres, in three dimensions".into()),
            "atom_style" => self.set_atom_style(rest),
            "region" => self.define_region(rest),
            "create_box" => self.create_box(rest, source),
            "create_atoms" => self.create_atoms(rest, source),
            "set" => self.set_particles(rest),
            "velocity" => self.set_velocity(rest),
            "group" => self.define_group(rest),
            "timestep" => self.set_timestep(rest),
            "run" => self.run(rest),
            "reset_timestep" => {
                self.step = rest.first().and_then(|w| self.number(w).ok()).unwrap_or(0.0) as u64;
                unneeded("time of a case begins at 0")
            }
            "pair_style" => self.pair_style(rest, source),
            "pair_coeff" => self.pair_coeff(rest, source),
            "fix" => self.fix(rest, source),
            "unfix" => self.unfix(rest),
            "dump" => self.dump(rest),
            "thermo" => self.thermo(rest),
            "thermo_modify" => {
                let lost = Self::behind(rest, "lost").and_then(|w| w.first());
                self.scene.loses |= lost.is_some_and(|word| word != "error");
                if lost.is_some() { Ok(Outcome::Translated) } else { unneeded("series.csv has its own columns") }
            }
            "restart" => self.restart(rest),
            "read_restart" => Err("a binary restart: write the state with `write_data` or `dump custom` there and give that file".into()),
            "write_restart" | "write_data" => unneeded("the last checkpoint of a run is written by itself"),
            "mass" | "dielectric" => Err("masses of types: granular particles have densities".into()),
            "if" | "jump" | "next" | "label" => Err("conditions and loops are not followed: give a script of the one way that is meant".into()),
            "compute" | "compute_modify" | "thermo_style" | "uncompute" | "dump_modify" | "undump" => {
                unneeded("what is written is columns of series.csv and fields of particles.vtkhdf")
            }
            "write_dump" => unneeded("snapshots have all particles"),
            "neighbor" | "neigh_modify" => unneeded("lists of neighbours choose their skin by themselves"),
            "processors" | "communicate" | "comm_modify" | "comm_style" | "newton" | "atom_modify" | "package"
            | "suffix" | "balance" | "partition" => unneeded("how ranks share the work is chosen by the program"),
            "echo" | "log" | "print" | "shell" | "info" | "timer" | "clear" | "quit" => {
                unneeded("a case says nothing to the screen")
            }
            "soft_particles" | "hard_particles" | "modify_timing" => unneeded("limits of that code's own"),
            "pair_modify" | "kspace_style" | "special_bonds" => unneeded("of no use to contacts"),
            "atom_type" | "lattice" => Err("no lattice is filled: give the particles in a data file".into()),
            "delete_atoms" => Err("particles are not removed at a time: let them leave through an outlet".into()),
            "bond_style" | "bond_coeff" | "create_bonds" => Err("bonds: see [[bond]] of a case".into()),
            other => Err(format!("no command of a case is {other}")),
        })
    }
}
