//! Inverse dynamics with multipliers: τ + Aᵀλ = M a + C v + g with τ = 0 on coordinates without a motor.
//!
//! These coordinates fix a part of λ by least squares. The rest minimizes |τ|. Cost: O(K² nv). The
//! acceleration is not checked against A a + Ȧv = 0. The forces may have either sign: use `support` for
//! contacts that cannot pull.

use nalgebra::{DMatrix, DVector};
use robot_dynamics_core::factorization::singular_values::SingularValues;
use robot_dynamics_core::{Model, Workspace, inverse_dynamics};
use robot_dynamics_description::check_length;
use robot_dynamics_integrators::check_computed;
use robot_dynamics_number::check_finite;

use super::forward_dynamics::LargestEntry;
use super::row_factor::ROUNDING;
use super::{ConstraintError, ConstraintSet};

/// The torques and multipliers of a motion.
#[derive(Clone, Debug, PartialEq)]
#[non_exhaustive]
pub struct ConstrainedTorque {
    /// τ, nv: zero on coordinates without a motor \[N·m or N\].
    pub tau: DVector<f64>,
    /// λ, K.
    pub multipliers: DVector<f64>,
    /// max |M a + C v + g − τ − Aᵀλ|: more than rounding if the motors cannot cause this motion.
    pub residual: f64,
}

/// Returns τ and λ with τ + Aᵀλ = M a + C v + g and τ = 0 on coordinates without a motor; the shortest such
/// τ.
///
/// The coordinates without motors fix part of λ, Aᵤᵀλ = fᵤ, by least squares. The rest of λ minimizes |τ|,
/// because internal forces of a loop cost torque and move nothing. If rows depend on others, τ and Aᵀλ are
/// unique and λ is the shortest. Examples are a planar loop closed in space, two wheels on one axle, or a
/// sole with four corners. Dependence is decided as by
/// [`ConstraintOptions::dependence`](super::ConstraintOptions::dependence) = 1e-9.
///
/// `actuated` has nv entries. a should satisfy A a + Ȧv = 0. This is not checked, as the torque is that of
/// the tree in any case.
///
/// ```
/// use robot_dynamics::constraints::{FrameConstraint, ConstraintSet, constrained_inverse_dynamics};
/// use robot_dynamics::model::{Workspace, neutral};
/// # use robot_dynamics::description::{Base, LinkDescription, RobotDescription};
/// # use robot_dynamics::model::Model;
/// # let mut robot = RobotDescription::new("ball");
/// # robot.base = Base::Floating;
/// # let ball = robot_dynamics::description::MassProperties::new(2.0, [0.0; 3].into(), nalgebra::Matrix3::identity()).ok();
/// # robot.links.push(LinkDescription::new("ball", ball));
/// # let model = Model::new(robot)?;
/// # let ball = model.frame_named("ball")?;
/// // A ball of 2 kg that hangs at a point, without a motor: the point carries it.
/// let set = ConstraintSet::new(&model, [("hold", FrameConstraint::point_contact(ball, [0.0; 3]).into())])?;
/// let (w, q, rest) = (&mut Workspace::new(&model), neutral(&model), [0.0; 6]);
/// let forces = constrained_inverse_dynamics(&model, w, &set, &q, &rest, &rest, &[false; 6])?;
/// assert!((forces.multipliers[2] - 2.0 * 9.81).abs() < 1e-13);
/// assert!(forces.tau.amax() == 0.0 && forces.residual < 1e-13);
/// # Ok::<(), Box<dyn std::error::Error>>(())
/// ```
///
/// # Errors
/// [`ConstraintError`]: q, v, a, a row or a result is not finite.
///
/// # Panics
/// If a slice has the wrong length.
#[track_caller]
pub fn constrained_inverse_dynamics(
    model: &Model,
    workspace: &mut Workspace,
    set: &ConstraintSet,
    q: &[f64],
    v: &[f64],
    a: &[f64],
    actuated: &[bool],
) -> Result<ConstrainedTorque, ConstraintError> {
    Ok(SolvedTorque::new(model, workspace, set, [q, v, a], actuated)?.torque)
}

/// The torques of a motion, with the rows and the forces that gave them.
pub(super) struct SolvedTorque {
    pub torque: ConstrainedTorque,
    /// A.
    pub rows: DMatrix<f64>,
    /// M a + C v + g.
    pub force: DVector<f64>,
}

impl SolvedTorque {
    #[track_caller]
    pub(super) fn new(
        model: &Model,
        workspace: &mut Workspace,
        set: &ConstraintSet,
        [q, v, a]: [&[f64]; 3],
        actuated: &[bool],
    ) -> Result<Self, ConstraintError> {
        workspace.check_inputs(model, q);
        let nv = model.nv();
        check_length("q", q.len(), model.nq());
        check_length("v", v.len(), nv);
        check_length("a", a.len(), nv);
        for (quantity, values) in [("q", q), ("v", v), ("a", a)] {
            check_finite(quantity, values)?;
        }
        check_length("the list of actuated coordinates", actuated.len(), nv);
        let rows = set.rows(model, workspace, q, v);
        rows.check(set.row_names())?;
        let rows = rows.matrix;
        let mut force = DVector::zeros(nv);
        inverse_dynamics(model, workspace, q, v, a, force.as_mut_slice());
        check_computed("M a + C v + g", force.as_slice())?;
        let range = ConstraintForces::new(&rows);
        let along = range.components(&force, actuated);
        let rest = &force - &range.basis * &along;
        let multipliers = range.multipliers(&rows, &along);
        let tau = DVector::from_fn(nv, |i, _| if actuated[i] { rest[i] } else { 0.0 });
        let residual = (rest - &tau).amax_or_zero();
        check_computed("the torque", tau.as_slice())?;
        check_computed("the multipliers", multipliers.as_slice())?;
        Ok(Self { torque: ConstrainedTorque { tau, multipliers, residual }, rows, force })
    }
}

/// The forces Aᵀλ in an orthonormal basis: Aᵀλ = U μ.
///
/// Rows that depend on others are left out here, once. In U no direction is small. If U μ does not act on the
/// coordinates without motors, it acts on the others with the length |μ|. No other rank decision on rounded
/// numbers is needed.
pub(super) struct ConstraintForces {
    /// U, nv × rank A.
    pub basis: DMatrix<f64>,
}

/// A singular value below this fraction of the largest is 0, for rows of length 1. Like
/// [`ConstraintOptions::dependence`](super::ConstraintOptions::dependence), it is above the rounding and the
/// drift of a redundant loop.
const DEPENDENCE: f64 = 1e-9;

impl ConstraintForces {
    pub(super) fn new(rows: &DMatrix<f64>) -> Self {
        let nv = rows.ncols();
        let longest = rows.row_iter().map(|row| row.norm()).fold(0.0, f64::max);
        let unit: Vec<_> = rows
            .row_iter()
            .filter(|row| row.norm() > ROUNDING * longest)
            .map(|row| row.transpose() / row.norm())
            .collect();
        if unit.is_empty() {
            return Self { basis: DMatrix::zeros(nv, 0) };
        }
        Self { basis: SingularValueSplit::of(&DMatrix::from_columns(&unit)).range }
    }

    /// μ: (U μ)ᵢ = fᵢ on coordinates without motors by least squares; of such μ, the one with the least motor
    /// torque.
    fn components(&self, force: &DVector<f64>, actuated: &[bool]) -> DVector<f64> {
        let pick =
            |motors: bool| -> Vec<usize> { (0..actuated.len()).filter(|&i| actuated[i] == motors).collect() };
        let (driven, free) = (pick(true), pick(false));
        let on_free = self.basis.select_rows(&free);
        let SingularValueSplit { range, null, pseudo_inverse } = SingularValueSplit::of(&on_free);
        let wanted = force.select_rows(&free);
        let fixed = pseudo_inverse * range.tr_mul(&wanted);
        // The columns of U_d N are orthonormal, as those of U N are and U_f N = 0.
        let on_driven = self.basis.select_rows(&driven);
        let left = force.select_rows(&driven) - &on_driven * &fixed;
        let open = &on_driven * &null;
        fixed + null * open.tr_mul(&left)
    }

    /// The shortest λ with Aᵀλ = U μ.
    fn multipliers(&self, rows: &DMatrix<f64>, along: &DVector<f64>) -> DVector<f64> {
        if along.is_empty() {
            return DVector::zeros(rows.nrows());
        }
        // (A U)ᵀ λ = μ; A U has independent columns, A U = Q R.
        let (q, r) = (rows * &self.basis).qr().unpack();
        q * r.tr_solve_upper_triangular(along).unwrap_or_else(|| along.map(|_| f64::NAN))
    }
}

/// B = U Σ Vᵀ, split at the smallest singular value above rounding.
pub(super) struct SingularValueSplit {
    /// The columns of U that span the range of B.
    range: DMatrix<f64>,
    /// An orthonormal basis of the x with B x = 0.
    pub null: DMatrix<f64>,
    /// V Σ⁻¹: times `range`ᵀ the pseudo-inverse of B.
    pub pseudo_inverse: DMatrix<f64>,
}

impl SingularValueSplit {
    /// Splits a B whose columns have at most length 1, so that singular values are compared with 1.
    pub(super) fn of(b: &DMatrix<f64>) -> Self {
        let (m, n) = b.shape();
        if m == 0 || n == 0 {
            let empty = DMatrix::zeros(n, 0);
            return Self {
                range: DMatrix::zeros(m, 0),
                null: DMatrix::identity(n, n),
                pseudo_inverse: empty,
            };
        }
        let SingularValues { product, right, values } = SingularValues::of(b);
        let (large, small): (Vec<_>, Vec<_>) = (0..n).partition(|&k| values[k] > DEPENDENCE);
        let (mut range, mut pseudo_inverse) = (product.select_columns(&large), right.select_columns(&large));
        for (column, &k) in large.iter().enumerate() {
            range.column_mut(column).scale_mut(1.0 / values[k]);
            pseudo_inverse.column_mut(column).scale_mut(1.0 / values[k]);
        }
        Self { range, null: right.select_columns(&small), pseudo_inverse }
    }
}
