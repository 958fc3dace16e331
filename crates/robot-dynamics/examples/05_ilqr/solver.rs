//! iLQR with bounded controls and an exact goal.
//!
//! min Σₖ ½(xₖ−x*)ᵀQ(xₖ−x*) + ½(uₖ−u*)ᵀR(uₖ−u*) with xₖ₊₁ = f(xₖ, uₖ), |uₖ| ≤ limit, x_N = x*.
//!
//! The backward pass computes the cost to go, a quadratic form V of δx, from A = ∂f/∂x and B = ∂f/∂u. Each
//! control minimizes its own quadratic form within the limits. The forward pass computes the motion with u +
//! αk + K δx, clamped. **(Tassa, Mansard, Todorov, ICRA 2014)** The goal is enforced by ½eᵀSe + λᵀe with e =
//! x_N − x*. After each convergence λ ← λ + S e (augmented Lagrangian).

use std::error::Error;

use nalgebra::{DMatrix, DVector};

use super::box_qp::box_minimum;

/// A controlled system in discrete time.
pub(crate) trait Plant {
    /// f(x, u).
    fn step(&mut self, x: &DVector<f64>, u: &DVector<f64>) -> Result<DVector<f64>, Box<dyn Error>>;
    /// A = ∂f/∂x and B = ∂f/∂u.
    #[allow(clippy::type_complexity)] // two matrices
    fn linearize(
        &mut self,
        x: &DVector<f64>,
        u: &DVector<f64>,
    ) -> Result<(DMatrix<f64>, DMatrix<f64>), Box<dyn Error>>;
}

/// The task. Weights are the diagonals of Q, R and S.
#[derive(Clone, Debug)]
pub(crate) struct Task {
    /// x₀.
    pub(crate) start: DVector<f64>,
    /// x*.
    pub(crate) goal: DVector<f64>,
    /// u*: the control with zero cost.
    pub(crate) rest: DVector<f64>,
    /// The largest |uᵢ|.
    pub(crate) limit: DVector<f64>,
    /// Q.
    pub(crate) state_weight: DVector<f64>,
    /// R.
    pub(crate) control_weight: DVector<f64>,
    /// S.
    pub(crate) end_weight: DVector<f64>,
    /// N.
    pub(crate) steps: usize,
    /// The goal is reached if max |e| is at most this.
    pub(crate) goal_tolerance: f64,
}

/// A motion, with statistics of the solver.
#[derive(Clone, Debug)]
pub(crate) struct Plan {
    /// x₀ … x_N.
    pub(crate) x: Vec<DVector<f64>>,
    /// u₀ … u_{N−1}.
    pub(crate) u: Vec<DVector<f64>>,
    /// K₀ … K_{N−1}: u + K δx corrects a disturbed motion. Rows of active limits are zero.
    pub(crate) gains: Vec<DMatrix<f64>>,
    /// λ, the multipliers of the goal.
    pub(crate) multipliers: DVector<f64>,
    /// The cost without the terms of the goal.
    pub(crate) cost: f64,
    /// The number of backward passes.
    pub(crate) iterations: usize,
    /// The number of updates of λ.
    pub(crate) renewals: usize,
}

/// The largest number of backward passes.
const MOST_ITERATIONS: usize = 2000;
/// Convergence: the next step would decrease the cost by less than this fraction.
const SETTLED: f64 = 1e-12;
/// The first and last value of μ, which adds μR to Q_uu if no step decreases the cost.
const REGULARIZATION: (f64, f64) = (1e-3, 1e12);

/// The result of one backward pass.
struct Policy {
    /// k.
    offsets: Vec<DVector<f64>>,
    /// K.
    gains: Vec<DMatrix<f64>>,
    /// kᵀQ_u and ½kᵀQ_uu k: the cost changes by α times the first plus α² times the second.
    change: [f64; 2],
}

/// The next smaller μ.
fn lowered(mu: f64) -> f64 {
    if mu > REGULARIZATION.0 { mu / 10.0 } else { 0.0 }
}

impl Task {
    /// Finds a motion, starting from the controls `u`.
    pub(crate) fn solve(&self, plant: &mut dyn Plant, u: Vec<DVector<f64>>) -> Result<Plan, Box<dyn Error>> {
        let mut multipliers = DVector::zeros(self.goal.len());
        let mut x = self.roll_out(plant, &u)?;
        let mut u = u;
        let (mut mu, mut iterations, mut renewals) = (0.0, 0, 0);
        loop {
            if iterations == MOST_ITERATIONS {
                let off = (&x[self.steps] - &self.goal).amax();
                return Err(format!(
                    "after {iterations} iterations the motion still ends {off:.1e} from the goal or has not \
                     settled; give it more time or torque"
                )
                .into());
            }
            iterations += 1;
            let policy = self.backward(plant, &x, &u, &multipliers, mu)?;
            let before = self.total(&x, &u, &multipliers);
            let expected = -(policy.change[0] + policy.change[1]);
            let off = &x[self.steps] - &self.goal;
            let nothing = SETTLED * before.abs().max(1e-9);
            let off_cost = off.component_mul(&self.end_weight).dot(&off);
            // λ is updated when the possible decrease is small relative to the cost of the distance from the
            // goal.
            let is_far = off.amax() > 0.1 * self.goal_tolerance;
            let enough = if is_far { nothing.max(1e-3 * off_cost) } else { nothing };
            if expected <= enough {
                if mu > 0.0 {
                    // The decrease can be small because a large μ limits the change of the controls.
                    mu = lowered(mu);
                } else if expected <= nothing && off.amax() <= self.goal_tolerance {
                    let (cost, gains) = (self.running(&x, &u), policy.gains);
                    return Ok(Plan { x, u, gains, multipliers, cost, iterations, renewals });
                } else {
                    multipliers += off.component_mul(&self.end_weight);
                    renewals += 1;
                }
                continue;
            }
            if let Some((next_x, next_u)) = self.search(plant, &x, &u, &policy, &multipliers, before) {
                (x, u) = (next_x, next_u);
                mu = lowered(mu);
            } else if mu < REGULARIZATION.1 {
                mu = (10.0 * mu).max(REGULARIZATION.0);
            } else {
                return Err(format!("no step lowers the cost of {before:.6e} any more").into());
            }
        }
    }

    /// u with each entry clamped to its limit.
    pub(crate) fn clamped(&self, u: &DVector<f64>) -> DVector<f64> {
        u.zip_map(&self.limit, |u, limit| u.clamp(-limit, limit))
    }

    /// x₀ … x_N under u₀ … u_{N−1}.
    fn roll_out(
        &self,
        plant: &mut dyn Plant,
        u: &[DVector<f64>],
    ) -> Result<Vec<DVector<f64>>, Box<dyn Error>> {
        let mut x = vec![self.start.clone()];
        for (k, u) in u.iter().enumerate() {
            x.push(plant.step(&x[k], u)?);
        }
        Ok(x)
    }

    /// Σ ½(x−x*)ᵀQ(x−x*) + ½(u−u*)ᵀR(u−u*).
    pub(crate) fn running(&self, x: &[DVector<f64>], u: &[DVector<f64>]) -> f64 {
        let square = |a: &DVector<f64>, b: &DVector<f64>, w: &DVector<f64>| {
            let d = a - b;
            0.5 * d.component_mul(w).dot(&d)
        };
        let stage =
            |(x, u)| square(x, &self.goal, &self.state_weight) + square(u, &self.rest, &self.control_weight);
        x.iter().zip(u).map(stage).sum()
    }

    /// The running cost and ½eᵀSe + λᵀe.
    pub(crate) fn total(&self, x: &[DVector<f64>], u: &[DVector<f64>], multipliers: &DVector<f64>) -> f64 {
        let off = &x[self.steps] - &self.goal;
        let end = 0.5 * off.component_mul(&self.end_weight).dot(&off) + multipliers.dot(&off);
        self.running(x, u) + end
    }

    /// From the end to the start: Q_u = l_u + BᵀV_x, Q_uu = R + BᵀV_xx B, Q_ux = BᵀV_xx A, …
    fn backward(
        &self,
        plant: &mut dyn Plant,
        x: &[DVector<f64>],
        u: &[DVector<f64>],
        multipliers: &DVector<f64>,
        mu: f64,
    ) -> Result<Policy, Box<dyn Error>> {
        let (q, r) =
            (DMatrix::from_diagonal(&self.state_weight), DMatrix::from_diagonal(&self.control_weight));
        let off = &x[self.steps] - &self.goal;
        let mut slope = off.component_mul(&self.end_weight) + multipliers;
        let mut form = DMatrix::from_diagonal(&self.end_weight);
        let (mut offsets, mut gains) = (Vec::with_capacity(self.steps), Vec::with_capacity(self.steps));
        let mut change = [0.0; 2];
        let mut warm = DVector::zeros(self.limit.len());
        for k in (0..self.steps).rev() {
            let (a, b) = plant.linearize(&x[k], &u[k])?;
            let by_x = &q * (&x[k] - &self.goal) + a.tr_mul(&slope);
            let by_u = &r * (&u[k] - &self.rest) + b.tr_mul(&slope);
            let (form_a, form_b) = (&form * &a, &form * &b);
            let by_xx = &q + a.tr_mul(&form_a);
            let by_uu = &r + b.tr_mul(&form_b);
            let by_ux = b.tr_mul(&form_a);
            // A penalty on changes of the control: for large μ the step follows the negative gradient.
            let stiff_uu = &by_uu + mu * &r;
            let bounds = (&(-&self.limit - &u[k]), &(&self.limit - &u[k]));
            let least = box_minimum(&stiff_uu, &by_u, bounds, &warm)
                .map_err(|error| format!("the control of step {k} is not determined: {error:?}"))?;
            let mut gain = DMatrix::zeros(by_ux.nrows(), by_ux.ncols());
            if let Some(factor) = &least.factor {
                let rows = factor.solve(&by_ux.select_rows(&least.free));
                for (row, &i) in least.free.iter().enumerate() {
                    gain.row_mut(i).copy_from(&-rows.row(row));
                }
            }
            let offset = least.x;
            let form_k = &by_uu * &offset;
            change[0] += offset.dot(&by_u);
            change[1] += 0.5 * offset.dot(&form_k);
            slope = by_x + gain.tr_mul(&(form_k + &by_u)) + by_ux.tr_mul(&offset);
            let cross = gain.tr_mul(&by_ux);
            form = by_xx + gain.tr_mul(&(&by_uu * &gain)) + &cross + cross.transpose();
            form = 0.5 * (&form + form.transpose());
            warm.copy_from(&offset);
            offsets.push(offset);
            gains.push(gain);
        }
        offsets.reverse();
        gains.reverse();
        Ok(Policy { offsets, gains, change })
    }

    /// The largest of α = 1, ½, ¼, … whose motion decreases the cost by a sufficient fraction of the
    /// prediction.
    #[allow(clippy::type_complexity)] // states and controls
    fn search(
        &self,
        plant: &mut dyn Plant,
        x: &[DVector<f64>],
        u: &[DVector<f64>],
        policy: &Policy,
        multipliers: &DVector<f64>,
        before: f64,
    ) -> Option<(Vec<DVector<f64>>, Vec<DVector<f64>>)> {
        let mut alpha = 1.0;
        while alpha > 1e-4 {
            let promise = -alpha * (policy.change[0] + alpha * policy.change[1]);
            // A motion that diverges is an error of the plant: the step is too long.
            if let Ok((next_x, next_u)) = self.follow(plant, x, u, policy, alpha) {
                let gain = before - self.total(&next_x, &next_u, multipliers);
                if gain >= 1e-3 * promise {
                    return Some((next_x, next_u));
                }
            }
            alpha *= 0.5;
        }
        None
    }

    /// The motion under u + αk + K δx, clamped.
    #[allow(clippy::type_complexity)] // states and controls
    fn follow(
        &self,
        plant: &mut dyn Plant,
        x: &[DVector<f64>],
        u: &[DVector<f64>],
        policy: &Policy,
        alpha: f64,
    ) -> Result<(Vec<DVector<f64>>, Vec<DVector<f64>>), Box<dyn Error>> {
        let mut next_x = vec![self.start.clone()];
        let mut next_u = Vec::with_capacity(self.steps);
        for k in 0..self.steps {
            let control = &u[k] + alpha * &policy.offsets[k] + &policy.gains[k] * (&next_x[k] - &x[k]);
            let control = self.clamped(&control);
            next_x.push(plant.step(&next_x[k], &control)?);
            next_u.push(control);
        }
        Ok((next_x, next_u))
    }
}
