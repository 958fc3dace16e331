//! Costs: sums of terms with their gradients and Hessians.

use robot_dynamics_number::InvalidInput;
use robot_dynamics_simulation::StepError;

use super::dynamics::ContactForces;
use super::residual::{Residual, ResidualInputs, ResidualJacobian};

/// A term ℓ(x, u) of a cost, with its gradient and a positive semidefinite approximation of its Hessian.
///
/// At the terminal node u is empty. An implementation owns its scratch memory; each thread of a solver works
/// on a clone.
pub trait CostTerm: Send {
    /// The sizes of x and u that it expects.
    fn expects(&self) -> ResidualInputs;

    /// ℓ(x, u).
    ///
    /// # Errors
    /// [`StepError`] if it cannot be computed.
    fn value(&mut self, x: &[f64], u: &[f64]) -> Result<f64, StepError>;

    /// Adds the derivatives to those of the other terms; returns ℓ(x, u).
    ///
    /// # Errors
    /// [`StepError`] if they cannot be computed.
    fn add_expansion(
        &mut self,
        x: &[f64],
        u: &[f64],
        expansion: &mut CostExpansion<'_>,
    ) -> Result<f64, StepError>;

    /// Takes the forces that the node's dynamics computed, for a term that reads forces.
    fn reuse(&mut self, _forces: &ContactForces<'_>) {}

    /// A clone in a box.
    fn boxed_clone(&self) -> Box<dyn CostTerm>;
}

impl Clone for Box<dyn CostTerm> {
    fn clone(&self) -> Self {
        (**self).boxed_clone()
    }
}

/// The derivatives of a cost at (x, u), by displacements δx (n numbers) and by u (m numbers). Matrices are
/// row-major.
#[derive(Debug)]
pub struct CostExpansion<'a> {
    /// ℓₓ, n.
    pub state_gradient: &'a mut [f64],
    /// ℓᵤ, m.
    pub control_gradient: &'a mut [f64],
    /// ℓₓₓ, n×n.
    pub state_hessian: &'a mut [f64],
    /// ℓᵤₓ, m×n.
    pub cross_hessian: &'a mut [f64],
    /// ℓᵤᵤ, m×m.
    pub control_hessian: &'a mut [f64],
}

/// The weights of the entries of a residual: one number for all, or one each.
#[derive(Clone, Debug, PartialEq)]
pub enum Weights {
    /// One weight for all entries.
    Uniform(f64),
    /// One weight for each entry.
    Diagonal(Vec<f64>),
}

impl From<f64> for Weights {
    fn from(weight: f64) -> Self {
        Self::Uniform(weight)
    }
}

impl From<Vec<f64>> for Weights {
    fn from(weights: Vec<f64>) -> Self {
        Self::Diagonal(weights)
    }
}

impl From<&[f64]> for Weights {
    fn from(weights: &[f64]) -> Self {
        Self::Diagonal(weights.to_vec())
    }
}

/// The scalar function of each entry of a residual.
#[derive(Clone, Debug, Default, PartialEq)]
#[non_exhaustive]
pub enum Activation {
    /// ½ r².
    #[default]
    Quadratic,
    /// ½ (distance of r from the interval)², a soft limit.
    QuadraticBarrier {
        /// The lower end of each interval; may be infinite.
        lower: Vec<f64>,
        /// The upper end of each interval; may be infinite.
        upper: Vec<f64>,
    },
}

impl Activation {
    /// The number whose square is penalized: r, or its part outside the interval.
    fn excess(&self, index: usize, r: f64) -> f64 {
        match self {
            Self::Quadratic => r,
            Self::QuadraticBarrier { lower, upper } => {
                (r - upper[index]).max(0.0) + (r - lower[index]).min(0.0)
            }
        }
    }
}

/// ½ Σ wᵢ a(rᵢ)², with a(r) = r, or the excess of r over an interval. Its Hessian is that of Gauss and
/// Newton, Σ wᵢ ∇rᵢ ∇rᵢᵀ.
#[derive(Clone)]
pub struct LeastSquares {
    residual: Box<dyn Residual>,
    weights: Vec<f64>,
    activation: Activation,
    values: Vec<f64>,
    by_state: Vec<f64>,
    by_control: Vec<f64>,
}

impl LeastSquares {
    /// A term with weights: a number, or one for each entry of the residual.
    ///
    /// # Errors
    /// [`InvalidInput`] if the number of weights differs from the residual's, or a weight is negative or not
    /// finite.
    pub fn new(residual: impl Residual + 'static, weights: impl Into<Weights>) -> Result<Self, InvalidInput> {
        let n = residual.dimension();
        let weights = match weights.into() {
            Weights::Uniform(weight) => vec![weight; n],
            Weights::Diagonal(weights) => weights,
        };
        check_count("weights", weights.len(), n)?;
        if let Some(index) = weights.iter().position(|w| !(*w >= 0.0 && w.is_finite())) {
            let quantity = format!("weight {index}");
            return Err(InvalidInput::out_of_range(quantity, weights[index], "", "0 or above, and finite"));
        }
        let residual = Box::new(residual);
        let (by_state, by_control) = (Vec::new(), Vec::new());
        let activation = Activation::Quadratic;
        Ok(Self { residual, weights, activation, values: vec![0.0; n], by_state, by_control })
    }

    /// The same term with another activation.
    ///
    /// # Errors
    /// [`InvalidInput`] if the intervals of a barrier are not one for each entry, or are empty.
    pub fn with_activation(mut self, activation: Activation) -> Result<Self, InvalidInput> {
        if let Activation::QuadraticBarrier { lower, upper } = &activation {
            check_count("lower ends", lower.len(), self.weights.len())?;
            check_count("upper ends", upper.len(), self.weights.len())?;
            if let Some(index) = (0..lower.len()).find(|&i| !is_ordered(lower[i], upper[i])) {
                let ends = format!("is from {} to {}; it must not be empty", lower[index], upper[index]);
                return Err(InvalidInput::unmet(format!("interval {index} of the barrier"), ends));
            }
        }
        self.activation = activation;
        Ok(self)
    }
}

/// Whether an interval has a point; false if an end is NaN.
fn is_ordered(lower: f64, upper: f64) -> bool {
    lower <= upper
}

fn check_count(quantity: &str, found: usize, expected: usize) -> Result<(), InvalidInput> {
    if found == expected {
        return Ok(());
    }
    let counts = format!("of a residual with {expected} entries are {found}; give one for each entry");
    Err(InvalidInput::unmet(format!("the {quantity}"), counts))
}

impl CostTerm for LeastSquares {
    fn expects(&self) -> ResidualInputs {
        self.residual.expects()
    }

    fn value(&mut self, x: &[f64], u: &[f64]) -> Result<f64, StepError> {
        self.residual.evaluate(x, u, &mut self.values)?;
        let terms = self.values.iter().zip(&self.weights).enumerate();
        Ok(0.5 * terms.map(|(i, (r, w))| w * self.activation.excess(i, *r).powi(2)).sum::<f64>())
    }

    fn add_expansion(
        &mut self,
        x: &[f64],
        u: &[f64],
        expansion: &mut CostExpansion<'_>,
    ) -> Result<f64, StepError> {
        let (n, m, rows) = (expansion.state_gradient.len(), u.len(), self.weights.len());
        for (jacobian, columns) in [(&mut self.by_state, n), (&mut self.by_control, m)] {
            jacobian.clear();
            jacobian.resize(rows * columns, 0.0);
        }
        let jacobian = ResidualJacobian { by_state: &mut self.by_state, by_control: &mut self.by_control };
        self.residual.linearize(x, u, &mut self.values, jacobian)?;
        let mut sum = 0.0;
        for i in 0..rows {
            let excess = self.activation.excess(i, self.values[i]);
            let (weight, is_active) =
                (self.weights[i], self.activation == Activation::Quadratic || excess != 0.0);
            sum += 0.5 * weight * excess * excess;
            if is_active && weight != 0.0 {
                let by_x = &self.by_state[i * n..(i + 1) * n];
                let by_u = &self.by_control[i * m..(i + 1) * m];
                expansion.add_square(weight, excess, by_x, by_u);
            }
        }
        Ok(sum)
    }

    fn reuse(&mut self, forces: &ContactForces<'_>) {
        self.residual.reuse(forces);
    }

    fn boxed_clone(&self) -> Box<dyn CostTerm> {
        Box::new(self.clone())
    }
}

impl CostExpansion<'_> {
    /// Adds the gradient w r ∇r and the Hessian w ∇r ∇rᵀ of ½ w r², skipping the zeros of ∇r.
    pub fn add_square(&mut self, weight: f64, r: f64, by_state: &[f64], by_control: &[f64]) {
        let (n, m) = (by_state.len(), by_control.len());
        add_rows(weight, by_state, by_state, self.state_hessian, n);
        add_rows(weight, by_control, by_state, self.cross_hessian, n);
        add_rows(weight, by_control, by_control, self.control_hessian, m);
        for (gradient, by) in
            [(&mut *self.state_gradient, by_state), (&mut *self.control_gradient, by_control)]
        {
            gradient.iter_mut().zip(by).for_each(|(to, by)| *to += weight * r * by);
        }
    }

    pub(super) fn clear(&mut self) {
        let Self { state_gradient, control_gradient, state_hessian, cross_hessian, control_hessian } = self;
        for part in [state_gradient, control_gradient, state_hessian, cross_hessian, control_hessian] {
            part.fill(0.0);
        }
    }
}

/// Adds w a bᵀ to a matrix with `width` columns.
fn add_rows(weight: f64, a: &[f64], b: &[f64], matrix: &mut [f64], width: usize) {
    if width == 0 || b.iter().all(|x| *x == 0.0) {
        return;
    }
    for (row, a) in matrix.chunks_exact_mut(width).zip(a).filter(|(_, a)| **a != 0.0) {
        row.iter_mut().zip(b).for_each(|(to, b)| *to += weight * a * b);
    }
}

/// A cost ℓ(x, u): the sum of its terms.
///
/// The terms of a running cost count at each node; a cost per second takes weights multiplied by the step.
///
/// ```
/// use robot_dynamics::control::optimal::{ControlResidual, Cost};
/// let mut cost = Cost::new();
/// cost.add(ControlResidual::new(&[1.0, 0.0])?, vec![2.0, 4.0])?;
/// assert_eq!(cost.value(&[], &[2.0, 3.0])?, 0.5 * (2.0 + 4.0 * 9.0));
/// # Ok::<(), Box<dyn std::error::Error>>(())
/// ```
#[derive(Clone, Default)]
#[doc(alias = "CostModelSum")]
pub struct Cost {
    terms: Vec<Box<dyn CostTerm>>,
}

impl Cost {
    /// The cost 0.
    pub fn new() -> Self {
        Self::default()
    }

    /// Adds ½ Σ wᵢ rᵢ².
    ///
    /// # Errors
    /// As [`LeastSquares::new`].
    pub fn add(
        &mut self,
        residual: impl Residual + 'static,
        weights: impl Into<Weights>,
    ) -> Result<&mut Self, InvalidInput> {
        Ok(self.add_term(LeastSquares::new(residual, weights)?))
    }

    /// Adds a term of any form.
    pub fn add_term(&mut self, term: impl CostTerm + 'static) -> &mut Self {
        self.terms.push(Box::new(term));
        self
    }

    /// ℓ(x, u).
    ///
    /// # Errors
    /// [`StepError`] of a term.
    pub fn value(&mut self, x: &[f64], u: &[f64]) -> Result<f64, StepError> {
        self.terms.iter_mut().try_fold(0.0, |sum, term| Ok(sum + term.value(x, u)?))
    }

    /// Writes the derivatives; returns ℓ(x, u).
    ///
    /// # Errors
    /// [`StepError`] of a term.
    pub fn expand(
        &mut self,
        x: &[f64],
        u: &[f64],
        mut expansion: CostExpansion<'_>,
    ) -> Result<f64, StepError> {
        expansion.clear();
        self.terms.iter_mut().try_fold(0.0, |sum, term| Ok(sum + term.add_expansion(x, u, &mut expansion)?))
    }

    /// Hands the forces of the node's dynamics to the terms.
    pub(super) fn reuse(&mut self, forces: &ContactForces<'_>) {
        self.terms.iter_mut().for_each(|term| term.reuse(forces));
    }

    /// The terms.
    pub(super) fn terms(&self) -> &[Box<dyn CostTerm>] {
        &self.terms
    }
}
