//! Measurements of the repository's robots: all rows exist, and the numbers are consistent.

use std::io::{BufRead, BufReader, Read};

use robot_dynamics::quantity::Quantity;
use serde_json::Value;

use crate::command::{Folder, RunOutput};

/// Quantities of single states, by their names in the library.
const SINGLE: [&str; 9] = [
    "inverse_dynamics",
    "forward_dynamics",
    "mass_matrix",
    "coriolis_matrix",
    "inverse_mass_matrix",
    "frame_poses",
    "frame_jacobian_local_world_aligned",
    "inverse_dynamics_derivatives",
    "forward_dynamics_derivatives",
];
const BATCH: [&str; 6] = [
    "inverse_dynamics",
    "forward_dynamics",
    "mass_matrix",
    "inverse_mass_matrix",
    "frame_poses",
    "frame_jacobian_local_world_aligned",
];
const ROLLOUT: [&str; 2] = ["semi_implicit_euler", "rk4"];

/// The output of a measurement. A debug build, as in tests, has one warning.
#[track_caller]
fn measured(ran: &RunOutput) -> &str {
    assert_eq!(ran.code, Some(0), "{ran:?}");
    assert_eq!(ran.err.lines().count(), usize::from(cfg!(debug_assertions)), "{}", ran.err);
    &ran.out
}

fn lines(text: &str) -> Vec<Value> {
    text.lines().map(|line| serde_json::from_str(line).unwrap_or_else(|e| panic!("{line}: {e}"))).collect()
}

#[test]
fn every_quantity_has_a_line() {
    let folder = Folder::new("bench_json");
    let ran =
        folder.run(&["bench", "panda.urdf", "--quick", "--json", "--threads", "3", "--states", "1024"], b"");
    let lines = lines(measured(&ran));
    let head = &lines[0];
    assert_eq!((&head["robot"], &head["nv"]), (&"panda".into(), &7.into()));
    assert_eq!((&head["tip"], &head["interrupted"]), (&"panda_link7".into(), &false.into()));
    let build = if cfg!(debug_assertions) { "debug" } else { "release" };
    assert_eq!(head["machine"]["build"], build);
    assert!(head["machine"]["threads"].as_u64().unwrap() >= 1);
    let expected: Vec<(&str, &str, &str, u64)> = SINGLE
        .into_iter()
        .map(|quantity| ("single", quantity, "f64", 1))
        .chain([("batch", &BATCH[..]), ("rollout", &ROLLOUT[..])].into_iter().flat_map(|(group, list)| {
            let numbers = list.iter().flat_map(|&quantity| [(quantity, "f64"), (quantity, "f32")]);
            numbers
                .flat_map(move |(quantity, number)| [1, 3].map(|threads| (group, quantity, number, threads)))
        }))
        .chain([("batch", "forward_dynamics", "f64", 2)])
        .collect();
    let text = |line: &Value, key: &str| line[key].as_str().unwrap().to_owned();
    let found: Vec<_> = lines[1..]
        .iter()
        .map(|x| (text(x, "group"), text(x, "quantity"), text(x, "number"), x["threads"].as_u64().unwrap()))
        .collect();
    assert_eq!(found.len(), expected.len());
    for (found, expected) in found.iter().zip(&expected) {
        assert_eq!((found.0.as_str(), found.1.as_str(), found.2.as_str(), found.3), *expected);
    }
    for line in &lines[1..] {
        let number = |value: &Value| value.as_f64().unwrap_or_else(|| panic!("{line}"));
        let (ns, rate) = (number(&line["ns"]), number(&line["per_second"]));
        let [least, most] = [0, 1].map(|i| number(&line["spread_ns"][i]));
        assert!(0.0 < least && least <= ns && ns <= most && most.is_finite(), "{line}");
        // A number and its inverse, each rounded once.
        assert!((ns * rate * 1e-9 - 1.0).abs() < 1e-12, "{line}");
        assert_eq!((&line["rounds"], &line["trouble"]), (&3.into(), &Value::Null), "{line}");
        assert_eq!(line["per"], if line["group"] == "rollout" { "step" } else { "state" });
    }
}

#[test]
fn the_tables_have_every_row() {
    let folder = Folder::new("bench_table");
    for robot in ["two_r.urdf", "humanoid.urdf"] {
        let ran = folder.run(&["bench", robot, "--quick", "--threads", "2"], b"");
        let text = measured(&ran);
        let first = text.lines().next().unwrap();
        assert!(first.contains(robot) && first.contains("degrees of freedom"), "{first}");
        // One row for single states, and one for batches of f64 and of f32.
        let titles = Quantity::ALL.iter().filter(|quantity| SINGLE.contains(&quantity.name()));
        let quantities =
            titles.map(|quantity| (quantity.title(), if BATCH.contains(&quantity.name()) { 3 } else { 1 }));
        let others = [("semi-implicit-euler", 2), ("rk4", 2), ("1 thread ", 1), ("2 threads ", 1)];
        for (row, times) in quantities.chain(others) {
            let rows = text.lines().filter(|line| line.trim_start().starts_with(row));
            assert_eq!(rows.count(), times, "{robot}: {row}\n{text}");
        }
        assert!(!text.contains("none") && !text.contains("NaN") && !text.contains(" - "), "{robot}\n{text}");
    }
}

/// An inertia of 1e-60 kg·m² is nonzero in f64 and zero in f32, where results that divide by it have no time.
#[test]
fn quantities_without_result_have_no_time() {
    let folder = Folder::new("bench_singular");
    let link = |name: &str, mass: &str| {
        format!(
            "<link name=\"{name}\"><inertial><mass value=\"{mass}\"/><inertia ixx=\"{mass}\" ixy=\"0\" ixz=\"0\" \
             iyy=\"{mass}\" iyz=\"0\" izz=\"{mass}\"/></inertial></link>"
        )
    };
    let joint = |name: &str, parent: &str, child: &str| {
        format!(
            "<joint name=\"{name}\" type=\"continuous\"><parent link=\"{parent}\"/><child link=\"{child}\"/></joint>"
        )
    };
    let robot = [
        "<robot name=\"mote\"><link name=\"base\"/>".to_owned(),
        link("first", "1"),
        link("second", "1e-60"),
        joint("one", "base", "first"),
        joint("two", "first", "second"),
        "</robot>".to_owned(),
    ];
    folder.write("mote.urdf", robot.concat().as_bytes());
    let ran = folder.run(&["bench", "mote.urdf", "--quick", "--json"], b"");
    let mut troubles = Vec::new();
    for line in &lines(measured(&ran))[1..] {
        let divides = ["forward_dynamics", "inverse_mass_matrix", "semi_implicit_euler", "rk4"];
        if line["number"] == "f32" && divides.contains(&line["quantity"].as_str().unwrap()) {
            assert!(line["ns"].is_null() && line["trouble"].is_string(), "{line}");
            troubles.push(line["trouble"].as_str().unwrap().to_owned());
        } else {
            assert!(line["ns"].is_number() && line["trouble"].is_null(), "{line}");
        }
    }
    assert!(troubles.len() >= 4, "{troubles:?}");
    let text = folder.run(&["bench", "mote.urdf", "--quick"], b"").out;
    let rows = text.lines().filter(|line| troubles.iter().any(|trouble| line.ends_with(trouble)));
    assert_eq!(rows.count(), 4, "a line for each quantity:\n{text}");
}

#[test]
fn wrong_calls_are_refused() {
    let folder = Folder::new("bench_wrong");
    folder.write("broken.urdf", b"<robot");
    folder.write("still.urdf", b"<robot name=\"still\"><link name=\"stone\"/></robot>");
    for (arguments, code) in [
        (&["bench", "broken.urdf"][..], 1),
        (&["bench", "missing.urdf"], 1),
        (&["bench", "still.urdf"], 1),
        (&["bench"], 2),
        (&["bench", "panda.urdf", "--states", "10"], 2),
        (&["bench", "panda.urdf", "--threads", "many"], 2),
    ] {
        let ran = folder.run(arguments, b"");
        assert_eq!((ran.code, ran.out.as_str()), (Some(code), ""), "{arguments:?}");
        assert_eq!(ran.err.lines().count(), 1, "{arguments:?}: {}", ran.err);
    }
}

/// Ctrl-C gives exit code 130 and the results so far.
#[cfg(unix)]
#[test]
fn an_interruption_keeps_what_was_measured() {
    let folder = Folder::new("bench_interrupted");
    let mut child = folder.command(&["bench", "humanoid.urdf", "--json"]).spawn().unwrap();
    let mut told = BufReader::new(child.stderr.take().unwrap());
    let mut err = String::new();
    if cfg!(debug_assertions) {
        // The handler for Ctrl-C is installed before the warning.
        told.read_line(&mut err).unwrap();
    } else {
        std::thread::sleep(std::time::Duration::from_millis(1500));
    }
    let id = child.id().to_string();
    assert!(std::process::Command::new("kill").args(["-INT", &id]).status().unwrap().success());
    let output = child.wait_with_output().unwrap();
    assert_eq!(output.status.code(), Some(130));
    told.read_to_string(&mut err).unwrap();
    assert_eq!(err.lines().count(), 1 + usize::from(cfg!(debug_assertions)), "{err}");
    let out = String::from_utf8(output.stdout).unwrap();
    let lines = lines(&out);
    assert_eq!(lines[0]["interrupted"], true);
    assert!(lines[1]["ns"].as_f64().unwrap() > 0.0);
    assert!(lines.last().unwrap()["rounds"].as_u64().unwrap() < 5);
}
