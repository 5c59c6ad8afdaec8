//! Mistakes of an import: files that are none, in other encodings or units, and variables given in vain.

#![allow(clippy::unwrap_used)]

mod common;

use common::folder;
use grains_import::{Options, import};
use std::fs;

const DATA: &str = "data\n\n1 atoms\n1 atom types\n0 1 xlo xhi\n0 1 ylo yhi\n0 1 zlo zhi\n\nAtoms # sphere\n\n1 1 0.01 2500 0.5 0.5 0.5\n";

const DUMP: &str = "ITEM: TIMESTEP\n0\nITEM: NUMBER OF ATOMS\n1\nITEM: BOX BOUNDS f f f\n0 1\n0 1\n0 1\nITEM: ATOMS id type x y z radius\n1 1 0.5 0.5 0.5 0.005\n";

const SCRIPT: &str = "units si\natom_style sphere\nregion box block 0 1 0 1 0 1\ncreate_box 1 box\n";

fn utf_16(text: &str) -> Vec<u8> {
    [0xff, 0xfe].into_iter().chain(text.encode_utf16().flat_map(u16::to_le_bytes)).collect()
}

#[test]
fn files_that_are_none_are_named_with_what_to_give() {
    let home = folder("mistakes_files");
    let latin: Vec<u8> = DATA.replace("data\n", "K\u{f6}rner\n").chars().map(|c| c as u8).collect();
    let rows: [(&str, &str, Vec<u8>, &str); 21] = [
        ("a script in UTF-16", "in.a", utf_16(SCRIPT), "save it in UTF-8"),
        ("data in UTF-16", "a.data", utf_16(DATA), "save it in UTF-8"),
        ("a dump in UTF-16", "a.dump", utf_16(DUMP), "save it in UTF-8"),
        ("data in Latin-1", "b.data", latin, "iconv -f latin1"),
        ("line ends of old Macs", "in.b", SCRIPT.replace('\n', "\r").into(), "carriage return alone"),
        ("an empty file", "in.c", Vec::new(), "the file is empty"),
        ("a file of blank lines", "in.d", b"\n\n".to_vec(), "the file is empty"),
        ("a case", "case.toml", b"[domain]\nlower = [0, 0, 0]\n".to_vec(), "in TOML"),
        ("a mesh", "m.stl", b"solid m\nfacet normal 0 0 1\n".to_vec(), "a mesh (STL)"),
        ("a table", "p.csv", b"x,y,z\n1,2,3\n".to_vec(), "a table (CSV)"),
        ("a binary restart", "restart.1", vec![7, 0, 1, 0, 2, 0], "`write_data` or `dump custom`"),
        ("a program in Python", "a.py", b"import numpy\nprint(1)\n".to_vec(), "is no command of LAMMPS"),
        ("a file that is not packed", "a.dump.gz", DUMP.into(), "drop .gz from its name"),
        ("units real", "in.e", SCRIPT.replace("units si", "units real").into(), "units real"),
        ("units metal", "in.f", SCRIPT.replace("units si", "units metal").into(), "convert its numbers"),
        ("decimal commas in data", "c.data", DATA.replace("0.01", "0,01").into(), "decimals have a point"),
        ("a size below 0 in data", "d.data", DATA.replace("0.01", "-0.01").into(), "must be above 0"),
        ("a density of 0 in data", "e.data", DATA.replace("2500", "0").into(), "must be above 0"),
        ("a size below 0 in a dump", "d.dump", DUMP.replace("0.005", "-0.005").into(), "must be above 0"),
        ("a size of 0 in a dump", "e.dump", DUMP.replace("0.005", "0").into(), "must be above 0"),
        ("decimal commas in a dump", "c.dump", DUMP.replace("0.5", "0,5").into(), "decimals have a point"),
    ];
    for (what, name, bytes, words) in rows {
        let path = home.join(name);
        fs::write(&path, &bytes).unwrap();
        let error = import(&[path], &home.join("to"), &Options::default()).expect_err(what).to_string();
        println!("| {what} | {} |", error.replace(&format!("{}/", home.display()), ""));
        assert!(error.contains(name) && error.contains(words), "{what}: {error}");
    }
    fs::write(home.join("a.data"), DATA).unwrap();
    let error = import(&[home.join("a.data")], &home.join("a.py"), &Options::default()).unwrap_err();
    assert!(error.to_string().contains("name a folder"), "{error}");
}

#[test]
fn marks_before_a_text_and_line_ends_of_windows_do_no_harm() {
    let home = folder("mistakes_marks");
    for (name, text) in [("a.data", DATA), ("a.dump", DUMP)] {
        for changed in [format!("\u{feff}{text}"), text.replace('\n', "\r\n")] {
            fs::write(home.join(name), changed).unwrap();
            let imported = import(&[home.join(name)], &home.join("to"), &Options::default()).unwrap();
            assert_eq!((imported.particles, imported.warnings.len()), (Some(1), 0), "{name}");
        }
    }
    let without = DUMP.replace(" radius", "").replace(" 0.005", "");
    fs::write(home.join("b.dump"), without).unwrap();
    let imported = import(&[home.join("b.dump")], &home.join("to"), &Options::default()).unwrap();
    assert!(imported.warnings[0].contains("dump the column radius"), "{:?}", imported.warnings);
}

#[test]
fn what_is_given_in_vain_or_left_out_is_told() {
    let home = folder("mistakes_vain");
    let text = SCRIPT.replace("units si\n", "") + "timestep 1e-5\nread_data a.data add append\nrun 100\n";
    fs::write(home.join("a.data"), DATA).unwrap();
    fs::write(home.join("in.a"), text).unwrap();
    let options = Options { variables: vec![("speeed".into(), "1".into())], ..Options::default() };
    // Whether it makes a case or not, the report says so.
    let _ = import(&[home.join("in.a")], &home.join("to"), &options);
    let report = fs::read_to_string(home.join("to/import.txt")).unwrap();
    for words in ["--var speeed: without effect", "has no `units`"] {
        assert!(report.contains(words), "{words}: {report}");
    }
}

#[test]
fn numbers_of_steps_that_cannot_be_are_refused_by_the_command() {
    let home = folder("mistakes_steps");
    fs::write(home.join("a.data"), DATA).unwrap();
    for steps in ["-5", "1e300", "nan"] {
        let text =
            format!("{SCRIPT}timestep 1e-5\nread_data a.data add append\nrun 10\nrun {steps}\nrun 10\n");
        fs::write(home.join("in.a"), text).unwrap();
        // Whether it makes a case or not, the report says so.
        let _ = import(&[home.join("in.a")], &home.join("to"), &Options::default());
        let report = fs::read_to_string(home.join("to/import.txt")).unwrap();
        assert!(report.contains("steps: must be between 0 and 9e15"), "{steps}: {report}");
    }
}

#[test]
fn sizes_and_densities_that_no_body_has_are_refused_wherever_they_are_given() {
    let home = folder("mistakes_sizes");
    let region = "region r block 0 .1 0 .1 0 .1 units box";
    let template = |style: &str| format!("fix t all particletemplate/{style}");
    for value in ["0", "-1e-3", "1e-3-2e-3"] {
        let commands = [
            format!("{region}\nfix p all pour 9 1 7 region r diam one {value} dens 2500 2500"),
            format!("{region}\nfix p all pour 9 1 7 region r diam range {value} 1e-3 dens 2500 2500"),
            format!("{region}\nfix p all pour 9 1 7 region r diam one 1e-3 dens {value} {value}"),
            format!("{} 1 atom_type 1 density constant {value} radius constant 1e-3", template("sphere")),
            format!("{} 1 atom_type 1 density constant 2500 radius constant {value}", template("sphere")),
            format!(
                "{} 1 atom_type 1 density constant 2500 shape constant 1e-3 {value} 1e-3 blockiness constant 2 2",
                template("superquadric")
            ),
            format!(
                "{} 1 atom_type 1 density constant 2500 nspheres 1 ntry 9 spheres 0 0 0 {value} type 1",
                template("multisphere")
            ),
            format!("set type 1 density {value}"),
            format!("set type 1 diameter {value}"),
        ];
        for command in commands {
            fs::write(home.join("a.data"), DATA).unwrap();
            fs::write(
                home.join("in.a"),
                format!("{SCRIPT}read_data a.data add append\ntimestep 1e-5\n{command}\nrun 10\n"),
            )
            .unwrap();
            let _ = import(&[home.join("in.a")], &home.join("to"), &Options::default());
            let report = fs::read_to_string(home.join("to/import.txt")).unwrap();
            assert!(report.contains("must be above 0"), "{command}: {report}");
        }
    }
}
