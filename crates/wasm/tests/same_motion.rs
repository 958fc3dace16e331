//! The runs of `testdata/same_motion` by the lab's robot, compiled natively, against the library's table.

use std::fs;
use std::path::PathBuf;

use serde_json::Value;
use wasm::{LabError, Robot};

/// The effects that `conservative` switches off.
const LOSSY: [&str; 5] = ["dissipation", "limits", "effort-limits", "actuators", "contacts"];

#[test]
fn the_lab_takes_the_librarys_steps() -> Result<(), LabError> {
    let folder = PathBuf::from(env!("CARGO_MANIFEST_DIR")).join("../..");
    let read = |path: &str| fs::read_to_string(folder.join(path));
    let runs: Value = serde_json::from_str(&read("testdata/same_motion/runs.json")?)?;
    let table = read("testdata/same_motion/states.tsv")?;
    let runs = runs.as_array().into_iter().flatten();
    let mut rounds_otherwise = None;
    for (run, line) in runs.zip(table.lines()) {
        let text = |key: &str| run[key].as_str().unwrap_or_default();
        let file = read(&format!("robots/{}", text("file")))?;
        let found = state_after(run, &file)?;
        let (name, numbers) = line.split_once('\t').unwrap_or_default();
        assert_eq!(name, text("name"));
        let expected: Vec<f64> = numbers.split(' ').map(str::parse).collect::<Result<_, _>>()?;
        // On a machine with other rounding, all bits differ from the first run on.
        let rounds_otherwise = *rounds_otherwise.get_or_insert(found != expected);
        if !rounds_otherwise {
            assert_eq!(found, expected, "{}", text("name"));
        }
        let allowed = run["rounding"].as_f64().unwrap_or(1e-9);
        let size = expected.iter().fold(1.0, |size: f64, x| size.max(x.abs()));
        assert_eq!(found.len(), expected.len(), "{}", text("name"));
        for (f, e) in found.iter().zip(&expected) {
            assert!((f - e).abs() <= allowed * size, "{}: {f} and {e}", text("name"));
        }
    }
    assert!(rounds_otherwise.is_some(), "there are no runs");
    Ok(())
}

fn state_after(run: &Value, file: &str) -> Result<Vec<f64>, LabError> {
    let is_set = |key: &str| run[key].as_bool().unwrap_or(false);
    let mut robot = Robot::load(file, is_set("floating_base"), false)?;
    let mut off: Vec<String> =
        if is_set("conservative") { LOSSY.map(str::to_owned).to_vec() } else { Vec::new() };
    off.extend(run["without"].as_array().into_iter().flatten().filter_map(Value::as_str).map(str::to_owned));
    robot.choose(run["method"].as_str().unwrap_or(""), number(&run["step"]), off)?;
    robot.set_ground(is_set("ground"))?;
    let (mut q, mut v) = (robot.q(), robot.v());
    let mut controls = vec![0.0; robot.actuators().len()];
    if let Some(name) = run["pose"].as_str() {
        let poses = robot.named_poses();
        let pose = poses.iter().find(|pose| pose.name == name).expect("a pose of the file");
        (q, v) = (pose.q.clone(), pose.v.clone());
        if !pose.controls.is_empty() {
            controls.clone_from(&pose.controls);
        }
    }
    let coordinates = robot.coordinates();
    for (joint, value) in entries(&run["pose"]) {
        if let Some(list) = value.as_array() {
            // This list contains the numbers of the base, which is first.
            list.iter().zip(&mut q).for_each(|(x, q)| *q = number(x));
        } else {
            let place = coordinates.iter().find(|one| one.name == *joint).and_then(|one| one.place);
            q[place.expect("a joint with one number") as usize] = number(value);
        }
    }
    for (joint, value) in entries(&run["velocity"]) {
        v[coordinates.iter().position(|one| one.name == *joint).expect("a joint")] = number(value);
    }
    for (actuator, value) in entries(&run["controls"]) {
        controls[robot.actuators().iter().position(|one| one.name == *actuator).expect("an actuator")] =
            number(value);
    }
    robot.place_moving(&q, &v)?;
    robot.set_controls(&controls)?;
    robot.advance(u32::try_from(run["steps"].as_u64().unwrap_or(0))?)?;
    Ok([robot.q(), robot.v()].concat())
}

fn entries(object: &Value) -> impl Iterator<Item = (&String, &Value)> {
    object.as_object().into_iter().flatten()
}

fn number(value: &Value) -> f64 {
    value.as_f64().unwrap_or(f64::NAN)
}
