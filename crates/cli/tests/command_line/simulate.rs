//! Runs of `dynamics simulate`: what is printed, what is written, and what is kept when a run ends early.

use std::fs;

use crate::command::Folder;

/// The number after `mark`.
fn number_after(text: &str, mark: &str) -> f64 {
    let rest = text.split_once(mark).unwrap_or_else(|| panic!("no {mark:?} in\n{text}")).1;
    let end = rest.find(|c: char| !"0123456789.e+-".contains(c)).unwrap_or(rest.len());
    rest[..end].parse().unwrap_or_else(|_| panic!("no number after {mark:?} in\n{text}"))
}

/// The textbook's free motion: ten seconds of the Panda, let go from the middle of its limits.
#[test]
fn panda_keeps_its_energy() {
    let folder = Folder::new("panda");
    let text = folder.output(&["simulate", "panda.urdf", "--conservative"], "");
    assert!(text.starts_with("panda (panda.urdf): 7 degrees of freedom, 16.06 kg\n"), "{text}");
    assert!(text.contains(
        "the middle of the joint limits, as all zeros is outside those of `panda_joint4`, at rest"
    ));
    let forces = "let go, no motor torque; conservative: no damping, friction, limits, actuators or contact";
    assert!(text.contains(forces), "{text}");
    assert!(text.contains("rk4, 10000 steps of 0.001 s, 10 s"), "{text}");
    assert!(text.contains("limits are not enforced"), "{text}");
    // After some four seconds rounding decides about the motion, and with it about the drift. Before, the drift is that of a method of order 4.
    let drift = |step: &str| {
        let text = folder
            .output(&["simulate", "panda.urdf", "--conservative", "--duration", "2", "--step", step], "");
        number_after(&text, "max |E − E0| / |E0|: ")
    };
    let (whole, half) = (drift("0.001"), drift("0.0005"));
    assert!(whole > 4e-8 && whole < 5e-8, "drift {whole}");
    assert!((whole / half - 16.0).abs() < 1.0, "drift {whole}, with half the step {half}");
}

/// With no flags at all everything acts: the Panda falls onto its limits, and what they take is accounted for.
#[test]
fn panda_without_flags_stops_at_its_limits() {
    let folder = Folder::new("panda_stops");
    let text = folder.output(&["simulate", "panda.urdf", "--duration", "3"], "");
    assert!(text.contains("let go, no motor torque; joints stop at their limits"), "{text}");
    assert!(
        text.contains("method  implicit, 3000 steps of 0.001 s, 3 s: needed for position limits"),
        "{text}"
    );
    assert!(text.contains("position limits are stops"), "{text}");
    assert!(!text.contains("beyond its limits"), "{text}");
    assert!(number_after(&text, "stops ") > 1.0, "{text}");
    // Off by order h² in the swing between the stops.
    assert!(number_after(&text, "− in + out| / energy moved: ") < 1e-3, "{text}");
}

/// Samples are thinned when there are 4096 of them. A run that ends with that one shows it.
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

/// Every sample is there, with a head, numbers in every cell, the last time exact, and E as good as printed.
#[test]
fn csv_holds_every_sample() {
    let folder = Folder::new("csv");
    let run = ["simulate", "two_r.urdf", "--duration", "0.5", "--csv", "run.csv"];
    let text = folder.output(&run, "");
    assert!(text.contains("run.csv (501 samples)"), "{text}");
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
    // With a stride: every hundredth and the last.
    let run = ["simulate", "two_r.urdf", "--duration", "0.45", "--csv", "run.csv", "--every", "100"];
    folder.output(&run, "");
    let times: Vec<String> = folder
        .read("run.csv")
        .lines()
        .skip(1)
        .map(|line| line.split(',').next().unwrap().to_owned())
        .collect();
    assert_eq!(times, ["0.0", "0.1", "0.2", "0.3", "0.4", "0.45"]);
    // Nothing else is left in the folder.
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
    for text in ["Joint coordinates [rad]", "Energy [J]", "Energy drift", "left_wrist_roll", "t [s]", "1e-12"]
    {
        assert!(svg.contains(text), "no {text:?} in the plot");
    }
    folder.output(&["simulate", "gantry.urdf", "--hold", "--duration", "0.3", "--plot", "run.png"], "");
    let png = fs::read(folder.path("run.png")).unwrap();
    assert!(png.starts_with(b"\x89PNG\r\n\x1a\n") && png.ends_with(b"IEND\xaeB`\x82"));
}

/// Motors carry the arm to the goal and hold it; their work is accounted for.
#[test]
fn motors_reach_the_goal() {
    let folder = Folder::new("hold");
    let run = ["simulate", "panda.urdf", "--goal", "panda_joint2=0.5,panda_joint4=-2", "--duration", "4"];
    let text = folder.output(&[&run[..], &["--without", "limits"]].concat(), "");
    assert!(text.contains("motors hold the goal: τ = g(q*) + Kp (q* − q) − Kd v"), "{text}");
    assert!(number_after(&text, "from its goal at the end: ") < 1e-3, "{text}");
    assert!(number_after(&text, "− in + out| / energy moved: ") < 1e-9, "{text}");
    // The weight of the raised arm, at the goal: joint 2 carries it against its limit of 87 N·m.
    let row = text.lines().rev().find(|line| line.trim_start().starts_with("panda_joint2")).unwrap();
    let cells: Vec<&str> = row.split_whitespace().collect();
    assert_eq!((cells[1], cells[2], cells[5]), ("N", "m", "87"), "{row}");
    assert!(cells[3].parse::<f64>().unwrap() < 87.0, "{row}");
}

/// Weak motors are cut off at their limit and say so.
#[test]
fn torques_stop_at_the_limits() {
    let folder = Folder::new("limits");
    let weak = folder.read("panda.urdf").replace("effort=\"87\"", "effort=\"5\"");
    folder.write("weak.urdf", weak.as_bytes());
    let text = folder.output(&["simulate", "weak.urdf", "--hold", "--duration", "0.5"], "");
    let row = text.lines().rev().find(|line| line.trim_start().starts_with("panda_joint2")).unwrap();
    let cells: Vec<&str> = row.split_whitespace().collect();
    assert_eq!((cells[3], cells[5], cells[6]), ("5", "5", "100"), "{row}");
    assert!(row.ends_with("too weak to carry the weight there"), "{row}");
}

/// Damping takes energy out, all of it accounted for; a floating base falls whatever the motors do.
#[test]
fn damping_and_floating_bases() {
    let folder = Folder::new("damping");
    let unaccounted = |step: &str, method: &[&str], losses: &str| {
        let run = ["simulate", "gripper.urdf", "--duration", "2", "--step", step];
        let run = [&run[..], method].concat();
        let text = folder.output(&run, "");
        assert!(number_after(&text, losses) > 0.1, "{text}");
        number_after(&text, "− in + out| / energy moved: ")
    };
    // In explicit steps friction jumps where a joint turns back or rests: there the books are right to first order.
    let explicit = ["--integrator", "rk4"];
    let took_out = "friction took out ";
    let (coarse, fine) = (unaccounted("1e-3", &explicit, took_out), unaccounted("1e-4", &explicit, took_out));
    assert!(
        coarse < 1e-3 && (5.0..20.0).contains(&(coarse / fine)),
        "{coarse:e} at 1 ms, {fine:e} at 0.1 ms"
    );
    // In the implicit steps that are taken where nothing else is asked for it sticks, and they are of order 2.
    let free = ["--without", "limits"];
    let (coarse, fine) =
        (unaccounted("1e-3", &free, ", friction "), unaccounted("2.5e-4", &free, ", friction "));
    assert!(
        coarse < 1e-3 && (10.0..25.0).contains(&(coarse / fine)),
        "{coarse:e} at 1 ms, {fine:e} at 0.25 ms"
    );
    let run = ["simulate", "quadruped.urdf", "--floating-base", "--hold", "--duration", "1"];
    let text = folder.output(&run, "");
    assert!(text.contains("the floating base has no motors and falls"), "{text}");
    let row = text.lines().find(|line| line.contains("floating_base.z")).unwrap();
    // No motor pushes against the world, so the centre of mass falls g/2 in the first second; the base is
    // within centimetres of it.
    let fallen: f64 = row.split_whitespace().nth(3).unwrap().parse().unwrap();
    assert!((fallen + 4.905).abs() < 0.1, "{row}");
}

/// A step that is far too long: exit code 1, the time, the step and the joint, and what was computed.
#[test]
fn a_blow_up_keeps_what_was_computed() {
    let folder = Folder::new("blow_up");
    folder.write("run.csv", b"older\n");
    let run = ["simulate", "panda.urdf", "--integrator", "explicit-euler", "--step", "0.05"];
    let files = ["--csv", "run.csv", "--plot", "run.svg"];
    let ran = folder.run(&[&run[..], &files[..]].concat(), b"");
    assert_eq!(ran.code, Some(1));
    assert!(ran.err.starts_with("error: the motion grows without bound: `panda_joint"), "{}", ran.err);
    assert!(
        ran.err.contains("try --step 5.0e-3, a tenth of this one") && ran.err.contains("; kept up to there:")
    );
    assert_eq!(ran.err.lines().count(), 1, "{}", ran.err);
    assert!(ran.out.contains("that is not the robot's motion but the integrator's error"), "{}", ran.out);
    // An older file of that name stays.
    assert_eq!(folder.read("run.csv"), "older\n");
    let partial = folder.read("run.partial.csv");
    let step = number_after(&ran.err, "(step ");
    assert_eq!(partial.lines().count() as f64, 1.0 + step, "a head, and the state before each step done");
    assert!(folder.read("run.partial.svg").contains("ends early"));
}

/// Ctrl-C: exit code 130, and files with what there was.
#[cfg(unix)]
#[test]
fn an_interruption_keeps_what_was_computed() {
    let folder = Folder::new("interrupted");
    let run = ["simulate", "panda.urdf", "--duration", "100000", "--csv", "run.csv", "--every", "1000"];
    let child = folder.command(&run).spawn().unwrap();
    // It is under way once its temporary file has rows.
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
    assert!(err.starts_with("interrupted at t = ") && err.ends_with(" s of 100000 s\n"), "{err}");
    let time = number_after(&err, "interrupted at t = ");
    let partial = folder.read("run.partial.csv");
    let last: f64 = partial.lines().last().unwrap().split(',').next().unwrap().parse().unwrap();
    assert!(time > 0.0 && (last - time).abs() < 1e-9, "last row at {last}, interrupted at {time}");
    assert!(out.contains("run.partial.csv"), "{out}");
    assert!(!folder.names().contains(&"run.csv".to_owned()));
}

/// A pipe that closes early is no failure and no panic.
#[test]
fn a_closed_pipe_is_no_failure() {
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

/// A robot that gravity does not move from zero is started elsewhere; the other ways to start are said, too.
#[test]
fn starts_are_said() {
    let folder = Folder::new("starts");
    // The axis along z: gravity cannot turn it, wherever it stands.
    let turntable = folder.read("two_r.urdf").replace("xyz=\"0 -1 0\"", "xyz=\"0 0 1\"");
    folder.write("table.urdf", turntable.as_bytes());
    let text = folder.output(&["simulate", "table.urdf", "--duration", "0.1"], "");
    assert!(text.contains("an equilibrium as far as tried: nothing will move"), "{text}");
    let text =
        folder.output(&["simulate", "panda.urdf", "--pose", "panda_joint1=3", "--duration", "0.1"], "");
    assert!(text.contains("as given; joints not named: the middle of the joint limits"), "{text}");
    assert!(text.contains("; outside the limits of `panda_joint1`, at rest"), "{text}");
    let text = folder.output(&["simulate", "two_r.urdf", "--velocity", "elbow=1", "--duration", "0.1"], "");
    assert!(text.contains("all zeros, moving as given"), "{text}");
}

/// Adaptive steps keep the energy to their tolerance, and say what they did.
#[test]
fn adaptive_steps_keep_their_tolerance() {
    let folder = Folder::new("adaptive");
    let run = ["simulate", "panda.urdf", "--integrator", "adaptive", "--duration", "2"];
    let drift = |tolerance: &str| {
        let text = folder.output(&[&run[..], &["--tolerance", tolerance]].concat(), "");
        assert!(text.contains(&format!("adaptive, order 9, tolerance {tolerance}: ")), "{text}");
        assert!(number_after(&text, "rejected, ") > 1000.0, "evaluations in\n{text}");
        number_after(&text, "max |E − E0| / |E0|: ")
    };
    let (loose, tight) = (drift("1e-5"), drift("1e-11"));
    // Some hundred steps, whose errors partly cancel; |E0| is 85 J.
    assert!(loose < 1e-4 && tight < 1e-10 && tight < 1e-3 * loose, "{loose:e} {tight:e}");
    // The end is that of Runge–Kutta at a tenth of a millisecond, to the printed digits.
    let row =
        |text: &str| text.lines().find(|line| line.contains("panda_joint4")).map(ToOwned::to_owned).unwrap();
    let run = ["simulate", "panda.urdf", "--conservative", "--duration", "1"];
    let fixed = folder.output(&[&run[..], &["--step", "1e-4"]].concat(), "");
    let adaptive = folder.output(&[&run[..], &["--step", "1e-4", "--integrator", "adaptive"]].concat(), "");
    assert_eq!(row(&fixed), row(&adaptive));
}

/// Motors are held between the same instants as with fixed steps: the same peaks and the same end.
#[test]
fn adaptive_steps_hold_the_motors_between_samples() {
    let folder = Folder::new("adaptive_hold");
    let run =
        ["simulate", "panda.urdf", "--goal", "panda_joint2=0.5", "--duration", "1", "--without", "limits"];
    let fixed = folder.output(&run, "");
    let adaptive = folder.output(&[&run[..], &["--integrator", "adaptive"]].concat(), "");
    let from =
        |text: &str| text[text.find("\n  joint ").unwrap()..text.find("\n  farthest").unwrap()].to_owned();
    assert_eq!(from(&fixed), from(&adaptive));
    assert!(number_after(&adaptive, "− in + out| / energy moved: ") < 1e-9, "{adaptive}");
}

/// The run ends where the first joint reaches a limit, and that instant is the last row of the table.
#[test]
fn a_run_stops_at_a_located_limit() {
    let folder = Folder::new("limit");
    let run = ["simulate", "panda.urdf", "--integrator", "adaptive", "--stop-at-limits", "--csv", "run.csv"];
    let text = folder.output(&[&run[..], &["--every", "100"]].concat(), "");
    assert!(text.contains("there the run ended (--stop-at-limits)"), "{text}");
    let time = number_after(&text, "`panda_joint2` at its upper limit at ");
    let csv = folder.read("run.csv");
    let last: Vec<f64> = csv.lines().last().unwrap().split(',').map(|cell| cell.parse().unwrap()).collect();
    assert!((last[0] - time).abs() < 1e-9, "the last row is at {} s, the limit at {time} s", last[0]);
    // panda.urdf: joint 2 up to 1.7628 rad.
    assert!((last[2] - 1.7628).abs() < 1e-9, "{last:?}");
    assert!(text.contains(&format!(" evaluations, {time:.4} s")), "{text}");
    // Steps of 1 ms, however far they are from the instant; errors h⁴ and h².
    for (row, error) in [("rk4", 1e-8), ("variational-midpoint", 1e-5)] {
        let text =
            folder.output(&[&["simulate", "panda.urdf", "--integrator", row][..], &run[4..]].concat(), "");
        assert!(text.contains("there the run ended (--stop-at-limits)"), "{text}");
        let found = number_after(&text, "`panda_joint2` at its upper limit at ");
        assert!((found - time).abs() < error, "{row}: {found} s, by adaptive steps {time} s");
        let csv = folder.read("run.csv");
        let last: Vec<f64> =
            csv.lines().last().unwrap().split(',').map(|cell| cell.parse().unwrap()).collect();
        assert!((last[0] - found).abs() < 1e-9 && (last[2] - 1.7628).abs() < 1e-9, "{row}: {last:?}");
    }
}

/// What does not go together is said in one line, before anything is computed.
#[test]
fn adaptive_options_that_do_not_fit_are_refused() {
    let folder = Folder::new("adaptive_wrong");
    let refused = |arguments: &[&str]| {
        let ran = folder.run(&[&["simulate"], arguments].concat(), b"");
        assert!(ran.code != Some(0) && ran.out.is_empty(), "{arguments:?}: {}", ran.out);
        ran.err
    };
    let error = refused(&["panda.urdf", "--tolerance", "1e-6"]);
    assert_eq!(
        error,
        "error: --tolerance goes with --integrator adaptive; the default takes steps of --step whatever their error\n"
    );
    let error = refused(&["panda.urdf", "--integrator", "adaptive", "--tolerance", "1e-20"]);
    assert!(error.contains("it must lie between 1e-13 and 1e-2"), "{error}");
    let error = refused(&["panda.urdf", "--integrator", "dop853"]);
    assert!(error.contains("variational-yoshida4, implicit, mujoco, adaptive"), "{error}");
    let error = refused(&["panda.urdf", "--without", "stops"]);
    assert!(
        error.contains("there is no effect `stops` to switch off; there are dissipation, limits"),
        "{error}"
    );
    let error = refused(&["quadruped.urdf", "--integrator", "adaptive", "--ground"]);
    assert!(error.contains("--ground goes with --integrator implicit or mujoco"), "{error}");
    // Adaptive steps leave out the effects that they do not support, and the text lists them.
    let run = ["simulate", "gripper.urdf", "--integrator", "adaptive", "--duration", "0.1"];
    let text = folder.output(&run, "");
    let without =
        "without damping and dry friction, position limits, contacts: `adaptive` does not know them";
    assert!(text.contains(without), "{text}");
}

/// A motion too wild for the step is the step's failure, not the robot's.
#[test]
fn a_variational_step_that_runs_away_says_so() {
    let folder = Folder::new("run_away");
    let run = ["simulate", "humanoid.urdf", "--integrator", "variational-midpoint", "--step", "0.01"];
    let ran = folder.run(&run, b"");
    assert_eq!(ran.code, Some(1));
    assert!(ran.err.contains("did not converge") && ran.err.contains("take a smaller step"), "{}", ran.err);
    assert!(ran.err.starts_with("error: no step from t = ") && !ran.err.contains("singular"), "{}", ran.err);
}

/// A file's actuators by their names, its poses by theirs, and what is said where there are none.
#[test]
fn actuators_and_poses_of_the_file() {
    let folder = Folder::new("actuators");
    folder.write("arm.xml", include_bytes!("../../../../robots/arm.xml"));
    let run = ["simulate", "arm.xml", "--pose", "home", "--controls", "pan_servo=0.5", "--duration", "3"];
    let text = folder.output(&run, "");
    assert!(
        text.contains("pose `home` of the file") && text.contains("6 actuators of the file, pan_servo=0.5"),
        "{text}"
    );
    assert!(text.contains("implicit, 3000 steps") && text.contains("joints stop at their limits"), "{text}");
    // The servo pulls its joint there; nothing but inertia and damping is in the way of a turn about the vertical.
    let row =
        text.lines().find(|line| line.trim_start().starts_with("pan ")).unwrap_or_else(|| panic!("{text}"));
    let end: f64 = row.split_whitespace().nth(3).unwrap().parse().unwrap();
    assert!((end - 0.5).abs() < 0.01, "{row}");
    let refused = |arguments: &[&str]| {
        let ran = folder.run(&[&["simulate"], arguments].concat(), b"");
        assert!(ran.code != Some(0) && ran.out.is_empty(), "{arguments:?}: {}", ran.out);
        ran.err
    };
    let error = refused(&["arm.xml", "--controls", "pan=1"]);
    assert!(error.contains("no actuator `pan`; there are pan_servo, lift_servo"), "{error}");
    let error = refused(&["arm.xml", "--pose", "rest"]);
    assert!(error.contains("no pose `rest`: its file has home"), "{error}");
    assert!(refused(&["panda.urdf", "--controls"]).contains("has no actuators"));
    let error = refused(&["arm.xml", "--controls", "--without", "actuators"]);
    assert!(error.contains("actuators do not act here"), "{error}");
    // Explicit steps know actuators, but not the limits.
    let run = ["simulate", "arm.xml", "--integrator", "rk4", "--duration", "0.1"];
    let text = folder.output(&run, "");
    assert!(text.contains("6 actuators of the file, controls at 0"), "{text}");
    assert!(text.contains("without position limits: `rk4` does not know them, `implicit` does"), "{text}");
}

/// The equalities of a file hold in every step: the loop of a linkage stays closed, and its energy stays.
#[test]
fn the_loops_of_a_file_are_held() {
    let folder = Folder::new("loops");
    folder.write("linkage.xml", include_bytes!("../../../../robots/linkage.xml"));
    let ran = folder.run(&["simulate", "linkage.xml", "--conservative", "--duration", "2"], b"");
    assert_eq!(ran.code, Some(0), "{}", ran.err);
    let text = ran.out;
    assert!(
        text.contains("loops   pin held, as the file says") && text.contains("as that is an equilibrium"),
        "{text}"
    );
    let drift = number_after(&text, "energy drift, max |E − E0| / |E0|: ");
    assert!(drift < 1e-6, "{text}");
    // The crank goes round or swings; without the loop nothing would turn the rocker back.
    let end = |joint: &str| -> f64 {
        let row = text
            .lines()
            .find(|line| line.trim_start().starts_with(joint))
            .unwrap_or_else(|| panic!("{text}"));
        row.split_whitespace().nth(3).unwrap().parse().unwrap()
    };
    assert!(end("crank").abs() > 0.1, "{text}");
    let ran = folder.run(&["simulate", "linkage.xml", "--integrator", "adaptive", "--duration", "0.1"], b"");
    assert!(ran.out.contains("equalities: `adaptive` does not know them, `implicit` does"), "{}", ran.out);
    assert!(ran.out.contains("without contacts, equalities: "), "{}", ran.out);
    // With damping, by implicit steps, and the books close.
    let ran = folder.run(&["simulate", "linkage.xml", "--duration", "2"], b"");
    assert_eq!(ran.code, Some(0), "{}", ran.err);
    let text = ran.out;
    assert!(text.contains("loops   pin held") && text.contains("method  implicit"), "{text}");
    // At 17 rad/s and 1 ms (ωh)² is 3e-4.
    assert!(number_after(&text, "|E − E0 − in + out| / energy moved: ") < 1e-3, "{text}");
    // With its motor, and on ground that its bars pass.
    let driven = folder.run(&["simulate", "linkage.xml", "--controls", "drive=1", "--duration", "1"], b"");
    assert!(driven.code == Some(0) && driven.out.contains("loops   pin held"), "{}", driven.err);
    let ground = folder.run(&["simulate", "linkage.xml", "--ground", "z=-0.1", "--duration", "2"], b"");
    assert!(
        ground.code == Some(0) && ground.out.contains("loops   pin held"),
        "{}{}",
        ground.out,
        ground.err
    );
}

/// Two balls on a slide: without the pair of the SRDF file one rests on the other, with it they pass through each other.
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
    // 0.35 m less 0.2 m above the low one, or less 0.1 m above the floor.
    assert!((end(&[]) + 0.05).abs() < 1e-3);
    assert!((end(&["--srdf", "pairs.srdf"]) + 0.25).abs() < 1e-3);
    let run = ["simulate", "balls.xml", "--duration", "0.1", "--srdf"];
    let refused = folder.run(&[&run[..], &["other.srdf"]].concat(), b"");
    assert!(refused.code != Some(0) && refused.err.contains("did you mean `low`?"), "{}", refused.err);
    let refused = folder.run(&[&run[..], &["balls.xml"]].concat(), b"");
    assert!(refused.code != Some(0) && refused.err.contains("not an SRDF file"), "{}", refused.err);
    // The file is one that the run reads.
    let refused = folder.run(&[&run[..], &["pairs.srdf", "--csv", "pairs.srdf"]].concat(), b"");
    assert!(refused.code != Some(0) && folder.read("pairs.srdf") == pair, "{}", refused.err);
}
