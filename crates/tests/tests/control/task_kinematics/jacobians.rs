//! Jacobians of all objectives against central differences of their errors.

use robot_dynamics::constraints::{ConstraintSet, Coupling, FrameConstraint, SpatialAxis};
use robot_dynamics::control::task_kinematics::KinematicObjective;
use robot_dynamics::description::{Base, Pose, RandomRobotOptions, random_robot};
use robot_dynamics::model::{Model, integrate};
use robot_dynamics::number::SplitMix64;

use super::{arm, load, moved, random_pose, random_q, with_objective};

/// The step of the differences. Their truncation is below h² times a third derivative of a few hundred, and
/// rounding below 1e-16 times ten, divided by h.
const STEP: f64 = 1e-5;
const TOLERANCE: f64 = 1e-7;

#[track_caller]
fn check(model: &Model, objective: &KinematicObjective, q: &[f64], rows: usize) {
    let mut kinematics = with_objective(model, objective.clone());
    let linear = kinematics.linearized_tasks(q).expect("rows").remove(0);
    assert_eq!(linear.residual.len(), rows, "{objective:?}");
    let nv = model.nv();
    let mut residual = |k: usize, h: f64| {
        let (mut step, mut to) = (vec![0.0; nv], q.to_vec());
        step[k] = h;
        integrate(model, q, &step, &mut to);
        kinematics.linearized_tasks(&to).expect("rows").remove(0).residual
    };
    for k in 0..nv {
        let slope = (residual(k, STEP) - residual(k, -STEP)) / (2.0 * STEP);
        let off = (slope - linear.jacobian.column(k)).amax();
        assert!(off < TOLERANCE, "{objective:?}, coordinate {k}: {off:e}");
    }
}

fn robots() -> Vec<Model> {
    let trees = RandomRobotOptions { joints: 7, ..Default::default() };
    let floating = RandomRobotOptions { base: Base::Floating, ..trees.clone() };
    let mimic = RandomRobotOptions { mimic: 0.4, chain: 0.9, ..trees.clone() };
    let mut robots: Vec<Model> = (0..3).map(arm).collect();
    for options in [trees, floating, mimic] {
        robots.extend((0..3).map(|seed| Model::new(random_robot(seed, &options)).expect("a robot")));
    }
    robots
}

#[test]
fn jacobians_are_derivatives_of_errors() {
    for (seed, model) in (0..).zip(robots()) {
        let mut random = SplitMix64::new(seed);
        let q = random_q(&model, &mut random);
        let frames = model.frames();
        let frame =
            |from_end: usize| model.frame_named(&frames[frames.len() - 1 - from_end].name).expect("a frame");
        let target = random_pose(&mut random);
        check(&model, &KinematicObjective::pose(frame(0), target), &q, 6);
        check(&model, &KinematicObjective::pose(frame(0), target.translation), &q, 3);
        let few = [SpatialAxis::Y, SpatialAxis::Rz, SpatialAxis::Rx];
        check(&model, &KinematicObjective::pose(frame(0), target).with_axes(&few), &q, 3);
        check(&model, &KinematicObjective::relative_pose(frame(0), frame(3), target), &q, 6);
        check(&model, &KinematicObjective::center_of_mass([0.1, 0.2, 0.3]), &q, 3);
        let weights = [2.0, 0.0, 0.5];
        check(&model, &KinematicObjective::CenterOfMass { target: [0.1, 0.2, 0.3], weights }, &q, 2);
        let moving = model.actuated_dofs().iter().filter(|moves| **moves).count();
        // Rotations below π, where the logarithm is smooth.
        let target = moved(&model, &q, 0.5, &mut random);
        check(&model, &KinematicObjective::Posture { target }, &q, moving);
        let (axis, point) = ([0.6, 0.0, 0.8], [0.7, -2.0, 3.0]);
        check(&model, &KinematicObjective::LookAt { frame: frame(0), axis, point }, &q, 3);
    }
}

#[test]
fn jacobians_of_constraints_are_derivatives() {
    let linkage = load("linkage.xml", Base::Fixed);
    let set = ConstraintSet::from_equalities(&linkage).expect("a closed loop");
    let q = random_q(&linkage, &mut SplitMix64::new(3));
    check(&linkage, &KinematicObjective::Constraints(set), &q, 3);
    let panda = load("panda.urdf", Base::Fixed);
    let names = panda.coordinate_names();
    let coupling = Coupling::new(&panda, &[(&names[1], 1.0), (&names[3], -0.5)], 0.2).expect("a coupling");
    let hand = panda.frame_named("panda_link8").expect("a frame");
    let at = Pose::from_xyz_rpy([0.4, 0.1, 0.5], [0.3, 0.2, 0.1]);
    let held = FrameConstraint::contact(hand, at, &FrameConstraint::WELD);
    let set = ConstraintSet::new(&panda, [("gear", coupling.into()), ("held", held.into())]).expect("a set");
    let q = [0.1, -0.4, 0.3, -2.2, 0.2, 1.9, 0.8];
    check(&panda, &KinematicObjective::Constraints(set), &q, 7);
}
