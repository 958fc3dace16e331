//! The gradients of rollouts with contact, stops and friction against differences of whole rollouts.

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
        Self { name, stepper, q, v, tau, steps: 60, weights, model }
    }

    /// Takes steps until the contacts have settled.
    fn settle(mut self, steps: usize) -> Self {
        let w = &mut StepWorkspace::new(&self.model);
        let forces = StepForces::new(&self.tau, true);
        for _ in 0..steps {
            self.stepper.step(&self.model, w, &forces, H, &mut self.q, &mut self.v).unwrap();
        }
        self
    }

    fn end(&self, (q, v, tau): (&[f64], &[f64], &[f64])) -> (Vec<f64>, Vec<f64>) {
        let (mut q, mut v, mut stepper) = (q.to_vec(), v.to_vec(), self.stepper.clone());
        let (w, forces) = (&mut StepWorkspace::new(&self.model), StepForces::new(tau, true));
        for _ in 0..self.steps {
            stepper.step(&self.model, w, &forces, H, &mut q, &mut v).unwrap();
        }
        (q, v)
    }

    /// The gradients by q, v and τ, one after the other.
    fn gradient(&self, spacing: usize) -> (Vec<f64>, LinearizedSteps) {
        let nv = self.model.nv();
        let rollout = StepperRollout::new(&self.stepper, H, self.steps);
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
        ("box", Shape::Box { size: [0.4, 0.3, 0.2] }, 0.1),
        ("sphere", Shape::Sphere { radius: 0.1 }, 0.1),
        ("capsule", Shape::Capsule { radius: 0.1, length: 0.3 }, 0.25),
    ] {
        let model = Model::new(body(8e-3, shape)).unwrap();
        let (mut q, v) = (neutral(&model), vec![0.7, 0.2, 0.0, 0.0, 0.0, 0.5]);
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

#[test]
fn gradients_are_those_of_differences() {
    for case in cases() {
        let (gradient, counts) = case.gradient(0);
        println!("{}: {counts:?}", case.name);
        let size = gradient.iter().fold(1.0_f64, |most, x| most.max(x.abs()));
        for (column, own) in gradient.iter().enumerate() {
            let by = if column < 2 * case.model.nv() { 1e-6 } else { 1e-4 };
            let [after, before] = case.quotients(column, by);
            let off = (0.5 * (after + before) - own).abs() / size;
            println!("  {column}: {own:.9} {after:.9} {before:.9} {off:.1e}");
        }
    }
}
