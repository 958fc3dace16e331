//! The forces and cotangents of one rollout.

use robot_dynamics_number::Scalar;

use super::checkpoints::RolloutInputs;
use super::cotangents::TrajectoryCotangents;
use super::stages::add;

/// The forces and cotangents of one rollout as tables.
pub(super) struct RolloutTables<'a, S> {
    /// Constant over all steps, or \[steps\]\[nv\], or empty for zero forces.
    pub(super) tau: &'a [S],
    pub(super) trajectory: TrajectoryCotangents<'a, S>,
    pub(super) by_force: &'a mut [S],
}

impl<S: Scalar> RolloutInputs<S> for RolloutTables<'_, S> {
    fn torque(&mut self, step: usize, tau: &mut [S]) {
        let n = tau.len();
        match self.tau.len() {
            0 => tau.fill(S::zero()),
            held if held == n => tau.copy_from_slice(self.tau),
            _ => tau.copy_from_slice(&self.tau[step * n..(step + 1) * n]),
        }
    }

    fn add_cotangents(&mut self, sample: usize, by_position: &mut [S], by_velocity: &mut [S]) {
        let rows = sample * by_position.len()..(sample + 1) * by_position.len();
        add(by_position, &self.trajectory.by_position[rows.clone()]);
        add(by_velocity, &self.trajectory.by_velocity[rows]);
    }

    fn record(&mut self, step: usize, by_force: &[S]) {
        let n = by_force.len();
        match self.by_force.len() {
            0 => {}
            held if held == n => add(self.by_force, by_force),
            _ => self.by_force[step * n..(step + 1) * n].copy_from_slice(by_force),
        }
    }

    fn go_on(&mut self, _: usize) -> bool {
        true
    }
}
