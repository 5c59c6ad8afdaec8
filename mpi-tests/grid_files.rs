//! Files of fields on the cells of a grid, written by blocks and read whole.

#![allow(clippy::unwrap_used)]

mod grids;
mod ranks;

use grains_comm::Job;
use grains_output::{
    Data, FieldSpec, FileError, GridBlock, GridFile, GridGeometry, GridSnapshotFile, Metadata, Precision,
};
use grids::{DEEP, RANKS, block, folder, places, rank, reals, text};
use mpi::traits::CommunicatorCollectives;
use ranks::on_ranks;
use std::fs;
use std::path::Path;

const SPECS: [FieldSpec; 3] = [
    FieldSpec::real("pressure", "Pa", 1),
    FieldSpec::real("velocity", "m/s", 3),
    FieldSpec::integer("count"),
];
/// Cells of a flow in the plane.
const FLAT: [usize; 3] = [13, 7, 1];

/// A grid of equal cells far from the origin.
fn uniform(job: &Job, all: [usize; 3]) -> GridGeometry {
    let axis = |n: usize, lower: f64, width: f64| (0..=n).map(|k| lower + width * k as f64).collect();
    let GridBlock { first, own, .. } = block(job, all);
    GridGeometry {
        nodes: [axis(all[0], 10.0, 0.1), axis(all[1], -3.0, 0.25), axis(all[2], 0.0, 0.5)],
        first,
        own,
    }
}

/// The same with cells that widen along y.
fn stretched(job: &Job, all: [usize; 3]) -> GridGeometry {
    let mut grid = uniform(job, all);
    grid.nodes[1] = (0..=all[1]).map(|k| 0.01 * (k as f64).powf(1.5)).collect();
    grid
}

fn append(file: &mut GridFile, grid: &GridGeometry, step: usize) {
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
    let whole = GridBlock { all, first: [0; 3], own: all };
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

/// What the specification wants of three steps of the flow in the plane, and what the XDMF file says of them.
fn assert_image(path: &Path, nodes: &[f64], precision: Precision, tolerance: f64) {
    let file = hdf5::File::open(path).unwrap();
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
    assert_eq!(file.dataset("grid/x").unwrap().read_raw::<f64>().unwrap(), nodes);
    let sidecar = fs::read_to_string(path.with_extension("xdmf")).unwrap();
    assert_well_formed(&sidecar);
    let bytes = if precision == Precision::F32 { 4 } else { 8 };
    let name = path.file_name().unwrap().to_str().unwrap();
    let velocity = format!("Precision=\"{bytes}\" Format=\"HDF\">{name}:/VTKHDF/CellData/velocity<");
    for (words, count) in [
        ("TopologyType=\"3DCoRectMesh\" Dimensions=\"2 8 14\"", 3),
        ("0.0 -3.0 10.0</DataItem>", 3),
        ("Center=\"Cell\"", 9),
        (">2 0 0 0 0 1 1 1 1 1 1 1 7 13 3</DataItem>", 1),
        ("<DataItem ItemType=\"HyperSlab\" Dimensions=\"1 7 13\"", 6),
        ("Dimensions=\"1 1 7 13\"", 2),
        ("Dimensions=\"3 1 7 13\"", 2),
        (&velocity, 3),
    ] {
        assert_eq!(sidecar.matches(words).count(), count, "{words} in {sidecar}");
    }
}

/// What is read back: each rank a block that others wrote.
fn assert_read_back(job: &Job, path: &Path, grid: &GridGeometry, tolerance: f64) {
    let file = GridSnapshotFile::open(path, job.world()).unwrap();
    assert_eq!((file.times(), file.nodes()), (&[0.0, 0.5, 1.0][..], &grid.nodes));
    assert!(["pressure", "velocity", "count"].iter().all(|name| file.fields().contains(&name.to_string())));
    let all = grid.cells();
    let wanted = GridBlock { all, first: [2, 1, 0], own: [all[0] - 2, all[1] - 1 - rank(job) % 2, all[2]] };
    for (name, width) in [("pressure", 1), ("velocity", 3)] {
        let (found, stored) = (file.block(2, name, &wanted).unwrap(), reals(&wanted, 2, width));
        assert_eq!(found.len(), stored.len());
        assert!(found.iter().zip(stored).all(|(a, b)| (a - b).abs() <= tolerance), "{name}");
    }
    assert!(file.block(3, "pressure", &wanted).is_err() && file.block(0, "density", &wanted).is_err());
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
            let (world, grid) = (job.world(), uniform(job, FLAT));
            let format = (precision, compress);
            let mut file = GridFile::create(&path, world, &grid, &SPECS, format, &metadata(job)).unwrap();
            (0..3).for_each(|step| append(&mut file, &grid, step));
            drop(file);
            world.barrier();
            assert_read_back(job, &path, &grid, tolerance);
            if rank(job) == 0 {
                assert_image(&path, &grid.nodes[0], precision, tolerance);
                let file = hdf5::File::open(&path).unwrap();
                assert_eq!(text(&file.group("grains-mpi").unwrap(), "ranks"), job.size().to_string());
            }
        }
    });
}

#[test]
fn unequal_cells_are_a_rectilinear_grid() {
    on_ranks(&RANKS, "unequal_cells_are_a_rectilinear_grid", |job| {
        let path = folder(job, "rectilinear").join("fluid.vtkhdf");
        let grid = stretched(job, DEEP);
        let format = (Precision::F64, false);
        let mut file = GridFile::create(&path, job.world(), &grid, &SPECS, format, &metadata(job)).unwrap();
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
        let world = job.world();
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
        let (world, format) = (job.world(), (Precision::F64, false));
        let good = uniform(job, DEEP);
        let create = |grid: &GridGeometry, specs: &[FieldSpec]| {
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
