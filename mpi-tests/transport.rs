//! What the ranks send each other.

#![allow(clippy::unwrap_used)]

mod ranks;

use grains_comm::share_on_node;
use grains_domain::{Channel, Transport};
use mpi::topology::Color;
use mpi::traits::Communicator;
use ranks::on_ranks;
use std::fs;

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
fn maxima_ended_later_come_in_the_order_in_which_they_were_begun() {
    on_ranks(&[1, 2, 5], "maxima_ended_later_come_in_the_order_in_which_they_were_begun", |job| {
        let transport = job.new_transport();
        let (rank, size) = (transport.rank(), transport.size());
        let values = |round: usize, rank: usize| [0, 1, 2].map(|k| value(round, rank, 0, k));
        for round in 0..6 {
            transport.begin_max(&values(round, rank));
            // What others do in the meantime does not mix with it.
            let mut sum = [1.0];
            transport.sum(&mut sum);
            assert_eq!(sum, [size as f64]);
            // Three are under way at a time.
            if round >= 2 {
                let mut found = [0.0; 3];
                transport.end_max(&mut found);
                let of_ranks = (0..size).map(|other| values(round - 2, other));
                let wanted = of_ranks
                    .fold([f64::NEG_INFINITY; 3], |max, own| std::array::from_fn(|k| max[k].max(own[k])));
                assert_eq!(found, wanted, "round {round}");
            }
        }
    });
}

#[test]
fn a_channel_takes_heads_of_messages_where_it_awaits_whole_ones() {
    on_ranks(&[2, 3, 5], "a_channel_takes_heads_of_messages_where_it_awaits_whole_ones", |job| {
        let transport = job.new_transport();
        let (rank, size) = (transport.rank(), transport.size());
        let peers: Vec<usize> = (0..size).filter(|&other| other != rank).collect();
        let lengths = |of: fn(usize, usize) -> (usize, usize)| -> Vec<usize> {
            peers.iter().map(|&peer| of(rank, peer)).map(|(from, to)| 3 + length(1, from, to)).collect()
        };
        let mut channel =
            Channel::new(&peers, &lengths(|own, peer| (own, peer)), &lengths(|own, peer| (peer, own)));
        transport.prepare(&mut channel);
        for round in 0..8 {
            for (k, &peer) in peers.iter().enumerate() {
                let message = channel.outgoing(k).iter_mut().enumerate();
                message.for_each(|(place, number)| *number = value(round, rank, peer, place));
            }
            let sends_heads = |rank: usize| (round + rank).is_multiple_of(3);
            match sends_heads(rank) {
                true => transport.start_heads(&mut channel, 2),
                false => transport.start(&mut channel),
            }
            transport.finish(&mut channel);
            for (k, &peer) in peers.iter().enumerate() {
                let arrived = if sends_heads(peer) { 2 } else { channel.incoming(k).len() };
                for (place, &number) in channel.incoming(k)[..arrived].iter().enumerate() {
                    assert_eq!(number, value(round, peer, rank, place), "round {round}");
                }
            }
        }
    });
}

#[test]
fn the_ranks_of_a_node_read_one_copy_and_keep_no_file_open() {
    on_ranks(&[1, 2, 5], "the_ranks_of_a_node_read_one_copy_and_keep_no_file_open", |job| {
        let (rank, size) = (job.transport().rank(), job.size());
        for per_node in 1..=size {
            // As if each node had so many ranks.
            let number = rank / per_node;
            let node = job.world().split_by_color(Color::with_value(number as i32)).unwrap();
            let bytes = |round: usize| vec![(number + round) as u8; 5_000 * round];
            for round in 1..4 {
                let shared = share_on_node(&node, || {
                    assert_eq!(rank % per_node, 0, "only the first of a node is asked");
                    Some(bytes(round))
                });
                assert_eq!(shared.is_some(), node.size() > 1);
                if let Some(shared) = shared {
                    assert_eq!(shared[..], bytes(round)[..]);
                }
                // A node whose first rank has nothing, and one that has nothing in it, go without.
                let none = share_on_node(&node, || (round > 1).then(Vec::new).filter(|_| number > 0));
                assert!(none.is_none_or(|shared| shared.is_empty()));
            }
        }
        let open = fs::read_dir("/proc/self/fd")
            .unwrap()
            .filter_map(|entry| fs::read_link(entry.unwrap().path()).ok());
        assert!(!open.into_iter().any(|path| path.to_string_lossy().contains("grains-mpi")));
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
