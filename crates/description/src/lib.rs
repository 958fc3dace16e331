//! A robot as its file describes it: names, links, joints, shapes, inertias, sensors and actuators.
//!
//! [`RobotDescription`] is plain data in the file's own axes. File formats read and write it. The crate
//! `robot-dynamics-core` checks it and compiles it into a model. [`MassProperties`] are checked on
//! construction. [`plausibility`] reports numbers that seem to be in a wrong unit.

mod activation;
mod actuated_joints;
mod actuator;
mod contact_pair;
mod couplings;
mod edit;
mod electric_motor;
mod equality;
mod error;
mod finding_group;
mod fingerprint;
mod fluid;
mod frame;
mod group;
mod inertia;
mod integral_action;
mod joint;
mod joint_kind;
mod length;
mod muscle;
mod named_pose;
mod pendulum;
pub mod plausibility;
mod polynomial_stiffness_damping;
mod pose;
mod pose_spring;
mod quaternion;
mod random_robot;
mod refused_file;
mod report;
mod robot;
mod scene;
pub mod sensor;
mod shape;
mod solver_impedance;
mod spatial_tendon;
mod tendon;
pub mod text;
#[doc(hidden)]
pub mod validation;
mod written_file;

pub use activation::Activation;
pub use actuator::{ActuatorDescription, Affine, Cogging, Transmission};
pub use contact_pair::ContactPairDescription;
pub use edit::{EditNote, JointElasticity, MotorDrive, moved_by};
pub use electric_motor::{
    BristleFriction, CurrentDynamics, Derating, ElectricMotor, MotorLoad, WindingTemperature,
};
pub use equality::{Equality, EqualityDescription};
pub use error::{ModelError, similar, unknown_name};
pub use finding_group::FindingGroup;
pub use fingerprint::fingerprint;
pub use fluid::{FluidEllipsoid, FluidForm, FluidShape, Medium};
pub use frame::FrameDescription;
pub use group::{EndEffectorDescription, GroupDescription};
pub use inertia::{
    InertiaError, MassProperties, PrincipalInertia, RotationalInertia, parallel_axis, parallel_axis_planar,
    six_digits,
};
pub use integral_action::IntegralAction;
pub use joint::{JointDescription, Limits, Mimic, PassiveForces};
pub use joint_kind::{Coordinate, CoordinateKind, JointKind, z_onto};
pub use length::check_length;
pub use muscle::Muscle;
pub use named_pose::NamedPose;
pub use pendulum::pendulum;
pub use polynomial_stiffness_damping::PolynomialStiffnessDamping;
pub use pose::Pose;
pub use pose::exponential::{exp_motion, log_motion};
pub use pose_spring::PoseSpring;
pub use quaternion::{Quaternion, rotation_of};
pub use random_robot::{JointKinds, RandomRobotOptions, random_quaternion, random_robot};
pub use refused_file::RefusedFile;
pub use report::{Disposition, Finding, LoadCounts, LoadReport, Severity};
pub use robot::{Base, EARTH_GRAVITY, FLOATING_BASE, LinkDescription, RobotDescription};
pub use scene::{Mount, Object, Scene};
pub use sensor::{SensorDescription, SensorKind, SensorObject};
pub use shape::{Elevation, LinkShape, Shape, ShapeRole, Surface, SurfaceVelocity};
pub use solver_impedance::{JointSolverImpedance, SolverImpedance, TendonSolverImpedance};
pub use spatial_tendon::{SpatialTendonDescription, TendonPathElement, TendonSurface};
pub use tendon::TendonDescription;
pub use written_file::{UnsupportedFeature, WrittenFile};
