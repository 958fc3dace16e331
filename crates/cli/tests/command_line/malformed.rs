//! Wrong command lines and wrong files: each has one line that says what is wrong, and its exit code.

use crate::command::Folder;

/// A body that can be swung, with a mistake to be put in.
const PENDULUM: &str = r#"<robot name="pendulum">
  <link name="ceiling"/>
  <link name="bob">
    <inertial>
      <mass value="2"/>
      <inertia ixx="1" ixy="0" ixz="0" iyy="1" iyz="0" izz="1"/>
    </inertial>
  </link>
  <joint name="hinge" type="continuous">
    <parent link="ceiling"/>
    <child link="bob"/>
    <dynamics damping="0.1"/>
  </joint>
</robot>"#;

/// A file that is not what it should be, and the rest of the line that says so.
const FILES: &[(&str, &str, &str)] = &[
    ("", "", "the file is empty; a URDF file holds one <robot> element"),
    ("", "robot", "line 1, column 1: not well-formed XML: unknown token"),
    (
        "",
        "<sdf version=\"1.6\"/>",
        "line 1: the outermost element is <sdf>, not <robot>; SDF files are not read; export URDF",
    ),
    (
        "value=\"2\"",
        "value=\"NaN\"",
        "line 5: link \"bob\"/inertial/mass: value=\"NaN\" is not a finite number; write an ordinary number in SI \
         units",
    ),
    (
        "damping=\"0.1\"",
        "damping=\"low\"",
        "line 12: joint \"hinge\"/dynamics: damping=\"low\" is not a number",
    ),
    (
        "type=\"continuous\"",
        "type=\"hinge\"",
        "line 9: joint \"hinge\": the type \"hinge\" is unknown; use revolute, continuous, prismatic, fixed, \
         floating, planar or spherical",
    ),
    (
        "child link=\"bob\"",
        "child link=\"rod\"",
        "line 9: joint \"hinge\": its child link \"rod\" does not exist; add it or correct the name",
    ),
    (
        "child link=\"bob\"",
        "child link=\"ceiling\"",
        "line 9: joint \"hinge\" joins link \"ceiling\" to itself; parent and child must differ",
    ),
];

/// Every malformed file is refused by every command with the same line.
#[test]
fn malformed_files() {
    let folder = Folder::new("malformed_files");
    for (index, (wanted, mistake, message)) in FILES.iter().enumerate() {
        let text = if wanted.is_empty() { (*mistake).to_owned() } else { PENDULUM.replace(wanted, mistake) };
        assert!(text != PENDULUM, "case {index} changes nothing");
        folder.write("bad.urdf", text.as_bytes());
        for command in ["inspect", "compute", "simulate", "audit"] {
            let ran = folder.run(&[command, "bad.urdf"], b"");
            assert_eq!(ran.err, format!("error: bad.urdf: {message}\n"), "{command}, case {index}");
            assert_eq!((ran.code, ran.out.as_str()), (Some(1), ""), "{command}, case {index}");
        }
    }
}

/// All errors of a file in one go, each on a line of its own.
#[test]
fn all_errors_at_once() {
    let folder = Folder::new("all_errors_at_once");
    let text = PENDULUM.replace("value=\"2\"", "value=\"2,5\"").replace("link=\"bob\"", "link=\"rod\"");
    folder.write("bad.urdf", text.as_bytes());
    for command in ["inspect", "compute", "simulate", "audit"] {
        let ran = folder.run(&[command, "bad.urdf"], b"");
        let expected = "error: bad.urdf: 2 errors\n  line 5: link \"bob\"/inertial/mass: value=\"2,5\" is not a number; it has \
                        a comma: write a decimal point, and white space between numbers\n  line 9: joint \"hinge\": its child link \
                        \"rod\" does not exist; add it or correct the name\n";
        assert_eq!((ran.code, ran.err.as_str(), ran.out.as_str()), (Some(1), expected, ""), "{command}");
    }
}

/// What is suspicious is computed as written, and no command computes it in silence.
#[test]
fn warnings_are_shown_by_every_command() {
    let folder = Folder::new("warnings_are_shown");
    let text = PENDULUM.replace("izz=\"1\"", "izz=\"5\"").replace(" name=\"pendulum\"", "");
    folder.write("odd.urdf", text.as_bytes());
    let name = "line 1: robot: no name: taken as \"odd\", after the file; write <robot name=\"NAME\">";
    let moments =
        "line 4: link \"bob\"/inertial: the principal moments 1, 1, 5 kg·m² break the triangle inequality";
    let state = b"{\"q\":[0.1],\"v\":[0],\"tau\":[0]}";
    for command in ["compute", "simulate", "audit"] {
        let ran = folder.run(&[command, "odd.urdf"], state);
        let lines: Vec<&str> =
            ran.err.lines().filter(|line| line.starts_with("warning: odd.urdf: ")).collect();
        assert_eq!(lines.len(), 2, "{command}: {}", ran.err);
        assert!(lines[0].ends_with(name) && lines[1].contains(moments), "{command}: {}", ran.err);
    }
    let listed = folder.run(&["inspect", "odd.urdf"], b"");
    assert_eq!((listed.code, listed.err.as_str()), (Some(0), ""));
    assert!(
        listed.out.contains(&format!("warning: {}", name.replacen(": no", ": AS WRITTEN: no", 1))),
        "{}",
        listed.out
    );
    assert!(listed.out.contains("2 suspicious but taken as written"), "{}", listed.out);
    // Repair shows what it replaces.
    let repaired = folder.run(&["inspect", "odd.urdf", "--repair-inertia"], b"");
    assert!(repaired.out.contains("1, 1, 5 → 1, 1, 2 kg·m²"), "{}", repaired.out);
    let strict = folder.run(&["inspect", "odd.urdf", "--strict"], b"");
    assert_eq!(strict.code, Some(1));
    assert!(strict.err.starts_with("error: odd.urdf: 2 errors\n  line 1: robot: no name"), "{}", strict.err);
}

/// Six joints with two unknown attributes each are two warnings, and `inspect` lists all twelve.
#[test]
fn warnings_of_one_kind_are_one_line() {
    let folder = Folder::new("grouped_warnings");
    let joint = |k: usize| {
        format!(
            "<link name=\"l{k}\"><inertial><mass value=\"1\"/><inertia ixx=\"1\" iyy=\"1\" izz=\"1\" ixy=\"0\" ixz=\"0\" \
             iyz=\"0\"/></inertial></link><joint name=\"j{k}\" type=\"continuous\"><parent link=\"l{}\"/><child \
             link=\"l{k}\"/><axis xyz=\"1 0 0\"/><dynamics bound{k}=\"0\" stiff=\"{k}.5\"/></joint>\n",
            k - 1
        )
    };
    let text = format!(
        "<robot name=\"chain\"><link name=\"l0\"/>\n{}",
        (1..=6).map(joint).collect::<Vec<_>>().concat()
    );
    folder.write("chain.urdf", (text + "</robot>").as_bytes());
    let ran = folder.run(&["compute", "chain.urdf"], b"{\"q\":[0,0,0,0,0,0]}");
    let lines: Vec<&str> = ran.err.lines().filter(|line| line.contains("stiff")).collect();
    assert_eq!(
        lines,
        [
            "warning: chain.urdf: line 2: joint \"j1\"/dynamics: unknown attribute stiff=\"1.5\" (6 of this kind; also at line 3: \
          joint \"j2\"/dynamics; line 4: joint \"j3\"/dynamics; line 5: joint \"j4\"/dynamics; and 2 more)"
        ],
        "{}",
        ran.err
    );
    // A digit within a name makes another kind.
    assert_eq!(ran.err.lines().filter(|line| line.contains("attribute bound")).count(), 6, "{}", ran.err);
    let listed = folder.run(&["inspect", "chain.urdf"], b"");
    assert_eq!(listed.out.matches("unknown attribute stiff").count(), 6, "{}", listed.out);
}

/// A robot that floats already stays as it is, and the command says so.
#[test]
fn a_floating_root_is_not_freed_twice() {
    let folder = Folder::new("a_floating_root");
    let text = PENDULUM.replace("\"continuous\"", "\"floating\"");
    folder.write("free.urdf", text.as_bytes());
    let plain = folder.run(&["inspect", "free.urdf"], b"");
    let freed = folder.run(&["inspect", "free.urdf", "--floating-base"], b"");
    assert_eq!((plain.code, freed.code), (Some(0), Some(0)));
    assert_eq!(plain.out.lines().next(), freed.out.lines().next());
    assert!(
        freed.err.contains("the robot's root floats already; --floating-base changes nothing"),
        "{}",
        freed.err
    );
}

/// A command line, its exit code, and the line on standard error.
type Case<'a> = (&'a [&'a str], i32, &'a str);

const PANDA_JOINTS: &str = "panda_joint1, panda_joint2, panda_joint3, panda_joint4, panda_joint5, panda_joint6, \
                            panda_joint7";

#[test]
fn malformed_command_lines() {
    let folder = Folder::new("malformed_command_lines");
    folder.write("pendulum.urdf", PENDULUM.as_bytes());
    let spring = PENDULUM.replace("damping=\"0.1\"", "springStiffness=\"3\"");
    folder.write("spring.urdf", spring.as_bytes());
    folder.write("still.urdf", b"<robot name=\"still\"><link name=\"stone\"/></robot>");
    folder.write("binary.urdf", b"\x89PNG\r\n\x1a\n\xff");
    std::fs::create_dir(folder.path("folder")).unwrap();
    let no_elbow =
        format!("--pose: robot `panda` has no joint `elbow`; its moving joints are {PANDA_JOINTS}");
    let no_knee = format!("--goal: robot `panda` has no joint `knee`; its moving joints are {PANDA_JOINTS}");
    let cases: &[Case<'_>] = &[
        (&["juggle"], 2, "unrecognized subcommand 'juggle' (see --help)"),
        (&["inspect"], 2, "the following required arguments were not provided: <ROBOT> (see --help)"),
        (
            &["simulate", "panda.urdf", "--posse", "a=1"],
            2,
            "unexpected argument '--posse' found; tip: a similar argument exists: '--pose' (see --help)",
        ),
        (&["inspect", "none.urdf"], 1, "cannot read none.urdf: No such file or directory (os error 2)"),
        (&["audit", "folder"], 1, "cannot read folder: Is a directory (os error 21)"),
        (
            &["compute", "binary.urdf"],
            1,
            "binary.urdf: byte 0 is not UTF-8 text; save the file as UTF-8, and check that it is a robot file at all",
        ),
        (
            &["inspect", "spring.urdf", "--strict"],
            1,
            "spring.urdf: line 12: joint \"hinge\"/dynamics: unknown attribute springStiffness=\"3\" (a warning, \
             which strict reading refuses; correct it or do not be strict)",
        ),
        (
            &["simulate", "still.urdf"],
            1,
            "still.urdf: no joint moves, so there is nothing to simulate (--floating-base frees the root link)",
        ),
        // Poses.
        (&["simulate", "panda.urdf", "--pose", "elbow=1"], 1, &no_elbow),
        (&["simulate", "panda.urdf", "--goal", "knee=1"], 1, &no_knee),
        (
            &["simulate", "panda.urdf", "--pose", "panda_joint1"],
            1,
            "--pose: robot `panda` has no pose `panda_joint1`: its file names none; write JOINT=NUMBER, several separated \
             by commas",
        ),
        (
            &["simulate", "panda.urdf", "--pose", "panda_joint1=NaN"],
            2,
            "invalid value 'panda_joint1=NaN' for '--pose <JOINT=NUMBER,…>': panda_joint1: NaN is not a finite \
             number (see --help)",
        ),
        (
            &["simulate", "panda.urdf", "--velocity", "panda_joint1=fast"],
            2,
            "invalid value 'panda_joint1=fast' for '--velocity <JOINT=NUMBER,…>': panda_joint1: \"fast\" is not a \
             number (see --help)",
        ),
        (
            &["simulate", "panda.urdf", "--pose", "panda_joint1=1,2"],
            1,
            "--pose: joint `panda_joint1` (revolute) takes 1 number, found 2",
        ),
        (
            &["simulate", "panda.urdf", "--pose", "panda_joint1=1", "--pose", "panda_joint1=2"],
            1,
            "--pose: joint `panda_joint1` is given twice",
        ),
        (
            &["simulate", "panda.urdf", "--pose", "panda_joint8=1"],
            1,
            "--pose: joint `panda_joint8` is fixed and has no value",
        ),
        (
            &["simulate", "gripper.urdf", "--pose", "thumb_turn=0.1"],
            1,
            "--pose: joint `thumb_turn` follows joint `grip`; set that one",
        ),
        (
            &["simulate", "quadruped.urdf", "--floating-base", "--pose", "floating_base=0,0,1,0,0,0,0"],
            1,
            "--pose: joint `floating_base`: the quaternion x,y,z,w has length 0, not 1; for no rotation write 0,0,0,1",
        ),
        (
            &["simulate", "quadruped.urdf", "--floating-base", "--pose", "floating_base=0,0,1"],
            1,
            "--pose: joint `floating_base` (floating) takes 7 numbers (x,y,z,qx,qy,qz,qw), found 3",
        ),
        (
            &["simulate", "quadruped.urdf", "--floating-base", "--velocity", "floating_base=1"],
            1,
            "--velocity: joint `floating_base` (floating) takes 6 numbers (vx,vy,vz,wx,wy,wz in the child's axes), \
             found 1",
        ),
        // Numbers.
        (
            &["simulate", "panda.urdf", "--step", "0"],
            2,
            "invalid value '0' for '--step <SECONDS>': it must be positive and finite (see --help)",
        ),
        (
            &["simulate", "panda.urdf", "--step", "-0.001"],
            2,
            "invalid value '-0.001' for '--step <SECONDS>': it must be positive and finite (see --help)",
        ),
        (
            &["simulate", "panda.urdf", "--step", "NaN"],
            2,
            "invalid value 'NaN' for '--step <SECONDS>': it must be positive and finite (see --help)",
        ),
        (
            &["simulate", "panda.urdf", "--step", "short"],
            2,
            "invalid value 'short' for '--step <SECONDS>': it is not a number (see --help)",
        ),
        (
            &["simulate", "panda.urdf", "--duration", "inf"],
            2,
            "invalid value 'inf' for '--duration <SECONDS>': it must be positive and finite (see --help)",
        ),
        (
            &["simulate", "panda.urdf", "--duration", "1e300"],
            1,
            "1.00e300 s in steps of 0.001 s are 1.00e303 steps, and 1e9 is the most; take a longer --step or a \
             shorter --duration",
        ),
        (
            &["simulate", "panda.urdf", "--integrator", "euler"],
            2,
            "invalid value 'euler' for '--integrator <NAME>': there is no method `euler`; there are explicit-euler, \
             semi-implicit-euler, rk4, variational-midpoint, variational-yoshida4, implicit, mujoco, adaptive (see --help)",
        ),
        (
            &["simulate", "panda.urdf", "--kp", "1", "--kd", "-1"],
            2,
            "invalid value '-1' for '--kd <GAIN>': it must be zero or positive, and finite (see --help)",
        ),
        (
            &["simulate", "panda.urdf", "--kp", "1"],
            2,
            "the following required arguments were not provided: --kd <GAIN> (see --help)",
        ),
        (
            &["audit", "panda.urdf", "--states", "0"],
            2,
            "invalid value '0' for '--states <STATES>': 0 is not in 1..=100000 (see --help)",
        ),
        // Files.
        (
            &["simulate", "panda.urdf", "--csv", "none/run.csv"],
            1,
            "cannot write none/run.csv: No such file or directory (os error 2)",
        ),
        (&["simulate", "panda.urdf", "--csv", "folder"], 1, "cannot write folder: it is a directory"),
        (
            &["simulate", "panda.urdf", "--plot", "run.pdf"],
            2,
            "invalid value 'run.pdf' for '--plot <FILE>': the name must end in .svg or .png (see --help)",
        ),
        (
            &["simulate", "panda.urdf", "--csv", "run.svg", "--plot", "run.svg"],
            1,
            "--plot run.svg is the same file as --csv, run.svg; name another file",
        ),
        (
            &["simulate", "panda.urdf", "--every", "0"],
            2,
            "invalid value '0' for '--every <STEPS>': 0 is not in 1..=4294967295 (see --help)",
        ),
    ];
    let before = folder.names();
    for (arguments, code, message) in cases {
        let ran = folder.run(arguments, b"");
        assert_eq!(ran.err, format!("error: {message}\n"), "{arguments:?}");
        assert_eq!((ran.code, ran.out.as_str()), (Some(*code), ""), "{arguments:?}");
    }
    assert_eq!(folder.names(), before, "a refused command leaves no file");
}

/// A line of states, and the error object it gives.
#[test]
fn malformed_states() {
    let folder = Folder::new("malformed_states");
    let wanted = "expected {\"q\":[..],\"v\":[..]} with \"a\" and \"tau\" optional";
    let cases: &[(&str, String)] = &[
        ("hello", format!("{wanted}; the line is no JSON object")),
        ("[[0,0],[0,0]]", format!("{wanted}; the line is no JSON object")),
        ("{\"q\":[0,0],\"v\":[0,0]", format!("{wanted}: EOF while parsing an object at column 20")),
        ("{\"q\":[0,0]}", format!("{wanted}: missing field `v` at column 11")),
        ("{\"q\":[0,null],\"v\":[0,0]}", format!("{wanted}: invalid type: null, expected f64 at column 12")),
        ("{\"q\":[0,NaN],\"v\":[0,0]}", format!("{wanted}: expected value at column 9")),
        ("{\"q\":[0,1e999],\"v\":[0,0]}", format!("{wanted}: number out of range at column 13")),
        (
            "{\"q\":[0,0],\"v\":[0,0],\"u\":[0,0]}",
            format!("{wanted}: unknown field `u`, expected one of `q`, `v`, `a`, `tau` at column 24"),
        ),
        ("{\"q\":[0],\"v\":[0,0]}", "q has 1 numbers, robot `two_r` needs 2".into()),
        ("{\"q\":[0,0],\"v\":[0,0,0]}", "v has 3 numbers, the robot needs 2".into()),
        ("{\"q\":[0,0],\"v\":[0,0],\"a\":[]}", "a has 0 numbers, the robot needs 2".into()),
        ("{\"q\":[0,0],\"v\":[0,0],\"tau\":[1]}", "tau has 1 numbers, the robot needs 2".into()),
        ("{\"q\":[0,1],\"v\":[1e200,0]}", "bias is not finite: the state's numbers are too large".into()),
    ];
    for (line, message) in cases {
        // A good line before and after it, and an empty one: the stream goes on and the count is right.
        let good = "{\"q\":[0,0],\"v\":[0,0]}";
        let ran = folder.run(&["compute", "two_r.urdf"], format!("{good}\n\n{line}\n{good}\n").as_bytes());
        let answers: Vec<serde_json::Value> =
            ran.out.lines().map(|line| serde_json::from_str(line).unwrap()).collect();
        assert_eq!(answers.len(), 3, "{line}");
        assert_eq!(answers[1], serde_json::json!({"error": message, "line": 3}), "{line}");
        assert!(answers[0]["gravity"].is_array() && answers[0] == answers[2], "{line}");
        let told = "error: 1 of 4 lines could not be used; each has an object with \"error\" in the output\n";
        assert_eq!((ran.code, ran.err.as_str()), (Some(1), told), "{line}");
    }
}

/// q with a quaternion of the wrong length is refused, as no rotation is meant by it.
#[test]
fn quaternions_of_compute_have_unit_length() {
    let folder = Folder::new("quaternions");
    folder.write("stone.urdf", PENDULUM.replace("continuous", "fixed").as_bytes());
    let state = "{\"q\":[0,0,0,0,0,0,0],\"v\":[0,0,0,0,0,0]}\n";
    let ran = folder.run(&["compute", "stone.urdf", "--floating-base"], state.as_bytes());
    assert_eq!(ran.code, Some(1));
    let answer: serde_json::Value = serde_json::from_str(&ran.out).unwrap();
    assert_eq!(
        answer["error"],
        "q[3..7] (joint `floating_base`) is a quaternion x y z w of length 0, not 1; normalise it, and \
         check its order"
    );
}

/// No states are no mistake, nor are bytes of any sort a panic.
#[test]
fn empty_and_hostile_input() {
    let folder = Folder::new("hostile_input");
    assert_eq!(folder.output(&["compute", "two_r.urdf"], ""), "");
    assert_eq!(folder.output(&["compute", "two_r.urdf"], "\n  \n"), "");
    let deep = "[".repeat(100_000);
    let long = format!("{{\"q\":[{}0]}}", "0,".repeat(100_000));
    for bytes in [&b"\xff\xfe{\x00}"[..], b"\0\0\0", deep.as_bytes(), long.as_bytes()] {
        let ran = folder.run(&["compute", "two_r.urdf"], bytes);
        assert_eq!(ran.code, Some(1));
        assert!(
            ran.out.starts_with("{\"error\":\"expected {") && ran.out.lines().count() == 1,
            "{}",
            ran.out
        );
    }
}
