//! The robots of this repository load, and no physics in them is ignored.

use std::path::PathBuf;

use robot_dynamics::description::{Base, JointKind, Pose};
use robot_dynamics::model::{Model, random_state};
use robot_dynamics::number::SplitMix64;
use robot_dynamics::urdf::{LoadOptions, Robot, load};

fn folder() -> PathBuf {
    PathBuf::from(env!("CARGO_MANIFEST_DIR")).join("../../robots")
}

fn robot(name: &str) -> Robot {
    load(folder().join(format!("{name}.urdf")), &LoadOptions::default().with_strict())
        .unwrap_or_else(|error| panic!("{name}: {error}"))
}

/// Name, links, joints, degrees of freedom, and mass in kg (the sum in the header of each file).
const ROBOTS: [(&str, usize, usize, usize, f64); 10] = [
    ("dual_arm", 17, 16, 16, 59.0),
    ("gantry", 7, 6, 6, 71.5),
    ("gripper", 7, 6, 4, 3.74),
    ("hand", 21, 20, 15, 0.735),
    ("humanoid", 36, 35, 34, 77.1),
    ("panda", 9, 8, 7, 16.062132),
    ("quadruped", 17, 16, 12, 19.9),
    ("three_r", 5, 4, 3, 3.0),
    ("two_r", 4, 3, 2, 3.0),
    ("ur5", 8, 7, 6, 17.0489),
];

#[test]
fn every_robot_loads_strictly_with_the_stated_size_and_mass() {
    let mut found: Vec<String> = std::fs::read_dir(folder())
        .expect("the folder of robots")
        .map(|entry| entry.expect("an entry").path())
        .filter(|path| path.extension().is_some_and(|extension| extension == "urdf"))
        .map(|path| path.file_stem().expect("a name").to_string_lossy().into_owned())
        .collect();
    found.sort();
    assert_eq!(found, ROBOTS.map(|(name, ..)| name.to_owned()), "a robot is missing here or there");
    for (name, links, joints, freedom, mass) in ROBOTS {
        let Robot { description, report, .. } = robot(name);
        assert_eq!(description.name, name);
        let counts = report.counts;
        assert_eq!(
            (counts.links, counts.joints, counts.degrees_of_freedom),
            (links, joints, freedom),
            "{name}"
        );
        // Shapes and the two materials in some files are not part of the dynamics. Everything else is read.
        let materials = if ["humanoid", "quadruped"].contains(&name) { 2 } else { 0 };
        let looks = description.shapes.len() + materials;
        assert_eq!((counts.ignored, counts.not_dynamics), (0, looks), "{name}:\n{report}");
        let sum: f64 =
            description.links.iter().filter_map(|link| link.mass_properties).map(|body| body.mass()).sum();
        // The masses are printed with nine digits.
        assert!((sum - mass).abs() < 1e-8 * mass, "{name} weighs {sum} kg, not {mass}");
    }
}

#[test]
fn legged_robots_load_with_a_floating_base() {
    for (name, freedom) in [("quadruped", 18), ("humanoid", 40)] {
        let options = LoadOptions::default().with_strict().with_floating_base();
        let loaded = load(folder().join(format!("{name}.urdf")), &options).expect("a robot");
        assert_eq!(loaded.description.base, Base::Floating);
        assert_eq!(loaded.report.counts.degrees_of_freedom, freedom);
    }
}

/// The pose of a link at `q`, which is in the order of the moving joints in the file.
fn placed(robot: &Robot, link: &str, q: &[f64]) -> Pose {
    let moving: Vec<&str> = robot
        .description
        .joints
        .iter()
        .filter(|joint| joint.kind != JointKind::Fixed)
        .map(|joint| joint.name.as_str())
        .collect();
    let Some(joint) = robot.description.joints.iter().find(|joint| joint.child == link) else {
        return Pose::IDENTITY;
    };
    let angle = moving.iter().position(|name| *name == joint.name).map_or(0.0, |at| q[at]);
    let turn = match joint.kind {
        JointKind::Revolute { axis } | JointKind::Continuous { axis } => {
            let (s, c) = (0.5 * angle).sin_cos();
            Pose::from_translation_quaternion_wxyz([0.0; 3], [c, s * axis[0], s * axis[1], s * axis[2]])
        }
        _ => Pose::IDENTITY,
    };
    placed(robot, &joint.parent, q).compose(&joint.parent_from_joint).compose(&turn)
}

fn assert_at(found: [f64; 3], expected: [f64; 3]) {
    let off = (0..3).map(|i| (found[i] - expected[i]).abs()).fold(0.0, f64::max);
    // Rounding of a few rotations by right angles, for lengths of about a metre.
    assert!(off < 1e-14, "found {found:?}, expected {expected:?}");
}

#[test]
fn planar_arms_turn_from_the_x_axis_up_to_z() {
    let (q1, q2, q3) = (0.7_f64, 0.4_f64, -1.1_f64);
    let tip = placed(&robot("two_r"), "tip", &[q1, q2]).translation;
    assert_at(tip, [q1.cos() + (q1 + q2).cos(), 0.0, q1.sin() + (q1 + q2).sin()]);
    let tip = placed(&robot("three_r"), "tip", &[q1, q2, q3]).translation;
    let along = |f: fn(f64) -> f64| 0.6 * f(q1) + 0.5 * f(q1 + q2) + 0.4 * f(q1 + q2 + q3);
    assert_at(tip, [along(f64::cos), 0.0, along(f64::sin)]);
}

#[test]
fn the_panda_flange_is_where_its_lengths_put_it() {
    // With all joints at zero the flange is above the base by d1 + d3 + d5 − d_flange and in front by a7, and
    // points down.
    let flange = placed(&robot("panda"), "panda_link8", &[0.0; 7]);
    assert_at(flange.translation, [0.088, 0.0, 0.333 + 0.316 + 0.384 - 0.107]);
    assert_at(flange.rotate([0.0, 0.0, 1.0]), [0.0, 0.0, -1.0]);
}

#[test]
fn the_ur5_tool_is_where_its_lengths_put_it() {
    // With all joints at zero the arm is stretched along −x, with the offsets of the wrist along −y and
    // downwards.
    let tool = placed(&robot("ur5"), "tool", &[0.0; 6]);
    assert_at(tool.translation, [-0.425 - 0.39225, -0.10915 - 0.0823, 0.089159 - 0.09465]);
}

/// Pullbacks are products with the Jacobians, for every robot with fixed and floating base. Tolerance: κ(M) ε
/// of the largest entry, or 1e-12.
#[test]
fn pullbacks_of_every_robot_are_rows_of_its_jacobians() {
    for (name, ..) in ROBOTS {
        for options in [LoadOptions::default(), LoadOptions::default().with_floating_base()] {
            let loaded = load(folder().join(format!("{name}.urdf")), &options).expect("a robot");
            let model = Model::new(loaded.description).expect("a model");
            let state = random_state(&model, &mut SplitMix64::new(11));
            let (q, v, a, tau) = (&state.q[..], &state.v[..], &state.a[..], &state.tau[..]);
            let by = model.inverse_dynamics_pullback(q, v, a, tau).expect("a pullback");
            let derivatives = model.inverse_dynamics_derivatives(q, v, a).expect("Jacobians");
            let lambda = nalgebra::DVector::from_column_slice(tau);
            for (found, jacobian) in [
                (&by.by_position, &derivatives.by_position),
                (&by.by_velocity, &derivatives.by_velocity),
                (&by.by_acceleration, &derivatives.by_acceleration),
            ] {
                let (expected, scale) = (jacobian.tr_mul(&lambda), jacobian.amax().max(1.0) * lambda.norm());
                assert!((found - expected).amax() < 1e-12 * scale, "{name}");
            }
            let by = model.forward_dynamics_pullback(q, v, tau, a);
            // A floating base without mass under a lift has no acceleration and no pullback: both give the
            // same error.
            if let Err(singular) = model.check_rank(q) {
                assert_eq!(by, Err(singular), "{name}");
                continue;
            }
            let by = by.expect("a pullback");
            let derivatives = model.forward_dynamics_derivatives(q, v, tau).expect("Jacobians");
            let eigenvalues = model.mass_matrix(q).expect("M").symmetric_eigenvalues();
            let condition = eigenvalues.max() / eigenvalues.min();
            let lambda = nalgebra::DVector::from_column_slice(a);
            let scale = [&derivatives.by_position, &derivatives.by_velocity, &derivatives.by_force]
                .iter()
                .fold(0.0_f64, |most, jacobian| most.max(jacobian.amax()));
            for (found, jacobian) in [
                (&by.by_position, &derivatives.by_position),
                (&by.by_velocity, &derivatives.by_velocity),
                (&by.by_force, &derivatives.by_force),
            ] {
                let allowed = 1e2 * f64::EPSILON * condition * scale * lambda.norm();
                let defect = (found - jacobian.tr_mul(&lambda)).amax();
                assert!(defect < allowed, "{name}: {defect:e} of {allowed:e}");
            }
        }
    }
}
