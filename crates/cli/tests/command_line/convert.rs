//! `dynamics convert`: each format to the other, losses told, nothing written over an input or where it cannot be right.

use std::path::Path;

use crate::command::Folder;

/// A folder with the MJCF robots beside the others.
fn folder(name: &str) -> Folder {
    let folder = Folder::new(name);
    for robot in ["arm", "hand", "linkage", "quadruped"] {
        let file = format!("{}/../../robots/{robot}.xml", env!("CARGO_MANIFEST_DIR"));
        folder.write(&format!("{robot}.xml"), &std::fs::read(file).unwrap());
    }
    folder
}

/// The number after a word of the command's answer.
fn after<'a>(text: &'a str, words: &str) -> &'a str {
    text.split(words).nth(1).and_then(|rest| rest.split_whitespace().next()).unwrap_or_default()
}

#[test]
fn both_ways_m_is_the_same() {
    let folder = folder("convert");
    for robot in ["panda.urdf", "gripper.urdf", "humanoid.urdf", "quadruped.xml", "hand.xml", "linkage.xml"] {
        let is_urdf = Path::new(robot).extension().is_some_and(|ending| ending == "urdf");
        let (there, back) = if is_urdf { ("there.xml", "back.urdf") } else { ("there.urdf", "back.xml") };
        let ran = folder.run(&["convert", robot, there], b"");
        assert_eq!(ran.code, Some(0), "{robot}: {}", ran.err);
        let off: f64 = after(&ran.out, "M the same to").parse().unwrap();
        assert!(off < 1e-12, "{robot}: {}", ran.out);
        let ran = folder.run(&["convert", there, back], b"");
        assert_eq!(ran.code, Some(0), "{robot}: {}", ran.err);
        // The formats find each other by content: M of all three by the command itself.
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

/// Physics as warnings, once for all of a kind; looks and bookkeeping as notes; with --strict no file.
#[test]
fn losses_are_told_and_strict_refuses_them() {
    let folder = folder("convert_losses");
    let ran = folder.run(&["convert", "arm.xml", "arm.urdf"], b"");
    assert_eq!(ran.code, Some(0), "{}", ran.err);
    let lines: Vec<&str> = ran.err.lines().collect();
    let of = |word: &str| lines.iter().filter(|line| line.starts_with(word)).count();
    assert_eq!((of("warning: "), of("note: "), lines.len()), (1, 4, 5), "{}", ran.err);
    assert!(lines[0].contains("actuator \"pan_servo\", actuator \"lift_servo\""), "{}", ran.err);
    assert!(ran.out.starts_with("wrote arm.urdf: URDF, left out of physics: 6; read back, "), "{}", ran.out);

    let before = folder.names();
    let ran = folder.run(&["convert", "--strict", "arm.xml", "strict.urdf"], b"");
    assert_eq!((ran.code, ran.out.as_str()), (Some(1), ""), "{}", ran.err);
    let last = "error: strict.urdf is not written: URDF has no words for the physics named above (6)\n";
    assert!(ran.err.ends_with(last), "{}", ran.err);
    assert_eq!(folder.names(), before);
    // All of it has words in MJCF.
    let ran = folder.run(&["convert", "--strict", "arm.xml", "same.xml"], b"");
    assert_eq!((ran.code, ran.err.as_str()), (Some(0), ""), "{}", ran.out);
    assert!(ran.out.contains("MJCF, no physics left out"), "{}", ran.out);
}

/// To standard output, the format said; locked joints and a floating base go along.
#[test]
fn options_of_reading_go_along() {
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
    let long = "panda.json does not tell the format: name it .urdf or .xml, or say --to urdf or --to mjcf";
    for (arguments, message) in [
        (&["panda.urdf", "panda.json"][..], long),
        (
            &["panda.urdf", "-"],
            "- does not tell the format: name it .urdf or .xml, or say --to urdf or --to mjcf",
        ),
        (
            &["panda.urdf", "panda.urdf"],
            "the output panda.urdf is the same file as the robot's file, panda.urdf; name another file",
        ),
        (
            &["panda.urdf", "./panda.urdf", "--to", "mjcf"],
            "the output ./panda.urdf is the same file as the robot's file, panda.urdf; name another file",
        ),
        (&["nowhere.urdf", "a.xml"], "cannot read nowhere.urdf: "),
        (&["panda.urdf", "nowhere/a.xml"], "cannot write nowhere/a.xml: "),
    ] {
        let ran = folder.run(&[&["convert"], arguments].concat(), b"");
        assert_eq!((ran.code, ran.out.as_str()), (Some(1), ""), "{arguments:?}: {}", ran.err);
        let told = ran.err.lines().last().unwrap_or_default();
        assert!(told.starts_with(&format!("error: {message}")), "{arguments:?}: {}", ran.err);
    }
    let ran = folder.run(&["convert", "panda.urdf", "a.xml", "--to", "sdf"], b"");
    assert_eq!(ran.code, Some(2), "{}", ran.err);
    assert!(ran.err.contains("possible values: urdf, mjcf"), "{}", ran.err);
    let ran = folder.run(&["convert", "panda.urdf"], b"");
    assert!(ran.code == Some(2) && ran.err.contains("<OUTPUT>"), "{}", ran.err);
    folder.write("broken.xml", b"<mujoco><worldbody><body>");
    let ran = folder.run(&["convert", "broken.xml", "a.urdf"], b"");
    assert!(ran.code == Some(1) && ran.err.contains("not well-formed"), "{}", ran.err);
    assert_eq!(folder.read("panda.urdf"), panda);
    assert_eq!(folder.names().len(), before.len() + 1);
}
