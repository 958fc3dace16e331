//! ∂τ and ∂λ of constrained inverse dynamics by q, v and a.
//!
//! With f = ID(q, v, a), e = f − Aᵀλ and the coordinates u without motors and d with motors, λ solves
//!
//! A S_u e = 0,  A S_d e = A S_u Aᵀζ for some ζ,  λ in the range of A,
//!
//! where S_u and S_d keep the coordinates u or d. Let U be an orthonormal basis of the range of Aᵀ, A U = C =
//! Q R, and N the null space of U_u. With x = Uᵀ(Aᵀδλ), h = δ(Aᵀ)λ and y = Aᵀζ, the differentials are
//!
//! x = (U_uᵀU_u)⁺ (C⁺δA e_u + U_uᵀ(δf − h)_u) + N Nᵀ (C⁺δA (e_d − y_u) + U_dᵀ(δf − h)_d),
//!
//! δλ = C⁺ᵀx + (1 − Q Qᵀ) δA z with A z = λ, and δτ = (δf − h − U x)_d. All ranks are those at the state.

use nalgebra::{DMatrix, DVector};
use robot_dynamics_core::{Model, Workspace, mass_matrix};
use robot_dynamics_integrators::check_computed;

use super::super::inverse::{ConstrainedTorque, ConstraintForces, SingularValueSplit, SolvedTorque};
use super::super::{ConstraintError, ConstraintSet};
use super::system::{force_derivative, inverse_derivatives, rate_derivative};

/// Torques and multipliers of a motion, and their derivatives.
#[derive(Clone, Debug, PartialEq)]
#[non_exhaustive]
pub struct ConstrainedTorqueDerivatives {
    /// τ, λ and the residual.
    pub torque: ConstrainedTorque,
    /// ∂τ/∂q, nv×nv; along [`integrate`](robot_dynamics_core::integrate)(q, δ eⱼ) for quaternion joints.
    pub tau_by_position: DMatrix<f64>,
    /// ∂τ/∂v, nv×nv.
    pub tau_by_velocity: DMatrix<f64>,
    /// ∂τ/∂a, nv×nv.
    pub tau_by_acceleration: DMatrix<f64>,
    /// ∂λ/∂q, K×nv.
    pub multipliers_by_position: DMatrix<f64>,
    /// ∂λ/∂v, K×nv.
    pub multipliers_by_velocity: DMatrix<f64>,
    /// ∂λ/∂a, K×nv.
    pub multipliers_by_acceleration: DMatrix<f64>,
}

/// The parts of the differential that depend on the state only.
pub(super) struct TorqueSystem {
    /// U, nv × r.
    pub basis: DMatrix<f64>,
    /// (U_uᵀU_u)⁺, r × r.
    pub gram_inverse: DMatrix<f64>,
    /// N, r × k.
    pub null: DMatrix<f64>,
    /// Q, K × r.
    pub range: DMatrix<f64>,
    /// R, r × r.
    pub triangle: DMatrix<f64>,
    /// e_u, e_d − y_u, and z.
    pub vectors: [DVector<f64>; 3],
}

impl TorqueSystem {
    pub(super) fn new(solved: &SolvedTorque, actuated: &[bool]) -> Self {
        let SolvedTorque { torque, rows, force } = solved;
        let basis = ConstraintForces::new(rows).basis;
        let free: Vec<usize> = (0..actuated.len()).filter(|&i| !actuated[i]).collect();
        let SingularValueSplit { null, pseudo_inverse, .. } =
            SingularValueSplit::of(&basis.select_rows(&free));
        let gram_inverse = &pseudo_inverse * pseudo_inverse.transpose();
        let (range, triangle) = (rows * &basis).qr().unpack();
        let rest = force - rows.tr_mul(&torque.multipliers);
        let unactuated = keep(&rest, actuated, false);
        let driven = keep(&rest, actuated, true);
        let y = &basis * (&gram_inverse * basis.tr_mul(&driven));
        let along = range.tr_mul(&torque.multipliers);
        let along = triangle.solve_upper_triangular(&along).unwrap_or_else(|| along.map(|_| f64::NAN));
        let vectors = [unactuated, driven - keep(&y, actuated, false), &basis * along];
        Self { basis, gram_inverse, null, range, triangle, vectors }
    }

    /// C⁺ X = R⁻¹Qᵀ X.
    fn pseudo_inverse(&self, x: &DMatrix<f64>) -> DMatrix<f64> {
        let along = self.range.tr_mul(x);
        self.triangle.solve_upper_triangular(&along).unwrap_or_else(|| along.map(|_| f64::NAN))
    }

    /// C⁺ᵀ X = Q R⁻ᵀ X.
    pub(super) fn pseudo_inverse_transposed(&self, x: &DMatrix<f64>) -> DMatrix<f64> {
        let along = self.triangle.tr_solve_upper_triangular(x).unwrap_or_else(|| x.map(|_| f64::NAN));
        &self.range * along
    }

    /// C⁺ λ̄, the cotangent of x in λ̄ᵀδλ.
    pub(super) fn pull_multipliers(&self, multipliers: &DVector<f64>) -> DVector<f64> {
        let along = self.range.tr_mul(multipliers);
        self.triangle.solve_upper_triangular(&along).unwrap_or_else(|| along.map(|_| f64::NAN))
    }

    /// δτ and δλ for the columns of δf − h, and for δA times the three vectors, if A changes.
    fn solve(
        &self,
        actuated: &[bool],
        forces: &DMatrix<f64>,
        rates: Option<&[DMatrix<f64>; 3]>,
    ) -> [DMatrix<f64>; 2] {
        let mut on_free = self.basis.tr_mul(&keep_rows(forces, actuated, false));
        let mut on_driven = self.basis.tr_mul(&keep_rows(forces, actuated, true));
        if let Some([first, second, _]) = rates {
            on_free += self.pseudo_inverse(first);
            on_driven += self.pseudo_inverse(second);
        }
        let x = &self.gram_inverse * on_free + &self.null * self.null.tr_mul(&on_driven);
        let mut multipliers = self.pseudo_inverse_transposed(&x);
        if let Some([.., third]) = rates {
            multipliers += third - &self.range * self.range.tr_mul(third);
        }
        [keep_rows(&(forces - &self.basis * x), actuated, true), multipliers]
    }
}

/// The entries of coordinates with (or without) motors; 0 elsewhere.
pub(super) fn keep(x: &DVector<f64>, actuated: &[bool], motors: bool) -> DVector<f64> {
    DVector::from_fn(x.len(), |i, _| if actuated[i] == motors { x[i] } else { 0.0 })
}

/// The rows of coordinates with (or without) motors; 0 elsewhere.
fn keep_rows(x: &DMatrix<f64>, actuated: &[bool], motors: bool) -> DMatrix<f64> {
    let mut kept = x.clone();
    for (i, mut row) in kept.row_iter_mut().enumerate() {
        if actuated[i] != motors {
            row.fill(0.0);
        }
    }
    kept
}

/// Returns τ and λ of [`constrained_inverse_dynamics`](super::super::constrained_inverse_dynamics) with their
/// derivatives by q, v and a.
///
/// If rows depend on others, or motors can supply internal forces, they are the derivatives along which the
/// ranks stay. λ is the shortest one there, too. The function allocates.
///
/// ```
/// use robot_dynamics::constraints::{ConstraintSet, FrameConstraint, SpatialAxis};
/// use robot_dynamics::derivatives::constrained_inverse_dynamics_derivatives;
/// use robot_dynamics::description::{Pose, pendulum};
/// use robot_dynamics::model::{Model, Workspace};
/// // The tip of a rod without a motor is held at its height: λ l cos q = m g l cos q − m l² a.
/// let model = Model::new(pendulum(2.0, 0.5))?;
/// let tip = model.frame_named("tip")?;
/// let hold = FrameConstraint::contact(tip, Pose::IDENTITY, &[SpatialAxis::Z]);
/// let set = ConstraintSet::new(&model, [("hold", hold.into())])?;
/// let w = &mut Workspace::new(&model);
/// let by = constrained_inverse_dynamics_derivatives(&model, w, &set, &[0.3], &[0.0], &[2.0], &[false])?;
/// assert!((by.multipliers_by_acceleration[(0, 0)] + 2.0 * 0.5 / 0.3_f64.cos()).abs() < 1e-13);
/// let rate = -2.0 * 2.0 * 0.5 * 0.3_f64.sin() / 0.3_f64.cos().powi(2);
/// assert!((by.multipliers_by_position[(0, 0)] - rate).abs() < 1e-13);
/// # Ok::<(), Box<dyn std::error::Error>>(())
/// ```
///
/// # Errors
/// Those of [`constrained_inverse_dynamics`](super::super::constrained_inverse_dynamics), and a derivative that
/// is not finite.
///
/// # Panics
/// If a slice has the wrong length.
#[track_caller]
pub fn constrained_inverse_dynamics_derivatives(
    model: &Model,
    workspace: &mut Workspace,
    set: &ConstraintSet,
    q: &[f64],
    v: &[f64],
    a: &[f64],
    actuated: &[bool],
) -> Result<ConstrainedTorqueDerivatives, ConstraintError> {
    let solved = SolvedTorque::new(model, workspace, set, [q, v, a], actuated)?;
    let system = TorqueSystem::new(&solved, actuated);
    let (nv, count) = (model.nv(), set.len());
    let mut mass = DMatrix::zeros(nv, nv);
    mass_matrix(model, workspace, q, mass.as_mut_slice());
    let [mut by_position, by_velocity] = inverse_derivatives(model, workspace, [q, v, a]);
    let mut rates = [(); 3].map(|()| DMatrix::zeros(count, nv));
    if let Some(placed) = set.placed(model, workspace, q) {
        let rest = vec![0.0; nv];
        by_position -=
            force_derivative(&placed.moving(model, q, v, &rest), solved.torque.multipliers.as_slice(), nv);
        for (rate, vector) in rates.iter_mut().zip(&system.vectors) {
            *rate = rate_derivative(&placed.moving(model, q, vector.as_slice(), &rest), count, nv);
        }
    }
    let [tau_by_position, multipliers_by_position] = system.solve(actuated, &by_position, Some(&rates));
    let [tau_by_velocity, multipliers_by_velocity] = system.solve(actuated, &by_velocity, None);
    let [tau_by_acceleration, multipliers_by_acceleration] = system.solve(actuated, &mass, None);
    let by = ConstrainedTorqueDerivatives {
        torque: solved.torque,
        tau_by_position,
        tau_by_velocity,
        tau_by_acceleration,
        multipliers_by_position,
        multipliers_by_velocity,
        multipliers_by_acceleration,
    };
    for (quantity, matrix) in [
        ("∂τ/∂q", &by.tau_by_position),
        ("∂τ/∂v", &by.tau_by_velocity),
        ("∂τ/∂a", &by.tau_by_acceleration),
        ("∂λ/∂q", &by.multipliers_by_position),
        ("∂λ/∂v", &by.multipliers_by_velocity),
        ("∂λ/∂a", &by.multipliers_by_acceleration),
    ] {
        check_computed(quantity, matrix.as_slice())?;
    }
    Ok(by)
}
