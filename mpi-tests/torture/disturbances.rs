//! Runs that are halted for a while, and clocks that jump.

use crate::common::results::last_step;
use crate::common::{signal, start};
use crate::{Draw, Subject, repeated};
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
