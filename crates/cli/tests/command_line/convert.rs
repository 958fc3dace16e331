//! `dynamics convert`: both directions, reports of lost features, and protection of existing files.

use std::path::Path;

use crate::command::Folder;
use crate::labels::{LOST_PHYSICS, MASS_DIFFERENCE, number_after};

/// A folder with the MJCF robots in addition to the others.
fn folder(name: &str) -> Folder {
    let folder = Folder::new(name);
    for robot in ["arm", "hand", "linkage", "quadruped"] {
        let file = format!("{}/../../robots/{robot}.xml", env!("CARGO_MANIFEST_DIR"));
        folder.write(&format!("{robot}.xml"), &std::fs::read(file).unwrap());
    }
    let hand = format!("{}/../../testdata/sdf/hand/hand.sdf", env!("CARGO_MANIFEST_DIR"));
    folder.write("palm.sdf", &std::fs::read(hand).unwrap());
    folder
}

#[test]
fn both_ways_m_is_the_same() {
    let folder = folder("convert");
    for robot in [
        "panda.urdf",
        "gripper.urdf",
        "humanoid.urdf",
        "quadruped.xml",
        "hand.xml",
        "linkage.xml",
        "palm.sdf",
    ] {
        let is_urdf = Path::new(robot).extension().is_some_and(|ending| ending == "urdf");
        let (there, back) = if is_urdf { ("there.xml", "back.urdf") } else { ("there.urdf", "back.xml") };
        let ran = folder.run(&["convert", robot, there], b"");
        assert_eq!(ran.code, Some(0), "{robot}: {}", ran.err);
        let off = number_after(&ran.out, MASS_DIFFERENCE);
        assert!(off < 1e-12, "{robot}: {}", ran.out);
        let ran = folder.run(&["convert", there, back], b"");
        assert_eq!(ran.code, Some(0), "{robot}: {}", ran.err);
        // The reader tells formats by content; `compute` gives M of both.
        let mass = |file: &str, inputs: &str| folder.output(&["compute", file], inputs);
        if robot == "panda.urdf" {
            let state =
                "{\"q\":[0.1,0.2,0.3,-1.4,0.5,1.6,0.7],\"v\":[1,0,0,1,0,0,0],\"a\":[0,0,1,0,0,0,0]}\n";
            let numbers = |text: String| -> Vec<f64> {
                text.split(|c: char| !"+-.e0123456789".contains(c))
                    .filter_map(|word| word.parse().ok())
                    .collect()
            };
            let (own, other) = (numbers(mass(robot, state)), numbers(mass(there, state)));
            assert!(own.len() > 60 && own.len() == other.len(), "{}", own.len());
            let scale = own.iter().fold(0.0_f64, |most, x| most.max(x.abs()));
            assert!(own.iter().zip(&other).all(|(a, b)| (a - b).abs() < 1e-12 * scale));
        }
    }
}

/// Lost physics gives one warning per kind, appearance and metadata give notes, and --strict writes no file.
#[test]
fn losses_are_reported_and_strict_rejects_them() {
    let folder = folder("convert_losses");
    let ran = folder.run(&["convert", "arm.xml", "arm.urdf"], b"");
    assert_eq!(ran.code, Some(0), "{}", ran.err);
    let lines: Vec<&str> = ran.err.lines().collect();
    let of = |word: &str| lines.iter().filter(|line| line.starts_with(word)).count();
    assert_eq!((of("warning: "), of("note: "), lines.len()), (1, 4, 5), "{}", ran.err);
    assert!(lines[0].contains("actuator \"pan_servo\", actuator \"lift_servo\""), "{}", ran.err);
    assert_eq!(number_after(&ran.out, LOST_PHYSICS), 6.0, "{}", ran.out);

    let before = folder.names();
    let ran = folder.run(&["convert", "--strict", "arm.xml", "strict.urdf"], b"");
    assert_eq!((ran.code, ran.out.as_str()), (Some(1), ""), "{}", ran.err);
    assert_eq!(ran.err.matches("error: ").count(), 1, "{}", ran.err);
    assert_eq!(folder.names(), before);
    // MJCF can represent all of it.
    let ran = folder.run(&["convert", "--strict", "arm.xml", "same.xml"], b"");
    assert_eq!((ran.code, ran.err.as_str()), (Some(0), ""), "{}", ran.out);
    assert!(!ran.out.contains(LOST_PHYSICS), "{}", ran.out);
}

/// Output to standard output with a given format, locked joints and a floating base.
#[test]
fn reader_options_apply() {
    let folder = folder("convert_options");
    let converted = |arguments: &[&str]| {
        let ran = folder.run(&[&["convert", "two_r.urdf", "-"], arguments].concat(), b"");
        assert_eq!(ran.code, Some(0), "{arguments:?}: {}", ran.err);
        (ran.out, ran.err)
    };
    let (text, told) = converted(&["--to", "mjcf", "--floating-base"]);
    assert!(told.lines().all(|line| line.starts_with("note: ")), "{told}");
    assert!(
        text.starts_with("<mujoco model=\"two_r\">\n")
            && text.contains("<freejoint name=\"floating_base\"/>"),
        "{text}"
    );
    let (text, told) = converted(&["--to", "urdf"]);
    assert_eq!(told, "");
    assert!(text.starts_with("<robot name=\"two_r\">\n"), "{text}");
    let ran = folder.run(&["convert", "panda.urdf", "locked.xml", "--lock", "panda_joint7=0.3"], b"");
    assert_eq!(ran.code, Some(0), "{}", ran.err);
    assert!(!folder.read("locked.xml").contains("name=\"panda_joint7\""), "{}", folder.read("locked.xml"));
}

#[test]
fn wrong_input_writes_nothing() {
    let folder = folder("convert_wrong");
    let before = folder.names();
    let panda = folder.read("panda.urdf");
    for (arguments, code) in [
        (&["panda.urdf", "panda.json"][..], 1),
        (&["panda.urdf", "-"], 1),
        (&["panda.urdf", "panda.urdf"], 1),
        (&["panda.urdf", "./panda.urdf", "--to", "mjcf"], 1),
        (&["nowhere.urdf", "a.xml"], 1),
        (&["panda.urdf", "nowhere/a.xml"], 1),
        (&["panda.urdf", "a.xml", "--to", "sdf"], 2),
        (&["panda.urdf"], 2),
    ] {
        let ran = folder.run(&[&["convert"], arguments].concat(), b"");
        assert_eq!((ran.code, ran.out.as_str()), (Some(code), ""), "{arguments:?}: {}", ran.err);
        assert!(ran.err.lines().last().unwrap().starts_with("error: "), "{arguments:?}: {}", ran.err);
    }
    folder.write("broken.xml", b"<mujoco><worldbody><body>");
    let ran = folder.run(&["convert", "broken.xml", "a.urdf"], b"");
    assert_eq!(ran.code, Some(1), "{}", ran.err);
    assert_eq!(folder.read("panda.urdf"), panda);
    assert_eq!(folder.names().len(), before.len() + 1);
}

/// A scene is a robot for every command, and `convert` writes it as one.
#[test]
fn scenes_are_converted_to_one_robot() {
    let folder = folder("convert_scene");
    let scene = r#"<scene>
        <robot file="panda.urdf" xyz="0 0 0.1"/>
        <robot file="hand.xml" on="panda_link8" prefix="hand_"/>
        <table name="table" size="1 0.6 0.4" xyz="0.9 0 0"/>
        <box name="cube" size="0.1 0.1 0.1" mass="0.5" xyz="0.8 0 0.46"/></scene>"#;
    folder.write("cell.scene", scene.as_bytes());
    let ran = folder.run(&["convert", "cell.scene", "cell.xml"], b"");
    assert_eq!(ran.code, Some(0), "{}", ran.err);
    assert!(number_after(&ran.out, MASS_DIFFERENCE) < 1e-12, "{}", ran.out);
    let written = std::fs::read_to_string(folder.path("cell.xml")).unwrap();
    assert!(written.contains("<mujoco model=\"cell\"") && written.contains("hand_"), "{written}");
    folder.write("bad.scene", b"<scene>\n<box name='a'/>\n<robot file='none.urdf'/></scene>");
    let ran = folder.run(&["inspect", "bad.scene"], b"");
    assert_eq!(ran.code, Some(1));
    assert!(ran.err.contains("bad.scene: 2 errors") && ran.err.contains("line 3: "), "{}", ran.err);
    // No output replaces a file of the scene.
    let ran = folder.run(&["convert", "cell.scene", "hand.xml"], b"");
    assert!(ran.code == Some(2) || ran.code == Some(1), "{}", ran.err);
}

/// The note that a floating base has no effect is printed only if this is so.
#[test]
fn floating_base_of_a_scene_has_an_effect() {
    let folder = folder("floating_scene");
    let mass = "<inertial pos='0 0 0' mass='1' diaginertia='1 1 1'/>";
    let scene = |joint: &str| {
        format!(
            "<mujoco><worldbody><geom type='plane' size='1 1 1'/><body name='robot'>{joint}{mass}\
             <body><joint name='hinge'/>{mass}</body></body></worldbody></mujoco>"
        )
    };
    for (joint, has_no_effect) in [("", false), ("<freejoint/>", true)] {
        folder.write("scene.xml", scene(joint).as_bytes());
        let ran = folder.run(&["inspect", "scene.xml", "--floating-base"], b"");
        assert_eq!(ran.code, Some(0), "{}", ran.err);
        assert!(ran.out.contains("7 degrees of freedom"), "{}", ran.out);
        assert_eq!(ran.err.contains("--floating-base has no effect"), has_no_effect, "{}", ran.err);
    }
}
