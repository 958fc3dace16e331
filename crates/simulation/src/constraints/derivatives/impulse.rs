//! The derivatives of the velocity jump at an impact.
//!
//! M (v⁺ − v⁻) = Aᵀι and A v⁺ = −e A v⁻ have the differentials
//!
//! M δv⁺ − Aᵀδι = M δv⁻ − δM (v⁺ − v⁻) + δ(Aᵀ)ι,  A δv⁺ = −e A δv⁻ − δA (v⁺ + e v⁻) − δe A v⁻.
//!
//! δM w is the change of inverse dynamics at v = 0 and a = w, less that at a = 0.

use nalgebra::{DMatrix, DVector};
use robot_dynamics_core::{Model, Workspace};
use robot_dynamics_description::check_length;
use robot_dynamics_integrators::check_computed;
use robot_dynamics_number::check_finite;

use super::super::impulse::{ContactImpulse, SolvedImpact};
use super::super::{ConstraintError, ConstraintOptions, ConstraintSet};
use super::system::{
    force_derivative, inverse_derivatives, pull_inverse_dynamics, rate_derivative, solve_system,
};

/// An impact and its derivatives.
#[derive(Clone, Debug, PartialEq)]
#[non_exhaustive]
pub struct ContactImpulseDerivatives {
    /// The impact: v⁺, ι and the loss of energy.
    pub impact: ContactImpulse,
    /// ∂v⁺/∂q, nv×nv; along [`integrate`](robot_dynamics_core::integrate)(q, δ eⱼ) for quaternion joints.
    pub velocity_by_position: DMatrix<f64>,
    /// ∂v⁺/∂v⁻, nv×nv: 1 − (1 + e) M⁻¹AᵀΛ⁻¹A.
    pub velocity_by_velocity: DMatrix<f64>,
    /// ∂v⁺/∂e, nv.
    pub velocity_by_restitution: DVector<f64>,
    /// ∂ι/∂q, K×nv.
    pub impulse_by_position: DMatrix<f64>,
    /// ∂ι/∂v⁻, K×nv.
    pub impulse_by_velocity: DMatrix<f64>,
    /// ∂ι/∂e, K.
    pub impulse_by_restitution: DVector<f64>,
}

/// Returns v⁺ and ι of [`contact_impulse`](super::super::contact_impulse) with their derivatives by q, v⁻ and
/// the restitution e.
///
/// The impulses of dependent rows are 0 with all their derivatives. The derivatives are those along which the
/// rank stays. The function allocates.
///
/// ```
/// use robot_dynamics::constraints::{ConstraintOptions, ConstraintSet, FrameConstraint, SpatialAxis};
/// use robot_dynamics::derivatives::contact_impulse_derivatives;
/// use robot_dynamics::description::{Pose, pendulum};
/// use robot_dynamics::model::{Model, Workspace};
/// // The tip of a rod meets the floor: v⁺ = −e v⁻, and ι l cos q = (1 + e) m l² v⁻.
/// let model = Model::new(pendulum(2.0, 0.5))?;
/// let tip = model.frame_named("tip")?;
/// let floor = FrameConstraint::contact(tip, Pose::IDENTITY, &[SpatialAxis::Z]);
/// let set = ConstraintSet::new(&model, [("floor", floor.into())])?;
/// let (w, options) = (&mut Workspace::new(&model), ConstraintOptions::default());
/// let by = contact_impulse_derivatives(&model, w, &set, &options, &[0.3], &[2.0], 0.5)?;
/// assert!((by.velocity_by_velocity[(0, 0)] + 0.5).abs() < 1e-14);
/// assert!((by.velocity_by_restitution[0] + 2.0).abs() < 1e-14);
/// let impulse = 1.5 * 2.0 * 0.25 * 2.0 / (0.5 * 0.3_f64.cos());
/// assert!((by.impulse_by_position[(0, 0)] - impulse * 0.3_f64.tan()).abs() < 1e-13);
/// # Ok::<(), Box<dyn std::error::Error>>(())
/// ```
///
/// # Errors
/// Those of [`contact_impulse`](super::super::contact_impulse), and a derivative that is not finite.
///
/// # Panics
/// If a slice has the wrong length, or the restitution e is outside \[0, 1\].
#[track_caller]
pub fn contact_impulse_derivatives(
    model: &Model,
    workspace: &mut Workspace,
    set: &ConstraintSet,
    options: &ConstraintOptions,
    q: &[f64],
    v: &[f64],
    restitution: f64,
) -> Result<ContactImpulseDerivatives, ConstraintError> {
    let SolvedImpact { impact, mass, factor, .. } =
        SolvedImpact::new(model, workspace, (set, options), (q, v), restitution)?;
    let (nv, count) = (model.nv(), set.len());
    let (before, rest) = (DVector::from_column_slice(v), vec![0.0; nv]);
    let jump = &impact.velocity - &before;
    let [with, _] = inverse_derivatives(model, workspace, [q, &rest, jump.as_slice()]);
    let [without, _] = inverse_derivatives(model, workspace, [q, &rest, &rest]);
    let mut force = without - with;
    let mut rate = DMatrix::zeros(count, nv);
    if let Some(placed) = set.placed(model, workspace, q) {
        let sum = &impact.velocity + &before * restitution;
        let moving = placed.moving(model, q, sum.as_slice(), &rest);
        force += force_derivative(&moving, impact.impulse.as_slice(), nv);
        rate -= rate_derivative(&moving, count, nv);
    }
    let [velocity_by_position, impulse_by_position] = solve_system(&mass, &factor, force, &rate);
    let along = &factor.forces * &before;
    let by = ContactImpulseDerivatives {
        velocity_by_position,
        velocity_by_velocity: DMatrix::identity(nv, nv)
            - factor.responses.tr_mul(&factor.forces) * (1.0 + restitution),
        velocity_by_restitution: -factor.responses.tr_mul(&along),
        impulse_by_position,
        impulse_by_velocity: factor.solve_transposed_columns(&factor.forces) * -(1.0 + restitution),
        impulse_by_restitution: -factor.solve_triangle_transposed(&along),
        impact,
    };
    for (quantity, values) in [
        ("∂v⁺/∂q", by.velocity_by_position.as_slice()),
        ("∂v⁺/∂v⁻", by.velocity_by_velocity.as_slice()),
        ("∂v⁺/∂e", by.velocity_by_restitution.as_slice()),
        ("∂ι/∂q", by.impulse_by_position.as_slice()),
        ("∂ι/∂v⁻", by.impulse_by_velocity.as_slice()),
        ("∂ι/∂e", by.impulse_by_restitution.as_slice()),
    ] {
        check_computed(quantity, values)?;
    }
    Ok(by)
}

/// An impact and the gradient of v̄ᵀv⁺ + ῑᵀι.
#[derive(Clone, Debug, PartialEq)]
#[non_exhaustive]
pub struct ContactImpulsePullback {
    /// The impact: v⁺, ι and the loss of energy.
    pub impact: ContactImpulse,
    /// The gradient by q, nv numbers; along [`integrate`](robot_dynamics_core::integrate)(q, δ eⱼ) for
    /// quaternion joints.
    pub by_position: DVector<f64>,
    /// The gradient by v⁻, nv numbers.
    pub by_velocity: DVector<f64>,
    /// The gradient by the restitution.
    pub by_restitution: f64,
}

/// The inputs of [`contact_impulse_pullback`].
#[derive(Clone, Copy, Debug)]
pub struct ImpulsePullbackInputs<'a> {
    /// The configuration, nq numbers.
    pub q: &'a [f64],
    /// v⁻, nv numbers \[rad/s, m/s\].
    pub v: &'a [f64],
    /// e.
    pub restitution: f64,
    /// v̄, the cotangent of v⁺, nv numbers.
    pub velocity: &'a [f64],
    /// ῑ, the cotangent of the impulses, K numbers.
    pub impulse: &'a [f64],
}

/// Returns v⁺ and ι of [`contact_impulse`](super::super::contact_impulse) and the gradient of v̄ᵀv⁺ + ῑᵀι by q,
/// v⁻ and the restitution. It equals the cotangents times the matrices of
/// [`contact_impulse_derivatives`](super::super::contact_impulse_derivatives). The function allocates.
///
/// ```
/// use robot_dynamics::constraints::{ConstraintOptions, ConstraintSet, FrameConstraint, SpatialAxis};
/// use robot_dynamics::derivatives::{ImpulsePullbackInputs, contact_impulse_pullback};
/// use robot_dynamics::description::{Pose, pendulum};
/// use robot_dynamics::model::{Model, Workspace};
/// // The tip of a rod meets the floor: v⁺ = −e v⁻.
/// let model = Model::new(pendulum(2.0, 0.5))?;
/// let tip = model.frame_named("tip")?;
/// let floor = FrameConstraint::contact(tip, Pose::IDENTITY, &[SpatialAxis::Z]);
/// let set = ConstraintSet::new(&model, [("floor", floor.into())])?;
/// let (w, options) = (&mut Workspace::new(&model), ConstraintOptions::default());
/// let (q, v) = (&[0.3], &[2.0]);
/// let inputs = ImpulsePullbackInputs { q, v, restitution: 0.5, velocity: &[3.0], impulse: &[0.0] };
/// let by = contact_impulse_pullback(&model, w, &set, &options, inputs)?;
/// assert!((by.by_velocity[0] + 3.0 * 0.5).abs() < 1e-13 && (by.by_restitution + 3.0 * 2.0).abs() < 1e-13);
/// # Ok::<(), Box<dyn std::error::Error>>(())
/// ```
///
/// # Errors
/// Those of [`contact_impulse`](super::super::contact_impulse), and a cotangent or a gradient that is not
/// finite.
///
/// # Panics
/// If a slice has the wrong length, or the restitution e is outside \[0, 1\].
#[track_caller]
pub fn contact_impulse_pullback(
    model: &Model,
    workspace: &mut Workspace,
    set: &ConstraintSet,
    options: &ConstraintOptions,
    inputs: ImpulsePullbackInputs<'_>,
) -> Result<ContactImpulsePullback, ConstraintError> {
    let ImpulsePullbackInputs { q, v, restitution, velocity, impulse } = inputs;
    check_length("the cotangent of v⁺", velocity.len(), model.nv());
    check_length("the cotangent of the impulse", impulse.len(), set.len());
    check_finite("the cotangent of v⁺", velocity)?;
    check_finite("the cotangent of the impulse", impulse)?;
    let SolvedImpact { impact, mass, factor, rows } =
        SolvedImpact::new(model, workspace, (set, options), (q, v), restitution)?;
    let (before, rest) = (DVector::from_column_slice(v), vec![0.0; model.nv()]);
    let [mu, y] = solve_system(
        &mass,
        &factor,
        DMatrix::from_column_slice(model.nv(), 1, velocity),
        &-DMatrix::from_column_slice(set.len(), 1, impulse),
    );
    let [mu, y] = [mu, y].map(|matrix| DVector::from_column_slice(matrix.as_slice()));
    let jump = &impact.velocity - &before;
    let negative = -&mu;
    let [with, ..] = pull_inverse_dynamics(model, workspace, [q, &rest, jump.as_slice()], &negative, &mut []);
    let [without, ..] = pull_inverse_dynamics(model, workspace, [q, &rest, &rest], &negative, &mut []);
    let mut by_position = with - without;
    if let Some(placed) = set.placed(model, workspace, q) {
        let sum = &impact.velocity + &before * restitution;
        let slice = by_position.as_mut_slice();
        placed.moving(model, q, mu.as_slice(), &rest).add_rate_gradient(impact.impulse.as_slice(), slice);
        placed.moving(model, q, sum.as_slice(), &rest).add_rate_gradient(y.as_slice(), slice);
    }
    let by_velocity = &mass.mass * &mu + rows.tr_mul(&y) * restitution;
    let by_restitution = y.dot(&(&rows * &before));
    check_computed("the gradient by q", by_position.as_slice())?;
    check_computed("the gradient by v⁻", by_velocity.as_slice())?;
    check_computed("the gradient by the restitution", &[by_restitution])?;
    Ok(ContactImpulsePullback { impact, by_position, by_velocity, by_restitution })
}
