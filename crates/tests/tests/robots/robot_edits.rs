//! Locked joints, payloads and scaled gravity against the equations of the original robot.

use robot_dynamics::algorithms::ReferenceFrame;
use robot_dynamics::description::{JointKind, MassProperties, RandomRobotOptions, random_robot};
use robot_dynamics::model::{Model, random_state};
use robot_dynamics::number::SplitMix64;
use robot_dynamics::{Classified, ErrorKind};

/// A joint held at q with v = a = 0 leaves the remaining rows of the original robot's equation unchanged. τ
/// of the locked robot equals those rows. Tolerance: 1e-12 of the largest torque, some hundred roundings.
#[test]
fn locked_joint_matches_joint_at_rest() {
    let mut locked_kinds = std::collections::BTreeSet::new();
    for seed in 0..200 {
        let options = RandomRobotOptions { mimic: 0.15, ..RandomRobotOptions::default() };
        let description = random_robot(seed, &options);
        let whole = Model::new(description.clone()).expect("random robots compile");
        let mut random = SplitMix64::new(seed);
        let mut state = random_state(&whole, &mut random);
        let candidates: Vec<_> =
            whole.joints().iter().filter(|joint| joint.nv > 0 && joint.kind != JointKind::Floating).collect();
        if candidates.len() < 2 {
            continue;
        }
        let pick = usize::try_from(seed).expect("a small seed") % candidates.len();
        let joint = candidates[pick];
        let mut locked = description;
        let q = joint.q();
        locked.lock_joint(&joint.name, &state.q[q.clone()]).expect("its own position fits");
        let locked = Model::new(locked).expect("a robot");
        locked_kinds.insert(joint.kind.name());

        let rows = joint.v();
        state.v[rows.clone()].fill(0.0);
        state.a[rows.clone()].fill(0.0);
        let expected = whole.inverse_dynamics(&state.q, &state.v, &state.a).expect("a finite state");
        let without = |values: &[f64], range: &std::ops::Range<usize>| -> Vec<f64> {
            (0..values.len()).filter(|i| !range.contains(i)).map(|i| values[i]).collect()
        };
        let (q, v, a) = (without(&state.q, &q), without(&state.v, &rows), without(&state.a, &rows));
        let found = locked.inverse_dynamics(&q, &v, &a).expect("a finite state");
        let expected = without(expected.as_slice(), &rows);
        let scale = expected.iter().fold(1e-3, |most: f64, x| most.max(x.abs()));
        for (i, (found, expected)) in found.iter().zip(&expected).enumerate() {
            let off = (found - expected).abs();
            assert!(
                off <= 1e-12 * scale,
                "seed {seed}, joint {} ({}), row {i}: {off:e}",
                joint.name,
                joint.kind
            );
        }
    }
    assert!(locked_kinds.len() >= 6, "only {locked_kinds:?} were locked");
}

/// A load of mass m at c adds its weight to g and its inertia to M.
#[test]
fn payload_adds_mass_and_inertia() {
    let description = random_robot(3, &RandomRobotOptions::default());
    let bare = Model::new(description.clone()).expect("compiles");
    let link = description.links.last().expect("has links").name.clone();
    let load = MassProperties::new(1.5, [0.1, -0.2, 0.3].into(), nalgebra::Matrix3::identity() * 0.02)
        .expect("physical");
    let mut loaded = description;
    loaded.attach_payload(&link, &load).expect("the link exists");
    let loaded = Model::new(loaded).expect("compiles");
    assert!((loaded.mass() - bare.mass() - 1.5).abs() < 1e-12);
    let state = random_state(&bare, &mut SplitMix64::new(5));
    let kinetic = |model: &Model| model.kinetic_energy(&state.q, &state.v).expect("a finite state");
    // The kinetic energy of the load, from the velocity of the link's frame.
    let frame = bare.frame(&link).expect("links are frames");
    let mut workspace = robot_dynamics::model::Workspace::new(&bare);
    let twist = robot_dynamics::algorithms::frame_velocity(
        &bare,
        &mut workspace,
        &state.q,
        &state.v,
        frame,
        ReferenceFrame::Local,
    );
    let (u, w) = (nalgebra::Vector3::from(twist.linear), nalgebra::Vector3::from(twist.angular));
    let at_center = u + w.cross(&load.center_of_mass());
    let own = 0.5 * 1.5 * at_center.norm_squared() + 0.5 * w.dot(&(load.inertia_about_center_of_mass() * w));
    let (found, expected) = (kinetic(&loaded), kinetic(&bare) + own);
    assert!((found - expected).abs() < 1e-12 * expected, "{found} {expected}");
}

#[test]
fn scaled_gravity_scales_the_weight() {
    let options = RandomRobotOptions { passive: 0.0, ..RandomRobotOptions::default() };
    let mut description = random_robot(8, &options);
    let model = Model::new(description.clone()).expect("compiles");
    let q = random_state(&model, &mut SplitMix64::new(1)).q;
    let earth = model.gravity_forces(&q).expect("finite");
    description.scale_gravity(0.38).expect("finite");
    let mars = Model::new(description).expect("compiles").gravity_forces(&q).expect("finite");
    assert!((mars - earth * 0.38).amax() < 1e-13 * 100.0);
}

#[test]
fn invalid_edits_are_errors() {
    let mut description = random_robot(2, &RandomRobotOptions::default());
    let joint =
        description.joints.iter().find(|joint| matches!(joint.kind, JointKind::Revolute { .. })).cloned();
    let name = joint.expect("a revolute joint in the first robots").name;
    let error = description.lock_joint("nowhere", &[0.0]).unwrap_err();
    assert!(error.to_string().starts_with("the robot has no joint `nowhere`; it has "), "{error}");
    assert_eq!(error.kind(), ErrorKind::UnknownName);
    let error = description.lock_joint(&name, &[0.0, 1.0]).unwrap_err();
    let expected = format!("the position of joint `{name}` has 2 numbers, its kind (revolute) needs 1");
    assert_eq!(error.to_string(), expected);
    let refused = [description.lock_joint(&name, &[f64::NAN]), description.scale_gravity(f64::INFINITY)];
    for refused in refused {
        assert_eq!(refused.unwrap_err().kind(), ErrorKind::InvalidInput);
    }
}

/// Infinite limits survive JSON, which has no infinity.
#[test]
fn description_round_trips_through_json() {
    for seed in 0..20 {
        let description = random_robot(seed, &RandomRobotOptions::default());
        let text = serde_json::to_string(&description).expect("serialises");
        let back: robot_dynamics::description::RobotDescription =
            serde_json::from_str(&text).expect("deserialises");
        assert!(back == description, "seed {seed}: the description changed on its way through JSON");
        let limits = robot_dynamics::description::Limits::default();
        let back: robot_dynamics::description::Limits =
            serde_json::from_str(&serde_json::to_string(&limits).unwrap()).unwrap();
        assert_eq!((back.lower, back.upper), (f64::NEG_INFINITY, f64::INFINITY));
    }
}
