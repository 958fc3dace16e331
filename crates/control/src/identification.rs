//! Inertial parameters from measured motions.
//!
//! Motions determine only combinations of the inertial parameters. In W π = τ, where W stacks the regressors
//! of many states, some columns depend on others. The independent columns, with the contributions of the
//! others, define the base parameters β = π_b + K π_d. Least squares determines β from data, and β determines
//! every torque.
//!
//! Joints add columns for damping, friction, armature and offsets ([`JointTerm`]). Rows are weighted by the
//! noise of their torque, and rows without a sensor are left out. The six rows of a floating base with
//! measured contact forces determine the same combinations as all rows. **(Ayusawa et al. 2014)**
//!
//! Cost: O(rows · parameters²) for the factorization. Motions that excite few combinations give a large
//! condition number, and noise then dominates. Least squares does not ensure positive masses;
//! [`physical_consistency`] lists links with impossible values. [`identify_consistent`] finds parameters of
//! bodies, near nominal ones, and [`identify_nonlinear`] Stribeck friction and the direction of gravity as
//! well.
//!
//! Sources:
//! - Atkeson, An, Hollerbach (1986), as in
//!   [`joint_torque_regressor`](robot_dynamics_core::joint_torque_regressor).
//! - Gautier, Khalil, *Direct calculation of minimum set of inertial parameters of serial robots*, IEEE T-RA
//!   6 (1990).
//! - Wensing, Kim, Slotine, *Linear matrix inequalities for physically consistent inertial parameter
//!   identification*, IEEE RA-L 3 (2018) for the pseudo-inertia.
//! - Lee, Wensing, Park, *Geometric robot dynamic identification: a convex programming approach*, IEEE T-RO
//!   36 (2020) for the entropic divergence.
//! - Swevers et al., *Optimal robot excitation and identification*, IEEE T-RA 13 (1997) for the motions of
//!   [`design_excitation`].
//! - Ayusawa, Venture, Nakamura, *Identifiability and identification of inertial parameters using the
//!   underactuated base-link dynamics for legged multibody systems*, Int. J. Robotics Research 33 (2014).

mod base_parameters;
mod consistency;
mod consistent;
mod consistent_options;
mod entropic;
mod error;
mod excitation;
mod joint_term;
mod least_squares;
mod nonlinear;
mod payload;
mod record;

pub use base_parameters::{BaseParameter, BaseParameters};
pub use consistency::{LinkConsistency, physical_consistency, pseudo_inertia};
pub use consistent::{ConsistentEstimate, identify_consistent};
pub use consistent_options::ConsistentOptions;
pub use entropic::entropic_divergence;
pub use error::IdentificationError;
pub use excitation::{
    Excitation, ExcitationCriterion, ExcitationLimits, ExcitationOptions, FourierSeries, design_excitation,
    design_excitation_observed,
};
pub use joint_term::{JointTerm, JointTermKind};
pub use least_squares::IdentificationResult;
pub use nonlinear::{MotionSample, NonlinearEstimate, NonlinearOptions, identify_nonlinear};
pub use payload::{Payload, PayloadEstimator};
pub use record::MotionRecord;

use robot_dynamics_core::Model;

/// The names of a link's ten parameters, in the order of
/// [`joint_torque_regressor`](robot_dynamics_core::joint_torque_regressor).
const PARAMETER_NAMES: [&str; robot_dynamics_core::PARAMETERS_PER_LINK] =
    ["m", "hx", "hy", "hz", "Ixx", "Ixy", "Iyy", "Ixz", "Iyz", "Izz"];

/// The names of all inertial parameters, `link.m`, `link.hx`, ..., in the order of
/// [`inertial_parameters`](robot_dynamics_core::inertial_parameters).
///
/// ```
/// use robot_dynamics::algorithms::inertial_parameters;
/// use robot_dynamics::control::inertial_parameter_names;
/// use robot_dynamics::description::pendulum;
/// use robot_dynamics::model::Model;
/// let model = Model::new(pendulum(2.0, 0.5))?;
/// let (names, values) = (inertial_parameter_names(&model), inertial_parameters(&model));
/// assert_eq!((names[0].as_str(), values[0]), ("rod.m", 2.0));
/// assert_eq!((names[1].as_str(), values[1]), ("rod.hx", 2.0 * 0.5));
/// assert_eq!((names[6].as_str(), values[6]), ("rod.Iyy", 2.0 * 0.5 * 0.5));
/// # Ok::<(), Box<dyn std::error::Error>>(())
/// ```
pub fn inertial_parameter_names(model: &Model) -> Vec<String> {
    let of_link = |link: &str| PARAMETER_NAMES.map(|name| format!("{link}.{name}"));
    model.moving_links().flat_map(of_link).collect()
}

/// The names of all inertial parameters and then of the joint terms.
fn parameter_names(model: &Model, terms: &[JointTerm]) -> Vec<String> {
    let mut names = inertial_parameter_names(model);
    names.extend(terms.iter().map(|term| term.label(model)));
    names
}
