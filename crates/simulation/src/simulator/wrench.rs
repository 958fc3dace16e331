//! Wrenches on frames as inputs of a step.

use robot_dynamics_core::{FrameId, Model, ReferenceFrame, Workspace, frame_jacobian};
use robot_dynamics_number::{InvalidInput, check_finite};

/// A force and a moment on the link that carries a frame.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct AppliedWrench {
    /// The frame.
    pub frame: FrameId,
    /// The axes of both vectors and the point of application of the force.
    pub axes: ReferenceFrame,
    /// Force \[N\].
    pub force: [f64; 3],
    /// The moment about that point \[N·m\].
    pub moment: [f64; 3],
}

impl AppliedWrench {
    /// A force at the frame's origin along the world's axes \[N\].
    ///
    /// ```
    /// use robot_dynamics::description::pendulum;
    /// use robot_dynamics::model::Model;
    /// use robot_dynamics::simulation::AppliedWrench;
    /// let model = Model::new(pendulum(2.0, 0.5))?;
    /// let push = AppliedWrench::force(model.frame_named("tip")?, [0.0, 0.0, 3.0]);
    /// assert_eq!(push.moment, [0.0; 3]);
    /// # Ok::<(), Box<dyn std::error::Error>>(())
    /// ```
    pub const fn force(frame: FrameId, force: [f64; 3]) -> Self {
        Self { frame, axes: ReferenceFrame::LocalWorldAligned, force, moment: [0.0; 3] }
    }

    /// Checks that all entries are finite; an error names the frame.
    pub(super) fn check(&self, model: &Model) -> Result<(), InvalidInput> {
        let named = |error: InvalidInput| {
            let frame = &model.frame_of(self.frame).name;
            let quantity = format!("the {} on frame `{frame}`", error.quantity);
            error.of(quantity)
        };
        check_finite("force", &self.force).and_then(|()| check_finite("moment", &self.moment)).map_err(named)
    }

    /// Adds Jᵀw at q to `tau`; `jacobian` is scratch memory for 6 nv numbers.
    pub(super) fn add_to(
        &self,
        model: &Model,
        workspace: &mut Workspace,
        q: &[f64],
        jacobian: &mut [f64],
        tau: &mut [f64],
    ) {
        frame_jacobian(model, workspace, q, self.frame, self.axes, jacobian);
        let nv = tau.len();
        for (row, w) in self.force.iter().chain(&self.moment).enumerate().filter(|(_, w)| **w != 0.0) {
            for (tau, j) in tau.iter_mut().zip(&jacobian[row * nv..(row + 1) * nv]) {
                *tau += j * w;
            }
        }
    }
}
