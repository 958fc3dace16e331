//! The driver of a robot's generated Rust code, for one state at a time or lanes; `generated.py` copies it
//! into the measured crate. It has the arguments of the other programs, and ignores the robot's.

use std::time::Instant;

use robot::robot::lanes::{self, InstructionSet};
use robot::robot::{self as code, MASS_MATRIX_RELATED_ENTRIES as ENTRIES, NQ, NV};

/// Calls between two clock readings, as in `side.hpp`.
const BLOCK: usize = 128;

#[derive(Default)]
struct States {
    q: Vec<f64>,
    v: Vec<f64>,
    a: Vec<f64>,
    tau: Vec<f64>,
}

impl States {
    fn read(path: &str) -> Self {
        let bytes = std::fs::read(path).unwrap();
        let numbers = bytes[32..].chunks(8).map(|x| f64::from_le_bytes(x.try_into().unwrap()));
        let numbers: Vec<f64> = numbers.collect();
        let mut states = Self::default();
        for state in numbers.chunks(NQ + 3 * NV) {
            let (q, rest) = state.split_at(NQ);
            let (v, rest) = rest.split_at(NV);
            let (a, tau) = rest.split_at(NV);
            states.q.extend(q);
            states.v.extend(v);
            states.a.extend(a);
            states.tau.extend(tau);
        }
        states
    }

    fn count(&self) -> usize {
        self.q.len() / NQ
    }

    /// The results of one state, or all results of a batch.
    fn call(&self, algorithm: &str, i: usize, out: &mut [f64]) {
        let Self { q, v, a, tau } = self;
        let best = InstructionSet::best();
        match algorithm {
            "inverse_dynamics" => code::inverse_dynamics(row(q, i), row(v, i), row(a, i), array(out)),
            "forward_dynamics" => code::forward_dynamics(row(q, i), row(v, i), row(tau, i), array(out)),
            "mass_matrix" => code::mass_matrix_related(row(q, i), array(out)),
            "inverse_dynamics_batch_f64" => lanes::inverse_dynamics(best, q, v, a, out),
            "forward_dynamics_batch_f64" => lanes::forward_dynamics(best, q, v, tau, out),
            "mass_matrix_batch_f64" => lanes::mass_matrix_related(best, q, out),
            other => panic!("no algorithm {other}"),
        }
    }
}

fn row<const N: usize>(table: &[f64], i: usize) -> &[f64; N] {
    array_of(&table[i * N..][..N])
}

fn array_of<const N: usize>(row: &[f64]) -> &[f64; N] {
    row.try_into().unwrap()
}

fn array<const N: usize>(row: &mut [f64]) -> &mut [f64; N] {
    row.try_into().unwrap()
}

fn main() {
    let arguments: Vec<String> = std::env::args().collect();
    let [_, _, states, algorithm, mode, value] = &arguments[..] else {
        panic!("usage: side RESULTS STATES ALGORITHM (time MS | write FILE)")
    };
    let states = States::read(states);
    let width = if algorithm.starts_with("mass_matrix") { ENTRIES.len() } else { NV };
    let is_batch = algorithm.ends_with("_batch_f64");
    match mode.as_str() {
        "time" => time(&states, algorithm, if is_batch { states.count() } else { 1 }, width, value.parse().unwrap()),
        "write" => write(&states, algorithm, is_batch, width, value),
        other => panic!("time or write, not {other}"),
    }
}

/// Runs one pass to warm up, then for that long; prints median and smallest nanoseconds per state of a block.
fn time(states: &States, algorithm: &str, at_once: usize, width: usize, milliseconds: f64) {
    let mut out = vec![0.0; width * at_once];
    let calls = if at_once == 1 { BLOCK } else { 1 };
    let mut blocks = Vec::new();
    let mut pass = |blocks: &mut Vec<f64>| {
        for first in (0..states.count() / at_once).step_by(calls) {
            let before = Instant::now();
            (first..first + calls).for_each(|i| states.call(algorithm, i, &mut out));
            blocks.push(before.elapsed().as_secs_f64() * 1e9 / (calls * at_once) as f64);
        }
    };
    pass(&mut blocks);
    blocks.clear();
    let start = Instant::now();
    while start.elapsed().as_secs_f64() * 1e3 < milliseconds {
        pass(&mut blocks);
    }
    blocks.sort_by(f64::total_cmp);
    let (median, least) = (blocks[blocks.len() / 2], blocks[0]);
    println!("{{\"median_ns\": {median:.3}, \"min_ns\": {least:.3}, \"blocks\": {}}}", blocks.len());
}

/// The results of all states; M as a dense matrix.
fn write(states: &States, algorithm: &str, is_batch: bool, width: usize, path: &str) {
    let mut out = vec![0.0; width * states.count()];
    if is_batch {
        states.call(algorithm, 0, &mut out);
    } else {
        out.chunks_mut(width).enumerate().for_each(|(i, out)| states.call(algorithm, i, out));
    }
    if algorithm.starts_with("mass_matrix") {
        let dense = |packed: &[f64]| {
            let mut dense = vec![0.0; NV * NV];
            for (&(i, j), &x) in ENTRIES.iter().zip(packed) {
                (dense[i * NV + j], dense[j * NV + i]) = (x, x);
            }
            dense
        };
        out = out.chunks(width).flat_map(dense).collect();
    }
    std::fs::write(path, out.iter().flat_map(|x| x.to_le_bytes()).collect::<Vec<u8>>()).unwrap();
}
