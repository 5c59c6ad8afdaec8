//! What the ranks send each other.

#![allow(clippy::unwrap_used)]

mod ranks;

use grains_domain::Transport;
use ranks::on_ranks;

/// Value k of the message of a round between two ranks.
fn value(round: usize, from: usize, to: usize, k: usize) -> f64 {
    ((round * 64 + from) * 64 + to) as f64 + 1e-3 * k as f64
}

/// Values in the message of a round between two ranks; some send nothing, some a long message.
fn length(round: usize, from: usize, to: usize) -> usize {
    match (round + 3 * from + 5 * to) % 4 {
        0 => 0,
        1 => 20_000,
        n => n,
    }
}

#[test]
fn sparse_exchanges_in_a_row_do_not_mix() {
    on_ranks(&[1, 2, 5], "sparse_exchanges_in_a_row_do_not_mix", |job| {
        let transport = job.new_transport();
        let (own, size) = (transport.rank(), transport.size());
        let message = |round, from, to| -> Vec<f64> {
            (0..length(round, from, to)).map(|k| value(round, from, to, k)).collect()
        };
        for round in 0..200 {
            // Whoever comes late finds messages of the next round among those of this one.
            if round % size == own {
                std::thread::sleep(std::time::Duration::from_micros(300));
            }
            let sent = (0..size).rev().map(|to| (to, message(round, own, to))).collect();
            let received = transport.exchange_sparse(sent);
            let wanted: Vec<(usize, Vec<f64>)> = (0..size)
                .map(|from| (from, message(round, from, own)))
                .filter(|(_, message)| !message.is_empty())
                .collect();
            assert_eq!(received, wanted, "round {round}");
        }
        // Nobody need send anything.
        assert_eq!(transport.exchange_sparse(Vec::new()), Vec::new());
    });
}

#[test]
fn arrays_are_gathered_and_counts_add_up_in_rank_order() {
    on_ranks(&[1, 2, 5], "arrays_are_gathered_and_counts_add_up_in_rank_order", |job| {
        let transport = job.new_transport();
        let (own, size) = (transport.rank(), transport.size());
        let gathered = transport.gather(&vec![own as f64; own % 3]);
        assert_eq!(gathered, (0..size).flat_map(|rank| vec![rank as f64; rank % 3]).collect::<Vec<_>>());
        assert!(transport.gather(&[]).is_empty());
        let mut before = [own as u64 + 1, 10];
        transport.counts_before(&mut before);
        assert_eq!(before, [(own * (own + 1) / 2) as u64, 10 * own as u64]);
        assert_eq!(transport.first_rank_with(own + 2 >= size), Some(size.saturating_sub(2)));
        assert_eq!(transport.first_rank_with(false), None);
    });
}

#[test]
fn a_message_of_more_than_two_gibibytes_arrives() {
    // It takes 5 GB of memory: by `scripts/torture` alone.
    if std::env::var_os("GRAINS_TORTURE").is_none() {
        return;
    }
    on_ranks(&[2], "a_message_of_more_than_two_gibibytes_arrives", |job| {
        let transport = job.new_transport();
        let length = (1 << 28) + 12_345;
        let message = || (0..length).map(|k| k as f64).collect::<Vec<_>>();
        let sent = if transport.rank() == 0 { vec![(1, message())] } else { Vec::new() };
        for (from, received) in transport.exchange_sparse(sent) {
            assert_eq!((from, received.len()), (0, length));
            assert!(received.iter().enumerate().all(|(k, &x)| x == k as f64));
            println!("attack: a message of {} bytes | 1 | it arrives", 8 * length);
        }
    });
}
