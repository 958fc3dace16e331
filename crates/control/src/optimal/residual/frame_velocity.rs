//! The velocity of a frame.

use std::sync::Arc;

use robot_dynamics_core::{
    FrameId, Model, ReferenceFrame, Twist, Workspace, frame_jacobian, frame_velocity,
    frame_velocity_derivative,
};
use robot_dynamics_number::{InvalidInput, check_finite};
use robot_dynamics_simulation::StepError;

use super::{Residual, ResidualInputs, ResidualJacobian};

/// r = V − V\*, six numbers, linear before angular: the velocity of a frame in a reference frame \[m/s,
/// rad/s\].
#[derive(Clone, Debug)]
pub struct FrameVelocityResidual {
    model: Arc<Model>,
    workspace: Workspace,
    frame: FrameId,
    axes: ReferenceFrame,
    target: [f64; 6],
    by_position: Vec<f64>,
    by_velocity: Vec<f64>,
}

impl FrameVelocityResidual {
    /// The velocity of the frame in `axes` relative to `target`, linear before angular.
    ///
    /// # Errors
    /// [`InvalidInput`] if the target is not finite.
    ///
    /// # Panics
    /// If the frame belongs to another model.
    #[track_caller]
    pub fn new(
        model: impl Into<Arc<Model>>,
        frame: FrameId,
        axes: ReferenceFrame,
        target: [f64; 6],
    ) -> Result<Self, InvalidInput> {
        check_finite("the target velocity", &target)?;
        let model = model.into();
        model.frame_of(frame);
        let nv = model.nv();
        let (by_position, by_velocity) = (vec![0.0; 6 * nv], vec![0.0; 6 * nv]);
        Ok(Self { workspace: Workspace::new(&model), model, frame, axes, target, by_position, by_velocity })
    }
}

impl Residual for FrameVelocityResidual {
    fn dimension(&self) -> usize {
        6
    }

    fn expects(&self) -> ResidualInputs {
        ResidualInputs { coordinates: Some(self.model.nq() + self.model.nv()), controls: None }
    }

    fn evaluate(&mut self, x: &[f64], _u: &[f64], residual: &mut [f64]) -> Result<(), StepError> {
        let (q, v) = x.split_at(self.model.nq());
        let Twist { linear, angular } =
            frame_velocity(&self.model, &mut self.workspace, q, v, self.frame, self.axes);
        for (k, (r, target)) in residual.iter_mut().zip(self.target).enumerate() {
            *r = if k < 3 { linear[k] } else { angular[k - 3] } - target;
        }
        Ok(())
    }

    fn linearize(
        &mut self,
        x: &[f64],
        u: &[f64],
        residual: &mut [f64],
        jacobian: ResidualJacobian<'_>,
    ) -> Result<(), StepError> {
        let (q, v) = x.split_at(self.model.nq());
        let (model, w, nv) = (&self.model, &mut self.workspace, self.model.nv());
        frame_velocity_derivative(model, w, q, v, self.frame, self.axes, &mut self.by_position);
        frame_jacobian(model, w, q, self.frame, self.axes, &mut self.by_velocity);
        let parts = self.by_position.chunks_exact(nv).zip(self.by_velocity.chunks_exact(nv));
        for (row, (by_q, by_v)) in jacobian.by_state.chunks_exact_mut(2 * nv).zip(parts) {
            row[..nv].copy_from_slice(by_q);
            row[nv..].copy_from_slice(by_v);
        }
        self.evaluate(x, u, residual)
    }

    fn boxed_clone(&self) -> Box<dyn Residual> {
        Box::new(self.clone())
    }
}
