//! The library's side of `bench/generated_lanes.py`: batches of one robot on one thread.
//!
//! `lanes_side ROBOT.urdf (fixed|floating) STATES MILLISECONDS FOLDER` prints a line `function median_ns least_ns` for each function and
//! writes its results to `FOLDER/function.bin`; the file of states is that of `bench/peers/side.hpp`.

use std::process::ExitCode;
use std::time::Instant;

use bench::{StateTable, robot_of_file};
use multibody::batch::{self, BadStates, BatchOptions, BatchWorkspace};
use multibody::{InstructionSet, Model};

const USAGE: &str = "usage: lanes_side ROBOT.urdf (fixed|floating) STATES MILLISECONDS FOLDER";

fn main() -> ExitCode {
    let arguments: Vec<String> = std::env::args().skip(1).collect();
    match run(&arguments) {
        Ok(()) => ExitCode::SUCCESS,
        Err(error) => {
            eprintln!("{error}");
            ExitCode::FAILURE
        }
    }
}

/// q, v, a and tau of all states.
type Tables = [Vec<f64>; 4];

/// Computes one function of all states.
type Function = fn(&Model, &mut BatchWorkspace<f64>, &Tables, &mut [f64]) -> Result<(), BadStates>;

fn run(arguments: &[String]) -> Result<(), Box<dyn std::error::Error>> {
    let [robot, base, states, milliseconds, folder] = arguments else { return Err(USAGE.into()) };
    let model = robot_of_file(robot, base == "floating")?;
    let milliseconds: f64 = milliseconds.parse()?;
    let states = StateTable::read(states)?;
    if states.dimensions() != (model.nq(), model.nv()) {
        return Err(format!("states of another robot than {}", model.name()).into());
    }
    let mut tables: Tables = Default::default();
    for i in 0..states.count() {
        for (table, row) in tables.iter_mut().zip(states.get(i)) {
            table.extend(row);
        }
    }
    let mut options = BatchOptions::default();
    options.threads = 1;
    let mut workspace = BatchWorkspace::<f64>::with_options(&model, options)?;
    eprintln!("{}", InstructionSet::best());
    let (nv, related) = (model.nv(), multibody::mass_matrix_related_entries(&model).len());
    let functions: [(&str, usize, Function); 4] = [
        ("inverse_dynamics", nv, |model, w, [q, v, a, _], out| {
            batch::inverse_dynamics(model, w, q, v, a, out)
        }),
        ("forward_dynamics", nv, |model, w, [q, v, _, tau], out| {
            batch::forward_dynamics(model, w, q, v, tau, out)
        }),
        ("mass_matrix", nv * nv, |model, w, [q, ..], out| batch::mass_matrix(model, w, q, out)),
        ("mass_matrix_related", related, |model, w, [q, ..], out| {
            batch::mass_matrix_related(model, w, q, out)
        }),
    ];
    for (name, width, compute) in functions {
        let mut out = vec![0.0; width * states.count()];
        compute(&model, &mut workspace, &tables, &mut out)?;
        let mut times = Vec::new();
        let start = Instant::now();
        while times.is_empty() || start.elapsed().as_secs_f64() * 1e3 < milliseconds {
            let before = Instant::now();
            compute(&model, &mut workspace, &tables, &mut out)?;
            times.push(before.elapsed().as_secs_f64() * 1e9 / states.count() as f64);
        }
        times.sort_by(f64::total_cmp);
        println!("{name} {:.2} {:.2}", times[times.len() / 2], times[0]);
        let bytes: Vec<u8> = out.iter().flat_map(|x| x.to_le_bytes()).collect();
        std::fs::write(std::path::Path::new(folder).join(format!("{name}.bin")), bytes)?;
    }
    Ok(())
}
