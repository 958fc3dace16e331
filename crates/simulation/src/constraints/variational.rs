//! The structure-preserving step with constraints.
//!
//! The method restricts the discrete action L_d of the unconstrained method (`integrate/variational.rs`) to
//! configurations on the constraint. With the multiplier split over the two ends of the step,
//!
//! p₀⁺ = p₀ + A(q₀)ᵀλ, (q₀, p₀⁺) ↦ (q₁, p₁⁻) the unconstrained step, φ(q₁) = 0, p₁ = p₁⁻ + A(q₁)ᵀμ, A(q₁) M⁻¹
//! p₁ = 0:
//!
//! This is RATTLE for any M(q) and any joint. **(HLW §VII.1.4)** A restricted L_d generates its map, so the
//! step is symplectic on the constrained phase space and reversible. It conserves the momenta of symmetries
//! that the constraint shares. Source: Marsden, West, *Discrete mechanics and variational integrators*, Acta
//! Numerica 10 (2001), §3.5.
//!
//! A row without φ has no discrete position equation. It becomes the discrete constraint A(q_m) v = 0 at the
//! middle of the step, with the same forces: the discrete Lagrange–d'Alembert principle. The step is then
//! reversible and keeps the constraint, but it is not symplectic, as the exact motion is not. Source: Cortés,
//! Martínez, *Non-holonomic integrators*, Nonlinearity 14 (2001).

use nalgebra::{DMatrix, DVector};
use robot_dynamics_core::{Model, SingularMass};
use robot_dynamics_integrators::IntegratorError;

use super::row_factor::{MassFactor, RowFactor};
use super::{ConstraintError, ConstraintOptions, ConstraintSet, constraint_drift, project_velocity};
use crate::motion::integrate::midpoint::{evaluate_middle, place_middle};
use crate::motion::integrate::rounding::{is_rounding, largest, rounding_scale};
use crate::motion::integrate::variational::{
    MAX_ITERATIONS, MAX_STALLS, begin, finish, place_end, run_away, velocity_of_momentum,
};
use crate::{StepForces, StepWorkspace};

/// Takes midpoint steps of these fractions of h from (q, v). Writes the result to (q, v) only on success.
pub(super) fn variational_step(
    model: &Model,
    workspace: &mut StepWorkspace,
    (set, options): (&ConstraintSet, &ConstraintOptions),
    forces: &StepForces<'_>,
    (h, fractions): (f64, &[f64]),
    q: &mut [f64],
    v: &mut [f64],
) -> Result<VariationalStepReport, ConstraintError> {
    begin(model, workspace, forces, q, v);
    let mut rank = None;
    for part in fractions.iter().map(|fraction| fraction * h) {
        let held = IndependentRows::at_start(model, workspace, set, options)?;
        rank.get_or_insert(held.independent.len());
        held.solve(model, workspace, set, forces, part)?;
        finish(model, workspace, part);
    }
    if let Err(error) = velocity_of_momentum(model, workspace) {
        let error = run_away(model, workspace, error, q, h, MAX_ITERATIONS);
        return Err(named(model, error, set, None));
    }
    // p₁ = p₁⁻ + A(q₁)ᵀμ with A(q₁) v₁ = 0 is v₁ ← P v₁.
    let StepWorkspace { dynamics, q_start, v: end, .. } = &mut *workspace;
    let velocity_before = constraint_drift(model, dynamics, set, q_start, end).velocity;
    if !set.is_empty() {
        project_velocity(model, dynamics, set, options, q_start, end)?;
    }
    q.copy_from_slice(&workspace.q_start);
    v.copy_from_slice(&workspace.v);
    Ok(VariationalStepReport { rank: rank.unwrap_or(0), velocity_before })
}

/// The results of a step other than the state.
pub(super) struct VariationalStepReport {
    /// The rank of A at the start.
    pub rank: usize,
    /// max |A v| of p₁⁻.
    pub velocity_before: f64,
}

/// The independent rows at the start of an inner step.
struct IndependentRows {
    /// Their indices in the set.
    independent: Vec<usize>,
    /// A(q₀) of them.
    matrix: DMatrix<f64>,
    /// p₀.
    momentum: Vec<f64>,
}

/// The equations of the active rows at an iterate. c = φ(q₁)/h, or A(q_m) v where a row has no φ, and B =
/// ∂c/∂v up to O(h).
struct RowEquations {
    value: DVector<f64>,
    /// The magnitude whose rounding limits c: a velocity, and for φ the lengths in it over h.
    size: DVector<f64>,
    slope: DMatrix<f64>,
}

impl IndependentRows {
    fn at_start(
        model: &Model,
        workspace: &mut StepWorkspace,
        set: &ConstraintSet,
        options: &ConstraintOptions,
    ) -> Result<Self, ConstraintError> {
        let StepWorkspace { dynamics, q_start, v, p_start, .. } = workspace;
        let rows = set.rows(model, dynamics, q_start, v);
        let mass = MassFactor::new(model, dynamics, q_start)?;
        let factor = RowFactor::of(set, &mass, &rows, options.dependence)?;
        factor.allowed_dependent_rows(set, options)?;
        let matrix = rows.matrix.select_rows(&factor.independent);
        Ok(Self { independent: factor.independent, matrix, momentum: p_start.clone() })
    }

    /// Solves p₀ + A₀ᵀλ + ½hF = p(v) and the rows' equations for (v, λ). Leaves the middle in `q` and `v`,
    /// and p₀⁺ in `p_start`.
    ///
    /// The iteration is that of the unconstrained step, v ← v + M⁻¹r, with the rows' equations: M δv − A₀ᵀδλ
    /// = r, B δv = −c. The residuals define the solution; M of the first middle and B affect only the rate of
    /// convergence.
    fn solve(
        &self,
        model: &Model,
        workspace: &mut StepWorkspace,
        set: &ConstraintSet,
        forces: &StepForces<'_>,
        h: f64,
    ) -> Result<(), ConstraintError> {
        let give_up = |residual, iterations, value: Option<&DVector<f64>>| {
            let error = IntegratorError::NotConverged { residual, iterations, step: h };
            named(model, error, set, value.map(|value| self.independent[value.icamax_or_zero()]))
        };
        let mut lambda = DVector::zeros(self.independent.len());
        let mut responses = DMatrix::zeros(0, 0);
        let (mut free_scale, mut scale) = (0.0, 0.0);
        let mut last_change = f64::INFINITY;
        let mut stalls = 0;
        for iterations in 1..=MAX_ITERATIONS {
            self.add_forces(workspace, &lambda);
            place_middle(model, workspace, h).ok_or_else(|| give_up(f64::INFINITY, iterations, None))?;
            if iterations == 1 {
                let StepWorkspace { dynamics, factor, q, .. } = &mut *workspace;
                if let Err(error) = factor.factor(model, dynamics, q) {
                    let start = workspace.q_start.clone();
                    let error = run_away(model, workspace, error, &start, h, iterations);
                    return Err(named(model, error, set, None));
                }
                responses = self.responses(workspace);
            }
            evaluate_middle(model, workspace, forces, h);
            let rows = self.equations(model, workspace, set, h);
            let solver = (&rows.slope * &responses).lu();
            if iterations == 1 {
                free_scale = rounding_scale(model, workspace, h);
                scale = free_scale + rows.scale(&responses, &solver);
                if !scale.is_finite() {
                    return Err(give_up(f64::INFINITY, iterations, Some(&rows.value)));
                }
            }
            // For an ill-conditioned robot, the changes stop decreasing above the rounding of v.
            if stalls >= MAX_STALLS && rows.is_rounding() && is_rounding(model, workspace, h) {
                return Ok(());
            }
            let StepWorkspace { factor, residual, v, .. } = &mut *workspace;
            factor.solve(residual);
            let mut step = DVector::from_column_slice(residual);
            if !lambda.is_empty() {
                let more = solver
                    .solve(&(-&rows.value - &rows.slope * &step))
                    .ok_or_else(|| self.nearly_dependent(set, &rows.slope, &responses))?;
                step += &responses * &more;
                lambda += more;
            }
            let change = largest(step.as_slice());
            if !change.is_finite() {
                return Err(give_up(f64::INFINITY, iterations, Some(&rows.value)));
            }
            v.iter_mut().zip(&step).for_each(|(v, step)| *v += step);
            // At round-off, the changes are below it or stop decreasing.
            if change <= 4.0 * f64::EPSILON * free_scale
                || (change >= last_change && change <= 1e3 * f64::EPSILON * scale)
            {
                self.add_forces(workspace, &lambda);
                place_middle(model, workspace, h).ok_or_else(|| give_up(f64::INFINITY, iterations, None))?;
                return Ok(());
            }
            if iterations == MAX_ITERATIONS {
                return Err(give_up(change / scale, iterations, Some(&rows.value)));
            }
            stalls += usize::from(change >= last_change);
            last_change = change;
        }
        unreachable!("the last iteration returns")
    }

    /// The row with the smallest part that is independent of the others.
    fn nearly_dependent(
        &self,
        set: &ConstraintSet,
        slope: &DMatrix<f64>,
        responses: &DMatrix<f64>,
    ) -> ConstraintError {
        let pivots = (slope * responses).lu().u().diagonal().abs();
        let least = (0..pivots.len()).min_by(|&i, &j| pivots[i].total_cmp(&pivots[j])).unwrap_or(0);
        ConstraintError::NearlyDependentRow { name: set.row_names()[self.independent[least]].clone() }
    }

    /// `p_start` ← p₀ + A₀ᵀλ.
    fn add_forces(&self, workspace: &mut StepWorkspace, lambda: &DVector<f64>) {
        let impulse = self.matrix.tr_mul(lambda);
        for ((p, start), kick) in workspace.p_start.iter_mut().zip(&self.momentum).zip(&impulse) {
            *p = start + kick;
        }
    }

    /// M⁻¹A₀ᵀ, nv×K.
    fn responses(&self, workspace: &StepWorkspace) -> DMatrix<f64> {
        let mut responses = self.matrix.transpose();
        for mut column in responses.column_iter_mut() {
            workspace.factor.solve(column.as_mut_slice());
        }
        responses
    }

    fn equations(
        &self,
        model: &Model,
        workspace: &mut StepWorkspace,
        set: &ConstraintSet,
        h: f64,
    ) -> RowEquations {
        let mut end = workspace.q_start.clone();
        place_end(model, (&workspace.q, &workspace.v), h, &mut end);
        let StepWorkspace { dynamics, q, v, .. } = workspace;
        let ends = set.rows(model, dynamics, &end, v);
        let mut value = DVector::zeros(self.independent.len());
        let mut slope = ends.matrix.select_rows(&self.independent);
        let has_velocity_rows = self.independent.iter().any(|&row| !ends.holonomic[row]);
        let middle = has_velocity_rows.then(|| set.rows(model, dynamics, q, v).matrix);
        let mut size = DVector::zeros(self.independent.len());
        let length = 1.0 + largest(&end);
        for (k, &row) in self.independent.iter().enumerate() {
            size[k] = largest(v);
            if ends.holonomic[row] {
                value[k] = ends.position_error[row] / h;
                size[k] += length / h.abs();
            } else if let Some(middle) = &middle {
                slope.set_row(k, &middle.row(row));
                value[k] = middle.row(row).iter().zip(v.iter()).map(|(a, v)| a * v).sum();
            }
            size[k] *= slope.row(k).iter().map(|x| x.abs()).sum::<f64>();
        }
        RowEquations { value, size, slope }
    }
}

impl RowEquations {
    /// Whether the residual of the rows is the rounding of their terms.
    fn is_rounding(&self) -> bool {
        self.value.iter().zip(&self.size).all(|(c, size)| c.abs() <= 64.0 * f64::EPSILON * size)
    }

    /// The magnitude of the velocities whose rounding is that of the rows' equations.
    fn scale(
        &self,
        responses: &DMatrix<f64>,
        solver: &nalgebra::LU<f64, nalgebra::Dyn, nalgebra::Dyn>,
    ) -> f64 {
        // A singular B M⁻¹A₀ᵀ is detected in the solve.
        let Some(inverse) = solver.try_inverse() else { return 0.0 };
        largest(((responses * inverse).abs() * &self.size).as_slice())
    }
}

/// The step's error as a constraint error with a row's name.
#[allow(clippy::needless_pass_by_value)] // it is turned into another
fn named(model: &Model, error: IntegratorError, set: &ConstraintSet, row: Option<usize>) -> ConstraintError {
    match error {
        IntegratorError::SingularMass { coordinate, pivot } => {
            SingularMass::at(model, coordinate, pivot).into()
        }
        IntegratorError::NotConverged { residual, iterations, step } => {
            let name = row.and_then(|row| set.row_names().get(row)).cloned().unwrap_or_else(|| "none".into());
            ConstraintError::StepNotConverged { residual, iterations, step, name }
        }
        error => error.into(),
    }
}

/// The index of the largest entry.
trait LargestIndex {
    /// The index of the largest entry, 0 if empty.
    fn icamax_or_zero(&self) -> usize;
}

impl LargestIndex for DVector<f64> {
    fn icamax_or_zero(&self) -> usize {
        let index = (0..self.len()).max_by(|&i, &j| self[i].abs().total_cmp(&self[j].abs()));
        index.unwrap_or(0)
    }
}
