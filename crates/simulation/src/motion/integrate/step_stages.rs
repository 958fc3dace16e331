//! One step of explicit stages over any number type.

use core::convert::Infallible;

use robot_dynamics_core::configuration::retraction::move_along;
use robot_dynamics_core::{InstructionSet, Model, Workspace, forward_dynamics};
use robot_dynamics_description::check_length;
use robot_dynamics_integrators::Stage;
use robot_dynamics_number::Scalar;

use super::explicit::{StageSystem, explicit_step};
use super::forces::{StepForces, net_force};
use super::stage_memory::{StageMemory, most_stages};

/// Scratch for [`step_stages`] on one model.
#[derive(Clone, Debug)]
pub struct StepStagesWorkspace<S: Scalar = f64> {
    dynamics: Workspace<S>,
    force: Vec<S>,
    stages: Vec<S>,
}

impl<S: Scalar> StepStagesWorkspace<S> {
    /// Allocates the memory for this model and any row of the table; nothing else allocates.
    pub fn new(model: &Model) -> Self {
        Self::limited(model, InstructionSet::best())
    }

    /// As [`StepStagesWorkspace::new`], limited to this instruction set.
    pub fn limited(model: &Model, limit: InstructionSet) -> Self {
        Self {
            dynamics: Workspace::limited(model, limit),
            force: vec![S::zero(); model.nv],
            stages: vec![S::zero(); StageMemory::<S>::size(model, most_stages())],
        }
    }
}

/// A tree under constant forces.
struct TreeUnderForces<'a, S: Scalar> {
    model: &'a Model,
    workspace: &'a mut Workspace<S>,
    /// τ − b(v).
    force: &'a mut [S],
    forces: &'a StepForces<'a, S>,
}

impl<S: Scalar> StageSystem<S> for TreeUnderForces<'_, S> {
    type Error = Infallible;

    fn move_along(&self, q: &[S], displacement: &[S], moved: &mut [S]) {
        move_along(self.model, q, displacement, moved);
    }

    fn accelerate(&mut self, q: &[S], v: &[S], acceleration: &mut [S]) -> Result<(), Infallible> {
        net_force(self.model, self.forces, v, self.force);
        forward_dynamics(self.model, self.workspace, q, v, self.force, acceleration);
        Ok(())
    }
}

/// One [`step`](crate::step) from (q, v) to (q₁, v₁) over any number type. It has no branches and does not
/// check that numbers are finite.
///
/// The stages are those of a row of the table,
/// [`Integrator::scheme`](robot_dynamics_integrators::Integrator::scheme), or custom stages, at most eight. h
/// has the same number type. A step may rotate a body by up to 12 rad. It does not allocate.
///
/// ```
/// use robot_dynamics::description::pendulum;
/// use robot_dynamics::model::Model;
/// use robot_dynamics::number::Dual;
/// use robot_dynamics::simulation::{Integrator, StepForces, StepScheme, StepStagesWorkspace};
/// use robot_dynamics::simulation::step_stages;
/// let model = Model::new(pendulum(2.0, 0.5))?; // 2 kg on 0.5 m: g(q) = −m g l cos q
/// let StepScheme::Explicit(stages) = Integrator::SemiImplicitEuler.scheme() else { unreachable!() };
/// // From rest, with the derivative by the torque: v₁ = h a and q₁ = h v₁, a = (τ + m g l)/(m l²).
/// type Slope = Dual<f64, 1>;
/// let (h, rest) = (Slope::constant(0.01), [Slope::constant(0.0)]);
/// let tau = [Slope::variable(0.5, 0)];
/// let (mut q, mut v) = (rest, rest);
/// let mut workspace = StepStagesWorkspace::new(&model);
/// let forces = StepForces::new(&tau, false);
/// step_stages(&model, stages, &mut workspace, &forces, h, (&rest, &rest), (&mut q, &mut v));
/// assert!((v[0].value - 0.01 * (0.5 + 9.81) / 0.5).abs() < 1e-15);
/// assert!((q[0].gradient[0] - 1e-4 / 0.5).abs() < 1e-18);
/// # Ok::<(), Box<dyn std::error::Error>>(())
/// ```
///
/// # Panics
/// Panics if a slice has the wrong length, the workspace belongs to another model, or there are more stages
/// than in any row.
#[track_caller]
pub fn step_stages<S: Scalar>(
    model: &Model,
    stages: &[Stage],
    workspace: &mut StepStagesWorkspace<S>,
    forces: &StepForces<'_, S>,
    h: S,
    (q, v): (&[S], &[S]),
    (q_next, v_next): (&mut [S], &mut [S]),
) {
    let StepStagesWorkspace { dynamics, force, stages: memory } = workspace;
    dynamics.check_inputs(model, q);
    check_length("v", v.len(), model.nv);
    check_length("tau", forces.tau.len(), model.nv);
    check_length("q after the step", q_next.len(), model.nq);
    check_length("v after the step", v_next.len(), model.nv);
    let (count, most) = (stages.len(), most_stages());
    assert!(count <= most, "the method has {count} stages, at most {most} are taken");
    let mut memory = StageMemory::new(model, count, memory);
    let mut motion = TreeUnderForces { model, workspace: dynamics, force, forces };
    let Ok(()) = explicit_step(model, stages, &mut motion, h, &mut memory, (q, v));
    q_next.copy_from_slice(memory.q);
    v_next.copy_from_slice(memory.v);
}
