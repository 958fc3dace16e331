//! Runs that end early or say little: interrupted between samples, given up, without a step, with idle motors.

use crate::command::Folder;

/// The number after `mark`.
fn number_after(text: &str, mark: &str) -> f64 {
    let rest = text.split_once(mark).unwrap_or_else(|| panic!("no {mark:?} in\n{text}")).1;
    let end = rest.find(|c: char| !"0123456789.e+-".contains(c)).unwrap_or(rest.len());
    rest[..end].parse().unwrap_or_else(|_| panic!("no number after {mark:?} in\n{text}"))
}

/// Seconds of processor time of a process.
#[cfg(target_os = "linux")]
fn processor_time(process: u32) -> f64 {
    let text = std::fs::read_to_string(format!("/proc/{process}/stat")).unwrap();
    let fields: Vec<&str> = text.rsplit_once(')').unwrap().1.split_whitespace().collect();
    // Fields 14 and 15 of proc(5), in hundredths of a second.
    let ticks: f64 = fields[11..13].iter().map(|field| field.parse::<f64>().unwrap()).sum();
    ticks / 100.0
}

/// Ctrl-C ends adaptive steps between two samples that are hours apart: exit code 130, and the state it came to is the
/// last row.
#[cfg(target_os = "linux")]
#[test]
fn an_interruption_between_samples() {
    let folder = Folder::new("between_samples");
    let run = ["simulate", "panda.urdf", "--integrator", "adaptive", "--tolerance", "1e-13"];
    let long = ["--step", "100000", "--duration", "100000", "--csv", "run.csv"];
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
    let time = number_after(&err, "interrupted at t = ");
    assert!(time > 0.0 && time < 1e5, "{err}");
    let partial = folder.read("run.partial.csv");
    let rows: Vec<&str> = partial.lines().collect();
    assert_eq!(rows.len(), 3, "the head, the start and the end: {partial}");
    assert_eq!(rows[2].split(',').next().unwrap().parse::<f64>().unwrap(), time);
    assert!(out.contains("energy drift") && out.contains("run.partial.csv (2 samples)"), "{out}");
}

/// A pendulum whose bob hardly weighs anything, in thick oil: its velocity follows within nanoseconds.
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

/// Damping of 10¹²/s is no matter of steps: those are implicit.
#[test]
fn a_stiff_joint_takes_few_steps() {
    let folder = Folder::new("oiled");
    folder.write("stiff.urdf", STIFF.as_bytes());
    let ran = folder.run(&["simulate", "stiff.urdf", "--integrator", "adaptive"], b"");
    assert_eq!(ran.code, Some(0), "{}", ran.err);
    assert!(
        ran.out.contains("adaptive, implicit as damping is stiff, order 5, tolerance 1e-9: "),
        "{}",
        ran.out
    );
    assert!(number_after(&ran.out, "tolerance 1e-9: ") < 1000.0, "{}", ran.out);
    // Hundreds of steps to 1e-9 each.
    assert!(number_after(&ran.out, "|E − E0 − in + out| / energy moved: ") < 1e-5, "{}", ran.out);
}

/// On a spring of 10⁸ rad/s.
const SPRUNG: &str = r#"<mujoco model="sprung"><worldbody>
  <body name="rod"><inertial pos="0.5 0 0" mass="1" diaginertia="0.1 0.1 0.1"/><joint name="hinge" axis="0 1 0"/>
    <body name="speck" pos="1 0 0"><inertial pos="0.1 0 0" mass="1e-8" diaginertia="1e-12 1e-12 1e-12"/>
      <joint name="sprung" axis="0 1 0" stiffness="1e6"/></body></body>
</worldbody></mujoco>"#;

/// The bound on steps ends a run that would take hours, names the joint and options, and keeps what there was.
#[test]
fn a_joint_that_asks_for_short_steps_is_named() {
    let folder = Folder::new("stiff");
    folder.write("sprung.xml", SPRUNG.as_bytes());
    let run = ["simulate", "sprung.xml", "--integrator", "adaptive", "--csv", "run.csv"];
    let ran = folder.run(&run, b"");
    assert_eq!(ran.code, Some(1), "{}", ran.out);
    assert!(ran.err.starts_with("error: given up at t = "), "{}", ran.err);
    assert!(
        ran.err.contains(" after 10100 steps since the sample before: `sprung` asks for steps of "),
        "{}",
        ran.err
    );
    assert!(ran.err.contains("--tolerance") && ran.err.contains("--integrator rk4"), "{}", ran.err);
    assert!(!ran.err.contains("max_steps") && ran.err.lines().count() == 1, "{}", ran.err);
    let time = number_after(&ran.err, "given up at t = ");
    let partial = folder.read("run.partial.csv");
    let last: f64 = partial.lines().last().unwrap().split(',').next().unwrap().parse().unwrap();
    // The time is said with three digits.
    assert!(last > 0.0 && (last / time - 1.0).abs() < 5e-3, "last row at {last} s, given up at {time} s");
}

/// What moved nowhere has no drift: the first step fails, and the summary says only that.
#[test]
fn a_run_without_a_step_has_no_drift() {
    let folder = Folder::new("no_step");
    let run = ["simulate", "panda.urdf", "--velocity", "panda_joint1=1e150", "--csv", "run.csv"];
    for integrator in ["rk4", "explicit-euler", "adaptive"] {
        let ran = folder.run(&[&run[..], &["--integrator", integrator]].concat(), b"");
        assert_eq!(ran.code, Some(1), "{integrator}: {}", ran.out);
        assert!(!ran.out.contains("drift") && !ran.out.contains("NaN"), "{integrator}: {}", ran.out);
        assert!(
            ran.out.contains("no step was taken, so there is nothing to say about the energy"),
            "{}",
            ran.out
        );
    }
}

/// A file that gives motors no effort: they do nothing, and no share of nothing is printed.
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
    // Joint, unit of two words, peak, asked for, limit, used.
    assert_eq!((cells[3], cells[5], cells[6]), ("0", "0", "-"), "{row}");
    assert!(row.ends_with("no motor: its effort limit is 0"), "{row}");
    let row = text.lines().rev().find(|line| line.trim_start().starts_with("panda_joint5")).unwrap();
    assert!(row.contains(" %"), "the others have: {row}");
}

/// Let go at a step of a millisecond the human falls for ten seconds, on its feet's stand and in the air.
#[test]
fn the_human_falls_for_ten_seconds() {
    let folder = Folder::new("human");
    for base in [&[][..], &["--floating-base"]] {
        let text = folder.output(&[&["simulate", "humanoid.urdf", "--conservative"], base].concat(), "");
        assert!(text.contains("rk4, 10000 steps of 0.001 s, 10 s"), "{text}");
        // Arms without stops swing wildly: a millisecond is coarse for them, but nothing blows up.
        let divisor = if text.contains("/ |E0|: ") { "/ |E0|: " } else { "/ max K: " };
        assert!(number_after(&text, divisor) < 10.0, "{text}");
    }
}
