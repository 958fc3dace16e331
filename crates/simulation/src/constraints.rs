//! Constraints on any tree: closed loops, contacts, rolling, coupled coordinates.
//!
//! A constraint consists of rows A(q) v = 0 with their bias Ȧv, so that A a + Ȧv is the rate of A v. If it
//! comes from a position, it also has an error φ(q), whose rate is A v on the constraint and off it. The
//! constraint force Aᵀλ does no work on an allowed velocity: M a + C v + g = τ + Aᵀλ, A a + Ȧv = 0 **(PRM
//! 10.16)**.
//!
//! | what holds | kind | rows | φ |
//! | --- | --- | --- | --- |
//! | two frames, or a frame and the world, are joined | [`FrameConstraint`] | 1 to 6 of x, y, z, rx, ry, rz | yes |
//! | a frame's own velocity components vanish: skate, blade, wheel | [`NoSlip`] | 1 to 6 | no |
//! | a disc rolls on a plane | [`RollingDisc`] | forward, side, normal | normal only |
//! | Σ cᵢ vᵢ = 0: gears, levers, locked joints | [`Coupling`] | 1 | for plain coordinates |
//! | y = p(x) between two joints or two tendons | [`PolynomialCoupling`] | 1 | yes |

mod anchor;
mod constraint;
mod coupling;
mod derivatives;
mod drift;
mod forward_dynamics;
mod frame_constraint;
mod held;
mod implicit;
mod impulse;
mod inverse;
mod loop_closure;
mod no_slip;
mod options;
mod polynomial_coupling;
mod position_rows;
mod project;
mod projections;
mod rolling;
mod row_factor;
mod rows;
mod run;
mod set;
mod step;
mod support;
mod variational;

pub use crate::equality::error::{ConstraintError, NamedDependentRow};
pub use anchor::{Anchor, SpatialAxis};
pub use constraint::Constraint;
pub use coupling::Coupling;
pub use derivatives::{
    ConstrainedMotionDerivatives, ConstrainedMotionPullback, ConstrainedPullbackInputs,
    ConstrainedTorqueDerivatives, ConstrainedTorquePullback, ConstrainedTorquePullbackInputs,
    ContactImpulseDerivatives, ContactImpulsePullback, ImpulsePullbackInputs,
    constrained_forward_dynamics_derivatives, constrained_forward_dynamics_pullback,
    constrained_inverse_dynamics_derivatives, constrained_inverse_dynamics_pullback,
    contact_impulse_derivatives, contact_impulse_pullback,
};
pub use drift::{ConstraintDrift, constraint_drift};
pub use forward_dynamics::{ConstrainedMotion, constrained_forward_dynamics};
pub use frame_constraint::FrameConstraint;
pub use held::{HeldDynamics, LinearizedHeldStep, LinearizedImpact, RowFeedback};
pub use impulse::{ContactImpulse, contact_impulse};
pub use inverse::{ConstrainedTorque, constrained_inverse_dynamics};
pub use loop_closure::LoopClosure;
pub use no_slip::NoSlip;
pub use options::{Baumgarte, ConstraintOptions, RedundantRows};
pub use polynomial_coupling::PolynomialCoupling;
pub use position_rows::PositionRows;
pub use project::{PositionProjection, project_position, project_velocity};
pub use projections::{TreeProjections, constraint_projections};
pub use rolling::{Plane, RollingDisc, RollingRow};
pub use rows::ConstraintRows;
pub use run::{ConstrainedStepper, ConstraintRecord};
pub use set::ConstraintSet;
pub use step::{ConstrainedStepReport, DriftCorrection, StepConstraints, constrained_step};
pub use support::{ContactSupport, SupportProblem, SupportedTorque, supported_inverse_dynamics};
