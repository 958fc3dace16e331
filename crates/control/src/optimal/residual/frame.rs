//! Differences of a frame's pose from a target.

use std::sync::Arc;

use robot_dynamics_core::{FrameId, Model, ReferenceFrame, Workspace, frame_jacobian, frame_pose};
use robot_dynamics_description::Pose;
use robot_dynamics_number::{InvalidInput, check_finite};
use robot_dynamics_simulation::StepError;

use super::{Residual, ResidualInputs, ResidualJacobian};

/// The memory for the pose and the Jacobian of a frame.
#[derive(Clone, Debug)]
struct FrameKinematics {
    model: Arc<Model>,
    workspace: Workspace,
    frame: FrameId,
    jacobian: Vec<f64>,
}

impl FrameKinematics {
    #[track_caller]
    fn new(model: Arc<Model>, frame: FrameId) -> Self {
        model.frame_of(frame);
        Self { workspace: Workspace::new(&model), frame, jacobian: vec![0.0; 6 * model.nv()], model }
    }

    fn inputs(&self) -> ResidualInputs {
        ResidualInputs { coordinates: Some(self.model.nq() + self.model.nv()), controls: None }
    }

    fn pose(&mut self, x: &[f64]) -> Pose {
        frame_pose(&self.model, &mut self.workspace, &x[..self.model.nq()], self.frame)
    }

    /// Writes rows `first`… of D J to the columns of q of a derivative; J is the Jacobian in `axes`, and D
    /// has six columns.
    fn write_product(&mut self, x: &[f64], axes: ReferenceFrame, d: &[[f64; 6]], by_state: &mut [f64]) {
        let (nq, nv) = (self.model.nq(), self.model.nv());
        frame_jacobian(&self.model, &mut self.workspace, &x[..nq], self.frame, axes, &mut self.jacobian);
        for (row, d) in by_state.chunks_exact_mut(2 * nv).zip(d) {
            for (jacobian, &d) in self.jacobian.chunks_exact(nv).zip(d).filter(|(_, d)| **d != 0.0) {
                row[..nv].iter_mut().zip(jacobian).for_each(|(to, j)| *to += d * j);
            }
        }
    }
}

/// r = p − p\*: the position of a frame's origin relative to a target, along the world's axes \[m\].
#[derive(Clone, Debug)]
pub struct FrameTranslationResidual {
    kinematics: FrameKinematics,
    target: [f64; 3],
}

impl FrameTranslationResidual {
    /// The position of the frame relative to `target` \[m\] in the world.
    ///
    /// # Errors
    /// [`InvalidInput`] if the target is not finite.
    ///
    /// # Panics
    /// If the frame belongs to another model.
    #[track_caller]
    pub fn new(model: impl Into<Arc<Model>>, frame: FrameId, target: [f64; 3]) -> Result<Self, InvalidInput> {
        check_finite("the target position", &target)?;
        Ok(Self { kinematics: FrameKinematics::new(model.into(), frame), target })
    }
}

impl Residual for FrameTranslationResidual {
    fn dimension(&self) -> usize {
        3
    }

    fn expects(&self) -> ResidualInputs {
        self.kinematics.inputs()
    }

    fn evaluate(&mut self, x: &[f64], _u: &[f64], residual: &mut [f64]) -> Result<(), StepError> {
        let position = self.kinematics.pose(x).translation;
        for ((r, p), target) in residual.iter_mut().zip(position).zip(self.target) {
            *r = p - target;
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
        let linear: [[f64; 6]; 3] =
            core::array::from_fn(|i| core::array::from_fn(|j| if i == j { 1.0 } else { 0.0 }));
        self.kinematics.write_product(x, ReferenceFrame::LocalWorldAligned, &linear, jacobian.by_state);
        self.evaluate(x, u, residual)
    }

    fn boxed_clone(&self) -> Box<dyn Residual> {
        Box::new(self.clone())
    }
}

/// r = log(R\*ᵀR): the rotation of a frame relative to a target, along the target's axes \[rad\].
#[derive(Clone, Debug)]
pub struct FrameRotationResidual(FramePlacementResidual);

impl FrameRotationResidual {
    /// The rotation of the frame relative to that of `target` in the world.
    ///
    /// # Errors
    /// [`InvalidInput`] if the target is not a rotation.
    ///
    /// # Panics
    /// If the frame belongs to another model.
    #[track_caller]
    pub fn new(
        model: impl Into<Arc<Model>>,
        frame: FrameId,
        target: [[f64; 3]; 3],
    ) -> Result<Self, InvalidInput> {
        let target = Pose { rotation: target, translation: [0.0; 3] };
        Ok(Self(FramePlacementResidual::new(model, frame, target)?))
    }

    /// `target_from_frame` without the translation.
    fn relative(&mut self, x: &[f64]) -> Pose {
        Pose { translation: [0.0; 3], ..self.0.relative(x) }
    }
}

impl Residual for FrameRotationResidual {
    fn dimension(&self) -> usize {
        3
    }

    fn expects(&self) -> ResidualInputs {
        self.0.expects()
    }

    fn evaluate(&mut self, x: &[f64], _u: &[f64], residual: &mut [f64]) -> Result<(), StepError> {
        residual.copy_from_slice(&self.relative(x).log().1);
        Ok(())
    }

    fn linearize(
        &mut self,
        x: &[f64],
        _u: &[f64],
        residual: &mut [f64],
        jacobian: ResidualJacobian<'_>,
    ) -> Result<(), StepError> {
        let relative = self.relative(x);
        residual.copy_from_slice(&relative.log().1);
        let derivative = relative.log_derivative();
        let axes = ReferenceFrame::Local;
        self.0.kinematics.write_product(x, axes, &derivative[3..], jacobian.by_state);
        Ok(())
    }

    fn boxed_clone(&self) -> Box<dyn Residual> {
        Box::new(self.clone())
    }
}

/// r = log(T\*⁻¹T), six numbers, linear before angular: the pose of a frame relative to a target \[m, rad\].
#[derive(Clone, Debug)]
pub struct FramePlacementResidual {
    kinematics: FrameKinematics,
    /// `target_from_world`.
    target: Pose,
}

/// The largest defect of a target's rotation that counts as rounding of six digits.
const ROTATION_ROUNDING: f64 = 1e-6;

impl FramePlacementResidual {
    /// The pose of the frame relative to `target`, `world_from_target`.
    ///
    /// # Errors
    /// [`InvalidInput`] if the target is not finite or not a rotation.
    ///
    /// # Panics
    /// If the frame belongs to another model.
    #[track_caller]
    pub fn new(model: impl Into<Arc<Model>>, frame: FrameId, target: Pose) -> Result<Self, InvalidInput> {
        check_finite("the target position", &target.translation)?;
        let defect = target.rotation_defect();
        let is_rotation = defect <= ROTATION_ROUNDING;
        if !is_rotation {
            let problem = robot_dynamics_number::InputProblem::NotARotation { defect };
            return Err(InvalidInput::new("the target", problem));
        }
        Ok(Self { kinematics: FrameKinematics::new(model.into(), frame), target: target.inverse() })
    }

    /// `target_from_frame`.
    fn relative(&mut self, x: &[f64]) -> Pose {
        self.target.compose(&self.kinematics.pose(x))
    }
}

impl Residual for FramePlacementResidual {
    fn dimension(&self) -> usize {
        6
    }

    fn expects(&self) -> ResidualInputs {
        self.kinematics.inputs()
    }

    fn evaluate(&mut self, x: &[f64], _u: &[f64], residual: &mut [f64]) -> Result<(), StepError> {
        let (linear, angular) = self.relative(x).log();
        residual[..3].copy_from_slice(&linear);
        residual[3..].copy_from_slice(&angular);
        Ok(())
    }

    fn linearize(
        &mut self,
        x: &[f64],
        u: &[f64],
        residual: &mut [f64],
        jacobian: ResidualJacobian<'_>,
    ) -> Result<(), StepError> {
        let derivative = self.relative(x).log_derivative();
        self.kinematics.write_product(x, ReferenceFrame::Local, &derivative, jacobian.by_state);
        self.evaluate(x, u, residual)
    }

    fn boxed_clone(&self) -> Box<dyn Residual> {
        Box::new(self.clone())
    }
}
