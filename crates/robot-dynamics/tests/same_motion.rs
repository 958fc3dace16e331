//! Compares the runs of `testdata/same_motion`, step by step and as one run, with the table that all front
//! ends are compared with.
#![cfg(feature = "convex")]

use std::fmt::Write;
use std::fs;
use std::path::PathBuf;

use robot_dynamics::contact::Ground;
use robot_dynamics::model::{Model, neutral};
use robot_dynamics::simulation::{Effect, RunOptions, Simulation};
use robot_dynamics::{LoadOptions, load_with, simulation};
use serde_json::Value;

fn folder() -> PathBuf {
    PathBuf::from(env!("CARGO_MANIFEST_DIR")).join("../../testdata/same_motion")
}

#[test]
fn the_table_holds_the_librarys_states() {
    let runs: Value = serde_json::from_str(&fs::read_to_string(folder().join("runs.json")).unwrap()).unwrap();
    let mut lines = String::new();
    for run in runs.as_array().unwrap() {
        let name = run["name"].as_str().unwrap();
        let steps = usize::try_from(run["steps"].as_u64().unwrap()).unwrap();
        let mut stepped = started(run);
        let mut whole = stepped.clone();
        for _ in 0..steps {
            stepped.step().unwrap_or_else(|error| panic!("{name}: {error}"));
        }
        whole
            .run_steps(steps, RunOptions::new().sample_ends())
            .unwrap_or_else(|error| panic!("{name}: {}", error.error));
        assert_eq!((stepped.q(), stepped.v()), (whole.q(), whole.v()), "{name}: stepped and in one run");
        println!(
            "{name}: {}, {:?}, {} contacts",
            stepped.method(),
            stepped.acting(),
            stepped.contacts().len()
        );
        let digits: Vec<String> = stepped.q().iter().chain(stepped.v()).map(f64::to_string).collect();
        writeln!(lines, "{name}\t{}", digits.join(" ")).unwrap();
    }
    let table = folder().join("states.tsv");
    if std::env::var_os("REGENERATE").is_some() {
        fs::write(&table, &lines).unwrap();
    }
    let expected = fs::read_to_string(&table).unwrap();
    // A machine with other rounding has other bits from the first run on.
    let rounds_otherwise = expected.lines().next() != lines.lines().next();
    assert_eq!(expected.lines().count(), lines.lines().count(), "run it with REGENERATE=1");
    for ((expected, found), run) in expected.lines().zip(lines.lines()).zip(runs.as_array().unwrap()) {
        if !rounds_otherwise {
            assert_eq!(expected, found, "run it with REGENERATE=1 and look at the change");
        }
        let allowed = run["rounding"].as_f64().unwrap_or(1e-9);
        let (expected, found) = (numbers(expected), numbers(found));
        let size = expected.iter().fold(1.0, |size: f64, x| size.max(x.abs()));
        assert_eq!(expected.len(), found.len(), "{}", run["name"]);
        for (e, f) in expected.iter().zip(&found) {
            assert!((e - f).abs() <= allowed * size, "{}: {e} and {f}", run["name"]);
        }
    }
}

/// Every kind of effect acts in some run, and every kind of step is used.
#[test]
fn the_runs_cover_what_can_act() {
    let runs: Value = serde_json::from_str(&fs::read_to_string(folder().join("runs.json")).unwrap()).unwrap();
    let all: Vec<Simulation> = runs.as_array().unwrap().iter().map(started).collect();
    for effect in Effect::ALL {
        assert!(all.iter().any(|one| one.acting().contains(&effect)), "{effect}");
    }
    for method in ["rk4", "implicit", "mujoco", "variational-midpoint"] {
        assert!(all.iter().any(|one| one.method().name() == method), "{method}");
    }
}

/// A run at its start.
fn started(run: &Value) -> Simulation {
    let file =
        PathBuf::from(env!("CARGO_MANIFEST_DIR")).join("../../robots").join(run["file"].as_str().unwrap());
    let is_floating = run["floating_base"].as_bool().unwrap_or(false);
    let options =
        if is_floating { LoadOptions::default().with_floating_base() } else { LoadOptions::default() };
    let model =
        load_with(&file, &options).unwrap_or_else(|error| panic!("{}: {error}", file.display())).model;
    let mut builder = simulation(&model).dt(number(&run["step"]));
    if let Some(method) = run["method"].as_str() {
        builder = builder.method(method.parse().unwrap());
    }
    if run["conservative"].as_bool().unwrap_or(false) {
        builder = builder.conservative();
    }
    for effect in run["without"].as_array().into_iter().flatten() {
        builder = builder.without(effect.as_str().unwrap().parse().unwrap());
    }
    if run["ground"].as_bool().unwrap_or(false) {
        builder = builder.ground(Ground::level(0.0));
    }
    let mut simulation = builder.build().unwrap_or_else(|error| panic!("{}: {error}", run["name"]));
    if let Some(pose) = run["pose"].as_str() {
        simulation.reset_to(pose).unwrap();
    } else {
        let mut q = neutral(&model);
        for (joint, values) in given(&run["pose"]) {
            let at = joint_of(&model, &joint).q_index;
            q[at..at + values.len()].copy_from_slice(&values);
        }
        let mut v = vec![0.0; model.nv()];
        for (joint, values) in given(&run["velocity"]) {
            let at = joint_of(&model, &joint).v_index;
            v[at..at + values.len()].copy_from_slice(&values);
        }
        simulation.reset(&q, &v).unwrap();
    }
    let mut controls = simulation.controls().to_vec();
    for (actuator, value) in given(&run["controls"]) {
        let index = simulation.control_names().position(|name| name == actuator).unwrap();
        controls[index] = value[0];
    }
    simulation.set_controls(&controls);
    simulation
}

fn joint_of<'m>(model: &'m Model, name: &str) -> &'m robot_dynamics::model::Joint {
    model.joint(name).unwrap_or_else(|| panic!("no joint {name}"))
}

/// Values by name, each a number or a list.
fn given(object: &Value) -> Vec<(String, Vec<f64>)> {
    let values = |value: &Value| match value.as_array() {
        Some(list) => list.iter().map(number).collect(),
        None => vec![number(value)],
    };
    object.as_object().into_iter().flatten().map(|(name, value)| (name.clone(), values(value))).collect()
}

fn number(value: &Value) -> f64 {
    value.as_f64().unwrap_or_else(|| panic!("{value} is not a number"))
}

fn numbers(line: &str) -> Vec<f64> {
    let (_, list) = line.split_once('\t').unwrap();
    list.split(' ').map(|x| x.parse().unwrap()).collect()
}
