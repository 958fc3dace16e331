//! Constraints of nodes, and their terms of the augmented Lagrangian.

use std::ops::Range;

use robot_dynamics_number::InvalidInput;
use robot_dynamics_simulation::StepError;

use super::cost::CostExpansion;
use super::dynamics::ContactForces;
use super::residual::{Residual, ResidualInputs, ResidualJacobian};

/// l ≤ c(x, u) ≤ h for some nodes, with their multipliers λ.
///
/// With the penalty μ and z = c + λ/μ, its term of the augmented Lagrangian is ½ μ |z − Π z|² − ½ |λ|²/μ,
/// where Π projects on the interval. Equalities have l = h.
#[derive(Clone)]
pub(super) struct NodeConstraint {
    residual: Box<dyn Residual>,
    lower: Vec<f64>,
    upper: Vec<f64>,
    nodes: Range<usize>,
    /// λ of all nodes.
    multipliers: Vec<f64>,
    values: Vec<f64>,
    by_state: Vec<f64>,
    by_control: Vec<f64>,
}

impl NodeConstraint {
    pub(super) fn new(
        residual: Box<dyn Residual>,
        lower: &[f64],
        upper: &[f64],
        nodes: Range<usize>,
    ) -> Result<Self, InvalidInput> {
        let rows = residual.dimension();
        if lower.len() != rows || upper.len() != rows {
            let counts =
                format!("are {} and {}, the constraint has {rows} entries", lower.len(), upper.len());
            return Err(InvalidInput::unmet("the bounds of the constraint", counts));
        }
        for (index, (low, high)) in lower.iter().zip(upper).enumerate() {
            let is_ordered = low <= high && *low < f64::INFINITY && *high > f64::NEG_INFINITY;
            if !is_ordered {
                let bounds =
                    format!("has the bounds {low} and {high}; the lower must not be above the upper");
                return Err(InvalidInput::unmet(format!("entry {index} of the constraint"), bounds));
            }
        }
        Ok(Self {
            residual,
            lower: lower.to_vec(),
            upper: upper.to_vec(),
            multipliers: vec![0.0; rows * nodes.len()],
            nodes,
            values: vec![0.0; rows],
            by_state: Vec::new(),
            by_control: Vec::new(),
        })
    }

    pub(super) fn expects(&self) -> ResidualInputs {
        self.residual.expects()
    }

    /// Hands the forces of the node's dynamics to c.
    pub(super) fn reuse(&mut self, forces: &ContactForces<'_>) {
        self.residual.reuse(forces);
    }

    pub(super) fn applies_to(&self, node: usize) -> bool {
        self.nodes.contains(&node)
    }

    /// The first multiplier of a node.
    fn first(&self, node: usize) -> usize {
        (node - self.nodes.start) * self.values.len()
    }

    /// z − Π z of an entry, for z = c + λ/μ.
    fn excess(&self, row: usize, multiplier: f64, penalty: f64) -> f64 {
        let z = self.values[row] + multiplier / penalty;
        (z - self.upper[row]).max(0.0) + (z - self.lower[row]).min(0.0)
    }

    /// The term of the augmented Lagrangian.
    pub(super) fn value(
        &mut self,
        node: usize,
        x: &[f64],
        u: &[f64],
        penalty: f64,
    ) -> Result<f64, StepError> {
        self.residual.evaluate(x, u, &mut self.values)?;
        let first = self.first(node);
        let term = |row: usize| {
            let multiplier = self.multipliers[first + row];
            let excess = self.excess(row, multiplier, penalty);
            0.5 * (penalty * excess * excess - multiplier * multiplier / penalty)
        };
        Ok((0..self.values.len()).map(term).sum())
    }

    /// Adds the derivatives of the term, with the Hessian of Gauss and Newton.
    pub(super) fn add_expansion(
        &mut self,
        node: usize,
        x: &[f64],
        u: &[f64],
        penalty: f64,
        expansion: &mut CostExpansion<'_>,
    ) -> Result<(), StepError> {
        let (n, m, rows) = (expansion.state_gradient.len(), u.len(), self.values.len());
        for (jacobian, columns) in [(&mut self.by_state, n), (&mut self.by_control, m)] {
            jacobian.clear();
            jacobian.resize(rows * columns, 0.0);
        }
        let jacobian = ResidualJacobian { by_state: &mut self.by_state, by_control: &mut self.by_control };
        self.residual.linearize(x, u, &mut self.values, jacobian)?;
        let first = self.first(node);
        for row in 0..rows {
            let excess = self.excess(row, self.multipliers[first + row], penalty);
            if excess != 0.0 || self.lower[row] == self.upper[row] {
                let (by_x, by_u) = (&self.by_state[row * n..][..n], &self.by_control[row * m..][..m]);
                expansion.add_square(penalty, excess, by_x, by_u);
            }
        }
        Ok(())
    }

    /// The largest |c − Π(c + λ/μ)|: the violation, and the slack of entries with a multiplier.
    pub(super) fn violation(
        &mut self,
        node: usize,
        x: &[f64],
        u: &[f64],
        penalty: f64,
    ) -> Result<f64, StepError> {
        self.residual.evaluate(x, u, &mut self.values)?;
        let first = self.first(node);
        Ok((0..self.values.len()).fold(0.0, |most: f64, row| {
            let multiplier = self.multipliers[first + row];
            most.max((self.excess(row, multiplier, penalty) - multiplier / penalty).abs())
        }))
    }

    /// λ ← μ (z − Π z) of a node.
    pub(super) fn update_multipliers(
        &mut self,
        node: usize,
        x: &[f64],
        u: &[f64],
        penalty: f64,
    ) -> Result<(), StepError> {
        self.residual.evaluate(x, u, &mut self.values)?;
        let first = self.first(node);
        for row in 0..self.values.len() {
            let multiplier = self.multipliers[first + row];
            self.multipliers[first + row] = penalty * self.excess(row, multiplier, penalty);
        }
        Ok(())
    }

    pub(super) fn copy_multipliers(&mut self, from: &Self) {
        self.multipliers.copy_from_slice(&from.multipliers);
    }

    pub(super) fn clear_multipliers(&mut self) {
        self.multipliers.fill(0.0);
    }
}
