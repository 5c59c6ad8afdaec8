//! `run.json`: what was run, where, what `check` said and what came of it. Each restart adds a part.

use crate::messages;
use grains_comm::MpiTransport;
use grains_domain::Transport;
use grains_output::utc_now;
use grains_report::RUN;
use grains_simulation::{Case, Prediction, Simulation, Status, Summary};
use serde_json::{Map, Value, json};
use std::fs;
use std::path::{Path, PathBuf};

/// Version of the form of the file.
const FORMAT: u64 = 1;

/// Where a run takes place.
pub struct Machine {
    processor: String,
    cores: usize,
    hosts: Vec<String>,
    ranks: usize,
}

impl Machine {
    /// That of the ranks of a simulation, on rank 0; collective.
    pub fn of(transport: &MpiTransport) -> Self {
        let host = fs::read_to_string("/proc/sys/kernel/hostname").unwrap_or_default();
        // Texts travel as numbers: this happens once.
        let own = host.trim().bytes().map(f64::from).collect();
        let text = |bytes: Vec<f64>| {
            String::from_utf8_lossy(&bytes.iter().map(|&b| b as u8).collect::<Vec<_>>()).into_owned()
        };
        let mut hosts: Vec<String> =
            transport.exchange_sparse(vec![(0, own)]).into_iter().map(|(_, bytes)| text(bytes)).collect();
        hosts.sort();
        hosts.dedup();
        Self { processor: processor(), cores: cores(), hosts, ranks: transport.size() }
    }

    fn json(&self) -> Value {
        json!({ "processor": self.processor, "cores": self.cores, "hosts": self.hosts, "ranks": self.ranks })
    }
}

/// Name of the processor, where the system tells.
fn processor() -> String {
    let text = fs::read_to_string("/proc/cpuinfo").unwrap_or_default();
    let name = text.lines().find_map(|line| line.strip_prefix("model name")?.split_once(':'));
    name.map_or_else(|| std::env::consts::ARCH.to_string(), |(_, name)| name.trim().to_string())
}

/// Logical cores of the host, of which mpirun gives a rank but one.
fn cores() -> usize {
    let text = fs::read_to_string("/proc/cpuinfo").unwrap_or_default();
    text.lines().filter(|line| line.starts_with("processor")).count()
}

/// The input files of a run, from the lines of `sha256sum`.
fn inputs(lines: &str) -> Vec<Value> {
    let files = lines.lines().filter_map(|line| line.split_once("  "));
    files.map(|(sha256, path)| json!({ "path": path, "sha256": sha256 })).collect()
}

/// How a run was begun.
pub struct Beginning<'a> {
    /// The case file.
    pub file: &'a Path,
    /// Program and version.
    pub program: &'a str,
    /// The checkpoint that it continues.
    pub restart: Option<&'a Path>,
}

/// The record of a run, on rank 0; the part of this process is its last.
pub struct Record {
    directory: PathBuf,
    earlier: Vec<Value>,
    part: Map<String, Value>,
    /// Number of the warnings that are written.
    warnings: usize,
    is_shown: bool,
}

impl Record {
    /// That of a run which begins or goes on; what is known is written.
    pub fn new(
        beginning: &Beginning,
        simulation: &Simulation,
        machine: &Machine,
        prediction: &Prediction,
    ) -> Self {
        let case = simulation.case();
        let directory = case.output.directory.clone();
        let earlier = match simulation.steps() > simulation.steps_done() {
            // Parts after the checkpoint that is continued are no part of this run.
            true => earlier(&directory, simulation.steps() - simulation.steps_done()),
            false => Vec::new(),
        };
        let Prediction { time_step, time_step_reason, steps, max_overlap, cost, seconds } = prediction;
        let part = object(json!({
            "state": "running",
            "program": beginning.program,
            "case_file": beginning.file,
            "case_sha256": simulation.origin("case_sha256"),
            "inputs": inputs(simulation.origin("inputs").unwrap_or_default()),
            "restart": beginning.restart,
            "begun": utc_now(),
            "from_step": simulation.steps() - simulation.steps_done(),
            "end_s": case.time.end,
            "time_step_s": simulation.dem().setup.parameters.dt,
            "machine": machine.json(),
            "predicted": {
                "time_step_s": time_step,
                "time_step_reason": time_step_reason,
                "steps": steps,
                "max_overlap": max_overlap,
                "overlap_limit": case.limits.overlap,
                "memory_bytes": cost.memory,
                "disk_bytes": cost.disk,
                "seconds": seconds,
            },
        }));
        let mut record = Self { directory, earlier, part, warnings: 0, is_shown: case.output.report };
        record.write();
        record
    }

    /// Writes warnings that have come since.
    pub fn renew(&mut self) {
        if messages::warnings().len() > self.warnings {
            self.write();
        }
    }

    /// Adds what a run that has ended has done, and how it ended.
    pub fn end(
        &mut self,
        (summary, case): (&Summary, &Case),
        (state, stopped_by): (Status, Option<&str>),
        at: (u64, f64),
    ) {
        let state = if state == Status::Stopped { "stopped" } else { "finished" };
        let phases = summary.phases.iter();
        let phases: Vec<Value> =
            phases.map(|p| json!({ "name": p.name, "min": p.min, "mean": p.mean, "max": p.max })).collect();
        let fluid = summary.fluid.map(|fluid| {
            json!({
                "cells": fluid.cells,
                "steps": fluid.steps,
                "iterations": fluid.iterations,
                "nanoseconds_per_cell_step": fluid.nanoseconds_per_cell_step(summary.ranks),
            })
        });
        let particles = (!case.inserts.is_empty()).then(|| {
            json!({
                "inserted": summary.inserted,
                "inside": summary.inside,
                "left": summary.left,
                "max_overlap": summary.worst_overlap,
                "deep_penetrations": summary.deep_penetrations,
                "missing": summary.missing.iter().map(|(name, count)| (name.clone(), json!(count))).collect::<Map<_, _>>(),
            })
        });
        self.part.extend(object(json!({
            "state": state,
            "stopped_by": stopped_by,
            "ended": utc_now(),
            "step": at.0,
            "time_s": at.1,
            "steps": summary.steps,
            "seconds": summary.seconds,
            "phases": phases,
            "memory_bytes": { "all": summary.memory[0], "largest_rank": summary.memory[1] },
            "disk_bytes": bytes_of(&self.directory),
            "particles": particles,
            "fluid": fluid,
            "imbalance": (summary.ranks > 1 && summary.particle_steps > 0).then_some(summary.imbalance),
            "microseconds_per_particle_step": summary.microseconds_per_particle_step(),
        })));
        self.write();
    }

    /// Adds why a run has failed.
    pub fn fail(&mut self, error: &str) {
        self.part.extend(object(json!({ "state": "failed", "error": error, "ended": utc_now() })));
        self.write();
    }

    /// Whether the case asks for a page about it.
    pub fn is_shown(&self) -> bool {
        self.is_shown
    }

    /// The directory of the results.
    pub fn directory(&self) -> &Path {
        &self.directory
    }

    fn write(&mut self) {
        let warnings = messages::warnings();
        self.warnings = warnings.len();
        self.part.insert("warnings".into(), json!(warnings));
        let parts: Vec<Value> =
            self.earlier.iter().cloned().chain([Value::Object(self.part.clone())]).collect();
        let text = format!("{:#}\n", json!({ "format": FORMAT, "parts": parts }));
        let (path, aside) = (self.directory.join(RUN), self.directory.join(".run.json"));
        let written = fs::write(&aside, text).and_then(|()| fs::rename(&aside, &path));
        if let Err(error) = written {
            eprintln!("warning: {}: cannot be written: {error}", path.display());
        }
    }
}

/// Parts of a run before a step; what was left running has been ended by something else.
fn earlier(directory: &Path, step: u64) -> Vec<Value> {
    let text = fs::read_to_string(directory.join(RUN)).unwrap_or_default();
    let stored: Value = serde_json::from_str(&text).unwrap_or_default();
    let parts = stored["parts"].as_array().cloned().unwrap_or_default();
    let is_before = |part: &Value| part["from_step"].as_u64().is_none_or(|from| from < step);
    let mut parts: Vec<Value> = parts.into_iter().filter(is_before).collect();
    for part in &mut parts {
        if part["state"] == "running" {
            part["state"] = json!("ended without a word");
        }
    }
    parts
}

fn object(value: Value) -> Map<String, Value> {
    match value {
        Value::Object(map) => map,
        _ => Map::new(),
    }
}

/// Bytes of the files in a directory and in those in it.
fn bytes_of(directory: &Path) -> u64 {
    let entries = fs::read_dir(directory).into_iter().flatten().flatten();
    let sizes = entries.filter_map(|entry| match entry.metadata() {
        Ok(metadata) if metadata.is_dir() => Some(bytes_of(&entry.path())),
        Ok(metadata) => Some(metadata.len()),
        Err(_) => None,
    });
    sizes.sum()
}
