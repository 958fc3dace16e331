//! The dynamics of the actuated coordinates after elimination of the others.

use robot_dynamics_core::factorization::cholesky;
use robot_dynamics_core::{Model, Workspace, check_rank, mass_matrix};
use robot_dynamics_simulation::ControllerError;
use robot_dynamics_simulation::motion::simulate::singular_mass;

/// M divided into the actuated coordinates a and the unactuated coordinates u: 0 = M_uu a_u + M_ua a_a + h_u.
///
/// Elimination of a_u gives a robot with the coordinates a:
///
/// > M̃ = M_aa − M_au M_uu⁻¹M_ua,  h̃ = h_a − M_au M_uu⁻¹h_u,  J̃ = J_a − J_u M_uu⁻¹M_ua
///
/// J̃ is the generalized Jacobian. Sources: Spong, *Partial feedback linearization of underactuated
/// mechanical systems* (1994); Umetani, Yoshida, *Resolved motion rate control of space manipulators with
/// generalized Jacobian matrix* (1989).
#[derive(Clone, Debug)]
pub(super) struct ActuatedPart {
    actuated: Vec<usize>,
    unactuated: Vec<usize>,
    /// M, row-major.
    mass: Vec<f64>,
    /// L of M_uu = L Lᵀ, row-major.
    factor: Vec<f64>,
    /// One entry for each unactuated coordinate.
    column: Vec<f64>,
}

impl ActuatedPart {
    /// Allocates memory for a model; `None` if all its coordinates are actuated.
    pub(super) fn new(model: &Model) -> Option<Self> {
        let nv = model.nv();
        let (actuated, unactuated): (Vec<_>, Vec<_>) = (0..nv).partition(|&k| model.actuated_dofs()[k]);
        let count = unactuated.len();
        (count > 0).then(|| Self {
            actuated,
            unactuated,
            mass: vec![0.0; nv * nv],
            factor: vec![0.0; count * count],
            column: vec![0.0; count],
        })
    }

    /// Factors M_uu at q.
    ///
    /// # Errors
    /// [`ControllerError`] if M is singular.
    pub(super) fn factor(
        &mut self,
        model: &Model,
        workspace: &mut Workspace,
        q: &[f64],
    ) -> Result<(), ControllerError> {
        check_rank(model, workspace, q)?;
        mass_matrix(model, workspace, q, &mut self.mass);
        let (nv, count) = (model.nv(), self.unactuated.len());
        for (i, &row) in self.unactuated.iter().enumerate() {
            for (j, &column) in self.unactuated.iter().enumerate() {
                self.factor[i * count + j] = self.mass[row * nv + column];
            }
        }
        cholesky::factor(&mut self.factor, count);
        let is_positive = (0..count).all(|k| self.factor[k * count + k].is_finite());
        if is_positive { Ok(()) } else { Err(singular_mass(model, q)) }
    }

    /// f ← f_a − M_au M_uu⁻¹f_u on actuated coordinates, and 0 on the others. It maps h to h̃, and a row of J
    /// to that of J̃. The force of a motion with a_u = 0 becomes the torque of the motion with free
    /// unactuated coordinates.
    pub(super) fn reduce(&mut self, force: &mut [f64]) {
        let nv = force.len();
        for (entry, &k) in self.column.iter_mut().zip(&self.unactuated) {
            *entry = force[k];
            force[k] = 0.0;
        }
        cholesky::solve(&self.factor, self.unactuated.len(), &mut self.column);
        for &i in &self.actuated {
            let row = &self.mass[i * nv..(i + 1) * nv];
            let lost: f64 = self.unactuated.iter().zip(&self.column).map(|(&u, x)| row[u] * x).sum();
            force[i] -= lost;
        }
    }

    /// J_u M_uu⁻¹f_u of a row of J, with the force of the last [`reduce`](Self::reduce).
    pub(super) fn along_unactuated(&self, row: &[f64]) -> f64 {
        self.unactuated.iter().zip(&self.column).map(|(&k, x)| row[k] * x).sum()
    }

    /// x ← 0 on unactuated coordinates.
    pub(super) fn clear_unactuated(&self, x: &mut [f64]) {
        self.unactuated.iter().for_each(|&k| x[k] = 0.0);
    }
}
