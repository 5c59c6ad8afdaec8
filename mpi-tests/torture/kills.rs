//! Runs that are killed at random times and continued on other ranks.

use crate::common::results::{assert_same_state, checkpoints};
use crate::common::{Running, signal, start};
use crate::{Draw, Subject, arguments, assert_readable, repeated};
use std::fs;
use std::path::Path;
use std::time::{Duration, Instant};

/// Longest time (s) for the ranks of a job to end once one of them is gone.
const PATIENCE: u64 = 60;

/// Who is killed.
const VICTIMS: [&str; 3] = ["one rank", "all ranks", "mpirun"];

/// Kills a run within `span` s again and again, until it comes to its end all the same; returns the number of kills.
fn one_life(subject: &Subject, home: &Path, span: f64, draw: &mut Draw) -> usize {
    let mut kills = 0;
    loop {
        let mut running = start(subject.ranks(draw), home, arguments(home), 0);
        let until = Instant::now() + Duration::from_secs_f64(span * draw.next());
        while Instant::now() < until && !running.has_ended() {
            std::thread::sleep(Duration::from_millis(2));
        }
        if running.has_ended() {
            running.wait().succeeded();
            return kills;
        }
        kill(running, draw);
        kills += 1;
        assert_readable(&home.join("results"));
        assert!(kills < 100, "{} does not come to its end", subject.name);
    }
}

/// Kills one rank, all of them or mpirun; all must end then.
fn kill(running: Running, draw: &mut Draw) {
    let (ranks, mpirun) = (running.ranks(), running.mpirun());
    // MPI has not started them yet.
    if ranks.is_empty() {
        signal("KILL", &[mpirun]);
        return drop(running.wait());
    }
    let victims = match VICTIMS[draw.of(VICTIMS.len())] {
        "one rank" => vec![ranks[draw.of(ranks.len())]],
        "all ranks" => ranks.clone(),
        _ => vec![mpirun],
    };
    signal("KILL", &victims);
    let begun = Instant::now();
    let lives = |rank: &u32| {
        let state = fs::read_to_string(format!("/proc/{rank}/stat")).unwrap_or_default();
        state.contains("(grains-mpi)") && !state.contains(") Z")
    };
    while ranks.iter().any(lives) {
        assert!(begun.elapsed().as_secs() < PATIENCE, "ranks {ranks:?} outlive {victims:?}");
        std::thread::sleep(Duration::from_millis(5));
    }
    running.wait_for_launcher();
}

/// Kills runs of a case, `few` or `many` times in all, and compares each with the one that was not.
fn killed(name: &'static str, (steps, every, saved): (u32, u32, u32), few: usize, many: usize) {
    let begun = Instant::now();
    let subject = Subject::new("kills", name, steps, every, saved);
    let span = begun.elapsed().as_secs_f64();
    let wanted = repeated(few, many);
    let mut draw = Draw(steps.into());
    let (mut kills, mut lives) = (0, 0);
    while kills < wanted {
        let home = subject.begin("kills");
        kills += one_life(&subject, &home, span, &mut draw);
        subject.assert_nothing_lost(&home);
        lives += 1;
    }
    println!("attack: {name} killed at random | {kills} kills, {lives} runs to the end | nothing lost");
}

#[test]
fn a_sheared_packing_that_is_killed_loses_nothing() {
    killed("shear", (1000, 5, 25), 4, 40);
}

#[test]
fn a_filling_drum_of_hard_collisions_that_is_killed_loses_nothing() {
    killed("hard", (1500, 10, 50), 4, 30);
}

#[test]
fn a_silo_whose_borders_move_that_is_killed_loses_nothing() {
    killed("silo", (3000, 20, 100), 4, 30);
}

#[test]
fn a_fluidised_bed_that_is_killed_loses_nothing() {
    killed("bed", (150, 3, 10), 4, 30);
}

#[test]
fn rain_into_a_gas_that_is_killed_loses_nothing() {
    killed("rain", (800, 10, 40), 4, 30);
}

#[test]
fn bodies_in_a_flow_that_are_killed_lose_nothing() {
    killed("resolved", (30, 1, 4), 3, 20);
}

#[test]
fn a_duct_that_is_killed_loses_nothing() {
    killed("duct", (120, 1, 5), 3, 20);
}

#[test]
fn a_run_killed_while_it_saves_has_the_checkpoint_before() {
    // A checkpoint at every step: most kills meet one that is written.
    let subject = Subject::new("saves", "shear", 60, 10, 1);
    let mut draw = Draw(1);
    let wanted = repeated(3, 20);
    let mut kills = 0;
    while kills < wanted {
        let home = subject.begin("saves");
        kills += one_life(&subject, &home, 1.0, &mut draw);
        let [a, b] = [&subject.home, &home].map(|home| checkpoints(&home.join("results")));
        assert_same_state(a.last().unwrap(), b.last().unwrap());
    }
    println!("attack: killed while it saves every step | {kills} kills | nothing lost");
}
