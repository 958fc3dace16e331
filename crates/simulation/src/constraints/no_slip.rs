//! Components of a frame's velocity, along its own axes, that vanish: J_k v = 0 for rows k of the Jacobian in
//! the frame.
//!
//! The rows do not follow from a position, so there is no φ to correct: a drift along them stays. A row costs
//! O(depth).

use nalgebra::RowDVector;
use robot_dynamics_core::{
    FrameId, Model, ReferenceFrame, Workspace, frame_bias_acceleration, frame_jacobian,
};

use super::SpatialAxis;
use super::rows::RowsAt;

/// Components of a frame's velocity, along the frame's own axes, that vanish.
///
/// The chapter's knife-edge is the row y of a frame that heads along x: no side-slip. Rows x and y allow a
/// frame only to turn on the spot. These rows do not follow from a position: there is no φ.
#[derive(Clone, Debug, PartialEq)]
pub struct NoSlip {
    /// The frame.
    pub frame: FrameId,
    /// The components; `rx` is ω_x.
    pub rows: Vec<SpatialAxis>,
}

impl NoSlip {
    /// The frame's origin does not move along the frame's y axis: a blade, or wheels, that head along x.
    pub fn sideways(frame: FrameId) -> Self {
        Self { frame, rows: vec![SpatialAxis::Y] }
    }

    pub(super) fn write(
        &self,
        model: &Model,
        workspace: &mut Workspace,
        q: &[f64],
        v: &[f64],
        rows: &mut RowsAt<'_>,
    ) {
        let nv = model.nv();
        let mut jacobian = vec![0.0; 6 * nv];
        frame_jacobian(model, workspace, q, self.frame, ReferenceFrame::Local, &mut jacobian);
        let bias = frame_bias_acceleration(model, workspace, q, v, self.frame, ReferenceFrame::Local);
        let bias = [bias.linear, bias.angular].concat();
        for &row in &self.rows {
            let k = row as usize;
            rows.push(&RowDVector::from_row_slice(&jacobian[k * nv..][..nv]), bias[k], None);
        }
    }
}
