//! One state at a time, by the functions with a workspace.

use std::hint::black_box;

use multibody::{FrameId, FramePose, InstructionSet, Model, Workspace};

use super::quantity::Quantity;
use super::states::States;

/// States between two looks at the clock: microseconds of work.
const BLOCK: usize = 64;

/// One thread's memory for every quantity.
pub(super) struct Single<'a> {
    model: &'a Model,
    states: &'a States<f64>,
    tip: FrameId,
    workspace: Workspace,
    vector: Vec<f64>,
    matrices: [Vec<f64>; 3],
    jacobian: Vec<f64>,
    poses: Vec<FramePose>,
}

impl<'a> Single<'a> {
    pub(super) fn new(model: &'a Model, states: &'a States<f64>, tip: FrameId) -> Self {
        let nv = model.nv();
        let pose = FramePose { rotation: [[0.0; 3]; 3], translation: [0.0; 3] };
        Self {
            model,
            states,
            tip,
            workspace: Workspace::new(model),
            vector: vec![0.0; nv],
            matrices: [(); 3].map(|()| vec![0.0; nv * nv]),
            jacobian: vec![0.0; 6 * nv],
            poses: vec![pose; model.frames().len()],
        }
    }

    pub(super) fn instruction_set(&self) -> InstructionSet {
        self.workspace.instruction_set()
    }

    /// Computes the next states from `cursor` on; how many.
    pub(super) fn block(&mut self, quantity: Quantity, cursor: &mut usize) -> usize {
        let count = BLOCK.min(self.states.count - *cursor);
        for i in *cursor..*cursor + count {
            self.call(quantity, i);
        }
        *cursor = (*cursor + count) % self.states.count;
        count
    }

    /// Whether the results of the last call are numbers.
    pub(super) fn is_finite(&self, quantity: Quantity) -> bool {
        let finite = |x: &[f64]| x.iter().all(|x| x.is_finite());
        match quantity {
            Quantity::InverseDynamics | Quantity::ForwardDynamics => finite(&self.vector),
            Quantity::MassMatrix | Quantity::CoriolisMatrix | Quantity::InverseMassMatrix => {
                finite(&self.matrices[0])
            }
            Quantity::FramePoses => self.poses.iter().all(|pose| finite(&pose.translation)),
            Quantity::TipJacobian => finite(&self.jacobian),
            Quantity::InverseDynamicsDerivatives => self.matrices[..2].iter().all(|x| finite(x)),
            Quantity::ForwardDynamicsDerivatives => self.matrices.iter().all(|x| finite(x)),
        }
    }

    fn call(&mut self, quantity: Quantity, i: usize) {
        let Self { model, states, tip, workspace: w, vector, matrices: [x, y, z], jacobian, poses } = self;
        let [q, v, a, tau] = states.part(i, 1);
        match quantity {
            Quantity::InverseDynamics => multibody::inverse_dynamics(model, w, q, v, a, vector),
            Quantity::ForwardDynamics => multibody::forward_dynamics(model, w, q, v, tau, vector),
            Quantity::MassMatrix => multibody::mass_matrix(model, w, q, x),
            Quantity::CoriolisMatrix => multibody::coriolis_matrix(model, w, q, v, x),
            Quantity::InverseMassMatrix => multibody::inverse_mass_matrix(model, w, q, x),
            Quantity::FramePoses => multibody::frame_poses(model, w, q, poses),
            Quantity::TipJacobian => multibody::frame_jacobian_world_aligned(model, w, q, *tip, jacobian),
            Quantity::InverseDynamicsDerivatives => {
                multibody::inverse_dynamics_derivatives(model, w, q, v, a, x, y);
            }
            Quantity::ForwardDynamicsDerivatives => {
                multibody::forward_dynamics_derivatives(model, w, q, v, tau, x, y, z);
            }
        }
        black_box((&*vector, &*x, &*y, &*z, &*jacobian, &*poses));
    }
}
