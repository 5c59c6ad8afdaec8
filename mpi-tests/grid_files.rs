//! Fields of cells and arrays on grids: written by blocks on some ranks, read on others.

#![allow(clippy::unwrap_used)]

mod ranks;

use grains_comm::Job;
use grains_output::{
    Array, Block, CheckpointFile, Data, FieldSpec, FileError, Grid, GridArray, GridFile, Metadata, Precision,
    Values, agree, latest_valid, write_checkpoint,
};
use mpi::traits::{Communicator, CommunicatorCollectives};
use ranks::on_ranks;
use std::fs;
use std::path::{Path, PathBuf};

const RANKS: [usize; 4] = [1, 2, 3, 8];
const SPECS: [FieldSpec; 3] = [
    FieldSpec::real("pressure", "Pa", 1),
    FieldSpec::real("velocity", "m/s", 3),
    FieldSpec::integer("count"),
];
/// Cells of the uniform grid; along z as in a flow in the plane.
const FLAT: [usize; 3] = [13, 7, 1];
const DEEP: [usize; 3] = [5, 6, 9];

fn rank(job: &Job) -> usize {
    job.world().rank() as usize
}

/// A folder of this test and these ranks, empty.
fn folder(job: &Job, test: &str) -> PathBuf {
    let path = Path::new(env!("CARGO_TARGET_TMPDIR")).join(format!("{test}-{}", job.size()));
    if rank(job) == 0 {
        let _ = fs::remove_dir_all(&path);
        fs::create_dir_all(&path).unwrap();
    }
    job.world().barrier();
    path
}

/// This rank's block: x cut in two where there are ranks enough, y among the rest, unevenly; the ranks
/// beyond the cells of y have none.
fn block(job: &Job, all: [usize; 3]) -> Block {
    block_of(all, rank(job), job.size())
}

fn block_of(all: [usize; 3], rank: usize, size: usize) -> Block {
    let columns = if size.is_multiple_of(2) { 2 } else { 1 };
    let (column, row, rows) = (rank % columns, rank / columns, size / columns);
    let cut = |n: usize, k: usize, parts: usize| if k == parts { n } else { (n + 1) * k / (parts + 1) };
    let ends = |n, k, parts| (cut(n, k, parts), cut(n, k + 1, parts));
    let (x, y) = (ends(all[0], column, columns), ends(all[1], row, rows));
    Block { all, first: [x.0, y.0, 0], own: [x.1 - x.0, y.1 - y.0, all[2]] }
}

/// A grid of equal cells far from the origin.
fn uniform(job: &Job, all: [usize; 3]) -> Grid {
    let axis = |n: usize, lower: f64, width: f64| (0..=n).map(|k| lower + width * k as f64).collect();
    let Block { first, own, .. } = block(job, all);
    Grid { nodes: [axis(all[0], 10.0, 0.1), axis(all[1], -3.0, 0.25), axis(all[2], 0.0, 0.5)], first, own }
}

/// The same with cells that widen along y.
fn stretched(job: &Job, all: [usize; 3]) -> Grid {
    let mut grid = uniform(job, all);
    grid.nodes[1] = (0..=all[1]).map(|k| 0.01 * (k as f64).powf(1.5)).collect();
    grid
}

/// A number for every value of a field, in every place of the grid and every step.
fn value(step: usize, place: usize, component: usize) -> f64 {
    (place as f64 * 1.37 + component as f64 * 0.11).sin() + 10.0 * step as f64
}

/// Places in the whole array, in the order of a block's values.
fn places(block: &Block) -> Vec<usize> {
    let Block { all, first, own } = *block;
    let mut list = Vec::new();
    for k in first[2]..first[2] + own[2] {
        for j in first[1]..first[1] + own[1] {
            list.extend((first[0]..first[0] + own[0]).map(|i| (k * all[1] + j) * all[0] + i));
        }
    }
    list
}

fn reals(block: &Block, step: usize, width: usize) -> Vec<f64> {
    places(block).iter().flat_map(|&place| (0..width).map(move |c| value(step, place, c))).collect()
}

fn append(file: &mut GridFile, grid: &Grid, step: usize) {
    let block = grid.block();
    let (pressure, velocity) = (reals(&block, step, 1), reals(&block, step, 3));
    let count: Vec<i64> = places(&block).iter().map(|&place| (place * 7 + step) as i64).collect();
    let fields = [Data::Real(&pressure), Data::Real(&velocity), Data::Integer(&count)];
    file.append(0.5 * step as f64, &fields).unwrap();
}

fn metadata(job: &Job) -> Metadata {
    vec![("program".into(), "test".into()), ("ranks".into(), job.size().to_string())]
}

/// The whole of a field of a file of `steps` steps, checked; `tolerance` is that of its precision.
fn assert_values(file: &hdf5::File, all: [usize; 3], steps: usize, tolerance: f64) {
    let [x, y, z] = all;
    let whole = Block { all, first: [0; 3], own: all };
    for (name, width) in [("pressure", 1), ("velocity", 3)] {
        let dataset = file.dataset(&format!("VTKHDF/CellData/{name}")).unwrap();
        let shape = [steps, z, y, x, width];
        assert_eq!(dataset.shape(), shape[..if width == 1 { 4 } else { 5 }], "{name}");
        let wanted: Vec<f64> = (0..steps).flat_map(|step| reals(&whole, step, width)).collect();
        let found = dataset.read_raw::<f64>().unwrap();
        let worst = found.iter().zip(&wanted).fold(0.0_f64, |worst, (a, b)| worst.max((a - b).abs()));
        assert!(worst <= tolerance, "{name}: off by {worst}");
        assert_eq!(text(&dataset, "unit"), if width == 1 { "Pa" } else { "m/s" });
    }
    let counts = file.dataset("VTKHDF/CellData/count").unwrap().read_raw::<i64>().unwrap();
    let wanted = (0..steps).flat_map(|step| places(&whole).into_iter().map(move |place| place * 7 + step));
    assert!(counts.iter().map(|&n| n as usize).eq(wanted));
}

fn text(object: &hdf5::Location, name: &str) -> String {
    let attribute = object.attr(name).unwrap();
    match attribute.dtype().unwrap().to_descriptor().unwrap() {
        hdf5::types::TypeDescriptor::FixedAscii(length) => {
            let text = attribute.read_scalar::<hdf5::types::FixedAscii<16>>().unwrap().to_string();
            assert_eq!(text.len(), length, "`{name}` is not padded: readers compare its bytes");
            text
        }
        _ => attribute.read_scalar::<hdf5::types::VarLenUnicode>().unwrap().to_string(),
    }
}

fn numbers(object: &hdf5::Location, name: &str) -> Vec<f64> {
    object.attr(name).unwrap().read_raw::<f64>().unwrap()
}

/// What the specification of VTKHDF wants of every temporal file of cells.
fn assert_steps(root: &hdf5::Group, steps: usize) {
    let group = root.group("Steps").unwrap();
    assert_eq!(group.attr("NSteps").unwrap().read_scalar::<i64>().unwrap(), steps as i64);
    let times: Vec<f64> = (0..steps).map(|step| 0.5 * step as f64).collect();
    let values = group.dataset("Values").unwrap();
    assert_eq!((values.read_raw::<f64>().unwrap(), text(&values, "unit")), (times, "s".to_string()));
    let rising: Vec<i64> = (0..steps as i64).collect();
    for spec in SPECS {
        let offsets = group.dataset(&format!("CellDataOffsets/{}", spec.name)).unwrap();
        assert_eq!(offsets.read_raw::<i64>().unwrap(), rising);
    }
}

/// Whether the tags of an XML text are well-formed: opened and closed in order, attributes quoted.
fn assert_well_formed(text: &str) {
    let mut open = Vec::new();
    let mut rest = text;
    while let Some(start) = rest.find('<') {
        let end = start + rest[start..].find('>').unwrap();
        let tag = &rest[start + 1..end];
        rest = &rest[end + 1..];
        let name = tag.trim_start_matches('/').split([' ', '/']).next().unwrap();
        if tag.starts_with(['?', '!']) {
            continue;
        }
        assert!(tag.matches('"').count().is_multiple_of(2), "{tag}");
        if tag.starts_with('/') {
            assert_eq!(open.pop(), Some(name), "{tag}");
        } else if !tag.ends_with('/') {
            open.push(name);
        }
    }
    assert!(open.is_empty(), "{open:?}");
}

#[test]
fn equal_cells_are_image_data() {
    on_ranks(&RANKS, "equal_cells_are_image_data", |job| {
        let folder = folder(job, "image");
        for (name, precision, compress, tolerance) in [
            ("plain", Precision::F64, false, 0.0),
            ("deflated", Precision::F64, true, 0.0),
            ("short", Precision::F32, true, 2e-6),
        ] {
            let path = folder.join(format!("{name}.vtkhdf"));
            let grid = uniform(job, FLAT);
            let format = (precision, compress);
            let mut file =
                GridFile::create(&path, &job.world(), &grid, &SPECS, format, &metadata(job)).unwrap();
            (0..3).for_each(|step| append(&mut file, &grid, step));
            drop(file);
            job.world().barrier();
            if rank(job) != 0 {
                continue;
            }
            let file = hdf5::File::open(&path).unwrap();
            let root = file.group("VTKHDF").unwrap();
            assert_eq!(text(&root, "Type"), "ImageData");
            assert_eq!(numbers(&root, "Version"), [2.0, 0.0]);
            assert_eq!(numbers(&root, "WholeExtent"), [0.0, 13.0, 0.0, 7.0, 0.0, 1.0]);
            assert_eq!(numbers(&root, "Origin"), [10.0, -3.0, 0.0]);
            let widths = numbers(&root, "Spacing");
            assert!(widths.iter().zip([0.1, 0.25, 0.5]).all(|(a, b)| (a - b).abs() < 1e-14), "{widths:?}");
            assert_eq!(numbers(&root, "Direction"), [1.0, 0.0, 0.0, 0.0, 1.0, 0.0, 0.0, 0.0, 1.0]);
            assert_steps(&root, 3);
            assert_values(&file, FLAT, 3, tolerance);
            assert_eq!(file.dataset("grid/x").unwrap().read_raw::<f64>().unwrap(), grid.nodes[0]);
            assert_eq!(text(&file.group("grains-mpi").unwrap(), "ranks"), job.size().to_string());
            let sidecar = fs::read_to_string(path.with_extension("xdmf")).unwrap();
            assert_well_formed(&sidecar);
            for (words, count) in [
                ("TopologyType=\"3DCoRectMesh\" Dimensions=\"2 8 14\"", 3),
                ("0.0 -3.0 10.0</DataItem>", 3),
                ("Center=\"Cell\"", 9),
                (">2 0 0 0 0 1 1 1 1 1 1 1 7 13 3</DataItem>", 1),
                ("Dimensions=\"3 1 7 13\"", 6),
            ] {
                assert_eq!(sidecar.matches(words).count(), count, "{words} in {sidecar}");
            }
            let bytes = if precision == Precision::F32 { 4 } else { 8 };
            assert_eq!(
                sidecar
                    .matches(&format!(
                        "Precision=\"{bytes}\" Format=\"HDF\">{name}.vtkhdf:/VTKHDF/CellData/velocity"
                    ))
                    .count(),
                3
            );
        }
    });
}

#[test]
fn unequal_cells_are_a_rectilinear_grid() {
    on_ranks(&RANKS, "unequal_cells_are_a_rectilinear_grid", |job| {
        let path = folder(job, "rectilinear").join("fluid.vtkhdf");
        let grid = stretched(job, DEEP);
        let format = (Precision::F64, false);
        let mut file = GridFile::create(&path, &job.world(), &grid, &SPECS, format, &metadata(job)).unwrap();
        (0..2).for_each(|step| append(&mut file, &grid, step));
        drop(file);
        job.world().barrier();
        if rank(job) != 0 {
            return;
        }
        let file = hdf5::File::open(&path).unwrap();
        let root = file.group("VTKHDF").unwrap();
        assert_eq!(text(&root, "Type"), "RectilinearGrid");
        assert_eq!(numbers(&root, "Version"), [2.0, 7.0]);
        assert_eq!(numbers(&root, "Dimensions"), [6.0, 7.0, 10.0]);
        for (nodes, axis) in grid.nodes.iter().zip(["X", "Y", "Z"]) {
            let found = root.dataset(&format!("{axis}Coordinates")).unwrap().read_raw::<f64>().unwrap();
            assert_eq!(&found, nodes);
            let offsets = root.dataset(&format!("Steps/{axis}CoordinatesOffsets")).unwrap();
            assert_eq!(offsets.read_raw::<i64>().unwrap(), [0, 0]);
        }
        assert_steps(&root, 2);
        assert_values(&file, DEEP, 2, 0.0);
        let sidecar = fs::read_to_string(path.with_extension("xdmf")).unwrap();
        assert_well_formed(&sidecar);
        for words in [
            "TopologyType=\"3DRectMesh\" Dimensions=\"10 7 6\"",
            "GeometryType=\"VXVYVZ\"",
            "Dimensions=\"7\" NumberType=\"Float\" Precision=\"8\" Format=\"HDF\">fluid.vtkhdf:/grid/y</DataItem>",
        ] {
            assert_eq!(sidecar.matches(words).count(), 2, "{words} in {sidecar}");
        }
    });
}

#[test]
fn a_file_is_continued_on_other_ranks_and_replaces_what_came_after() {
    // What one number of ranks has begun the next continues.
    let test = "a_file_is_continued_on_other_ranks_and_replaces_what_came_after";
    let path = Path::new(env!("CARGO_TARGET_TMPDIR")).join("continued.vtkhdf");
    let short = (Precision::F32, true);
    on_ranks(&RANKS, test, |job| {
        let grid = stretched(job, DEEP);
        let world = &job.world();
        let mut file = if job.size() == 1 {
            GridFile::create(&path, world, &grid, &SPECS, short, &metadata(job)).unwrap()
        } else {
            // Kept are the steps up to 2 = at 1.0 s; those after come from the run before.
            let file = GridFile::resume(&path, world, &grid, &SPECS, Precision::F32, 1.0).unwrap();
            world.barrier();
            if rank(job) == 0 {
                let sidecar = fs::read_to_string(path.with_extension("xdmf")).unwrap();
                assert_eq!(sidecar.matches("<Time").count(), 3, "the sidecar is cut as well");
            }
            world.barrier();
            file.record_restart(&metadata(job)).unwrap();
            file
        };
        // The step of the restart is written again, and replaces itself.
        let first = if job.size() == 1 { 0 } else { 2 };
        (first..6).for_each(|step| append(&mut file, &grid, step));
        drop(file);
        world.barrier();
        if rank(job) == 0 {
            let file = hdf5::File::open(&path).unwrap();
            assert_steps(&file.group("VTKHDF").unwrap(), 6);
            assert_values(&file, DEEP, 6, 2e-5);
            let restarts = file.group("grains-mpi").unwrap().member_names().unwrap().len();
            assert_eq!(restarts, RANKS.iter().position(|&n| n == job.size()).unwrap());
            let sidecar = fs::read_to_string(path.with_extension("xdmf")).unwrap();
            assert_eq!(sidecar.matches("<Time").count(), 6);
        }
        world.barrier();
        // Another grid, precision or set of fields is refused on all ranks, and nothing is lost.
        let other = uniform(job, DEEP);
        let refused = [
            (GridFile::resume(&path, world, &other, &SPECS, Precision::F32, 1.0), "another grid"),
            (GridFile::resume(&path, world, &grid, &SPECS, Precision::F64, 1.0), "precision"),
            (GridFile::resume(&path, world, &grid, &SPECS[..2], Precision::F32, 1.0), "holds the arrays"),
        ];
        for (outcome, words) in refused {
            let message = outcome.err().unwrap().to_string();
            assert!(rank(job) > 0 || message.contains(words), "{message}");
        }
    });
}

#[test]
fn blocks_and_fields_that_do_not_fit_are_refused() {
    on_ranks(&[1, 3], "blocks_and_fields_that_do_not_fit_are_refused", |job| {
        let path = folder(job, "unfit").join("fluid.vtkhdf");
        let (world, format) = (&job.world(), (Precision::F64, false));
        let good = uniform(job, DEEP);
        let create = |grid: &Grid, specs: &[FieldSpec]| {
            GridFile::create(&path, world, grid, specs, format, &metadata(job))
        };
        let refused = |outcome: Result<GridFile, FileError>, words: &str| {
            let message = outcome.err().unwrap().to_string();
            assert!(rank(job) > 0 || message.contains(words), "{message}");
        };
        let mut few = good.clone();
        few.own[2] -= 1;
        refused(create(&few, &SPECS), "the blocks have 240 places, the grid of [5, 6, 9] has 270");
        let mut beyond = good.clone();
        beyond.first[0] += 1;
        refused(create(&beyond, &SPECS), "reaches beyond the grid");
        let mut folded = good.clone();
        folded.nodes[2][4] = folded.nodes[2][3];
        refused(create(&folded, &SPECS), "along z do not ascend");
        refused(create(&good, &[FieldSpec::real("stress", "Pa", 9)]), "9 components");
        // One rank alone has a field too short: all refuse the step, and the next one is written.
        let mut file = create(&good, &SPECS[..1]).unwrap();
        let values = reals(&good.block(), 0, 1);
        let short = &values[..values.len() - usize::from(rank(job) + 1 == job.size())];
        assert!(file.append(0.0, &[Data::Real(short)]).is_err());
        file.append(0.0, &[Data::Real(&values)]).unwrap();
    });
}

/// Arrays of a checkpoint: of cells, and of the faces normal to x, one more than cells.
fn grids(job: &Job) -> Vec<GridArray> {
    let array = |name, unit, width, all, step| {
        let block = block(job, all);
        GridArray { name, unit, width, block, values: reals(&block, step, width) }
    };
    vec![
        array("pressure", "Pa", 1, DEEP, 0),
        array("velocity_x", "m/s", 1, [DEEP[0] + 1, DEEP[1], DEEP[2]], 1),
        array("mean_velocity", "m/s", 3, DEEP, 2),
    ]
}

#[test]
fn arrays_on_grids_are_read_by_any_block_on_other_ranks() {
    let folder = Path::new(env!("CARGO_TARGET_TMPDIR")).join("grid-checkpoints");
    on_ranks(&RANKS, "arrays_on_grids_are_read_by_any_block_on_other_ranks", |job| {
        let world = &job.world();
        if job.size() == 1 {
            let _ = fs::remove_dir_all(&folder);
            fs::create_dir_all(&folder).unwrap();
        } else {
            // What the number of ranks before has written.
            let (file, refused) = latest_valid(&folder, world).unwrap();
            assert!(refused.is_empty(), "{refused:?}");
            assert_eq!(file.text("note"), Some("a grid"));
            for array in grids(job) {
                let read = agree(world, file.grid(array.name, array.width, &array.block)).unwrap();
                assert_eq!(read, array.values, "{}", array.name);
                let all = array.block.all;
                let one = Block { all, first: [3, 2, 8], own: [2, 1, 1] };
                let read = file.grid(array.name, array.width, &one).unwrap();
                let wanted = read.len() / array.width;
                assert_eq!(wanted, 2);
                let other = Block { all: [all[0] + 1, all[1], all[2]], ..one };
                let message = file.grid(array.name, array.width, &other).unwrap_err().to_string();
                assert!(message.contains("another grid"), "{message}");
            }
            assert!(file.has_grid("velocity_x") && !file.has_grid("velocity_y"));
            assert!(file.grid("velocity_y", 1, &block(job, DEEP)).is_err());
            assert_eq!(
                file.real("rows").unwrap().len(),
                12 * (rank(job) + 1) / job.size() - 12 * rank(job) / job.size()
            );
        }
        let rows = if rank(job) == 0 { vec![0.5; 12] } else { Vec::new() };
        let rows = [Array { name: "rows", unit: "-", width: 1, values: Values::Real(rows) }];
        let texts = vec![("note".to_string(), "a grid".to_string())];
        write_checkpoint(&folder, job.size() as u64, world, &rows, &grids(job), &texts).unwrap();
    });
    if std::env::var_os("GRAINS_TEST_ON_RANKS").is_some() {
        return;
    }
    // All ranks wrote the same bytes of state.
    let stored = |ranks: usize| {
        let file = hdf5::File::open(folder.join(format!("checkpoint-{ranks:012}.h5"))).unwrap();
        let contents = file.attr("contents").unwrap().read_scalar::<u64>().unwrap();
        let velocity = file.dataset("grids/velocity_x").unwrap();
        assert_eq!((velocity.shape(), text(&velocity, "unit")), (vec![9, 6, 6], "m/s".to_string()));
        assert_eq!(file.dataset("grids/mean_velocity").unwrap().shape(), [9, 6, 5, 3]);
        (contents, velocity.read_raw::<f64>().unwrap())
    };
    let first = stored(1);
    assert!(RANKS.iter().all(|&ranks| stored(ranks) == first));
}

#[test]
fn damaged_and_missing_arrays_on_grids_are_found() {
    on_ranks(&[1, 3], "damaged_and_missing_arrays_on_grids_are_found", |job| {
        let folder = folder(job, "damaged-grids");
        let world = &job.world();
        let refusal = |path: &Path| CheckpointFile::read(path, world).err().unwrap().to_string();
        let good = write_checkpoint(&folder, 1, world, &[], &grids(job), &Metadata::new()).unwrap();
        assert!(CheckpointFile::read(&good, world).is_ok());
        let damage = |name: &str, how: &dyn Fn(&hdf5::File)| {
            let path = folder.join(name);
            if rank(job) == 0 {
                fs::copy(&good, &path).unwrap();
                let file = hdf5::File::open_rw(&path).unwrap();
                how(&file);
                file.close().unwrap();
            }
            world.barrier();
            path
        };
        let exchanged = damage("exchanged.h5", &|file| {
            let dataset = file.dataset("grids/mean_velocity").unwrap();
            let mut values = dataset.read_raw::<f64>().unwrap();
            values.swap(100, 101);
            dataset.write_raw(&values).unwrap();
        });
        let message = refusal(&exchanged);
        assert!(rank(job) > 0 || message.contains("the checksum of `grids/mean_velocity`"), "{message}");
        let missing = damage("missing.h5", &|file| file.unlink("grids/pressure").unwrap());
        let message = refusal(&missing);
        assert!(rank(job) > 0 || message.contains("an array is missing"), "{message}");
        let none = damage("none.h5", &|file| file.unlink("grids").unwrap());
        let message = refusal(&none);
        assert!(rank(job) > 0 || message.contains("an array is missing"), "{message}");
        // Blocks that overlap are as many places as the grid has, but the sum of the hashes is another.
        let mut overlapping = grids(job);
        if job.size() == 3 && rank(job) == 1 {
            overlapping[0].block.first[1] -= 1;
        }
        let path = write_checkpoint(&folder, 2, world, &[], &overlapping, &Metadata::new()).unwrap();
        assert_eq!(CheckpointFile::read(&path, world).is_ok(), job.size() == 1);
        // A checkpoint without arrays on grids has no group of them, as those of earlier versions.
        let path = write_checkpoint(&folder, 3, world, &[], &[], &Metadata::new()).unwrap();
        assert!(!hdf5::File::open(&path).unwrap().link_exists("grids"));
        assert!(CheckpointFile::read(&path, world).is_ok_and(|file| !file.has_grid("pressure")));
    });
}
