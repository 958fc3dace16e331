//! Proven bounds by `dynamics certify`, and certificates that a program without this library's code checks.

use std::process::Command;

use serde_json::Value;

use crate::command::Folder;

/// The options of each task for a small robot.
const TASKS: [&[&str]; 5] = [
    &["digits", "two_r.urdf", "--states", "3"],
    &["mass-matrix", "two_r.urdf"],
    &["reach", "two_r.urdf", "--frame", "tip", "--range", "elbow=0.2,1"],
    &["reach", "gantry.urdf", "--frame", "tool", "--keep", "0,0,-1,0.5"],
    &[
        "torques",
        "two_r.urdf",
        "--to",
        "shoulder=-1.2,elbow=0.4",
        "--from",
        "shoulder=-1.5",
        "--masses",
        "0.9,1.1",
        "--payload",
        "0,0.5",
        "--payload-frame",
        "tip",
        "--duration",
        "1.5",
        "--tolerance",
        "0.05",
    ],
];

/// The exit code of the checker and its line.
fn check(folder: &Folder, certificate: &str) -> (Option<i32>, String) {
    folder.write("check_certificate.py", folder.output(&["certify", "checker"], "").as_bytes());
    let mut python = Command::new("python3");
    let output =
        python.arg(folder.path("check_certificate.py")).arg(folder.path(certificate)).output().unwrap();
    assert_eq!(String::from_utf8(output.stderr).unwrap(), "");
    (output.status.code(), String::from_utf8(output.stdout).unwrap())
}

#[test]
fn another_program_proves_each_certificate_again() {
    let folder = Folder::new("certify_tasks");
    for task in TASKS {
        let arguments = [&["certify"][..], task, &["--certificate", "certificate.json"]].concat();
        folder.output(&arguments, "");
        let (code, line) = check(&folder, "certificate.json");
        assert_eq!(code, Some(0), "{task:?}: {line}");
        assert!(line.ends_with("proven\n"), "{line}");
    }
}

/// Changes a number of a certificate.
fn altered(folder: &Folder, change: impl FnOnce(&mut Value)) {
    let mut certificate: Value = serde_json::from_str(&folder.read("certificate.json")).unwrap();
    change(&mut certificate);
    folder.write("altered.json", certificate.to_string().as_bytes());
}

#[test]
fn another_program_refuses_false_claims() {
    let folder = Folder::new("certify_false");
    let certificate = |task: &[&str]| {
        folder.output(&[&["certify"][..], task, &["--certificate", "certificate.json"]].concat(), "");
    };
    let is_refused = || check(&folder, "altered.json").0 == Some(1);
    certificate(TASKS[0]);
    altered(&folder, |c| {
        c["robot"]["bodies"][1]["mass"] =
            (c["robot"]["bodies"][1]["mass"].as_f64().unwrap() * (1.0 + 1e-9)).into();
    });
    assert!(is_refused(), "a mass that differs in the ninth digit");
    certificate(TASKS[1]);
    altered(&folder, |c| c["robot"]["bodies"][1]["inertia"] = vec![vec![0.0; 3]; 3].into());
    assert!(is_refused(), "a body without inertia about its joint");
    certificate(TASKS[3]);
    altered(&folder, |c| {
        let most = &mut c["claim"]["half_spaces"][0]["at_most"];
        *most = (most.as_f64().unwrap() - 1.0).into();
    });
    assert!(is_refused(), "a half-space that the tool enters");
    certificate(TASKS[4]);
    altered(&folder, |c| {
        let greatest = &mut c["claim"]["torques"][0][1];
        *greatest = (0.9 * greatest.as_f64().unwrap()).into();
    });
    assert!(is_refused(), "a torque that is exceeded");
    altered(&folder, |c| {
        c["claim"]["parts"].as_array_mut().unwrap().remove(0);
    });
    let output = Command::new("python3")
        .arg(folder.path("check_certificate.py"))
        .arg(folder.path("altered.json"))
        .output()
        .unwrap();
    assert!(!output.status.success(), "a motion with a gap");
}

#[test]
fn verdicts_are_proven_exceeded_or_false() {
    let folder = Folder::new("certify_verdicts");
    let json = |arguments: &[&str]| -> (Option<i32>, Value) {
        let ran = folder.run(&[&["certify"][..], arguments, &["--json"]].concat(), b"");
        (ran.code, serde_json::from_str(&ran.out).unwrap())
    };
    let motion = ["torques", "panda.urdf", "--to", "panda_joint1=1"];
    let (code, slow) = json(&[&motion[..], &["--duration", "2"]].concat());
    assert_eq!((code, &slow["proven"]), (Some(0), &true.into()));
    let (code, fast) = json(&[&motion[..], &["--duration", "0.05"]].concat());
    assert_eq!((code, &fast["torques"][0]["verdict"]), (Some(1), &"exceeded".into()));
    let (code, reach) =
        json(&["reach", "panda.urdf", "--frame", "panda_link8", "--keep", "0,0,1,1.1", "--cells", "16"]);
    assert_eq!((code, &reach["bounds"][0]["verdict"]), (Some(1), &"false".into()));
    // The reach of the arm's datasheet is 0.855 m from the first axis to the flange's axis, without its
    // offsets.
    let (_, reach) = json(&["reach", "panda.urdf", "--frame", "panda_link8"]);
    let radius = reach["bounds"][0]["greatest"].as_f64().unwrap();
    assert!((0.855..0.865).contains(&radius), "{radius}");
}

#[test]
fn wrong_options_are_named() {
    let folder = Folder::new("certify_wrong");
    for (arguments, message) in [
        (&["torques", "two_r.urdf"][..], "error: give the motion by --from and --to, or by --motion\n"),
        (
            &["torques", "quadruped.urdf", "--floating-base", "--to", "x=1"],
            "needs joints without quaternions",
        ),
        (&["reach", "two_r.urdf", "--frame", "hand"], "no frame"),
        (&["reach", "gantry.urdf", "--frame", "tool", "--range", "x=1"], "--range"),
        (&["torques", "two_r.urdf", "--to", "elbow=1", "--masses", "-1,1"], "--masses"),
        (&["torques", "two_r.urdf", "--motion", "none.csv"], "none.csv"),
    ] {
        let ran = folder.run(&[&["certify"][..], arguments].concat(), b"");
        assert!(ran.code != Some(0) && ran.err.contains(message), "{arguments:?}: {}", ran.err);
    }
}
