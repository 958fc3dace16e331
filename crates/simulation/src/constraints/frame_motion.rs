//! The pose, motion and Jacobian of a frame.

use nalgebra::{DMatrix, Matrix3, RowDVector, Vector3};
use robot_dynamics_core::{
    FrameId, Model, ReferenceFrame, Twist, Workspace, frame_bias_acceleration, frame_jacobian, frame_pose,
    frame_velocity,
};
use robot_dynamics_description::Pose;

use super::anchor::Anchor;

/// A frame at a state, in world axes.
pub(super) struct FrameMotion {
    /// p \[m\].
    pub position: Vector3<f64>,
    /// R: the frame's axes as columns.
    pub rotation: Matrix3<f64>,
    /// ṗ \[m/s\].
    pub velocity: Vector3<f64>,
    /// ω \[rad/s\].
    pub spin: Vector3<f64>,
    /// p̈ at a = 0 \[m/s²\].
    pub bias: Vector3<f64>,
    /// ω̇ at a = 0 \[rad/s²\].
    pub spin_bias: Vector3<f64>,
    /// (ṗ, ω) = J v, 6×nv.
    jacobian: DMatrix<f64>,
}

impl FrameMotion {
    /// The motion of one side of a closure.
    pub(super) fn of(
        model: &Model,
        workspace: &mut Workspace,
        q: &[f64],
        v: &[f64],
        anchor: &Anchor,
    ) -> Self {
        match anchor {
            Anchor::Frame(frame) => Self::of_frame(model, workspace, q, v, *frame),
            Anchor::World(Pose { rotation, translation }) => Self {
                position: Vector3::from(*translation),
                rotation: from_rows(rotation),
                velocity: Vector3::zeros(),
                spin: Vector3::zeros(),
                bias: Vector3::zeros(),
                spin_bias: Vector3::zeros(),
                jacobian: DMatrix::zeros(6, model.nv()),
            },
        }
    }

    pub(super) fn of_frame(
        model: &Model,
        workspace: &mut Workspace,
        q: &[f64],
        v: &[f64],
        frame: FrameId,
    ) -> Self {
        let nv = model.nv();
        let Pose { rotation, translation } = frame_pose(model, workspace, q, frame);
        let mut jacobian = vec![0.0; 6 * nv];
        frame_jacobian(model, workspace, q, frame, ReferenceFrame::LocalWorldAligned, &mut jacobian);
        let Twist { linear, angular } =
            frame_velocity(model, workspace, q, v, frame, ReferenceFrame::LocalWorldAligned);
        let bias = frame_bias_acceleration(model, workspace, q, v, frame, ReferenceFrame::LocalWorldAligned);
        Self {
            position: translation.into(),
            rotation: from_rows(&rotation),
            velocity: linear.into(),
            spin: angular.into(),
            bias: bias.linear.into(),
            spin_bias: bias.angular.into(),
            jacobian: DMatrix::from_row_slice(6, nv, &jacobian),
        }
    }

    /// The row of v ↦ l·ṗ + n·ω.
    pub(super) fn row(&self, l: &Vector3<f64>, n: &Vector3<f64>) -> RowDVector<f64> {
        l.transpose() * self.jacobian.rows(0, 3) + n.transpose() * self.jacobian.rows(3, 3)
    }

    /// Axis k of the frame.
    pub(super) fn axis(&self, k: usize) -> Vector3<f64> {
        self.rotation.column(k).into()
    }
}

fn from_rows(rows: &[[f64; 3]; 3]) -> Matrix3<f64> {
    Matrix3::from_fn(|i, j| rows[i][j])
}
