//! The recursions: each quantity of the equation of motion in O(n), or O(n) per row.
//!
//! M(q) v̇ + C(q, v) v + g(q) = τ. Outward passes carry motions from the root to the leaves, inward passes
//! carry forces and inertias back. Each file states its equation, algorithm, source and cost. The functions
//! do not allocate, and they do not check their numbers: NaN propagates.
//!
//! Sources: RBDA, and the papers that the files name.

pub mod center_of_mass;
pub(crate) mod centroidal;
pub mod christoffel;
pub mod coriolis;
pub mod dissipation;
pub mod energy;
pub mod forward_dynamics;
pub mod forward_dynamics_by_cholesky;
pub mod frame_motion;
pub mod inverse_dynamics;
pub mod inverse_mass_matrix;
pub mod jacobian;
pub mod joint_reactions;
pub mod kinematics;
pub mod mass_matrix;
pub mod mass_matrix_factor;
pub mod mass_matrix_rate;
pub mod momentum;
pub mod motion_error;
pub mod rank;
pub mod regressor;
