//! Every error of the library has a kind, and converts to `Error` with the kind and the text of the original.

use std::error::Error as _;
use std::path::Path;

use robot_dynamics::ErrorKind::{self, *};
use robot_dynamics::algorithms::{MotionError, SingularMass};
use robot_dynamics::constraints::ConstraintError;
use robot_dynamics::control::online_motion::OnlineMotionError;
use robot_dynamics::control::task_kinematics::{KinematicLimit, TaskKinematicsError};
use robot_dynamics::control::whole_body::{Limit, WholeBodyError};
use robot_dynamics::control::{
    DlqrError, IdentificationError, InverseKinematicsError, ParameterizationError,
};
use robot_dynamics::description::{InertiaError, ModelError, pendulum};
use robot_dynamics::model::Model;
use robot_dynamics::simulation::{
    CallbackError, ControllerError, Integrator, IntegratorError, RunError, RunFailure, SimulationError,
    StepError,
};
use robot_dynamics::{
    Classified, Error, FileError, InputProblem, InvalidInput, LoadOptions, load_description_from_text,
};

/// Checks the kind, and that the conversion keeps text and source.
#[track_caller]
fn check<E: Classified>(error: E, kind: ErrorKind) {
    let (text, source) = (error.to_string(), error.source().map(ToString::to_string));
    let error = Error::from(error);
    assert_eq!(error.kind(), kind, "{error}");
    assert_eq!((error.to_string(), format!("{error:?}")), (text.clone(), text));
    assert_eq!(error.source().map(ToString::to_string), source);
    assert!(error.downcast_ref::<E>().is_some());
    assert!(error.downcast::<E>().is_ok());
}

fn bad_name() -> InvalidInput {
    InvalidInput::unknown_name("pose", "up", "robot `arm`", [])
}

fn bad_input() -> InvalidInput {
    InvalidInput::new("v", InputProblem::Overflow { value: f64::INFINITY })
}

fn singular_mass() -> SingularMass {
    let model = Model::new(pendulum(2.0, 0.5)).expect("a robot");
    SingularMass::at(&model, 0, 0.0)
}

fn name() -> String {
    "elbow".to_owned()
}

#[test]
fn errors_of_files_and_descriptions() {
    let refused = load_description_from_text("<robot/>", &LoadOptions::default()).expect_err("no links");
    check(refused, File);
    check(FileError::Model { source: Box::new(ModelError::NoLinks), report: Box::default() }, Description);
    let refused = load_description_from_text(
        "<mujoco><worldbody><joint/></worldbody></mujoco>",
        &LoadOptions::default(),
    )
    .expect_err("a joint");
    assert!(matches!(refused, FileError::Mjcf(_)));
    check(refused, File);
    check(std::io::Error::other("no disk"), File);
    check(robot_dynamics::urdf::disabled_collisions("<robot", &[]).expect_err("not XML"), File);
    check(ModelError::NoLinks, Description);
    check(ModelError::from(bad_name()), UnknownName);
    check(ModelError::from(bad_input()), InvalidInput);
    check(ModelError::Follows { joint: name(), leader: name() }, Unsupported);
    check(ModelError::Irreversible { joint: name(), reason: "it has a spring" }, Unsupported);
    check(ModelError::Mesh { file: name(), reason: "it is open".to_owned() }, Description);
    let refused = load_description_from_text("<scene><cone/></scene>", &LoadOptions::default());
    check(refused.expect_err("an unknown part"), File);
    check(ModelError::MomentWithoutMass { link: name() }, Description);
    check(ModelError::Unwritable(vec![name()]), Unsupported);
    check(InertiaError::TriangleInequality { moments: [1.0, 1.0, 3.0] }, Description);
    check(InertiaError::from(bad_input()), InvalidInput);
    let model = Model::new(pendulum(2.0, 0.5)).expect("a robot");
    let missing: InvalidInput = model.frame_named("gripper").expect_err("no gripper");
    check(missing, UnknownName);
    check(ModelError::NotReduced { joint: name(), reason: name() }, Description);
}

#[test]
fn errors_of_states_and_motions() {
    check(bad_input(), InvalidInput);
    check(MotionError::from(bad_input()), InvalidInput);
    check(MotionError::NoMass { robot: name() }, Infeasible);
    check(MotionError::from(singular_mass()), Singular);
    check(singular_mass(), Singular);
    check(StepError::NotDifferentiable { integrator: Integrator::VariationalMidpoint }, Unsupported);
    check(StepError::ParametersNotDifferentiable { reason: "a fluid" }, Unsupported);
    check(StepError::from(singular_mass()), Singular);
    check(StepError::from(bad_input()), InvalidInput);
    check(StepError::Discontinuous { quantity: "q", coordinate: name() }, Infeasible);
}

#[test]
fn errors_of_control() {
    check(ControllerError::from(bad_input()), InvalidInput);
    check(ControllerError::SingularPose { row: "z", pivot: 0.0 }, Singular);
    check(ControllerError::Callback(CallbackError::new("no answer")), Callback);
    check(InverseKinematicsError::from(bad_input()), InvalidInput);
    check(IdentificationError::TooFewData { equations: 0, unknowns: 1, coordinates: 1 }, Infeasible);
    check(IdentificationError::SingularNominal { link: "rod".into() }, Infeasible);
    check(IdentificationError::NotConverged { steps: 100 }, NotConverged);
    check(IdentificationError::from(bad_input()), InvalidInput);
    check(DlqrError::NotConverged, NotConverged);
    check(DlqrError::NotStabilizable { modulus: 1.0, angle: 0.0 }, Infeasible);
    check(DlqrError::from(bad_input()), InvalidInput);
    check(ParameterizationError::from(bad_input()), InvalidInput);
    check(ParameterizationError::Standstill { s: 0.0 }, Infeasible);
    check(OnlineMotionError::from(bad_input()), InvalidInput);
    check(OnlineMotionError::PositionLimits, Infeasible);
    check(OnlineMotionError::NoMotion { reason: name() }, Infeasible);
    check(TaskKinematicsError::from(bad_input()), InvalidInput);
    check(TaskKinematicsError::NotConverged { steps: 3 }, NotConverged);
    let limit = KinematicLimit::Velocity { dof: 0 };
    check(TaskKinematicsError::Infeasible { limit }, Infeasible);
    check(WholeBodyError::from(bad_input()), InvalidInput);
    check(WholeBodyError::Infeasible { limit: Limit::Torque { dof: 6 } }, Infeasible);
    check(WholeBodyError::ContradictoryContacts { residual: 1.0 }, Infeasible);
    check(WholeBodyError::NotConverged { steps: 100 }, NotConverged);
}

#[test]
fn errors_of_simulations() {
    check(SimulationError::from(bad_input()), InvalidInput);
    check(SimulationError::GroundWithoutContacts, Unsupported);
    check(robot_dynamics::contact::Ground::slope(2.0).expect_err("a wall"), InvalidInput);
    check(ConstraintError::DuplicateName { name: name() }, Constraint);
    check(ConstraintError::from(bad_name()), UnknownName);
    check(ConstraintError::StabilizedVariationalStep, Unsupported);
    check(ConstraintError::NonFiniteRow { name: name() }, Constraint);
    check(ConstraintError::NotConverged { iterations: 1, name: name(), error: 1.0 }, NotConverged);
    check(StepError::NotExplicit { integrator: "variational" }, Unsupported);
    check(IntegratorError::from(bad_input()), InvalidInput);
    check(IntegratorError::NotFinite { quantity: "the acceleration", index: 0 }, Diverged);
    check(IntegratorError::Interrupted, Interrupted);
    check(StepError::from(IntegratorError::EnergyNotFinite { steps_done: 1 }), Diverged);
    check(StepError::from(ConstraintError::NonFiniteRow { name: name() }), Constraint);
    check(StepError::from(CallbackError::new("no answer")), Callback);
    check(StepError::StepTooSmall { step: 1e-12, coordinate: name() }, NotConverged);
    check(RunError::Input(bad_input()), InvalidInput);
    check(RunError::Input(bad_name()), UnknownName);
    let source = StepError::from(IntegratorError::Interrupted);
    check(RunError::Step { step: 1, time: 0.1, source }, Interrupted);
    check(RunError::SingularMass { step: 1, time: 0.1, source: singular_mass() }, Singular);
    check(RunError::EventNotFinite { name: name(), time: 0.1, value: f64::NAN }, Callback);

    let model = Model::new(pendulum(2.0, 0.5)).expect("a robot");
    let mut simulation = robot_dynamics::simulation(&model).build().expect("a simulation");
    simulation.set_torques(&[f64::NAN]);
    let failure: Box<RunFailure> = simulation
        .run_steps_from(&[f64::NAN], &[0.0], 1, robot_dynamics::simulation::RunOptions::new())
        .unwrap_err();
    check(*failure, InvalidInput);
}

#[cfg(feature = "batch")]
#[test]
fn errors_of_batches() {
    use robot_dynamics::batch::RolloutError;
    check(RolloutError::Policy, Unsupported);
    check(RolloutError::Cancelled { unfinished: vec![0], batch: 1 }, Interrupted);
    check(RolloutError::from(bad_input()), InvalidInput);
}

/// The public error types in the sources of all crates that do not implement `Classified`.
#[test]
fn every_public_error_type_has_a_kind() {
    let mut texts = Vec::new();
    read_sources(&Path::new(env!("CARGO_MANIFEST_DIR")).join(".."), &mut texts);
    let all = texts.concat();
    let declared = all.lines().filter_map(|line| {
        let item = line.strip_prefix("pub enum ").or_else(|| line.strip_prefix("pub struct "))?;
        let name = item.split(|c: char| !c.is_alphanumeric()).next()?;
        ["Error", "Failure", "Fault"].iter().any(|end| name.ends_with(end)).then_some(name)
    });
    // `Error` converts from every `Classified`, so it cannot be one. `LabError` is a message for a page. The
    // errors of a file's lines are parts of a `RefusedFile`, which has a kind.
    let parts = ["Error", "LabError", "MjcfError", "SceneFault", "UrdfError", "UsdError", "XmlError"];
    let without: Vec<&str> = declared
        .filter(|name| !parts.contains(name) && !all.contains(&format!("Classified for {name} {{")))
        .collect();
    assert!(without.is_empty(), "{without:?}");
}

fn read_sources(folder: &Path, texts: &mut Vec<String>) {
    for entry in std::fs::read_dir(folder).expect("a folder of crates") {
        let path = entry.expect("an entry").path();
        if path.is_dir() && !path.ends_with("tests") && !path.ends_with("target") {
            read_sources(&path, texts);
        } else if path.extension().is_some_and(|extension| extension == "rs") {
            texts.push(std::fs::read_to_string(&path).expect("a source"));
        }
    }
}
