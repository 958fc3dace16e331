//! Clarabel on the quadratic programs that `measure_whole_body -- FILE` writes: medians of the time of a
//! solution, and the largest difference of the cost from ours.
//!
//! A line of the file is a program: minimize ½ |A x − b|² with E x = e and l ≤ C x ≤ u. Clarabel is set up
//! for each program, which the time includes.
//!
//! `cargo run --release --manifest-path bench/peers/quadratic_programs/Cargo.toml -- FILE`

use std::error::Error;
use std::time::Instant;

use clarabel::algebra::CscMatrix;
use clarabel::solver::SupportedConeT::{NonnegativeConeT, ZeroConeT};
use clarabel::solver::{DefaultSettingsBuilder, DefaultSolver, IPSolver};
use serde_json::Value;

type Rows = Vec<Vec<f64>>;

struct Program {
    name: String,
    hessian: Rows,
    gradient: Vec<f64>,
    /// b², so that costs are those of the tasks.
    constant: f64,
    equations: Rows,
    values: Vec<f64>,
    limits: Rows,
    lower: Vec<f64>,
    upper: Vec<f64>,
    cost: f64,
}

fn rows(value: &Value) -> Rows {
    value.as_array().into_iter().flatten().map(|row| numbers(row, 0.0)).collect()
}

fn numbers(value: &Value, missing: f64) -> Vec<f64> {
    value.as_array().into_iter().flatten().map(|x| x.as_f64().unwrap_or(missing)).collect()
}

fn read(line: &str) -> Result<Program, Box<dyn Error>> {
    let value: Value = serde_json::from_str(line)?;
    let (tasks, targets) = (rows(&value["tasks"]), numbers(&value["task_values"], 0.0));
    let n = tasks.first().ok_or("no tasks")?.len();
    let column = |j: usize| tasks.iter().map(move |row| row[j]);
    let hessian = (0..n)
        .map(|i| (0..n).map(|j| column(i).zip(column(j)).map(|(a, b)| a * b).sum()).collect())
        .collect();
    let gradient = (0..n).map(|j| -column(j).zip(&targets).map(|(a, b)| a * b).sum::<f64>()).collect();
    Ok(Program {
        name: value["name"].as_str().unwrap_or_default().to_owned(),
        hessian,
        gradient,
        constant: targets.iter().map(|b| b * b).sum(),
        equations: rows(&value["equations"]),
        values: numbers(&value["equation_values"], 0.0),
        limits: rows(&value["limits"]),
        lower: numbers(&value["lower"], f64::NEG_INFINITY),
        upper: numbers(&value["upper"], f64::INFINITY),
        cost: value["cost"].as_f64().ok_or("no cost")?,
    })
}

impl Program {
    fn cost_of(&self, x: &[f64]) -> f64 {
        let quadratic: f64 = self.hessian.iter().zip(x).map(|(row, x_i)| x_i * dot(row, x)).sum();
        0.5 * (quadratic + self.constant) + dot(&self.gradient, x)
    }
}

fn dot(a: &[f64], b: &[f64]) -> f64 {
    a.iter().zip(b).map(|(a, b)| a * b).sum()
}

/// The columns of rows: starts, indices and values of all entries that `keep` chooses.
fn columns(
    rows: &Rows,
    n: usize,
    keep: impl Fn(usize, usize, f64) -> bool,
) -> (Vec<usize>, Vec<usize>, Vec<f64>) {
    let (mut starts, mut indices, mut values) = (vec![0], Vec::new(), Vec::new());
    for j in 0..n {
        for (i, row) in rows.iter().enumerate().filter(|(i, row)| keep(*i, j, row[j])) {
            indices.push(i);
            values.push(row[j]);
        }
        starts.push(indices.len());
    }
    (starts, indices, values)
}

fn by_clarabel(program: &Program) -> Result<(f64, f64), Box<dyn Error>> {
    let n = program.gradient.len();
    let (mut all, mut right) = (program.equations.clone(), program.values.clone());
    for (row, (lower, upper)) in program.limits.iter().zip(program.lower.iter().zip(&program.upper)) {
        for (sign, bound) in [(1.0, *upper), (-1.0, -lower)] {
            if bound.is_finite() {
                all.push(row.iter().map(|x| sign * x).collect());
                right.push(bound);
            }
        }
    }
    let count = program.equations.len();
    let cones = [ZeroConeT(count), NonnegativeConeT(all.len() - count)];
    let (starts, indices, values) = columns(&program.hessian, n, |i, j, x| i <= j && x != 0.0);
    let hessian = CscMatrix::new(n, n, starts, indices, values);
    let (starts, indices, values) = columns(&all, n, |_, _, x| x != 0.0);
    let matrix = CscMatrix::new(all.len(), n, starts, indices, values);
    let settings = DefaultSettingsBuilder::default().verbose(false).build()?;
    let start = Instant::now();
    let mut solver = DefaultSolver::new(&hessian, &program.gradient, &matrix, &right, &cones, settings)?;
    solver.solve();
    let spent = start.elapsed().as_secs_f64();
    Ok((1e6 * spent, (program.cost_of(&solver.solution.x) - program.cost).abs() / (1.0 + program.cost)))
}

fn print(name: &str, results: &mut [(f64, f64)]) {
    results.sort_by(|a, b| a.0.total_cmp(&b.0));
    let worst = results.iter().fold(0.0_f64, |most, (_, off)| most.max(*off));
    println!("{name}, Clarabel: {:.1} µs, costs within {worst:.1e}", results[results.len() / 2].0);
}

fn main() -> Result<(), Box<dyn Error>> {
    let path = std::env::args().nth(1).ok_or("name the file of `measure_whole_body -- FILE`")?;
    let programs: Vec<Program> =
        std::fs::read_to_string(path)?.lines().map(read).collect::<Result<_, _>>()?;
    let mut names: Vec<&str> = programs.iter().map(|program| program.name.as_str()).collect();
    names.dedup();
    for name in names {
        let own: Vec<&Program> = programs.iter().filter(|program| program.name == name).collect();
        let mut results = own.iter().map(|program| by_clarabel(program)).collect::<Result<Vec<_>, _>>()?;
        print(name, &mut results);
    }
    Ok(())
}
