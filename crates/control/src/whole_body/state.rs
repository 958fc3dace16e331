//! The state of the robot at a solution, and its memory.

use robot_dynamics_core::{Model, Workspace};

use super::matrix::Matrix;

/// The quantities from which tasks compute their rows.
pub(super) struct State<'a> {
    pub(super) model: &'a Model,
    pub(super) workspace: &'a mut Workspace,
    pub(super) q: &'a [f64],
    pub(super) v: &'a [f64],
    /// D with τ = D x + h: the columns M and −Jᵀ.
    pub(super) dynamics: &'a Matrix,
    /// h: C v + g, and the dissipation if it is compensated.
    pub(super) bias: &'a [f64],
    /// Scratch of 6 nv and nv numbers.
    pub(super) jacobian: &'a mut Vec<f64>,
    pub(super) error: &'a mut Vec<f64>,
}
