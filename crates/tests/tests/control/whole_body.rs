//! Whole-body control against the optimality conditions, other control laws, and statics.

mod laws;
mod limits;
mod optimality;
mod simulated;

use robot_dynamics::LoadOptions;
use robot_dynamics::algorithms::{
    FrameWrench, ReferenceFrame, frame_acceleration, frame_pose, inverse_dynamics_with_wrenches,
};
use robot_dynamics::control::Reference;
use robot_dynamics::control::whole_body::{
    ContactGeometry, HeldContact, Objective, PdGains, WholeBodyControl, WholeBodySolution,
};
use robot_dynamics::description::Base;
use robot_dynamics::model::{FrameId, Model, Workspace, integrate, neutral};
use robot_dynamics::number::SplitMix64;

const ROBOTS: &str = concat!(env!("CARGO_MANIFEST_DIR"), "/../../robots/");

pub(super) const FEET: [&str; 4] =
    ["front_left_foot", "front_right_foot", "hind_left_foot", "hind_right_foot"];

/// The radius of the quadruped's feet \[m\].
pub(super) const RADIUS: f64 = 0.02;

pub(super) fn load(file: &str, base: Base) -> Model {
    let mut robot = robot_dynamics::load_description(format!("{ROBOTS}{file}"), &LoadOptions::default())
        .expect("a robot")
        .description;
    robot.base = base;
    Model::new(robot).expect("a valid robot")
}

pub(super) fn quadruped() -> Model {
    load("quadruped.urdf", Base::Floating)
}

/// The quadruped with bent knees and its feet at the height of their radius.
pub(super) fn standing(model: &Model) -> Vec<f64> {
    let mut q = neutral(model);
    for leg in 0..4 {
        q[7 + 3 * leg..10 + 3 * leg].copy_from_slice(&[0.0, 0.7, -1.4]);
    }
    let foot = model.frame_named(FEET[0]).expect("a foot");
    q[2] += RADIUS - frame_pose(model, &mut Workspace::new(model), &q, foot).translation[2];
    q
}

/// A state near the stance, with all coordinates moved and moving.
pub(super) fn near(model: &Model, q: &[f64], size: f64, seed: u64) -> (Vec<f64>, Vec<f64>) {
    let mut random = SplitMix64::new(seed);
    let mut vector = |size: f64| (0..model.nv()).map(|_| random.uniform(-size, size)).collect::<Vec<_>>();
    let (step, v) = (vector(size), vector(3.0 * size));
    let mut moved = q.to_vec();
    integrate(model, q, &step, &mut moved);
    (moved, v)
}

/// A controller of the quadruped with its feet on the ground and no task.
pub(super) fn on_feet(model: &Model, friction: f64) -> WholeBodyControl<&Model> {
    let mut control = WholeBodyControl::new(model);
    for foot in FEET {
        let frame = model.frame_named(foot).expect("a foot");
        let contact = HeldContact::new(frame, ContactGeometry::Ball(RADIUS));
        control.add_contact(contact.with_friction(friction, 4).expect("a cone")).expect("a contact");
    }
    control
}

pub(super) fn posture(model: &Model, q: &[f64], stiffness: f64) -> Objective {
    let rest = vec![0.0; model.nv()];
    let reference = Reference { q: q.to_vec(), v: rest.clone(), a: rest };
    Objective::Posture { reference, gains: PdGains::critical(stiffness) }
}

/// Inverse dynamics with the forces at the lowest points of balls.
pub(super) fn torque_of(
    model: &Model,
    (q, v, a): (&[f64], &[f64], &[f64]),
    forces: &[(FrameId, [f64; 3])],
) -> Vec<f64> {
    let workspace = &mut Workspace::new(model);
    let wrenches: Vec<FrameWrench> = forces
        .iter()
        .map(|(frame, force)| {
            let rotation = frame_pose(model, workspace, q, *frame).rotation;
            let turn = |x: [f64; 3]| core::array::from_fn(|j| (0..3).map(|i| rotation[i][j] * x[i]).sum());
            // (0, 0, −r) × f.
            let moment = [RADIUS * force[1], -RADIUS * force[0], 0.0];
            FrameWrench { frame: *frame, force_in_frame: turn(*force), moment_in_frame: turn(moment) }
        })
        .collect();
    let mut tau = vec![0.0; model.nv()];
    inverse_dynamics_with_wrenches(model, workspace, q, v, a, &wrenches, &mut tau);
    tau
}

/// The acceleration of the lowest point of a ball that rolls, with the velocity of that point.
pub(super) fn rolling(
    model: &Model,
    (q, v, a): (&[f64], &[f64], &[f64]),
    frame: FrameId,
) -> ([f64; 3], [f64; 3]) {
    let (w, aligned) = (&mut Workspace::new(model), ReferenceFrame::LocalWorldAligned);
    let rate = frame_acceleration(model, w, q, v, a, frame, aligned);
    let twist = robot_dynamics::algorithms::frame_velocity(model, w, q, v, frame, aligned);
    // x + ω × (0, 0, −r).
    let at_ground = |x: [f64; 3], w: [f64; 3]| [x[0] - RADIUS * w[1], x[1] + RADIUS * w[0], x[2]];
    (at_ground(rate.linear, rate.angular), at_ground(twist.linear, twist.angular))
}

/// Forces with the frames of their contacts, one point each.
pub(super) fn forces_at(frames: &[FrameId], solution: &WholeBodySolution) -> Vec<(FrameId, [f64; 3])> {
    solution.forces.iter().map(|point| (frames[point.contact.index()], point.force)).collect()
}

pub(super) fn frames(model: &Model, names: &[&str]) -> Vec<FrameId> {
    names.iter().map(|name| model.frame_named(name).expect("a frame")).collect()
}

pub(super) fn largest(x: impl IntoIterator<Item = f64>) -> f64 {
    x.into_iter().fold(0.0, |most: f64, x| if x.abs() <= most { most } else { x.abs() })
}
