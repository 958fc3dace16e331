//! The gradients of rollouts with contact, stops and friction against differences of whole rollouts.

use robot_dynamics::batch::{self, BatchOptions, BatchWorkspace, RolloutPullbackInputs, Torques};
use robot_dynamics::contact::Ground;
use robot_dynamics::derivatives::{
    LinearizedSteps, MotionCotangents, RobotState, StepperPullbackWorkspace, StepperRollout,
    TrajectoryCotangents, rollout_pullback_by_stepper,
};
use robot_dynamics::description::{Base, Limits, Shape};
use robot_dynamics::model::{Model, difference, integrate, neutral};
use robot_dynamics::number::SplitMix64;
use robot_dynamics::simulation::{
    Method, SimulationBuilder, SimulationStepper, StepForces, StepWorkspace, Stepper,
};

use crate::free_body::body;

const H: f64 = 1e-3;

/// A rollout with its loss, the sum of weights · (q_N ⊖ q_ref, v_N).
struct Case {
    name: &'static str,
    model: Model,
    stepper: SimulationStepper,
    q: Vec<f64>,
    v: Vec<f64>,
    tau: Vec<f64>,
    steps: usize,
    restarts: bool,
    weights: Vec<f64>,
}

impl Case {
    fn new(
        name: &'static str,
        model: Model,
        ground: bool,
        (q, v, tau): (Vec<f64>, Vec<f64>, Vec<f64>),
    ) -> Self {
        let mut builder = SimulationBuilder::new(&model).method(Method::Implicit);
        if ground {
            builder = builder.ground(Ground::level(0.0).with_friction(0.6));
        }
        let stepper = builder.build().unwrap().stepper();
        let mut random = SplitMix64::new(3);
        let weights = (0..2 * model.nv()).map(|_| random.uniform(-1.0, 1.0)).collect();
        Self { name, stepper, q, v, tau, steps: 20, restarts: false, weights, model }
    }

    /// Takes steps until the contacts have settled, and forgets their forces.
    fn settle(mut self, steps: usize) -> Self {
        let (w, fresh) = (&mut StepWorkspace::new(&self.model), self.stepper.clone());
        let forces = StepForces::new(&self.tau, true);
        for _ in 0..steps {
            self.stepper.step(&self.model, w, &forces, H, &mut self.q, &mut self.v).unwrap();
        }
        self.stepper = fresh;
        self
    }

    fn end(&self, (q, v, tau): (&[f64], &[f64], &[f64])) -> (Vec<f64>, Vec<f64>) {
        let (mut q, mut v, mut stepper) = (q.to_vec(), v.to_vec(), self.stepper.clone());
        let (w, forces) = (&mut StepWorkspace::new(&self.model), StepForces::new(tau, true));
        for _ in 0..self.steps {
            if self.restarts {
                stepper.clone_from(&self.stepper);
            }
            stepper.step(&self.model, w, &forces, H, &mut q, &mut v).unwrap();
        }
        (q, v)
    }

    /// The gradients by q, v and τ, one after the other.
    fn gradient(&self, spacing: usize) -> (Vec<f64>, LinearizedSteps) {
        let nv = self.model.nv();
        let rollout = StepperRollout::new(&self.stepper, H, self.steps);
        let rollout = if self.restarts { rollout.with_restarts() } else { rollout };
        let workspace = &mut StepperPullbackWorkspace::new(&self.model, spacing);
        let (mut by_q, mut by_v) = (self.weights[..nv].to_vec(), self.weights[nv..].to_vec());
        let mut by_tau = vec![0.0; nv];
        let cotangents = MotionCotangents {
            by_position: &mut by_q,
            by_velocity: &mut by_v,
            by_force: &mut by_tau,
            parameters: &mut [],
        };
        let (state, trajectory) = (RobotState { q: &self.q, v: &self.v }, TrajectoryCotangents::default());
        let counts = rollout_pullback_by_stepper(
            &self.model,
            &rollout,
            workspace,
            state,
            &self.tau,
            trajectory,
            cotangents,
        )
        .unwrap();
        by_q.extend(by_v);
        by_q.extend(by_tau);
        (by_q, counts)
    }

    /// The one-sided difference quotients of the loss in one coordinate of (q, v, τ).
    fn quotients(&self, column: usize, by: f64) -> [f64; 2] {
        let nv = self.model.nv();
        let middle = self.end((&self.q, &self.v, &self.tau));
        [by, -by].map(|by| {
            let (mut way, mut v, mut tau) = (vec![0.0; nv], self.v.clone(), self.tau.clone());
            match column / nv {
                0 => way[column] = by,
                1 => v[column - nv] += by,
                _ => tau[column - 2 * nv] += by,
            }
            let mut q = self.q.clone();
            integrate(&self.model, &self.q, &way, &mut q);
            let end = self.end((&q, &v, &tau));
            let mut moved = vec![0.0; nv];
            difference(&self.model, &middle.0, &end.0, &mut moved);
            moved.extend(end.1.iter().zip(&middle.1).map(|(end, middle)| end - middle));
            moved.iter().zip(&self.weights).map(|(x, weight)| x * weight).sum::<f64>() / by
        })
    }
}

fn file(name: &str) -> Model {
    let path = format!("{}/../../robots/{name}", env!("CARGO_MANIFEST_DIR"));
    let mut robot = robot_dynamics::load(&path).unwrap().model.description().clone();
    if name == "humanoid.urdf" {
        robot.base = Base::Floating;
    }
    robot.joints.iter_mut().for_each(|joint| joint.limits = Limits::default());
    Model::new(robot).unwrap()
}

fn cases() -> Vec<Case> {
    let mut cases = Vec::new();
    for (name, shape, height) in [
        // Its corners would slide in different directions if it turned.
        ("box", Shape::Box { size: [0.4, 0.3, 0.2] }, 0.1),
        ("sphere", Shape::Sphere { radius: 0.1 }, 0.1),
        ("capsule", Shape::Capsule { radius: 0.1, length: 0.3 }, 0.25),
    ] {
        let model = Model::new(body(8e-3, shape)).unwrap();
        let (mut q, v) =
            (neutral(&model), vec![0.7, 0.2, 0.0, 0.0, 0.0, if name == "box" { 0.0 } else { 0.5 }]);
        q[2] = height;
        cases.push(Case::new(name, model, true, (q, v, vec![0.3, 0.1, 0.0, 0.0, 0.0, 0.0])).settle(40));
    }
    let model = file("panda.urdf");
    let tau = (0..model.nv()).map(|k| 3.0 - k as f64).collect();
    let state = (neutral(&model), vec![0.1; model.nv()], tau);
    cases.push(Case::new("panda", model, false, state).settle(40));
    let model = file("quadruped.xml");
    let mut q = neutral(&model);
    q[2] = 0.4;
    let (v, tau) = (vec![0.0; model.nv()], vec![0.0; model.nv()]);
    cases.push(Case::new("quadruped", model, false, (q, v, tau)).settle(300));
    cases
}

/// The largest difference of the gradient from central differences, relative to its size, in the columns
/// whose quotients of both sides agree, and the number of those columns.
fn compare(case: &Case) -> (f64, usize) {
    let (gradient, counts) = case.gradient(0);
    assert_eq!((counts.analytic, counts.differences), (case.steps, 0), "{}", case.name);
    let size = gradient.iter().fold(1.0_f64, |most, x| most.max(x.abs()));
    let (mut worst, mut smooth) = (0.0_f64, 0);
    for (column, own) in gradient.iter().enumerate() {
        let by = if column < 2 * case.model.nv() { 1e-6 } else { 1e-4 };
        let [after, before] = case.quotients(column, by);
        if (after - before).abs() < 2e-5 * size {
            smooth += 1;
            worst = worst.max((0.5 * (after + before) - own).abs() / size);
        }
    }
    (worst, smooth)
}

/// Steps without the forces of the step before. Where a contact opens or closes the differences mix both
/// sides, and such columns are left out. The contact solver is accurate to 1e-10 of the speeds, which the
/// increment of 1e-6 divides.
#[test]
fn gradients_are_those_of_differences() {
    for mut case in cases().into_iter().filter(|case| ["sphere", "panda"].contains(&case.name)) {
        case.restarts = true;
        let (off, smooth) = compare(&case);
        assert!(off < 1e-5, "{}: {off:e}", case.name);
        assert!(2 * smooth >= 3 * case.model.nv(), "{}: {smooth} smooth columns", case.name);
    }
}

/// The forces that one step passes to the next are of second order in the step, and count as constant.
#[test]
fn forces_of_the_step_before_have_a_small_part_in_gradients() {
    for case in cases().into_iter().filter(|case| ["sphere", "panda"].contains(&case.name)) {
        let (off, _) = compare(&case);
        assert!(off < if case.name == "panda" { 1e-7 } else { 1e-3 }, "{}: {off:e}", case.name);
    }
}

/// x = t²/2m (F − μ m g) of a block that slides on the ground, so ∂x/∂F = t²/2m.
#[test]
fn sliding_block_follows_the_closed_form() {
    let model = Model::new(body(8e-3, Shape::Box { size: [0.4, 0.3, 0.2] })).unwrap();
    let mut q = neutral(&model);
    q[2] = 0.1;
    let (v, tau) = (vec![0.3, 0.0, 0.0, 0.0, 0.0, 0.0], vec![7.0, 0.0, 0.0, 0.0, 0.0, 0.0]);
    let mut case = Case::new("block", model, true, (q, v, tau));
    case.weights.fill(0.0);
    case.weights[0] = 1.0;
    case.restarts = true;
    let (gradient, _) = case.gradient(0);
    let time = case.steps as f64 * H;
    // The solver is accurate to 1e-10 of the speeds.
    assert!((gradient[12] - 0.5 * time * time).abs() < 1e-9, "{}", gradient[12]);
    assert!((gradient[0] - 1.0).abs() < 1e-9 && (gradient[6] - time).abs() < 1e-9);
}

#[test]
fn checkpoints_do_not_change_a_bit() {
    let case = &cases()[1];
    let (expected, _) = case.gradient(0);
    for spacing in [1, 7, case.steps] {
        assert_eq!(case.gradient(spacing).0, expected, "{spacing}");
    }
}

/// The gradient by the states of a trajectory is the sum of the gradients of the rollouts that end there, and
/// those of batches are those of single states, bit for bit.
#[test]
fn trajectories_and_batches_are_sums_and_rows() {
    let mut case = cases().remove(1);
    case.steps = 10;
    let (nv, w) = (case.model.nv(), &mut StepperPullbackWorkspace::new(&case.model, 3));
    let (by_q, by_v) = case.weights.split_at(nv);
    let whole = case.gradient(0).0;
    case.steps = 5;
    let half = case.gradient(0).0;
    let rollout = StepperRollout::new(&case.stepper, H, 10).with_stride(5);
    let (on_q, on_v) = (by_q.repeat(2), by_v.repeat(2));
    let trajectory = TrajectoryCotangents { by_position: &on_q, by_velocity: &on_v };
    let mut found = [(); 3].map(|()| vec![0.0; nv]);
    let [by_position, by_velocity, by_force] = &mut found;
    let cotangents = MotionCotangents { by_position, by_velocity, by_force, parameters: &mut [] };
    let state = RobotState { q: &case.q, v: &case.v };
    rollout_pullback_by_stepper(&case.model, &rollout, w, state, &case.tau, trajectory, cotangents).unwrap();
    for (found, (whole, half)) in found.concat().iter().zip(whole.iter().zip(&half)) {
        // Ten steps round ten times.
        assert!((found - whole - half).abs() < 1e-13 * (1.0 + whole.abs() + half.abs()), "{found}");
    }
    for threads in [1, 3] {
        let mut options = BatchOptions::default();
        options.threads = threads;
        let workspace = &BatchWorkspace::with_options(&case.model, options).unwrap();
        let (q, v, tau) = (case.q.repeat(4), case.v.repeat(4), case.tau.repeat(4));
        let (on_q, on_v) = (on_q.repeat(4), on_v.repeat(4));
        let trajectory = TrajectoryCotangents { by_position: &on_q, by_velocity: &on_v };
        let torques = Torques::Held(&tau);
        let inputs = RolloutPullbackInputs { spacing: 0, torques, q: &q, v: &v, trajectory };
        let mut many = [(); 3].map(|()| vec![0.0; 4 * nv]);
        let [by_position, by_velocity, by_force] = &mut many;
        let cotangents = MotionCotangents { by_position, by_velocity, by_force, parameters: &mut [] };
        let counts =
            batch::rollout_pullback_by_stepper(&case.model, workspace, &rollout, &inputs, cotangents, None)
                .unwrap();
        assert_eq!(counts.analytic, 40);
        for (many, one) in many.iter().zip(&found) {
            assert_eq!(*many, one.repeat(4));
        }
    }
}
