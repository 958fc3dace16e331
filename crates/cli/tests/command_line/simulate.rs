//! Runs of `dynamics simulate`: printed text, files, and the results of runs that end early.

use std::fs;

use crate::command::Folder;
use crate::labels::{
    DRIFT, EVALUATIONS, FRICTION, FRICTION_AMONG_OTHERS, FROM_GOAL, INTERRUPTED, STOPS, UNACCOUNTED,
    number_after,
};

/// Free motion without losses: ten seconds of the Panda from the middle of its limits.
#[test]
fn panda_keeps_its_energy() {
    let folder = Folder::new("panda");
    let text = folder.output(&["simulate", "panda.urdf", "--conservative"], "");
    assert!(text.starts_with("panda (panda.urdf): 7 degrees of freedom, 16.06 kg\n"), "{text}");
    assert!(text.contains("rk4, 10000 steps of 0.001 s, 10 s"), "{text}");
    // After about four seconds rounding determines the motion, and with it the drift. Before, the drift is
    // that of a method of order 4.
    let drift = |step: &str| {
        let text =
            folder.output(&["simulate", "panda.urdf", "--conservative", "--duration", "2", "--dt", step], "");
        number_after(&text, DRIFT)
    };
    let (whole, half) = (drift("0.001"), drift("0.0005"));
    assert!(whole > 4e-8 && whole < 5e-8, "drift {whole}");
    assert!((whole / half - 16.0).abs() < 1.0, "drift {whole}, with half the step {half}");
}

/// Without flags all effects act: the Panda falls onto its limits, and the energy balance includes their
/// losses.
#[test]
fn panda_without_flags_stops_at_its_limits() {
    let folder = Folder::new("panda_stops");
    let text = folder.output(&["simulate", "panda.urdf", "--duration", "3"], "");
    assert!(text.contains("implicit, 3000 steps of 0.001 s, 3 s"), "{text}");
    assert!(number_after(&text, STOPS) > 1.0, "{text}");
    // The residual is of order h², from the swing between the stops.
    assert!(number_after(&text, UNACCOUNTED) < 1e-3, "{text}");
}

/// Samples are thinned at 4096. A run that ends with that sample shows it.
#[test]
fn the_table_ends_where_the_run_does() {
    let folder = Folder::new("thinned");
    let text = folder.output(&["simulate", "panda.urdf", "--conservative", "--duration", "4.095"], "");
    let rows = text.lines().skip_while(|line| !line.contains("t [s]")).skip(1);
    let times = rows.map_while(|line| line.split_whitespace().next()?.parse::<f64>().ok());
    assert_eq!(times.last(), Some(4.095), "{text}");
}

/// E0 by hand from `compute`, and the same E at the end, to the printed digits.
#[test]
fn the_table_shows_energies() {
    let folder = Folder::new("energies");
    let run = [
        "simulate",
        "two_r.urdf",
        "--pose",
        "shoulder=0.5,elbow=-1",
        "--velocity",
        "elbow=2",
        "--duration",
        "1",
    ];
    let text = folder.output(&run, "");
    let state = "{\"q\":[0.5,-1],\"v\":[0,2]}\n";
    let answer: serde_json::Value =
        serde_json::from_str(&folder.output(&["compute", "two_r.urdf"], state)).unwrap();
    let energy = answer["kinetic_energy"].as_f64().unwrap() + answer["potential_energy"].as_f64().unwrap();
    let shown = format!("{energy:.6}");
    let rows = text.lines().filter(|line| line.split_whitespace().nth(3) == Some(shown.as_str())).count();
    assert_eq!(rows, 6, "E = {shown} at six times in\n{text}");
}

/// The CSV file has every sample, a header, numbers in every cell, the exact last time, and E to the printed
/// digits.
#[test]
fn csv_holds_every_sample() {
    let folder = Folder::new("csv");
    let run = ["simulate", "two_r.urdf", "--duration", "0.5", "--csv", "run.csv"];
    let text = folder.output(&run, "");
    assert!(text.contains("run.csv (501 "), "{text}");
    let csv = folder.read("run.csv");
    let mut lines = csv.lines();
    assert_eq!(
        lines.next().unwrap(),
        "t [s],q shoulder [rad],q elbow [rad],v shoulder [rad/s],v elbow [rad/s],tau shoulder [N m],tau elbow [N m],\
         K [J],V [J],E [J],energy error [J]"
    );
    let rows: Vec<Vec<f64>> =
        lines.map(|line| line.split(',').map(|cell| cell.parse().unwrap()).collect()).collect();
    assert_eq!(rows.len(), 501);
    assert!(rows.iter().all(|row| row.len() == 11 && row[5] == 0.0 && row[6] == 0.0));
    assert_eq!((rows[0][0], rows[500][0]), (0.0, 0.5));
    assert!(
        rows.iter().all(|row| (row[7] + row[8] - row[9]).abs() < 1e-12 && (row[9] - rows[0][9]).abs() < 1e-9)
    );
    // With a period: a row each 0.1 s and the last.
    let run = ["simulate", "two_r.urdf", "--duration", "0.45", "--csv", "run.csv", "--sample-period", "0.1"];
    folder.output(&run, "");
    let times: Vec<String> = folder
        .read("run.csv")
        .lines()
        .skip(1)
        .map(|line| line.split(',').next().unwrap().to_owned())
        .collect();
    assert_eq!(times, ["0.0", "0.1", "0.2", "0.3", "0.4", "0.45"]);
    // Nothing else remains in the folder.
    assert!(
        folder.names().iter().all(|name| name.contains(".urdf") || name == "run.csv"),
        "{:?}",
        folder.names()
    );
}

#[test]
fn plots_are_pictures() {
    let folder = Folder::new("plots");
    let run = ["simulate", "humanoid.urdf", "--conservative", "--duration", "0.3", "--plot", "run.svg"];
    folder.output(&run, "");
    let svg = folder.read("run.svg");
    assert!(svg.starts_with("<svg ") && svg.trim_end().ends_with("</svg>"));
    for text in ["[rad]", "[J]", "left_wrist_roll", "t [s]", "1e-12"] {
        assert!(svg.contains(text), "no {text:?} in the plot");
    }
    folder.output(&["simulate", "gantry.urdf", "--hold", "--duration", "0.3", "--plot", "run.png"], "");
    let png = fs::read(folder.path("run.png")).unwrap();
    assert!(png.starts_with(b"\x89PNG\r\n\x1a\n") && png.ends_with(b"IEND\xaeB`\x82"));
}

/// Motors move the arm to the goal and hold it; the energy balance includes their work.
#[test]
fn motors_reach_the_goal() {
    let folder = Folder::new("hold");
    let run = ["simulate", "panda.urdf", "--goal", "panda_joint2=0.5,panda_joint4=-2", "--duration", "4"];
    let text = folder.output(&[&run[..], &["--without", "limits"]].concat(), "");
    assert!(number_after(&text, FROM_GOAL) < 1e-3, "{text}");
    assert!(number_after(&text, UNACCOUNTED) < 1e-9, "{text}");
    // At the goal, joint 2 carries the weight of the raised arm within its limit of 87 N·m.
    let row = text.lines().rev().find(|line| line.trim_start().starts_with("panda_joint2")).unwrap();
    let cells: Vec<&str> = row.split_whitespace().collect();
    assert_eq!((cells[1], cells[2], cells[5]), ("N", "m", "87"), "{row}");
    assert!(cells[3].parse::<f64>().unwrap() < 87.0, "{row}");
}

/// The torques of weak motors stop at their limits.
#[test]
fn torques_stop_at_the_limits() {
    let folder = Folder::new("limits");
    let weak = folder.read("panda.urdf").replace("effort=\"87\"", "effort=\"5\"");
    folder.write("weak.urdf", weak.as_bytes());
    let text = folder.output(&["simulate", "weak.urdf", "--hold", "--duration", "0.5"], "");
    let row = text.lines().rev().find(|line| line.trim_start().starts_with("panda_joint2")).unwrap();
    let cells: Vec<&str> = row.split_whitespace().collect();
    assert_eq!((cells[3], cells[5], cells[6]), ("5", "5", "100"), "{row}");
}

/// The energy balance includes damping; a floating base falls in spite of motors.
#[test]
fn damping_and_floating_bases() {
    let folder = Folder::new("damping");
    let unaccounted = |step: &str, method: &[&str], losses: &str| {
        let run = ["simulate", "gripper.urdf", "--duration", "2", "--dt", step];
        let run = [&run[..], method].concat();
        let text = folder.output(&run, "");
        assert!(number_after(&text, losses) > 0.1, "{text}");
        number_after(&text, UNACCOUNTED)
    };
    // With explicit steps friction jumps when a joint reverses or rests, and the energy balance is of order
    // 1.
    let explicit = ["--integrator", "rk4"];
    let (coarse, fine) = (unaccounted("1e-3", &explicit, FRICTION), unaccounted("1e-4", &explicit, FRICTION));
    assert!(
        coarse < 1e-3 && (5.0..20.0).contains(&(coarse / fine)),
        "{coarse:e} at 1 ms, {fine:e} at 0.1 ms"
    );
    // With the default implicit steps it sticks, and they are of order 2.
    let free = ["--without", "limits"];
    let [coarse, fine] = ["1e-3", "2.5e-4"].map(|step| unaccounted(step, &free, FRICTION_AMONG_OTHERS));
    assert!(
        coarse < 1e-3 && (10.0..25.0).contains(&(coarse / fine)),
        "{coarse:e} at 1 ms, {fine:e} at 0.25 ms"
    );
    let run = ["simulate", "quadruped.urdf", "--floating-base", "--hold", "--duration", "1"];
    let text = folder.output(&run, "");
    let row = text.lines().find(|line| line.contains("floating_base.z")).unwrap();
    // No motor acts against the world, so the centre of mass falls g/2 in the first second, and the base
    // stays within centimetres of it.
    let fallen: f64 = row.split_whitespace().nth(3).unwrap().parse().unwrap();
    assert!((fallen + 4.905).abs() < 0.1, "{row}");
}

/// A step that is far too long: exit code 1, the time, the step, the joint, and the results so far.
#[test]
fn a_diverging_run_keeps_its_results() {
    let folder = Folder::new("blow_up");
    folder.write("run.csv", b"older\n");
    let run = ["simulate", "panda.urdf", "--integrator", "explicit-euler", "--dt", "0.05"];
    let files = ["--csv", "run.csv", "--plot", "run.svg"];
    let ran = folder.run(&[&run[..], &files[..]].concat(), b"");
    assert_eq!(ran.code, Some(1));
    assert!(ran.err.contains("`panda_joint") && ran.err.contains("--dt 5.0e-3"), "{}", ran.err);
    assert!(ran.err.contains("run.partial.csv"), "{}", ran.err);
    assert_eq!(ran.err.lines().count(), 1, "{}", ran.err);
    // An older file of that name stays.
    assert_eq!(folder.read("run.csv"), "older\n");
    let partial = folder.read("run.partial.csv");
    let step = number_after(&ran.err, "(step ");
    assert_eq!(partial.lines().count() as f64, 1.0 + step, "a head, and the state before each step done");
    assert!(folder.read("run.partial.svg").starts_with("<svg "));
}

/// Ctrl-C: exit code 130, and files with the results so far.
#[cfg(unix)]
#[test]
fn an_interruption_keeps_results() {
    let folder = Folder::new("interrupted");
    let run = ["simulate", "panda.urdf", "--duration", "100000", "--csv", "run.csv", "--sample-period", "1"];
    let child = folder.command(&run).spawn().unwrap();
    // The run has started once its temporary file has rows.
    let is_running = || {
        let unfinished = folder.names().into_iter().find(|name| name.starts_with(".unfinished"));
        unfinished.is_some_and(|name| fs::metadata(folder.path(&name)).is_ok_and(|file| file.len() > 8000))
    };
    let clock = std::time::Instant::now();
    while !is_running() {
        assert!(clock.elapsed().as_secs() < 60, "the run writes nothing");
        std::thread::sleep(std::time::Duration::from_millis(20));
    }
    let id = child.id().to_string();
    assert!(std::process::Command::new("kill").args(["-INT", &id]).status().unwrap().success());
    let output = child.wait_with_output().unwrap();
    assert_eq!(output.status.code(), Some(130));
    let (out, err) = (String::from_utf8(output.stdout).unwrap(), String::from_utf8(output.stderr).unwrap());
    assert_eq!(err.lines().count(), 1, "{err}");
    let time = number_after(&err, INTERRUPTED);
    let partial = folder.read("run.partial.csv");
    let last: f64 = partial.lines().last().unwrap().split(',').next().unwrap().parse().unwrap();
    assert!(time > 0.0 && (last - time).abs() < 1e-9, "last row at {last}, interrupted at {time}");
    assert!(out.contains("run.partial.csv"), "{out}");
    assert!(!folder.names().contains(&"run.csv".to_owned()));
}

/// A closed pipe is not an error.
#[test]
fn a_closed_pipe_is_not_an_error() {
    let folder = Folder::new("closed_pipe");
    for arguments in [&["inspect", "panda.urdf"][..], &["simulate", "two_r.urdf"], &["--help"], &["numbers"]]
    {
        let mut child = folder.command(arguments).spawn().unwrap();
        drop(child.stdout.take());
        let output = child.wait_with_output().unwrap();
        let err = String::from_utf8(output.stderr).unwrap();
        assert_eq!((output.status.code(), err.as_str()), (Some(0), ""), "{arguments:?}");
    }
}

/// A robot that gravity does not move starts at zero; joints that are not named, at the middle of their
/// limits.
#[test]
fn starts_are_chosen() {
    let folder = Folder::new("starts");
    let start = |arguments: &[&str]| {
        let run = ["--duration", "0.001", "--csv", "run.csv"];
        folder.output(&[&["simulate"], arguments, &run].concat(), "");
        let table = folder.read("run.csv");
        let row = table.lines().nth(1).unwrap();
        row.split(',').skip(1).map(|cell| cell.parse::<f64>().unwrap()).collect::<Vec<f64>>()
    };
    // The axis is vertical, so gravity exerts no torque about it.
    let turntable = folder.read("two_r.urdf").replace("xyz=\"0 -1 0\"", "xyz=\"0 0 1\"");
    folder.write("table.urdf", turntable.as_bytes());
    assert_eq!(start(&["table.urdf"])[..4], [0.0; 4]);
    // panda.urdf: joint 4 from -3.0718 to -0.0698 rad.
    let panda = start(&["panda.urdf", "--pose", "panda_joint1=3"]);
    assert!(panda[0] == 3.0 && (panda[3] - f64::midpoint(-3.0718, -0.0698)).abs() < 1e-9, "{panda:?}");
    assert_eq!(start(&["two_r.urdf", "--velocity", "elbow=1"])[..4], [0.0, 0.0, 0.0, 1.0]);
}

/// Adaptive steps conserve energy to their tolerance, and the summary has their statistics.
#[test]
fn adaptive_steps_keep_their_tolerance() {
    let folder = Folder::new("adaptive");
    let run = ["simulate", "panda.urdf", "--integrator", "adaptive", "--duration", "2"];
    let drift = |tolerance: &str| {
        let text = folder.output(&[&run[..], &["--tolerance", tolerance]].concat(), "");
        assert!(text.contains(&format!("order 9, tolerance {tolerance}: ")), "{text}");
        assert!(number_after(&text, EVALUATIONS) > 1000.0, "evaluations in\n{text}");
        number_after(&text, DRIFT)
    };
    let (loose, tight) = (drift("1e-5"), drift("1e-11"));
    // Some hundred steps, whose errors partly cancel; |E0| is 85 J.
    assert!(loose < 1e-4 && tight < 1e-10 && tight < 1e-3 * loose, "{loose:e} {tight:e}");
    // The end equals that of Runge–Kutta with a tenth of a millisecond, to the printed digits.
    let row =
        |text: &str| text.lines().find(|line| line.contains("panda_joint4")).map(ToOwned::to_owned).unwrap();
    let run = ["simulate", "panda.urdf", "--conservative", "--duration", "1"];
    let fixed = folder.output(&[&run[..], &["--dt", "1e-4"]].concat(), "");
    let adaptive = folder.output(&[&run[..], &["--dt", "1e-4", "--integrator", "adaptive"]].concat(), "");
    assert_eq!(row(&fixed), row(&adaptive));
}

/// Motors are held between the same instants as with fixed steps, so peaks and end are equal.
#[test]
fn adaptive_steps_hold_the_motors_between_samples() {
    let folder = Folder::new("adaptive_hold");
    let run =
        ["simulate", "panda.urdf", "--goal", "panda_joint2=0.5", "--duration", "1", "--without", "limits"];
    let fixed = folder.output(&run, "");
    let adaptive = folder.output(&[&run[..], &["--integrator", "adaptive"]].concat(), "");
    let from = |text: &str| text[text.find("\n  joint ").unwrap()..text.find(FROM_GOAL).unwrap()].to_owned();
    assert_eq!(from(&fixed), from(&adaptive));
    assert!(number_after(&adaptive, UNACCOUNTED) < 1e-9, "{adaptive}");
}

/// The run ends when the first joint reaches a limit, and that instant is the last row of the table.
#[test]
fn a_run_stops_at_a_located_limit() {
    let folder = Folder::new("limit");
    let run = ["simulate", "panda.urdf", "--integrator", "adaptive", "--stop-at-limits", "--csv", "run.csv"];
    let text = folder.output(&[&run[..], &["--sample-period", "0.1"]].concat(), "");
    assert!(text.contains("--stop-at-limits"), "{text}");
    let time = number_after(&text, "`panda_joint2` at its upper limit at ");
    let csv = folder.read("run.csv");
    let last: Vec<f64> = csv.lines().last().unwrap().split(',').map(|cell| cell.parse().unwrap()).collect();
    assert!((last[0] - time).abs() < 1e-9, "the last row is at {} s, the limit at {time} s", last[0]);
    // panda.urdf: joint 2 up to 1.7628 rad.
    assert!((last[2] - 1.7628).abs() < 1e-9, "{last:?}");
    // Steps of 1 ms, at any distance from the instant; errors h⁴ and h².
    for (row, error) in [("rk4", 1e-8), ("variational-midpoint", 1e-5)] {
        let text =
            folder.output(&[&["simulate", "panda.urdf", "--integrator", row][..], &run[4..]].concat(), "");
        let found = number_after(&text, "`panda_joint2` at its upper limit at ");
        assert!((found - time).abs() < error, "{row}: {found} s, by adaptive steps {time} s");
        let csv = folder.read("run.csv");
        let last: Vec<f64> =
            csv.lines().last().unwrap().split(',').map(|cell| cell.parse().unwrap()).collect();
        assert!((last[0] - found).abs() < 1e-9 && (last[2] - 1.7628).abs() < 1e-9, "{row}: {last:?}");
    }
}

/// Contradictory options give one line before anything is computed.
#[test]
fn adaptive_options_that_do_not_fit_are_refused() {
    let folder = Folder::new("adaptive_wrong");
    let refused = |arguments: &[&str]| {
        let ran = folder.run(&[&["simulate"], arguments].concat(), b"");
        assert!(ran.out.is_empty() && ran.err.lines().count() == 1, "{arguments:?}: {}{}", ran.out, ran.err);
        ran.code
    };
    assert_eq!(refused(&["panda.urdf", "--tolerance", "1e-6"]), Some(1));
    assert_eq!(refused(&["panda.urdf", "--integrator", "adaptive", "--tolerance", "1e-20"]), Some(2));
    assert_eq!(refused(&["panda.urdf", "--integrator", "dop853"]), Some(2));
    assert_eq!(refused(&["panda.urdf", "--without", "stops"]), Some(2));
    assert_eq!(refused(&["quadruped.urdf", "--integrator", "adaptive", "--ground"]), Some(1));
    // Adaptive steps leave out unsupported effects, and the text lists them.
    let run = ["simulate", "gripper.urdf", "--integrator", "adaptive", "--duration", "0.1"];
    assert!(folder.output(&run, "").contains("\n  without "));
}

/// A step that is too long for the motion fails with one line.
#[test]
fn a_variational_step_that_does_not_converge_fails() {
    let folder = Folder::new("run_away");
    let run = ["simulate", "humanoid.urdf", "--integrator", "variational-midpoint", "--dt", "0.01"];
    let ran = folder.run(&run, b"");
    assert_eq!(ran.code, Some(1));
    assert_eq!(ran.err.lines().count(), 1, "{}", ran.err);
}

/// Actuators and poses of a file by name, and errors for unknown names.
#[test]
fn actuators_and_poses_of_the_file() {
    let folder = Folder::new("actuators");
    folder.write("arm.xml", include_bytes!("../../../../robots/arm.xml"));
    let run = ["simulate", "arm.xml", "--pose", "home", "--controls", "pan_servo=0.5", "--duration", "3"];
    let text = folder.output(&run, "");
    assert!(text.contains("pan_servo=0.5") && text.contains("implicit, 3000 steps"), "{text}");
    // The servo moves its joint to the control; gravity exerts no torque about the vertical axis.
    let row =
        text.lines().find(|line| line.trim_start().starts_with("pan ")).unwrap_or_else(|| panic!("{text}"));
    let end: f64 = row.split_whitespace().nth(3).unwrap().parse().unwrap();
    assert!((end - 0.5).abs() < 0.01, "{row}");
    let refused = |arguments: &[&str]| {
        let ran = folder.run(&[&["simulate"], arguments].concat(), b"");
        assert_eq!((ran.code, ran.out.as_str()), (Some(1), ""), "{arguments:?}: {}", ran.err);
        ran.err
    };
    let error = refused(&["arm.xml", "--controls", "pan=1"]);
    assert!(error.contains("pan_servo, lift_servo"), "{error}");
    assert!(refused(&["arm.xml", "--pose", "rest"]).contains("home"));
    refused(&["panda.urdf", "--controls"]);
    refused(&["arm.xml", "--controls", "--without", "actuators"]);
    // Explicit steps support actuators, but no limits.
    let run = ["simulate", "arm.xml", "--integrator", "rk4", "--duration", "0.1"];
    let text = folder.output(&run, "");
    assert!(text.contains("6 actuators") && text.contains("\n  without "), "{text}");
}

/// The equalities of a file hold in every step: the loop of a linkage stays closed, and its energy is
/// conserved.
#[test]
fn the_loops_of_a_file_stay_closed() {
    let folder = Folder::new("loops");
    folder.write("linkage.xml", include_bytes!("../../../../robots/linkage.xml"));
    let ran = folder.run(&["simulate", "linkage.xml", "--conservative", "--duration", "2"], b"");
    assert_eq!(ran.code, Some(0), "{}", ran.err);
    let text = ran.out;
    assert!(text.contains("\n  loops   pin"), "{text}");
    let drift = number_after(&text, DRIFT);
    assert!(drift < 1e-6, "{text}");
    // The crank rotates or swings; the rocker reverses only because of the loop.
    let end = |joint: &str| -> f64 {
        let row = text
            .lines()
            .find(|line| line.trim_start().starts_with(joint))
            .unwrap_or_else(|| panic!("{text}"));
        row.split_whitespace().nth(3).unwrap().parse().unwrap()
    };
    assert!(end("crank").abs() > 0.1, "{text}");
    let ran = folder.run(&["simulate", "linkage.xml", "--integrator", "adaptive", "--duration", "0.1"], b"");
    assert!(ran.out.contains("equalities") && !ran.out.contains("\n  loops "), "{}", ran.out);
    // With damping, by implicit steps, the energy balance closes.
    let ran = folder.run(&["simulate", "linkage.xml", "--duration", "2"], b"");
    assert_eq!(ran.code, Some(0), "{}", ran.err);
    let text = ran.out;
    assert!(text.contains("\n  loops   pin") && text.contains("implicit, 2000 steps"), "{text}");
    // At 17 rad/s and 1 ms (ωh)² is 3e-4.
    assert!(number_after(&text, UNACCOUNTED) < 1e-3, "{text}");
    // With its motor, and on ground.
    let driven = folder.run(&["simulate", "linkage.xml", "--controls", "drive=1", "--duration", "1"], b"");
    assert!(driven.code == Some(0) && driven.out.contains("\n  loops   pin"), "{}", driven.err);
    let ground = folder.run(&["simulate", "linkage.xml", "--ground", "z=-0.1", "--duration", "2"], b"");
    assert!(ground.code == Some(0) && ground.out.contains("\n  loops   pin"), "{}{}", ground.out, ground.err);
}

/// Two balls on a slide: with contact one rests on the other; with the pair of the SRDF file they pass
/// through each other.
#[test]
fn pairs_of_an_srdf_file_do_not_touch() {
    let folder = Folder::new("srdf");
    let body = |name: &str, z: f64| {
        format!(
            r#"<body name="{name}" pos="0 0 {z}"><joint name="{name}" type="slide" axis="0 0 1"/><geom size="0.1"/></body>"#
        )
    };
    let floor = r#"<geom type="plane" size="0 0 1"/>"#;
    let text =
        format!("<mujoco><worldbody>{floor}{}{}</worldbody></mujoco>", body("low", 0.1), body("high", 0.35));
    folder.write("balls.xml", text.as_bytes());
    let pair = r#"<robot name="r"><disable_collisions link1="high" link2="low" reason="Never"/></robot>"#;
    folder.write("pairs.srdf", pair.as_bytes());
    folder.write("other.srdf", pair.replace("low", "lowe").as_bytes());
    let end = |arguments: &[&str]| -> f64 {
        let run = ["simulate", "balls.xml", "--duration", "1", "--csv", "-"];
        let table = folder.run(&[&run[..], arguments].concat(), b"");
        assert_eq!(table.code, Some(0), "{}", table.err);
        let mut lines = table.out.lines();
        let column = lines.next().unwrap().split(',').position(|name| name == "q high [m]").unwrap();
        lines.last().unwrap().split(',').nth(column).unwrap().parse().unwrap()
    };
    // 0.35 m minus 0.2 m above the low one, or minus 0.1 m above the floor.
    assert!((end(&[]) + 0.05).abs() < 1e-3);
    assert!((end(&["--srdf", "pairs.srdf"]) + 0.25).abs() < 1e-3);
    let run = ["simulate", "balls.xml", "--duration", "0.1", "--srdf"];
    let refused = folder.run(&[&run[..], &["other.srdf"]].concat(), b"");
    assert!(refused.code == Some(1) && refused.err.contains("`low`"), "{}", refused.err);
    let refused = folder.run(&[&run[..], &["balls.xml"]].concat(), b"");
    assert_eq!(refused.code, Some(1), "{}", refused.err);
    // `inspect` shows the groups, and a group state is a named pose.
    let group = r#"<robot name="r"><group name="lift"><joint name="high"/></group>
        <group_state name="up" group="lift"><joint name="high" value="0.5"/></group_state></robot>"#;
    folder.write("group.srdf", group.as_bytes());
    let shown = folder.run(&["inspect", "balls.xml", "--srdf", "group.srdf"], b"");
    assert!(
        shown.code == Some(0) && shown.out.contains("lift: 1 link, 1 joint"),
        "{}{}",
        shown.out,
        shown.err
    );
    assert!(shown.out.contains("Poses: up"), "{}", shown.out);
    // The SRDF file is an input of the run.
    let refused = folder.run(&[&run[..], &["pairs.srdf", "--csv", "pairs.srdf"]].concat(), b"");
    assert!(refused.code != Some(0) && folder.read("pairs.srdf") == pair, "{}", refused.err);
}
