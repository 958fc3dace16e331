//! Simulation of kinematic trees: contact, constraints, actuators, sensors, steps and runs.

// Each module uses those before it alone (`cargo xtask tidy` checks).

// The forces of a fluid.
mod fluid;

// Actuators, tendons, passive forces beyond the joints.
mod actuation;

// The places and motions of bodies in the world.
pub(crate) use robot_dynamics_core::kinematics::body_placement as placement;
pub(crate) use robot_dynamics_core::kinematics::motion_columns;

// Rows of equalities.
mod equality;

// Contact.
#[doc(hidden)]
pub mod contact;

// Steps and runs.
#[doc(hidden)]
pub mod motion;

// Sensors.
mod sensors;

// Constraints on velocities.
#[doc(hidden)]
pub mod constraints;

// The simulator.
pub mod simulator;

pub use actuation::{Actuation, ActuationDerivatives, ActuationWorkspace, AffineForces};
pub use constraints::{
    Anchor, Baumgarte, ConstrainedMotion, ConstrainedMotionDerivatives, ConstrainedMotionPullback,
    ConstrainedPullbackInputs, ConstrainedStepReport, ConstrainedTorque, ConstrainedTorqueDerivatives,
    ConstrainedTorquePullback, ConstrainedTorquePullbackInputs, Constraint, ConstraintDrift, ConstraintError,
    ConstraintOptions, ConstraintRecord, ConstraintRows, ConstraintSet, ContactImpulse,
    ContactImpulseDerivatives, ContactImpulsePullback, ContactSupport, Coupling, DriftCorrection,
    FrameConstraint, HeldDynamics, ImpulsePullbackInputs, LinearizedHeldStep, LinearizedImpact, LoopClosure,
    NamedDependentRow, NoSlip, Plane, PolynomialCoupling, PositionProjection, RedundantRows, RollingDisc,
    RollingRow, RowFeedback, SpatialAxis, StepConstraints, SupportProblem, SupportedTorque, TreeProjections,
    constrained_forward_dynamics, constrained_forward_dynamics_derivatives,
    constrained_forward_dynamics_pullback, constrained_inverse_dynamics,
    constrained_inverse_dynamics_derivatives, constrained_inverse_dynamics_pullback, constrained_step,
    constraint_drift, constraint_projections, contact_impulse, contact_impulse_derivatives,
    contact_impulse_pullback, project_position, project_velocity, supported_inverse_dynamics,
};
pub use contact::{
    ActiveSet, ContactLaw, ContactLaws, ContactPoint, ContactProblem, ContactSet, ContactViolation, Ground,
    HeightField, SoftConstraints, SoftContact, SoftDynamicsInputs,
};
pub use fluid::{FluidForces, FluidWorkspace};
pub use motion::RobotState;
pub use motion::contact_step::{ContactStep, ContactStepInputs};
pub use motion::implicit::ImplicitIntegrator;
pub use motion::integrate::step_stages::step_stages;
pub use motion::integrate::{StepForces, StepStagesWorkspace, StepWorkspace, step};
pub use motion::linearize_step::{
    LinearizationMethod, LinearizeStepWorkspace, LinearizedStep, LinearizedStepWithParameters,
    LinearizedSteps, linearize_by_differences, linearize_step, linearize_stepper,
    linearize_stepper_with_parameters,
};
pub use motion::mujoco_euler::MujocoEuler;
pub use motion::pullback::{
    MotionCotangents, Rollout, RolloutPullbackWorkspace, StepPullbackWorkspace, StepperPullbackWorkspace,
    StepperRollout, TrajectoryCotangents, rollout_pullback, rollout_pullback_by_stepper, step_pullback,
    stepper_pullback,
};
#[cfg(feature = "adaptive")]
pub use motion::simulate::{AdaptiveMethod, AdaptiveOptions, AdaptiveRecord, ControlTiming, StepStatistics};
pub use motion::simulate::{
    CallbackError, ConstantTorque, Controller, ControllerError, Delayed, DivergenceCause, Event,
    EventOccurrence, GravityAt, GravityCompensatedPd, ImplicitGains, IntoCallbackResult, Losses, Run,
    RunError, RunFailure, Sample, StateTransition, StepError, StepInfo, Stepper, Trajectory,
    WithImplicitGains, ZeroTorque, energy_account, record_step, steps_in,
};
pub use sensors::{PointForce, SensorInputs, SensorMemory, SensorSet};
