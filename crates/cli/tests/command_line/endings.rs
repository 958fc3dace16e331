//! Runs that end early: interrupted between samples, stopped, or failed at the first step; and motors without
//! effort.

use crate::command::Folder;
use crate::labels::{DRIFT, DRIFT_OF_KINETIC, FAILED, INTERRUPTED, UNACCOUNTED, number_after};

/// Seconds of processor time of a process.
#[cfg(target_os = "linux")]
fn processor_time(process: u32) -> f64 {
    let text = std::fs::read_to_string(format!("/proc/{process}/stat")).unwrap();
    let fields: Vec<&str> = text.rsplit_once(')').unwrap().1.split_whitespace().collect();
    // Fields 14 and 15 of proc(5), in hundredths of a second.
    let ticks: f64 = fields[11..13].iter().map(|field| field.parse::<f64>().unwrap()).sum();
    ticks / 100.0
}

/// Ctrl-C ends adaptive steps between two samples that are hours apart. The exit code is 130, and the current
/// state is the last row.
#[cfg(target_os = "linux")]
#[test]
fn an_interruption_between_samples() {
    let folder = Folder::new("between_samples");
    let run = ["simulate", "panda.urdf", "--integrator", "adaptive", "--tolerance", "1e-13"];
    let long = ["--dt", "100000", "--duration", "100000", "--csv", "run.csv"];
    let child = folder.command(&[&run[..], &long[..]].concat()).spawn().unwrap();
    let clock = std::time::Instant::now();
    let started = || folder.names().iter().any(|name| name.starts_with(".unfinished"));
    while !(started() && processor_time(child.id()) > 0.3) {
        assert!(clock.elapsed().as_secs() < 120, "the run does not start");
        std::thread::sleep(std::time::Duration::from_millis(20));
    }
    let id = child.id().to_string();
    assert!(std::process::Command::new("kill").args(["-INT", &id]).status().unwrap().success());
    let output = child.wait_with_output().unwrap();
    let (out, err) = (String::from_utf8(output.stdout).unwrap(), String::from_utf8(output.stderr).unwrap());
    assert_eq!(output.status.code(), Some(130), "{err}{out}");
    let time = number_after(&err, INTERRUPTED);
    assert!(time > 0.0 && time < 1e5, "{err}");
    let partial = folder.read("run.partial.csv");
    let rows: Vec<&str> = partial.lines().collect();
    assert_eq!(rows.len(), 3, "the head, the start and the end: {partial}");
    assert_eq!(rows[2].split(',').next().unwrap().parse::<f64>().unwrap(), time);
    assert!(out.contains(DRIFT) && out.contains("run.partial.csv (2 "), "{out}");
}

/// A pendulum with a very light second link whose joint has strong damping: its velocity relaxes within
/// nanoseconds.
const STIFF: &str = r#"<robot name="stiff">
  <link name="ceiling"/>
  <link name="rod"><inertial><origin xyz="0.5 0 0"/><mass value="1"/>
    <inertia ixx="0.1" ixy="0" ixz="0" iyy="0.1" iyz="0" izz="0.1"/></inertial></link>
  <link name="speck"><inertial><origin xyz="0.1 0 0"/><mass value="1e-8"/>
    <inertia ixx="1e-12" ixy="0" ixz="0" iyy="1e-12" iyz="0" izz="1e-12"/></inertial></link>
  <joint name="hinge" type="continuous"><parent link="ceiling"/><child link="rod"/><axis xyz="0 1 0"/></joint>
  <joint name="oiled" type="continuous"><parent link="rod"/><child link="speck"/><origin xyz="1 0 0"/>
    <axis xyz="0 1 0"/><dynamics damping="1"/></joint>
</robot>"#;

/// Adaptive steps handle damping of 10¹²/s by an implicit method.
#[test]
fn a_stiff_joint_takes_few_steps() {
    let folder = Folder::new("oiled");
    folder.write("stiff.urdf", STIFF.as_bytes());
    let ran = folder.run(&["simulate", "stiff.urdf", "--integrator", "adaptive"], b"");
    assert_eq!(ran.code, Some(0), "{}", ran.err);
    assert!(ran.out.contains("order 5, tolerance 1e-9: "), "{}", ran.out);
    assert!(number_after(&ran.out, "tolerance 1e-9: ") < 1000.0, "{}", ran.out);
    // Hundreds of steps to 1e-9 each.
    assert!(number_after(&ran.out, UNACCOUNTED) < 1e-5, "{}", ran.out);
}

/// The light link on a spring of 10⁸ rad/s.
const SPRUNG: &str = r#"<mujoco model="sprung"><worldbody>
  <body name="rod"><inertial pos="0.5 0 0" mass="1" diaginertia="0.1 0.1 0.1"/><joint name="hinge" axis="0 1 0"/>
    <body name="speck" pos="1 0 0"><inertial pos="0.1 0 0" mass="1e-8" diaginertia="1e-12 1e-12 1e-12"/>
      <joint name="sprung" axis="0 1 0" stiffness="1e6"/></body></body>
</worldbody></mujoco>"#;

/// The limit on steps ends a run that would take hours. The error names the joint and options, and results
/// are kept.
#[test]
fn a_joint_that_asks_for_short_steps_is_named() {
    let folder = Folder::new("stiff");
    folder.write("sprung.xml", SPRUNG.as_bytes());
    let run = ["simulate", "sprung.xml", "--integrator", "adaptive", "--csv", "run.csv"];
    let ran = folder.run(&run, b"");
    assert_eq!(ran.code, Some(1), "{}", ran.out);
    assert!(ran.err.contains(" 10100 ") && ran.err.contains("`sprung`"), "{}", ran.err);
    assert!(ran.err.contains("--tolerance") && ran.err.contains("--integrator rk4"), "{}", ran.err);
    assert!(!ran.err.contains("max_steps") && ran.err.lines().count() == 1, "{}", ran.err);
    let time = number_after(&ran.err, FAILED);
    let partial = folder.read("run.partial.csv");
    let last: f64 = partial.lines().last().unwrap().split(',').next().unwrap().parse().unwrap();
    // The message rounds the time to three digits.
    assert!(last > 0.0 && (last / time - 1.0).abs() < 5e-3, "last row at {last} s, given up at {time} s");
}

/// If the first step fails, the summary has no drift.
#[test]
fn a_run_without_a_step_has_no_drift() {
    let folder = Folder::new("no_step");
    let run = ["simulate", "panda.urdf", "--velocity", "panda_joint1=1e150", "--csv", "run.csv"];
    for integrator in ["rk4", "explicit-euler", "adaptive"] {
        let ran = folder.run(&[&run[..], &["--integrator", integrator]].concat(), b"");
        assert_eq!(ran.code, Some(1), "{integrator}: {}", ran.out);
        let numbers = [DRIFT, UNACCOUNTED, "NaN"];
        assert!(!numbers.iter().any(|number| ran.out.contains(number)), "{integrator}: {}", ran.out);
    }
}

/// Motors with an effort limit of zero give no torque, and have no percentage.
#[test]
fn motors_without_effort_have_no_share() {
    let folder = Folder::new("no_effort");
    let idle = folder.read("panda.urdf").replace("effort=\"87\"", "effort=\"0\"");
    folder.write("idle.urdf", idle.as_bytes());
    let ran = folder.run(&["simulate", "idle.urdf", "--hold", "--duration", "0.1"], b"");
    let text = ran.out;
    assert!(ran.code == Some(0) && !text.contains("NaN"), "{text}");
    let row = text.lines().rev().find(|line| line.trim_start().starts_with("panda_joint2")).unwrap();
    let cells: Vec<&str> = row.split_whitespace().collect();
    // Joint, unit of two words, peak, demand, limit, used.
    assert_eq!((cells[3], cells[5], cells[6]), ("0", "0", "-"), "{row}");
    let row = text.lines().rev().find(|line| line.trim_start().starts_with("panda_joint5")).unwrap();
    assert!(row.contains(" %"), "the others have: {row}");
}

/// The humanoid falls for ten seconds with steps of a millisecond, with a fixed and a floating base.
#[test]
fn the_human_falls_for_ten_seconds() {
    let folder = Folder::new("human");
    for base in [&[][..], &["--floating-base"]] {
        let text = folder.output(&[&["simulate", "humanoid.urdf", "--conservative"], base].concat(), "");
        assert!(text.contains("rk4, 10000 steps of 0.001 s, 10 s"), "{text}");
        // Arms without stops swing fast. A millisecond is coarse for them, but the motion does not diverge.
        let drift = if text.contains(DRIFT) { DRIFT } else { DRIFT_OF_KINETIC };
        assert!(number_after(&text, drift) < 10.0, "{text}");
    }
}
