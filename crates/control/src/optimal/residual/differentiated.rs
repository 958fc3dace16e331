//! Residuals of the user's formula, differentiated by dual numbers.

use robot_dynamics_core::configuration::retraction::move_along;
use robot_dynamics_number::{Dual, Scalar};
use robot_dynamics_simulation::StepError;

use super::{Residual, ResidualInputs, ResidualJacobian};
use crate::optimal::StateSpace;

/// A formula r(q, v, u) over any number type, which [`DifferentiatedResidual`] differentiates.
///
/// For plain numbers as states, q is empty and v is x.
pub trait ResidualFunction: Clone + Send + 'static {
    /// The number of entries of r.
    fn dimension(&self) -> usize;

    /// Writes r(q, v, u). At the terminal node u is empty.
    fn evaluate<S: Scalar>(&self, q: &[S], v: &[S], u: &[S], residual: &mut [S]);
}

/// The derivatives that one evaluation computes.
const WIDTH: usize = 4;

/// The residual of a [`ResidualFunction`]; its derivatives come from dual numbers and are exact to rounding.
///
/// ```
/// use robot_dynamics::control::optimal::{DifferentiatedResidual, Residual, ResidualFunction};
/// use robot_dynamics::control::optimal::{ResidualJacobian, StateSpace};
/// use robot_dynamics::number::Scalar;
/// #[derive(Clone)]
/// struct Power;
/// impl ResidualFunction for Power {
///     fn dimension(&self) -> usize {
///         1
///     }
///     fn evaluate<S: Scalar>(&self, _q: &[S], v: &[S], u: &[S], residual: &mut [S]) {
///         residual[0] = v[0] * u[0];
///     }
/// }
/// let mut power = DifferentiatedResidual::new(&StateSpace::vector(1), Some(1), Power);
/// let (mut r, mut by_x, mut by_u) = ([0.0], [0.0], [0.0]);
/// let jacobian = ResidualJacobian { by_state: &mut by_x, by_control: &mut by_u };
/// power.linearize(&[3.0], &[5.0], &mut r, jacobian)?;
/// assert_eq!((r, by_x, by_u), ([15.0], [5.0], [3.0]));
/// # Ok::<(), Box<dyn std::error::Error>>(())
/// ```
#[derive(Clone, Debug)]
pub struct DifferentiatedResidual<F> {
    space: StateSpace,
    controls: Option<usize>,
    function: F,
    /// q, v and δq with their derivatives, u, r.
    x: Vec<Dual<f64, WIDTH>>,
    start: Vec<Dual<f64, WIDTH>>,
    displacement: Vec<Dual<f64, WIDTH>>,
    u: Vec<Dual<f64, WIDTH>>,
    residual: Vec<Dual<f64, WIDTH>>,
}

impl<F: ResidualFunction> DifferentiatedResidual<F> {
    /// The residual of a formula on states of a space. `controls` is the number of controls on which it
    /// depends, `None` if it does not depend on u.
    pub fn new(space: &StateSpace, controls: Option<usize>, function: F) -> Self {
        let zeros = |n: usize| vec![Dual::constant(0.0); n];
        Self {
            x: zeros(space.coordinates()),
            start: zeros(space.coordinates()),
            displacement: zeros(space.tangent()),
            u: zeros(controls.unwrap_or(0)),
            residual: zeros(function.dimension()),
            space: space.clone(),
            controls,
            function,
        }
    }

    fn nq(&self) -> usize {
        self.space.model().map_or(0, |model| model.nq())
    }

    /// Evaluates r with the derivatives by the entries `first`… of (δx, u).
    fn evaluate_along(&mut self, x: &[f64], u: &[f64], first: usize) {
        let (nq, n) = (self.nq(), self.space.tangent());
        let seed = |value: f64, k: usize| match k.checked_sub(first) {
            Some(k) if k < WIDTH => Dual::variable(value, k),
            _ => Dual::constant(value),
        };
        for (k, d) in self.displacement.iter_mut().enumerate() {
            *d = seed(0.0, k);
        }
        self.start.iter_mut().zip(x).for_each(|(to, x)| *to = Dual::constant(*x));
        let nv = n - (self.x.len() - nq);
        if let Some(model) = self.space.model() {
            move_along(model, &self.start[..nq], &self.displacement[..nv], &mut self.x[..nq]);
        }
        for (k, to) in self.x[nq..].iter_mut().enumerate() {
            *to = seed(x[nq + k], nv + k);
        }
        for (k, (to, u)) in self.u.iter_mut().zip(u).enumerate() {
            *to = seed(*u, n + k);
        }
        let (q, v) = self.x.split_at(nq);
        self.function.evaluate(q, v, &self.u, &mut self.residual);
    }
}

impl<F: ResidualFunction> Residual for DifferentiatedResidual<F> {
    fn dimension(&self) -> usize {
        self.residual.len()
    }

    fn expects(&self) -> ResidualInputs {
        ResidualInputs { coordinates: Some(self.space.coordinates()), controls: self.controls }
    }

    fn evaluate(&mut self, x: &[f64], u: &[f64], residual: &mut [f64]) -> Result<(), StepError> {
        let (q, v) = x.split_at(self.nq());
        self.function.evaluate(q, v, &u[..self.u.len()], residual);
        Ok(())
    }

    fn linearize(
        &mut self,
        x: &[f64],
        u: &[f64],
        residual: &mut [f64],
        jacobian: ResidualJacobian<'_>,
    ) -> Result<(), StepError> {
        let (n, m) = (self.space.tangent(), self.u.len());
        for first in (0..n + m).step_by(WIDTH) {
            self.evaluate_along(x, u, first);
            for (i, r) in self.residual.iter().enumerate() {
                for (k, &derivative) in r.gradient.iter().enumerate() {
                    match first + k {
                        column if column < n => jacobian.by_state[i * n + column] = derivative,
                        column if column < n + m => jacobian.by_control[i * m + column - n] = derivative,
                        _ => {}
                    }
                }
            }
        }
        self.evaluate(x, u, residual)
    }

    fn boxed_clone(&self) -> Box<dyn Residual> {
        Box::new(self.clone())
    }
}
