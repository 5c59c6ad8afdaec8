//! From what a script set up to a case.

mod contacts;
mod particles;
mod walls;

use crate::case_text::Section;
use crate::laws::shown;
use crate::liggghts_law::Properties;
use crate::meshes::PlacedMesh;
use crate::particles::{Names, Particle};
use crate::report::Report;
use crate::scene::{Scene, WallLaw};
use crate::units::{PRESSURE, Units};
use grains_case::sections::time::RawTime;
use grains_case::{Domain, Exchange, Face, Material, TimeStep};
use std::path::PathBuf;
use toml::Table;
use walls::closes;

/// How a case begins that was imported.
const HEAD: &str = "# Written by grains-mpi import; import.txt says what became of each command.\n# Comments name the commands that sections come from.\n";

/// A case, and the files that it names.
pub(crate) struct Draft {
    /// Its text.
    pub(crate) text: String,
    /// Meshes by their paths in the folder of the case.
    pub(crate) meshes: Vec<(PathBuf, PlacedMesh)>,
    /// Tables of particles by their paths in the folder of the case, with names of forms and materials.
    pub(crate) tables: Vec<(PathBuf, Vec<Particle>)>,
    /// Those names.
    pub(crate) names: Names,
}

/// What makes a case of a scene.
pub(crate) struct Assembly<'a> {
    pub(crate) name: &'a str,
    pub(crate) scene: &'a Scene,
    pub(crate) properties: &'a Properties,
    pub(crate) units: &'a Units,
    pub(crate) report: &'a mut Report,
}

impl Assembly<'_> {
    /// The case.
    ///
    /// # Errors
    /// A scene without box, particles or laws.
    pub(crate) fn draft(&mut self) -> Result<Draft, String> {
        let Some((corners, source)) = self.scene.corners.clone() else {
            return Err("the script has no box: neither create_box nor read_data was read".into());
        };
        let grains = self.grains()?;
        let mut sections = vec![
            self.head()?,
            self.domain(corners)?.from([&source]),
            self.time()?,
            self.output()?,
            self.limits()?,
        ];
        sections.extend(self.heat()?);
        let walls = self.wall_materials();
        let mut contacts = Vec::new();
        let elastic = self.contacts(&grains, &walls, &mut contacts)?;
        for grain in &grains {
            let material = self.material(&grain.name, grain.kind, Some(grain.density), &elastic);
            sections.push(Section::new("[[material]]", &material)?.from(&grain.sources));
        }
        for (law, name) in &walls {
            let kind = if let WallLaw::Style(kind, _) = law { *kind } else { 0 };
            sections.push(Section::new("[[material]]", &self.material(name, kind, None, &elastic))?);
        }
        sections.append(&mut contacts);
        let names = self.names(&grains);
        self.shapes(&names, &mut sections)?;
        let tables = self.inserts(&grains, &names, &mut sections)?;
        let meshes = self.walls(&walls, &mut sections)?;
        let mut text = String::from(HEAD);
        sections.iter().filter(|s| !s.is_empty()).for_each(|section| text.push_str(&section.text()));
        Ok(Draft { text, meshes, tables, names })
    }

    /// The time at which the case ends (s).
    pub(super) fn end(&self) -> f64 {
        let end = self.scene.end();
        if end > 0.0 { end } else { 1.0 }
    }

    fn head(&self) -> Result<Section, String> {
        let gravity = self.scene.gravity.as_ref().map_or([0.0; 3], |(gravity, _)| *gravity);
        let head = Section::new("", &Table::new())?
            .with("name", Some(self.name))
            .with("gravity", Some(gravity.to_vec()));
        Ok(head.from(self.scene.gravity.iter().map(|(_, source)| source)))
    }

    fn domain(&mut self, [mut lower, mut upper]: [[f64; 3]; 2]) -> Result<Section, String> {
        let periodic = self.scene.periodic();
        for particle in &self.scene.start {
            let reach = particle.radius.unwrap_or(0.0);
            for axis in 0..3 {
                // Faces that follow the particles.
                let [below, above] = self.scene.boundary[axis].map(|c| matches!(c, 's' | 'm'));
                if below {
                    lower[axis] = lower[axis].min(particle.position[axis] - reach);
                }
                if above {
                    upper[axis] = upper[axis].max(particle.position[axis] + reach);
                }
            }
        }
        let is_open = |face: &Face| {
            let walls = self.scene.walls.iter();
            !periodic[face.axis()] && !walls.into_iter().any(|wall| closes(wall, *face, [lower, upper]))
        };
        let outlets: Vec<Face> = match self.scene.loses {
            true => Face::ALL.into_iter().filter(is_open).collect(),
            false => Vec::new(),
        };
        if !outlets.is_empty() {
            self.report.remark("thermo_modify lost ignore: particles may leave through the faces that no wall closes (domain.outlets)");
        }
        let domain = Domain {
            lower,
            upper,
            periodic,
            shear: None,
            outlets: outlets.clone(),
            ranks: None,
            balance: true,
            exchange: Exchange::default(),
        };
        let mut table = Table::try_from(&domain).map_err(|e| e.to_string())?;
        table.retain(|key, _| !matches!(key, "balance" | "exchange"));
        if outlets.is_empty() {
            table.remove("outlets");
        }
        if periodic == [false; 3] {
            table.remove("periodic");
        }
        Section::new("[domain]", &table)
    }

    fn time(&mut self) -> Result<Section, String> {
        if self.scene.end() <= 0.0 {
            self.report.remark("the script runs no step: the case ends after 1 s");
        }
        let end = self.end();
        let steps = self.scene.runs.iter().filter(|(steps, _)| *steps > 0).map(|(_, dt)| *dt);
        let min = steps.clone().fold(f64::INFINITY, f64::min);
        if steps.clone().any(|dt| dt != min) {
            self.report.remark(format!(
                "the timestep changes during the script: {} s, the smallest, holds all the time here",
                shown(min)
            ));
        }
        let time = RawTime {
            end,
            dt: if min.is_finite() { TimeStep::Seconds(min) } else { TimeStep::Auto },
            steps_per_contact: 20.0,
            accept_coarse_dt: false,
            impact_speed: None,
        };
        Section::new("[time]", &time)
    }

    fn output(&self) -> Result<Section, String> {
        let [particles, series, checkpoint] =
            self.scene.intervals.map(|i| i.filter(|i| *i > 0.0).map(|i| i.min(self.end())));
        let directory = format!("results/{}", self.name);
        Ok(Section::new("[output]", &Table::new())?
            .with("directory", Some(directory))
            .with("particles", particles)
            .with("series", series)
            .with("checkpoint", checkpoint))
    }

    fn limits(&mut self) -> Result<Section, String> {
        self.report.remark(
            "limits.overlap is 0.5 of the radius here, as other codes have no limit; 0.2 without a word",
        );
        Ok(Section::new("[limits]", &Table::new())?.with("overlap", Some(0.5)))
    }

    fn heat(&self) -> Result<Option<Section>, String> {
        let Some((temperature, source)) = &self.scene.heat else { return Ok(None) };
        let section = Section::new("[heat]", &Table::new())?.with("temperature", Some(*temperature));
        Ok(Some(section.from([source])))
    }

    /// A material; `elastic` names those whose elastic constants some contact takes.
    fn material(&self, name: &str, kind: usize, density: Option<f64>, elastic: &[String]) -> Material {
        let is_elastic = elastic.iter().any(|other| other == name);
        let of = |property: &str| self.properties.of_type(property, kind).ok();
        let has_heat = self.scene.heat.is_some();
        Material {
            name: name.to_owned(),
            density,
            youngs_modulus: of("youngsModulus").filter(|_| is_elastic).map(|e| self.units.si(e, PRESSURE)),
            poissons_ratio: of("poissonsRatio").filter(|_| is_elastic),
            surface_energy: None,
            heat_capacity: of("thermalCapacity").filter(|_| has_heat && density.is_some()),
            conductivity: of("thermalConductivity").filter(|_| has_heat),
            emissivity: None,
            heat_source: None,
            film: None,
        }
    }
}
