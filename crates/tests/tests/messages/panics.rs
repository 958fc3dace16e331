use std::panic::{AssertUnwindSafe, catch_unwind};

use robot_dynamics::algorithms::{ReferenceFrame, frame_jacobian, frame_pose, gravity};
use robot_dynamics::batch::{self, BatchWorkspace};
use robot_dynamics::constraints::{ConstraintSet, FrameConstraint, SpatialAxis};
use robot_dynamics::control::{
    InverseKinematicsOptions, TaskControl, TaskGains, TaskReference, inverse_kinematics,
};
use robot_dynamics::derivatives::{InversePullbackMut, inverse_dynamics_pullback};
use robot_dynamics::description::pendulum;
use robot_dynamics::model::{JointMap, Model, Workspace, neutral};
use robot_dynamics::verification::lagrange;

use crate::Section;
use crate::robots::{arm, floating_arm, planar_arm};

fn message<T>(call: impl FnOnce() -> T) -> String {
    match catch_unwind(AssertUnwindSafe(call)) {
        Ok(_) => panic!("the call returns"),
        Err(panic) => match panic.downcast::<String>() {
            Ok(text) => *text,
            Err(panic) => (*panic.downcast::<&str>().expect("a text")).to_owned(),
        },
    }
}

/// The same joints and links with other masses, so that lengths fit.
fn heavy() -> Model {
    let mut robot = arm();
    robot.name = "heavy".into();
    let mass = robot.links[2].mass_properties.expect("a body");
    robot.links[2].mass_properties = Some(mass.combine(&mass));
    Model::new(robot).expect("a robot")
}

/// Workspaces, frames, sets and maps of another robot.
pub(crate) fn foreign_objects() -> Section {
    let mut section = Section::new("panics: objects of another robot");
    let (model, heavy) = (Model::new(arm()).expect("a robot"), heavy());
    let (q, v, mut out) = ([0.1, 0.2], [0.0; 2], [0.0; 12]);
    let frame = heavy.frame("hand").expect("a link");
    let w = &mut Workspace::new(&model);
    section.row("a workspace", message(|| gravity(&model, &mut Workspace::new(&heavy), &q, &mut out[..2])));
    let foreign = &mut BatchWorkspace::<f64>::new(&heavy);
    section.row("a workspace of batches", message(|| batch::gravity(&model, foreign, &q, &mut out[..2])));
    section.row("a frame", message(|| frame_pose(&model, w, &q, frame)));
    let jacobian =
        message(|| frame_jacobian(&model, w, &q, frame, ReferenceFrame::LocalWorldAligned, &mut out));
    section.row("a frame of a Jacobian", jacobian);
    let pin = FrameConstraint::point_contact(frame, [0.0; 3]);
    let set = ConstraintSet::new(&heavy, [("pin", pin.into())]).expect("a set");
    section.row("a constraint set", message(|| set.rows(&model, w, &q, &v)));
    let options = InverseKinematicsOptions::default();
    let target = [1.0, 0.0, 0.0];
    let solved = message(|| inverse_kinematics(&model, w, frame, target, &q, &options));
    section.row("a frame of inverse kinematics", solved);
    let mut locked = arm();
    locked.name = "locked".into();
    locked.lock_joint("elbow", &[0.0]).expect("a hinge");
    let locked = Model::new(locked).expect("a robot");
    let map = JointMap::new(&model, &locked, &neutral(&model)).expect("a reduction");
    section.row("a model of a joint map", message(|| map.check(&model, &model)));
    section.row("a q of a joint map", message(|| map.expand_configuration(&[0.0; 2], &mut [0.0; 2])));
    section
}

pub(crate) fn wrong_lengths() -> Section {
    let mut section = Section::new("panics: wrong arguments");
    let model = Model::new(pendulum(2.0, 0.5)).expect("a robot");
    let w = &mut Workspace::<f64>::new(&model);
    section.row("a q of 2 numbers for 1", message(|| gravity(&model, w, &[0.0; 2], &mut [0.0])));
    let pulled = message(|| {
        let (x, none) = (&mut [0.0], &mut []);
        let out = InversePullbackMut {
            by_position: x,
            by_velocity: none,
            by_acceleration: &mut [0.0],
            parameters: &mut [],
        };
        inverse_dynamics_pullback(&model, w, &[0.0], &[0.0], &[0.0], &[0.0], out);
    });
    section.row("an empty cotangent", pulled);
    let floating = Model::new(floating_arm()).expect("a robot");
    let q = neutral(&floating);
    section.row("symbols of a floating base", message(|| lagrange::christoffel(&floating, &q)));
    let arm = Model::new(planar_arm()).expect("a robot");
    let tip = arm.frame_named("tip").expect("a frame");
    let position = |_| TaskReference { position: [0.0; 3], velocity: [0.0; 3], acceleration: [0.0; 3] };
    let gains = TaskGains { stiffness: 1.0, damping: 1.0, null_damping: 0.0 };
    let control = TaskControl::new(&arm, tip, position, gains).expect("gains");
    let rows = message(|| drop(control.with_rows(&[SpatialAxis::X, SpatialAxis::Rx])));
    section.row("a turn in a task of positions", rows);
    section
}

/// Tables of a batch of three states.
pub(crate) fn batches() -> Section {
    let mut section = Section::new("panics: tables of a batch");
    let model = Model::new(arm()).expect("a robot");
    let w = &mut BatchWorkspace::<f64>::new(&model);
    let (q, v, mut out) = ([0.1; 6], [0.1; 6], [0.0; 6]);
    section.row("a part of a state", message(|| batch::gravity(&model, w, &q[1..], &mut out)));
    section.row("velocities of fewer states", message(|| batch::bias(&model, w, &q, &v[1..], &mut out)));
    section.row("one result", message(|| batch::gravity(&model, w, &q, &mut [0.0])));
    let (mut x, mut y) = ([0.0; 12], [0.0; 3]);
    let derivatives = message(|| {
        let out = batch::InverseDynamicsDerivativesMut { by_position: &mut x, by_velocity: &mut y };
        batch::inverse_dynamics_derivatives(&model, w, &q, &v, &v, out)
    });
    section.row("derivatives of fewer states", derivatives);
    let related = message(|| batch::mass_matrix_related(&model, w, &q, &mut [0.0; 7]));
    section.row("entries of M of fewer states", related);
    section
}
