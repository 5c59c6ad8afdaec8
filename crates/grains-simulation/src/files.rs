//! The files of a run: what of the state goes where.

use crate::changes;
use crate::error::{RunError, agreed};
use crate::fluid::{self, FluidFiles, FluidPhase, Opening};
use crate::heat;
use crate::laws;
use crate::lock::DirectoryLock;
use crate::restart::{Continued, HISTORY, IDENTITY, INPUTS, State};
use crate::run_directory::{prepare_directory, write_side_files};
use crate::series_columns::series_columns;
use crate::species;
use crate::wall_triangles::{triangles_of, wall_fields};
use grains_case::{Case, Field, Precision as CasePrecision};
use grains_comm::MpiTransport;
use grains_dem::{Dem, Liquid, Loading, Totals};
use grains_domain::Transport;
use grains_geometry::Vec3;
use grains_output::{
    Data, FieldSpec, FileError, Metadata, PolyDataFile, Precision, Series, Step, abandon_later,
    agree_written, from_rank, remove_old, utc_now, write_checkpoint,
};
use grains_resolved::FlowLink;
use std::path::PathBuf;

/// Fields of a particle snapshot when none is left out.
const PARTICLE_FIELDS: [FieldSpec; 18] = [
    FieldSpec::integer("id"),
    FieldSpec::integer("shape"),
    FieldSpec::integer("material"),
    FieldSpec::integer("coordination"),
    FieldSpec::integer("wall_contacts"),
    FieldSpec::integer("bonds"),
    FieldSpec::real("radius", "m", 1),
    FieldSpec::real("scale", "-", 1),
    FieldSpec::real("orientation_wxyz", "-", 4),
    FieldSpec::real("velocity", "m/s", 3),
    FieldSpec::real("angular_velocity", "rad/s", 3),
    FieldSpec::real("force", "N", 3),
    FieldSpec::real("torque", "N m", 3),
    FieldSpec::real("fluid_force", "N", 3),
    FieldSpec::real("fluid_torque", "N m", 3),
    FieldSpec::real("film", "m3", 1),
    FieldSpec::real("liquid", "m3", 1),
    FieldSpec::real("temperature", "K", 1),
];

/// Fields of the particle snapshots of a case.
pub fn particle_fields(case: &Case) -> Vec<FieldSpec> {
    let is_resolved = case.fluid.as_ref().is_some_and(|fluid| fluid.resolved.is_some());
    let is_kept = |spec: &FieldSpec| {
        let optional = match spec.name {
            "material" => Field::Material,
            "coordination" => Field::Coordination,
            "wall_contacts" => Field::WallContacts,
            "velocity" => Field::Velocity,
            "angular_velocity" => Field::AngularVelocity,
            "force" => Field::Force,
            "torque" => Field::Torque,
            "bonds" => Field::Bonds,
            "film" => Field::Film,
            "liquid" => Field::Liquid,
            "temperature" => Field::Temperature,
            "fluid_force" => Field::FluidForce,
            "fluid_torque" => Field::FluidTorque,
            _ => return true,
        };
        let exists = match optional {
            Field::FluidForce | Field::FluidTorque => is_resolved,
            Field::Bonds => !case.bonds.is_empty(),
            Field::Film | Field::Liquid => case.contacts.iter().any(laws::is_fed_by_films),
            Field::Temperature => case.heat.is_some(),
            _ => true,
        };
        case.output.fields.contains(&optional) && exists
    };
    PARTICLE_FIELDS.into_iter().filter(is_kept).chain(species::fields(case)).collect()
}

/// Fields of the triangles of particles.
pub const SURFACE_FIELDS: [FieldSpec; 3] =
    [FieldSpec::integer("id"), FieldSpec::integer("shape"), FieldSpec::real("speed", "m/s", 1)];

/// Key numbers of a row of the time series.
#[derive(Clone, Debug, PartialEq)]
pub struct Row {
    /// Particles inside.
    pub particles: u64,
    /// Contacts between particles.
    pub contacts: u64,
    /// Kinetic energy (J).
    pub kinetic_energy: f64,
    /// Largest speed (m/s).
    pub max_speed: f64,
    /// Largest overlap over inscribed radius (-).
    pub max_overlap: f64,
    /// Net count through each flow plane.
    pub crossings: Vec<i64>,
}

/// Values of a field of all owned particles.
enum Values {
    Real(Vec<f64>),
    Integer(Vec<i64>),
}

impl Values {
    fn data(&self) -> Data<'_> {
        match self {
            Self::Real(values) => Data::Real(values),
            Self::Integer(values) => Data::Integer(values),
        }
    }
}

/// Values of one of [`PARTICLE_FIELDS`].
fn values_of(field: &str, dem: &Dem, (neighbours, walls): &(Vec<u32>, Vec<u32>)) -> Values {
    let particles = &dem.particles;
    let owned = 0..particles.owned;
    let body = |i: usize| &particles.bodies[i];
    let integers = |value: &dyn Fn(usize) -> i64| Values::Integer(owned.clone().map(value).collect());
    let reals = |value: &dyn Fn(usize) -> f64| Values::Real(owned.clone().map(value).collect());
    let vectors = |value: &dyn Fn(usize) -> Vec3| {
        Values::Real(owned.clone().flat_map(|i| <[f64; 3]>::from(value(i))).collect())
    };
    match field {
        "id" => integers(&|i| particles.ids[i] as i64),
        "shape" => integers(&|i| i64::from(body(i).kind.shape)),
        "material" => integers(&|i| i64::from(body(i).kind.material)),
        "coordination" => integers(&|i| i64::from(neighbours[i])),
        "wall_contacts" => integers(&|i| i64::from(walls[i])),
        "bonds" => Values::Integer(dem.bonds_of_each().into_iter().map(i64::from).collect()),
        "radius" => reals(&|i| body(i).radius),
        "scale" => reals(&|i| body(i).radius / dem.setup.catalogue.shape(body(i).kind).bounding_radius),
        "velocity" => vectors(&|i| body(i).velocity),
        "angular_velocity" => vectors(&|i| body(i).angular_velocity),
        "force" => vectors(&|i| particles.loads[i].force),
        "torque" => vectors(&|i| particles.loads[i].torque),
        "fluid_force" => vectors(&|i| FlowLink::read(&particles.cargo[i]).force),
        "fluid_torque" => vectors(&|i| FlowLink::read(&particles.cargo[i]).torque),
        "temperature" => reals(&|i| particles.temperatures[i]),
        "film" => reals(&|i| particles.films[i].volume()),
        "liquid" => Values::Real(dem.liquid_of_each().into_iter().map(|[_, liquid]| liquid).collect()),
        "orientation_wxyz" => Values::Real(owned.flat_map(|i| dem.orientation_in_case(i)).collect()),
        of_species => {
            let mut all = dem.setup.species.iter();
            match all.position(|species| species::field_name(species) == of_species) {
                Some(number) => reals(&|i| particles.amounts_of(i)[number]),
                None => unreachable!("no field {of_species}"),
            }
        }
    }
}

/// Open files of a run.
pub struct Files {
    directory: PathBuf,
    particle_fields: Vec<FieldSpec>,
    metadata: Metadata,
    keep: usize,
    particles: Option<PolyDataFile>,
    walls: Option<PolyDataFile>,
    surfaces: Option<PolyDataFile>,
    fluid: Option<FluidFiles>,
    /// On rank 0 only.
    series: Option<Series>,
    /// On rank 0 only.
    lock: Option<DirectoryLock>,
}

impl Files {
    /// Opens the files of a run: new, or those of a run that is continued from a checkpoint among them.
    ///
    /// # Errors
    /// A directory or file that cannot be used.
    pub fn open(
        case: &Case,
        program: &str,
        transport: &MpiTransport,
        continued: Option<&Continued>,
        (dem, fluid): (&Dem, &Option<FluidPhase>),
    ) -> Result<Self, RunError> {
        let communicator = transport.communicator();
        let directory = case.output.directory.clone();
        let is_own = continued.is_some_and(|continued| continued.is_own);
        let is_first = transport.rank() == 0;
        let ready = is_first.then(|| prepare_directory(&directory, is_own)).transpose();
        let lock = agree_written(communicator, ready)?;
        if is_first && is_own {
            // What the files say of later steps is cut off: no later checkpoint may be continued from.
            abandon_later(&directory, dem.step);
        }
        let metadata = metadata(case, program, transport, continued)?;
        agree_written(
            communicator,
            if is_first { write_side_files(case, program, dem, &directory) } else { Ok(()) },
        )?;
        let precision = match case.output.precision {
            CasePrecision::F64 => Precision::F64,
            CasePrecision::F32 => Precision::F32,
        };
        let opening = Opening {
            directory: &directory,
            format: (precision, case.output.compress),
            metadata: &metadata,
            restart: is_own.then_some((dem.step, dem.time())),
        };
        let open = |name: &str, is_wanted: bool, specs: &[FieldSpec], is_surface: bool| {
            is_wanted.then(|| open_polydata(&opening, name, (specs, is_surface), transport)).transpose()
        };
        let particle_fields = particle_fields(case);
        let has_particles = case.output.particles > 0.0 && !case.inserts.is_empty();
        let particles = open("particles.vtkhdf", has_particles, &particle_fields, false)?;
        let has_walls = has_particles && !case.walls.is_empty();
        let walls = open("walls.vtkhdf", has_walls, &wall_fields(dem.has_wear()), true)?;
        let surfaces = open("surfaces.vtkhdf", case.output.surfaces > 0.0, &SURFACE_FIELDS, true)?;
        let fluid_files =
            fluid.as_ref().map(|f| FluidFiles::open(case, f, &opening, transport)).transpose()?;
        let is_written = is_first && case.output.series > 0.0;
        let series = is_written.then(|| open_series(case, dem, &opening, continued)).transpose();
        let series = agree_written(communicator, series)?;
        let keep = case.output.keep_checkpoints as usize;
        Ok(Self {
            directory,
            particle_fields,
            metadata,
            keep,
            particles,
            walls,
            surfaces,
            fluid: fluid_files,
            series,
            lock,
        })
    }

    /// Checks that the directory is still the one that was opened; collective.
    ///
    /// # Errors
    /// One that was renamed, removed or replaced.
    pub fn verify(&self, transport: &MpiTransport) -> Result<(), RunError> {
        let there = self.lock.as_ref().map_or(Ok(()), DirectoryLock::verify);
        Ok(agree_written(transport.communicator(), there)?)
    }

    /// The outcome of writing; what fails because the directory is gone is told as that. Collective if it failed.
    pub fn explained<T>(
        &self,
        outcome: Result<T, RunError>,
        transport: &MpiTransport,
    ) -> Result<T, RunError> {
        outcome.map_err(|error| self.verify(transport).err().unwrap_or(error))
    }

    /// Writes a snapshot of particles and walls, unless the files hold it.
    ///
    /// # Errors
    /// A full disk.
    pub fn snapshot(&mut self, dem: &Dem, transport: &MpiTransport) -> Result<(), RunError> {
        if let Some(file) = self.particles.as_mut().filter(|file| !file.holds(dem.time())) {
            let particles = &dem.particles;
            let wrapped = |i: usize| dem.setup.global.wrap(particles.bodies[i].position.into());
            let points: Vec<f64> = (0..particles.owned).flat_map(wrapped).collect();
            let coordination = dem.coordination();
            let values: Vec<Values> =
                self.particle_fields.iter().map(|f| values_of(f.name, dem, &coordination)).collect();
            let fields: Vec<Data> = values.iter().map(Values::data).collect();
            file.append(&Step { time: dem.time(), points: &points, triangles: &[], fields: &fields })?;
        }
        if let Some(file) = self.walls.as_mut().filter(|file| !file.holds(dem.time())) {
            let worn = dem.worn_volumes(transport);
            let surface = if transport.rank() == 0 { triangles_of(dem, &worn) } else { Default::default() };
            let mut fields = vec![Data::Integer(&surface.walls), Data::Real(&surface.velocities)];
            if dem.has_wear() {
                fields.push(Data::Real(&surface.worn_depths));
            }
            file.append(&Step {
                time: dem.time(),
                points: &surface.points,
                triangles: &surface.triangles,
                fields: &fields,
            })?;
        }
        Ok(())
    }

    /// Changes which cells of the fluid each rank writes.
    ///
    /// # Errors
    /// Blocks that do not make up the grid.
    pub fn divide(&mut self, fluid: &FluidPhase) -> Result<(), RunError> {
        self.fluid.as_mut().map_or(Ok(()), |files| files.divide(fluid))
    }

    /// Writes a snapshot of the fluid.
    ///
    /// # Errors
    /// A full disk.
    pub fn fluid_snapshot(
        &mut self,
        fluid: &mut FluidPhase,
        dem: &Dem,
        transport: &MpiTransport,
    ) -> Result<(), RunError> {
        self.fluid.as_mut().map_or(Ok(()), |files| files.snapshot(fluid, dem, transport))
    }

    /// Writes the true surfaces of all particles, unless the file holds them.
    ///
    /// # Errors
    /// A full disk.
    pub fn surfaces(&mut self, dem: &Dem) -> Result<(), RunError> {
        let Some(file) = self.surfaces.as_mut().filter(|file| !file.holds(dem.time())) else { return Ok(()) };
        let bodies = &dem.particles.bodies[..dem.particles.owned];
        let surface_of = |body: &grains_dem::Body| &dem.setup.catalogue.shape(body.kind).surface;
        let [count, faces] = bodies.iter().map(surface_of).fold([0, 0], |[count, faces], surface| {
            [count + surface.vertices.len(), faces + surface.triangles.len()]
        });
        // By far the largest arrays of a run: none is moved as it grows.
        let (mut points, mut triangles) = (Vec::with_capacity(3 * count), Vec::with_capacity(3 * faces));
        let (mut ids, mut shapes) = (Vec::with_capacity(faces), Vec::with_capacity(faces));
        let mut speeds = Vec::with_capacity(faces);
        for (i, body) in bodies.iter().enumerate() {
            let shape = dem.setup.catalogue.shape(body.kind);
            let scale = body.radius / shape.bounding_radius;
            let center = Vec3::from(dem.setup.global.wrap(body.position.into()));
            let placed = shape.surface.transformed(&dem.particles.record(i).orientation, scale, &center);
            let first = (points.len() / 3) as i64;
            points.extend(placed.vertices.iter().flat_map(|v| [v.x, v.y, v.z]));
            triangles.extend(placed.triangles.iter().flatten().map(|&k| first + i64::from(k)));
            ids.extend(placed.triangles.iter().map(|_| dem.particles.ids[i] as i64));
            shapes.extend(placed.triangles.iter().map(|_| i64::from(body.kind.shape)));
            speeds.extend(placed.triangles.iter().map(|_| body.velocity.norm()));
        }
        let fields = [Data::Integer(&ids), Data::Integer(&shapes), Data::Real(&speeds)];
        file.append(&Step { time: dem.time(), points: &points, triangles: &triangles, fields: &fields })?;
        Ok(())
    }

    /// Writes a row of the time series, at its end what is told of the fluid, unless the file holds it.
    ///
    /// # Errors
    /// A full disk.
    pub fn row(
        &mut self,
        dem: &mut Dem,
        of_fluid: &[f64],
        transport: &MpiTransport,
    ) -> Result<Row, RunError> {
        let totals = dem.totals(transport);
        let crossings = dem.crossings(transport);
        let (loads, worn) = (dem.wall_loads(transport), dem.worn_walls(transport));
        let (neighbours, walls) = dem.coordination();
        let count = |list: &[u32]| list.iter().map(|&c| u64::from(c)).sum::<u64>();
        let (report, ledger) = (&dem.report, &dem.ledger);
        let mut counts =
            [count(&neighbours), count(&walls), report.deep_penetrations, ledger.inserted, ledger.left];
        transport.sum_counts(&mut counts);
        let mut overlap = [report.max_overlap];
        transport.max(&mut overlap);
        let Totals { momentum: p, angular_momentum: l, .. } = totals;
        let mut values = vec![dem.time(), totals.particles as f64, counts[3] as f64, counts[4] as f64];
        values.extend([0.5 * counts[0] as f64, counts[1] as f64]);
        values.extend([totals.kinetic_translation, totals.kinetic_rotation, totals.potential, p.x, p.y, p.z]);
        values.extend([l.x, l.y, l.z]);
        values.extend([overlap[0], totals.max_speed, counts[2] as f64]);
        if !dem.setup.bonds.is_empty() {
            let bonds = dem.check_bonds(transport).map_err(|e| RunError::unphysical(e.to_string()))?;
            values.extend(bonds.map(|count| count as f64));
        }
        if dem.particles.is_wet() {
            let liquid = dem.check_liquid(transport).map_err(|e| RunError::unphysical(e.to_string()))?;
            let Liquid { films, bridges, walls, inserted, left, count, broken } = liquid;
            values.extend([count as f64, broken as f64, films, bridges, walls, inserted, left]);
        }
        let quantum = dem.mass_quantum();
        values.extend(crossings.iter().flat_map(|c| [c.count as f64, c.mass(quantum)]));
        let walls = dem.setup.walls.iter().zip(dem.wall_states());
        for ((load, worn), (wall, state)) in loads.iter().zip(worn).zip(walls) {
            values.extend(load.force.iter().chain(load.torque.iter()));
            if let Some(Loading { axis, .. }) = wall.motion.loading() {
                values.extend([axis.dot(&state.translation), axis.dot(&state.velocity)]);
            }
            values.extend(worn.iter().flat_map(|worn| [worn.volume, worn.sliding_power]));
        }
        for load in &dem.prescribed_loads(transport) {
            values.extend(load.force.iter().chain(load.torque.iter()));
        }
        if let Some(stress) = dem.take_stress(transport) {
            values.extend(stress.total.iter().chain(&stress.kinetic));
            values.push(stress.temperature);
        }
        values.extend(heat::row(dem, transport));
        values.extend(species::row(dem, transport));
        values.extend(of_fluid);
        let written = match &mut self.series {
            Some(series) if !series.holds(dem.step) => series.append(dem.step, &values),
            _ => Ok(()),
        };
        agree_written(transport.communicator(), written)?;
        Ok(Row {
            particles: totals.particles,
            contacts: counts[0] / 2,
            kinetic_energy: totals.kinetic_translation + totals.kinetic_rotation,
            max_speed: totals.max_speed,
            max_overlap: overlap[0],
            crossings: crossings.iter().map(|c| c.count).collect(),
        })
    }

    /// What every file says of its origin.
    pub fn metadata(&self) -> &Metadata {
        &self.metadata
    }

    /// Writes a checkpoint and deletes old ones.
    ///
    /// The state of the particles was taken before the contacts of the step, that of the fluid is the present one.
    ///
    /// # Errors
    /// A full disk; earlier checkpoints stay.
    pub fn checkpoint(
        &mut self,
        (dem, fluid): (&Dem, &Option<FluidPhase>),
        (arrays, mut texts): State,
        transport: &MpiTransport,
    ) -> Result<(), RunError> {
        texts.extend(fluid.iter().flat_map(|fluid| fluid.texts(dem, transport)));
        let grids = fluid.iter().flat_map(FluidPhase::arrays);
        texts.extend(self.metadata.iter().cloned());
        self.verify(transport)?;
        write_checkpoint(&self.directory, dem.step, transport.communicator(), &arrays, grids, &texts)?;
        if transport.rank() == 0 {
            remove_old(&self.directory, self.keep);
        }
        Ok(())
    }
}

/// Opens a file of snapshots: the one there goes on after a restart, else a new one begins.
fn open_polydata(
    opening: &Opening,
    name: &str,
    (specs, is_surface): (&[FieldSpec], bool),
    transport: &MpiTransport,
) -> Result<PolyDataFile, FileError> {
    let (path, communicator) = (opening.directory.join(name), transport.communicator());
    // There is none after a restart right at the beginning, or where the first run did not write one.
    let is_there = transport.any(transport.rank() == 0 && path.exists());
    match opening.restart.filter(|_| is_there) {
        Some((_, time)) => {
            let (precision, _) = opening.format;
            let file = PolyDataFile::resume(&path, communicator, specs, is_surface, precision, time)?;
            file.record_restart(opening.metadata)?;
            Ok(file)
        }
        None => {
            PolyDataFile::create(&path, communicator, specs, is_surface, opening.format, opening.metadata)
        }
    }
}

/// Opens the time series: the one there goes on after a restart, else a new one begins.
fn open_series(
    case: &Case,
    dem: &Dem,
    opening: &Opening,
    continued: Option<&Continued>,
) -> Result<Series, FileError> {
    let path = opening.directory.join("series.csv");
    let (columns, units): (Vec<String>, Vec<&str>) =
        series_columns(dem).into_iter().chain(fluid::columns(case)).unzip();
    if opening.restart.is_some() && path.exists() {
        let mut series = Series::resume(&path, &columns, dem.step)?;
        let changes = continued.map_or(String::new(), |continued| continued.changes.join("\n"));
        series.note(&[(format!("from step {}", dem.step), changes)])?;
        return Ok(series);
    }
    let mut comments = opening.metadata.clone();
    comments.push(("units".into(), units.join(",")));
    Series::create(&path, &columns, &comments)
}

fn metadata(
    case: &Case,
    program: &str,
    transport: &MpiTransport,
    continued: Option<&Continued>,
) -> Result<Metadata, RunError> {
    let text = case.to_toml();
    let inputs = if transport.rank() == 0 { changes::inputs(&text) } else { Ok(String::new()) };
    let inputs = agreed(transport, inputs.map_err(RunError::case))?;
    let ranks = transport.size();
    // Clocks of ranks differ: all write what rank 0 says.
    let begun = from_rank(transport.communicator(), 0, &utc_now());
    let mut metadata: Metadata = vec![
        ("program".into(), program.to_string()),
        ("ranks".into(), ranks.to_string()),
        ("begun".into(), begun),
        ("seed".into(), case.seed.to_string()),
        ("case".into(), text.clone()),
    ];
    let inputs = from_rank(transport.communicator(), 0, &inputs);
    metadata.push((IDENTITY.into(), changes::identity(&text, &inputs).map_err(RunError::case)?));
    let history = continued.map_or(String::new(), |continued| continued.history.clone());
    let lists = [(INPUTS, inputs), (HISTORY, history)].into_iter().filter(|(_, text)| !text.is_empty());
    metadata.extend(lists.map(|(name, text)| (name.to_string(), text)));
    Ok(metadata)
}
