//! Forward dynamics with multipliers: M a + C v + g = τ + Aᵀλ, A a = −Ȧv. **(PRM 10.16–10.17)**
//!
//! With A = T E and E M⁻¹Eᵀ = 1 (`row_factor`), a = a₀ + M⁻¹Eᵀw with w = T⁻¹(−Ȧv) − E a₀, and Tᵀλ = w. Cost:
//! O(K² nv + K nv depth) for K rows.
//!
//! Multipliers of dependent rows are not unique. Baumgarte's terms, if requested, replace −Ȧv by −Ȧv − 2γAv −
//! γ²φ.

use nalgebra::{DMatrix, DVector};
use robot_dynamics_core::{Model, Workspace, bias};
use robot_dynamics_description::check_length;
use robot_dynamics_integrators::check_computed;
use robot_dynamics_number::check_finite;

use super::row_factor::{MassFactor, RowFactor};
use super::rows::ConstraintRows;
use super::{ConstraintError, ConstraintOptions, ConstraintSet, NamedDependentRow, RedundantRows};

/// Acceleration and multipliers at a state.
#[derive(Clone, Debug, PartialEq)]
#[non_exhaustive]
pub struct ConstrainedMotion {
    /// a, nv \[rad/s² or m/s²\].
    pub acceleration: DVector<f64>,
    /// λ, K: the force of row k is Aₖᵀλₖ \[N, or N·m for a rotation\].
    pub multipliers: DVector<f64>,
    /// The number of independent rows.
    pub rank: usize,
    /// The dependent rows.
    pub dependent: Vec<NamedDependentRow>,
    /// max |A a − target| over all rows: rounding, unless dependent rows contradict the others.
    pub residual: f64,
}

/// Returns a and λ of M a + C v + g = τ + Aᵀλ with A a = −Ȧv (− 2γ A v − γ² φ). **(PRM 10.16–10.17)**
///
/// The free acceleration is a₀ = M⁻¹(τ − C v − g). With A = T E and E M⁻¹Eᵀ = 1: w = T⁻¹(−Ȧv) − E a₀,
/// a = a₀ + M⁻¹Eᵀ w, Tᵀλ = w. One step of refinement follows. M has a sparse factor LᵀDL, so the rows cost
/// O(K² nv + K nv depth). Damping and friction are not included, as in
/// [`forward_dynamics`](robot_dynamics_core::forward_dynamics). The function allocates.
///
/// ```
/// use robot_dynamics::constraints::{FrameConstraint, ConstraintOptions, ConstraintSet};
/// use robot_dynamics::constraints::constrained_forward_dynamics;
/// use robot_dynamics::description::{Base, LinkDescription, RobotDescription};
/// use robot_dynamics::model::{Model, Workspace, neutral};
/// // A bead of 2 kg on a floating base, held at the world's origin: the hold carries its weight.
/// let mut robot = RobotDescription::new("bead");
/// robot.base = Base::Floating;
/// let ball = robot_dynamics::description::MassProperties::new(2.0, nalgebra::Vector3::zeros(), nalgebra::Matrix3::identity());
/// robot.links.push(LinkDescription::new("bead", ball.ok()));
/// let model = Model::new(robot)?;
/// let bead = model.frame("bead").expect("a link");
/// let set = ConstraintSet::new(&model, [("hold", FrameConstraint::point_contact(bead, [0.0; 3]).into())])?;
/// let motion = constrained_forward_dynamics(&model, &mut Workspace::new(&model), &set,
///     &ConstraintOptions::default(), &neutral(&model), &[0.0; 6], &[0.0; 6])?;
/// assert!((motion.multipliers[2] - 2.0 * 9.81).abs() < 1e-12);
/// # Ok::<(), Box<dyn std::error::Error>>(())
/// ```
///
/// # Errors
/// [`ConstraintError`] if an input, an option, a row or a result is not finite, or M is singular. The
/// same if dependent rows are refused, or rows contradict each other by more than rounding.
///
/// # Panics
/// If a slice has the wrong length.
#[doc(alias = "KKT")]
#[track_caller]
pub fn constrained_forward_dynamics(
    model: &Model,
    workspace: &mut Workspace,
    set: &ConstraintSet,
    options: &ConstraintOptions,
    q: &[f64],
    v: &[f64],
    tau: &[f64],
) -> Result<ConstrainedMotion, ConstraintError> {
    Ok(SolvedMotion::new(model, workspace, (set, options), [q, v, tau])?.motion)
}

/// A constrained motion with the rows and the factors that gave it.
pub(super) struct SolvedMotion {
    pub motion: ConstrainedMotion,
    pub rows: ConstraintRows,
    pub mass: MassFactor,
    pub factor: RowFactor,
}

impl SolvedMotion {
    /// The motion at (q, v, τ).
    #[track_caller]
    pub(super) fn new(
        model: &Model,
        workspace: &mut Workspace,
        (set, options): (&ConstraintSet, &ConstraintOptions),
        [q, v, tau]: [&[f64]; 3],
    ) -> Result<Self, ConstraintError> {
        workspace.check_inputs(model, q);
        check_length("q", q.len(), model.nq());
        check_length("v", v.len(), model.nv());
        check_length("tau", tau.len(), model.nv());
        for (quantity, values) in [("q", q), ("v", v), ("tau", tau)] {
            check_finite(quantity, values)?;
        }
        options.check()?;
        let rows = set.rows(model, workspace, q, v);
        let mut force = DVector::zeros(model.nv());
        bias(model, workspace, q, v, force.as_mut_slice());
        force = DVector::from_column_slice(tau) - force;
        check_computed("τ − C v − g", force.as_slice())?;
        let mass = MassFactor::new(model, workspace, q)?;
        let factor = RowFactor::of(set, &mass, &rows, options.dependence)?;
        let dependent = factor.allowed_dependent_rows(set, options)?;
        let target = target(&rows, v, options);
        let Solution { acceleration, mut multipliers, free } =
            solve(&mass, &factor, &rows.matrix, &force, &target);
        if let (RedundantRows::Proximal { damping }, false) = (options.redundant, dependent.is_empty()) {
            multipliers = shortest_multipliers(
                &factor,
                &(&factor.triangle * factor_part(&factor, &multipliers)),
                damping,
            );
        }
        check_computed("the acceleration", acceleration.as_slice())?;
        check_computed("the multipliers", multipliers.as_slice())?;
        let missed = &rows.matrix * &acceleration - &target;
        let residual = missed.amax_or_zero();
        // The rows' terms bound the rounding of their sum. If the constraint prevents all motion, the bound
        // is that of the unconstrained acceleration.
        let entry = rows.matrix.abs().amax_or_zero();
        let scale = target.amax_or_zero() + entry * acceleration.abs().sum();
        let rounding = 64.0 * f64::EPSILON * entry * free;
        if let Some(worst) = missed.iter().position(|x| x.abs() > 1e-4 * scale + rounding) {
            return Err(ConstraintError::Inconsistent { name: set.row_names()[worst].clone(), residual });
        }
        let rank = factor.rank();
        let motion = ConstrainedMotion { acceleration, multipliers, rank, dependent, residual };
        Ok(Self { motion, rows, mass, factor })
    }
}

/// −Ȧv − 2γ A v − γ² φ.
fn target(rows: &ConstraintRows, v: &[f64], options: &ConstraintOptions) -> DVector<f64> {
    let mut target = -rows.bias.clone();
    if let Some(feedback) = options.stabilization {
        let velocity = &rows.matrix * DVector::from_column_slice(v);
        target -= velocity * (2.0 * feedback.rate) + &rows.position_error * feedback.rate.powi(2);
    }
    target
}

/// The result of [`solve`].
struct Solution {
    acceleration: DVector<f64>,
    multipliers: DVector<f64>,
    /// Σ |a₀|.
    free: f64,
}

/// a and λ, with one step of refinement: if M is ill-conditioned, a₀ and its rounding can dwarf a.
fn solve(
    mass: &MassFactor,
    factor: &RowFactor,
    rows: &DMatrix<f64>,
    force: &DVector<f64>,
    target: &DVector<f64>,
) -> Solution {
    let once = |force: &DVector<f64>, target: &DVector<f64>| {
        let free = mass.solve(force);
        let w = factor.solve_triangle(target) - &factor.forces * &free;
        Solution {
            acceleration: &free + factor.responses.tr_mul(&w),
            multipliers: factor.solve_triangle_transposed(&w),
            free: free.abs().sum(),
        }
    };
    let mut found = once(force, target);
    let left_force = force + rows.tr_mul(&found.multipliers) - &mass.mass * &found.acceleration;
    let more = once(&left_force, &(target - rows * &found.acceleration));
    found.acceleration += more.acceleration;
    found.multipliers += more.multipliers;
    found
}

/// Tᵀλ: the constraint force in the basis E.
fn factor_part(factor: &RowFactor, lambda: &DVector<f64>) -> DVector<f64> {
    factor.triangle.tr_mul(lambda)
}

/// The shortest λ with Λλ = `wanted`, Λ = T Tᵀ, by proximal steps from 0, which stay in the range of Λ.
fn shortest_multipliers(factor: &RowFactor, wanted: &DVector<f64>, damping: f64) -> DVector<f64> {
    let gram = &factor.triangle * factor.triangle.transpose();
    let count = gram.nrows();
    let mut damped = gram.clone();
    let mu = damping * gram.trace() / count as f64;
    for i in 0..count {
        damped[(i, i)] += mu;
    }
    let mut lambda = DVector::zeros(count);
    let Some(solver) = damped.cholesky() else { return lambda };
    let mut last = f64::INFINITY;
    // Each step reduces the error by σ/μ, σ the smallest nonzero eigenvalue of Λ, until rounding.
    for _ in 0..1000 {
        let step = solver.solve(&(wanted - &gram * &lambda));
        let change = step.amax_or_zero();
        if change == 0.0 || change >= last {
            break;
        }
        lambda += step;
        last = change;
    }
    lambda
}

/// max |xᵢ|, 0 if empty.
pub(super) trait LargestEntry {
    /// max |xᵢ|, 0 if empty.
    fn amax_or_zero(&self) -> f64;
}

impl<R: nalgebra::Dim, C: nalgebra::Dim, S: nalgebra::RawStorage<f64, R, C>> LargestEntry
    for nalgebra::Matrix<f64, R, C, S>
{
    fn amax_or_zero(&self) -> f64 {
        self.iter().fold(0.0, |most: f64, x| if x.is_nan() { f64::NAN } else { most.max(x.abs()) })
    }
}
