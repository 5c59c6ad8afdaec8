//! The page of the manual with all cases by theme.

use crate::{files, must_be_current, root, text_of};
use std::fmt::Write;

const HEAD: &str = "\
<!-- Written by `cargo test -p grains-case --test manual` from the READMEs of cases; do not edit. -->
# Cases

Each case is a folder with its case files, scripts and a README with figures beside those of the source. Commands start in the
root of the repository. What each reproduces, in one table: [all results](../cases/README.md).
";

const THEMES: [(&str, &[&str]); 8] = [
    (
        "Flow of grains",
        &["silo", "drum", "wet-drum", "dam-break", "angle-of-repose", "shear-flow", "calibration", "million"],
    ),
    ("Packings", &["packing", "fixed-bed"]),
    (
        "Contacts, bonds and shapes",
        &["laws", "bonds", "cylinder-impact", "superellipsoid-energy", "superellipsoid-scaling"],
    ),
    ("Stages and restarts", &["staged"]),
    ("Fluid among particles", &["fluidised-bed", "spouted-bed", "gas-hopper"]),
    (
        "Fluid around particles",
        &[
            "settling-sphere",
            "settling-2d",
            "sedimentation-3d",
            "oscillating-cylinder",
            "schaefer-turek",
            "array-sphere",
            "array-lobes",
            "packed-bed",
            "reactor-tube",
            "bingham-sphere",
        ],
    ),
    ("Fluid alone, and walls in it", &["cavity", "heated-cavity", "turbulent-channel", "stirred-tank"]),
    (
        "Heat and reactions",
        &["heated-bed", "sphere-heat", "hot-settling", "effectiveness", "virtual-reactor"],
    ),
];

#[test]
fn the_gallery_is_current() {
    let mut text = HEAD.to_string();
    for (theme, cases) in THEMES {
        let _ = write!(text, "\n## {theme}\n\n| | case | command and cost |\n|---|---|---|\n");
        cases.iter().for_each(|case| text += &row(case));
    }
    must_be_current("docs/gallery.md", &text);
    for readme in files("cases", "README.md") {
        let folder = readme.parent().expect("folder");
        let name = folder.file_name().expect("name").to_string_lossy().into_owned();
        let is_listed = THEMES.iter().any(|(_, cases)| cases.contains(&&*name));
        assert!(is_listed || folder == root().join("cases"), "{name} has no theme in {}", file!());
    }
}

/// A case with its first picture, first sentence and first command; what stands behind the command is its cost.
fn row(case: &str) -> String {
    let readme = text_of(&root().join("cases").join(case).join("README.md"));
    let title = readme.lines().next().expect("title").trim_start_matches("# ").to_string();
    let targets =
        readme.match_indices("](").map(|(at, _)| readme[at + 2..].split(')').next().unwrap_or_default());
    let pictures: Vec<&str> = targets.filter(|target| target.ends_with(".png")).collect();
    // The one that has the name of the case shows it best.
    let best = pictures.iter().find(|file| case.contains(file.trim_end_matches(".png"))).or(pictures.first());
    let picture = best.map_or(String::new(), |file| {
        format!("<a href=\"../cases/{case}/README.md\"><img src=\"../cases/{case}/{file}\" width=\"220\" alt=\"{title}\"></a>")
    });
    let paragraph: Vec<&str> = readme
        .lines()
        .skip(1)
        .skip_while(|line| line.is_empty())
        .take_while(|line| !line.is_empty())
        .collect();
    let first = sentence(&paragraph.join(" "));
    let (command, cost) = command(&readme).unwrap_or_else(|| panic!("cases/{case}/README.md has no command"));
    let cost = if cost.is_empty() { String::new() } else { format!("<br>{}", cost.replace('|', "\\|")) };
    format!("| {picture} | [{title}](../cases/{case}/README.md)<br>{first} | `{command}`{cost} |\n")
}

/// The first sentence of a paragraph, with its links as plain text.
fn sentence(paragraph: &str) -> String {
    let is_end = |at: &usize| {
        let rest = &paragraph[*at..];
        rest.starts_with(". ")
            && rest[2..].starts_with(|c: char| c.is_uppercase())
            // Behind initials and "et al." it goes on.
            && paragraph[..*at].rsplit(' ').next().is_some_and(|word| word.len() > 2)
    };
    let end = paragraph.match_indices(". ").map(|(at, _)| at).find(is_end);
    let first = end.map_or(paragraph, |at| &paragraph[..=at]);
    let mut plain = String::new();
    let mut rest = first;
    while let Some((before, link)) = rest.split_once('[') {
        let Some((words, after)) =
            link.split_once("](").and_then(|(words, after)| Some((words, after.split_once(')')?.1)))
        else {
            break;
        };
        plain += before;
        plain += words;
        rest = after;
    }
    (plain + rest).replace('|', "\\|")
}

/// The first command of a README that runs something, and the remark behind it.
fn command(readme: &str) -> Option<(String, String)> {
    let mut is_shell = false;
    let lines = readme.lines().filter(|line| {
        if line.starts_with("```") {
            is_shell = line.starts_with("```sh");
        }
        is_shell || line.starts_with("    python3")
    });
    let lines: Vec<String> = lines
        .map(|line| line.replace("$run ", "mpirun -n 2 grains-mpi ").replace("$python ", "python3 "))
        .collect();
    let runs = |line: &str| ["scripts/run", "grains-mpi", "python"].iter().any(|word| line.contains(word));
    let is_set_up = |line: &&String| ["```", "python=", "run="].iter().any(|begin| line.starts_with(begin));
    let line = lines.iter().filter(|line| !is_set_up(line)).find(|line| runs(line)).map(String::as_str);
    let line =
        line.or_else(|| readme.split('`').skip(1).step_by(2).find(|code| code.starts_with("grains-mpi ")))?;
    let (command, cost) = line.split_once(" #").unwrap_or((line, ""));
    Some((command.trim().to_string(), cost.trim().to_string()))
}
