//! Controllers that own their robot, moved into a thread or a struct, give the torques of borrowing
//! controllers.

use std::sync::Arc;
use std::thread;

use robot_dynamics::InputProblem;
use robot_dynamics::algorithms::MotionError;
use robot_dynamics::control::{ComputedTorque, PoseReference, Reference, TaskControl, TaskGains};
use robot_dynamics::description::{JointKinds, Pose, RandomRobotOptions, random_robot};
use robot_dynamics::model::{FrameId, Model};
use robot_dynamics::simulation::{Controller, ControllerError, GravityAt, GravityCompensatedPd};

const Q: [f64; 7] = [0.4, -0.3, 0.2, 0.5, -0.1, 0.3, 0.2];
const V: [f64; 7] = [0.1, 0.2, -0.3, 0.4, 0.0, -0.1, 0.2];
const GAINS: TaskGains = TaskGains { stiffness: 100.0, damping: 20.0, null_damping: 10.0 };

fn arm() -> (Arc<Model>, FrameId) {
    let options =
        RandomRobotOptions { joints: 7, kinds: JointKinds::Turning, chain: 1.0, ..Default::default() };
    let model = Model::new(random_robot(4, &options)).unwrap();
    let hand = model.frame_named(&model.frames()[model.frames().len() - 1].name).unwrap();
    (Arc::new(model), hand)
}

fn ahead(t: f64) -> Reference {
    Reference { q: Q.map(|q| q + t).to_vec(), v: vec![1.0; 7], a: vec![0.5; 7] }
}

fn here(_: f64) -> PoseReference {
    PoseReference::at_rest(Pose::from_translation([0.1, 0.2, 0.3]))
}

fn asked(control: &mut impl Controller) -> [f64; 7] {
    let mut tau = [0.0; 7];
    control.torque(0.1, &Q, &V, &mut tau).unwrap_or_else(|error| panic!("{error}"));
    tau
}

/// The torque is equal bit for bit for a borrowed model, a shared pointer in another thread, and an owned
/// model.
#[track_caller]
fn all_agree<A, B, C>(mut borrowing: A, sharing: B, mut own: C)
where
    A: Controller,
    B: Controller + Send + 'static,
    C: Controller,
{
    let expected = asked(&mut borrowing);
    assert!(expected.iter().any(|tau| tau.abs() > 1e-3), "nothing to compare: {expected:?}");
    let mut sharing = sharing;
    let found = thread::spawn(move || asked(&mut sharing)).join().expect("the thread ends");
    assert_eq!((found, asked(&mut own)), (expected, expected));
}

#[test]
fn pd_works_in_another_thread() {
    let (model, _) = arm();
    let (target, kp, kd) = ([0.2; 7], [30.0; 7], [3.0; 7]);
    for at in [GravityAt::Target, GravityAt::State] {
        all_agree(
            GravityCompensatedPd::new(&model, &target, &kp, &kd).unwrap().with_gravity_at(at),
            GravityCompensatedPd::owning(Arc::clone(&model), &target, &kp, &kd).unwrap().with_gravity_at(at),
            GravityCompensatedPd::owning(Model::clone(&model), &target, &kp, &kd)
                .unwrap()
                .with_gravity_at(at),
        );
    }
    let tight = GravityCompensatedPd::owning(model, &target, &kp, &kd).unwrap().with_limits(&[0.0; 7]);
    assert!(!tight.overloaded_coordinates().is_empty());
}

#[test]
fn computed_torque_works_in_another_thread() {
    let (model, _) = arm();
    let (kp, kd) = ([100.0; 7], [20.0; 7]);
    all_agree(
        ComputedTorque::new(&model, ahead, &kp, &kd).unwrap().with_dissipation(),
        ComputedTorque::owning(Arc::clone(&model), ahead, &kp, &kd).unwrap().with_dissipation(),
        ComputedTorque::owning(Model::clone(&model), ahead, &kp, &kd).unwrap().with_dissipation(),
    );
}

#[test]
fn task_control_works_in_another_thread() {
    let (model, hand) = arm();
    all_agree(
        TaskControl::new(&model, hand, here, GAINS).unwrap().with_posture(&Q, 25.0).unwrap(),
        TaskControl::owning(Arc::clone(&model), hand, here, GAINS).unwrap().with_posture(&Q, 25.0).unwrap(),
        TaskControl::owning(Model::clone(&model), hand, here, GAINS).unwrap().with_posture(&Q, 25.0).unwrap(),
    );
}

/// A struct without a lifetime can hold both.
#[test]
fn struct_holds_robot_and_controller() {
    struct Station {
        model: Arc<Model>,
        control: GravityCompensatedPd<Arc<Model>>,
    }
    let (model, _) = arm();
    let control = GravityCompensatedPd::owning(Arc::clone(&model), &Q, &[1.0; 7], &[1.0; 7]).unwrap();
    let mut station = Station { model, control };
    assert!(Arc::strong_count(&station.model) == 2);
    assert_ne!(asked(&mut station.control), [0.0; 7]);
}

/// Invalid gains give the errors of the borrowing constructors.
#[test]
fn invalid_gains_are_errors() {
    let (model, hand) = arm();
    let error = GravityCompensatedPd::owning(Arc::clone(&model), &Q, &[f64::NAN; 7], &[1.0; 7]).unwrap_err();
    let ControllerError::Motion(MotionError::Input(error)) = error else { panic!("{error}") };
    assert_eq!(error.quantity, "the stiffness");
    assert!(matches!(error.problem, InputProblem::NotFinite { index: Some(0), .. }), "{error}");
    let error =
        ComputedTorque::owning(Arc::clone(&model), ahead, &[1.0; 6], &[1.0; 7]).err().expect("an error");
    let ControllerError::Motion(MotionError::Input(error)) = error else { panic!("{error}") };
    assert_eq!(error.quantity, "the stiffness");
    assert!(matches!(error.problem, InputProblem::WrongLength { found: 6, expected: 7, .. }), "{error}");
    let gains = TaskGains { damping: f64::INFINITY, ..GAINS };
    let error = TaskControl::owning(model, hand, here, gains).err().expect("an error");
    let ControllerError::Motion(MotionError::Input(error)) = error else { panic!("{error}") };
    assert_eq!(error.quantity, "the damping");
    let (index, coordinate, value) = (None, None, f64::INFINITY);
    assert_eq!(error.problem, InputProblem::NotFinite { index, coordinate, value });
}
