//! The analytic A and B of implicit steps with closed loops, couplings, and limits of ball joints and of
//! spatial tendons, against central differences of the same steps.
//!
//! A state off the equalities has another derivative, so the perturbed states are ends of steps under
//! perturbed forces.

use nalgebra::{DMatrix, DVector, Matrix3, Vector3};
use robot_dynamics::algorithms::mass_matrix;
use robot_dynamics::derivatives::{LinearizationMethod, LinearizedStep, RobotState, linearize_stepper};
use robot_dynamics::description::{
    FrameDescription, JointDescription, JointKind, Limits, LinkDescription, MassProperties, Pose,
    RobotDescription, SpatialTendonDescription, TendonPathElement,
};
use robot_dynamics::model::{Model, difference, neutral};
use robot_dynamics::simulation::{
    Method, SimulationBuilder, SimulationStepper, StepForces, StepWorkspace, Stepper,
};

const H: f64 = 1e-3;

/// The increment of a velocity by a force in one step \[rad/s, m/s\].
const MOVE: f64 = 1e-5;

/// A state with the stepper that has led to it.
#[derive(Clone)]
struct State {
    q: Vec<f64>,
    v: Vec<f64>,
    stepper: SimulationStepper,
}

impl State {
    fn next(&self, model: &Model, tau: &[f64]) -> Self {
        let mut next = self.clone();
        let w = &mut StepWorkspace::new(model);
        next.stepper.step(model, w, &StepForces::new(tau, true), H, &mut next.q, &mut next.v).unwrap();
        next
    }

    /// The displacement to another state.
    fn way_to(&self, model: &Model, other: &Self) -> DVector<f64> {
        let mut way = vec![0.0; model.nv()];
        difference(model, &self.q, &other.q, &mut way);
        way.extend(other.v.iter().zip(&self.v).map(|(other, own)| other - own));
        DVector::from_vec(way)
    }
}

/// The method of the derivatives of the second step from a state, and the largest difference from central
/// differences, relative to the change of the state.
fn compare(model: &Model, start: &State, tau: &[f64]) -> (LinearizationMethod, f64) {
    let (nv, w) = (model.nv(), &mut StepWorkspace::new(model));
    let mut mass = vec![0.0; nv * nv];
    mass_matrix(model, w.dynamics(), &start.q, &mut mass);
    let mut middle = start.next(model, tau);
    let end = middle.next(model, tau);
    let (mut a, mut b) = (vec![0.0; 4 * nv * nv], vec![0.0; 2 * nv * nv]);
    let out = LinearizedStep { by_state: &mut a, by_force: &mut b };
    let (forces, state) =
        (StepForces::new(tau, true), RobotState { q: &middle.q.clone(), v: &middle.v.clone() });
    let method = linearize_stepper(model, &mut middle.stepper, w, &forces, H, state, out).unwrap();
    let (a, b) = (DMatrix::from_row_slice(2 * nv, 2 * nv, &a), DMatrix::from_row_slice(2 * nv, nv, &b));
    let mut worst = 0.0_f64;
    for k in 0..nv {
        let unit = mass[k * (nv + 1)] / H;
        let [after, before] = [1.0, -1.0].map(|sign| {
            let mut tau = tau.to_vec();
            tau[k] += sign * MOVE * unit;
            tau
        });
        // By the state: both steps start with the forces of the unperturbed one.
        let from =
            [&after, &before].map(|tau| State { stepper: middle.stepper.clone(), ..start.next(model, tau) });
        let [to_after, to_before] = from.clone().map(|from| end.way_to(model, &from.next(model, tau)));
        let [from_after, from_before] = from.map(|from| middle.way_to(model, &from));
        let expected = (to_after - to_before) / (2.0 * MOVE);
        let found = &a * (from_after - from_before) / (2.0 * MOVE);
        let size = expected.amax().max(1.0);
        worst = worst.max((found - expected).amax() / size);
        // By the force.
        let [to_after, to_before] = [after, before].map(|tau| end.way_to(model, &middle.next(model, &tau)));
        let expected = (to_after - to_before) / (2.0 * MOVE);
        worst = worst.max((b.column(k) * unit - expected).amax());
    }
    (method, worst)
}

/// Takes steps under these forces, and compares at every `each`-th.
fn check(name: &str, model: &Model, state: State, tau: &[f64], (steps, each): (usize, usize)) {
    let mut state = state;
    for step in 0..steps {
        if step % each == each - 1 {
            let (method, off) = compare(model, &state, tau);
            assert_eq!(method, LinearizationMethod::Analytic { at_transition: false }, "{name}, step {step}");
            assert!(off < 1e-6, "{name}, step {step}: {off:e}");
        }
        state = state.next(model, tau);
    }
}

fn start(model: &Model, q: Vec<f64>, v: Vec<f64>) -> State {
    let stepper = SimulationBuilder::new(model).method(Method::Implicit).build().unwrap().stepper();
    State { q, v, stepper }
}

/// The linkages move under their weight and a force on the first coordinate.
#[test]
fn loops_and_couplings_have_analytic_derivatives() {
    for name in ["linkage.xml", "hand.xml"] {
        let path = format!("{}/../../robots/{name}", env!("CARGO_MANIFEST_DIR"));
        let mut robot = robot_dynamics::load(&path).unwrap().model.description().clone();
        robot.joints.iter_mut().for_each(|joint| joint.limits = Limits::default());
        let model = Model::new(robot).unwrap();
        let mut tau = vec![0.0; model.nv()];
        tau[0] = 0.1;
        let state = start(&model, neutral(&model), vec![0.0; model.nv()]);
        check(name, &model, state, &tau, (200, 50));
    }
}

/// A body of 2 kg at 0.5 m on a ball joint.
fn hanging(most: f64) -> RobotDescription {
    let mut robot = RobotDescription::new("hanging");
    let at = Vector3::new(0.0, 0.0, 0.5);
    let body = MassProperties::new(2.0, at, Matrix3::identity() * 1e-2).unwrap();
    robot.links.push(LinkDescription::new("world", None));
    robot.links.push(LinkDescription::new("body", body));
    let mut limits = Limits::default();
    limits.turn = most;
    let ball = JointDescription::new("ball", JointKind::Spherical, "world", "body", Pose::IDENTITY);
    robot.joints.push(ball.with_limits(limits));
    robot
}

/// A pendulum at the limit of its ball joint slides along it.
#[test]
fn limit_of_a_ball_joint_has_analytic_derivatives() {
    let most = 0.4_f64;
    let model = Model::new(hanging(most)).unwrap();
    let half = (0.5 * most).sin();
    let state = start(&model, vec![0.6 * half, 0.8 * half, 0.0, (0.5 * most).cos()], vec![0.0; 3]);
    check("ball", &model, state, &[0.2, -0.3, 0.1], (120, 40));
}

/// A ball swings on a rope of 1 m.
#[test]
fn taut_rope_has_analytic_derivatives() {
    let mut robot = RobotDescription::new("ball on a rope");
    robot.links.push(LinkDescription::new("world", None));
    robot.frames.push(FrameDescription::new("hook", "world", Pose::IDENTITY));
    let mass = MassProperties::new(2.0, Vector3::zeros(), Matrix3::identity() * 2e-3).unwrap();
    robot.links.push(LinkDescription::new("ball", mass));
    let joint = JointDescription::new("free", JointKind::Floating, "world", "ball", Pose::IDENTITY);
    robot.joints.push(joint);
    let path = ["hook", "ball"].map(|frame| TendonPathElement::Point { frame: frame.into() });
    let mut rope = SpatialTendonDescription::new("rope", path.to_vec());
    rope.limits = Limits::new(f64::NEG_INFINITY, 1.0);
    robot.spatial_tendons.push(rope);
    let model = Model::new(robot).unwrap();
    let mut q = neutral(&model);
    (q[0], q[2]) = (0.6, -0.8);
    let mut v = vec![0.0; 6];
    (v[1], v[4]) = (0.5, 0.3);
    check("rope", &model, start(&model, q, v), &[0.1, 0.2, 0.0, 1e-3, 0.0, 0.0], (120, 40));
}
