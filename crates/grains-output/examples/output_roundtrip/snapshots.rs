//! Particles, walls and true surfaces whose values are known functions of particle and step.

use grains_output::{
    Bodies, Data, FieldSpec, FileError, Kind, Metadata, PolyDataFile, Precision, ReferenceSurface, Step,
    Tessellation, utc_now, write_shape, write_stl, write_view_script,
};
use mpi::topology::SimpleCommunicator;
use mpi::traits::{Communicator, CommunicatorCollectives};
use std::f64::consts::TAU;
use std::fmt::Write;
use std::path::Path;

/// Particles per step: growing, shrinking, none at the beginning, in the middle and twice in a row.
pub const COUNTS: [usize; 9] = [0, 7, 9000, 0, 0, 5, 3, 0, 20];

const FIELDS: [FieldSpec; 6] = [
    field("id", "-", 1, Kind::Integer),
    field("shape", "-", 1, Kind::Integer),
    field("scale", "-", 1, Kind::Real),
    field("orientation_wxyz", "-", 4, Kind::Real),
    field("velocity", "m/s", 3, Kind::Real),
    field("wall_force", "N", 1, Kind::Real),
];
const WALL_FIELDS: [FieldSpec; 2] =
    [field("wall", "-", 1, Kind::Integer), field("velocity", "m/s", 3, Kind::Real)];

const fn field(name: &'static str, unit: &'static str, components: usize, kind: Kind) -> FieldSpec {
    FieldSpec { name, unit, components, kind }
}

pub fn metadata(world: &SimpleCommunicator) -> Metadata {
    vec![
        ("program".into(), "grains-output test".into()),
        ("ranks".into(), world.size().to_string()),
        ("started".into(), utc_now()),
        // Longer than the 64 KiB of a compact attribute, and not only ASCII.
        ("case".into(), "[materials.glass] # ρ = 2500 kg/m³\n".repeat(4000)),
    ]
}

/// This rank's particles of a step: numbers, positions and fields. Rank 1 never has any.
#[derive(Default)]
struct Cloud {
    ids: Vec<i64>,
    shapes: Vec<i64>,
    points: Vec<f64>,
    scales: Vec<f64>,
    orientations: Vec<f64>,
    velocities: Vec<f64>,
    forces: Vec<f64>,
}

impl Cloud {
    fn new(count: usize, step: usize, world: &SimpleCommunicator) -> Self {
        let holders: Vec<i32> = (0..world.size()).filter(|&r| r != 1).collect();
        let place = holders.iter().position(|&r| r == world.rank());
        let own = place.map_or(0..0, |p| count * p / holders.len()..count * (p + 1) / holders.len());
        let mut cloud = Self::default();
        for g in own {
            let (x, t) = (g as f64, step as f64);
            let half = 0.5 * TAU * (0.1 * x + 0.05 * t);
            cloud.ids.push(g as i64);
            cloud.shapes.push((g % 2) as i64);
            cloud.points.extend([x, (0.3 * x + t).sin(), t]);
            cloud.scales.push(0.5 + 0.001 * x);
            cloud.orientations.extend([half.cos(), 0.0, 0.0, half.sin()]);
            cloud.velocities.extend([t, -x, x * t]);
            cloud.forces.push(x * x - t);
        }
        cloud
    }

    fn append_to(&self, file: &mut PolyDataFile, time: f64) {
        self.try_append_to(file, time).expect("a step is appended");
    }

    fn try_append_to(&self, file: &mut PolyDataFile, time: f64) -> Result<(), FileError> {
        let fields = [
            Data::Integer(&self.ids),
            Data::Integer(&self.shapes),
            Data::Real(&self.scales),
            Data::Real(&self.orientations),
            Data::Real(&self.velocities),
            Data::Real(&self.forces),
        ];
        let step = Step { time, points: &self.points, triangles: &[], fields: &fields };
        file.append(&step)
    }

    fn append_surfaces_to(&self, file: &mut PolyDataFile, time: f64) {
        let (vertices, triangles) = cube();
        let cube = ReferenceSurface { vertices: &vertices, triangles: &triangles };
        let tetrahedron = ReferenceSurface { vertices: &TETRAHEDRON.0, triangles: &TETRAHEDRON.1 };
        let bodies = Bodies {
            shape: &self.shapes,
            position: &self.points,
            orientation_wxyz: &self.orientations,
            scale: &self.scales,
        };
        let mut all = Tessellation::default();
        all.fill(&[cube, tetrahedron], &bodies);
        let (ids, velocities) = (all.per_triangle(&self.ids, 1), all.per_triangle(&self.velocities, 3));
        let fields = [Data::Integer(&ids), Data::Real(&velocities)];
        let step = Step { time, points: &all.points, triangles: &all.triangles, fields: &fields };
        file.append(&step).expect("surfaces are appended");
    }
}

const TETRAHEDRON: ([[f64; 3]; 4], [[u32; 3]; 4]) = (
    [[0.5, 0.5, 0.5], [0.5, -0.5, -0.5], [-0.5, 0.5, -0.5], [-0.5, -0.5, 0.5]],
    [[0, 1, 2], [0, 3, 1], [0, 2, 3], [1, 3, 2]],
);

/// A cube of edge 1 around the origin.
fn cube() -> ([[f64; 3]; 8], [[u32; 3]; 12]) {
    let corner = |k: usize| [k & 1, k >> 1 & 1, k >> 2].map(|bit| bit as f64 - 0.5);
    let faces = [
        [0, 2, 1],
        [1, 2, 3],
        [4, 5, 6],
        [5, 7, 6],
        [0, 1, 4],
        [1, 5, 4],
        [2, 6, 3],
        [3, 6, 7],
        [0, 4, 2],
        [2, 4, 6],
        [1, 3, 5],
        [3, 7, 5],
    ];
    (std::array::from_fn(corner), faces)
}

fn time(step: usize) -> f64 {
    0.25 * step as f64
}

/// Walls at a step, on rank 0 only: one that moves; none at steps 2 and 3; two from step 5 on.
fn append_walls(file: &mut PolyDataFile, step: usize, world: &SimpleCommunicator) {
    let count = match step {
        2 | 3 => 0,
        0..5 => 1,
        _ => 2,
    };
    let (mut points, mut triangles, mut walls, mut velocities) = (vec![], vec![], vec![], vec![]);
    if world.rank() == 0 {
        for wall in 0..count {
            let (z, first) = (0.1 * step as f64 + 5.0 * wall as f64, 4 * wall);
            points.extend([0.0, 0.0, z, 1.0, 0.0, z, 1.0, 1.0, z, 0.0, 1.0, z]);
            triangles.extend([0, 1, 2, 0, 2, 3].map(|k: i64| k + first));
            walls.extend([wall; 2]);
            velocities.extend([0.0, 0.0, 0.4, 0.0, 0.0, 0.4]);
        }
    }
    let fields = [Data::Integer(&walls), Data::Real(&velocities)];
    let step = Step { time: time(step), points: &points, triangles: &triangles, fields: &fields };
    file.append(&step).expect("walls are appended");
}

fn new_file(
    path: &Path,
    world: &SimpleCommunicator,
    is_surface: bool,
    format: (Precision, bool),
) -> PolyDataFile {
    let specs: &[FieldSpec] = match (is_surface, path.ends_with("walls.vtkhdf")) {
        (false, _) => &FIELDS,
        (true, true) => &WALL_FIELDS,
        (true, false) => &[FIELDS[0], FIELDS[4]],
    };
    PolyDataFile::create(path, world, specs, is_surface, format, &metadata(world)).expect("a file is created")
}

/// All kinds of files, with what a reader must find in them.
pub fn write_all(directory: &Path, world: &SimpleCommunicator) {
    for (name, format) in [
        ("particles", (Precision::F64, false)),
        ("short", (Precision::F32, false)),
        ("compressed", (Precision::F64, true)),
    ] {
        let mut file = new_file(&directory.join(format!("{name}.vtkhdf")), world, false, format);
        for (step, &count) in COUNTS.iter().enumerate() {
            Cloud::new(count, step, world).append_to(&mut file, time(step));
        }
        assert_eq!(file.steps(), COUNTS.len());
        expect(&directory.join(format!("{name}.json")), world, &COUNTS, &COUNTS);
    }
    let mut walls = new_file(&directory.join("walls.vtkhdf"), world, true, (Precision::F64, false));
    let mut surfaces = new_file(&directory.join("surfaces.vtkhdf"), world, true, (Precision::F32, true));
    for (step, &count) in COUNTS.iter().enumerate() {
        append_walls(&mut walls, step, world);
        Cloud::new(count, step, world).append_surfaces_to(&mut surfaces, time(step));
    }
    let of_walls = [1, 1, 0, 0, 1, 2, 2, 2, 2];
    expect(&directory.join("walls.json"), world, &of_walls.map(|n| 4 * n), &of_walls.map(|n| 2 * n));
    // Cubes are even, tetrahedra odd.
    let even = COUNTS.map(|n| n.div_ceil(2));
    let sum = |(cube, tetrahedron): (usize, usize)| {
        std::array::from_fn::<usize, 9, _>(|k| cube * even[k] + tetrahedron * (COUNTS[k] - even[k]))
    };
    expect(&directory.join("surfaces.json"), world, &sum((8, 4)), &sum((12, 4)));
    if world.rank() == 0 {
        write_shapes(directory);
    }
    world.barrier();
}

fn write_shapes(directory: &Path) {
    let shapes = directory.join("shapes");
    std::fs::create_dir_all(&shapes).expect("a folder for shapes");
    let (vertices, triangles) = cube();
    write_shape(&shapes.join("0-cube.vtp"), &vertices, &triangles).expect("a shape");
    write_shape(&shapes.join("1.vtp"), &TETRAHEDRON.0, &TETRAHEDRON.1).expect("a shape");
    let surface = ReferenceSurface { vertices: &vertices, triangles: &triangles };
    write_stl(&shapes.join("cube.stl"), "cube", surface).expect("an STL file");
    write_view_script(directory).expect("a script");
}

/// Writes what `scripts/readback.py` must find.
fn expect(path: &Path, world: &SimpleCommunicator, points: &[usize], cells: &[usize]) {
    if world.rank() != 0 {
        return;
    }
    let times: Vec<f64> = (0..points.len()).map(time).collect();
    let mut text = String::new();
    let _ = write!(text, "{{\"times\": {times:?}, \"points\": {points:?}, \"cells\": {cells:?}}}");
    std::fs::write(path, text).expect("the expectation is written");
}

/// A file continued after a step equals one written in one go.
pub fn resume(directory: &Path, world: &SimpleCommunicator) {
    for compress in [false, true] {
        let name = |kind: &str| directory.join(format!("{kind}-{compress}.vtkhdf"));
        let whole = name("whole");
        let mut file = new_file(&whole, world, false, (Precision::F64, compress));
        for (step, &count) in COUNTS.iter().enumerate() {
            Cloud::new(count, step, world).append_to(&mut file, time(step));
        }
        drop(file);
        for last in [0, 2, 4, 8] {
            let path = name(&format!("resumed-{last}"));
            let mut file = new_file(&path, world, false, (Precision::F64, compress));
            // What the killed run wrote after its last checkpoint is another future.
            for (step, &count) in COUNTS.iter().enumerate() {
                let other = if step < last { count } else { count / 2 + 1 };
                Cloud::new(other, step, world).append_to(&mut file, time(step));
            }
            drop(file);
            let again = |time| PolyDataFile::resume(&path, world, &FIELDS, false, Precision::F64, time);
            let mut file = again(time(last)).expect("the file is continued");
            assert_eq!(file.steps(), last + 1);
            file.record_restart(&metadata(world)).expect("the restart is noted");
            for (step, &count) in COUNTS.iter().enumerate().skip(last) {
                Cloud::new(count, step, world).append_to(&mut file, time(step));
            }
            drop(file);
            world.barrier();
            let other = PolyDataFile::resume(&path, world, &FIELDS[1..], false, Precision::F64, 1.0);
            let message = told(world, other.err());
            assert!(message.contains("it holds the arrays id, "), "{message}");
        }
    }
}

/// Appends until nothing fits any more: a clear error on all ranks, and the steps before can be read.
pub fn full_disk(directory: &Path, world: &SimpleCommunicator) {
    let mut file = new_file(&directory.join("full.vtkhdf"), world, false, (Precision::F64, false));
    let (count, mut steps) = (4000, 0);
    if world.rank() == 0 {
        std::fs::write(directory.join("ballast"), [0; 4096]).expect("there is room at first");
    }
    let error = loop {
        match Cloud::new(count, steps, world).try_append_to(&mut file, time(steps)) {
            Ok(()) => steps += 1,
            Err(error) => break error,
        }
    };
    let message = told(world, Some(error));
    // The last: the limit on the size of a file that stands for a full disk lets a probe pass.
    let cause = ["No space left", "write failed"];
    assert!(message.contains("full.vtkhdf") && cause.iter().any(|c| message.contains(c)), "{message}");
    assert!(steps > 1);
    let again = Cloud::new(count, steps, world).try_append_to(&mut file, time(steps));
    told(world, again.err());
    if world.rank() == 0 {
        // There is no room for the expectation beside the file.
        let _ = std::fs::remove_file(directory.join("ballast"));
    }
    let points = vec![count; steps];
    expect(&directory.join("full.json"), world, &points, &points);
}

/// Ends without closing anything, as a killed job does.
pub fn killed(directory: &Path, world: &SimpleCommunicator) {
    let mut file = new_file(&directory.join("killed.vtkhdf"), world, false, (Precision::F64, false));
    for (step, &count) in COUNTS.iter().enumerate().take(6) {
        Cloud::new(count, step, world).append_to(&mut file, time(step));
    }
    expect(&directory.join("killed.json"), world, &COUNTS[..6], &COUNTS[..6]);
    world.barrier();
    std::process::abort();
}

/// A folder that does not exist is named, on rank 0, and no rank waits for another.
pub fn missing_folder(directory: &Path, world: &SimpleCommunicator) {
    for (folder, reason) in [("nowhere", "the folder"), ("file", "Not a directory")] {
        if world.rank() == 0 && folder == "file" {
            std::fs::write(directory.join("file"), "").expect("a file");
        }
        world.barrier();
        let path = directory.join(folder).join("particles.vtkhdf");
        let format = (Precision::F64, false);
        let outcome = PolyDataFile::create(&path, world, &FIELDS, false, format, &metadata(world));
        let message = told(world, outcome.err());
        assert!(message.contains(reason) && message.contains(&path.display().to_string()), "{message}");
    }
}

/// The text of an error that all ranks met, from rank 0.
pub fn told(world: &SimpleCommunicator, error: Option<FileError>) -> String {
    use mpi::traits::Root;
    let error = error.expect("every rank meets the error");
    let mut bytes = error.to_string().into_bytes();
    bytes.resize(4096, b' ');
    world.process_at_rank(0).broadcast_into(&mut bytes[..]);
    String::from_utf8_lossy(&bytes).trim_end().to_string()
}
