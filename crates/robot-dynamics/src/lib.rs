//! The dynamics of any robot from its file: M(q) v̇ + C(q,v) v + g(q) + b = τ.
//!
//! ```
//! # let file = concat!(env!("CARGO_MANIFEST_DIR"), "/../../robots/panda.urdf");
//! let robot = robot_dynamics::load(file)?;
//! let model = &robot.model;
//! let (q, rest) = (robot_dynamics::model::neutral(model), vec![0.0; model.nv()]);
//! let hold = model.inverse_dynamics(&q, &rest, &rest)?; // the torques that hold it still
//! assert_eq!(hold, model.gravity_forces(&q)?);
//! # Ok::<(), robot_dynamics::Error>(())
//! ```
//!
//! | module | contents |
//! | --- | --- |
//! | [`load`], [`load_with`], [`load_description`], [`load_description_from_text`], [`load_description_from_files`] | a robot from its file, in any format |
//! | [`write()`], [`Format`], [`output`] | a robot's file from a robot; files that are replaced whole or not at all |
//! | [`description`] | a robot as its file describes it, edited or made in code |
//! | [`model`] | the compiled [`Model`](model::Model), its configuration space, its [`Workspace`](model::Workspace) |
//! | [`algorithms`] | the recursions: τ, a, M, C, g, kinematics, energies, regressors |
//! | [`derivatives`] | derivatives of the recursions and of steps; gradients pulled back |
//! | [`mod@simulation`], [`Robot::simulation`] | everything that the file states, step by step |
//! | [`contact`], [`constraints`] | contact, closed loops, rolling, supports |
//! | [`control`] | inverse kinematics, operational space, LQR, optimal control, time-optimal paths, identification |
//! | `batch`, with the feature `batch` | many states at once: lanes and threads |
//! | [`quantity`] | the algorithms as a table |
//! | [`verification`] | independent routes to the same numbers, and the audit of a robot |
//! | [`plausibility`] | numbers that look like a wrong unit |
//! | [`conventions`] | conversions to and from other libraries' conventions |
//! | [`mesh_corners`], [`height_field`] | points of a shape's mesh file, and height fields, for contact |
//! | [`mesh_object`] | an object of a scene whose shape is a mesh file |
//! | `json`, with the feature `json` | states and results as lines of JSON |
//! | [`urdf`], [`mjcf`] | the readers of each format, with their own reports |
//! | [`Error`], [`ErrorKind`] | the error that every error of the library converts to, and its kind |
//! | [`InvalidInput`] | an argument of the wrong length, not finite, or out of its range |
//! | [`prelude`] | the names that most programs use |

mod error;
mod height_field;
#[cfg(feature = "json")]
pub mod json;
mod load;
mod mesh;
mod mesh_object;
pub mod output;
mod scene_file;
mod writer;

pub use nalgebra;
pub use robot_dynamics_mjcf as mjcf;
pub use robot_dynamics_urdf as urdf;

pub use robot_dynamics_core::conventions;
pub use robot_dynamics_description::{plausibility, text};
pub use robot_dynamics_number::{Classified, ErrorKind, InputProblem, InvalidInput};

pub use error::Error;
pub use height_field::height_field;
pub use load::{
    FileError, LoadedDescription, Robot, load, load_description, load_description_from_files,
    load_description_from_text, load_with, simulation,
};
pub use mesh::mesh_corners;
pub use mesh_object::{MeshMass, MeshSolid, mesh_object};
pub use scene_file::SceneFault;

#[cfg(feature = "native")]
pub use robot_dynamics_functions::with_native_code;
pub use robot_dynamics_mjcf::FileSet;
pub use robot_dynamics_urdf::{LoadOptions, Srdf};
pub use writer::{Format, write};

/// A robot as its file describes it: links, joints, shapes, inertias, sensors, actuators, and the report of a
/// reader.
pub mod description {
    pub use robot_dynamics_description::{
        Activation, ActuatorDescription, Affine, Base, BristleFriction, Cogging, ContactPairDescription,
        Coordinate, CoordinateKind, CurrentDynamics, Derating, Disposition, EARTH_GRAVITY, EditNote,
        ElectricMotor, Elevation, EndEffectorDescription, Equality, EqualityDescription, FLOATING_BASE,
        Finding, FindingGroup, FluidEllipsoid, FluidForm, FluidShape, FrameDescription, GroupDescription,
        InertiaError, IntegralAction, JointDescription, JointElasticity, JointKind, JointKinds,
        JointSolverImpedance, Limits, LinkDescription, LinkShape, LoadCounts, LoadReport, MassProperties,
        Medium, Mimic, ModelError, MotorDrive, MotorLoad, Mount, Muscle, NamedPose, Object, PassiveForces,
        PolynomialStiffnessDamping, Pose, PoseSpring, PrincipalInertia, Quaternion, RandomRobotOptions,
        RefusedFile, RobotDescription, RotationalInertia, Scene, SensorDescription, SensorKind, SensorObject,
        Severity, Shape, ShapeRole, SolverImpedance, SpatialTendonDescription, Surface, SurfaceVelocity,
        TendonDescription, TendonPathElement, TendonSolverImpedance, TendonSurface, Transmission,
        UnsupportedFeature, WindingTemperature, WrittenFile, parallel_axis, parallel_axis_planar, pendulum,
        random_robot,
    };
}

/// The compiled model, its configuration space and its memory.
pub mod model {
    pub use robot_dynamics_core::{
        Frame, FrameId, InstructionSet, Joint, JointMap, Link, Model, NativeCode, NativeFunction,
        NativeReport, NativeUse, RandomState, Workspace, check_configuration, check_vector,
        cotangent_from_coordinates, cotangent_to_coordinates, difference, integrate, interpolate,
        lock_massless, neutral, normalize_quaternions, random_state, random_within_limits,
    };
    #[cfg(feature = "native")]
    pub use robot_dynamics_core::{NativeTrace, Tracer};
}

/// The recursions: each quantity of the equation of motion, kinematics, energies and regressors.
pub mod algorithms {
    pub use robot_dynamics_core::{
        CentroidalMomentum, FrameWrench, MotionError, PARAMETERS_PER_LINK, ReferenceFrame, SingularMass,
        SingularMotion, SpatialAcceleration, Twist, bias, center_of_mass, center_of_mass_bias_acceleration,
        center_of_mass_jacobian, center_of_mass_velocity, centroidal_momentum, centroidal_momentum_bias_rate,
        centroidal_momentum_matrix, centroidal_momentum_rate, check_rank, christoffel_symbols,
        coriolis_matrix, dissipation, dissipation_derivative, forward_dynamics, forward_dynamics_by_cholesky,
        forward_dynamics_with_wrenches, frame_acceleration, frame_bias_acceleration, frame_jacobian,
        frame_pose, frame_poses, frame_velocity, gravity, inertial_parameters, inverse_dynamics,
        inverse_dynamics_with_wrenches, inverse_mass_matrix, joint_reactions, joint_torque_regressor,
        kinetic_energy, kinetic_energy_gradient, kinetic_energy_regressor, mass_matrix, mass_matrix_factor,
        mass_matrix_rate, mass_matrix_related_entries, mass_rank, momentum, potential_energy,
        potential_energy_regressor, velocity_product,
    };
}

/// Derivatives of the recursions and of steps, and gradients pulled back through them.
pub mod derivatives {
    pub use robot_dynamics_core::{
        ForwardDirections, ForwardDynamicsDerivatives, ForwardDynamicsDerivativesMut, ForwardHessianProduct,
        ForwardHessianProductMut, ForwardPullback, ForwardPullbackInputs, ForwardPullbackMut,
        ForwardSecondDerivatives, ForwardSecondDerivativesMut, FrameAccelerationDerivativesMut,
        FrameAccelerationInputs, FramePoseInputs, FrameVelocityHessianProductMut, FrameVelocityInputs,
        InverseDirections, InverseDynamicsDerivatives, InverseDynamicsDerivativesMut, InverseHessianProduct,
        InverseHessianProductMut, InversePullback, InversePullbackInputs, InversePullbackMut,
        InverseSecondDerivatives, InverseSecondDerivativesMut, PASSIVE_PARAMETERS_PER_JOINT,
        ParameterCotangents, SecondOrderWorkspace, center_of_mass_velocity_derivative, dissipation_pullback,
        forward_dynamics_derivatives, forward_dynamics_derivatives_with_wrenches, forward_dynamics_hessian,
        forward_dynamics_hessian_product, forward_dynamics_pullback, forward_dynamics_pullback_derivative,
        forward_dynamics_pullback_with_parameters, forward_dynamics_second_derivatives,
        frame_acceleration_derivatives, frame_jacobian_derivative, frame_pose_hessian,
        frame_pose_hessian_product, frame_velocity_derivative, frame_velocity_hessian,
        frame_velocity_hessian_product, gravity_derivative, inverse_dynamics_derivatives,
        inverse_dynamics_derivatives_with_wrenches, inverse_dynamics_hessian,
        inverse_dynamics_hessian_product, inverse_dynamics_pullback, inverse_dynamics_pullback_derivative,
        inverse_dynamics_pullback_with_parameters, inverse_dynamics_second_derivatives, parameter_count,
        parameter_values, with_parameters,
    };
    pub use robot_dynamics_simulation::{
        ConstrainedMotionDerivatives, ConstrainedMotionPullback, ConstrainedPullbackInputs,
        ConstrainedTorqueDerivatives, ConstrainedTorquePullback, ConstrainedTorquePullbackInputs,
        ContactImpulseDerivatives, ContactImpulsePullback, ImpulsePullbackInputs, LinearizationMethod,
        LinearizeStepWorkspace, LinearizedStep, LinearizedStepWithParameters, LinearizedSteps,
        MotionCotangents, RobotState, Rollout, RolloutPullbackWorkspace, StepPullbackWorkspace,
        StepperPullbackWorkspace, StepperRollout, TrajectoryCotangents,
        constrained_forward_dynamics_derivatives, constrained_forward_dynamics_pullback,
        constrained_inverse_dynamics_derivatives, constrained_inverse_dynamics_pullback,
        contact_impulse_derivatives, contact_impulse_pullback, linearize_by_differences, linearize_step,
        linearize_stepper, linearize_stepper_with_parameters, rollout_pullback, rollout_pullback_by_stepper,
        step_pullback, stepper_pullback,
    };
}

/// The algorithms as a table: arguments, results and calls.
pub mod quantity {
    pub use robot_dynamics_core::{Input, Inputs, Quantity, QuantityMemory, QuantityResult, ResultShape};
}

/// Closed loops, rolling, supports: constraints on the velocities of a robot.
pub mod constraints {
    pub use robot_dynamics_simulation::{
        Anchor, Baumgarte, ConstrainedMotion, ConstrainedStepReport, ConstrainedTorque, Constraint,
        ConstraintDrift, ConstraintError, ConstraintOptions, ConstraintRecord, ConstraintRows, ConstraintSet,
        ContactImpulse, ContactSupport, Coupling, DriftCorrection, FrameConstraint, HeldDynamics,
        LinearizedHeldStep, LinearizedImpact, LoopClosure, NamedDependentRow, NoSlip, Plane,
        PolynomialCoupling, PositionProjection, RedundantRows, RollingDisc, RollingRow, RowFeedback,
        SpatialAxis, StepConstraints, SupportProblem, SupportedTorque, TreeProjections,
        constrained_forward_dynamics, constrained_inverse_dynamics, constrained_step, constraint_drift,
        constraint_projections, contact_impulse, project_position, project_velocity,
        supported_inverse_dynamics,
    };
}

/// Contact between links, and with the ground.
pub mod contact {
    pub use robot_dynamics_simulation::{
        ActiveSet, ContactLaw, ContactLaws, ContactPoint, ContactProblem, ContactSet, ContactViolation,
        Ground, HeightField, SoftConstraints, SoftContact, SoftDynamicsInputs,
    };
}

/// Simulations: everything that a file states, step by step.
pub mod simulation {
    pub use robot_dynamics_integrators::{
        EnergyAccount, Integrator, IntegratorError, Stage, StepScheme, Symplectic,
    };
    pub use robot_dynamics_simulation::simulator::*;
    pub use robot_dynamics_simulation::{
        Actuation, ActuationDerivatives, ActuationWorkspace, AffineForces, CallbackError, ConstantTorque,
        ContactStep, ContactStepInputs, Controller, ControllerError, Delayed, DivergenceCause, Event,
        EventOccurrence, FluidForces, FluidWorkspace, GravityAt, GravityCompensatedPd, ImplicitGains,
        ImplicitIntegrator, IntoCallbackResult, Losses, MujocoEuler, PointForce, Run, RunError, RunFailure,
        Sample, SensorInputs, SensorMemory, SensorSet, StateTransition, StepError, StepForces, StepInfo,
        StepStagesWorkspace, StepWorkspace, Stepper, Trajectory, WithImplicitGains, ZeroTorque,
        energy_account, record_step, step, step_stages, steps_in,
    };
    #[cfg(feature = "adaptive")]
    pub use robot_dynamics_simulation::{
        AdaptiveMethod, AdaptiveOptions, AdaptiveRecord, ControlTiming, StepStatistics,
    };
}

/// Inverse kinematics, operational-space control, LQR, time-optimal paths, identification of parameters.
pub mod control {
    pub use robot_dynamics_control::{
        Admittance, BaseParameter, BaseParameters, Collocation, ComputedTorque, ControlAllocation,
        CubicSpline, Dlqr, DlqrError, EffortScales, FrameTarget, IdentificationError, IdentificationResult,
        ImpedanceControl, ImpedanceGains, InverseKinematicsError, InverseKinematicsOptions,
        InverseKinematicsSolution, LimitUtilization, LinkConsistency, MomentumObserver, MotionLimits,
        MotionRecord, OperationalSpace, OperationalSpaceInputs, OperationalSpaceWorkspace,
        ParameterizationError, PathCoefficients, PathState, PoseReference, Reference, TaskControl,
        TaskDeviation, TaskGains, TaskReference, TaskTarget, TimeOptimal, TimedPath, TreePath, TreePathPoint,
        dlqr, identification, inertial_parameter_names, inverse_kinematics, joint_trajectory,
        limit_utilization, online_motion, operational_space, operational_space_into, optimal,
        path_coefficients, physical_consistency, pseudo_inertia, task_kinematics, time_optimal,
        time_parameterization, whole_body,
    };
}

/// The numbers that the algorithms run over, and the seeded generator of test states.
pub mod number {
    pub use robot_dynamics_number::{Dual, Scalar, SplitMix64};
}

/// Many states of one robot at once: lanes inside, threads across.
#[cfg(feature = "batch")]
pub mod batch {
    pub use robot_dynamics_batch::*;
}

/// Independent routes to the same numbers, and the audit of a robot.
pub mod verification {
    pub use robot_dynamics_verification::{admm, audit, lagrange};
}

/// The names that most programs use.
///
/// ```
/// use robot_dynamics::prelude::*;
/// let model = Model::new(pendulum(2.0, 0.5))?;
/// let mut tau = [0.0_f64];
/// inverse_dynamics(&model, &mut Workspace::new(&model), &[0.0], &[0.0], &[0.0], &mut tau);
/// assert!((tau[0].abs() - 2.0 * 9.81 * 0.5).abs() < 1e-12);
/// # Ok::<(), Box<dyn std::error::Error>>(())
/// ```
pub mod prelude {
    pub use crate::ErrorKind;
    pub use crate::algorithms::{
        ReferenceFrame, bias, coriolis_matrix, forward_dynamics, frame_jacobian, frame_pose, gravity,
        inverse_dynamics, kinetic_energy, mass_matrix, potential_energy,
    };
    pub use crate::description::{
        JointDescription, JointKind, LinkDescription, MassProperties, Pose, RobotDescription, pendulum,
    };
    pub use crate::error::Error;
    pub use crate::load::{Robot, load};
    pub use crate::model::{Model, Workspace, difference, integrate, neutral};
    pub use crate::simulation::{Simulation, SimulationBuilder};
}

/// The code of the repository's front page, compiled and run with the doc tests.
#[cfg(doctest)]
#[doc = include_str!("../../../README.md")]
mod readme {}
