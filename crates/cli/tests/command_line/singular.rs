//! Robots with a singular mass matrix: results that need no inverse, and clear errors for the others.

use std::fmt::Write;

use serde_json::{Value, json};

use crate::command::Folder;
use crate::messages::Transcript;

const LINK: &str = r#"<inertial><origin xyz="0.1 0.02 0.2"/><mass value="1"/>
    <inertia ixx="0.01" ixy="0" ixz="0" iyy="0.01" iyz="0" izz="0.01"/></inertial>"#;

/// A chain of joints (name, axis, link's inertia), a metre apart along z after links with inertia.
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

/// Two joints about one axis, without inertia between them.
pub(crate) fn coaxial() -> String {
    chain(&[("one", "0 0 1", ""), ("two", "0 0 -1", LINK)])
}

fn folder(name: &str) -> Folder {
    let folder = Folder::new(name);
    let files = [
        ("coaxial.urdf", coaxial()),
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

#[test]
fn compute_gives_all_but_the_accelerations() {
    let folder = folder("singular_compute");
    let states = "{\"q\":[0.1,0.2],\"v\":[1,2],\"a\":[3,4],\"tau\":[5,6]}\n{\"q\":[0.1,0.2],\"v\":[1,2]}\n";
    let ran = folder.run(&["compute", "coaxial.urdf"], states.as_bytes());
    assert_eq!(ran.code, Some(1));
    let mut transcript = Transcript::default();
    transcript.add_text(&ran.err);
    transcript.compare("singular_compute");
    let [first, second] = &objects(&ran.out)[..] else { panic!("{}", ran.out) };
    assert_eq!(first["mass_matrix"], second["mass_matrix"]);
    assert_eq!(first["inverse_dynamics"].as_array().unwrap().len(), 2);
    assert!(first.get("forward_dynamics").is_none() && second.get("forward_dynamics_error").is_none());
    let error = &first["forward_dynamics_error"];
    assert_eq!([&error["joints"], &error["line"]], [&json!(["one", "two"]), &json!(1)]);
    assert!(error["message"].as_str().unwrap().contains("`one`, `two`"));
    // A line without `tau` asks for no accelerations.
    let ran = folder.run(&["compute", "coaxial.urdf"], b"{\"q\":[0.1,0.2],\"v\":[1,2],\"a\":[3,4]}");
    assert_eq!((ran.code, ran.err.lines().count()), (Some(0), 1), "{}", ran.err);
}

/// A gimbal is singular only at zero, and other lines have accelerations.
#[test]
fn singular_in_one_pose() {
    let folder = folder("singular_gimbal");
    let state = |pitch: f64| json!({"q": [0.1, pitch, 0.3], "v": [0, 0, 0], "tau": [1, 2, 3]}).to_string();
    let ran = folder.run(&["compute", "gimbal.urdf"], [state(0.0), state(0.5)].join("\n").as_bytes());
    assert_eq!(ran.code, Some(1));
    assert!(ran.err.starts_with("warning: ") && ran.err.contains("`yaw`, `roll`"), "{}", ran.err);
    let [first, second] = &objects(&ran.out)[..] else { panic!("{}", ran.out) };
    assert_eq!(first["forward_dynamics_error"]["joints"], json!(["yaw", "roll"]));
    assert_eq!(second["forward_dynamics"].as_array().unwrap().len(), 3);
    let audit = folder.run(&["audit", "gimbal.urdf", "--json"], b"");
    let audit = &objects(&audit.out)[0];
    let check =
        audit["checks"].as_array().unwrap().iter().find(|check| check["check"] == "mass_matrix").unwrap();
    assert_eq!(check["verdict"], "short");
    assert!(check["where"].as_str().unwrap().contains("`yaw`, `roll`"), "{check}");
    // The sampled states are regular, so their accelerations are checked.
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
        assert!(last.contains(" t = 0 s") && last.contains("`one`, `two`"), "{integrator}: {last}");
        assert!(last.contains("--lock JOINT"), "{last}");
    }
}

#[test]
fn inspection_has_a_section() {
    let folder = folder("singular_inspect");
    assert!(folder.output(&["inspect", "coaxial.urdf"], "").contains("Mass matrix"));
    assert!(!folder.output(&["inspect", "bare.urdf"], "").contains("Mass matrix"));
    let object = &objects(&folder.output(&["inspect", "hand.urdf", "--json"], ""))[0]["singular_mass"];
    assert_eq!(object["massless_joints"], json!(["slide", "nail"]));
    assert_eq!(object["motions_at_zeros"], json!([["nail"], ["slide"]]));
    assert_eq!([&object["random_poses"], &object["random_poses_singular"]], [&json!(5), &json!(5)]);
    let object = &objects(&folder.output(&["inspect", "bare.urdf", "--json"], ""))[0]["singular_mass"];
    assert_eq!([&object["massless_joints"], &object["random_poses_singular"]], [&json!([]), &json!(0)]);
}

/// Robots with massless joints load. With these joints locked, they simulate like the robot without them.
#[test]
fn locked_joints_simulate() {
    let folder = folder("locked");
    let ran = folder.run(&["simulate", "hand.urdf", "--duration", "0.1"], b"");
    assert_eq!(ran.code, Some(1));
    assert!(ran.err.contains("`slide`, `nail`") && ran.err.contains("--lock-massless"), "{}", ran.err);
    let bare = folder.output(&["simulate", "bare.urdf", "--duration", "0.1", "--csv", "bare.csv"], "");
    assert!(bare.contains(": 1 degree of freedom"), "{bare}");
    let told = "note: --lock-massless: joints `slide`, `nail`";
    let run = ["simulate", "hand.urdf", "--duration", "0.1", "--csv", "hand.csv"];
    let ran = folder.run(&[&run[..], &["--lock-massless"]].concat(), b"");
    // Warnings about the file remain.
    assert!(ran.code == Some(0) && ran.err.starts_with(told), "{}", ran.err);
    assert!(!ran.err.contains("--lock JOINT"), "M is regular: {}", ran.err);
    assert_eq!(folder.read("hand.csv"), folder.read("bare.csv"));
    folder.write("hand.csv", b"");
    let ran = folder.run(&[&run[..], &["--lock", "slide=0.1,nail"]].concat(), b"");
    assert_eq!(ran.code, Some(0), "{}", ran.err);
    assert_eq!(folder.read("hand.csv"), folder.read("bare.csv"));
    let ran = folder.run(&["inspect", "bare.urdf", "--lock-massless"], b"");
    assert_eq!((ran.code, ran.err.lines().count()), (Some(0), 1), "{}", ran.err);
}

/// A lock's position counts; without one it is as close to zero as the limits allow.
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
fn wrong_locks_are_refused() {
    let folder = folder("lock_errors");
    let gripper = &objects(&folder.output(&["inspect", "gripper.urdf", "--json"], ""))[0];
    let joints = gripper["joints"].as_array().unwrap();
    let mimic = joints.iter().find(|joint| !joint["mimic"].is_null()).unwrap();
    let (name, leader) = (mimic["name"].as_str().unwrap(), mimic["mimic"]["joint"].as_str().unwrap());
    for (robot, lock, named) in [
        ("bare.urdf", "leg", "`leg`"),
        ("bare.urdf", "arm,arm", "`arm`"),
        ("bare.urdf", "arm=1,2", "`arm`"),
        ("bare.urdf", "floating_base", "--floating-base"),
        ("gripper.urdf", name, leader),
        ("panda.urdf", "panda_joint8", "`panda_joint8`"),
    ] {
        let ran = folder.run(&["inspect", robot, "--lock", lock], b"");
        assert_eq!((ran.code, ran.err.lines().count()), (Some(1), 1), "{lock}: {}", ran.err);
        assert!(ran.err.starts_with("error: --lock: ") && ran.err.contains(named), "{lock}: {}", ran.err);
    }
}
