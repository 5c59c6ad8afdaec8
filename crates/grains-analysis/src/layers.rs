//! The fields of a flow that the grid resolves, summed over layers of cells.

use super::snapshots::StoredRun;
use super::sums::exact_sums;
use grains_comm::MpiTransport;
use grains_domain::Transport;
use grains_geometry::Vec3;
use grains_output::{GridBlock, GridSnapshotFile};
use grains_simulation::{RunError, agreed};
use std::ops::{AddAssign, Mul, Range};

/// Fields that are needed.
const FIELDS: [&str; 3] = ["velocity", "pressure", "void_fraction"];
/// Cells that are read at once: their fields take some ten megabytes.
const CELLS_AT_ONCE: usize = 1 << 18;

/// The stored states of the flow of a run.
pub struct FlowFile(GridSnapshotFile);

impl FlowFile {
    /// Opens the `fluid.vtkhdf` beside the stored particles; `what` is the analysis that wants it.
    ///
    /// # Errors
    /// No such file, or one that lacks a field, naming the key that stores it.
    pub fn open(run: &StoredRun, what: &str, transport: &MpiTransport) -> Result<Self, RunError> {
        let path = run.path.with_file_name("fluid.vtkhdf");
        let name = path.display();
        // Rank 0 looks: on a network file system the ranks may see different files for a while.
        if !transport.any(transport.rank() == 0 && path.exists()) {
            return Err(RunError::files(format!(
                "{name}: does not exist, but `analyse {what}` needs it: set output.particles or fluid.output.interval above 0 and run the case again"
            )));
        }
        let file = GridSnapshotFile::open(&path, transport.communicator())?;
        if let Some(field) = FIELDS.iter().find(|field| !file.fields().iter().any(|f| f == *field)) {
            return Err(RunError::case(format!(
                "{name}: lacks `{field}`, which `analyse {what}` needs: add \"{field}\" to fluid.output.fields of the case and run it again"
            )));
        }
        if file.times().is_empty() {
            return Err(RunError::files(format!("{name}: holds no state yet; wait for the first")));
        }
        Ok(Self(file))
    }

    /// Number and time (s) of the state nearest to a time (s).
    pub fn nearest(&self, time: f64) -> (usize, f64) {
        let times = self.0.times();
        let nearest =
            (0..times.len()).min_by(|&a, &b| (times[a] - time).abs().total_cmp(&(times[b] - time).abs()));
        let step = nearest.unwrap_or_default();
        (step, times[step])
    }

    /// Calls `visit` with indices, middle (m), volume (m³) and the values of some fields of every cell of this rank's share of a state;
    /// collective.
    ///
    /// # Errors
    /// A field that is not stored, or a damaged file.
    pub fn cells(
        &self,
        step: usize,
        fields: &[&str],
        transport: &MpiTransport,
        mut visit: impl FnMut([usize; 3], Vec3, f64, &[&[f64]]),
    ) -> Result<(), RunError> {
        for field in fields {
            if !self.0.fields().iter().any(|stored| stored == field) {
                let message = format!(
                    "fluid.vtkhdf lacks `{field}`: add it to fluid.output.fields and run the case again"
                );
                return Err(RunError::case(message));
            }
            self.0.verify(step, field, transport.communicator())?;
        }
        let nodes = self.0.nodes();
        let [nx, ny, nz] = nodes.each_ref().map(|nodes| nodes.len() - 1);
        let at = |a: usize, i: usize| 0.5 * (nodes[a][i] + nodes[a][i + 1]);
        let width = |a: usize, i: usize| nodes[a][i + 1] - nodes[a][i];
        let own = nz * transport.rank() / transport.size()..nz * (transport.rank() + 1) / transport.size();
        let at_once = (CELLS_AT_ONCE / (nx * ny)).max(1);
        let read = own.clone().step_by(at_once).try_for_each(|first| {
            let count = at_once.min(own.end - first);
            let block = GridBlock { all: [nx, ny, nz], first: [0, 0, first], own: [nx, ny, count] };
            let values: Vec<Vec<f64>> =
                fields.iter().map(|field| self.0.block(step, field, &block)).collect::<Result<_, _>>()?;
            for (c, (k, (j, i))) in (0..count)
                .flat_map(|k| (0..ny).flat_map(move |j| (0..nx).map(move |i| (k, (j, i)))))
                .enumerate()
            {
                let k = first + k;
                let of_cell: Vec<&[f64]> = values
                    .iter()
                    .map(|values| {
                        let n = values.len() / (nx * ny * count);
                        &values[n * c..n * (c + 1)]
                    })
                    .collect();
                let volume = width(0, i) * width(1, j) * width(2, k);
                visit([i, j, k], Vec3::new(at(0, i), at(1, j), at(2, k)), volume, &of_cell);
            }
            Ok::<_, RunError>(())
        });
        agreed(transport, read)
    }

    /// Nodes of the cells along the axes (m).
    pub fn nodes(&self) -> &[Vec<f64>; 3] {
        self.0.nodes()
    }

    /// The sums of a state over the layers normal to an axis; collective.
    ///
    /// # Errors
    /// A damaged file.
    pub fn layers(&self, step: usize, axis: usize, transport: &MpiTransport) -> Result<Vec<Layer>, RunError> {
        for field in FIELDS {
            self.0.verify(step, field, transport.communicator())?;
        }
        let nodes = self.0.nodes();
        let all = nodes.each_ref().map(|nodes| nodes.len() - 1);
        let read = |field: &str, range: Range<usize>| {
            let block = GridBlock { all, first: [0, 0, range.start], own: [all[0], all[1], range.len()] };
            self.0.block(step, field, &block).map_err(RunError::from)
        };
        layers(nodes, axis, read, transport)
    }
}

/// Sums over the cells of a layer, of volumes v and void fractions ε.
#[derive(Clone, Copy, Debug, Default, PartialEq)]
pub struct Layer {
    /// Where it begins and ends along the axis (m).
    pub ends: [f64; 2],
    /// Σ v (m³).
    pub volume: f64,
    /// Σ ε v (m³).
    pub fluid: f64,
    /// Σ p ε v (Pa m³).
    pub pressure: f64,
    /// Σ u ε v (m⁴/s).
    pub flux: Vec3,
    /// Σ |u| ε v (m⁴/s).
    pub speed: f64,
}

/// Number of sums of a layer.
const SUMS: usize = 7;

impl Layer {
    /// Middle along the axis (m).
    pub fn middle(&self) -> f64 {
        0.5 * (self.ends[0] + self.ends[1])
    }

    /// Void fraction ⟨ε⟩ = Σ ε v/Σ v (-)   (7.29, corrected).
    pub fn void_fraction(&self) -> f64 {
        self.fluid / self.volume
    }

    /// Mean pressure of the fluid ⟨p⟩ = Σ p ε v/Σ ε v (Pa)   (7.31, corrected); NaN without fluid.
    pub fn mean_pressure(&self) -> f64 {
        self.pressure / self.fluid
    }

    fn add_cell(&mut self, volume: f64, void: f64, pressure: f64, velocity: &Vec3) {
        let fluid = void * volume;
        self.volume += volume;
        self.fluid += fluid;
        self.pressure += pressure * fluid;
        self.flux += velocity * fluid;
        self.speed += velocity.norm() * fluid;
    }

    fn sums(&self) -> [f64; SUMS] {
        let [x, y, z] = self.flux.into();
        [self.volume, self.fluid, self.pressure, x, y, z, self.speed]
    }

    fn from_sums(ends: [f64; 2], sums: &[f64]) -> Self {
        let flux = Vec3::new(sums[3], sums[4], sums[5]);
        Self { ends, volume: sums[0], fluid: sums[1], pressure: sums[2], flux, speed: sums[6] }
    }
}

/// The part of a layer that its share of the thickness holds.
impl Mul<f64> for Layer {
    type Output = Self;

    fn mul(self, share: f64) -> Self {
        Self {
            ends: self.ends,
            volume: self.volume * share,
            fluid: self.fluid * share,
            pressure: self.pressure * share,
            flux: self.flux * share,
            speed: self.speed * share,
        }
    }
}

impl AddAssign for Layer {
    fn add_assign(&mut self, other: Self) {
        self.volume += other.volume;
        self.fluid += other.fluid;
        self.pressure += other.pressure;
        self.flux += other.flux;
        self.speed += other.speed;
    }
}

/// The sums over the part of some layers between two coordinates along their axis (m).
pub fn between(layers: &[Layer], ends: [f64; 2]) -> Layer {
    let mut sum = Layer { ends, ..Layer::default() };
    for layer in layers {
        let [from, to] = [layer.ends[0].max(ends[0]), layer.ends[1].min(ends[1])];
        if to > from {
            sum += *layer * ((to - from) / (layer.ends[1] - layer.ends[0]));
        }
    }
    sum
}

/// Sums over the layers of cells normal to an axis, on a grid of given nodes (m); `read` gives a field in some layers along z,
/// `[z][y][x][components]`. Each rank reads its share of these layers, some at a time.
///
/// What is added is sums over the parts of layers with one z, so that the ranks do not matter.
///
/// # Errors
/// Those of `read`.
pub fn layers(
    nodes: &[Vec<f64>; 3],
    axis: usize,
    read: impl Fn(&str, Range<usize>) -> Result<Vec<f64>, RunError>,
    transport: &impl Transport,
) -> Result<Vec<Layer>, RunError> {
    let [nx, ny, nz] = nodes.each_ref().map(|nodes| nodes.len() - 1);
    let width = |a: usize, k: usize| nodes[a][k + 1] - nodes[a][k];
    let own = nz * transport.rank() / transport.size()..nz * (transport.rank() + 1) / transport.size();
    let at_once = (CELLS_AT_ONCE / (nx * ny)).max(1);
    let mut parts: Vec<(usize, [f64; SUMS])> = Vec::new();
    let summed = own.clone().step_by(at_once).try_for_each(|first| {
        let range = first..(first + at_once).min(own.end);
        let [velocity, pressure, void] = FIELDS.map(|field| read(field, range.clone()));
        let (velocity, pressure, void) = (velocity?, pressure?, void?);
        for k in range.clone() {
            let mut of_layer = vec![Layer::default(); [nx, ny, 1][axis]];
            for j in 0..ny {
                for i in 0..nx {
                    let c = ((k - first) * ny + j) * nx + i;
                    let volume = width(0, i) * width(1, j) * width(2, k);
                    let u = Vec3::from_column_slice(&velocity[3 * c..3 * c + 3]);
                    of_layer[[i, j, 0][axis]].add_cell(volume, void[c], pressure[c], &u);
                }
            }
            let slots = of_layer.iter().enumerate();
            parts.extend(slots.map(|(slot, layer)| (if axis == 2 { k } else { slot }, layer.sums())));
        }
        Ok(())
    });
    agreed(transport, summed)?;
    let number = [nx, ny, nz][axis];
    let sums = exact_sums(transport, SUMS * number, |add| {
        parts.iter().for_each(|(slot, sums)| (0..SUMS).for_each(|s| add(SUMS * slot + s, sums[s])));
    });
    let ends = nodes[axis].windows(2).map(|pair| [pair[0], pair[1]]);
    Ok(ends.zip(sums.chunks_exact(SUMS)).map(|(ends, sums)| Layer::from_sums(ends, sums)).collect())
}
