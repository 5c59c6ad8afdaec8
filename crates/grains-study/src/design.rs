//! Which combinations of values are run: every list crosses every other, and the Latin hypercube over the ranges.

use crate::csv_table::CsvTable;
use crate::error::StudyError;
use crate::random::Random;
use crate::study_check::no_such;
use crate::study_file::{Range, Study};
use std::collections::BTreeMap;
use toml::Value;

/// Values of the varied quantities, by name.
pub(crate) type Values = BTreeMap<String, Value>;

/// Members of a study beyond which it is refused: their cases alone would take minutes to check.
const MOST_MEMBERS: usize = 100_000;

/// All combinations of a study, the last list changing fastest.
///
/// # Errors
/// A table of points that does not fit the study, or more members than any machine runs.
pub(crate) fn points(study: &Study) -> Result<Vec<Values>, StudyError> {
    let factors = factors(study)?;
    members(study, &factors)?;
    let cross = |points: Vec<Values>, factor: &Vec<Values>| -> Vec<Values> {
        points
            .iter()
            .flat_map(|point| factor.iter().map(|row| point.clone().into_iter().chain(row.clone()).collect()))
            .collect()
    };
    Ok(factors.iter().fold(vec![Values::new()], cross))
}

/// Number of members that a study begins with.
///
/// # Errors
/// As for [`points`].
pub(crate) fn count(study: &Study) -> Result<usize, StudyError> {
    match study.fit {
        Some(_) => Ok(crate::fit::initial_points(study).saturating_mul(study.design.repeats)),
        None => members(study, &factors(study)?),
    }
}

/// Number of combinations of some lists, times that of repeats.
fn members(study: &Study, factors: &[Vec<Values>]) -> Result<usize, StudyError> {
    let counts = factors.iter().map(Vec::len).chain([study.design.repeats]);
    let members = counts.fold(1, usize::saturating_mul);
    match members <= MOST_MEMBERS {
        true => Ok(members),
        false => Err(study.error(
            "design",
            format!(
                "the lists and points of [vary] with their repeats make {members} members, {MOST_MEMBERS} at most; give fewer values, or let lists go together (design.together)"
            ),
        )),
    }
}

/// The lists of values that cross each other.
fn factors(study: &Study) -> Result<Vec<Vec<Values>>, StudyError> {
    let together = &study.design.together;
    let is_alone = |name: &&String| !together.iter().flatten().any(|other| other == *name);
    let lists = study.vary.iter().filter(|(_, vary)| !vary.values.is_empty()).map(|(name, _)| name);
    let alone = lists.filter(is_alone).map(|name| vec![name.clone()]);
    let groups = together.iter().filter(|group| !group.is_empty()).cloned();
    let mut factors: Vec<Vec<Values>> = alone.chain(groups).map(|group| rows_of(study, &group)).collect();
    factors.extend(table(study)?);
    let ranges = study.ranges();
    if let (false, Some(samples)) = (ranges.is_empty(), study.design.samples) {
        factors.push(sampled(&ranges, samples, study.design.seed));
    }
    Ok(factors)
}

/// The rows of lists that go together.
fn rows_of(study: &Study, group: &[String]) -> Vec<Values> {
    let count = study.vary[&group[0]].values.len();
    let row =
        |i: usize| group.iter().map(|name| (name.clone(), study.vary[name].values[i].clone())).collect();
    (0..count).map(row).collect()
}

/// The rows of the table of points, if there is one.
fn table(study: &Study) -> Result<Option<Vec<Values>>, StudyError> {
    let without: Vec<&str> = study
        .vary
        .iter()
        .filter(|(_, vary)| vary.values.is_empty() && vary.range().is_none())
        .map(|(name, _)| name.as_str())
        .collect();
    let Some(path) = &study.design.points else { return Ok(None) };
    let path = study.base().join(path);
    let table = CsvTable::read(&path)?;
    if let Some(stranger) = table.columns.iter().find(|column| !without.contains(&column.as_str())) {
        let message = match study.vary.contains_key(stranger) {
            true => {
                format!("[vary.{stranger}] has values or a range as well; leave out the one or the other")
            }
            false if stranger.contains([';', '\t']) => "columns are parted by commas".into(),
            false => no_such("varied quantity without values", stranger, &without),
        };
        return Err(StudyError::of_file(&path, format!("column `{stranger}`: {message}")));
    }
    if let Some(missing) = without.iter().find(|name| table.position(name).is_none()) {
        return Err(StudyError::of_file(
            &path,
            format!("has no column `{missing}`, and [vary.{missing}] no values"),
        ));
    }
    if table.rows.is_empty() {
        return Err(StudyError::of_file(&path, "has no rows"));
    }
    let value = |text: &str| -> Value {
        let number =
            text.parse::<i64>().map(Value::Integer).or_else(|_| text.parse::<f64>().map(Value::Float));
        number.unwrap_or_else(|_| Value::String(text.trim_matches('"').to_owned()))
    };
    let row =
        |row: &Vec<String>| table.columns.iter().cloned().zip(row.iter().map(|text| value(text))).collect();
    Ok(Some(table.rows.iter().map(row).collect()))
}

/// A Latin hypercube over ranges, as values.
pub(crate) fn sampled(ranges: &[(&str, Range)], samples: usize, seed: u64) -> Vec<Values> {
    let places = latin_hypercube(ranges.len(), samples, seed);
    places.iter().map(|place| at(ranges, place)).collect()
}

/// The values at shares of ranges.
pub(crate) fn at(ranges: &[(&str, Range)], shares: &[f64]) -> Values {
    let value = |((name, range), share): (&(&str, Range), &f64)| {
        // Six digits tell all that a run can tell, and read better.
        let value: f64 = format!("{:.5e}", range.at(*share)).parse().unwrap_or(range.min);
        (name.to_string(), Value::Float(value.clamp(range.min, range.max)))
    };
    ranges.iter().zip(shares).map(value).collect()
}

/// Shares of ranges such that each of `samples` equal parts of each range holds one (McKay, Beckman and Conover 1979): of some
/// hypercubes the one whose nearest points are farthest apart.
pub(crate) fn latin_hypercube(dimensions: usize, samples: usize, seed: u64) -> Vec<Vec<f64>> {
    const TRIES: u64 = 50;
    let draw = |attempt: u64| -> Vec<Vec<f64>> {
        let mut random = Random::new(seed, 1000 + attempt);
        let mut places = vec![vec![0.0; dimensions]; samples];
        for axis in 0..dimensions {
            for (place, part) in places.iter_mut().zip(random.permutation(samples)) {
                place[axis] = (part as f64 + random.uniform()) / samples as f64;
            }
        }
        places
    };
    // Of many points any hypercube will do, and distances would take long.
    if samples > 300 {
        return draw(0);
    }
    let tried = (0..TRIES).map(draw).map(|places| (least_distance(&places), places));
    tried.fold((-1.0, Vec::new()), |best, next| if next.0 > best.0 { next } else { best }).1
}

fn least_distance(places: &[Vec<f64>]) -> f64 {
    let distance = |a: &[f64], b: &[f64]| a.iter().zip(b).map(|(x, y)| (x - y).powi(2)).sum::<f64>();
    let pairs = places.iter().enumerate().flat_map(|(i, a)| places[..i].iter().map(move |b| distance(a, b)));
    pairs.fold(f64::INFINITY, f64::min)
}

#[cfg(test)]
mod tests {
    use super::*;

    fn study(text: &str) -> Study {
        Study::parse(&format!("case = \"a.toml\"\n{text}"), "study.toml").unwrap()
    }

    #[test]
    fn every_part_of_every_range_holds_one_sample() {
        for (dimensions, samples) in [(1, 7), (3, 20), (5, 400)] {
            let places = latin_hypercube(dimensions, samples, 3);
            for axis in 0..dimensions {
                let mut parts: Vec<usize> =
                    places.iter().map(|p| (p[axis] * samples as f64) as usize).collect();
                parts.sort_unstable();
                assert_eq!(parts, (0..samples).collect::<Vec<_>>());
            }
        }
        assert_ne!(latin_hypercube(2, 9, 1), latin_hypercube(2, 9, 2));
    }

    #[test]
    fn lists_cross_and_those_that_go_together_do_not() {
        let vary = "[vary]\na = { key = \"time.end\", values = [1, 2, 3] }\nb = { key = \"seed\", values = [4, 5] }\nc = { key = \"name\", values = [\"x\", \"y\"] }\n";
        let all = points(&study(vary)).unwrap();
        assert_eq!(all.len(), 12);
        assert_eq!(all[1]["c"], Value::from("y"));
        let zipped = points(&study(&format!("{vary}[design]\ntogether = [[\"b\", \"c\"]]\n"))).unwrap();
        assert_eq!(zipped.len(), 6);
        assert!(zipped.iter().all(|p| (p["b"] == Value::Integer(4)) == (p["c"] == Value::from("x"))));
    }

    #[test]
    fn more_members_than_a_machine_can_check_are_refused() {
        let list = |name: u8| {
            format!("{} = {{ key = \"seed\", values = [1, 2, 3, 4, 5, 6, 7, 8] }}\n", name as char)
        };
        let text = |lists: u8| format!("[vary]\n{}", (b'a'..b'a' + lists).map(list).collect::<String>());
        assert_eq!(points(&study(&text(4))).unwrap().len(), 4096);
        let refused = points(&study(&text(24))).unwrap_err().to_string();
        assert!(refused.contains("members, 100000 at most"), "{refused}");
        let repeats = format!("{}[design]\nrepeats = 1000\n", text(3));
        assert!(points(&study(&repeats)).is_err());
    }

    #[test]
    fn ranges_are_sampled_for_each_combination_of_lists() {
        let text = "[vary]\na = { key = \"time.end\", values = [1, 2] }\nb = { key = \"seed\", min = 1e-4, max = 1, log = true }\n[design]\nsamples = 10\n";
        let all = points(&study(text)).unwrap();
        assert_eq!(all.len(), 20);
        let small = all.iter().filter(|p| p["b"].as_float().is_some_and(|b| b < 1e-2)).count();
        assert_eq!(small, 10, "half of a range of its logarithm");
    }

    #[test]
    fn a_table_gives_its_rows() {
        let folder = std::env::temp_dir().join(format!("grains-study-points-{}", std::process::id()));
        std::fs::create_dir_all(&folder).unwrap();
        std::fs::write(folder.join("p.csv"), "a,b\n1,0.5\n2,wet\n").unwrap();
        let text = "case = \"a.toml\"\n[vary]\na = { key = \"seed\" }\nb = { key = \"name\" }\nc = { key = \"time.end\", values = [1, 2] }\n[design]\npoints = \"p.csv\"\n";
        let study = |text: &str| Study::parse(text, &folder.join("s.toml").display().to_string()).unwrap();
        let all = points(&study(text)).unwrap();
        assert_eq!(all.len(), 4);
        assert_eq!((&all[0]["a"], &all[1]["b"]), (&Value::Integer(1), &Value::from("wet")));
        let missing = points(&study(&text.replace("b = ", "beta = "))).unwrap_err().to_string();
        assert!(missing.contains("column `b`: no such varied quantity"), "{missing}");
    }
}
