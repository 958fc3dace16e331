//! The rate of fused multiply-adds of this machine, by the width of its registers.
//!
//! Compiled alone for this machine (`rustc -O -C target-cpu=native bench/peak.rs`). It runs independent
//! chains of a·x + b in registers, enough to hide their latency, and prints nanoseconds per instruction as
//! JSON.

use std::hint::black_box;
use std::time::Instant;

/// Parallel chains: more than latency times instructions per cycle.
const CHAINS: usize = 10;

/// Smallest nanoseconds per fused multiply-add of `L` lanes.
fn measure<const L: usize>() -> f64 {
    const TURNS: usize = 20_000;
    let (a, b) = (black_box([0.999_f64; L]), black_box([0.001; L]));
    let mut least = f64::INFINITY;
    for _ in 0..200 {
        let mut x = black_box([[1.0_f64; L]; CHAINS]);
        let before = Instant::now();
        for _ in 0..TURNS {
            for x in &mut x {
                for k in 0..L {
                    x[k] = x[k].mul_add(a[k], b[k]);
                }
            }
        }
        let seconds = before.elapsed().as_secs_f64();
        black_box(x);
        least = least.min(seconds * 1e9 / (TURNS * CHAINS) as f64);
    }
    least
}

fn main() {
    println!(
        r#"{{"fma_1_lane_ns": {:.4}, "fma_4_lanes_ns": {:.4}, "fma_8_lanes_ns": {:.4}}}"#,
        measure::<1>(),
        measure::<4>(),
        measure::<8>()
    );
}
