//! The runs of `testdata/same_motion` by the command, whose last row of CSV is compared with the library's
//! table.

use std::fs;
use std::path::Path;

use serde_json::Value;

use crate::command::Folder;

#[test]
fn the_last_row_is_the_librarys_state() {
    let data = Path::new(env!("CARGO_MANIFEST_DIR")).join("../../testdata/same_motion");
    let runs: Value = serde_json::from_str(&fs::read_to_string(data.join("runs.json")).unwrap()).unwrap();
    let table = fs::read_to_string(data.join("states.tsv")).unwrap();
    let folder = Folder::new("same_motion");
    let mut rounds_otherwise = None;
    assert_eq!(runs.as_array().unwrap().len(), table.lines().count());
    for (run, line) in runs.as_array().unwrap().iter().zip(table.lines()) {
        let (name, expected) = line.split_once('\t').unwrap();
        assert_eq!(name, run["name"].as_str().unwrap());
        let file = run["file"].as_str().unwrap();
        folder.write(file, &fs::read(data.join("../../robots").join(file)).unwrap());
        let arguments = arguments(run);
        let ran = folder.run(&arguments.iter().map(String::as_str).collect::<Vec<_>>(), b"");
        assert_eq!(ran.code, Some(0), "{arguments:?}: {}", ran.err);
        let expected: Vec<f64> = expected.split(' ').map(|x| x.parse().unwrap()).collect();
        let last = folder.read("run.csv");
        // q and v follow the time.
        let row = last.lines().last().unwrap().split(',').skip(1).take(expected.len());
        let found: Vec<f64> = row.map(|x| x.parse().unwrap()).collect();
        // On a machine with other rounding, all bits differ from the first run on.
        let rounds_otherwise = *rounds_otherwise.get_or_insert(found != expected);
        if !rounds_otherwise {
            assert_eq!(found, expected, "{name}");
        }
        let allowed = run["rounding"].as_f64().unwrap_or(1e-9);
        let size = expected.iter().fold(1.0, |size: f64, x| size.max(x.abs()));
        for (f, e) in found.iter().zip(&expected) {
            assert!((f - e).abs() <= allowed * size, "{name}: {f} and {e}");
        }
    }
}

/// The arguments that a user writes for this run.
fn arguments(run: &Value) -> Vec<String> {
    let step = run["step"].as_f64().unwrap();
    let duration = (step * run["steps"].as_f64().unwrap()).to_string();
    let mut all: Vec<String> =
        ["simulate", run["file"].as_str().unwrap(), "--csv", "run.csv", "--sample-period", "1e6"]
            .map(str::to_owned)
            .into();
    all.extend(["--dt".to_owned(), step.to_string(), "--duration".to_owned(), duration]);
    let mut add = |option: &str, value: String| {
        all.push(option.to_owned());
        if !value.is_empty() {
            all.push(value);
        }
    };
    for (key, option) in [("floating_base", "--floating-base"), ("conservative", "--conservative")] {
        if run[key].as_bool().unwrap_or(false) {
            add(option, String::new());
        }
    }
    if run["ground"].as_bool().unwrap_or(false) {
        add("--ground", "z=0".into());
    }
    if let Some(method) = run["method"].as_str() {
        add("--integrator", method.into());
    }
    for effect in run["without"].as_array().into_iter().flatten() {
        add("--without", effect.as_str().unwrap().into());
    }
    if let Some(pose) = run["pose"].as_str() {
        add("--pose", pose.into());
    }
    for (key, option) in [("pose", "--pose"), ("velocity", "--velocity"), ("controls", "--controls")] {
        let listed: Vec<String> = run[key].as_object().into_iter().flatten().map(assignment).collect();
        if !listed.is_empty() {
            add(option, listed.join(","));
        }
    }
    all
}

/// `name=number` or `name=number,number,…`.
fn assignment((name, value): (&String, &Value)) -> String {
    let numbers = match value.as_array() {
        Some(list) => list.iter().map(Value::to_string).collect::<Vec<_>>().join(","),
        None => value.to_string(),
    };
    format!("{name}={numbers}")
}
