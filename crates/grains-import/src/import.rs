//! From files to a folder with a case.

use crate::assemble::{Assembly, Draft};
use crate::data_file;
use crate::dump_file::{Frame, Frames, unit_error};
use crate::error::ImportError;
use crate::particles::{Particle, write_csv};
use crate::report::{Report, Source};
use crate::scene::Scene;
use crate::script::Script;
use crate::units::Units;
use crate::vtk::{write_pvd, write_vtp};
use flate2::read::MultiGzDecoder;
use grains_case::{Case, ParticleColumns, Place};
use std::collections::BTreeMap;
use std::fs::{self, File};
use std::io::{BufRead, BufReader, BufWriter, Read, Write};
use std::path::{Path, PathBuf};

/// How to import.
#[derive(Clone, Debug, Default)]
pub struct Options {
    /// Values of variables of the script.
    pub variables: Vec<(String, String)>,
    /// Step of the frame of a dump that becomes the particles; the last one if absent.
    pub step: Option<u64>,
    /// Units of dumps and data that come without a script; si if absent.
    pub units: Option<String>,
}

/// What was written.
#[derive(Clone, Debug, Default)]
pub struct Imported {
    /// What became of the script, if there was one.
    pub report: Report,
    /// The case, if there was a script.
    pub case: Option<PathBuf>,
    /// Warnings of the case, each with file and line.
    pub warnings: Vec<String>,
    /// Number of particles in the table, if there is one.
    pub particles: Option<usize>,
    /// Number of frames written for ParaView.
    pub frames: usize,
    /// The files written, the case first.
    pub files: Vec<PathBuf>,
}

/// What a file holds.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
enum Kind {
    Script,
    Data,
    Dump,
}

/// Reads scripts, data files and dumps, and writes to the folder `to` what a case needs.
///
/// A script becomes `case.toml`, its particles `particles.csv`, its meshes `meshes/`, and `import.txt` says what became of each
/// command. A dump beside a script replaces the particles. Without a script data and dumps become `particles.csv`; dumps also
/// `frames.csv` and a series for ParaView.
///
/// # Errors
/// Files that cannot be read or written, are not what they should be, or make no case.
pub fn import(files: &[PathBuf], to: &Path, options: &Options) -> Result<Imported, ImportError> {
    let kinds = files.iter().map(|file| kind(file)).collect::<Result<Vec<_>, _>>()?;
    let of =
        |wanted: Kind| files.iter().zip(&kinds).filter(move |(_, k)| **k == wanted).map(|(file, _)| file);
    let scripts: Vec<&PathBuf> = of(Kind::Script).collect();
    if to.is_file() {
        let message = format!("--to {}: is a file; name a folder, which may be new", to.display());
        return Err(ImportError::Case(message));
    }
    fs::create_dir_all(to).map_err(ImportError::write(to))?;
    let mut folder = Folder { to, written: Imported::default() };
    let Some(first) = scripts.first() else {
        return without_script((of(Kind::Data).collect(), of(Kind::Dump).collect()), folder, options);
    };
    let mut script = Script::new(&options.variables);
    for path in &scripts {
        script.read(path)?;
    }
    script.check(first)?;
    if let Some(dump) = of(Kind::Dump).next_back() {
        let units = script.units;
        let frames = Frames::new(open(dump)?, dump, units);
        let (particles, _) = chosen(frames, dump, options)?;
        replace(&mut script.scene, particles, dump);
    }
    for data in of(Kind::Data) {
        let read = data_file::read(open(data)?, data, None, &script.units)?;
        replace(&mut script.scene, read.particles, data);
    }
    let name = first.file_stem().unwrap_or_default().to_string_lossy().trim_start_matches("in.").to_owned();
    // `in.hopper` has the stem `in`.
    let name = match (name.as_str(), first.extension()) {
        ("in", Some(extension)) => extension.to_string_lossy().into_owned(),
        _ => name,
    };
    folder.written.report = script.report;
    let mut report = folder.written.report.clone();
    let draft = Assembly {
        name: &name,
        scene: &script.scene,
        properties: &script.properties,
        units: &script.units,
        report: &mut report,
    }
    .draft();
    folder.written.report = report;
    match draft {
        Ok(draft) => folder.case(draft)?,
        Err(why) => {
            folder.report()?;
            let import = to.join("import.txt");
            return Err(ImportError::Case(format!(
                "no case: {why}; {} says what became of each command",
                import.display()
            )));
        }
    }
    Ok(folder.written)
}

/// The particles that a file has take the place of those of the script.
fn replace(scene: &mut Scene, particles: Vec<Particle>, path: &Path) {
    let known: BTreeMap<u64, Particle> =
        std::mem::take(&mut scene.start).into_iter().map(|particle| (particle.id, particle)).collect();
    scene.start = particles;
    for particle in &mut scene.start {
        // A dump may leave out what the data of the script have.
        if let Some(same) = known.get(&particle.id) {
            particle.density = particle.density.or(same.density);
            particle.radius = particle.radius.or(same.radius);
            particle.shape = particle.shape.or(same.shape);
        }
    }
    // Templates of one density per type say what a dump does not.
    for particle in scene.start.iter_mut().filter(|p| p.density.is_none()) {
        let templates = scene.inserts.iter().flat_map(|insert| &insert.mixture);
        let mut densities: Vec<f64> =
            templates.filter(|(t, _)| t.kind == particle.kind).map(|(t, _)| t.density).collect();
        densities.dedup();
        if let [density] = densities[..] {
            particle.density = Some(density);
        }
    }
    // Insertions of before are done.
    scene.inserts.clear();
    scene.start_source = Some(Source { file: path.display().to_string(), line: 1, text: "particles".into() });
}

/// What is in a file, by its first lines.
fn kind(path: &Path) -> Result<Kind, ImportError> {
    let mut head = Vec::new();
    let file = open(path)?;
    file.take(4096).read_to_end(&mut head).map_err(ImportError::read(path))?;
    if let Some(problem) = foreign(&head) {
        return Err(ImportError::at(path, 1, problem));
    }
    let head = String::from_utf8_lossy(&head);
    let head = head.trim_start_matches('\u{feff}');
    if head.trim_start().starts_with("ITEM:") {
        return Ok(Kind::Dump);
    }
    let is_number = |word: &str| word.parse::<f64>().is_ok();
    let is_header = |line: &str| match line.split_whitespace().collect::<Vec<_>>()[..] {
        [count, "atoms"] => is_number(count),
        [lower, upper, "xlo", "xhi"] => is_number(lower) && is_number(upper),
        _ => false,
    };
    Ok(if head.lines().any(is_header) { Kind::Data } else { Kind::Script })
}

/// What the beginning of a file is that holds neither script nor particles, and what to do.
fn foreign(head: &[u8]) -> Option<String> {
    if let Some(problem) = grains_case::no_text(head) {
        return Some(problem.into());
    }
    if head.contains(&0) {
        return Some("a binary file, as restarts are: write the state there with `write_data` or `dump custom`, and give that file".into());
    }
    let text = String::from_utf8_lossy(head);
    if let Some(problem) = grains_case::oddity(&text) {
        return Some(problem.into());
    }
    let mut lines = text.lines().map(str::trim).filter(|line| !line.is_empty() && !line.starts_with('#'));
    let Some(first) = lines.next() else {
        return Some("the file is empty; give a script, a data file or a text dump".into());
    };
    let kind = if first.starts_with("solid") {
        "a mesh (STL)"
    } else if first.starts_with('[')
        || first.contains(" = ") && !first.contains('$') && !first.starts_with("variable")
    {
        "a case or another file in TOML"
    } else if first.split(',').count() > 2 && !first.contains(' ') {
        "a table (CSV)"
    } else {
        return None;
    };
    Some(format!("{kind}, and no script, data file or text dump of LAMMPS or LIGGGHTS; give one of these"))
}

/// A file, unpacked if its name ends in `.gz`.
fn open(path: &Path) -> Result<Box<dyn BufRead>, ImportError> {
    let file = File::open(path).map_err(ImportError::read(path))?;
    Ok(match path.extension().is_some_and(|e| e == "gz") {
        true => Box::new(BufReader::new(MultiGzDecoder::new(file))),
        false => Box::new(BufReader::new(file)),
    })
}

/// The particles of the frame that is asked for, and its step.
fn chosen<R: BufRead>(
    mut frames: Frames<R>,
    path: &Path,
    options: &Options,
) -> Result<(Vec<Particle>, u64), ImportError> {
    let mut found: Option<Frame> = None;
    while let Some(frame) = frames.next().transpose()? {
        if options.step.is_none_or(|step| step == frame.step) {
            found = Some(frame);
        }
    }
    let Some(frame) = found else { return Err(no_frame(path, options)) };
    let particles = frame.particles(&frames.units()).map_err(|e| ImportError::at(path, 1, e))?;
    Ok((particles, frame.step))
}

fn no_frame(path: &Path, options: &Options) -> ImportError {
    let path = path.display();
    ImportError::Case(match options.step {
        Some(step) => format!("{path}: no frame of step {step}; leave --step out for the last one"),
        None => format!("{path}: there is no frame"),
    })
}

fn without_script(
    (data, dumps): (Vec<&PathBuf>, Vec<&PathBuf>),
    mut folder: Folder,
    options: &Options,
) -> Result<Imported, ImportError> {
    let name = options.units.as_deref().unwrap_or("si");
    let units =
        Units::named(name).ok_or_else(|| ImportError::Case(format!("--units: {}", unit_error(name))))?;
    let mut particles = None;
    for path in data {
        particles = Some(data_file::read(open(path)?, path, None, &units)?.particles);
    }
    if !dumps.is_empty() {
        particles = Some(folder.dumps(&dumps, units, options)?);
    }
    if let Some(particles) = particles {
        if particles.iter().any(|particle| particle.radius.is_none() && particle.shape.is_none()) {
            folder.written.warnings.push("the particles have no sizes: they will get those of the shape that a case gives them; dump the column radius as well".into());
        }
        folder.table("particles.csv", &particles, None)?;
    }
    Ok(folder.written)
}

/// The folder that is written to.
struct Folder<'a> {
    to: &'a Path,
    written: Imported,
}

impl Folder<'_> {
    /// Writes a file and notes it.
    fn write(
        &mut self,
        name: &str,
        content: impl FnOnce(&mut BufWriter<File>) -> std::io::Result<()>,
    ) -> Result<PathBuf, ImportError> {
        let path = self.to.join(name);
        let file = File::create(&path).map_err(ImportError::write(&path))?;
        let mut out = BufWriter::new(file);
        content(&mut out).and_then(|()| out.flush()).map_err(ImportError::write(&path))?;
        self.written.files.push(path.clone());
        Ok(path)
    }

    fn table(
        &mut self,
        name: &str,
        particles: &[Particle],
        names: Option<&crate::particles::Names>,
    ) -> Result<(), ImportError> {
        self.write(name, |out| write_csv(out, particles, names))?;
        *self.written.particles.get_or_insert(0) += particles.len();
        Ok(())
    }

    /// Writes all frames of dumps for ParaView and as one table; returns the particles of the one that is asked for.
    fn dumps(
        &mut self,
        dumps: &[&PathBuf],
        units: Units,
        options: &Options,
    ) -> Result<Vec<Particle>, ImportError> {
        let path = self.to.join("frames.csv");
        let mut table = BufWriter::new(File::create(&path).map_err(ImportError::write(&path))?);
        let (mut series, mut columns, mut kept) = (Vec::new(), None, None);
        for dump in dumps {
            let mut frames = Frames::new(open(dump)?, dump, units);
            while let Some(frame) = frames.next().transpose()? {
                let particles = frame.particles(&frames.units()).map_err(|e| ImportError::at(dump, 1, e))?;
                if *columns.get_or_insert_with(|| frame.columns.clone()) != frame.columns {
                    let message =
                        format!("the columns change at step {}: import the dumps one by one", frame.step);
                    return Err(ImportError::Case(format!("{}: {message}", dump.display())));
                }
                write_rows(&mut table, &frame, series.is_empty()).map_err(ImportError::write(&path))?;
                let name = format!("particles-{:010}.vtp", frame.step);
                self.write(&name, |out| write_vtp(out, &frame, &particles))?;
                series.push((frame.time.unwrap_or(frame.step as f64), name));
                if options.step.is_none_or(|step| step == frame.step) {
                    kept = Some(particles);
                }
            }
        }
        table.flush().map_err(ImportError::write(&path))?;
        self.written.frames = series.len();
        self.written.files.push(path);
        self.write("particles.pvd", |out| write_pvd(out, &series))?;
        kept.ok_or_else(|| no_frame(dumps[0], options))
    }

    fn report(&mut self) -> Result<(), ImportError> {
        let text = self.written.report.to_string();
        self.write("import.txt", |out| out.write_all(text.as_bytes())).map(drop)
    }

    /// Writes a case and the files that it names, and checks it.
    fn case(&mut self, draft: Draft) -> Result<(), ImportError> {
        let path = self.write("case.toml", |out| out.write_all(draft.text.as_bytes()))?;
        for (name, mesh) in &draft.meshes {
            let to = self.to.join(name);
            mesh.write(&to)?;
            self.written.files.push(to);
        }
        for (name, particles) in &draft.tables {
            self.table(&name.to_string_lossy(), particles, Some(&draft.names))?;
        }
        self.report()?;
        let case = Case::load(&path).map_err(|e| {
            let import = self.to.join("import.txt");
            ImportError::Case(format!("{e}\n{} says what became of each command", import.display()))
        })?;
        for insert in &case.inserts {
            let Place::File { path } = &insert.place else { continue };
            ParticleColumns::read_csv(path)
                .and_then(|table| table.check(&path.display().to_string(), &case, insert))
                .map_err(|e| ImportError::Case(e.to_string()))?;
        }
        self.written.warnings = case.warnings.iter().map(ToString::to_string).collect();
        self.written.case = Some(path);
        Ok(())
    }
}

/// Adds a frame to the table of all frames: step, time (s) if the dump has it, and its columns as they are.
fn write_rows(out: &mut impl Write, frame: &Frame, is_first: bool) -> std::io::Result<()> {
    let time = frame.time.map(|time| format!(",{time}"));
    if is_first {
        writeln!(out, "step{},{}", if time.is_some() { ",time" } else { "" }, frame.columns.join(","))?;
    }
    for row in &frame.rows {
        let fields: Vec<String> = row.iter().map(f64::to_string).collect();
        writeln!(out, "{}{},{}", frame.step, time.as_deref().unwrap_or_default(), fields.join(","))?;
    }
    Ok(())
}
