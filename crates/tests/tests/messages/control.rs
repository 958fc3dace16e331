use robot_dynamics::constraints::SpatialAxis;
use robot_dynamics::control::online_motion::{OnlineLimits, OnlineMotion, OnlineMotionError};
use robot_dynamics::control::{
    ComputedTorque, CubicSpline, FrameTarget, InverseKinematicsError, InverseKinematicsOptions, MotionLimits,
    MotionRecord, ParameterizationError, PoseReference, Reference, TaskControl, TaskGains, TimeOptimal,
    inverse_kinematics, time_optimal,
};
use robot_dynamics::description::Pose;
use robot_dynamics::model::{Model, Workspace};
use robot_dynamics::simulation::{Controller, GravityCompensatedPd};

use crate::Section;
use crate::robots::planar_arm;

pub(crate) fn controller_error() -> Section {
    let mut section = Section::new("ControllerError");
    let model = Model::new(planar_arm()).expect("a robot");
    let tip = model.frame_named("tip").expect("a frame");
    let error = GravityCompensatedPd::new(&model, &[0.0; 2], &[f64::NAN; 2], &[1.0; 2]).expect_err("NaN");
    section.row("a stiffness of NaN", error);
    let still = |_| Reference { q: vec![0.0; 2], v: vec![0.0; 2], a: vec![0.0; 2] };
    let error = ComputedTorque::new(&model, still, &[1.0; 3], &[1.0; 2]).err().expect("a length");
    section.row("3 stiffnesses for 2", error);
    let gains = TaskGains { stiffness: 100.0, damping: 20.0, null_damping: 0.0 };
    let here = |_| PoseReference::at_rest(Pose::IDENTITY);
    let error = TaskControl::new(&model, tip, here, TaskGains { damping: f64::INFINITY, ..gains });
    section.row("infinite damping", error.err().expect("infinite"));
    let mut stretched = Pose::IDENTITY;
    stretched.rotation[1][1] = 1.5;
    let mut control = TaskControl::new(&model, tip, |_| PoseReference::at_rest(stretched), gains)
        .expect("gains")
        .with_rows(&[SpatialAxis::X]);
    let error = control.torque(0.0, &[0.1, 0.2], &[0.0; 2], &mut [0.0; 2]);
    section.row("a stretched pose", error.expect_err("stretched"));
    section
}

pub(crate) fn inverse_kinematics_error() -> Section {
    let mut section = Section::new("InverseKinematicsError");
    let model = Model::new(planar_arm()).expect("a robot");
    let tip = model.frame_named("tip").expect("a frame");
    let mut row = |input: &str, target: FrameTarget, start: &[f64], options: InverseKinematicsOptions| {
        let error = inverse_kinematics(&model, &mut Workspace::new(&model), tip, target, start, &options);
        section.row(input, error.expect_err(input));
    };
    let usual = InverseKinematicsOptions::default;
    let (good, start) = (FrameTarget::Position([1.0, 0.0, 0.5]), [0.1, 0.2]);
    row("a position of NaN", FrameTarget::Position([0.0, f64::NAN, 0.0]), &start, usual());
    let mut pose = Pose::IDENTITY;
    pose.rotation[2][1] = f64::INFINITY;
    row("an infinite rotation", pose.into(), &start, usual());
    pose.rotation[2][1] = 0.5;
    row("a sheared rotation", pose.into(), &start, usual());
    row("a start of NaN", good, &[0.1, f64::NAN], usual());
    row("one number for two", good, &[0.1], usual());
    for tolerance in [0.0, f64::NAN] {
        let options = usual().with_tolerances(1e-6, tolerance);
        row(&format!("a tolerance of {tolerance}"), good, &start, options);
    }
    let found = inverse_kinematics(&model, &mut Workspace::new(&model), tip, good, &start, &usual());
    let mut best = Box::new(found.expect("a target in reach"));
    (best.position_error, best.angle_error, best.iterations, best.restarts) = (1.5, 0.0, 12, 3);
    let (frame, robot) = ("tip".to_owned(), "planar".to_owned());
    section.row("a target out of reach", InverseKinematicsError::NoSolution { frame, robot, best });
    section
}

pub(crate) fn spline_error() -> Section {
    let mut section = Section::new("ParameterizationError of CubicSpline");
    let error = CubicSpline::through(&[vec![0.0], vec![1.0], vec![1.0]]).expect_err("a point twice");
    section.row("a point twice", error);
    section
}

pub(crate) fn parameterization_error() -> Section {
    let mut section = Section::new("ParameterizationError");
    let model = Model::new(planar_arm()).expect("a robot");
    let path = CubicSpline::through(&[vec![-1.0, 0.0], vec![0.0, 1.75], vec![1.0, 0.0]]).expect("a path");
    let solve = |limits: MotionLimits| {
        time_optimal(&model, &path, &TimeOptimal::from_rest_to_rest(limits, 2)).expect_err("no motion")
    };
    let coordinate = "elbow".to_owned();
    section.row(
        "a waypoint beyond a limit",
        ParameterizationError::BeyondPosition { s: 0.5, coordinate, value: 1.75, lower: -2.0, upper: 1.5 },
    );
    section.row("a torque limit of 0", solve(MotionLimits::new(vec![0.0, 14.0], vec![4.0, 5.0])));
    section.row(
        "a torque limit below the weight",
        ParameterizationError::Overloaded {
            s: 0.5,
            coordinate: "shoulder".into(),
            needed: 20.0,
            limit: 15.0,
        },
    );
    section.row("no limits", ParameterizationError::Unbounded { s: 0.0 });
    section.row(
        "a start that is too fast",
        ParameterizationError::EndSpeed { place: "start", speed: 50.0, largest: 2.5 },
    );
    section
}

pub(crate) fn online_motion_error() -> Section {
    let mut section = Section::new("OnlineMotionError");
    let model = Model::new(planar_arm()).expect("a robot");
    let limits = OnlineLimits::new(vec![1.0; 2], vec![4.0; 2], vec![40.0; 2]);
    let no_jerk = OnlineLimits { jerk: vec![40.0, 0.0], ..limits.clone() };
    section.row("a jerk limit of 0", OnlineMotion::new(&model, no_jerk, 1e-3).expect_err("no jerk"));
    let error = OnlineMotion::new(&model, limits.clone(), 0.0).expect_err("no period");
    section.row("a period of 0", error);
    let mut motion = OnlineMotion::new(&model, limits, 1e-3).expect("limits");
    section.row("one number for two", motion.set_target(&[0.0], &[0.0], &[0.0]).expect_err("one number"));
    let error = motion.set_target(&[0.0; 2], &[0.0, -1.5], &[0.0; 2]).expect_err("too fast");
    section.row("a target that is too fast", error);
    section.row("no way to stop within the limits of position", OnlineMotionError::PositionLimits);
    section.row("no motion", OnlineMotionError::NoMotion { reason: "ErrorZeroLimits".into() });
    section
}

pub(crate) fn identification_error() -> Section {
    let mut section = Section::new("IdentificationError");
    let model = Model::new(planar_arm()).expect("a robot");
    let mut record = MotionRecord::new(&model, false);
    record.push(&[0.1; 2], &[0.0; 2], &[0.0; 2], &[0.0; 2]).expect("a sample");
    let error = record.push(&[0.1; 2], &[f64::NAN; 2], &[0.0; 2], &[0.0; 2]).expect_err("NaN");
    section.row("v of NaN", error);
    section
}
