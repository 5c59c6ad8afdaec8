//! Particles of data files and dumps come over as they are.

#![allow(clippy::unwrap_used)]

mod common;

use common::{Random, folder, imported};
use flate2::{Compression, write::GzEncoder};
use grains_case::ParticleColumns;
use grains_import::{Options, import};
use std::fs::{self, File};
use std::io::Write;
use std::path::PathBuf;

/// A particle: place, velocity, angular velocity, radius and density.
struct Grain {
    place: [f64; 3],
    velocity: [f64; 3],
    spin: [f64; 3],
    radius: f64,
    density: f64,
}

fn random_grains(count: usize, random: &mut Random) -> Vec<Grain> {
    let grain = |_| Grain {
        place: random.vector(0.09),
        velocity: random.vector(2.0),
        spin: random.vector(300.0),
        radius: random.magnitude(1e-4, 1e-2),
        density: [1000.0, 2500.0][usize::from(random.between(0.0, 1.0) > 0.5)],
    };
    (0..count).map(grain).collect()
}

fn words(numbers: &[f64]) -> String {
    numbers.iter().map(f64::to_string).collect::<Vec<_>>().join(" ")
}

fn data_file(grains: &[Grain]) -> String {
    let mut text = format!(
        "data of a test\n\n{} atoms\n1 atom types\n-0.1 0.1 xlo xhi\n-0.1 0.1 ylo yhi\n-0.1 0.1 zlo zhi\n\nAtoms # sphere\n\n",
        grains.len()
    );
    // In no order, and with periodic images.
    for (k, g) in grains.iter().enumerate().rev() {
        text += &format!("{} 1 {} {} {} 0 0 0\n", k + 1, 2.0 * g.radius, g.density, words(&g.place));
    }
    text += "\nVelocities\n\n";
    for (k, g) in grains.iter().enumerate() {
        text += &format!("{} {} {}\n", k + 1, words(&g.velocity), words(&g.spin));
    }
    text
}

const LAW: &str = "units si\natom_style sphere\nboundary f f f\nread_data grains.data
pair_style gran/hooke/history 1e5 NULL 100 NULL 0.5 1\npair_coeff * *\ntimestep 1e-6\nrun 10\n";

#[test]
fn a_data_file_becomes_the_table_of_a_case() {
    let home = folder("particles_data");
    let grains = random_grains(200, &mut Random(5));
    fs::write(home.join("grains.data"), data_file(&grains)).unwrap();
    let (case, done) = imported(&home, LAW);
    assert_eq!(done.particles, Some(200));
    let table = ParticleColumns::read_csv(&home.join("case/particles.csv")).unwrap();
    for (k, grain) in grains.iter().enumerate() {
        assert_eq!(table.position[k], grain.place);
        assert_eq!(table.velocity.as_ref().unwrap()[k], grain.velocity);
        assert_eq!(table.angular_velocity.as_ref().unwrap()[k], grain.spin);
        assert!((table.radius.as_ref().unwrap()[k] / grain.radius - 1.0).abs() < 1e-15);
        // Two densities of one type are two materials.
        let material = case.material_index(&table.material.as_ref().unwrap()[k]).unwrap();
        assert_eq!(case.materials[material].density, Some(grain.density));
    }
    assert_eq!(case.materials.len(), 2);
}

/// A dump of two frames, of which the later one counts; a state of a dump takes the place of that of the script.
fn dump(grains: &[Grain], time: bool) -> String {
    let mut text = String::new();
    for step in [0_u64, 500] {
        let clock = if time { format!("ITEM: TIME\n{}\n", step as f64 * 1e-3) } else { String::new() };
        text += &format!(
            "{clock}ITEM: TIMESTEP\n{step}\nITEM: NUMBER OF ATOMS\n{}\nITEM: BOX BOUNDS pp ff ff\n-0.1 0.1\n-0.1 0.1\n-0.1 0.1\nITEM: ATOMS vx vy vz type id x y z radius density omegax omegay omegaz f_heat\n",
            grains.len()
        );
        for (k, g) in grains.iter().enumerate().rev() {
            // The first frame is one box to the right of the last, which x is periodic along.
            let shift = if step == 0 { 0.2 } else { 0.0 };
            let place = [g.place[0] + shift, g.place[1], g.place[2]];
            text += &format!(
                "{} 1 {} {} {} {} {} {k}\n",
                words(&g.velocity),
                k + 1,
                words(&place),
                g.radius,
                g.density,
                words(&g.spin)
            );
        }
    }
    text
}

#[test]
fn a_dump_becomes_a_table_and_a_series_for_paraview() {
    let home = folder("particles_dump");
    let grains = random_grains(50, &mut Random(6));
    let text = dump(&grains, true);
    fs::write(home.join("plain.dump"), &text).unwrap();
    let mut packed = GzEncoder::new(File::create(home.join("packed.dump.gz")).unwrap(), Compression::fast());
    packed.write_all(text.as_bytes()).unwrap();
    packed.finish().unwrap();
    for name in ["plain.dump", "packed.dump.gz"] {
        let to = home.join(format!("from-{name}"));
        let done = import(&[home.join(name)], &to, &Options::default()).unwrap();
        assert_eq!((done.frames, done.particles), (2, Some(50)));
        let table = ParticleColumns::read_csv(&to.join("particles.csv")).unwrap();
        let places: Vec<[f64; 3]> = grains.iter().map(|g| g.place).collect();
        for (found, exact) in table.position.iter().zip(&places) {
            assert!((0..3).all(|a| (found[a] - exact[a]).abs() < 1e-15), "{found:?} {exact:?}");
        }
        let series = fs::read_to_string(to.join("particles.pvd")).unwrap();
        assert!(
            series.contains("timestep=\"0.5\"") && series.contains("particles-0000000500.vtp"),
            "{series}"
        );
        let all = fs::read_to_string(to.join("frames.csv")).unwrap();
        assert!(all.starts_with("step,time,vx,vy,vz,type,id,x,y,z,radius"), "{}", &all[..80]);
        assert_eq!(all.lines().count(), 101);
        assert_points(&fs::read(to.join("particles-0000000500.vtp")).unwrap(), &places);
    }
    // The first frame on its own, wrapped into the box.
    let options = Options { step: Some(0), ..Options::default() };
    import(&[home.join("plain.dump")], &home.join("first"), &options).unwrap();
    let table = ParticleColumns::read_csv(&home.join("first/particles.csv")).unwrap();
    assert!(table.position.iter().zip(&grains).all(|(p, g)| (p[0] - g.place[0]).abs() < 1e-12));
    let options = Options { step: Some(7), ..Options::default() };
    let error = import(&[home.join("plain.dump")], &home.join("none"), &options).unwrap_err();
    assert!(error.to_string().contains("no frame of step 7"), "{error}");
}

/// The first block of appended data are the points, and arrays lie where the header says.
fn assert_points(bytes: &[u8], places: &[[f64; 3]]) {
    let start = bytes.windows(2).position(|w| w == b"\n_").unwrap() + 2;
    let header = std::str::from_utf8(&bytes[..start]).unwrap();
    let block = |offset: usize| {
        let at = start + offset;
        let size = u64::from_le_bytes(bytes[at..at + 8].try_into().unwrap()) as usize;
        let number = |b: &[u8]| f64::from_le_bytes(b.try_into().unwrap());
        bytes[at + 8..at + 8 + size].chunks_exact(8).map(number).collect::<Vec<f64>>()
    };
    assert_eq!(block(0), places.concat());
    let heat = header.lines().find(|line| line.contains("\"f_heat\"")).unwrap();
    let offset = heat.split("offset=\"").nth(1).unwrap().split('"').next().unwrap().parse().unwrap();
    assert_eq!(block(offset), (0..places.len()).map(|k| k as f64).collect::<Vec<_>>());
}

#[test]
fn a_state_of_a_dump_takes_the_place_of_that_of_the_script() {
    let home = folder("particles_state");
    let (first, later) = (random_grains(20, &mut Random(7)), random_grains(20, &mut Random(8)));
    fs::write(home.join("grains.data"), data_file(&first)).unwrap();
    fs::write(home.join("in.script"), LAW).unwrap();
    fs::write(home.join("later.dump"), dump(&later, false)).unwrap();
    let files: Vec<PathBuf> = ["in.script", "later.dump"].iter().map(|name| home.join(name)).collect();
    import(&files, &home.join("case"), &Options::default()).unwrap();
    let table = ParticleColumns::read_csv(&home.join("case/particles.csv")).unwrap();
    assert!(table.position.iter().zip(&later).all(|(p, g)| (p[1] - g.place[1]).abs() < 1e-15));
}

#[test]
fn files_that_are_cut_or_wrong_are_refused_with_their_line() {
    let home = folder("particles_wrong");
    let grains = random_grains(5, &mut Random(9));
    let (data, frames) = (data_file(&grains), dump(&grains, false));
    let cut = frames.lines().take(20).collect::<Vec<_>>().join("\n");
    let rows = [
        (data.replace("5 atoms", "6 atoms"), ":1: 6 atoms are announced, and 5 are there"),
        (data.replacen("\n5 1 ", "\n5 1 2 8 ", 1), "12 columns, but atoms of style Sphere have 7"),
        (data.replace("# sphere", "# hybrid"), "write the state with `dump custom`"),
        (data.replace("xlo xhi", "xlo xhi\n0 0 0 xy xz yz"), "the box is tilted"),
        (cut, ":21: the file ends within a frame"),
        (frames.replace(" x y z ", " a b c "), "no coordinates among the columns"),
        (
            frames.replace("ITEM: NUMBER OF ATOMS\n5", "ITEM: NUMBER OF ATOMS\n4"),
            "where `ITEM:` must begin a section",
        ),
    ];
    for (text, message) in rows {
        let path = home.join("wrong");
        fs::write(&path, &text).unwrap();
        let error = import(&[path], &home.join("to"), &Options::default()).unwrap_err().to_string();
        assert!(error.contains(message), "{message}: {error}");
    }
}
