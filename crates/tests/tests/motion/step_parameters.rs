//! The derivatives of implicit steps by friction, inertial parameters and controls, against closed forms and
//! against central differences of the same steps.

use nalgebra::{DMatrix, DVector};
use robot_dynamics::algorithms::inertial_parameters;
use robot_dynamics::contact::Ground;
use robot_dynamics::derivatives::{
    LinearizationMethod, LinearizedStep, LinearizedStepWithParameters, RobotState,
    linearize_stepper_with_parameters, parameter_values, with_parameters,
};
use robot_dynamics::description::Shape;
use robot_dynamics::model::{Model, difference, neutral};
use robot_dynamics::simulation::{
    Method, Simulation, SimulationBuilder, SimulationStepper, StepError, StepForces, StepWorkspace, Stepper,
};

use crate::free_body::body;

const H: f64 = 1e-3;

/// A state with the stepper that has led to it.
struct State {
    q: Vec<f64>,
    v: Vec<f64>,
    tau: Vec<f64>,
    stepper: SimulationStepper,
}

/// The derivatives by controls, inertial parameters and friction.
struct Derivatives {
    method: LinearizationMethod,
    by_control: DMatrix<f64>,
    by_inertial: DMatrix<f64>,
    by_friction: DVector<f64>,
}

impl State {
    fn new(simulation: &Simulation, (q, v): (Vec<f64>, Vec<f64>), steps: usize) -> Self {
        let model = simulation.shared_model().clone();
        let (mut state, w) = (
            Self { tau: vec![0.0; v.len()], q, v, stepper: simulation.stepper() },
            &mut StepWorkspace::new(&model),
        );
        for _ in 0..steps {
            let forces = StepForces::new(&state.tau, true);
            state.stepper.step(&model, w, &forces, H, &mut state.q, &mut state.v).unwrap();
        }
        state
    }

    fn derivatives(&mut self, model: &Model) -> Derivatives {
        let (nv, w) = (model.nv(), &mut StepWorkspace::new(model));
        let (links, controls) = (10 * model.moving_links().count(), self.stepper.control_count());
        let matrix = |columns: usize| vec![0.0; 2 * nv * columns];
        let (mut a, mut b) = (matrix(2 * nv), matrix(nv));
        let (mut by_control, mut by_inertial, mut by_friction) = (matrix(controls), matrix(links), matrix(1));
        let out = LinearizedStepWithParameters {
            step: LinearizedStep { by_state: &mut a, by_force: &mut b },
            by_control: &mut by_control,
            by_inertial: &mut by_inertial,
            by_friction: &mut by_friction,
        };
        let (forces, state) = (StepForces::new(&self.tau, true), RobotState { q: &self.q, v: &self.v });
        let stepper = &mut self.stepper;
        let method = linearize_stepper_with_parameters(model, stepper, w, &forces, H, state, out).unwrap();
        Derivatives {
            method,
            by_control: DMatrix::from_row_slice(2 * nv, controls, &by_control),
            by_inertial: DMatrix::from_row_slice(2 * nv, links, &by_inertial),
            by_friction: DVector::from_vec(by_friction),
        }
    }

    /// The state after one step by another stepper.
    fn end(&self, model: &Model, stepper: &SimulationStepper) -> (Vec<f64>, Vec<f64>) {
        let (mut q, mut v, w) = (self.q.clone(), self.v.clone(), &mut StepWorkspace::new(model));
        let forces = StepForces::new(&self.tau, true);
        stepper.clone().step(model, w, &forces, H, &mut q, &mut v).unwrap();
        (q, v)
    }
}

/// The difference of two ends, divided by `by`.
fn quotient(
    model: &Model,
    after: &(Vec<f64>, Vec<f64>),
    before: &(Vec<f64>, Vec<f64>),
    by: f64,
) -> DVector<f64> {
    let mut way = vec![0.0; model.nv()];
    difference(model, &before.0, &after.0, &mut way);
    way.extend(after.1.iter().zip(&before.1).map(|(after, before)| after - before));
    DVector::from_vec(way) / by
}

const ANALYTIC: LinearizationMethod = LinearizationMethod::Analytic { at_transition: false };

fn on_ground(model: &Model, friction: f64) -> Simulation {
    let ground = Ground::level(0.0).with_friction(friction);
    SimulationBuilder::new(model).method(Method::Implicit).ground(ground).build().unwrap()
}

/// A block that slides loses μ g h of its speed in a step, and one that sticks does not depend on μ. Its mass
/// cancels.
#[test]
fn sliding_block_loses_speed_with_its_friction() {
    let model = Model::new(body(8e-3, Shape::Box { size: [0.4, 0.3, 0.2] })).unwrap();
    let mut q = neutral(&model);
    q[2] = 0.1;
    for (speed, expected) in [(1.0, -9.81 * H), (0.0, 0.0)] {
        let start = (q.clone(), vec![0.0, speed, 0.0, 0.0, 0.0, 0.0]);
        // Without forces of earlier steps.
        let mut state = State::new(&on_ground(&model, 0.4), start, 0);
        let found = state.derivatives(&model);
        assert_eq!(found.method, ANALYTIC);
        assert!((found.by_friction[7] - expected).abs() < 1e-9, "{}", found.by_friction[7]);
        assert!((found.by_friction[1] - 0.5 * H * expected).abs() < 1e-11);
        assert!(found.by_inertial.column(0).amax() < 1e-9, "{}", found.by_inertial.column(0));
    }
}

/// The same derivatives by differences: steps with other friction, and of robots with other parameters. Both
/// start with the same state and without earlier forces.
///
/// The contact solver is accurate to 1e-10 of the speeds, which the increments of 1e-4 divide.
#[test]
fn derivatives_by_friction_and_inertia_are_those_of_differences() {
    for (name, shape, height) in [
        ("sphere", Shape::Sphere { radius: 0.1 }, 0.1),
        ("capsule", Shape::Capsule { radius: 0.1, length: 0.3 }, 0.25),
    ] {
        // The differences have an error of the square of the increment relative to the inertia.
        let model = Model::new(body(0.4, shape)).unwrap();
        let (mut q, v) = (neutral(&model), vec![0.7, 0.2, 0.0, 0.1, 0.0, 0.5]);
        q[2] = height;
        let settled = State::new(&on_ground(&model, 0.6), (q, v), 40);
        let start = (settled.q, settled.v);
        let mut state = State::new(&on_ground(&model, 0.6), start, 0);
        state.tau = vec![0.3, 0.1, 0.0, 0.01, 0.0, 0.02];
        let found = state.derivatives(&model);
        assert_eq!(found.method, ANALYTIC, "{name}");
        let by = 1e-4;
        let [after, before] =
            [0.6 + by, 0.6 - by].map(|friction| state.end(&model, &on_ground(&model, friction).stepper()));
        let expected = quotient(&model, &after, &before, 2.0 * by);
        let off = (&found.by_friction - &expected).amax();
        assert!(off < 1e-6, "{name}: {off:e} of {}", expected.amax());
        let values = parameter_values(&model);
        for k in 0..10 {
            let ends = [by, -by].map(|by| {
                let mut values = values.clone();
                values[k] += by;
                let other = Model::new(with_parameters(&model, &values).unwrap()).unwrap();
                (state.end(&other, &on_ground(&other, 0.6).stepper()), other)
            });
            let expected = quotient(&model, &ends[0].0, &ends[1].0, 2.0 * by);
            let off = (found.by_inertial.column(k) - &expected).amax();
            assert!(off < 2e-6 * expected.amax().max(1.0), "{name}, {k}: {off:e} of {}", expected.amax());
        }
        assert_eq!(inertial_parameters(&model).len(), found.by_inertial.ncols());
    }
}

/// The arm's servos, and its friction: derivatives by every control and every inertial parameter.
#[test]
fn derivatives_of_an_arm_are_those_of_differences() {
    let path = format!("{}/../../robots/arm.xml", env!("CARGO_MANIFEST_DIR"));
    let model = Model::new(robot_dynamics::load(&path).unwrap().model.description().clone()).unwrap();
    let build = |model: &Model, change: &[f64]| {
        let mut simulation = SimulationBuilder::new(model).method(Method::Implicit).build().unwrap();
        let controls: Vec<f64> = change.iter().enumerate().map(|(k, x)| 0.1 + 0.05 * k as f64 + x).collect();
        simulation.set_controls(&controls);
        simulation
    };
    let controls = SimulationBuilder::new(&model).method(Method::Implicit).build().unwrap().controls().len();
    let none = vec![0.0; controls];
    let nv = model.nv();
    let settled = State::new(&build(&model, &none), (neutral(&model), vec![0.3; nv]), 20);
    let mut state = State::new(&build(&model, &none), (settled.q, settled.v), 0);
    let found = state.derivatives(&model);
    assert_eq!(found.method, ANALYTIC);
    let mut acting = 0;
    for k in 0..controls {
        let by = 1e-4;
        let [after, before] = [by, -by].map(|by| {
            let mut change = none.clone();
            change[k] = by;
            state.end(&model, &build(&model, &change).stepper())
        });
        let expected = quotient(&model, &after, &before, 2.0 * by);
        let off = (found.by_control.column(k) - &expected).amax();
        assert!(off < 1e-6 * expected.amax().max(1e-3), "control {k}: {off:e} of {}", expected.amax());
        acting += usize::from(expected.amax() > 1e-6);
    }
    assert!(acting > 0, "{controls} controls");
    let values = parameter_values(&model);
    for k in 0..found.by_inertial.ncols() {
        let by = 1e-5;
        let [after, before] = [by, -by].map(|by| {
            let mut values = values.clone();
            values[k] += by;
            let other = Model::new(with_parameters(&model, &values).unwrap()).unwrap();
            state.end(&other, &build(&other, &none).stepper())
        });
        let expected = quotient(&model, &after, &before, 2.0 * by);
        let off = (found.by_inertial.column(k) - &expected).amax();
        assert!(off < 1e-6 * expected.amax().max(1.0), "parameter {k}: {off:e} of {}", expected.amax());
    }
}

/// Steps by differences have no derivatives by parameters.
#[test]
fn methods_without_derivatives_by_parameters_are_refused() {
    let model = Model::new(body(8e-3, Shape::Sphere { radius: 0.1 })).unwrap();
    let simulation = SimulationBuilder::new(&model).method(Method::Mujoco).build().unwrap();
    let (mut a, mut b, mut by_friction) = ([0.0; 144], [0.0; 72], [1.0; 12]);
    let step = LinearizedStep { by_state: &mut a, by_force: &mut b };
    let out = LinearizedStepWithParameters {
        step,
        by_control: &mut [],
        by_inertial: &mut [],
        by_friction: &mut by_friction,
    };
    let (q, v, w) = (neutral(&model), vec![0.0; 6], &mut StepWorkspace::new(&model));
    let (forces, state) = (StepForces::new(&[0.0; 6], true), RobotState { q: &q, v: &v });
    let stepper = &mut simulation.stepper();
    let refused = linearize_stepper_with_parameters(&model, stepper, w, &forces, H, state, out);
    assert!(matches!(refused, Err(StepError::ParametersNotDifferentiable { .. })), "{refused:?}");
    assert_eq!(by_friction, [1.0; 12]);
}
