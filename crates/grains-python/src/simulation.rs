//! A simulation, as Python steps and sees it.

use crate::arrays::Leases;
use crate::{CaseError, case, job, raised};
use grains_domain::Transport;
use grains_simulation::{Inflow, Options, Simulation as Running, Status, Summary};
use numpy::{PyArray1, PyArray2};
use pyo3::exceptions::PyValueError;
use pyo3::prelude::*;
use pyo3::types::PyDict;
use std::path::PathBuf;
use std::time::{Duration, Instant};

/// How often Python is asked whether a signal has come.
const SIGNALS: Duration = Duration::from_millis(100);

/// A simulation in progress on this rank.
#[pyclass(unsendable, module = "grains._grains")]
pub struct Simulation {
    /// None once it is closed.
    running: Option<Running>,
    leases: Leases,
    status: Status,
    step: (u64, f64),
}

impl Drop for Simulation {
    /// Arrays may live longer than it.
    fn drop(&mut self) {
        self.abandon();
    }
}

fn is_closed() -> PyErr {
    PyValueError::new_err("this simulation is closed; open its results with grains.open")
}

impl Simulation {
    fn running(&self) -> PyResult<&Running> {
        self.running.as_ref().ok_or_else(is_closed)
    }

    /// The simulation, about to change its state.
    fn changing(&mut self) -> PyResult<&mut Running> {
        let running = self.running.as_mut().ok_or_else(is_closed)?;
        self.leases.release(running);
        Ok(running)
    }

    /// Steps until `is_enough`, the end or a signal; collective.
    fn go_on(&mut self, py: Python<'_>, is_enough: impl Fn(&Running) -> bool) -> PyResult<bool> {
        let mut signal = None;
        let mut asked = Instant::now();
        let running = self.changing()?;
        let mut status = Status::Running;
        while !is_enough(running) {
            status = running.step().map_err(raised)?;
            if status != Status::Running {
                break;
            }
            if signal.is_none() && asked.elapsed() > SIGNALS {
                asked = Instant::now();
                if let Err(error) = py.check_signals() {
                    // All ranks stop at the same step, with a checkpoint.
                    running.stop();
                    signal = Some(error);
                }
            }
        }
        self.step = (running.steps(), running.time());
        self.status = status;
        match signal {
            Some(error) => Err(error),
            None => Ok(status == Status::Running),
        }
    }
}

#[pymethods]
impl Simulation {
    /// Builds a case in the job of the communicator at an address, and fills it or takes a checkpoint; collective.
    #[new]
    fn new(
        case: &case::Case,
        communicator: usize,
        restart: Option<PathBuf>,
        writes_files: bool,
        petsc: Vec<String>,
    ) -> PyResult<Self> {
        let program = concat!("grains (Python) ", env!("CARGO_PKG_VERSION")).into();
        let options = Options { restart, writes_files, program, petsc };
        let job = job::job(communicator)?;
        let mut running = Running::new(&case.case, &job, options).map_err(raised)?;
        running.insert_due().map_err(raised)?;
        let step = (running.steps(), running.time());
        Ok(Self { running: Some(running), leases: Leases::default(), status: Status::Running, step })
    }

    /// Does a number of steps; whether there are more. Collective.
    fn advance(&mut self, py: Python<'_>, steps: u64) -> PyResult<bool> {
        let end = self.running()?.steps() + steps;
        self.go_on(py, |running| running.steps() >= end)
    }

    /// Goes on up to the step nearest to a time (s), or to the end; whether there are more. Collective.
    fn run_to(&mut self, py: Python<'_>, time: f64) -> PyResult<bool> {
        let running = self.changing()?;
        running.pause_at(time);
        self.go_on(py, Running::is_paused)
    }

    /// Asks for the end: one of the next ten steps writes a checkpoint and is the last.
    fn stop(&mut self) -> PyResult<()> {
        self.running.as_mut().ok_or_else(is_closed)?.stop();
        Ok(())
    }

    /// Ends the simulation, with a checkpoint if it was still running; collective.
    fn close<'py>(&mut self, py: Python<'py>) -> PyResult<Bound<'py, PyDict>> {
        self.changing()?;
        let running = self.running.take().ok_or_else(is_closed)?;
        summary(py, &running.close().map_err(raised)?)
    }

    /// Lets go of everything without a checkpoint; the files hold what was written.
    fn abandon(&mut self) {
        if let Some(mut running) = self.running.take() {
            self.leases.release(&mut running);
        }
    }

    /// "running", "finished" or "stopped".
    #[getter]
    fn status(&self) -> &'static str {
        match self.status {
            Status::Running => "running",
            Status::Finished => "finished",
            Status::Stopped => "stopped",
        }
    }

    /// Time of the present state (s).
    #[getter]
    fn time(&self) -> f64 {
        self.running.as_ref().map_or(self.step.1, Running::time)
    }

    /// Steps of the particles so far, those before a restart included.
    #[getter]
    fn steps(&self) -> u64 {
        self.running.as_ref().map_or(self.step.0, Running::steps)
    }

    /// Time step of the particles (s).
    #[getter]
    fn time_step(&self) -> PyResult<f64> {
        Ok(self.running()?.dem().setup.parameters.dt)
    }

    /// Rank of this process and number of ranks.
    #[getter]
    fn ranks(&self) -> PyResult<(usize, usize)> {
        let transport = self.running()?.transport();
        Ok((transport.rank(), transport.size()))
    }

    /// Sum of a number over the ranks; collective.
    fn sum(&self, value: f64) -> PyResult<f64> {
        Ok(self.running()?.sum(value))
    }

    /// Largest of a number over the ranks; collective.
    fn max(&self, value: f64) -> PyResult<f64> {
        Ok(self.running()?.max(value))
    }

    /// Number of particles of this rank.
    #[getter]
    fn particle_count(&self) -> PyResult<usize> {
        Ok(self.running()?.dem().particles.owned)
    }

    /// An array over the particles of this rank.
    fn particles<'py>(&self, py: Python<'py>, name: &str) -> PyResult<Bound<'py, PyAny>> {
        let dem = self.running()?.dem();
        let (particles, leases) = (&dem.particles, &self.leases);
        let (bodies, loads, count) = (&particles.bodies, &particles.loads, particles.owned);
        match name {
            "id" => leases.numbers(py, &particles.ids, count, |id| id),
            "position" => leases.vectors(py, bodies, count, |b| &b.position.x),
            "velocity" => leases.vectors(py, bodies, count, |b| &b.velocity.x),
            "angular_velocity" => leases.vectors(py, bodies, count, |b| &b.angular_velocity.x),
            "radius" => leases.numbers(py, bodies, count, |b| &b.radius),
            "mass" => leases.numbers(py, bodies, count, |b| &b.mass),
            "force" => leases.vectors(py, loads, count, |l| &l.force.x),
            "torque" => leases.vectors(py, loads, count, |l| &l.torque.x),
            "temperature" if !particles.temperatures.is_empty() => {
                leases.numbers(py, &particles.temperatures, count, |t| t)
            }
            "temperature" => Err(CaseError::new_err("particles have no temperature; add a [heat] section")),
            "shape" => Ok(of_each(py, count, |i| bodies[i].kind.shape)),
            "material" => Ok(of_each(py, count, |i| bodies[i].kind.material)),
            "orientation" => {
                let rows: Vec<Vec<f64>> = (0..count).map(|i| dem.orientation_in_case(i).to_vec()).collect();
                let array = match rows.is_empty() {
                    true => PyArray2::zeros(py, [0, 4], false),
                    false => PyArray2::from_vec2(py, &rows)?,
                };
                Ok(array.into_any())
            }
            _ => Err(CaseError::new_err(format!("particles have no `{name}`"))),
        }
    }

    /// Names of the shapes and of the materials of the case.
    #[getter]
    fn names(&self) -> PyResult<(Vec<String>, Vec<String>)> {
        let case = self.running()?.case();
        let shapes = case.shapes.iter().map(|shape| shape.name.clone()).collect();
        Ok((shapes, case.materials.iter().map(|material| material.name.clone()).collect()))
    }

    /// The walls: name → position (m), velocity (m/s), force (N) and torque (N m) of the particles of this rank.
    fn walls<'py>(&self, py: Python<'py>) -> PyResult<Bound<'py, PyDict>> {
        let walls = PyDict::new(py);
        for view in self.running()?.walls() {
            let wall = PyDict::new(py);
            wall.set_item("displacement", <[f64; 3]>::from(view.state.translation))?;
            wall.set_item("velocity", <[f64; 3]>::from(view.state.velocity))?;
            wall.set_item("angular_velocity", <[f64; 3]>::from(view.state.angular_velocity))?;
            wall.set_item("force", <[f64; 3]>::from(view.load.force))?;
            wall.set_item("torque", <[f64; 3]>::from(view.load.torque))?;
            walls.set_item(view.name, wall)?;
        }
        Ok(walls)
    }

    /// A field of the own cells of the fluid, `[nz][ny][nx]`: `pressure`, `velocity_x` … on the upper faces, `void_fraction`, or
    /// a scalar; none without a fluid, or without such a field.
    fn fluid<'py>(&self, py: Python<'py>, name: &str) -> PyResult<Option<Bound<'py, PyAny>>> {
        let Some(view) = self.running()?.fluid() else { return Ok(None) };
        let (state, layout) = (&view.flow.state, view.flow.layout());
        let case = &self.running()?.case();
        let scalars = case.fluid.iter().flat_map(|fluid| &fluid.scalar);
        let mut names = scalars.map(|scalar| scalar.name.as_str());
        let data = match name {
            "pressure" => Some(state.pressure.data()),
            "velocity_x" => Some(state.velocity.component(0)),
            "velocity_y" => Some(state.velocity.component(1)),
            "velocity_z" => Some(state.velocity.component(2)),
            "void_fraction" => view.flow.mixture.as_ref().map(|mixture| mixture.void_fraction.data()),
            _ => names
                .position(|n| n == name)
                .zip(view.flow.scalars.as_ref())
                .map(|(k, s)| s.all[k].value.data()),
        };
        data.map(|data| self.leases.cells(py, data, layout)).transpose()
    }

    /// Coordinates of the faces between the own cells of the fluid along each axis (m); none without a fluid.
    fn fluid_nodes<'py>(&self, py: Python<'py>) -> PyResult<Option<Vec<Bound<'py, PyArray1<f64>>>>> {
        let Some(view) = self.running()?.fluid() else { return Ok(None) };
        let (first, cells) = (view.flow.first_cell(), view.flow.layout().cells);
        let nodes = |a: usize| {
            let nodes = view.flow.setup.grid.axis(a).nodes();
            PyArray1::from_slice(py, &nodes[first[a]..=first[a] + cells[a]])
        };
        Ok(Some((0..3).map(nodes).collect()))
    }

    /// Moves a wall otherwise from now on, by a motion in the words of the case (TOML, an inline table); all ranks together.
    fn set_wall_motion(&mut self, wall: &str, motion: Option<&str>) -> PyResult<()> {
        let running = self.changing()?;
        match motion {
            Some(motion) => running.set_wall_motion_as_in_case(wall, motion),
            None => running.set_wall_motion(wall, grains_simulation::Motion::Fixed),
        }
        .map_err(raised)
    }

    /// Lets in a velocity (m/s) through an inlet from now on; collective.
    fn set_inlet_velocity(&mut self, boundary: usize, velocity: [f64; 3]) -> PyResult<()> {
        self.changing()?.set_inflow(boundary, Inflow::Velocity(velocity)).map_err(raised)
    }

    /// Lets in a flow (kg/s or m³/s, as the case states it) through a flow inlet from now on; collective.
    fn set_inlet_flow(&mut self, boundary: usize, flow: f64) -> PyResult<()> {
        self.changing()?.set_inflow(boundary, Inflow::Flow(flow)).map_err(raised)
    }

    /// Inserts so many particles per batch, at intervals (s), the next at a time (s), now by default; collective.
    fn set_insertion(&mut self, name: &str, batch: u64, interval: f64, next: Option<f64>) -> PyResult<()> {
        self.changing()?.set_insertion(name, batch, interval, next).map_err(raised)
    }
}

/// A number of each particle.
fn of_each(py: Python<'_>, count: usize, of: impl Fn(usize) -> u16) -> Bound<'_, PyAny> {
    PyArray1::from_iter(py, (0..count).map(|i| i64::from(of(i)))).into_any()
}

/// What a simulation has done.
fn summary<'py>(py: Python<'py>, summary: &Summary) -> PyResult<Bound<'py, PyDict>> {
    let told = PyDict::new(py);
    told.set_item("ranks", summary.ranks)?;
    told.set_item("seconds", summary.seconds)?;
    told.set_item("steps", summary.steps)?;
    told.set_item("memory", summary.memory[0])?;
    told.set_item("inserted", summary.inserted)?;
    told.set_item("inside", summary.inside)?;
    told.set_item("left", summary.left)?;
    told.set_item("max_overlap", summary.worst_overlap)?;
    let phases = PyDict::new(py);
    for phase in &summary.phases {
        phases.set_item(&phase.name, phase.mean)?;
    }
    told.set_item("phases", phases)?;
    Ok(told)
}
