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
//! | which forces for a motion | [`inverse_dynamics`], [`bias`], [`gravity`], [`velocity_product`], [`dissipation`], [`joint_reactions`] |
//! | which motion from forces | [`forward_dynamics`], [`constrained_forward_dynamics`] |
//! | the matrices of the equation | [`mass_matrix`], [`mass_matrix_factor`], [`inverse_mass_matrix`], [`coriolis_matrix`], [`christoffel_symbols`], [`mass_matrix_rate`] |
//! | where, and how fast, is a frame | [`frame_poses`], [`frame_velocity_world_aligned`], [`frame_jacobian_world_aligned`] and their kin |
//! | which joints bring a frame into place | [`inverse_kinematics`] |
//! | the robot as a whole | [`center_of_mass`], [`centroidal_momentum`], [`kinetic_energy`], [`potential_energy`], [`momentum`] |
//! | slopes of all this | [`inverse_dynamics_derivatives`], [`forward_dynamics_derivatives`], [`linearize_step`], [`linearize_by_differences`] |
//! | gradients of a loss, without the slopes | [`inverse_dynamics_pullback`], [`forward_dynamics_pullback`], [`step_pullback`], [`rollout_pullback`] |
//! | loops, contacts, rolling | [`ConstraintSet`], [`constrained_inverse_dynamics`], [`supported_inverse_dynamics`], [`contact_impulse`], [`constrained_step`] |
//! | control | [`dlqr`](dynamics::dlqr), [`ComputedTorque`], [`operational_space`], [`TaskControl`], [`GravityCompensatedPd`], [`time_optimal`] |
//! | simulation | [`SimulationBuilder`](simulator::SimulationBuilder), [`Simulation`](simulator::Simulation), [`Event`], [`step`], [`integrate`] on the configuration space |
//! | the same robot with joints locked | [`RobotDescription::lock_joint`], [`JointMap`] |
//! | which parameters has this robot | [`joint_torque_regressor`], [`BaseParameters`] |
//! | many states at once | [`batch`]: lanes and threads |
//! | what its sensors show | [`SensorDescription`], [`SensorSet`] |
//! | are its numbers in the right units | [`plausibility`] |
//! | is it right | [`lagrange`]: the same from V, M and their derivatives, sharing no code with the recursions; [`admm`]: contact's law by another method |
//!
//! Six-vectors are linear before angular; quaternions x y z w; angles in radians, lengths in metres; M and the
//! Jacobians row-major. [`conventions`] converts to and from others. Every function is generic over
//! [`Scalar`](dynamics::Scalar): `f64`, `f32`, and dual numbers for derivatives of anything.

// Rooms, each of which uses those before it alone (`cargo xtask tidy` looks). Copies that keep their capacity;
mod clone_in_place;

// names in outputs of each kind;
pub mod text;

// vectors, rotations, six-vectors;
mod spatial;

// how joints move;
mod joint;

// the robot as described, checked and compiled;
mod model;

// what looks like a wrong unit in it;
pub mod plausibility;

// its configuration space;
mod space;

// factors of M;
mod factor;

// the memory of the recursions, and what runs a recursion on it;
mod scratch;

// what several recursions begin with;
mod stages;

// the equation of motion,
mod algorithms;

// what drives it,
mod actuation;

// where it touches the ground,
mod contact;

// what its sensors show,
mod sensors;

// its slopes,
mod derivatives;

// and the second route to both;
mod oracle;

// motion in time;
mod motion;

// loops, contacts, rolling;
mod constraint;

// all of it in steps;
pub mod simulator;

// control,
mod control;

// planning,
mod planning;

// identification;
mod identification;

// many states at once;
#[cfg(feature = "batch")]
pub mod batch;

// all of it as a table,
mod quantity;

// and against itself.
pub mod audit;

pub use oracle::{admm, lagrange};
pub use space::conventions;

pub use actuation::{Actuation, ActuationWorkspace};
pub use algorithms::center_of_mass::{
    center_of_mass, center_of_mass_bias_acceleration, center_of_mass_jacobian, center_of_mass_velocity,
};
pub use algorithms::centroidal::{
    CentroidalMomentum, centroidal_momentum, centroidal_momentum_bias_rate, centroidal_momentum_matrix,
    centroidal_momentum_rate,
};
pub use algorithms::christoffel::christoffel_symbols;
pub use algorithms::coriolis::coriolis_matrix;
pub use algorithms::dissipation::{dissipation, dissipation_derivative};
pub use algorithms::energy::{kinetic_energy, potential_energy};
#[doc(hidden)]
pub use algorithms::forward_dynamics::inverse_pivots;
pub use algorithms::forward_dynamics::{forward_dynamics, forward_dynamics_with_wrenches};
pub use algorithms::forward_dynamics_by_cholesky::forward_dynamics_by_cholesky;
pub use algorithms::frame_motion::{
    Twist, frame_classical_acceleration_world_aligned, frame_spatial_acceleration_in_frame,
    frame_spatial_acceleration_in_world, frame_velocity_in_frame, frame_velocity_in_world,
    frame_velocity_world_aligned,
};
pub use algorithms::inverse_dynamics::{
    bias, gravity, inverse_dynamics, inverse_dynamics_with_wrenches, velocity_product,
};
pub use algorithms::inverse_mass_matrix::inverse_mass_matrix;
pub use algorithms::jacobian::{
    frame_bias_acceleration_in_frame, frame_bias_acceleration_in_world,
    frame_bias_acceleration_world_aligned, frame_jacobian_in_frame, frame_jacobian_in_world,
    frame_jacobian_world_aligned,
};
pub use algorithms::joint_reactions::joint_reactions;
pub use algorithms::kinematics::{FramePose, frame_pose, frame_poses};
pub use algorithms::mass_matrix::{mass_matrix, mass_matrix_related_entries};
pub use algorithms::mass_matrix_factor::mass_matrix_factor;
pub use algorithms::mass_matrix_rate::mass_matrix_rate;
pub use algorithms::momentum::{kinetic_energy_gradient, momentum};
pub use algorithms::motion_error::MotionError;
pub use algorithms::rank::{SingularMass, SingularMotion, check_rank, mass_rank};
pub use algorithms::regressor::{
    PARAMETERS_PER_LINK, inertial_parameters, joint_torque_regressor, kinetic_energy_regressor,
    potential_energy_regressor,
};
pub use constraint::{
    Anchor, Baumgarte, Closure, ClosureRow, ConstrainedMotion, ConstrainedMotionError, ConstrainedStepReport,
    ConstrainedTorque, Constraint, ConstraintDrift, ConstraintOptions, ConstraintRecord, ConstraintRows,
    ConstraintSet, ConstraintSetError, ContactImpulse, Coupling, DriftCorrection, LoopClosure,
    NamedDependentRow, NoSlip, Plane, PolynomialCoupling, PositionProjection, RedundantRows, RollingDisc,
    RollingRow, Support, SupportedTorque, Supports, TreeProjections, constrained_forward_dynamics,
    constrained_inverse_dynamics, constrained_step, constraint_drift, constraint_projections,
    contact_impulse, project_position, project_velocity, supported_inverse_dynamics,
};
pub use contact::{
    ActiveSet, ContactError, ContactLaw, ContactLaws, ContactPoint, ContactProblem, ContactSet,
    ContactViolation, Ground, HeightField, SoftConstraints, SoftContact,
};
pub use control::inverse_kinematics::{
    FrameTarget, InverseKinematicsError, InverseKinematicsOptions, InverseKinematicsSolution,
    inverse_kinematics,
};
pub use control::operational_space::{
    ComputedTorque, OperationalSpace, OperationalSpaceWorkspace, PoseReference, Reference, TaskControl,
    TaskGains, TaskReference, TaskTarget, operational_space, operational_space_into,
};
pub use derivatives::{
    PASSIVE_PARAMETERS_PER_JOINT, ParameterCotangents, ParameterError, dissipation_pullback,
    forward_dynamics_pullback, forward_dynamics_pullback_with_parameters, inverse_dynamics_pullback,
    inverse_dynamics_pullback_with_parameters, parameter_count, parameter_values, with_parameters,
};
pub use derivatives::{
    center_of_mass_velocity_derivative, forward_dynamics_derivatives,
    forward_dynamics_derivatives_with_wrenches, frame_acceleration_derivatives_in_frame,
    frame_acceleration_derivatives_world_aligned, frame_velocity_derivative_in_frame,
    frame_velocity_derivative_world_aligned, gravity_derivative, inverse_dynamics_derivatives,
    inverse_dynamics_derivatives_with_wrenches,
};
pub use identification::{
    BaseParameter, BaseParameters, IdentificationError, Identified, LinkConsistency, MotionRecord,
    inertial_parameter_names, physical_consistency, pseudo_inertia,
};
pub use joint::kind::{Coordinate, JointKind, Measure};
pub use model::actuator::{Activation, ActuatorDescription, Affine, Transmission};
pub use model::contact_pair::ContactPairDescription;
pub use model::description::{
    Base, EARTH_GRAVITY, FLOATING_BASE, FrameDescription, LinkDescription, RobotDescription,
};
pub use model::equality::{Equality, EqualityDescription};
pub use model::error::{ModelError, NoSuchFrame};
pub use model::finding_group::FindingGroup;
pub use model::higher_terms::HigherTerms;
pub use model::joint_description::{JointDescription, Limits, Mimic, PassiveForces};
pub use model::named_pose::NamedPose;
pub use model::native::{NativeCode, NativeFunction, NativeReport, NativeUse};
#[cfg(feature = "native")]
pub use model::native::{NativeTrace, Tracer};
pub use model::pendulum::pendulum;
pub use model::placement_spring::PlacementSpring;
pub use model::random_robot::{JointKinds, RandomRobotOptions, RandomState, random_robot, random_state};
pub use model::refused_file::RefusedFile;
pub use model::report::{Counts, Finding, LoadReport, Severity, Treatment};
pub use model::sensor::{SensorDescription, SensorKind, SensorObject};
pub use model::shape::{Elevation, LinkShape, Shape, ShapeRole, Surface};
pub use model::softness::{JointSoftness, Softness, TendonSoftness};
pub use model::surgery::SurgeryError;
pub use model::tendon::TendonDescription;
pub use model::written_file::{LeftOut, WriteError, WrittenFile};
pub use model::{Frame, FrameId, Joint, Model};
pub use motion::allocating::{ForwardSlopes, InverseSlopes};
pub use motion::fixed_size::{FixedSize, FixedSizeError};
pub use motion::implicit::Implicit;
pub use motion::integrate::{StepForces, StepStagesWorkspace, StepWorkspace, step, step_stages};
pub use motion::linearize_step::{
    DifferenceError, LinearizeStepError, LinearizeStepWorkspace, linearize_by_differences, linearize_step,
};
pub use motion::mujoco_euler::MujocoEuler;
pub use motion::operational_space_error::OperationalSpaceError;
pub use motion::pullback::{
    ForwardPullback, InversePullback, PullbackError, Rollout, RolloutPullbackWorkspace,
    StepPullbackWorkspace, rollout_pullback, step_pullback,
};
pub use motion::simulate::{
    ActuatedStepError, CallbackError, ConstantTorque, Controller, ControllerError, DivergenceCause, Event,
    EventOccurrence, GravityAt, GravityCompensatedPd, Losses, Outcome, Run, RunError, RunFailure, Sample,
    StepError, StepFault, StepInfo, Stepper, Trajectory, ZeroTorque, energy_ledger, record_step,
};
#[cfg(feature = "adaptive")]
pub use motion::simulate::{
    AdaptiveMethod, AdaptiveOptions, AdaptiveOptionsError, AdaptiveRecord, AdaptiveStepError, ControlTiming,
    StepStatistics,
};
pub use number::InstructionSet;
pub use planning::time_parameterization::{
    Collocation, CubicSpline, LimitUse, MotionLimits, ParameterizationError, PathCoefficients, PathMoment,
    SplineError, TimeOptimal, TimedPath, TreePath, TreePathPoint, limit_use, path_coefficients, time_optimal,
};
pub use quantity::{Input, Inputs, Quantity, QuantityMemory, QuantityResult, ResultShape};
pub use scratch::workspace::Workspace;
pub use sensors::{PointForce, SensorInputs, SensorMemory, SensorSet};
pub use space::configuration::{
    ConfigurationError, check_configuration, difference, integrate, interpolate, neutral,
    normalize_quaternions, random_within_limits,
};
pub use space::cotangent::{cotangent_from_coordinates, cotangent_to_coordinates};
pub use space::joint_map::{JointMap, JointMapError};
pub use spatial::pose::Pose;
pub use spatial::quaternion::Quaternion;
pub use stages::wrench::FrameWrench;
