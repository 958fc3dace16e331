//! Dynamics of any robot: M(q) v̇ + C(q,v) v + g(q) = τ for trees of rigid bodies, in O(n).
//!
//! A [`RobotDescription`] (from a URDF file by the crate `urdf`, or by hand) is compiled into a [`Model`], which is
//! immutable and checked. Each algorithm is a function of the model, a caller's [`Workspace`] and slices; none
//! allocates. The methods of [`Model`] do the same with vectors and check their input.
//!
//! ```
//! use multibody::{Model, RandomRobotOptions, Workspace, inverse_dynamics, neutral, random_robot};
//! let model = Model::new(random_robot(3, &RandomRobotOptions::default()))?; // any robot
//! let (mut workspace, mut tau) = (Workspace::new(&model), vec![0.0; model.nv()]);
//! let (q, rest) = (neutral(&model), vec![0.0; model.nv()]);
//! inverse_dynamics(&model, &mut workspace, &q, &rest, &rest, &mut tau); // holds the robot against gravity
//! assert_eq!(tau, model.gravity_forces(&q)?.as_slice());
//! # Ok::<(), Box<dyn std::error::Error>>(())
//! ```
//!
//! | question | functions |
//! | --- | --- |
//! | which forces for a motion | [`inverse_dynamics`], [`bias`], [`gravity`], [`velocity_product`], [`dissipation`] |
//! | which motion from forces | [`forward_dynamics`], [`constrained_forward_dynamics`] |
//! | the matrices of the equation | [`mass_matrix`], [`inverse_mass_matrix`], [`coriolis_matrix`], [`christoffel_symbols`], [`mass_matrix_rate`] |
//! | where, and how fast, is a frame | [`frame_poses`], [`frame_velocity_world_aligned`], [`frame_jacobian_world_aligned`] and their kin |
//! | the robot as a whole | [`center_of_mass`], [`centroidal_momentum`], [`kinetic_energy`], [`potential_energy`], [`momentum`] |
//! | slopes of all this | [`inverse_dynamics_derivatives`], [`forward_dynamics_derivatives`], [`linearize_step`] |
//! | loops, contacts, rolling | [`ConstraintSet`], [`constrained_inverse_dynamics`], [`contact_impulse`], [`ConstrainedSimulation`] |
//! | control | [`ComputedTorque`], [`operational_space`], [`TaskControl`], [`GravityCompensatedPd`], [`time_optimal`] |
//! | simulation | [`Simulation`], [`step`], [`integrate`] on the configuration space |
//! | which parameters has this robot | [`joint_torque_regressor`], [`BaseParameters`] |
//! | many states at once | [`batch`]: lanes and threads |
//! | are its numbers in the right units | [`plausibility`] |
//! | is it right | [`lagrange`]: the same from V, M and their derivatives, sharing no code with the recursions |
//!
//! Six-vectors are linear before angular; quaternions x y z w; angles in radians, lengths in metres; M and the
//! Jacobians row-major. [`conventions`] converts to and from others. Every function is generic over
//! [`Scalar`](dynamics::Scalar): `f64`, `f32`, and dual numbers for derivatives of anything.

mod algebra;
mod allocating;
pub mod batch;
mod center_of_mass;
mod centroidal;
mod cholesky;
mod christoffel;
mod compile;
mod compiled_once;
mod configuration;
mod configuration_rate;
mod constraint;
pub mod conventions;
mod coriolis;
mod derivatives;
mod description;

mod dissipation;
mod energy;
mod error;
mod fixed_size;
mod forward_dynamics;
mod identification;
mod identity;

mod integrate;
mod inverse_dynamics;
mod inverse_mass_matrix;
mod jacobian;
mod kinematics;
pub mod lagrange;
mod linearize_step;
mod mass_matrix;
mod mass_matrix_rate;
mod model;
mod momentum;
mod momentum_block;
mod motion_error;
mod operational_space;
mod place;
pub mod plausibility;
mod pose;
mod quaternion;
mod random_robot;
mod rank;
mod reference_point;
mod regressor;
mod report;
mod screws;
mod shape;
mod simulate;
mod sparse_cholesky;
mod surgery;
mod time_parameterization;
mod validate;
mod workspace;
mod wrench;

pub use allocating::{ForwardSlopes, InverseSlopes};
pub use center_of_mass::{
    center_of_mass, center_of_mass_bias_acceleration, center_of_mass_jacobian, center_of_mass_velocity,
};
pub use centroidal::{
    CentroidalMomentum, centroidal_momentum, centroidal_momentum_bias_rate, centroidal_momentum_matrix,
    centroidal_momentum_rate,
};
pub use christoffel::christoffel_symbols;
pub use configuration::{
    ConfigurationError, check_configuration, difference, integrate, interpolate, neutral,
    normalize_quaternions, random_within_limits,
};
pub use constraint::{
    Anchor, Baumgarte, Closure, ClosureRow, ConstrainedMotion, ConstrainedMotionError, ConstrainedRun,
    ConstrainedRunFailure, ConstrainedSimulation, ConstrainedStepReport, ConstrainedTorque, Constraint,
    ConstraintDrift, ConstraintOptions, ConstraintRows, ConstraintSet, ConstraintSetError, ContactImpulse,
    Coupling, DriftCorrection, LoopClosure, NamedDependentRow, NoSlip, Plane, PositionProjection,
    RedundantRows, RollingDisc, RollingRow, TreeProjections, constrained_forward_dynamics,
    constrained_inverse_dynamics, constrained_step, constraint_drift, constraint_projections,
    contact_impulse, project_position, project_velocity,
};
pub use coriolis::coriolis_matrix;
pub use derivatives::{
    center_of_mass_velocity_derivative, forward_dynamics_derivatives,
    forward_dynamics_derivatives_with_wrenches, frame_acceleration_derivatives_in_frame,
    frame_acceleration_derivatives_world_aligned, frame_velocity_derivative_in_frame,
    frame_velocity_derivative_world_aligned, gravity_derivative, inverse_dynamics_derivatives,
    inverse_dynamics_derivatives_with_wrenches,
};
pub use description::{
    Base, EARTH_GRAVITY, FLOATING_BASE, FrameDescription, JointDescription, JointKind, Limits,
    LinkDescription, Mimic, PassiveForces, RobotDescription,
};
pub use dissipation::{dissipation, dissipation_derivative};
pub use energy::{kinetic_energy, potential_energy};
pub use error::ModelError;
pub use fixed_size::{FixedSize, FixedSizeError};
pub use forward_dynamics::{forward_dynamics, forward_dynamics_by_cholesky, forward_dynamics_with_wrenches};
pub use identification::{
    BaseParameter, BaseParameters, IdentificationError, Identified, LinkConsistency, MotionRecord,
    inertial_parameter_names, physical_consistency, pseudo_inertia,
};
pub use integrate::{StepForces, StepWorkspace, step};
pub use inverse_dynamics::{
    bias, gravity, inverse_dynamics, inverse_dynamics_with_wrenches, velocity_product,
};
pub use inverse_mass_matrix::inverse_mass_matrix;
pub use jacobian::{
    frame_bias_acceleration_in_frame, frame_bias_acceleration_in_world,
    frame_bias_acceleration_world_aligned, frame_jacobian_in_frame, frame_jacobian_in_world,
    frame_jacobian_world_aligned,
};
pub use kinematics::{
    FramePose, Twist, frame_classical_acceleration_world_aligned, frame_pose, frame_poses,
    frame_spatial_acceleration_in_frame, frame_spatial_acceleration_in_world, frame_velocity_in_frame,
    frame_velocity_in_world, frame_velocity_world_aligned,
};
pub use linearize_step::{LinearizeStepError, LinearizeStepWorkspace, linearize_step};
pub use mass_matrix::mass_matrix;
pub use mass_matrix_rate::mass_matrix_rate;
pub use model::{Frame, FrameId, Joint, Model};
pub use momentum::{kinetic_energy_gradient, momentum};
pub use motion_error::MotionError;
pub use number::InstructionSet;
pub use operational_space::{
    ComputedTorque, OperationalSpace, OperationalSpaceError, OperationalSpaceWorkspace, PoseReference,
    Reference, TaskControl, TaskGains, TaskReference, TaskTarget, operational_space, operational_space_into,
};
pub use pose::Pose;
pub use quaternion::Quaternion;
pub use random_robot::{JointKinds, RandomRobotOptions, RandomState, random_robot, random_state};
pub use rank::{SingularMass, SingularMotion, check_rank, mass_rank};
pub use regressor::{
    PARAMETERS_PER_LINK, inertial_parameters, joint_torque_regressor, kinetic_energy_regressor,
    potential_energy_regressor,
};
pub use report::{Counts, Finding, LoadReport, Severity, Treatment};
pub use shape::{LinkShape, Shape, ShapeRole};
#[cfg(feature = "adaptive")]
pub use simulate::{
    AdaptiveEnd, AdaptiveError, AdaptiveFailure, AdaptiveRun, AdaptiveSimulation, ControlTiming, Event,
    EventOccurrence, StepStatistics,
};
pub use simulate::{
    CallbackError, ConstantTorque, Controller, ControllerError, EnergyLedger, GravityAt,
    GravityCompensatedPd, Moment, Outcome, Run, RunError, RunFailure, Sample, Simulation, Trajectory,
    ZeroTorque,
};
pub use surgery::SurgeryError;
pub use time_parameterization::{
    Collocation, CubicSpline, LimitUse, MotionLimits, ParameterizationError, PathCoefficients, PathMoment,
    SplineError, TimeOptimal, TimedPath, TreePath, TreePathPoint, limit_use, path_coefficients, time_optimal,
};
pub use workspace::Workspace;
pub use wrench::FrameWrench;
