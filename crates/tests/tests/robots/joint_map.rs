//! The robot with joints locked against the full robot at rest in those joints.

use std::panic::{AssertUnwindSafe, catch_unwind};

use robot_dynamics::algorithms::{forward_dynamics, frame_pose, inverse_dynamics, mass_matrix};
use robot_dynamics::description::{
    Base, JointKind, ModelError, RandomRobotOptions, RobotDescription, random_robot,
};
use robot_dynamics::model::{JointMap, Model, Workspace, lock_massless, neutral};
use robot_dynamics::{Classified, ErrorKind, InputProblem};

use crate::common::{Robot, dot, families, max_difference, size};

/// Every k-th moving joint locked at the position in the robot's state; for odd seeds the base is fixed at
/// the origin.
fn locked(robot: &Robot, every: usize) -> (Model, Vec<f64>) {
    let mut description = robot.model.description().clone();
    let mut reference = robot.state.q.clone();
    let fixes_base = description.base == Base::Floating && robot.seed % 2 == 1;
    for (k, joint) in robot.model.joints().iter().filter(|joint| joint.nq > 0).enumerate() {
        let own = joint.q();
        if k == 0 && description.base == Base::Floating {
            if fixes_base {
                reference[own].copy_from_slice(&neutral(&robot.model)[..7]);
            }
        } else if k % every == 0 {
            description.lock_joint(&joint.name, &reference[own]).expect("its own position");
        }
    }
    if fixes_base {
        description.base = Base::Fixed;
    }
    (Model::new(description).expect("a robot"), reference)
}

/// τ, M and a of the reduced robot equal those of the full robot with v = a = 0 in the locked joints. Both
/// sum the same forces, but over bodies that are merged in one of them. Tolerance: some hundred roundings of
/// the largest term, times κ(M) for a.
#[test]
fn reduced_robot_matches_full_robot_at_rest() {
    let (mut locked_kinds, mut compared) = (std::collections::BTreeSet::new(), 0);
    for family in families() {
        for robot in family.robots().take(25) {
            let full = &robot.model;
            let (reduced, reference) = locked(&robot, 2 + (robot.seed % 3) as usize);
            if reduced.nv() == 0 {
                continue;
            }
            let map = JointMap::new(full, &reduced, &reference).unwrap_or_else(|error| panic!("{error}"));
            map.check(full, &reduced);
            assert_eq!((map.q_indices().len(), map.v_indices().len()), (reduced.nq(), reduced.nv()));
            for name in map.locked_joints() {
                locked_kinds.insert(full.joint(name).expect("a joint").kind.name());
            }

            let (mut q, mut v, mut a) =
                (vec![0.0; reduced.nq()], vec![0.0; reduced.nv()], vec![0.0; reduced.nv()]);
            map.restrict_configuration(&robot.state.q, &mut q);
            map.restrict_velocity(&robot.state.v, &mut v);
            map.restrict_velocity(&robot.state.a, &mut a);
            let (mut full_q, mut full_v, mut full_a) =
                (vec![7.0; full.nq()], vec![7.0; full.nv()], vec![7.0; full.nv()]);
            map.expand_configuration(&q, &mut full_q);
            map.expand_velocity(&v, &mut full_v);
            map.expand_velocity(&a, &mut full_a);
            let (whole, own) = (&mut Workspace::new(full), &mut Workspace::new(&reduced));

            let (mut full_tau, mut expected, mut tau) = (full_a.clone(), a.clone(), a.clone());
            inverse_dynamics(full, whole, &full_q, &full_v, &full_a, &mut full_tau);
            map.restrict_velocity(&full_tau, &mut expected);
            inverse_dynamics(&reduced, own, &q, &v, &a, &mut tau);
            robot.require("τ′ = Eᵀτ", max_difference(&tau, &expected), 1e-12 * size(&full_tau).max(1e-3));

            let (n, m) = (full.nv(), reduced.nv());
            let (mut full_mass, mut mass) = (vec![0.0; n * n], vec![0.0; m * m]);
            mass_matrix(full, whole, &full_q, &mut full_mass);
            mass_matrix(&reduced, own, &q, &mut mass);
            let entries = |i: usize| map.v_indices().iter().map(move |&j| (i, j));
            let block: Vec<f64> =
                map.v_indices().iter().flat_map(|&i| entries(i)).map(|(i, j)| full_mass[i * n + j]).collect();
            robot.require("M′ = EᵀM E", max_difference(&mass, &block), 1e-12 * size(&full_mass));

            // a of the full robot under its own τ, which keeps the locked joints at rest, and a of the
            // reduced robot.
            let (mut found, mut full_found) = (vec![0.0; m], vec![0.0; n]);
            forward_dynamics(&reduced, own, &q, &v, &expected, &mut found);
            forward_dynamics(full, whole, &full_q, &full_v, &full_tau, &mut full_found);
            let mut restricted = vec![0.0; m];
            map.restrict_velocity(&full_found, &mut restricted);
            let rounding =
                1e3 * f64::EPSILON * robot.condition() * size(&full_a).max(size(&full_tau)).max(1.0);
            robot.require("a′ = a", max_difference(&found, &restricted), rounding);
            robot.require("a′ is what went in", max_difference(&found, &a), rounding);

            // The power of the remaining joints: v′ᵀτ′ = vᵀτ, as the locked joints do no work.
            let power = dot(&full_v, &full_tau);
            let scale = size(&full_v) * size(&full_tau) * n as f64;
            robot.require("v′ᵀτ′ = vᵀτ", (dot(&v, &tau) - power).abs(), 1e-12 * scale.max(1e-3));

            // Each link has the same pose in both.
            for frame in reduced.frames() {
                let at = |model: &Model, workspace: &mut Workspace, q: &[f64]| {
                    frame_pose(model, workspace, q, model.frame(&frame.name).expect("in both"))
                };
                let (one, other) = (at(full, whole, &full_q), at(&reduced, own, &q));
                let off = max_difference(one.rotation.as_flattened(), other.rotation.as_flattened())
                    .max(max_difference(&one.translation, &other.translation));
                robot.require("the same place", off, 1e-12 * size(&one.translation).max(1.0));
            }
            compared += 1;
        }
    }
    assert!(compared > 150 && locked_kinds.len() == 8, "{compared} robots, {locked_kinds:?}");
}

#[test]
fn robot_is_its_own_reduction() {
    let model = Model::new(random_robot(3, &RandomRobotOptions::default())).unwrap();
    let map = JointMap::new(&model, &model, &neutral(&model)).unwrap();
    assert!(map.q_indices().iter().copied().eq(0..model.nq()));
    assert!(map.v_indices().iter().copied().eq(0..model.nv()) && map.locked_joints().is_empty());
}

/// A tree of hinges, and the name of its third joint.
fn hinges() -> (RobotDescription, String) {
    let options = RandomRobotOptions {
        kinds: robot_dynamics::description::JointKinds::Turning,
        fixed: 0.0,
        passive: 0.0,
        ..Default::default()
    };
    let description = random_robot(5, &options);
    let name = description.joints[2].name.clone();
    (description, name)
}

#[test]
fn invalid_reductions_name_the_joint() {
    let (description, name) = hinges();
    let full = Model::new(description.clone()).unwrap();
    let at = full.joint(&name).unwrap().q_index;
    let map = |change: &dyn Fn(&mut RobotDescription), reference: &[f64]| {
        let mut changed = description.clone();
        changed.name = "reduced".into();
        change(&mut changed);
        JointMap::new(&full, &Model::new(changed).unwrap(), reference)
    };
    let index = |robot: &RobotDescription| robot.joints.iter().position(|joint| joint.name == name).unwrap();
    let rest = vec![0.0; full.nq()];

    let renamed = map(
        &|robot| {
            let k = index(robot);
            robot.joints[k].name = format!("{name}_b");
        },
        &rest,
    )
    .unwrap_err();
    assert_eq!(renamed.kind(), ErrorKind::UnknownName);
    let text = renamed.to_string();
    assert!(text.ends_with(&format!("has no joint `{name}_b`; did you mean `{name}`?")), "{text}");

    let freed = map(
        &|robot| {
            let k = index(robot);
            robot.joints[k].kind = JointKind::Spherical;
        },
        &rest,
    )
    .unwrap_err();
    let ModelError::NotReduced { joint, reason } = &freed else { panic!("{freed}") };
    assert!(*joint == name && reason.starts_with("is spherical in the reduced robot"), "{freed}");

    let coupled = |robot: &mut RobotDescription| {
        let (k, leader) = (index(robot), robot.joints[0].name.clone());
        robot.joints[k].mimic = Some(robot_dynamics::description::Mimic::new(leader, 1.0, 0.0));
    };
    let error = map(&coupled, &rest).unwrap_err();
    let ModelError::NotReduced { joint, reason } = &error else { panic!("{error}") };
    assert!(*joint == name && reason.contains("it must move the same way in both"), "{error}");
    // A mimic joint that is fixed while its leader moves.
    let mut followed = description.clone();
    coupled(&mut followed);
    let mut still = followed.clone();
    let k = index(&still);
    (still.joints[k].mimic, still.joints[k].kind) = (None, JointKind::Fixed);
    let followed = Model::new(followed).unwrap();
    let error = JointMap::new(&followed, &Model::new(still).unwrap(), &neutral(&followed)).unwrap_err();
    let ModelError::NotReduced { joint, reason } = &error else { panic!("{error}") };
    assert!(*joint == name && reason.starts_with("is fixed in the reduced robot"), "{error}");

    // Locked at 0.3, with 0.4 in the reference: the pose is off by a fraction of 0.1 rad.
    let mut reference = rest.clone();
    reference[at] = 0.4;
    let lock = |robot: &mut RobotDescription| robot.lock_joint(&name, &[0.3]).unwrap();
    match map(&lock, &reference).unwrap_err() {
        ModelError::NotReduced { joint, reason } => {
            let distance = reason.split(' ').nth(2).unwrap().parse::<f64>().unwrap();
            assert!(joint == name && (0.01..=0.1).contains(&distance), "{joint} {distance}");
        }
        other => panic!("{other}"),
    }
    reference[at] = 0.3;
    assert_eq!(map(&lock, &reference).unwrap().locked_joints(), std::slice::from_ref(&name));
    // A full turn further is the same pose.
    reference[at] += std::f64::consts::TAU;
    assert!(map(&lock, &reference).is_ok());

    reference[at] = f64::NAN;
    let error = map(&lock, &reference).unwrap_err();
    let ModelError::Input(error) = error else { panic!("{error}") };
    let InputProblem::NotFinite { index, .. } = error.problem else { panic!("{error}") };
    assert_eq!(index, Some(at));
}

/// A base can be fixed only at the origin, where the fixed robot is placed.
#[test]
fn base_is_fixed_at_the_origin_only() {
    let options = RandomRobotOptions { base: Base::Floating, joints: 3, ..Default::default() };
    let mut description = random_robot(1, &options);
    let full = Model::new(description.clone()).unwrap();
    description.base = Base::Fixed;
    let reduced = Model::new(description).unwrap();
    let mut reference = neutral(&full);
    let map = JointMap::new(&full, &reduced, &reference).unwrap();
    assert_eq!((map.q_indices()[0], map.v_indices()[0], map.locked_joints().len()), (7, 6, 1));
    reference[2] = 0.5;
    let error = JointMap::new(&full, &reduced, &reference).unwrap_err();
    let ModelError::NotReduced { joint, reason } = &error else { panic!("{error}") };
    assert!(joint == "floating_base" && reason.starts_with("is locked 5e-1 off"), "{error}");
    // The reverse: the full robot lacks the base joint.
    let error = JointMap::new(&reduced, &full, &neutral(&reduced)).unwrap_err();
    assert_eq!(error.kind(), ErrorKind::UnknownName, "{error}");
}

/// Joints that move no inertia are locked at their resting position; the rest of the robot can be simulated.
#[test]
fn locked_massless_joints_are_filled_in() {
    let (mut description, _) = hinges();
    let tip = description.links.last_mut().expect("links");
    tip.mass_properties = None;
    let full = Model::new(description.clone()).unwrap();
    let names = lock_massless(&mut description).unwrap();
    assert!(!names.is_empty() && names.len() < full.nv(), "{names:?}");
    let mut reference = neutral(&full);
    for name in &names {
        let joint = full.joint(name).unwrap();
        let rest = full.description().resting_position(name).unwrap();
        reference[joint.q()].copy_from_slice(&rest);
    }
    let reduced = Model::new(description).unwrap();
    let map = JointMap::new(&full, &reduced, &reference).unwrap();
    assert_eq!(map.locked_joints(), names);
    // τ of the full robot, whose accelerations do not exist.
    let (q, mut full_q) = (vec![0.3; reduced.nq()], vec![0.0; full.nq()]);
    map.expand_configuration(&q, &mut full_q);
    let mut tau = vec![0.0; reduced.nv()];
    map.restrict_velocity(full.gravity_forces(&full_q).unwrap().as_slice(), &mut tau);
    let expected = reduced.gravity_forces(&q).unwrap();
    // Tolerance: some hundred roundings.
    assert!(max_difference(&tau, expected.as_slice()) <= 1e-12 * size(&tau), "{tau:?} {expected}");
}

#[test]
fn models_of_other_robots_panic() {
    let (mut description, name) = hinges();
    let full = Model::new(description.clone()).unwrap();
    description.lock_joint(&name, &[0.0]).unwrap();
    let reduced = Model::new(description).unwrap();
    let map = JointMap::new(&full, &reduced, &neutral(&full)).unwrap();
    map.check(&full, &reduced);
    assert!(catch_unwind(AssertUnwindSafe(|| map.check(&full, &full))).is_err());
}

#[test]
fn slices_of_wrong_length_panic() {
    let (mut description, name) = hinges();
    let full = Model::new(description.clone()).unwrap();
    description.lock_joint(&name, &[0.0]).unwrap();
    let map = JointMap::new(&full, &Model::new(description).unwrap(), &neutral(&full)).unwrap();
    let mut q = vec![0.0; full.nq()];
    assert!(catch_unwind(AssertUnwindSafe(|| map.expand_configuration(&[0.0; 2], &mut q))).is_err());
}
