//! Derivatives of residuals, costs and dynamics against central differences along the manifold.

use std::sync::Arc;

use robot_dynamics::algorithms::ReferenceFrame;
use robot_dynamics::control::optimal::{
    Activation, ActuationMatrix, CenterOfMassResidual, ControlResidual, Cost, CostExpansion,
    DifferentiatedResidual, DiscreteDynamics, FramePlacementResidual, FrameRotationResidual,
    FrameTranslationResidual, FrameVelocityResidual, LeastSquares, LinearizedDynamics, Residual,
    ResidualFunction, ResidualJacobian, SmoothStep, StateResidual, StateSpace,
};
use robot_dynamics::description::Pose;
use robot_dynamics::model::{Model, RandomState, random_state};
use robot_dynamics::number::{Scalar, SplitMix64};
use robot_dynamics::simulation::Integrator;

use super::floating_tree;

/// The step of central differences; the error is about its square, and rounding over it.
pub(super) const STEP: f64 = 1e-5;

/// Differences of numbers of size 1 to 10 are right to about nine digits.
const TOLERANCE: f64 = 1e-7;

pub(super) fn random_x(model: &Model, random: &mut SplitMix64) -> Vec<f64> {
    let RandomState { q, v, .. } = random_state(model, random);
    q.into_iter().chain(v).collect()
}

/// Column `k` of the derivative of `f` by central differences along δx.
pub(super) fn difference_by_state(
    space: &StateSpace,
    x: &[f64],
    k: usize,
    mut f: impl FnMut(&[f64]) -> Vec<f64>,
) -> Vec<f64> {
    let mut at = |h: f64| {
        let (mut displacement, mut moved) = (vec![0.0; space.tangent()], x.to_vec());
        displacement[k] = h;
        space.integrate(x, &displacement, &mut moved);
        f(&moved)
    };
    let (above, below) = (at(STEP), at(-STEP));
    above.iter().zip(below).map(|(a, b)| (a - b) / (2.0 * STEP)).collect()
}

#[derive(Clone)]
struct Mixed;

impl ResidualFunction for Mixed {
    fn dimension(&self) -> usize {
        2
    }
    fn evaluate<S: Scalar>(&self, q: &[S], v: &[S], u: &[S], residual: &mut [S]) {
        let squares = q.iter().fold(S::zero(), |sum, q| sum + *q * *q * *q);
        residual[0] = squares * v[0] + u[0].sin_cos().0;
        residual[1] = q[3] * q[4] + v[1] * u[1];
    }
}

fn check_residual(space: &StateSpace, residual: &mut dyn Residual, x: &[f64], u: &[f64], name: &str) {
    let (n, m, rows) = (space.tangent(), u.len(), residual.dimension());
    let (mut by_x, mut by_u) = (vec![0.0; rows * n], vec![0.0; rows * m]);
    let mut values = vec![0.0; rows];
    let jacobian = ResidualJacobian { by_state: &mut by_x, by_control: &mut by_u };
    residual.linearize(x, u, &mut values, jacobian).expect("derivatives");
    let mut again = vec![0.0; rows];
    residual.evaluate(x, u, &mut again).expect("values");
    assert_eq!(values, again, "{name}");
    let mut evaluate = |x: &[f64], u: &[f64]| {
        let mut values = vec![0.0; rows];
        residual.evaluate(x, u, &mut values).expect("values");
        values
    };
    for k in 0..n {
        let column = difference_by_state(space, x, k, |x| evaluate(x, u));
        for i in 0..rows {
            let off = (column[i] - by_x[i * n + k]).abs();
            assert!(off < TOLERANCE, "{name} [{i}, {k}]: {} {}", column[i], by_x[i * n + k]);
        }
    }
    for k in 0..m {
        let mut at = |h: f64| {
            let mut moved = u.to_vec();
            moved[k] += h;
            evaluate(x, &moved)
        };
        let (above, below) = (at(STEP), at(-STEP));
        for i in 0..rows {
            let off = ((above[i] - below[i]) / (2.0 * STEP) - by_u[i * m + k]).abs();
            assert!(off < TOLERANCE, "{name} [{i}, u {k}]");
        }
    }
}

#[test]
fn jacobians_of_residuals_are_their_derivatives() {
    for seed in 1..5 {
        let model = floating_tree(seed);
        let (space, mut random) = (StateSpace::robot(model.clone()), SplitMix64::new(seed));
        let (x, reference) = (random_x(&model, &mut random), random_x(&model, &mut random));
        let frame = model.frame_named(&model.frames()[model.frames().len() - 1].name).expect("a frame");
        let u: Vec<f64> = (0..3).map(|_| random.uniform(-1.0, 1.0)).collect();
        let target = Pose::exp([0.1, 0.2, -0.3], [0.4, -0.5, 0.2]);
        let robot = || model.clone();
        let mut residuals: Vec<(&str, Box<dyn Residual>)> = vec![
            ("state", Box::new(StateResidual::new(&space, &reference).expect("a state"))),
            ("control", Box::new(ControlResidual::new(&[0.1, 0.2, 0.3]).expect("controls"))),
            (
                "translation",
                Box::new(FrameTranslationResidual::new(robot(), frame, [0.1; 3]).expect("a point")),
            ),
            (
                "rotation",
                Box::new(FrameRotationResidual::new(robot(), frame, target.rotation).expect("axes")),
            ),
            ("placement", Box::new(FramePlacementResidual::new(robot(), frame, target).expect("a pose"))),
            ("centre of mass", Box::new(CenterOfMassResidual::new(robot(), [0.1; 3]).expect("a point"))),
            ("dual numbers", Box::new(DifferentiatedResidual::new(&space, Some(3), Mixed))),
        ];
        for axes in ReferenceFrame::ALL {
            let velocity = FrameVelocityResidual::new(robot(), frame, axes, [0.1; 6]).expect("a velocity");
            residuals.push(("velocity", Box::new(velocity)));
        }
        for (name, residual) in &mut residuals {
            check_residual(&space, residual.as_mut(), &x, &u, name);
        }
    }
}

/// The gradient of a cost, and its Hessian where the residual is linear.
#[test]
fn gradients_of_costs_are_their_derivatives() {
    let model = floating_tree(3);
    let (space, mut random) = (StateSpace::robot(model.clone()), SplitMix64::new(8));
    let (x, u) = (random_x(&model, &mut random), [0.4, -0.6]);
    let n = space.tangent();
    let mut cost = Cost::new();
    cost.add(StateResidual::new(&space, &random_x(&model, &mut random)).expect("a state"), 0.3)
        .expect("weights");
    let limits = Activation::QuadraticBarrier { lower: vec![-0.1, f64::NEG_INFINITY], upper: vec![0.1, 0.0] };
    let barrier = LeastSquares::new(ControlResidual::new(&[0.0; 2]).expect("controls"), vec![2.0, 3.0]);
    cost.add_term(barrier.and_then(|term| term.with_activation(limits)).expect("a barrier"));
    let (mut lx, mut lu) = (vec![0.0; n], vec![0.0; 2]);
    let (mut lxx, mut lux, mut luu) = (vec![0.0; n * n], vec![0.0; 2 * n], vec![0.0; 4]);
    let expansion = CostExpansion {
        state_gradient: &mut lx,
        control_gradient: &mut lu,
        state_hessian: &mut lxx,
        cross_hessian: &mut lux,
        control_hessian: &mut luu,
    };
    let value = cost.expand(&x, &u, expansion).expect("an expansion");
    assert_eq!(value, cost.value(&x, &u).expect("a value"));
    for k in 0..n {
        let column = difference_by_state(&space, &x, k, |x| vec![cost.value(x, &u).expect("a value")]);
        assert!((column[0] - lx[k]).abs() < TOLERANCE, "{k}: {} {}", column[0], lx[k]);
    }
    // 0.4 is above its interval by 0.3, −0.6 is within its own.
    assert!((lu[0] - 2.0 * 0.3).abs() < 1e-15 && lu[1] == 0.0);
    assert_eq!(luu, [2.0, 0.0, 0.0, 0.0]);
}

#[test]
fn derivatives_of_smooth_steps_are_those_of_their_map() {
    let model = floating_tree(2);
    let (space, mut random) = (StateSpace::robot(model.clone()), SplitMix64::new(4));
    let x = random_x(&model, &mut random);
    let nv = model.nv();
    let entries: Vec<f64> = (0..nv * 2).map(|_| random.uniform(-1.0, 1.0)).collect();
    let gears = ActuationMatrix::new(nv, 2, &entries).expect("a matrix");
    let step = SmoothStep::new(Arc::clone(&model), Integrator::SemiImplicitEuler, 0.01).expect("a step");
    let mut step = step.with_actuation(gears).expect("a matrix");
    let (n, u) = (2 * nv, [0.3, -0.2]);
    let (mut a, mut b) = (vec![0.0; n * n], vec![0.0; n * 2]);
    let out = LinearizedDynamics { by_state: &mut a, by_control: &mut b };
    step.linearize(&x, &u, out).expect("derivatives");
    let mut centre = x.clone();
    step.step(&x, &u, &mut centre).expect("a step");
    let mut from_centre = |x: &[f64], u: &[f64]| {
        let (mut next, mut displacement) = (x.to_vec(), vec![0.0; n]);
        step.step(x, u, &mut next).expect("a step");
        space.difference(&centre, &next, &mut displacement);
        displacement
    };
    for k in 0..n {
        let column = difference_by_state(&space, &x, k, |x| from_centre(x, &u));
        assert!((0..n).all(|i| (column[i] - a[i * n + k]).abs() < 1e-6), "{k}");
    }
    for k in 0..2 {
        let mut at = |h: f64| {
            let mut moved = u;
            moved[k] += h;
            from_centre(&x, &moved)
        };
        let (above, below) = (at(STEP), at(-STEP));
        assert!((0..n).all(|i| ((above[i] - below[i]) / (2.0 * STEP) - b[i * 2 + k]).abs() < 1e-6), "{k}");
    }
}
