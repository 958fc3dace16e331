//! Kinematic trees: M(q) v̇ + C(q,v) v + g(q) = τ for trees of rigid bodies, in O(n).
//!
//! A `RobotDescription` is compiled into a [`Model`], which is immutable and checked. Each algorithm is a
//! function of the model, a caller's [`Workspace`] and slices; none allocates. The methods of [`Model`] are
//! the same algorithms on vectors, with checked input.
//!
//! Six-vectors are linear before angular. Quaternions are x y z w. Angles are in radians, lengths in metres.
//! M and the Jacobians are row-major. [`conventions`] converts to and from other conventions. Every function
//! is generic over [`Scalar`](robot_dynamics_number::Scalar): `f64`, `f32`, and dual numbers for derivatives.
//!
//! The modules hidden from this documentation serve the other crates of this library; semantic versioning
//! does not apply to them.

// Each module uses only those before it (`cargo xtask tidy` checks this).

// Copies that keep their capacity.
#[doc(hidden)]
pub mod clone_in_place;

// Rotations and six-vectors.
#[doc(hidden)]
pub mod spatial;

// Motion of each primitive joint.
#[doc(hidden)]
pub mod joint;

// The compiled model.
#[doc(hidden)]
pub mod model;

// The configuration space.
#[doc(hidden)]
pub mod configuration;

// Factors of M.
#[doc(hidden)]
pub mod factorization;

// Memory of the recursions, and their dispatch.
#[doc(hidden)]
pub mod workspace;

// Passes that several recursions share.
#[doc(hidden)]
pub mod kinematics;

// The recursions.
#[doc(hidden)]
pub mod algorithms;

// Their derivatives.
#[doc(hidden)]
pub mod derivatives;

// The recursions as methods that check their input.
mod model_methods;

// The recursions as a table.
mod quantity;

pub use configuration::conventions;
pub use robot_dynamics_number::InstructionSet;

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
pub use algorithms::frame_motion::{SpatialAcceleration, Twist, frame_acceleration, frame_velocity};
pub use algorithms::inverse_dynamics::{
    bias, gravity, inverse_dynamics, inverse_dynamics_with_wrenches, velocity_product,
};
pub use algorithms::inverse_mass_matrix::inverse_mass_matrix;
pub use algorithms::jacobian::{frame_bias_acceleration, frame_jacobian};
pub use algorithms::joint_reactions::joint_reactions;
pub use algorithms::kinematics::{frame_pose, frame_poses};
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
pub use configuration::cotangent::{cotangent_from_coordinates, cotangent_to_coordinates};
pub use configuration::joint_map::JointMap;
pub use configuration::manifold::{
    check_configuration, check_vector, difference, integrate, interpolate, neutral, normalize_quaternions,
    random_within_limits,
};
pub use derivatives::{
    ForwardDirections, ForwardDynamicsDerivativesMut, ForwardHessianProductMut, ForwardPullbackInputs,
    ForwardPullbackMut, ForwardSecondDerivativesMut, FrameAccelerationDerivativesMut,
    FrameAccelerationInputs, FramePoseInputs, FrameVelocityHessianProductMut, FrameVelocityInputs,
    InverseDirections, InverseDynamicsDerivativesMut, InverseHessianProductMut, InversePullbackInputs,
    InversePullbackMut, InverseSecondDerivativesMut, PASSIVE_PARAMETERS_PER_JOINT, ParameterCotangents,
    SecondOrderWorkspace, center_of_mass_velocity_derivative, dissipation_pullback,
    forward_dynamics_derivatives, forward_dynamics_derivatives_with_wrenches, forward_dynamics_hessian,
    forward_dynamics_hessian_product, forward_dynamics_pullback, forward_dynamics_pullback_derivative,
    forward_dynamics_pullback_with_parameters, forward_dynamics_second_derivatives,
    frame_acceleration_derivatives, frame_jacobian_derivative, frame_pose_hessian,
    frame_pose_hessian_product, frame_velocity_derivative, frame_velocity_hessian,
    frame_velocity_hessian_product, gravity_derivative, inverse_dynamics_derivatives,
    inverse_dynamics_derivatives_with_wrenches, inverse_dynamics_hessian, inverse_dynamics_hessian_product,
    inverse_dynamics_pullback, inverse_dynamics_pullback_derivative,
    inverse_dynamics_pullback_with_parameters, inverse_dynamics_second_derivatives, parameter_count,
    parameter_values, with_parameters,
};
pub use kinematics::wrench::FrameWrench;
pub use model::massless_joints::lock_massless;
pub use model::native::{NativeCode, NativeFunction, NativeReport, NativeUse};
#[cfg(feature = "native")]
pub use model::native::{NativeTrace, Tracer};
pub use model::random_state::{RandomState, random_state};
pub use model::{Frame, FrameId, Joint, Link, Model, ReferenceFrame};
pub use model_methods::{
    ForwardDynamicsDerivatives, ForwardHessianProduct, ForwardPullback, ForwardSecondDerivatives,
    InverseDynamicsDerivatives, InverseHessianProduct, InversePullback, InverseSecondDerivatives,
};
pub use quantity::{Input, Inputs, Quantity, QuantityMemory, QuantityResult, ResultShape};
pub use workspace::buffers::Workspace;
