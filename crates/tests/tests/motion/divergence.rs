//! Runs that grow without bound are reported as diverged by every method, with a step that keeps them
//! bounded.

use std::sync::atomic::AtomicBool;

use nalgebra::{Matrix3, Vector3};
use robot_dynamics::batch::{SimulationBatch, Threads};
use robot_dynamics::description::{
    ActuatorDescription, Base, Equality, EqualityDescription, JointDescription, JointKind, LinkDescription,
    MassProperties, PassiveForces, Pose, RobotDescription, Transmission,
};
use robot_dynamics::model::Model;
use robot_dynamics::simulation::{
    ConstantTorque, ControllerError, DivergenceCause, Integrator, Method, Run, RunError, RunFailure,
    RunOptions, SimulationBuilder,
};

type Ended = Result<Run, Box<RunFailure>>;

/// A finger of 3e-5 kg m² on a hinge.
fn finger() -> RobotDescription {
    let mut robot = RobotDescription::new("finger");
    robot.links.push(LinkDescription::new("palm", None));
    let mass = MassProperties::new(0.01, Vector3::new(0.05, 0.0, 0.0), Matrix3::identity() * 3e-5).unwrap();
    robot.links.push(LinkDescription::new("tip", mass));
    let hinge = JointKind::Revolute { axis: [0.0, 1.0, 0.0] };
    robot.joints.push(JointDescription::new("bend", hinge, "palm", "tip", Pose::IDENTITY));
    robot
}

/// The number of steps in a duration.
fn steps_of(time: f64, h: f64) -> usize {
    (0..1_000_000).take_while(|k| f64::from(*k) * h < time).count()
}

/// Asserts that the run diverges at the hinge, and that it stays bounded with the suggested step.
fn assert_named(what: &str, h: f64, of_step: impl Fn(f64) -> Ended) {
    let RunError::Diverged { coordinate, suggested_step, cause, time, step, .. } =
        of_step(h).unwrap_err().error
    else {
        panic!("{what}: another error");
    };
    assert_eq!((coordinate.as_str(), cause), ("bend", DivergenceCause::Stiffness), "{what}");
    assert!((time - step as f64 * h).abs() < 1e-12 && suggested_step < h, "{what}: {suggested_step:e}");
    let run = of_step(suggested_step).unwrap();
    assert!(run.v[0].abs() < 1.0, "{what}: {:?}", run.v);
}

/// A servo that is too stiff for the step, with MuJoCo's step and with Runge–Kutta; the implicit method
/// integrates it.
#[test]
fn stiff_servos_are_reported() {
    let mut robot = finger();
    let servo = ActuatorDescription::new("servo", Transmission::joint("bend", 1.0)).servo(50.0, 1.0);
    robot.actuators.push(servo);
    let model = Model::new(robot).unwrap();
    let steps = |h| steps_of(0.5, h);
    let by = |method: Method, h: f64| {
        let mut simulation = SimulationBuilder::new(&model).dt(h).method(method).build().unwrap();
        simulation.set_controls(&[0.5]);
        simulation.run_steps(steps(h), RunOptions::new())
    };
    assert_named("mujoco", 5e-3, |h| by(Method::Mujoco, h));
    assert_named("rk4", 5e-3, |h| by(Method::Fixed(Integrator::RungeKutta4), h));
    let run = by(Method::Implicit, 5e-3).unwrap();
    // At rest the servo carries 0.05 m · 0.1 N with 50 N m/rad.
    assert!((run.q[0] - 0.5).abs() < 2e-4, "{:?}", run.q);
}

/// A damper and a spring of a joint, with each explicit method.
#[test]
fn stiff_joints_are_reported() {
    for passive in [
        PassiveForces::default().with_damping(2.0),
        PassiveForces::default().with_spring(400.0, 0.1),
        PassiveForces::default().with_spring(300.0, 0.1).with_damping(1.0),
    ] {
        let mut robot = finger();
        robot.joints[0].passive = passive;
        let model = Model::new(robot).unwrap();
        for row in [Integrator::SemiImplicitEuler, Integrator::RungeKutta4] {
            assert_named(&format!("{row} {passive:?}"), 5e-3, |h| {
                let steps = steps_of(2.0, h);
                SimulationBuilder::new(&model)
                    .method(Method::Fixed(row))
                    .dt(h)
                    .build()
                    .unwrap()
                    .run_steps_from(&[0.1], &[1e-3], steps, RunOptions::new())
            });
        }
    }
}

/// A negative damper grows with any step, also with the implicit method. The error does not suggest that a
/// shorter step helps.
#[test]
fn growth_at_any_step_is_reported() {
    let mut robot = finger();
    robot.joints[0].passive = PassiveForces::default().with_damping(-1.0);
    let model = Model::new(robot).unwrap();
    let mut simulation = SimulationBuilder::new(&model).method(Method::Implicit).build().unwrap();
    let failure = simulation.run_steps_from(&[0.0], &[1e-3], 100_000, RunOptions::new()).unwrap_err();
    let RunError::Diverged { suggested_step, cause, .. } = failure.error else {
        panic!("another error");
    };
    assert_eq!((suggested_step, cause), (1e-4, DivergenceCause::Unknown));
}

/// A free body that tumbles too fast for MuJoCo's step continues with shorter steps.
#[test]
fn fast_tumbling_is_reported() {
    let mut robot = RobotDescription::new("body");
    robot.gravity = [0.0; 3];
    robot.base = Base::Floating;
    let moments = Matrix3::from_diagonal(&Vector3::new(4e-3, 5e-3, 8e-3));
    let mass = MassProperties::new(1.0, Vector3::zeros(), moments).unwrap();
    robot.links.push(LinkDescription::new("body", mass));
    let model = Model::new(robot).unwrap();
    let ended = |h: f64, steps: usize| {
        let (q, v) = ([0.0, 0.0, 0.0, 0.0, 0.0, 0.0, 1.0], [0.0, 0.0, 0.0, 1.0, 1000.0, 1.0]);
        SimulationBuilder::new(&model).method(Method::Mujoco).dt(h).build().unwrap().run_steps_from(
            &q,
            &v,
            steps,
            RunOptions::new(),
        )
    };
    let RunError::Diverged { suggested_step, cause, .. } = ended(1e-3, 10_000).unwrap_err().error else {
        panic!("another error");
    };
    assert_eq!(cause, DivergenceCause::Speed);
    assert!((suggested_step - 1e-4).abs() < 1e-12, "{suggested_step:e}");
    let run = ended(suggested_step, 100).unwrap();
    assert!(run.v[3..].iter().all(|v| v.abs() < 2e3), "{:?}", run.v);
}

/// A torque of NaN is not reported as divergence.
#[test]
fn inputs_that_are_not_finite_are_not_divergence() {
    let model = Model::new(finger()).unwrap();
    let mut torque = ConstantTorque(vec![f64::NAN]);
    let ended = SimulationBuilder::new(&model)
        .method(Method::Fixed(Integrator::RungeKutta4))
        .dt(1e-3)
        .build()
        .unwrap()
        .run_steps_from(&[0.0], &[0.0], 10, RunOptions::new().controller(&mut torque));
    assert!(!matches!(ended.unwrap_err().error, RunError::Diverged { .. }));
}

/// Equalities with a spring that is too stiff for the step.
#[test]
fn diverging_constrained_runs_are_reported() {
    let mut robot = finger();
    robot.joints[0].passive = PassiveForces::default().with_spring(400.0, 0.1);
    let mass = MassProperties::new(0.01, Vector3::new(0.05, 0.0, 0.0), Matrix3::identity() * 3e-5).unwrap();
    robot.links.push(LinkDescription::new("thumb", mass));
    let hinge = JointKind::Revolute { axis: [0.0, 1.0, 0.0] };
    robot.joints.push(JointDescription::new("thumb", hinge, "palm", "thumb", Pose::IDENTITY));
    let leader = Some(("bend".to_owned(), 0.0));
    let follows =
        Equality::Joints { joint: ("thumb".into(), 0.0), leader, polynomial: [0.0, 0.01, 0.0, 0.0, 0.0] };
    robot.equalities.push(EqualityDescription::new("coupled", follows));
    let model = Model::new(robot).unwrap();
    for row in [Integrator::SemiImplicitEuler, Integrator::RungeKutta4] {
        assert_named(&format!("{row} with an equality"), 5e-3, |h| {
            let builder = SimulationBuilder::new(&model).dt(h).method(Method::Fixed(row));
            let mut simulation = builder.build().unwrap();
            simulation.reset(&[0.1, 0.001], &[0.0; 2]).unwrap();
            simulation.run_steps(steps_of(2.0, h), RunOptions::new())
        });
    }
}

/// Implicit steps under a controller whose own spring, held over each step, is unstable.
#[test]
fn diverging_implicit_runs_are_reported() {
    let model = Model::new(finger()).unwrap();
    let mut controller = |_: f64, q: &[f64], v: &[f64], tau: &mut [f64]| -> Result<(), ControllerError> {
        tau[0] = -400.0 * q[0] - 0.1 * v[0];
        Ok(())
    };
    let mut simulation = SimulationBuilder::new(&model).method(Method::Implicit).dt(5e-3).build().unwrap();
    let ended =
        simulation.run_steps_from(&[0.1], &[0.0], 2000, RunOptions::new().controller(&mut controller));
    let error = ended.unwrap_err().error;
    let RunError::Diverged { coordinate, cause, .. } = &error else { panic!("{error}") };
    assert_eq!((coordinate.as_str(), *cause), ("bend", DivergenceCause::Unknown));
}

/// Adaptive steps follow a growing motion and end when its digits are lost.
#[test]
#[cfg(feature = "adaptive")]
fn diverging_adaptive_runs_are_reported() {
    let mut robot = finger();
    robot.joints[0].passive = PassiveForces::default().with_damping(-1e-3);
    let model = Model::new(robot).unwrap();
    let options = robot_dynamics::simulation::AdaptiveOptions::default();
    let mut simulation = SimulationBuilder::new(&model).adaptive(options).dt(1000.0).build().unwrap();
    let error = simulation.run_steps_from(&[0.0], &[1e-3], 1, RunOptions::new()).unwrap_err().error;
    let RunError::Step { time, ref source, .. } = error else { panic!("{error}") };
    let robot_dynamics::simulation::StepError::Diverged { coordinate, speed, step } = source else {
        panic!("{error}")
    };
    assert!(coordinate == "bend" && speed.abs() * step > 1e8 && (0.1..100.0).contains(&time), "{error}");
}

/// A diverging state of a batch is invalid, and the error of its run gives the cause.
#[test]
fn diverging_states_of_batches_are_reported() {
    let mut robot = finger();
    robot.joints[0].passive = PassiveForces::default().with_damping(2.0);
    let model = Model::new(robot).unwrap();
    let builder = SimulationBuilder::new(&model).dt(5e-3).method(Method::Fixed(Integrator::RungeKutta4));
    let mut batch = SimulationBatch::new(&builder.build().unwrap(), 3, &Threads::start(2).unwrap());
    // The first two are at rest at the pose where gravity has no moment.
    for (simulation, speed) in batch.simulations_mut().iter_mut().zip([0.0, 0.0, 1e-3]) {
        simulation.reset(&[core::f64::consts::FRAC_PI_2], &[speed]).unwrap();
    }
    let failed = batch.step(400, &AtomicBool::new(false));
    let error = &failed.last().expect("a state that grows").1;
    assert_eq!(failed.last().unwrap().0, 2);
    let RunError::Diverged { coordinate, suggested_step, .. } = error else { panic!("{error}") };
    assert!(coordinate == "bend" && *suggested_step < 5e-3, "{error}");
}
