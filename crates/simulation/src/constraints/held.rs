//! Motions and impacts of a robot with held rows, their derivatives and steps, in memory that is kept.
//!
//! The equations are those of [`constrained_forward_dynamics`](super::constrained_forward_dynamics) and
//! [`contact_impulse`](super::contact_impulse). This form serves optimal control: it keeps its memory, and
//! it differentiates by the state and by the controls at once. The factor is that of `kernels`.

mod derivatives;
mod impact;
mod kernels;
mod step;

pub use impact::LinearizedImpact;
pub use step::LinearizedHeldStep;

use robot_dynamics_core::factorization::sparse;
use robot_dynamics_core::{Model, Workspace, bias, check_rank, mass_matrix};
use robot_dynamics_description::check_length;
use robot_dynamics_integrators::check_computed;
use robot_dynamics_number::{InvalidInput, check_finite, check_number};

use self::kernels::{RightSides, RowBasis};
use super::ConstraintSet;
use crate::StepError;
use crate::equality::rows::EqualityRows;
use crate::motion::RobotState;

/// Feedback on held rows: A a = −Ȧv − d A v − p φ.
///
/// With p = 0, the default, a point is held where it is: only its velocity is brought to zero. A phase of a
/// gait needs no target then. Rows without φ, such as those of a skate, have p = 0.
#[derive(Clone, Copy, Debug, Default, PartialEq)]
pub struct RowFeedback {
    /// p \[1/s²\].
    pub position: f64,
    /// d \[1/s\]. An explicit step of h needs d below about 2/h.
    pub velocity: f64,
}

impl From<super::Baumgarte> for RowFeedback {
    /// p = γ² and d = 2γ.
    fn from(feedback: super::Baumgarte) -> Self {
        Self { position: feedback.rate * feedback.rate, velocity: 2.0 * feedback.rate }
    }
}

/// The motion of a robot whose rows A v = 0 are held: M a + C v + g = τ + Aᵀλ, A a = −Ȧv − d A v − p φ.
///
/// The results stay until the next call. Rows that depend on earlier ones have λ = 0. Damping and friction of
/// the joints are not included.
///
/// ```
/// use robot_dynamics::constraints::{ConstraintSet, FrameConstraint, HeldDynamics, RowFeedback, SpatialAxis};
/// use robot_dynamics::description::{Pose, pendulum};
/// use robot_dynamics::model::Model;
/// use robot_dynamics::derivatives::RobotState;
/// // A rod on a hinge, whose tip is held at its height: λ l cos q = τ + m g l cos q.
/// let model = Model::new(pendulum(2.0, 0.5))?;
/// let hold = FrameConstraint::contact(model.frame_named("tip")?, Pose::IDENTITY, &[SpatialAxis::Z]);
/// let set = ConstraintSet::new(&model, [("hold", hold.into())])?;
/// let mut held = HeldDynamics::new(&model, &set, RowFeedback::default())?;
/// held.solve(&model, RobotState { q: &[0.3], v: &[0.0] }, &[1.0])?;
/// assert!(held.acceleration()[0].abs() < 1e-14);
/// let force = (1.0 + 2.0 * 9.81 * 0.5 * 0.3_f64.cos()) / (0.5 * 0.3_f64.cos());
/// assert!((held.multipliers()[0] - force).abs() < 1e-12);
/// # Ok::<(), Box<dyn std::error::Error>>(())
/// ```
#[derive(Clone, Debug)]
pub struct HeldDynamics {
    workspace: Workspace,
    rows: EqualityRows,
    feedback: RowFeedback,
    dependence: f64,
    basis: RowBasis,
    /// A, K×nv.
    matrix: Vec<f64>,
    acceleration: Vec<f64>,
    multipliers: Vec<f64>,
    /// v⁺ of the last impact.
    velocity: Vec<f64>,
    /// The derivatives by (δq, δv, δu) of the last linearization: nv and K rows.
    by_inputs: Vec<f64>,
    multipliers_by_inputs: Vec<f64>,
    /// Scratch: two squares, and vectors.
    squares: [Vec<f64>; 2],
    changes: [Vec<f64>; 2],
    vectors: [Vec<f64>; 2],
}

/// The fraction of a row's length below which its independent part counts as zero.
const DEPENDENCE: f64 = 1e-9;

impl HeldDynamics {
    /// The dynamics of a robot with the rows of a set.
    ///
    /// # Errors
    /// [`InvalidInput`] if a number of the feedback is not finite, or the set has no rows.
    ///
    /// # Panics
    /// If the set belongs to another robot.
    #[track_caller]
    pub fn new(model: &Model, set: &ConstraintSet, feedback: RowFeedback) -> Result<Self, InvalidInput> {
        set.check_robot(model);
        check_number("the feedback on φ", feedback.position)?;
        check_number("the feedback on A v", feedback.velocity)?;
        let Some(rows) = set.equalities() else {
            return Err(InvalidInput::unmet("the set of held rows", "must belong to a robot"));
        };
        let (workspace, nv, count) = (Workspace::new(model), model.nv(), set.len());
        let vector = || vec![0.0; nv];
        Ok(Self {
            rows: rows.clone(),
            feedback,
            dependence: DEPENDENCE,
            basis: RowBasis::new(workspace.dense.dof_parent.clone(), count),
            workspace,
            matrix: vec![0.0; count * nv],
            acceleration: vector(),
            multipliers: vec![0.0; count],
            velocity: vector(),
            by_inputs: Vec::new(),
            multipliers_by_inputs: Vec::new(),
            squares: [(); 2].map(|()| vec![0.0; nv * nv]),
            changes: [Vec::new(), Vec::new()],
            vectors: [(); 2].map(|()| vector()),
        })
    }

    /// Computes a and λ at a state with generalized forces τ.
    ///
    /// # Errors
    /// [`StepError`] if a number is not finite, M is singular, or a result is not finite.
    ///
    /// # Panics
    /// If a slice has the wrong length, or the model is another.
    #[track_caller]
    pub fn solve(&mut self, model: &Model, state: RobotState<'_>, tau: &[f64]) -> Result<(), StepError> {
        let RobotState { q, v } = state;
        check_length("tau", tau.len(), model.nv());
        check_finite("tau", tau)?;
        self.place(model, state)?;
        let Self { workspace, acceleration, multipliers, rows, matrix, .. } = self;
        bias(model, workspace, q, v, acceleration);
        acceleration.iter_mut().zip(tau).for_each(|(a, tau)| *a = tau - *a);
        let RowFeedback { position, velocity } = self.feedback;
        let own = rows.rows().iter().zip(matrix.chunks_exact(model.nv()));
        for ((c, bias), (row, a)) in multipliers.iter_mut().zip(rows.bias(model, q, v)).zip(own) {
            let rate: f64 = a.iter().zip(v).map(|(a, v)| a * v).sum();
            *c = -bias - velocity * rate - position * row.error.unwrap_or(0.0);
        }
        self.basis.solve(RightSides { forces: acceleration, rates: multipliers, width: 1 });
        check_computed("the acceleration", acceleration)?;
        check_computed("the multipliers", multipliers)?;
        Ok(())
    }

    /// Computes A, and factors M and the rows.
    #[track_caller]
    fn place(&mut self, model: &Model, RobotState { q, v }: RobotState<'_>) -> Result<(), StepError> {
        self.workspace.check_inputs(model, q);
        check_length("q", q.len(), model.nq());
        check_length("v", v.len(), model.nv());
        check_finite("q", q)?;
        check_finite("v", v)?;
        let Self { workspace, rows, basis, matrix, vectors: [diagonal, _], .. } = self;
        mass_matrix(model, workspace, q, &mut basis.lower);
        let (nv, lower) = (model.nv(), &mut basis.lower);
        (0..nv).for_each(|k| diagonal[k] = lower[k * nv + k]);
        sparse::factor(&basis.dof_parent, lower);
        let pivots = (0..nv).map(|k| (lower[k * nv + k], diagonal[k]));
        if let Err(error) = sparse::check_pivots(pivots) {
            // The rank check names the joints.
            check_rank(model, workspace, q)?;
            return Err(error.into());
        }
        rows.place(model, workspace, q);
        matrix.fill(0.0);
        for (row, to) in rows.rows().iter().zip(matrix.chunks_exact_mut(nv)) {
            row.terms.iter().for_each(|&(k, factor)| to[k] = factor);
        }
        check_computed("the held rows", matrix)?;
        basis.factor(matrix, self.dependence);
        Ok(())
    }

    /// a of the last call of [`solve`](Self::solve), nv \[rad/s² or m/s²\].
    pub fn acceleration(&self) -> &[f64] {
        &self.acceleration
    }

    /// λ of the last call, K: the force of row k is Aₖᵀλₖ \[N, or N·m for a rotation\]. After an impact these
    /// are the impulses \[N·s, or N·m·s\].
    pub fn multipliers(&self) -> &[f64] {
        &self.multipliers
    }

    /// The number of independent rows at the last state.
    pub fn rank(&self) -> usize {
        self.basis.rank()
    }

    /// The number of rows, K.
    pub fn rows(&self) -> usize {
        self.multipliers.len()
    }

    /// The derivatives of λ, or of the impulses, of the last linearization: K×w, row-major, with the columns
    /// δq, δv and, after a motion, one for each column of its forces.
    pub fn multipliers_by_inputs(&self) -> &[f64] {
        &self.multipliers_by_inputs
    }

    /// The derivatives of a, or of v⁺, of the last linearization: nv×w, with the same columns.
    pub fn motion_by_inputs(&self) -> &[f64] {
        &self.by_inputs
    }
}
