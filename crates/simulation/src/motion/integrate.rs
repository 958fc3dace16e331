//! Integration steps on any tree, with the configuration kept on its manifold.
//!
//! [`robot_dynamics_integrators::Integrator`] defines the rows of the table; this module applies each row to
//! a [`Model`]. If every joint has plain coordinates, a step is the same map as there. Quaternions are
//! integrated as follows:
//!
//! | row | method on spherical and floating joints | conserved for a free rigid body |
//! | --- | --- | --- |
//! | explicit stages: Euler, classical Runge–Kutta | Munthe-Kaas: stages in exponential coordinates, of unchanged order up to 4 | nothing; errors have the order of the row |
//! | variational midpoint and its compositions | a discrete action on SO(3) and R³×SO(3) | momenta and K, to round-off |
//!
//! The generalized force τ is constant over the step. Dissipation belongs to the dynamics and depends on v.

mod dense_factor;
pub mod explicit;
mod forces;
mod mass_factor;
pub(crate) mod midpoint;
mod momentum;
mod newton;
mod newton_memory;
mod retraction;
pub mod rounding;
pub mod stage_memory;
pub mod step_stages;
pub(crate) mod variational;
pub mod vectors;
mod workspace;

pub use forces::{StepForces, accelerate, net_force};
pub use mass_factor::MassFactor;
pub use step_stages::{StepStagesWorkspace, step_stages};
pub use workspace::StepWorkspace;

use robot_dynamics_core::Model;
use robot_dynamics_description::check_length;
use robot_dynamics_integrators::{Integrator, IntegratorError, StepScheme};
use robot_dynamics_number::{InvalidInput, check_finite, check_positive};

/// Advances (q, v) in place by `h` \[s\]. It does not allocate; on an error q and v are unchanged.
///
/// # Errors
/// - [`IntegratorError::Input`] if an input is not finite, or `h` is not positive and finite.
/// - [`IntegratorError::NotFinite`] if an acceleration or a result is not finite, with the coordinate.
/// - [`IntegratorError::NotConverged`] if the step of an implicit row is too long: neither fixed-point
///   iteration nor Newton's method finds the solution that short steps lead to.
///
/// # Panics
/// Panics if a slice has the wrong length.
///
/// ```
/// use nalgebra::{Matrix3, Vector3};
/// use robot_dynamics::description::{JointDescription, JointKind, LinkDescription, MassProperties};
/// use robot_dynamics::description::{Pose, RobotDescription};
/// use robot_dynamics::model::Model;
/// use robot_dynamics::simulation::{Integrator, StepForces, StepWorkspace, step};
/// // A pendulum of 1 kg on a rod of 1 m along x, with its axis along y.
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
/// // ½ v² = g sin q: the kinetic energy equals the loss of potential energy.
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
    match integrator.scheme() {
        StepScheme::Explicit(stages) => {
            Ok(explicit::step(model, workspace, (integrator, stages), forces, h, q, v)?)
        }
        StepScheme::Variational(fractions) => {
            variational::compose(model, workspace, forces, (h, fractions), q, v)
        }
    }
}

/// Checks that a step is positive and finite.
pub fn check_step(h: f64) -> Result<(), InvalidInput> {
    check_positive("the step", h, "s")
}
