//! An algorithm on one robot as a call by the number of the state.

use std::hint::black_box;

use multibody::{
    FrameId, FramePose, InstructionSet, Model, Workspace, coriolis_matrix, forward_dynamics,
    forward_dynamics_derivatives, frame_jacobian_in_frame, frame_jacobian_world_aligned, frame_poses,
    inverse_dynamics, inverse_dynamics_derivatives, mass_matrix,
};

use crate::StateTable;

/// What is measured.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Algorithm {
    /// τ(q, v, a).
    InverseDynamics,
    /// a(q, v, τ).
    ForwardDynamics,
    /// M(q), both triangles.
    MassMatrix,
    /// C(q, v).
    CoriolisMatrix,
    /// `world_from_frame` of every frame.
    FramePoses,
    /// The tip's Jacobian along the world's axes, 6×nv.
    Jacobian,
    /// The tip's Jacobian along its own axes, 6×nv.
    JacobianInFrame,
    /// ∂τ/∂q and ∂τ/∂v.
    InverseDynamicsDerivatives,
    /// ∂a/∂q and ∂a/∂v; M⁻¹ comes along.
    ForwardDynamicsDerivatives,
}

impl Algorithm {
    /// All of them.
    pub const ALL: [Self; 9] = [
        Self::InverseDynamics,
        Self::ForwardDynamics,
        Self::MassMatrix,
        Self::CoriolisMatrix,
        Self::FramePoses,
        Self::Jacobian,
        Self::JacobianInFrame,
        Self::InverseDynamicsDerivatives,
        Self::ForwardDynamicsDerivatives,
    ];

    /// The name in tables and on the command line.
    pub fn name(self) -> &'static str {
        match self {
            Self::InverseDynamics => "inverse_dynamics",
            Self::ForwardDynamics => "forward_dynamics",
            Self::MassMatrix => "mass_matrix",
            Self::CoriolisMatrix => "coriolis_matrix",
            Self::FramePoses => "frame_poses",
            Self::Jacobian => "jacobian",
            Self::JacobianInFrame => "jacobian_in_frame",
            Self::InverseDynamicsDerivatives => "inverse_dynamics_derivatives",
            Self::ForwardDynamicsDerivatives => "forward_dynamics_derivatives",
        }
    }

    /// The algorithm of that name.
    pub fn named(name: &str) -> Option<Self> {
        Self::ALL.into_iter().find(|algorithm| algorithm.name() == name)
    }
}

/// A robot, its states, and the memory that the calls write.
#[derive(Debug)]
pub struct Task<'a> {
    model: &'a Model,
    states: &'a StateTable,
    workspace: Workspace,
    tip: FrameId,
    vector: Vec<f64>,
    matrix: Vec<f64>,
    jacobian: Vec<f64>,
    /// By position, by velocity, by force.
    derivatives: [Vec<f64>; 3],
    poses: Vec<FramePose>,
}

impl<'a> Task<'a> {
    /// Memory for every algorithm on this robot.
    ///
    /// # Panics
    /// If the states are another robot's.
    pub fn new(model: &'a Model, states: &'a StateTable) -> Self {
        let (nq, nv) = (model.nq(), model.nv());
        assert_eq!(states.dimensions(), (nq, nv), "states of another robot than {}", model.name());
        let moving = model.joints().iter().filter(|joint| joint.nv > 0 && joint.parent != "world");
        let tip = moving.map(|joint| &joint.child).nth(states.tip());
        let tip = tip.or(model.joints().last().map(|joint| &joint.child)).expect("a robot with joints");
        let frame = FramePose { rotation: [[0.0; 3]; 3], translation: [0.0; 3] };
        Self {
            model,
            states,
            workspace: Workspace::new(model),
            tip: model.frame(tip).expect("every link is a frame"),
            vector: vec![0.0; nv],
            matrix: vec![0.0; nv * nv],
            jacobian: vec![0.0; 6 * nv],
            derivatives: [(); 3].map(|()| vec![0.0; nv * nv]),
            poses: vec![frame; model.frames().len()],
        }
    }

    /// As [`Task::new`], on the instructions that every machine has.
    pub fn portable(model: &'a Model, states: &'a StateTable) -> Self {
        Self { workspace: Workspace::limited(model, InstructionSet::Portable), ..Self::new(model, states) }
    }

    /// Computes state `i`.
    ///
    /// # Panics
    /// If there is no such state.
    #[inline]
    pub fn call(&mut self, algorithm: Algorithm, i: usize) {
        let Self { model, states, workspace, tip, vector, matrix, jacobian, derivatives, poses } = self;
        let [by_q, by_v, by_tau] = derivatives;
        let [q, v, a, tau] = states.get(i);
        match algorithm {
            Algorithm::InverseDynamics => inverse_dynamics(model, workspace, q, v, a, vector),
            Algorithm::ForwardDynamics => forward_dynamics(model, workspace, q, v, tau, vector),
            Algorithm::MassMatrix => mass_matrix(model, workspace, q, matrix),
            Algorithm::CoriolisMatrix => coriolis_matrix(model, workspace, q, v, matrix),
            Algorithm::FramePoses => frame_poses(model, workspace, q, poses),
            Algorithm::Jacobian => frame_jacobian_world_aligned(model, workspace, q, *tip, jacobian),
            Algorithm::JacobianInFrame => frame_jacobian_in_frame(model, workspace, q, *tip, jacobian),
            Algorithm::InverseDynamicsDerivatives => {
                inverse_dynamics_derivatives(model, workspace, q, v, a, by_q, by_v);
            }
            Algorithm::ForwardDynamicsDerivatives => {
                forward_dynamics_derivatives(model, workspace, q, v, tau, by_q, by_v, by_tau);
            }
        }
        black_box((&*vector, &*matrix, &*jacobian, &*derivatives, &*poses));
    }

    /// The numbers of the last call: matrices by rows; each frame's rotation by rows, then its translation.
    pub fn result(&self, algorithm: Algorithm) -> Vec<f64> {
        match algorithm {
            Algorithm::InverseDynamics | Algorithm::ForwardDynamics => self.vector.clone(),
            Algorithm::MassMatrix | Algorithm::CoriolisMatrix => self.matrix.clone(),
            Algorithm::Jacobian | Algorithm::JacobianInFrame => self.jacobian.clone(),
            // The peer's M⁻¹ is one triangle: it is not compared.
            Algorithm::InverseDynamicsDerivatives | Algorithm::ForwardDynamicsDerivatives => {
                self.derivatives[..2].concat()
            }
            Algorithm::FramePoses => {
                let moving = self.model.frames().iter().zip(&self.poses);
                // A root that is fixed to the world is no result.
                let fixed = self.model.nq() == self.model.nv();
                let moving = moving.skip(usize::from(fixed)).map(|(_, pose)| pose);
                moving.flat_map(|pose| pose.rotation.into_iter().flatten().chain(pose.translation)).collect()
            }
        }
    }
}
