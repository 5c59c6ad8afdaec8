//! The rows of a motion by a table of times, inline or in a CSV file.

use std::path::{Path, PathBuf};

use crate::check::Checker;
use crate::csv_numbers;
use crate::vector::{norm, sub};

/// The columns of a file, in any order; `time` is required.
const COLUMNS: [&str; 5] = ["time", "x", "y", "z", "angle"];

/// A row of a table.
#[derive(Clone, Copy, Debug, Default, PartialEq)]
pub struct TableRow {
    /// Time (s).
    pub time: f64,
    /// Displacement (m).
    pub displacement: [f64; 3],
    /// Angle turned (rad).
    pub angle: f64,
}

impl TableRow {
    /// Mean speed (m/s) up to a later row, at an arm (m) from the axis.
    pub(crate) fn mean_speed(&self, next: &Self, arm: f64) -> f64 {
        let turned = if next.angle == self.angle { 0.0 } else { (next.angle - self.angle).abs() * arm };
        (norm(sub(next.displacement, self.displacement)) + turned) / (next.time - self.time)
    }
}

/// The rows of a file, whose full path takes the place of `file`, or of lists; none if something is wrong.
pub(crate) fn check(
    key: &str,
    file: &mut Option<PathBuf>,
    lists: (&[f64], &[[f64; 3]], &[f64]),
    checker: &mut Checker,
) -> Vec<TableRow> {
    let errors = checker.error_count();
    let (rows, key) = match file {
        Some(file) => {
            let key = format!("{key}.path");
            if lists != (&[], &[], &[]) {
                checker
                    .error(&key, "excludes times, displacements and angles; remove one or the other".into());
            }
            *file = checker.file(&key, file, &["csv"]);
            if checker.error_count() > errors {
                return Vec::new();
            }
            (read(file), key)
        }
        None => (of_lists(lists), format!("{key}.times")),
    };
    let rows = rows.and_then(|rows| ascending(&rows).map(|()| rows));
    rows.unwrap_or_else(|message| {
        checker.error(&key, message);
        Vec::new()
    })
}

fn of_lists((times, displacements, angles): (&[f64], &[[f64; 3]], &[f64])) -> Result<Vec<TableRow>, String> {
    for (name, length) in [("displacements", displacements.len()), ("angles", angles.len())] {
        if length != 0 && length != times.len() {
            return Err(format!("{} times but {length} {name}; give one for each time", times.len()));
        }
    }
    let row = |(k, &time): (usize, &f64)| TableRow {
        time,
        displacement: displacements.get(k).copied().unwrap_or_default(),
        angle: angles.get(k).copied().unwrap_or_default(),
    };
    Ok(times.iter().enumerate().map(row).collect())
}

fn ascending(rows: &[TableRow]) -> Result<(), String> {
    if rows.len() < 2 {
        return Err("a motion takes two times and more".into());
    }
    match rows.windows(2).find(|pair| pair[1].time <= pair[0].time) {
        Some(pair) => Err(format!("must ascend; {} s comes after {} s", pair[1].time, pair[0].time)),
        None => Ok(()),
    }
}

fn read(file: &Path) -> Result<Vec<TableRow>, String> {
    let rows = csv_numbers::read(file, &COLUMNS)?.into_iter().map(|[time, x, y, z, angle]| {
        let displacement = [x, y, z].map(Option::unwrap_or_default);
        Some(TableRow { time: time?, displacement, angle: angle.unwrap_or_default() })
    });
    rows.collect::<Option<_>>().ok_or_else(|| "the file has no column time".into())
}

#[cfg(test)]
mod tests {
    use crate::{Case, Motion};
    use std::path::Path;

    /// The motion of a wall, and what is wrong with it.
    fn motion(text: &str, base: &Path) -> Result<Motion, String> {
        let text = format!(
            r#"
[domain]
lower = [0, 0, 0]
upper = [1, 1, 1]
[time]
end = 1
[[material]]
name = "steel"
density = 7800
[[contact]]
between = ["steel", "steel"]
normal_stiffness = 1e5
restitution = 0.8
friction = 0.3
[[shape]]
name = "ball"
kind = "sphere"
radius = 0.01
[[insert]]
name = "balls"
particles = [{{ shape = "ball", material = "steel" }}]
count = 1
place = {{ kind = "lattice", lower = [0.4, 0.4, 0.4], upper = [0.6, 0.6, 0.6] }}
[[wall]]
name = "lid"
material = "steel"
kind = "plane"
point = [0, 0, 1]
normal = [0, 0, -1]
motion = {{ kind = "table", {text} }}
"#
        );
        let case = Case::parse(&text, "case.toml", base).map_err(|e| e.to_string())?;
        Ok(case.walls[0].motion.clone().unwrap())
    }

    #[test]
    fn a_file_and_lists_give_the_same_rows() {
        let base = std::env::temp_dir().join(format!("grains-motion-{}", std::process::id()));
        std::fs::create_dir_all(&base).unwrap();
        std::fs::write(base.join("lid.csv"), "# measured\nangle, z ,time\n0, 0, 0.1\n0.5, -0.2, 0.4\n")
            .unwrap();
        let axis = "point = [0, 0, 1], axis = [0, 0, 3]";
        let of_file = motion(&format!("path = \"lid.csv\", {axis}"), &base).unwrap();
        let lists = "times = [0.1, 0.4], displacements = [[0, 0, 0], [0, 0, -0.2]], angles = [0, 0.5]";
        let of_lists = motion(&format!("{lists}, {axis}"), &base).unwrap();
        let [Motion::Table { rows: a, .. }, Motion::Table { rows: b, axis, .. }] = [&of_file, &of_lists]
        else {
            panic!("tables: {of_file:?} {of_lists:?}")
        };
        assert_eq!(a, b);
        assert_eq!(*axis, Some([0.0, 0.0, 1.0]));
        assert_eq!(of_file.interval(), (0.1, 0.4));
        let (speed, key) = of_file.speed(0.3);
        assert!((speed - 1.5 * (0.2 + 0.5 * 0.3) / 0.3).abs() < 1e-12 && key == "times", "{speed}");
        std::fs::write(base.join("lid.csv"), "time,zz\n0,0\n1,1\n").unwrap();
        let error = motion("path = \"lid.csv\"", &base).unwrap_err();
        assert!(error.contains("did you mean `z`"), "{error}");
        std::fs::remove_dir_all(&base).unwrap();
    }

    #[test]
    fn tables_that_are_none_are_refused() {
        let here = Path::new("");
        for (text, words) in [
            ("times = [0.1]", "two times and more"),
            ("times = [0.1, 0.1]", "must ascend"),
            ("times = [0, 1], displacements = [[0, 0, 0]]", "2 times but 1 displacements"),
            ("times = [0, 1], angles = [0, 1]", "angles are about an axis"),
            ("path = \"none.csv\"", "no such file"),
        ] {
            let error = motion(text, here).unwrap_err();
            assert!(error.contains(words) && error.contains("wall[0].motion."), "{text}: {error}");
        }
    }
}
