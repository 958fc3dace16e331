//! Audits of the repository's robots, and of files that must fail.

use serde_json::Value;

use crate::command::{Folder, robots};

/// The checks for every robot with joints.
const CHECKS: [&str; 12] = [
    "load",
    "inertia_triangle",
    "mass_matrix",
    "mass_columns",
    "lagrange_mass",
    "lagrange_velocity_product",
    "lagrange_gravity",
    "gravity",
    "skew",
    "forward_inverse",
    "forward_routes",
    "power",
];

fn check<'a>(audit: &'a Value, name: &str) -> &'a Value {
    let mut checks = audit["checks"].as_array().unwrap().iter();
    checks.find(|check| check["check"] == name).unwrap_or_else(|| panic!("no check {name} in {audit}"))
}

#[test]
fn every_robot_passes() {
    let folder = Folder::new("audit_all");
    for robot in robots() {
        let file = robot.file_name().unwrap().to_str().unwrap();
        assert!(!folder.output(&["audit", file], "").is_empty());
        let audit: Value = serde_json::from_str(&folder.output(&["audit", file, "--json"], "")).unwrap();
        assert_eq!(audit["passed"], true);
        assert_eq!(audit["suspicions"], serde_json::json!([]), "{file}");
        for name in CHECKS {
            assert_eq!(check(&audit, name)["verdict"], "ok", "{file}: {name}");
        }
        for integrator in robot_dynamics::simulation::Integrator::ALL {
            let name = format!("drift_{}", integrator.name().replace('-', "_"));
            assert_eq!(check(&audit, &name)["verdict"], "ok");
        }
        // Two independent routes differ by rounding somewhere.
        let moves = |name| check(&audit, name)["found"].as_f64().unwrap() > 0.0;
        assert!(moves("forward_inverse") && moves("power"), "{file}: {audit}");
    }
}

#[test]
fn floating_robots_pass() {
    let folder = Folder::new("audit_floating");
    for file in ["quadruped.urdf", "humanoid.urdf"] {
        folder.output(&["audit", file, "--floating-base", "--seed", "5"], "");
    }
}

/// An inertia in kg·mm² read as kg·m² is suspicious, and a failure only with --strict.
#[test]
fn an_inertia_in_the_wrong_unit_is_suspected() {
    let folder = Folder::new("audit_unit");
    let panda = folder.read("panda.urdf");
    let wrong = panda.replace(
        "<inertia ixx=\"0.70337\" ixy=\"-0.000139\" ixz=\"0.006772\" iyy=\"0.70661\" iyz=\"0.019169\" izz=\"0.009117\"/>",
        "<inertia ixx=\"703370\" ixy=\"-139\" ixz=\"6772\" iyy=\"706610\" iyz=\"19169\" izz=\"9117\"/>",
    );
    assert!(wrong != panda);
    folder.write("wrong.urdf", wrong.as_bytes());
    let text = folder.output(&["audit", "wrong.urdf"], "");
    assert_eq!(text.matches("link \"panda_link1\"").count(), 1, "{text}");

    let ran = folder.run(&["audit", "wrong.urdf", "--json", "--strict"], b"");
    assert_eq!((ran.code, ran.err.as_str()), (Some(1), ""));
    let audit: Value = serde_json::from_str(&ran.out).unwrap();
    assert_eq!(audit["passed"], false);
    let [suspicion] = &audit["suspicions"].as_array().unwrap()[..] else { panic!("{audit}") };
    assert_eq!(suspicion["verdict"], "suspect");
    assert_eq!(suspicion["quantity"], "ellipsoid_density");
    assert_eq!(suspicion["places"], serde_json::json!(["link \"panda_link1\""]));
    assert_eq!(suspicion["cause"]["culprit"], "moments");
    assert!((1e5..1e7).contains(&suspicion["cause"]["factor"].as_f64().unwrap()), "{suspicion}");
    assert!(suspicion["found"].as_f64().unwrap() < suspicion["expected"][0].as_f64().unwrap());
    // The equations also hold for an impossible body.
    let checks = audit["checks"].as_array().unwrap();
    assert!(checks.iter().all(|check| check["verdict"] == "ok"), "{audit}");
}

/// Angles and limits in degrees give two suspicions, each with its joints.
#[test]
fn degrees_are_suspected() {
    let folder = Folder::new("audit_degrees");
    let ur5 = folder.read("ur5.urdf");
    let turned = ur5.replace("rpy=\"1.5707963267948966 0 0\"", "rpy=\"90 0 0\"");
    let wrong = turned.replace("6.283185307179586\"", "360\"");
    assert!(turned != ur5 && wrong != turned);
    folder.write("degrees.urdf", wrong.as_bytes());
    let audit: Value =
        serde_json::from_str(&folder.output(&["audit", "degrees.urdf", "--json", "--states", "2"], ""))
            .unwrap();
    let quantities: Vec<&Value> =
        audit["suspicions"].as_array().unwrap().iter().map(|suspicion| &suspicion["quantity"]).collect();
    assert_eq!(quantities, ["written_angle", "angle_limit"], "{audit}");
    assert_eq!(audit["suspicions"][1]["places"].as_array().unwrap().len(), 6);
    assert_eq!(audit["suspicions"][1]["found"], 360.0);
}

/// Physics that the reader ignores is a failed check.
#[test]
fn ignored_physics_falls_short() {
    let folder = Folder::new("audit_ignored");
    let sprung = folder.read("two_r.urdf").replace("<axis", "<dynamics springStiffness=\"3\"/><axis");
    folder.write("sprung.urdf", sprung.as_bytes());
    let ran = folder.run(&["audit", "sprung.urdf", "--json"], b"");
    assert_eq!(ran.code, Some(1), "{}", ran.err);
    let audit: Value = serde_json::from_str(&ran.out).unwrap();
    let short = audit["checks"].as_array().unwrap().iter().filter(|check| check["verdict"] == "short");
    assert_eq!(short.map(|check| &check["check"]).collect::<Vec<_>>(), ["load"], "{audit}");
}

/// Two joints on one axis without inertia between them: M is singular, and one check fails.
#[test]
fn a_singular_mass_matrix_falls_short() {
    let folder = Folder::new("audit_singular");
    let ran = folder.run(&["audit", "two_r.urdf", "--floating-base", "--json"], b"");
    assert_eq!(ran.code, Some(1));
    let audit: Value = serde_json::from_str(&ran.out).unwrap();
    let condition = check(&audit, "mass_matrix");
    assert_eq!((condition["verdict"].as_str(), condition["found"].is_null()), (Some("short"), true));
    let place = condition["where"].as_str().unwrap();
    assert!(place.contains("`floating_base`"), "{place}");
    let fall_short = audit["checks"].as_array().unwrap().iter().filter(|check| check["verdict"] == "short");
    assert_eq!(fall_short.count(), 1, "{audit}");
}

/// The same seed gives the same numbers, another seed others.
#[test]
fn audits_repeat() {
    let folder = Folder::new("audit_seed");
    let audit =
        |seed: &str| folder.output(&["audit", "panda.urdf", "--json", "--states", "5", "--seed", seed], "");
    assert_eq!(audit("3"), audit("3"));
    assert_ne!(audit("3"), audit("4").replace("\"seed\":4", "\"seed\":3"));
}

/// A robot without joints has only its links to check.
#[test]
fn a_robot_that_does_not_move() {
    let folder = Folder::new("audit_still");
    folder.write("still.urdf", b"<robot name=\"still\"><link name=\"stone\"/></robot>");
    let audit: Value = serde_json::from_str(&folder.output(&["audit", "still.urdf", "--json"], "")).unwrap();
    assert_eq!(audit["checks"].as_array().unwrap().len(), 1);
    assert_eq!(folder.output(&["compute", "still.urdf"], "{\"q\":[],\"v\":[],\"a\":[]}").lines().count(), 1);
    folder.output(&["inspect", "still.urdf"], "");
}
