//! Which fields of stored states colour particles and slices.

use crate::channel::Range;
use serde::Serialize;

/// How a field of a page is called, in which unit, and over which range.
#[derive(Clone, Debug, Serialize)]
pub struct Field {
    /// Its name.
    pub name: String,
    /// Its unit.
    pub unit: String,
    /// Smallest number.
    pub min: f64,
    /// Largest number.
    pub max: f64,
    /// Where colours begin: below are few of the numbers.
    pub low: f64,
    /// Where colours end: above are few of the numbers.
    pub high: f64,
}

/// Share of the numbers beyond each end of the colours.
const TAIL: f64 = 0.005;

impl Field {
    /// That of numbers.
    pub fn of(name: &str, unit: Option<String>, mut values: Vec<f64>) -> Self {
        values.retain(|x| x.is_finite());
        let Range { min, max } = Range::of(values.iter().copied());
        let end = |share: f64, values: &mut Vec<f64>| match values.len() {
            0 => 0.0,
            count => {
                let place = (share * (count - 1) as f64).round() as usize;
                *values.select_nth_unstable_by(place, f64::total_cmp).1
            }
        };
        let (low, high) = (end(TAIL, &mut values), end(1.0 - TAIL, &mut values));
        let (low, high) = if low < high { (low, high) } else { (min, max) };
        Self { name: name.into(), unit: unit.unwrap_or_default(), min, max, low, high }
    }

    /// The range that its numbers are quantised over.
    pub fn range(&self) -> Range {
        Range { min: self.min, max: self.max }
    }
}

/// A stored field and what of it is shown: its magnitude if it has several components.
#[derive(Clone, Debug, PartialEq)]
pub struct Shown {
    /// Its name in the file.
    pub stored: String,
    /// Its name on the page.
    pub name: String,
    /// Whether it holds whole numbers.
    pub is_integer: bool,
}

/// Fields of particles by how much they say; others come between the first and the second group.
const FIRST: [&str; 2] = ["velocity", "temperature"];
const LAST: [&str; 9] = [
    "force",
    "coordination",
    "fluid_force",
    "bonds",
    "liquid",
    "film",
    "angular_velocity",
    "torque",
    "fluid_torque",
];
/// What the page has without them, or what no colour shows.
const NEVER: [&str; 8] =
    ["id", "shape", "material", "scale", "radius", "orientation_wxyz", "wall_contacts", "solid_velocity"];
const INTEGERS: [&str; 2] = ["coordination", "bonds"];

/// What to show of the fields of a file, the first first.
pub fn shown(stored: &[String]) -> Vec<Shown> {
    let rank =
        |name: &str| match (FIRST.iter().position(|f| *f == name), LAST.iter().position(|f| *f == name)) {
            (Some(k), _) => k,
            (_, Some(k)) => FIRST.len() + 1 + k,
            _ => FIRST.len(),
        };
    let mut names: Vec<&str> = stored.iter().map(String::as_str).filter(|n| !NEVER.contains(n)).collect();
    names.sort_by_key(|name| rank(name));
    let shown = |name: &str| Shown {
        stored: name.into(),
        name: match name {
            "velocity" => "speed".into(),
            "angular_velocity" => "angular speed".into(),
            other => other.replace('_', " "),
        },
        is_integer: INTEGERS.contains(&name),
    };
    names.into_iter().map(shown).collect()
}

/// Magnitudes of `count` things, of which each has as many components as there are numbers for it.
pub fn magnitudes(values: &[f64], count: usize) -> Vec<f64> {
    match values.len() / count.max(1) {
        0 | 1 => values.to_vec(),
        width => values.chunks_exact(width).map(|v| v.iter().map(|x| x * x).sum::<f64>().sqrt()).collect(),
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn the_speed_comes_first_and_species_before_forces() {
        let stored = ["coordination", "force", "id", "methane_amount", "orientation_wxyz", "velocity"];
        let names: Vec<String> = shown(&stored.map(String::from)).into_iter().map(|s| s.name).collect();
        assert_eq!(names, ["speed", "methane amount", "force", "coordination"]);
    }

    #[test]
    fn a_single_outlier_does_not_take_the_colours() {
        let values = (0..1000).map(f64::from).chain([1e9, f64::NAN]).collect();
        let field = Field::of("speed", Some("m/s".into()), values);
        assert_eq!((field.min, field.max), (0.0, 1e9));
        assert!(field.low == 5.0 && field.high == 995.0, "{field:?}");
        let equal = Field::of("temperature", None, vec![300.0; 10]);
        assert_eq!((equal.low, equal.high), (300.0, 300.0));
    }
}
