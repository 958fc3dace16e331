//! Motion in time: one step of an integrator on any tree, with its configuration kept on its manifold.
//!
//! The rows of the table are [`dynamics::Integrator`]'s; here each row runs on a [`Model`]. Where every q is a
//! plain number, a step is the same map as there. Quaternions take part as follows:
//!
//! | row | on spherical and floating joints | keeps of a free rigid body |
//! | --- | --- | --- |
//! | explicit stages: Euler's, the classical Runge–Kutta | Munthe-Kaas: stages in the exponential's coordinates, their order kept up to 4 | nothing; the error of the order |
//! | variational midpoint and its compositions | a discrete action on SO(3) and R³×SO(3) | momenta and K, to round-off |
//!
//! The generalized force τ is held over the step. Dissipation is part of the dynamics and follows v.

mod dense_factor;
pub(crate) mod explicit;
mod mass_factor;
mod momentum;
mod newton;
mod retraction;
pub(crate) mod rounding;
mod step_stages;
pub(crate) mod variational;
mod workspace;

pub(crate) use mass_factor::MassFactor;
pub use step_stages::{StepStagesWorkspace, step_stages};
pub use workspace::StepWorkspace;

use dynamics::{DynamicsError, Integrator, IntegratorError, Method, Scalar, check_finite};

use crate::model::length::check_length;
use crate::{Model, Workspace, dissipation, forward_dynamics};

/// What acts on the joints during one step.
#[derive(Clone, Copy, Debug, PartialEq)]
#[non_exhaustive]
pub struct StepForces<'a, S = f64> {
    /// Generalized forces τ of the motors, held over the step, nv entries \[N·m or N\].
    pub tau: &'a [S],
    /// Whether the joints' damping and friction act. Springs and armature always do.
    ///
    /// Damping is taken at every velocity a method visits. So is the sign of the Coulomb friction, except
    /// in the implicit rows: there it is the sign at the start of the step.
    pub dissipation: bool,
}

impl<'a, S> StepForces<'a, S> {
    /// τ held over the step, with damping and friction or without.
    pub const fn new(tau: &'a [S], dissipation: bool) -> Self {
        Self { tau, dissipation }
    }
}

/// Advances (q, v) in place by `h` \[s\]. No allocation; on an error q and v are left as they were.
///
/// # Errors
/// [`IntegratorError::Dynamics`] where an input, an acceleration or a result is not finite, with the coordinate;
/// [`IntegratorError::BadStep`] where `h` is not positive and finite;
/// [`IntegratorError::NotConverged`] where an implicit row's step is too long: neither the plain iteration nor Newton's
/// method finds a solution that short steps lead to.
///
/// # Panics
/// If a slice has the wrong length.
///
/// ```
/// use dynamics::{Integrator, MassProperties};
/// use multibody::{JointDescription, JointKind, LinkDescription, Model, Pose, RobotDescription};
/// use multibody::{StepForces, StepWorkspace, step};
/// use nalgebra::{Matrix3, Vector3};
/// // A pendulum: 1 kg on a rod of 1 m along x, turning about y.
/// let mut robot = RobotDescription::new("pendulum");
/// let bob = MassProperties::new(1.0, Vector3::new(1.0, 0.0, 0.0), Matrix3::zeros())?;
/// robot.links.push(LinkDescription::new("ceiling", None));
/// robot.links.push(LinkDescription::new("rod", bob));
/// let hinge = JointKind::Revolute { axis: [0.0, 1.0, 0.0] };
/// robot.joints.push(JointDescription::new("hinge", hinge, "ceiling", "rod", Pose::IDENTITY));
/// let model = Model::new(robot)?;
/// let (mut q, mut v) = ([0.0], [0.0]);
/// let forces = StepForces::new(&[0.0], false);
/// let mut workspace = StepWorkspace::new(&model);
/// for _ in 0..100 {
///     step(&model, Integrator::RungeKutta4, &mut workspace, &forces, 0.001, &mut q, &mut v)?;
/// }
/// // ½ v² = g sin q: what it fell, it gained.
/// assert!((0.5 * v[0] * v[0] - 9.81 * q[0].sin()).abs() < 1e-12);
/// # Ok::<(), Box<dyn std::error::Error>>(())
/// ```
#[track_caller]
pub fn step(
    model: &Model,
    integrator: Integrator,
    workspace: &mut StepWorkspace,
    forces: &StepForces<'_>,
    h: f64,
    q: &mut [f64],
    v: &mut [f64],
) -> Result<(), IntegratorError> {
    check_step(h)?;
    check_length("q", q.len(), model.nq);
    check_length("v", v.len(), model.nv);
    check_length("tau", forces.tau.len(), model.nv);
    for (quantity, values) in [("q", &*q), ("v", &*v), ("tau", forces.tau)] {
        check_finite(quantity, values)?;
    }
    match integrator.method() {
        Method::Explicit(stages) => {
            Ok(explicit::step(model, workspace, (integrator, stages), forces, h, q, v)?)
        }
        Method::Variational(fractions) => {
            variational::compose(model, workspace, forces, (h, fractions), q, v)
        }
    }
}

/// Refuses a step that is not positive and finite.
pub(crate) fn check_step(h: f64) -> Result<(), IntegratorError> {
    if h > 0.0 && h.is_finite() { Ok(()) } else { Err(IntegratorError::BadStep { step: h }) }
}

/// a = M⁻¹(τ − b(v) − C v − g) at the state (q, v); τ − b(v) to `force`.
pub(crate) fn accelerate(
    model: &Model,
    workspace: &mut Workspace,
    forces: &StepForces<'_>,
    force: &mut [f64],
    (q, v): (&[f64], &[f64]),
    acceleration: &mut [f64],
) -> Result<(), DynamicsError> {
    net_force(model, forces, v, force);
    forward_dynamics(model, workspace, q, v, force, acceleration);
    check_finite("the acceleration", acceleration)
}

/// τ − b(v).
pub(crate) fn net_force<S: Scalar>(model: &Model, forces: &StepForces<'_, S>, v: &[S], force: &mut [S]) {
    if forces.dissipation {
        dissipation(model, v, force);
        force.iter_mut().zip(forces.tau).for_each(|(b, tau)| *b = *tau - *b);
    } else {
        force.copy_from_slice(forces.tau);
    }
}
