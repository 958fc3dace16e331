//! The end of a step: the state after it.

use robot_dynamics_core::Model;
use robot_dynamics_core::configuration::retraction::move_along;
use robot_dynamics_core::factorization::sparse::dof_ancestors;
use robot_dynamics_description::check_length;
use robot_dynamics_number::Scalar;

use super::ContactStep;
use super::problem::Reader;

impl ContactStep {
    /// The end of a step: v₁ from the velocity √D L v₁ of the sweeps, and q₁.
    ///
    /// # Panics
    /// If a slice has the wrong length, or the step belongs to another robot.
    #[track_caller]
    pub fn finish<S: Scalar>(
        &self,
        model: &Model,
        problem: &[S],
        (q, h): (&[S], S),
        velocity: &[S],
        q_next: &mut [S],
        v_next: &mut [S],
    ) {
        model.check_identity(&self.robot, "the contact step");
        check_length("the problem", problem.len(), self.problem_count());
        check_length("the velocity", velocity.len(), model.nv());
        check_length("q", q.len(), model.nq());
        check_length("q after the step", q_next.len(), model.nq());
        check_length("v after the step", v_next.len(), model.nv());
        let mut reader = Reader::new(problem);
        for k in 0..velocity.len() {
            let inverse_root = reader.one();
            let mut sum = velocity[k] * inverse_root;
            for i in dof_ancestors(&self.dof_parent, k) {
                sum -= reader.one() * v_next[i];
            }
            v_next[k] = sum;
        }
        let displacement: Vec<S> = v_next.iter().map(|&v| h * v).collect();
        move_along(model, q, &displacement, q_next);
    }
}
