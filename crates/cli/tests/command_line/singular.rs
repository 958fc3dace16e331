//! Robots whose mass matrix is singular: everything that needs no inverse, and a clear end of what does.

use crate::command::Folder;
use serde_json::{Value, json};
use std::fmt::Write;

const LINK: &str = r#"<inertial><origin xyz="0.1 0.02 0.2"/><mass value="1"/>
    <inertia ixx="0.01" ixy="0" ixz="0" iyy="0.01" iyz="0" izz="0.01"/></inertial>"#;

/// A chain of joints (name, axis, what the link holds), a metre apart along z where the link holds something.
fn chain(links: &[(&str, &str, &str)]) -> String {
    let mut text = r#"<robot name="chain"><link name="link0"/>"#.to_owned();
    for (i, (name, axis, inertial)) in links.iter().enumerate() {
        let kind = if name.starts_with("slide") { "prismatic" } else { "revolute" };
        let _ = write!(
            text,
            r#"<link name="link{}">{inertial}</link>
               <joint name="{name}" type="{kind}"><parent link="link{i}"/><child link="link{}"/><axis xyz="{axis}"/>
               <limit lower="-3" upper="3" effort="10" velocity="5"/></joint>"#,
            i + 1,
            i + 1
        );
    }
    text + "</robot>"
}

fn folder(name: &str) -> Folder {
    let folder = Folder::new(name);
    let files = [
        ("coaxial.urdf", chain(&[("one", "0 0 1", ""), ("two", "0 0 -1", LINK)])),
        ("gimbal.urdf", chain(&[("yaw", "0 0 1", ""), ("pitch", "0 1 0", ""), ("roll", "0 0 1", LINK)])),
        ("hand.urdf", chain(&[("arm", "0 1 0", LINK), ("slide", "1 0 0", ""), ("nail", "0 0 1", "")])),
        ("bare.urdf", chain(&[("arm", "0 1 0", LINK)])),
    ];
    for (name, text) in files {
        folder.write(name, text.as_bytes());
    }
    folder
}

fn objects(text: &str) -> Vec<Value> {
    text.lines().map(|line| serde_json::from_str(line).unwrap()).collect()
}

const COAXIAL: &str = "in every pose looked at the mass matrix is singular: joints `one`, `two` can move against each \
                       other without moving any inertia; no acceleration follows from the forces: give the links \
                       there mass or the joint armature, or lock a joint (--lock JOINT)";

#[test]
fn compute_gives_all_but_the_accelerations() {
    let folder = folder("singular_compute");
    let states = "{\"q\":[0.1,0.2],\"v\":[1,2],\"a\":[3,4],\"tau\":[5,6]}\n{\"q\":[0.1,0.2],\"v\":[1,2]}\n";
    let ran = folder.run(&["compute", "coaxial.urdf"], states.as_bytes());
    assert_eq!(ran.code, Some(1));
    assert_eq!(
        ran.err,
        format!(
            "warning: {COAXIAL}\nerror: 1 of 2 lines asked for accelerations where the mass matrix is singular; each \
             has \"forward_dynamics_error\" in place of \"forward_dynamics\"\n"
        )
    );
    let [first, second] = &objects(&ran.out)[..] else { panic!("{}", ran.out) };
    assert_eq!(first["mass_matrix"], second["mass_matrix"]);
    assert_eq!(first["inverse_dynamics"].as_array().unwrap().len(), 2);
    assert!(first.get("forward_dynamics").is_none() && second.get("forward_dynamics_error").is_none());
    let error = &first["forward_dynamics_error"];
    assert_eq!([&error["joints"], &error["line"]], [&json!(["one", "two"]), &json!(1)]);
    assert!(
        error["message"].as_str().unwrap().starts_with("the mass matrix is singular: joints `one`, `two`")
    );
    // Where nobody asks, nothing is missing.
    let ran = folder.run(&["compute", "coaxial.urdf"], b"{\"q\":[0.1,0.2],\"v\":[1,2],\"a\":[3,4]}");
    assert_eq!((ran.code, ran.err), (Some(0), format!("warning: {COAXIAL}\n")));
}

/// A gimbal is singular at zero and nowhere else: the other lines have their accelerations.
#[test]
fn singular_in_one_pose() {
    let folder = folder("singular_gimbal");
    let state = |pitch: f64| json!({"q": [0.1, pitch, 0.3], "v": [0, 0, 0], "tau": [1, 2, 3]}).to_string();
    let ran = folder.run(&["compute", "gimbal.urdf"], [state(0.0), state(0.5)].join("\n").as_bytes());
    assert_eq!(ran.code, Some(1));
    assert!(
        ran.err.starts_with("warning: at all zeros the mass matrix is singular: joints `yaw`, `roll` "),
        "{}",
        ran.err
    );
    let [first, second] = &objects(&ran.out)[..] else { panic!("{}", ran.out) };
    assert_eq!(first["forward_dynamics_error"]["joints"], json!(["yaw", "roll"]));
    assert_eq!(second["forward_dynamics"].as_array().unwrap().len(), 3);
    let audit = folder.run(&["audit", "gimbal.urdf", "--json"], b"");
    let audit = &objects(&audit.out)[0];
    let check =
        audit["checks"].as_array().unwrap().iter().find(|check| check["check"] == "mass_matrix").unwrap();
    assert_eq!(check["verdict"], "short");
    assert!(
        check["where"]
            .as_str()
            .unwrap()
            .starts_with("all zeros: the mass matrix is singular: joints `yaw`, `roll`")
    );
    // The states themselves are regular, and their accelerations are checked.
    assert!(audit["checks"].as_array().unwrap().iter().any(|check| check["check"] == "forward_routes"));
}

#[test]
fn a_simulation_ends_with_time_and_joints() {
    let folder = folder("singular_simulate");
    for integrator in ["rk4", "variational-midpoint", "adaptive"] {
        let ran =
            folder.run(&["simulate", "coaxial.urdf", "--integrator", integrator, "--csv", "run.csv"], b"");
        assert_eq!((ran.code, ran.out.as_str()), (Some(1), ""), "{integrator}");
        let last = ran.err.lines().last().unwrap();
        assert!(
            last.starts_with(
                "error: no step from t = 0 s: the mass matrix is singular: joints `one`, `two` "
            ),
            "{integrator}: {last}"
        );
        assert!(last.ends_with("or lock a joint (--lock JOINT)"), "{last}");
    }
}

#[test]
fn inspection_has_a_section() {
    let folder = folder("singular_inspect");
    let text = folder.output(&["inspect", "coaxial.urdf"], "");
    assert!(text.contains(&format!("\nMass matrix: {COAXIAL}\n")), "{text}");
    assert!(!folder.output(&["inspect", "bare.urdf"], "").contains("Mass matrix"));
    let object = &objects(&folder.output(&["inspect", "hand.urdf", "--json"], ""))[0]["singular_mass"];
    assert_eq!(object["massless_joints"], json!(["slide", "nail"]));
    assert_eq!(object["motions_at_zeros"], json!([["nail"], ["slide"]]));
    assert_eq!([&object["random_poses"], &object["random_poses_singular"]], [&json!(5), &json!(5)]);
    let object = &objects(&folder.output(&["inspect", "bare.urdf", "--json"], ""))[0]["singular_mass"];
    assert_eq!([&object["massless_joints"], &object["random_poses_singular"]], [&json!([]), &json!(0)]);
}

/// Massless joints load; held still they leave the robot that they hang on.
#[test]
fn locked_joints_simulate() {
    let folder = folder("locked");
    let ran = folder.run(&["simulate", "hand.urdf", "--duration", "0.1"], b"");
    assert_eq!(ran.code, Some(1));
    assert!(
        ran.err.contains("joints `slide`, `nail` move no inertia;")
            && ran.err.contains("or --lock-massless)"),
        "{}",
        ran.err
    );
    let bare = folder.output(&["simulate", "bare.urdf", "--duration", "0.1", "--csv", "bare.csv"], "");
    assert!(bare.contains("1 degree of freedom"), "{bare}");
    let told = "note: --lock-massless: joints `slide`, `nail` move no inertia and are held still\n";
    let run = ["simulate", "hand.urdf", "--duration", "0.1", "--csv", "hand.csv"];
    let ran = folder.run(&[&run[..], &["--lock-massless"]].concat(), b"");
    // The file is what it is, and its warnings stay.
    assert!(ran.code == Some(0) && ran.err.starts_with(told), "{}", ran.err);
    assert!(!ran.err.contains("the mass matrix is singular:"), "{}", ran.err);
    assert_eq!(folder.read("hand.csv"), folder.read("bare.csv"));
    folder.write("hand.csv", b"");
    let ran = folder.run(&[&run[..], &["--lock", "slide=0.1,nail"]].concat(), b"");
    assert_eq!(ran.code, Some(0), "{}", ran.err);
    assert_eq!(folder.read("hand.csv"), folder.read("bare.csv"));
    let ran = folder.run(&["inspect", "bare.urdf", "--lock-massless"], b"");
    assert_eq!(ran.err, "note: --lock-massless: every joint moves some inertia; none is locked\n");
}

/// A lock's position counts, and without one it is as near to zero as the limits allow.
#[test]
fn locks_have_positions() {
    let folder = folder("lock_positions");
    let at = |q: f64, lock: &str| {
        let whole = json!({"q": [0.3, q], "v": [0, 0]}).to_string();
        let gravity = |arguments: &[&str], state: &str| {
            objects(&folder.output(arguments, state))[0]["gravity"][0].as_f64().unwrap()
        };
        let expected = gravity(&["compute", "two_r.urdf"], &whole);
        let found = gravity(&["compute", "two_r.urdf", "--lock", lock], "{\"q\":[0.3],\"v\":[0]}");
        assert!((found - expected).abs() < 1e-12, "{lock}: {found} and {expected}");
    };
    let inspection = &objects(&folder.output(&["inspect", "two_r.urdf", "--json"], ""))[0];
    let second =
        inspection["joints"].as_array().unwrap().iter().filter(|joint| joint["nv"] == 1).nth(1).unwrap();
    let name = second["name"].as_str().unwrap();
    at(0.0, name);
    at(-0.7, &format!("{name}=-0.7"));
    let inspection =
        &objects(&folder.output(&["inspect", "panda.urdf", "--json", "--lock", "panda_joint4"], ""))[0];
    assert_eq!(inspection["nv"], 6);
}

#[test]
fn locks_that_cannot_be() {
    let folder = folder("lock_errors");
    for (robot, lock, message) in [
        ("bare.urdf", "leg", "--lock: the robot has no joint `leg`; its moving joints are arm"),
        ("bare.urdf", "arm,arm", "--lock: joint `arm` is given twice"),
        (
            "bare.urdf",
            "arm=1,2",
            "--lock: joint `arm` (revolute) is locked at 1 finite numbers, got [1.0, 2.0]",
        ),
        ("bare.urdf", "floating_base", "--lock: the base is fixed without --floating-base; leave that out"),
    ] {
        let ran = folder.run(&["inspect", robot, "--lock", lock], b"");
        assert_eq!((ran.code, ran.err), (Some(1), format!("error: {message}\n")), "{lock}");
    }
    let gripper = &objects(&folder.output(&["inspect", "gripper.urdf", "--json"], ""))[0];
    let joints = gripper["joints"].as_array().unwrap();
    let follower = joints.iter().find(|joint| !joint["mimic"].is_null()).unwrap();
    let (name, leader) = (follower["name"].as_str().unwrap(), follower["mimic"]["joint"].as_str().unwrap());
    let ran = folder.run(&["inspect", "gripper.urdf", "--lock", name], b"");
    assert_eq!(
        ran.err,
        format!("error: --lock: joint `{name}` follows joint `{leader}`; lock `{leader}` instead\n")
    );
    let fixed = joints.iter().find(|joint| joint["kind"] == "fixed");
    if let Some(fixed) = fixed {
        let name = fixed["name"].as_str().unwrap();
        let ran = folder.run(&["inspect", "gripper.urdf", "--lock", name], b"");
        assert_eq!(ran.err, format!("error: --lock: joint `{name}` is fixed already\n"));
    }
}
