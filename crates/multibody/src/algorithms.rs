//! The recursions: each quantity of the equation of motion in O(n), or O(n) per row.

pub(crate) mod center_of_mass;
pub(crate) mod centroidal;
pub(crate) mod christoffel;
pub(crate) mod coriolis;
pub(crate) mod dissipation;
pub(crate) mod energy;
pub(crate) mod forward_dynamics;
pub(crate) mod forward_dynamics_by_cholesky;
pub(crate) mod frame_motion;
pub(crate) mod inverse_dynamics;
pub(crate) mod inverse_mass_matrix;
pub(crate) mod jacobian;
pub(crate) mod joint_reactions;
pub(crate) mod kinematics;
pub(crate) mod mass_matrix;
pub(crate) mod mass_matrix_factor;
pub(crate) mod mass_matrix_rate;
pub(crate) mod momentum;
pub(crate) mod motion_error;
pub(crate) mod rank;
pub(crate) mod regressor;
