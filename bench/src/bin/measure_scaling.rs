//! Measures the growth of the cost with the size of the robot, by every route of this machine, and counts
//! operations.
//!
//! `cargo run --release -p bench --bin measure_scaling -- docs/performance/scaling.jsonl`
//!
//! The first line of the file is the machine. Then there is one JSON line for each robot, algorithm and
//! route, and one with the operations of each robot and algorithm. Every round measures everything once. A
//! record has the median of the rounds' medians, and the smallest time of all, which is steadier on a shared
//! machine.

use std::path::PathBuf;
use std::process::{Command, ExitCode};
use std::time::{Duration, Instant};

use bench::{BatchTask, Counted, Counts, StateTable, Task, all_robots, key, robot_by_name, tally};
use robot_dynamics::batch::BatchOptions;
use robot_dynamics::model::{InstructionSet, Model, Workspace};
use robot_dynamics::quantity::Quantity;
use robot_dynamics_number::Scalar;
use serde_json::{Value, json};

const STATES: usize = 1024;
const SEED: u64 = 20260;
const ROUNDS: usize = 9;
const SLICE: Duration = Duration::from_millis(20);
/// States between two clock readings, which are slow for a WebAssembly module.
const BLOCK: usize = if cfg!(target_family = "wasm") { 256 } else { 32 };

const RECURSIONS: [Quantity; 3] =
    [Quantity::InverseDynamics, Quantity::ForwardDynamics, Quantity::MassMatrix];
const KINEMATICS: [Quantity; 3] =
    [Quantity::CoriolisMatrix, Quantity::FramePoses, Quantity::FrameJacobianLocalWorldAligned];

fn main() -> ExitCode {
    let mut arguments = std::env::args().skip(1);
    let Some(path) = arguments.next().map(PathBuf::from) else {
        eprintln!("usage: measure_scaling FILE.jsonl [ROBOT …]");
        return ExitCode::FAILURE;
    };
    match measured(&arguments.collect::<Vec<_>>()) {
        Ok(lines) => {
            let lines: Vec<String> = lines.iter().map(Value::to_string).collect();
            let text = lines.join("\n") + "\n";
            let written = path
                .parent()
                .map_or(Ok(()), std::fs::create_dir_all)
                .and_then(|()| std::fs::write(&path, text));
            if let Err(error) = written {
                eprintln!("cannot write {}: {error}", path.display());
                return ExitCode::FAILURE;
            }
            ExitCode::SUCCESS
        }
        Err(error) => {
            eprintln!("{error}");
            ExitCode::FAILURE
        }
    }
}

/// The named robots, or all.
fn measured(names: &[String]) -> Result<Vec<Value>, Box<dyn std::error::Error>> {
    let mut lines = vec![json!({ "machine": machine()? })];
    let named: Result<Vec<Model>, _> = names.iter().map(|name| robot_by_name(name)).collect();
    for model in if names.is_empty() { all_robots()? } else { named? } {
        eprintln!("{}", model.name());
        let states = StateTable::random(&model, STATES, SEED);
        let mut items = items(&model, &states);
        for _ in 0..ROUNDS {
            items.iter_mut().for_each(Item::round);
        }
        lines.extend(items.into_iter().map(|item| item.record(&model)));
        for algorithm in RECURSIONS {
            let tally = tally(|| count(&model, algorithm));
            lines.push(json!({
                "robot": model.name(), "nv": model.nv(), "algorithm": key(algorithm),
                "done": record_of(tally.done), "left": record_of(tally.left),
            }));
        }
    }
    Ok(lines)
}

/// One algorithm by one route.
struct Item<'a> {
    algorithm: Quantity,
    /// "one state", or "batch".
    form: &'static str,
    number: &'static str,
    instructions: InstructionSet,
    /// Computes some states. Returns how many.
    block: Box<dyn FnMut() -> usize + 'a>,
    medians: Vec<f64>,
    least: f64,
}

impl Item<'_> {
    fn round(&mut self) {
        (self.block)();
        let (start, mut times) = (Instant::now(), Vec::new());
        while times.is_empty() || start.elapsed() < SLICE {
            let before = Instant::now();
            let states = (self.block)();
            times.push(before.elapsed().as_secs_f64() * 1e9 / states as f64);
        }
        times.sort_by(f64::total_cmp);
        self.medians.push(times[times.len() / 2]);
        self.least = self.least.min(times[0]);
    }

    fn record(mut self, model: &Model) -> Value {
        self.medians.sort_by(f64::total_cmp);
        json!({
            "robot": model.name(), "nv": model.nv(), "algorithm": key(self.algorithm),
            "form": self.form, "number": self.number, "instructions": self.instructions.to_string(),
            "ns": rounded(self.medians[self.medians.len() / 2]), "least_ns": rounded(self.least),
        })
    }
}

/// Rounds to a hundredth of a nanosecond.
fn rounded(x: f64) -> f64 {
    (x * 100.0).round() / 100.0
}

/// All measurements of a robot.
fn items<'a>(model: &'a Model, states: &'a StateTable) -> Vec<Item<'a>> {
    let mut items = Vec::new();
    let derivatives = [Quantity::InverseDynamicsDerivatives, Quantity::ForwardDynamicsDerivatives];
    let singles =
        RECURSIONS.into_iter().chain(KINEMATICS).chain(derivatives).map(|algorithm| (algorithm, false));
    for (algorithm, portable) in singles.chain(RECURSIONS.map(|algorithm| (algorithm, true))) {
        let instructions =
            if portable { InstructionSet::Portable } else { Workspace::<f64>::new(model).instruction_set() };
        let mut task = if portable { Task::portable(model, states) } else { Task::new(model, states) };
        let mut first = 0;
        let block = move || {
            (first..first + BLOCK).for_each(|i| task.call(algorithm, i));
            first = (first + BLOCK) % STATES;
            BLOCK
        };
        items.push(item(algorithm, "one state", "f64", instructions, Box::new(block)));
    }
    for instructions in InstructionSet::ALL.iter().copied().filter(|set| set.is_available()) {
        for algorithm in RECURSIONS {
            let mut options = BatchOptions::default();
            options.threads = 1;
            options.limit = Some(instructions);
            // A thousand mass matrices of a long chain would not fit any cache.
            let states = states.first((STATES * 38 / model.nv()).clamp(64, STATES));
            let mut doubles = BatchTask::<f64>::new(model, &states, 1, options);
            let mut singles = BatchTask::<f32>::new(model, &states, 1, options);
            let block = move || {
                doubles.call(algorithm);
                doubles.count()
            };
            items.push(item(algorithm, "batch", "f64", instructions, Box::new(block)));
            let block = move || {
                singles.call(algorithm);
                singles.count()
            };
            items.push(item(algorithm, "batch", "f32", instructions, Box::new(block)));
        }
    }
    items
}

fn item<'a>(
    algorithm: Quantity,
    form: &'static str,
    number: &'static str,
    instructions: InstructionSet,
    block: Box<dyn FnMut() -> usize + 'a>,
) -> Item<'a> {
    Item { algorithm, form, number, instructions, block, medians: Vec::new(), least: f64::INFINITY }
}

/// Runs an algorithm over counting numbers.
fn count(model: &Model, algorithm: Quantity) {
    let (w, nv) = (&mut Workspace::<Counted>::new(model), model.nv());
    let (q, v) = (vec![Counted::UNKNOWN; model.nq()], vec![Counted::UNKNOWN; nv]);
    let (other, mut vector) = (v.clone(), v.clone());
    let mut matrix = vec![Counted::zero(); nv * nv];
    match algorithm {
        Quantity::InverseDynamics => {
            robot_dynamics::algorithms::inverse_dynamics(model, w, &q, &v, &other, &mut vector);
        }
        Quantity::ForwardDynamics => {
            robot_dynamics::algorithms::forward_dynamics(model, w, &q, &v, &other, &mut vector);
        }
        _ => robot_dynamics::algorithms::mass_matrix(model, w, &q, &mut matrix),
    }
}

fn record_of(counts: Counts) -> Value {
    let Counts { additions, multiplications, fused, divisions, roots, sines } = counts;
    json!({
        "additions": additions, "multiplications": multiplications, "fused": fused, "divisions": divisions,
        "roots": roots, "sines": sines, "arithmetic": counts.arithmetic(), "instructions": counts.instructions(),
    })
}

/// The machine, and the smallest time of a fused multiply-add.
fn machine() -> Result<Value, Box<dyn std::error::Error>> {
    let said = |program: &str, arguments: &[&str]| -> Option<String> {
        let output =
            Command::new(program).args(arguments).output().ok().filter(|output| output.status.success())?;
        Some(String::from_utf8_lossy(&output.stdout).trim().to_owned())
    };
    let info = std::fs::read_to_string("/proc/cpuinfo").unwrap_or_default();
    let processor =
        info.lines().find(|line| line.starts_with("model name")).and_then(|line| line.split_once(": "));
    let root = concat!(env!("CARGO_MANIFEST_DIR"), "/peak.rs");
    let mut peak = Value::Null;
    // A WebAssembly module cannot start programs and has no folder for them.
    if !cfg!(target_family = "wasm") {
        let program = std::env::temp_dir().join(format!("peak_{}", std::process::id()));
        let shown = program.to_string_lossy().into_owned();
        let flags = ["--edition", "2024", "-C", "opt-level=3", "-C", "target-cpu=native", root, "-o", &shown];
        if let Some(text) = said("rustc", &flags).and_then(|_| said(&shown, &[])) {
            peak = serde_json::from_str(&text)?;
        }
        let _ = std::fs::remove_file(program);
    }
    Ok(json!({
        "processor": processor.map(|(_, name)| name), "cores": std::thread::available_parallelism().map_or(1, usize::from),
        "system": std::env::consts::OS, "rustc": said("rustc", &["--version"]), "peak": peak,
        "states": STATES, "rounds": ROUNDS,
    }))
}
