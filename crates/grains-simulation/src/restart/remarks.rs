//! What is seldom meant of a restart: files that are no checkpoints, and changes with consequences.

use crate::changes::{self, Change};
use crate::insertion::Insertions;
use grains_case::{Case, closest};
use grains_output::{CheckpointFile, checkpoints};
use std::path::Path;
use toml::{Table, Value};

/// Why a path can be no checkpoint, before it is read.
pub fn no_checkpoint(case: &Case, path: &Path) -> Option<String> {
    let (shown, directory) = (path.display(), &case.output.directory);
    let extension = path.extension().and_then(|e| e.to_str()).unwrap_or_default();
    if !path.exists() {
        let names: Vec<String> = checkpoints(directory)
            .iter()
            .filter_map(|(_, path)| Some(format!("`{}`", path.file_name()?.to_str()?)))
            .collect();
        let remedy = match (closest(&shown.to_string(), ["latest"]), &names[..]) {
            (Some(_), _) => "did you mean `--restart latest`?".into(),
            (None, []) => format!("{} holds none either: run without --restart", directory.display()),
            (None, names) => format!(
                "{} holds {}: name one of them, or take `--restart latest`",
                directory.display(),
                names.join(", ")
            ),
        };
        return Some(format!("--restart {shown}: No such file or folder; {remedy}"));
    }
    match extension {
        "h5" | "hdf5" => None,
        "vtkhdf" => Some(format!(
            "--restart {shown}: holds snapshots, and a run goes on from a checkpoint alone: name a checkpoint-STEP.h5 beside it, or take `--restart latest`; to begin anew with its particles set insert.place = {{ kind = \"file\", path = {:?} }}",
            shown.to_string()
        )),
        _ => Some(format!(
            "--restart {shown}: is no checkpoint, which is called checkpoint-STEP.h5: name one, or take `--restart latest`"
        )),
    }
}

/// The same particles under another name of an insertion, and counts below what is there.
fn of_insertions(case: &Case, [before, now]: [&Table; 2], insertions: &Insertions) -> Vec<(String, String)> {
    let entry = |table: &Table, name: &str| -> Option<Table> {
        let list = table.get("insert")?.as_array()?.iter().filter_map(Value::as_table);
        let mut own = list.filter(|insert| insert.get("name").and_then(Value::as_str) == Some(name)).cloned();
        let mut found = own.next()?;
        found.remove("name");
        Some(found)
    };
    let [old, new] = [before, now].map(|table| changes::names(table, "insert"));
    let mut remarks = Vec::new();
    for (i, name) in new.iter().enumerate() {
        let key = |of: &str| format!("insert[{i}].{of}");
        let (own, was) = (entry(now, name), entry(before, name));
        let is_like = |other: &&String| !new.contains(other) && entry(before, other) == own;
        if let (None, Some(like)) = (&was, old.iter().find(is_like)) {
            let message = format!(
                "new, and but for its name insertion \"{like}\" of the checkpoint, which is gone: its particles are inserted once more beside those that are there; keep the name \"{like}\""
            );
            remarks.push((key("name"), message));
        }
        let count = case.inserts.get(i).and_then(|insert| insert.count);
        if let (Some(_), Some(count)) = (was, count)
            && let Some(done) = insertions.done(i).filter(|done| *done > count)
        {
            let message = format!(
                "{done} of them are there already, and none is removed; set {done}, or insert the particles of a snapshot without those that are to go"
            );
            remarks.push((key("count"), message));
        }
    }
    remarks
}

/// Stiffnesses that jump: contacts that are there keep their overlap.
fn of_stiffness(now: &Table, changes: &[Change]) -> Vec<(String, String)> {
    /// Ratio of stiffnesses (-) that a bed at rest bears.
    const BORNE: f64 = 2.0;
    let names = changes::names(now, "contact");
    let remark = |change: &Change| {
        let [section, pair, key] = &change.key[..] else { return None };
        let is_stiffness =
            section == "contact" && ["normal_stiffness", "effective_modulus"].contains(&&**key);
        let number = |value: &Option<Value>| value.as_ref().and_then(Value::as_float);
        let (before, now) = (number(&change.before)?, number(&change.now)?);
        let place = names.iter().position(|name| name == pair).filter(|_| is_stiffness)?;
        let (ratio, consequence) = match now / before {
            ratio if ratio >= BORNE => {
                (ratio, "push each other apart with as many times the force, and a bed at rest bursts")
            }
            ratio if ratio <= 1.0 / BORNE => (
                1.0 / ratio,
                "sink into each other until the force is the same again, and a bed at rest collapses",
            ),
            _ => return None,
        };
        let more = if now > before { "higher" } else { "lower" };
        let message = format!(
            "{ratio:.1} times {more} than at the checkpoint: particles that touch {consequence}; change it by less than {BORNE} times at each restart, or settle the bed anew"
        );
        Some((format!("contact[{place}].{key}"), message))
    };
    changes.iter().filter_map(remark).collect()
}

/// What has consequences that are seldom meant, of a run that continues a checkpoint of a step and time (s).
pub fn remarks(
    case: &Case,
    file: &CheckpointFile,
    (step, time): (u64, f64),
    (before, now, changes): (&Table, &Table, &[Change]),
    insertions: &Insertions,
) -> Vec<String> {
    let mut found = of_insertions(case, [before, now], insertions);
    found.extend(of_stiffness(now, changes));
    if time >= case.time.end * (1.0 - 1e-12) {
        let message = format!(
            "the checkpoint is of t = {time} s, not before the end: no step is made; raise it (s), or leave the run as it is"
        );
        found.push(("time.end".into(), message));
    }
    let mut told: Vec<String> = found.into_iter().map(|(key, message)| case.about(&key, message)).collect();
    let directory = &case.output.directory;
    let is_own =
        file.path.canonicalize().ok().and_then(|path| Some(path.parent()? == directory.canonicalize().ok()?));
    let later = checkpoints(directory).into_iter().rev().find(|(later, _)| *later > step);
    if let (Some(true), Some((later, _))) = (is_own, later) {
        told.push(format!(
            "{}: holds a checkpoint of step {later}, and this run goes on from step {step}: its rows and snapshots of later steps are cut off, and later checkpoints get the ending .abandoned; to keep them continue into another output.directory",
            directory.display()
        ));
    }
    told
}

/// What a case has changed that may push particles into each other at once, to be told with such an error.
pub fn suspects(changes: &[String]) -> String {
    let sections = ["wall.", "contact.", "insert.", "limits.", "gravity", "domain."];
    let mut those =
        changes.iter().filter(|change| sections.iter().any(|section| change.starts_with(section)));
    match those.next() {
        None => String::new(),
        Some(first) => format!(
            "; the case differs from that of the checkpoint: {first}{}: undo that if it moves walls onto particles, or hardens contacts",
            if those.next().is_some() { ", and more told above" } else { "" }
        ),
    }
}
