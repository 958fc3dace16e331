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
    folder
}

#[test]
fn both_ways_m_is_the_same() {
    let folder = folder("convert");
    for robot in ["panda.urdf", "gripper.urdf", "humanoid.urdf", "quadruped.xml", "hand.xml", "linkage.xml"] {
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
