//! The texts of the command: help, errors and summaries, compared with the files in `tests/snapshots`.
//!
//! All wording that tests compare is in these files. After a change, `INSTA_UPDATE=always cargo test -p
//! robot-dynamics-cli --all-features` rewrites them, for review as a diff.

use crate::command::{Folder, RunOutput};

/// A list of commands with their outputs.
#[derive(Default)]
pub(crate) struct Transcript(String);

impl Transcript {
    /// Adds a command with its exit code and its texts.
    pub(crate) fn add(&mut self, arguments: &[&str], ran: &RunOutput) {
        self.add_text(&format!("$ dynamics {}", arguments.join(" ")));
        if let Some(code) = ran.code.filter(|code| *code != 0) {
            self.add_text(&format!("exit code {code}"));
        }
        self.add_text(&ran.err);
        self.add_text(&ran.out);
        self.0.push('\n');
    }

    /// Adds a command that prints measured or computed numbers, each of which becomes `#`.
    pub(crate) fn add_without_numbers(&mut self, arguments: &[&str], ran: &RunOutput) {
        let [out, err] = [&ran.out, &ran.err].map(|text| without_numbers(text));
        self.add(arguments, &RunOutput { code: ran.code, out, err });
    }

    pub(crate) fn add_text(&mut self, text: &str) {
        self.0.push_str(text);
        if !text.is_empty() && !text.ends_with('\n') {
            self.0.push('\n');
        }
    }

    /// Compares it with the snapshot of this name.
    #[track_caller]
    pub(crate) fn compare(&self, name: &str) {
        let mut settings = insta::Settings::clone_current();
        settings.set_snapshot_path("../snapshots");
        settings.set_prepend_module_to_snapshot(false);
        settings.set_omit_expression(true);
        settings.bind(|| insta::assert_snapshot!(name, self.0));
    }
}

/// The text with `#` for each number. Longer spaces become two, since the width of a column depends on its
/// numbers. A row with at least four numbers keeps only a remark at its end.
fn without_numbers(text: &str) -> String {
    let is_row = |line: &str| line.matches("  #").count() + line.matches("  -").count() >= 4;
    let mut lines: Vec<String> = Vec::new();
    for line in numbers_marked(text).lines() {
        let line = match line.rsplit_once("  ") {
            Some((_, "#" | "-")) if is_row(line) => continue,
            Some((_, remark)) if is_row(line) => format!("  … {remark}"),
            _ => line.to_owned(),
        };
        if line.is_empty() || !lines.contains(&line) {
            lines.push(line);
        }
    }
    lines.join("\n")
}

fn numbers_marked(text: &str) -> String {
    let mut plain = String::new();
    let mut letters = text.chars().peekable();
    while let Some(letter) = letters.next() {
        let is_sign = letter == '-' && letters.peek().is_some_and(char::is_ascii_digit);
        if letter.is_ascii_digit() || is_sign {
            while letters.next_if(|next| next.is_ascii_digit() || ".e+-".contains(*next)).is_some() {}
            plain.push('#');
        } else if !(letter == ' ' && plain.ends_with("  ")) {
            plain.push(letter);
        }
    }
    plain
}

/// Robots for the commands, and files with mistakes.
fn folder(name: &str) -> Folder {
    let folder = Folder::new(name);
    for robot in ["arm", "hand", "linkage", "quadruped"] {
        let file = format!("{}/../../robots/{robot}.xml", env!("CARGO_MANIFEST_DIR"));
        folder.write(&format!("{robot}.xml"), &std::fs::read(file).unwrap());
    }
    let pendulum = crate::malformed::PENDULUM;
    folder.write("pendulum.urdf", pendulum.as_bytes());
    folder.write("spring.urdf", pendulum.replace("damping=\"0.1\"", "springStiffness=\"3\"").as_bytes());
    folder.write("free.urdf", pendulum.replace("\"continuous\"", "\"floating\"").as_bytes());
    folder.write("odd.urdf", pendulum.replace("izz=\"1\"", "izz=\"5\"").as_bytes());
    folder.write("stone.urdf", pendulum.replace("continuous", "fixed").as_bytes());
    folder.write("still.urdf", b"<robot name=\"still\"><link name=\"stone\"/></robot>");
    folder.write("binary.urdf", b"\x89PNG\r\n\x1a\n\xff");
    folder.write("broken.xml", b"<mujoco><worldbody><body>");
    folder.write("coaxial.urdf", crate::singular::coaxial().as_bytes());
    folder.write("balls.xml", BALLS.as_bytes());
    folder.write("bowl.xml", BOWL.as_bytes());
    folder.write("eggs.xml", EGGS.as_bytes());
    folder.write("empty.srdf", b"<robot name=\"r\"/>");
    folder.write("pairs.srdf", SRDF.as_bytes());
    let panda = folder.read("panda.urdf");
    folder.write("weak.urdf", panda.replace("effort=\"87\"", "effort=\"5\"").as_bytes());
    folder.write("idle.urdf", panda.replace("effort=\"87\"", "effort=\"0\"").as_bytes());
    let two_r = folder.read("two_r.urdf");
    folder.write("table.urdf", two_r.replace("xyz=\"0 -1 0\"", "xyz=\"0 0 1\"").as_bytes());
    let degrees = folder.read("ur5.urdf").replace("rpy=\"1.5707963267948966 0 0\"", "rpy=\"90 0 0\"");
    folder.write("degrees.urdf", degrees.replace("6.283185307179586\"", "360\"").as_bytes());
    folder.write("foreign.c", b"int mine;\n");
    std::fs::create_dir(folder.path("folder")).unwrap();
    folder
}

const BALLS: &str = r#"<mujoco><worldbody>
  <body name="low" pos="0 0 0.1"><freejoint/><geom type="sphere" size="0.1" mass="1"/></body>
  <body name="high" pos="0 0 0.35"><freejoint/><geom type="sphere" size="0.1" mass="1"/></body>
</worldbody></mujoco>"#;

const BOWL: &str = r#"<mujoco><asset>
  <hfield name="bowl" size="1 1 0.5 0.1" nrow="3" ncol="3" elevation="1 1 1 1 0 1 1 1 1"/></asset><worldbody>
  <geom type="hfield" hfield="bowl" pos="0 0 -1"/>
  <body pos="0.1 0 0"><freejoint name="base"/><geom size="0.1" mass="1"/></body></worldbody></mujoco>"#;

const EGGS: &str = r#"<mujoco><worldbody>
  <body name="one" pos="0 0 1"><freejoint/><site name="site"/><geom name="one" type="ellipsoid" size="0.1 0.2 0.3"/></body>
  <body name="two" pos="1 0 1"><freejoint/><geom name="two" type="ellipsoid" size="0.1 0.2 0.3"/></body>
</worldbody><sensor><gyro name="turn" site="site"/></sensor></mujoco>"#;

const SRDF: &str =
    r#"<robot name="r"><disable_collisions link1="high" link2="lowe" reason="Never"/></robot>"#;

/// The long help of every subcommand, which is also the text of its manual page.
#[test]
fn help() {
    let folder = Folder::new("messages_help");
    let mut transcript = Transcript::default();
    transcript.add(&["--help"], &folder.run(&["--help"], b""));
    for subcommand in crate::manuals::SUBCOMMANDS {
        let arguments = [subcommand, "--help"];
        transcript.add(&arguments, &folder.run(&arguments, b""));
    }
    transcript.compare("help");
}

/// Rejected command lines: exit code 1 or 2, one line on standard error, and no file.
const REFUSED: &str = "
    juggle
    inspect
    simulate panda.urdf --posse a=1
    completions csh
    man juggle
    man --output two_r.urdf

    inspect none.urdf
    audit folder
    compute binary.urdf
    inspect spring.urdf --strict
    inspect odd.urdf --strict
    inspect panda.urdf --package-path nowhere

    inspect pendulum.urdf --lock leg
    inspect pendulum.urdf --lock hinge,hinge
    inspect pendulum.urdf --lock hinge=1,2
    inspect pendulum.urdf --lock hinge=one
    inspect pendulum.urdf --lock hinge=inf
    inspect pendulum.urdf --lock ,
    inspect pendulum.urdf --lock floating_base
    inspect gripper.urdf --lock thumb_turn
    inspect panda.urdf --lock panda_joint8

    compute panda.urdf --terms frame_jacobian_local_world_aligned
    compute panda.urdf --terms forward_dynamics_derivatives --dissipation
    compute panda.urdf --frame hand
    compute panda.urdf --terms torque

    simulate still.urdf
    simulate panda.urdf --pose elbow=1
    simulate panda.urdf --goal knee=1
    simulate panda.urdf --pose panda_joint1
    simulate arm.xml --pose rest
    simulate panda.urdf --pose panda_joint1=NaN
    simulate panda.urdf --pose =1
    simulate panda.urdf --velocity panda_joint1=fast
    simulate panda.urdf --pose panda_joint1=1,2
    simulate panda.urdf --pose panda_joint1=1 --pose panda_joint1=2
    simulate panda.urdf --pose panda_joint8=1
    simulate gripper.urdf --pose thumb_turn=0.1
    simulate humanoid.urdf --pose knee=1
    simulate quadruped.urdf --floating-base --pose floating_base=0,0,1,0,0,0,0
    simulate quadruped.urdf --floating-base --pose floating_base=0,0,1
    simulate quadruped.urdf --floating-base --velocity floating_base=1

    simulate panda.urdf --dt 0
    simulate panda.urdf --dt -0.001
    simulate panda.urdf --dt NaN
    simulate panda.urdf --dt short
    simulate panda.urdf --duration inf
    simulate panda.urdf --duration 1e300
    simulate panda.urdf --integrator euler
    simulate panda.urdf --integrator dop853
    simulate panda.urdf --without stops
    simulate panda.urdf --tolerance 1e-6
    simulate panda.urdf --integrator rk4 --tolerance 1e-6
    simulate panda.urdf --integrator adaptive --tolerance 1e-20
    simulate panda.urdf --integrator adaptive --tolerance small
    simulate panda.urdf --kp 1 --kd -1
    simulate panda.urdf --kp 1
    simulate panda.urdf --sample-period 0

    simulate panda.urdf --controls
    simulate arm.xml --controls pan=1
    simulate arm.xml --controls pan_servo
    simulate arm.xml --controls pan_servo=1,2
    simulate arm.xml --controls --without actuators

    simulate quadruped.urdf --floating-base --friction 1
    simulate quadruped.urdf --floating-base --standing
    simulate quadruped.urdf --floating-base --ground --integrator rk4
    simulate quadruped.urdf --floating-base --ground --integrator adaptive
    simulate quadruped.urdf --floating-base --ground --integrator mujoco --without limits
    simulate quadruped.urdf --floating-base --ground file
    simulate quadruped.urdf --floating-base --ground x=1
    simulate quadruped.urdf --floating-base --ground steep
    simulate quadruped.urdf --floating-base --ground z=high
    simulate quadruped.urdf --floating-base --ground slope=2
    simulate quadruped.urdf --floating-base --ground --friction -1
    simulate quadruped.urdf --floating-base --ground --friction much
    simulate quadruped.urdf --ground --standing
    simulate panda.urdf --ground
    simulate balls.xml --srdf pairs.srdf
    simulate balls.xml --srdf balls.xml

    simulate panda.urdf --csv none/run.csv
    simulate panda.urdf --csv folder
    simulate panda.urdf --csv folder/
    simulate panda.urdf --csv missing/
    simulate panda.urdf --plot run.pdf
    simulate panda.urdf --csv run.svg --plot run.svg
    simulate panda.urdf --csv panda.urdf
    simulate panda.urdf --csv run.partial.svg --plot run.svg

    audit panda.urdf --states 0
    bench still.urdf
    bench panda.urdf --states 10
    bench panda.urdf --threads many

    convert panda.urdf
    convert panda.urdf panda.json
    convert panda.urdf -
    convert panda.urdf panda.urdf
    convert panda.urdf none/a.xml
    convert panda.urdf a.xml --to sdf
    convert broken.xml a.urdf

    generate two_r.urdf --target rust --functions inverse_dynamic -o code
    generate two_r.urdf --target rust --functions frame_pose:hand -o code
    generate two_r.urdf --target rust --functions gravity,gravity -o code
    generate two_r.urdf --target c --lanes -o code
    generate two_r.urdf --target c --name foreign -o .
    generate two_r.urdf --target java -o code
";

#[cfg(target_os = "linux")] // some contain texts of the system
#[test]
fn refusals() {
    let folder = folder("messages_refusals");
    let before = folder.names();
    let mut transcript = Transcript::default();
    for line in REFUSED.lines().map(str::trim).filter(|line| !line.is_empty()) {
        let arguments: Vec<&str> = line.split_whitespace().collect();
        let ran = folder.run(&arguments, b"");
        assert!(matches!(ran.code, Some(1 | 2)) && ran.out.is_empty(), "{line}: {ran:?}");
        let lines = ran.err.lines().filter(|line| !line.starts_with("  ")).count();
        assert!(ran.err.starts_with("error: ") && lines == 1, "{line}: {}", ran.err);
        transcript.add(&arguments, &ran);
    }
    assert_eq!(folder.names(), before, "a refused command leaves no file");
    transcript.compare("refusals");
}

/// Commands whose output mixes words and numbers.
const SUMMARIES: &str = "
    inspect panda.urdf
    inspect gripper.urdf
    inspect humanoid.urdf --floating-base --lock-massless
    inspect free.urdf --floating-base
    inspect still.urdf
    inspect arm.xml
    inspect linkage.xml
    inspect eggs.xml
    inspect coaxial.urdf
    inspect odd.urdf
    inspect odd.urdf --repair-inertia
    inspect spring.urdf --all

    audit two_r.urdf --states 2
    audit odd.urdf --states 2
    audit spring.urdf --states 2
    audit degrees.urdf --states 2
    audit two_r.urdf --states 2 --floating-base

    convert arm.xml arm.urdf
    convert arm.xml strict.urdf --strict
    convert two_r.urdf two_r.xml
    convert still.urdf still.xml
    generate two_r.urdf --target c -o code
    man --output pages

    simulate panda.urdf --conservative --duration 0.1
    simulate panda.urdf --duration 0.1 --csv run.csv --plot run.svg
    simulate panda.urdf --duration 0.1 --pose panda_joint1=3
    simulate panda.urdf --duration 0.1 --velocity panda_joint1=3 --integrator rk4
    simulate panda.urdf --duration 0.1 --goal panda_joint2=0.5 --without limits
    simulate panda.urdf --duration 0.1 --hold --kp 100 --kd 10 --integrator adaptive
    simulate panda.urdf --duration 9 --stop-at-limits --integrator adaptive
    simulate weak.urdf --duration 0.1 --hold
    simulate idle.urdf --duration 0.1 --hold
    simulate table.urdf --duration 0.1
    simulate gripper.urdf --duration 0.1 --integrator adaptive
    simulate coaxial.urdf --duration 0.1
    simulate arm.xml --duration 0.1 --pose home --controls pan_servo=0.5
    simulate arm.xml --duration 0.1 --integrator rk4
    simulate linkage.xml --duration 0.1 --conservative
    simulate linkage.xml --duration 0.1 --integrator adaptive
    simulate quadruped.urdf --duration 0.01 --floating-base --hold
    simulate quadruped.urdf --duration 0.01 --floating-base --ground
    simulate quadruped.urdf --duration 0.01 --floating-base --ground --standing --integrator mujoco
    simulate quadruped.urdf --duration 0.01 --floating-base --ground slope=0.2,z=1 --friction 1.5 --standing
    simulate quadruped.urdf --duration 0.01 --ground z=1
    simulate balls.xml --duration 0.01 --ground
    simulate bowl.xml --duration 0.01 --ground file
    simulate panda.urdf --integrator explicit-euler --dt 0.05
    simulate humanoid.urdf --integrator variational-midpoint --dt 0.01
    simulate panda.urdf --velocity panda_joint1=1e150 --integrator adaptive
";

#[test]
fn summaries() {
    let folder = folder("messages_summaries");
    let mut transcript = Transcript::default();
    for line in SUMMARIES.lines().map(str::trim).filter(|line| !line.is_empty()) {
        let arguments: Vec<&str> = line.split_whitespace().collect();
        // Machine code depends on the instructions of the machine.
        let output = folder.command(&arguments).env("ROBOT_DYNAMICS_NATIVE", "0").output().unwrap();
        let [out, err] = [output.stdout, output.stderr].map(|text| String::from_utf8(text).unwrap());
        transcript.add_without_numbers(&arguments, &RunOutput { code: output.status.code(), out, err });
    }
    transcript.compare("summaries");
}
