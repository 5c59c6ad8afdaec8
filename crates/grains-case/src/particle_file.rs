//! Particles listed in a file: the columns of a CSV, and the checks that also serve HDF5.

use std::collections::BTreeMap;
use std::path::Path;

use crate::case::Case;
use crate::csv_share::CsvShare;
use crate::diagnostic::{CaseErrors, Diagnostic, unknown};
use crate::fit::missing_contact;
use crate::sections::insert::Insert;
use crate::sections::shape::ShapeKind;
use crate::slips::remedy_of_column;
use crate::vector::norm;

/// The columns a particle file may have, in any order; x, y and z are required.
const COLUMNS: [&str; 18] = [
    "x",
    "y",
    "z",
    "radius",
    "scale",
    "qw",
    "qx",
    "qy",
    "qz",
    "vx",
    "vy",
    "vz",
    "wx",
    "wy",
    "wz",
    "shape",
    "material",
    "temperature",
];

/// More remarks than this about one file say nothing new.
const MOST_REMARKS: usize = 20;

/// Particles as columns, one entry per particle; an absent column takes its value from `[[insert]]`.
#[derive(Clone, Debug, Default, PartialEq)]
pub struct ParticleColumns {
    /// Line of each particle in the file, from 1; for a file without lines, the row.
    pub lines: Vec<usize>,
    /// Centres of mass (m).
    pub position: Vec<[f64; 3]>,
    /// Radii (m), for spheres; excludes `scale`.
    pub radius: Option<Vec<f64>>,
    /// Factors on the lengths of the shape (-).
    pub scale: Option<Vec<f64>>,
    /// Quaternions (w, x, y, z) that turn the shape as the case gives it (-), of any length.
    pub orientation: Option<Vec<[f64; 4]>>,
    /// Velocities (m/s).
    pub velocity: Option<Vec<[f64; 3]>>,
    /// Angular velocities (rad/s).
    pub angular_velocity: Option<Vec<[f64; 3]>>,
    /// Temperatures (K).
    pub temperature: Option<Vec<f64>>,
    /// Names of shapes.
    pub shape: Option<Vec<String>>,
    /// Names of materials.
    pub material: Option<Vec<String>>,
}

impl ParticleColumns {
    /// Reads a CSV file: a header, then one particle per line; `#` begins a comment line.
    ///
    /// # Errors
    /// Unreadable file, unknown, repeated or missing columns, and every field that is no number.
    pub fn read_csv(path: &Path) -> Result<Self, CaseErrors> {
        Self::parse_share(&CsvShare::read(path, (0, 1))?, 0, &path.display().to_string())
    }

    /// Parses the text of a CSV file named `file`; see [`Self::read_csv`].
    ///
    /// # Errors
    /// As for [`Self::read_csv`].
    pub fn parse_csv(text: &str, file: &str) -> Result<Self, CaseErrors> {
        Self::parse_share(&CsvShare::of_text(text), 0, file)
    }

    /// Parses a share of the lines of a CSV file named `file`, so many lines after its first.
    ///
    /// # Errors
    /// As for [`Self::read_csv`]; a wrong header is an error of every share.
    pub fn parse_share(share: &CsvShare, lines_before: usize, file: &str) -> Result<Self, CaseErrors> {
        let mut remarks = Remarks::new(file);
        let header = share.columns();
        check_header(share.header_line, &header, &mut remarks);
        remarks.check()?;
        let (wants, mut rows) = (header.len(), Vec::new());
        for (line, fields) in share.rows(lines_before) {
            let has = fields.len();
            if has == wants {
                rows.push((line, fields));
            } else {
                let remedy = match has == 2 * wants {
                    true => "; decimals have a point, as in 0.005, and commas part the columns",
                    false => "",
                };
                let message = format!("{has} fields, but the header names {wants} columns{remedy}");
                remarks.add(line, "", None, message);
            }
        }
        let table = Table { header, rows };
        let columns = table.columns(&mut remarks);
        remarks.check()?;
        Ok(columns)
    }

    /// Number of particles.
    pub fn len(&self) -> usize {
        self.position.len()
    }

    /// Whether there is no particle.
    pub fn is_empty(&self) -> bool {
        self.position.is_empty()
    }

    /// Index of each particle's shape, if the file names shapes and all of them exist.
    pub fn shape_indices(&self, case: &Case) -> Option<Vec<usize>> {
        self.shape.as_ref()?.iter().map(|name| case.shape_index(name)).collect()
    }

    /// Checks the particles of `file` against the case and the insertion that names the file.
    ///
    /// # Errors
    /// Too few particles, centres outside the domain, sizes that are not positive or do not fit, unknown
    /// names, materials without density or contact law, numbers that are not finite.
    pub fn check(&self, file: &str, case: &Case, insert: &Insert) -> Result<(), CaseErrors> {
        self.check_share(file, case, insert, &FileTotals::of(self, case))
    }

    /// Checks a share of the particles of `file`, of which all shares together have some totals.
    ///
    /// # Errors
    /// As for [`Self::check`]; what is wrong with the whole file is an error of every share, with a material one of the
    /// share that names it first.
    pub fn check_share(
        &self,
        file: &str,
        case: &Case,
        insert: &Insert,
        totals: &FileTotals,
    ) -> Result<(), CaseErrors> {
        let mut remarks = Remarks::new(file);
        if let Some(count) = insert.count
            && count > totals.rows
        {
            let message = format!(
                "only {} particles, but {count} are asked for; lower count of insert \"{}\" or leave it out",
                totals.rows, insert.name
            );
            remarks.add(0, "", None, message);
        }
        self.check_positions(case, &mut remarks);
        self.check_sizes(case, insert, &mut remarks);
        self.check_names(case, &mut remarks);
        let own = self.lines.first().zip(self.lines.last()).map(|(first, last)| *first..=*last);
        totals.check_materials(
            (case, insert),
            |line| own.as_ref().is_some_and(|own| own.contains(&line)),
            &mut remarks,
        );
        self.check_motion(&mut remarks);
        remarks.check()
    }

    fn check_positions(&self, case: &Case, remarks: &mut Remarks) {
        for (line, position) in self.lines.iter().zip(&self.position) {
            if !case.domain.contains(*position) {
                let (lower, upper) = (case.domain.lower, case.domain.upper);
                remarks.add(
                    *line,
                    "x, y, z",
                    Some(format!("{position:?}")),
                    format!("outside the domain {lower:?} to {upper:?} m; lengths are in metres"),
                );
            }
        }
    }

    fn check_sizes(&self, case: &Case, insert: &Insert, remarks: &mut Remarks) {
        if self.radius.is_some() && self.scale.is_some() {
            remarks.add(0, "radius", None, "excludes the column scale; remove one of them".into());
        }
        for (key, sizes) in [("radius", &self.radius), ("scale", &self.scale)] {
            for (line, size) in self.lines.iter().zip(sizes.iter().flatten()) {
                if !(*size > 0.0 && size.is_finite()) {
                    remarks.add(*line, key, Some(size.to_string()), "must be above 0".into());
                }
            }
        }
        let Some(radii) = &self.radius else { return };
        let named = self.shape_indices(case);
        let is_sphere = |index: usize| matches!(case.shapes[index].kind, ShapeKind::Sphere { .. });
        let mixture_is_round = insert.particles.iter().all(|component| is_sphere(component.shape));
        let room = case.domain.extents().into_iter().fold(f64::INFINITY, f64::min);
        for (i, (line, radius)) in self.lines.iter().zip(radii).enumerate() {
            let is_round = named.as_ref().map_or(mixture_is_round, |shapes| is_sphere(shapes[i]));
            let message = if !is_round {
                "only spheres have a radius; use the column scale".to_owned()
            } else if 2.0 * radius > room {
                format!("does not fit the domain, {room} m wide; lengths are in metres")
            } else {
                continue;
            };
            remarks.add(*line, "radius", Some(radius.to_string()), message);
        }
    }

    fn check_names(&self, case: &Case, remarks: &mut Remarks) {
        let shapes: Vec<&str> = case.shapes.iter().map(|shape| shape.name.as_str()).collect();
        for (line, name) in self.lines.iter().zip(self.shape.iter().flatten()) {
            if case.shape_index(name).is_none() {
                remarks.add(*line, "shape", Some(name.clone()), unknown("shape", name, &shapes));
            }
        }
        let materials: Vec<&str> = case.materials.iter().map(|material| material.name.as_str()).collect();
        for (line, name) in self.lines.iter().zip(self.material.iter().flatten()) {
            if case.material_index(name).is_none() {
                remarks.add(*line, "material", Some(name.clone()), unknown("material", name, &materials));
            }
        }
    }

    fn check_motion(&self, remarks: &mut Remarks) {
        for (key, vectors) in [("vx, vy, vz", &self.velocity), ("wx, wy, wz", &self.angular_velocity)] {
            for (line, vector) in self.lines.iter().zip(vectors.iter().flatten()) {
                if !vector.iter().all(|x| x.is_finite()) {
                    remarks.add(*line, key, Some(format!("{vector:?}")), "must be finite numbers".into());
                }
            }
        }
        for (line, temperature) in self.lines.iter().zip(self.temperature.iter().flatten()) {
            if !(*temperature >= 0.0 && temperature.is_finite()) {
                let message = "is no temperature in kelvin: it must not be below 0";
                remarks.add(*line, "temperature", Some(temperature.to_string()), message.into());
            }
        }
        for (line, q) in self.lines.iter().zip(self.orientation.iter().flatten()) {
            if !(q.iter().all(|x| x.is_finite()) && norm(*q) > 0.0) {
                let message = "is no orientation; [1, 0, 0, 0] is the unturned body";
                remarks.add(*line, "qw, qx, qy, qz", Some(format!("{q:?}")), message.into());
            }
        }
    }
}

/// What the rows of a file come to, shares of other readers included.
#[derive(Clone, Debug, PartialEq)]
pub struct FileTotals {
    /// Number of particles.
    pub rows: u64,
    /// First line that names each material of the case; none where no line does.
    pub material_lines: Vec<Option<usize>>,
}

impl FileTotals {
    /// Those of some columns alone.
    pub fn of(columns: &ParticleColumns, case: &Case) -> Self {
        let mut material_lines = vec![None; case.materials.len()];
        for (line, name) in columns.lines.iter().zip(columns.material.iter().flatten()) {
            if let Some(index) = case.material_index(name) {
                material_lines[index].get_or_insert(*line);
            }
        }
        Self { rows: columns.len() as u64, material_lines }
    }

    /// Remarks on the materials whose first lines are the own ones.
    fn check_materials(
        &self,
        (case, insert): (&Case, &Insert),
        is_own: impl Fn(usize) -> bool,
        remarks: &mut Remarks,
    ) {
        let lines = self.material_lines.iter().enumerate();
        let used: BTreeMap<usize, usize> = lines.filter_map(|(m, line)| Some((m, (*line)?))).collect();
        let is_free = !insert.is_prescribed();
        let walls = case.walls.iter().map(|wall| wall.material).filter(|_| is_free);
        // Particles of prescribed motion meet free ones only.
        let others = case.inserts.iter().filter(|other| is_free || !other.is_prescribed());
        let others = others.flat_map(|other| &other.particles).map(|component| component.material);
        let own = used.keys().copied().filter(|_| is_free);
        let partners: std::collections::BTreeSet<usize> = walls.chain(others).chain(own).collect();
        for (&index, &line) in used.iter().filter(|(_, line)| is_own(**line)) {
            let name = Some(case.materials[index].name.clone());
            if case.materials[index].density.is_none() {
                let message = "has no density; add density (kg/m³) to that [[material]]";
                remarks.add(line, "material", name.clone(), message.into());
            }
            for &other in &partners {
                let is_first = !is_free || other >= index || !used.contains_key(&other);
                if is_first && !case.holds_particles() && case.contact(index, other).is_none() {
                    remarks.add(line, "material", name.clone(), missing_contact(case, index, other));
                }
            }
        }
    }
}

/// Remarks about one file, up to a sensible number.
struct Remarks<'a> {
    file: &'a str,
    list: Vec<Diagnostic>,
    omitted: usize,
}

impl<'a> Remarks<'a> {
    fn new(file: &'a str) -> Self {
        Self { file, list: Vec::new(), omitted: 0 }
    }

    fn add(&mut self, line: usize, key: &str, value: Option<String>, message: String) {
        if self.list.len() == MOST_REMARKS {
            self.omitted += 1;
            return;
        }
        let file = self.file.to_owned();
        self.list.push(Diagnostic { file, line, column: 0, key: key.to_owned(), value, message });
    }

    fn check(&mut self) -> Result<(), CaseErrors> {
        if self.list.is_empty() {
            return Ok(());
        }
        let mut list = std::mem::take(&mut self.list);
        list.sort_by_key(|remark| remark.line);
        if self.omitted > 0 {
            list.extend(CaseErrors::of_file(self.file, format!("and {} more like these", self.omitted)).0);
        }
        Err(CaseErrors(list))
    }
}

fn check_header(line: usize, header: &[&str], remarks: &mut Remarks) {
    for (i, name) in header.iter().enumerate() {
        if !COLUMNS.contains(name) {
            let message = match remedy_of_column(name, header) {
                Some(remedy) => format!("unknown column; {remedy}"),
                None => unknown("column", name, &COLUMNS),
            };
            remarks.add(line, name, None, message);
        } else if header[..i].contains(name) {
            remarks.add(line, name, None, "this column appears twice; remove one".into());
        }
    }
    let groups: [&[&str]; 4] =
        [&["x", "y", "z"], &["qw", "qx", "qy", "qz"], &["vx", "vy", "vz"], &["wx", "wy", "wz"]];
    for (i, group) in groups.into_iter().enumerate() {
        let is_wanted = i == 0 || group.iter().any(|name| header.contains(name));
        for name in group.iter().filter(|name| is_wanted && !header.contains(name)) {
            let message = format!("missing column; the header must name {}", group.join(", "));
            remarks.add(line, name, None, message);
        }
    }
}

/// The fields of a CSV file as text.
struct Table<'t> {
    header: Vec<&'t str>,
    /// Lines in the file, and fields.
    rows: Vec<(usize, Vec<&'t str>)>,
}

impl Table<'_> {
    fn columns(&self, remarks: &mut Remarks) -> ParticleColumns {
        ParticleColumns {
            lines: self.rows.iter().map(|(line, _)| *line).collect(),
            position: self.numbers(["x", "y", "z"], remarks).unwrap_or_default(),
            radius: self.single("radius", remarks),
            scale: self.single("scale", remarks),
            orientation: self.numbers(["qw", "qx", "qy", "qz"], remarks),
            velocity: self.numbers(["vx", "vy", "vz"], remarks),
            angular_velocity: self.numbers(["wx", "wy", "wz"], remarks),
            temperature: self.single("temperature", remarks),
            shape: self.words("shape"),
            material: self.words("material"),
        }
    }

    fn index(&self, name: &str) -> Option<usize> {
        self.header.iter().position(|other| *other == name)
    }

    fn words(&self, name: &str) -> Option<Vec<String>> {
        let index = self.index(name)?;
        Some(self.rows.iter().map(|(_, fields)| fields[index].to_owned()).collect())
    }

    fn single(&self, name: &str, remarks: &mut Remarks) -> Option<Vec<f64>> {
        Some(self.numbers([name], remarks)?.into_iter().map(|[x]| x).collect())
    }

    fn numbers<const N: usize>(&self, names: [&str; N], remarks: &mut Remarks) -> Option<Vec<[f64; N]>> {
        let mut indices = [0; N];
        for (index, name) in indices.iter_mut().zip(names) {
            *index = self.index(name)?;
        }
        let mut column = Vec::with_capacity(self.rows.len());
        for (line, fields) in &self.rows {
            column.push(std::array::from_fn(|i| {
                let field = fields[indices[i]];
                field.parse().unwrap_or_else(|_| {
                    let message = "must be a number with a decimal point".to_owned();
                    remarks.add(*line, names[i], Some(field.to_owned()), message);
                    0.0
                })
            }));
        }
        Some(column)
    }
}
