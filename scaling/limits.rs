//! What one core of this machine can do: cycles, streaming, latency. `rustc -O limits.rs && ./limits` prints lines `NAME VALUE`.

use std::arch::asm;
use std::hint::black_box;
use std::time::Instant;

/// Shortest time (s) of some rounds.
fn fastest(rounds: usize, mut round: impl FnMut()) -> f64 {
    let time = |_| {
        let begun = Instant::now();
        round();
        begun.elapsed().as_secs_f64()
    };
    (0..rounds).map(time).fold(f64::INFINITY, f64::min)
}

/// Cycles per nanosecond, by additions that wait for each other.
fn gigahertz() -> f64 {
    const LOOPS: usize = 1_000_000;
    let mut sum = 0_u64;
    let time = fastest(20, || {
        for _ in 0..LOOPS {
            macro_rules! add {
                ($($_:tt)*) => { $({ let _ = stringify!($_); one(&mut sum); })* };
            }
            add!(1 2 3 4 5 6 7 8 9 10 11 12 13 14 15 16 17 18 19 20);
        }
    });
    black_box(sum);
    (20 * LOOPS) as f64 / time / 1e9
}

#[inline(always)]
fn one(sum: &mut u64) {
    // SAFETY: adds two registers.
    #[cfg(target_arch = "x86_64")]
    unsafe {
        asm!("add {0}, {1}", inout(reg) *sum, in(reg) 3_u64, options(pure, nomem, nostack));
    }
    // SAFETY: adds two registers.
    #[cfg(target_arch = "aarch64")]
    unsafe {
        asm!("add {0}, {0}, {1}", inout(reg) *sum, in(reg) 3_u64, options(pure, nomem, nostack));
    }
}

/// Bytes per nanosecond read and written by a[i] = b[i] + s c[i] over three arrays that take so many bytes.
fn stream(bytes: usize) -> f64 {
    let n = bytes / 24;
    let (mut a, b, c) = (vec![0.0_f64; n], vec![1.0_f64; n], vec![2.0_f64; n]);
    let repeats = 100_000_000 / bytes + 1;
    let time = fastest(8, || {
        for repeat in 0..repeats {
            let s = repeat as f64;
            a.iter_mut().zip(&b).zip(&c).for_each(|((a, b), c)| *a = b + s * c);
            black_box(&mut a);
        }
    });
    (24 * n * repeats) as f64 / time / 1e9
}

/// Nanoseconds of a load that waits for the one before, over so many bytes in no order.
fn latency(bytes: usize) -> f64 {
    const LINE: usize = 8;
    let n = bytes / 64;
    let mut order: Vec<usize> = (0..n).collect();
    let mut state = 1_u64;
    for i in (1..n).rev() {
        state = state.wrapping_mul(6_364_136_223_846_793_005).wrapping_add(1_442_695_040_888_963_407);
        order.swap(i, (state >> 33) as usize % (i + 1));
    }
    let mut next = vec![0_usize; n * LINE];
    (0..n).for_each(|i| next[order[i] * LINE] = order[(i + 1) % n] * LINE);
    let mut at = 0;
    const LOADS: usize = 2_000_000;
    let time = fastest(3, || {
        for _ in 0..LOADS {
            at = next[at];
        }
    });
    black_box(at);
    time / LOADS as f64 * 1e9
}

fn main() {
    println!("gigahertz {:.3}", gigahertz());
    for (name, bytes) in [("first", 16 << 10), ("second", 512 << 10), ("third", 8 << 20), ("memory", 512 << 20)] {
        println!("stream_{name} {:.1}", stream(bytes));
        println!("latency_{name} {:.2}", latency(bytes));
    }
}
