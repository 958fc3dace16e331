//! Inverse dynamics with multipliers: what the motors, and only they, must give.

use nalgebra::{DMatrix, DVector};

use super::error::check_entries;
use super::forward::LargestEntry;
use super::{ConstrainedMotionError, ConstraintSet};
use crate::model::length::check_length;
use crate::{Model, Workspace, inverse_dynamics};

/// Torques and multipliers of a motion.
#[derive(Clone, Debug, PartialEq)]
#[non_exhaustive]
pub struct ConstrainedTorque {
    /// τ, nv: zero where there is no motor \[N·m or N\].
    pub tau: DVector<f64>,
    /// λ, K.
    pub multipliers: DVector<f64>,
    /// max |M a + C v + g − τ − Aᵀλ|: more than rounding where the motors cannot make this motion.
    pub residual: f64,
}

/// τ and λ with τ + Aᵀλ = M a + C v + g and τ = 0 on coordinates without a motor; the shortest such τ.
///
/// Rows of coordinates without motors fix part of λ, Aᵤᵀλ = fᵤ; the freedom that is left makes |τ| least:
/// squeezing a loop against itself costs torque and moves nothing. `actuated` has nv entries. a should obey
/// A a + Ȧv = 0; it is not checked, as the torque is that of the tree in any case.
///
/// ```
/// use multibody::{Closure, ConstraintSet, Workspace, constrained_inverse_dynamics, neutral};
/// # use multibody::*;
/// # let mut robot = RobotDescription::new("ball");
/// # robot.base = Base::Floating;
/// # let ball = dynamics::MassProperties::new(2.0, [0.0; 3].into(), nalgebra::Matrix3::identity()).ok();
/// # robot.links.push(LinkDescription::new("ball", ball));
/// # let model = Model::new(robot)?;
/// # let ball = model.frame_named("ball")?;
/// // A ball of 2 kg that hangs at a point, without a motor: the point carries it.
/// let set = ConstraintSet::new(&model, [("hold", Closure::point_contact(ball, [0.0; 3]).into())])?;
/// let (w, q, rest) = (&mut Workspace::new(&model), neutral(&model), [0.0; 6]);
/// let forces = constrained_inverse_dynamics(&model, w, &set, &q, &rest, &rest, &[false; 6])?;
/// assert!((forces.multipliers[2] - 2.0 * 9.81).abs() < 1e-13);
/// assert!(forces.tau.amax() == 0.0 && forces.residual < 1e-13);
/// # Ok::<(), Box<dyn std::error::Error>>(())
/// ```
///
/// # Errors
/// [`ConstrainedMotionError`]: q, v, a, a row or a result is not finite.
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
) -> Result<ConstrainedTorque, ConstrainedMotionError> {
    workspace.admit(model, q);
    let nv = model.nv();
    check_length("q", q.len(), model.nq());
    check_length("v", v.len(), nv);
    check_length("a", a.len(), nv);
    for (quantity, values) in [("q", q), ("v", v), ("a", a)] {
        check_entries(quantity, values)?;
    }
    check_length("the list of actuated coordinates", actuated.len(), nv);
    let rows = set.rows(model, workspace, q, v);
    rows.check(set)?;
    let rows = rows.matrix;
    let mut force = DVector::zeros(nv);
    inverse_dynamics(model, workspace, q, v, a, force.as_mut_slice());
    check_entries("M a + C v + g", force.as_slice())?;
    let pick = |motors: bool| -> Vec<usize> { (0..nv).filter(|&i| actuated[i] == motors).collect() };
    let (driven, free) = (pick(true), pick(false));
    let (f_free, at_free) = (force.select_rows(&free), rows.select_columns(&free).transpose());
    let (f_driven, at_driven) = (force.select_rows(&driven), rows.select_columns(&driven).transpose());

    let (mut multipliers, null) = solve_with_null_space(&at_free, &f_free);
    let (along, _) = solve_with_null_space(&(&at_driven * &null), &(f_driven - &at_driven * &multipliers));
    multipliers += null * along;

    let rest = force - rows.tr_mul(&multipliers);
    let tau = DVector::from_fn(nv, |i, _| if actuated[i] { rest[i] } else { 0.0 });
    let residual = (rest - &tau).amax_or_zero();
    check_entries("the torque", tau.as_slice())?;
    check_entries("the multipliers", multipliers.as_slice())?;
    Ok(ConstrainedTorque { tau, multipliers, residual })
}

/// The shortest least-squares x of B x = y, and an orthonormal basis of the x with B x = 0.
fn solve_with_null_space(b: &DMatrix<f64>, y: &DVector<f64>) -> (DVector<f64>, DMatrix<f64>) {
    let n = b.ncols();
    if b.nrows() == 0 || n == 0 {
        return (DVector::zeros(n), DMatrix::identity(n, n));
    }
    // Rows of zeros make V square, so that it spans the null space as well.
    let height = b.nrows().max(n);
    let svd = b.clone().resize_vertically(height, 0.0).svd(true, true);
    let y = y.clone().resize_vertically(height, 0.0);
    let (u, vt) = (svd.u.expect("asked for"), svd.v_t.expect("asked for"));
    let negligible = svd.singular_values.amax_or_zero() * f64::EPSILON * 16.0 * height as f64;
    let mut x = DVector::zeros(n);
    let mut null = Vec::new();
    for (k, &sigma) in svd.singular_values.iter().enumerate() {
        let direction = vt.row(k).transpose();
        if sigma > negligible {
            x += direction * (u.column(k).dot(&y) / sigma);
        } else {
            null.push(direction);
        }
    }
    let null = if null.is_empty() { DMatrix::zeros(n, 0) } else { DMatrix::from_columns(&null) };
    (x, null)
}
