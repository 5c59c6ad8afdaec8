//! The script beside the results, run by ParaView: the picture that a newcomer sees first.

#![allow(clippy::unwrap_used)]

mod common;

use common::{case, folder, replaced, run_case, skipped};
use std::fs;
use std::path::Path;
use std::process::Command;

/// Runs a script and says what the picture shows.
///
/// Coloured pixels are those of particles and fluid: walls, outlines and texts are grey.
const LOOK: &str = r#"
import sys
from paraview import simple as pv
from vtkmodules.vtkIOImage import vtkPNGReader
from vtkmodules.util.numpy_support import vtk_to_numpy

script, picture = sys.argv[1], sys.argv[2]
exec(compile(open(script).read(), script, "exec"), {"__file__": script, "__name__": "__main__"})
view = pv.GetActiveView()
scene = pv.GetAnimationScene()
glyphs = [d for d in view.Representations if getattr(d, "Representation", "") == "3D Glyphs"]
bars = [d for d in view.Representations if d.GetXMLName() == "ScalarBarWidgetRepresentation" and d.Visibility]
for glyph in glyphs:
    print("scale factor", glyph.ScaleFactor)
if glyphs:
    points = [source.GetDataInformation().GetNumberOfPoints() for source in [g.Input for g in glyphs] + [glyphs[0].Input.Input]]
    print("shown", sum(points[:-1]))
    print("particles", points[-1])
print("time", view.ViewTime)
print("bars", len(bars))
for glyph in glyphs[:1]:
    points = glyph.LookupTable.RGBPoints
    print("limits", points[0], points[-4])
print("up", *view.CameraViewUp)
reader = vtkPNGReader()
reader.SetFileName(picture)
reader.Update()
pixels = vtk_to_numpy(reader.GetOutput().GetPointData().GetScalars())[:, :3].astype(int)
width, height, _ = reader.GetOutput().GetDimensions()
rows = (pixels.max(axis=1) - pixels.min(axis=1) > 40).reshape(height, width)
# Without the bars at the sides; the first row is the lowest.
rows = rows[:, width // 8:-width // 8]
print("coloured", rows.mean())
print("lower", rows[:height // 2].sum() / rows.sum())
shades = pixels.reshape(height, width, 3)[:, width // 8:-width // 8][rows]
print("colours", len({tuple(shade) for shade in shades // 32}))
"#;

/// What [`LOOK`] says after a word, if ParaView is there.
fn look(home: &Path) -> Option<impl Fn(&str) -> Vec<f64> + use<>> {
    let is_there = |name: &str, argument: &str| Command::new(name).arg(argument).output().is_ok();
    if !is_there("pvbatch", "--version") {
        return None;
    }
    fs::write(home.join("look.py"), LOOK).unwrap();
    let has_screen = std::env::var_os("DISPLAY").is_some() || !is_there("xvfb-run", "--help");
    let mut command = if has_screen { Command::new("pvbatch") } else { Command::new("xvfb-run") };
    if !has_screen {
        // ParaView tries the display before it opens its window; a server that starts anew in between refuses the window.
        command.args(["-a", "-s", "-noreset -screen 0 1280x1024x24", "pvbatch"]);
    }
    let files = [home.join("look.py"), home.join("results/view.py"), home.join("picture.png")];
    let output = command.args(files).output().unwrap();
    let text = String::from_utf8_lossy(&output.stdout).into_owned();
    let complaints = String::from_utf8_lossy(&output.stderr).into_owned();
    assert!(output.status.success() && !complaints.contains("Traceback"), "{text}\n{complaints}");
    Some(move |word: &str| {
        let found = text.lines().filter_map(|line| line.strip_prefix(word));
        found.flat_map(str::split_whitespace).map(|x| x.parse().unwrap()).collect()
    })
}

#[test]
fn the_script_shows_the_last_state_at_true_size_from_the_side() {
    let tilted = replaced(&case("silo.toml"), "seed = 3", "seed = 3\ngravity = [0, -0.5, -9.8]");
    for (name, text, end, bars) in [
        ("silo", case("silo.toml"), 0.24, 1.0),
        ("tilted", tilted, 0.24, 1.0),
        ("bed", case("bed.toml"), 0.03, 2.0),
        ("resolved", case("resolved.toml"), 0.12, 2.0),
        ("duct", case("duct.toml"), f64::NAN, 1.0),
    ] {
        let home = folder(&format!("view_{name}"));
        run_case(2, &home, &text, &[]).succeeded();
        let Some(seen) = look(&home) else {
            return skipped("view", "no pvbatch: the script for ParaView is not run");
        };
        assert!(seen("scale factor").iter().all(|&factor| factor == 1.0), "{name}");
        assert!(end.is_nan() || (seen("time")[0] - end).abs() < 1e-9, "{name} at {:?}", seen("time"));
        assert_eq!(seen("bars"), [bars], "{name}: colour bars");
        // Without particles, and in a state of rest, the limits are not of interest.
        if name == "silo" {
            let speed = seen("limits")[1];
            assert!(speed > 0.5 && speed < 1.5, "falling by 3 cm gives 0.8 m/s, not {speed}");
        }
        assert_eq!(seen("shown"), seen("particles"), "{name}: each particle once, as what it is");
        let (up, coloured) = (seen("up"), seen("coloured")[0]);
        match name {
            "tilted" => assert!((up[2] - 0.9987).abs() < 1e-3 && (up[1] - 0.05096).abs() < 1e-3, "{up:?}"),
            "silo" | "bed" => assert_eq!(up, [0.0, 0.0, 1.0], "{name}"),
            _ => (),
        }
        assert!(coloured > 0.02, "{name}: {coloured} of the picture is particles or fluid");
        let (lower, colours) = (seen("lower")[0], seen("colours")[0]);
        if ["silo", "tilted"].contains(&name) {
            assert!(lower > 0.8, "{name}: the hopper is below, with {lower} of what is coloured");
        }
        assert!(colours > 10.0 || name == "duct", "{name}: {colours} colours");
    }
}
