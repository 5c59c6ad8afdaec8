//! Runs that are halted for a while, and clocks that jump.

use crate::common::results::last_step;
use crate::common::{signal, start, start_with};
use crate::{Draw, Subject, preloaded, repeated};
use std::time::Duration;

#[test]
fn ranks_that_are_halted_for_a_while_change_nothing() {
    let subject = Subject::new("halted", "silo", 3000, 20, 300);
    let home = subject.begin("halted");
    let results = home.join("results");
    let mut running = start(3, &home, &["case.toml"], 0);
    let (mut draw, pause) = (Draw(5), repeated(1, 20));
    for halt in 1..=3 {
        running.wait_until("some steps on", || last_step(&results) >= 400 * halt);
        let ranks = running.ranks();
        let halted = if halt == 3 { ranks.clone() } else { vec![ranks[draw.of(ranks.len())]] };
        signal("STOP", &halted);
        std::thread::sleep(Duration::from_secs(pause as u64));
        signal("CONT", &halted);
    }
    running.wait().succeeded();
    subject.assert_nothing_lost(&home);
    println!("attack: ranks halted | 3 times {pause} s | nothing changed");
}

#[test]
fn a_clock_that_jumps_by_a_day_changes_nothing() {
    let subject = Subject::new("clock", "shear", 400, 10, 100);
    let home = subject.begin("clock");
    let clock = [("LD_PRELOAD", preloaded("jumping_clock"))];
    let output = start_with(2, &home, &["case.toml"], (0, &clock)).wait().succeeded();
    assert!(!output.stderr.contains("warning"), "{}", output.text());
    subject.assert_nothing_lost(&home);
}
