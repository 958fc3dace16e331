use robot_dynamics::batch::{BatchWorkspace, Rollout, RolloutStates, Torques, rollout};
use robot_dynamics::constraints::{
    ConstraintError, ConstraintOptions, ConstraintSet, ContactSupport, FrameConstraint, LoopClosure,
    RedundantRows, SpatialAxis, SupportProblem, constrained_forward_dynamics, supported_inverse_dynamics,
};
use robot_dynamics::control::operational_space;
use robot_dynamics::derivatives::{MotionCotangents, RobotState, StepPullbackWorkspace, step_pullback};
use robot_dynamics::description::{LinkDescription, MassProperties, pendulum};
use robot_dynamics::model::{Model, Workspace, check_configuration, neutral};
use robot_dynamics::simulation::{
    ControllerError, Integrator, IntegratorError, StepError, StepForces, StepWorkspace, step,
};

use crate::Section;
use crate::robots::{arm, floating_arm, gimbal, planar_arm};

pub(crate) fn configuration_error() -> Section {
    let mut section = Section::new("InvalidInput of q");
    let model = Model::new(floating_arm()).expect("a robot");
    let mut q = neutral(&model);
    section.row("one number too few", check_configuration(&model, &q[1..]).expect_err("length"));
    q[6] = 2.0;
    section.row("a quaternion of length 2", check_configuration(&model, &q).expect_err("length 2"));
    q[8] = f64::NAN;
    section.row("an angle of NaN", check_configuration(&model, &q).expect_err("NaN"));
    section
}

pub(crate) fn motion_error() -> Section {
    let mut section = Section::new("MotionError");
    let model = Model::new(gimbal()).expect("a robot");
    let (good, zero) = ([0.1, 0.2, 0.3], [0.0; 3]);
    let error = model.forward_dynamics(&good, &zero, &[0.0, 0.0, f64::INFINITY]).expect_err("infinite");
    section.row("an infinite torque", error);
    section.row("4 velocities for 3", model.bias(&good, &[0.0; 4]).expect_err("length"));
    section.row("q of NaN", model.mass_matrix(&[0.0, f64::NAN, 0.0]).expect_err("NaN"));
    section.row("v of 1e200", model.velocity_product(&good, &[1e200; 3]).expect_err("overflow"));
    let error = model.forward_dynamics(&zero, &zero, &zero).expect_err("singular");
    section.row("two joints with one axis", error);
    let solve = |robot| {
        let model: Model = Model::new(robot).expect("a robot");
        model.forward_dynamics(&[0.1, 0.2], &[0.0; 2], &[0.0; 2]).expect_err("no acceleration")
    };
    let mut massless = arm();
    massless.links[2].mass_properties = None;
    section.row("a link without mass", solve(massless.clone()));
    massless.links[1].mass_properties = None;
    section.row("two links without mass", solve(massless));
    let mut negative = arm();
    let moments = nalgebra::Matrix3::identity() * -0.1;
    negative.links[2].mass_properties =
        MassProperties::as_written(1.0, nalgebra::Vector3::zeros(), moments).ok();
    section.row("a link with negative moments of inertia", solve(negative));
    section
}

pub(crate) fn constraint_set_error() -> Section {
    let mut section = Section::new("ConstraintError");
    let model = Model::new(arm()).expect("a robot");
    let loops = r#"[{"name": "pin", "frame_a": "finger", "frame_b": "hand", "rows": ["x", "y"]}]"#;
    let loops: Vec<LoopClosure> = serde_json::from_str(loops).expect("a loop");
    section.row("an unknown frame", ConstraintSet::from_loops(&model, &loops).expect_err("no frame"));
    let mut other = arm();
    other.name = "other".into();
    other.gravity = [0.0; 3];
    let other = Model::new(other).expect("a robot");
    let frame = other.frame("hand").expect("a link");
    let pin = FrameConstraint::point_contact(frame, [0.0; 3]);
    let error = ConstraintSet::new(&model, [("pin", pin.into())]).expect_err("a foreign frame");
    section.row("a frame of another robot", error);
    section
}

pub(crate) fn constrained_motion_error() -> Section {
    let mut section = Section::new("ConstraintError");
    let model = Model::new(arm()).expect("a robot");
    let hand = model.frame("hand").expect("a link");
    let w = &mut Workspace::new(&model);
    let pin = FrameConstraint::point_contact(hand, [0.0; 3]);
    let set = ConstraintSet::new(&model, [("pin", pin.into())]).expect("a set");
    let options = ConstraintOptions { redundant: RedundantRows::Refuse, ..ConstraintOptions::default() };
    let (q, zero) = ([0.3, 0.4], [0.0; 2]);
    let error = constrained_forward_dynamics(&model, w, &set, &options, &q, &zero, &zero);
    section.row("dependent rows", error.expect_err("dependent rows"));
    section.row("feedback in a variational step", ConstraintError::StabilizedVariationalStep);
    let name = || "pin.x".to_owned();
    section.row(
        "a step of 2 s",
        ConstraintError::StepNotConverged { residual: 0.25, iterations: 50, step: 2.0, name: name() },
    );
    section.row(
        "a point out of reach",
        ConstraintError::NotConverged { iterations: 50, name: name(), error: 0.5 },
    );
    section.row(
        "a start off the constraint",
        ConstraintError::OffConstraint { quantity: "the position error", name: name(), error: 0.5 },
    );
    let mut supported = |input: &str, change: &dyn Fn(&mut ContactSupport), weight: f64| {
        let mut foot = ContactSupport::new(hand, [0.0; 3], [0.0, 0.0, 1.0], 0.5);
        change(&mut foot);
        let feet = [foot];
        let supports = SupportProblem::new(&feet).with_force_weight(weight);
        let w = &mut Workspace::new(&model);
        let error = supported_inverse_dynamics(&model, w, &supports, &q, &zero, &zero, &[false; 2]);
        section.row(input, error.expect_err(input));
    };
    supported("a support without a normal", &|foot| foot.normal = [0.0; 3], 1.0);
    supported("a support at NaN", &|foot| foot.point[1] = f64::NAN, 1.0);
    supported("a support with negative friction", &|foot| foot.friction = -1.0, 1.0);
    supported("supports with the weight 0", &|_| {}, 0.0);
    section
}

pub(crate) fn operational_space_error() -> Section {
    let mut section = Section::new("ControllerError of operational_space");
    let model = Model::new(planar_arm()).expect("a robot");
    let tip = model.frame_named("tip").expect("a frame");
    let w = &mut Workspace::new(&model);
    let error = operational_space(&model, w, &[f64::NAN, 0.0], &[0.0; 2], tip, &[SpatialAxis::Z]);
    section.row("q of NaN", error.expect_err("NaN"));
    section.row("out of its plane", ControllerError::SingularPose { row: "y", pivot: 0.0 });
    section
}

pub(crate) fn integrator_error() -> Section {
    let mut section = Section::new("IntegratorError");
    let model = Model::new(pendulum(2.0, 0.5)).expect("a robot");
    let forces = StepForces::new(&[0.0], false);
    let (w, rk4) = (&mut StepWorkspace::new(&model), Integrator::RungeKutta4);
    let error = step(&model, rk4, w, &forces, 0.1, &mut [0.0], &mut [f64::NAN]).expect_err("NaN");
    section.row("v of NaN", error);
    let error = IntegratorError::NotConverged { residual: 0.25, iterations: 50, step: 5.0 };
    section.row("a variational step of 5 s", error);
    section
}

pub(crate) fn pullback_error() -> Section {
    let mut section = Section::new("StepError of derivatives");
    let integrator = Integrator::VariationalMidpoint;
    section.row("an implicit row", StepError::NotDifferentiable { integrator });
    let mut pull = |input: &str, mass: Option<MassProperties>, v: f64| {
        let mut robot = pendulum(2.0, 0.5);
        robot.links[1] = LinkDescription::new(robot.links[1].name.clone(), mass);
        robot.frames.clear();
        let model = Model::new(robot).expect("a robot");
        let (w, forces) = (&mut StepPullbackWorkspace::new(&model), StepForces::new(&[0.0], false));
        let rk4 = Integrator::RungeKutta4;
        let (x, y, z) = (&mut [1.0], &mut [1.0], &mut [0.0]);
        let cotangents =
            MotionCotangents { by_position: x, by_velocity: y, by_force: z, parameters: &mut [] };
        let error =
            step_pullback(&model, rk4, w, &forces, 1e-3, RobotState { q: &[0.0], v: &[v] }, cotangents);
        section.row(input, error.expect_err(input));
    };
    pull("v of NaN", MassProperties::point(1.0, nalgebra::Vector3::x()).ok(), f64::NAN);
    pull("a link without mass", None, 0.0);
    section
}

pub(crate) fn rollout_error() -> Section {
    let mut section = Section::new("RolloutError");
    let model = Model::new(pendulum(2.0, 0.5)).expect("a robot");
    let how = Rollout::new(Integrator::VariationalMidpoint, 1e-3, 5);
    let w = &mut BatchWorkspace::<f64>::new(&model);
    let (mut q, mut v) = ([0.0], [0.0]);
    let error = rollout(&model, w, &how, Torques::Zero, RolloutStates::ends(&mut q, &mut v), None);
    section.row("an implicit row", error.expect_err("implicit"));
    let how = Rollout::new(Integrator::RungeKutta4, f64::INFINITY, 5);
    let (mut q, mut v) = ([0.0], [0.0]);
    let error = rollout(&model, w, &how, Torques::Zero, RolloutStates::ends(&mut q, &mut v), None);
    section.row("an infinite step", error.expect_err("infinite"));
    section
}
