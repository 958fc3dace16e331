//! Grips of a point of the robot, and the mass that the hand feels there.

use robot_dynamics::algorithms::{ReferenceFrame, frame_jacobian, frame_pose};
use robot_dynamics::control::{InverseKinematicsError, InverseKinematicsOptions, inverse_kinematics};
use wasm_bindgen::prelude::wasm_bindgen;

use super::hand::{Hand, mobility};
use super::robot::Robot;
use crate::LabError;
use crate::input::finite;

/// Tolerance of inverse kinematics \[m\], and the number of its iterations in one call.
const NEAR: f64 = 1e-5;
const STEPS: usize = 30;

/// The effective mass at the held point by direction, (J M⁻¹ Jᵀ)⁻¹. **(Khatib 1987)**
#[wasm_bindgen(getter_with_clone)]
#[derive(Clone, Debug)]
pub struct FeltMass {
    /// Along each axis \[kg\]; infinite in directions without motion.
    #[wasm_bindgen(readonly)]
    pub masses: Vec<f64>,
    /// World frame from these axes, in row-major order.
    #[wasm_bindgen(readonly)]
    pub axes: Vec<f64>,
}

#[wasm_bindgen]
impl Robot {
    /// The effective mass at the held point; `undefined` without a grip.
    #[wasm_bindgen(js_name = feltMass)]
    pub fn felt_mass(&mut self) -> Option<FeltMass> {
        let Hand { model, workspace, point, jacobian, .. } = self.hand.as_mut()?;
        frame_jacobian(
            model,
            workspace,
            self.simulation.q(),
            *point,
            ReferenceFrame::LocalWorldAligned,
            jacobian,
        );
        let eigen = mobility(model, workspace, self.simulation.q(), jacobian).symmetric_eigen();
        let masses =
            eigen.eigenvalues.iter().map(|m| if *m > 1e-9 { 1.0 / m } else { f64::INFINITY }).collect();
        Some(FeltMass { masses, axes: eigen.eigenvectors.transpose().as_slice().to_vec() })
    }

    /// Grips that link at a point of the world \[m\].
    ///
    /// # Errors
    /// Fails if the link does not exist, or the point is not three finite numbers.
    pub fn grab(&mut self, link: usize, point: &[f64]) -> Result<(), LabError> {
        finite("the point", point, 3)?;
        self.hand = Some(Hand::new(&self.model, self.simulation.q(), link, [point[0], point[1], point[2]])?);
        Ok(())
    }

    /// Moves the hand \[m\]; a moving robot is pulled after it.
    ///
    /// # Errors
    /// Fails if the point is not three finite numbers.
    #[wasm_bindgen(js_name = pullTo)]
    pub fn pull_to(&mut self, point: &[f64]) -> Result<(), LabError> {
        finite("the point", point, 3)?;
        if let Some(hand) = &mut self.hand {
            hand.target.copy_from_slice(point);
        }
        Ok(())
    }

    /// Moves the held point of a robot at rest to this point \[m\], as close as the joints' limits allow.
    /// Returns the remaining distance \[m\].
    ///
    /// # Errors
    /// Fails if the point is not three finite numbers.
    #[wasm_bindgen(js_name = leadTo)]
    pub fn lead_to(&mut self, point: &[f64]) -> Result<f64, LabError> {
        self.pull_to(point)?;
        let Some(Hand { model, workspace, point, target, .. }) = &mut self.hand else { return Ok(0.0) };
        let options = InverseKinematicsOptions::default()
            .with_tolerances(NEAR, NEAR)
            .with_iterations(STEPS)
            .with_restarts(0, 0);
        let found = match inverse_kinematics(model, workspace, *point, *target, self.simulation.q(), &options)
        {
            Ok(found) => found,
            Err(InverseKinematicsError::NoSolution { best, .. }) => *best,
            Err(error) => return Err(error.into()),
        };
        self.place(&found.q)?;
        Ok(found.position_error)
    }

    /// The held point: three numbers \[m\], or none without a grip.
    #[wasm_bindgen(js_name = heldPoint)]
    pub fn held_point(&mut self) -> Vec<f64> {
        match &mut self.hand {
            Some(Hand { model, workspace, point, .. }) => {
                frame_pose(model, workspace, self.simulation.q(), *point).translation.to_vec()
            }
            None => Vec::new(),
        }
    }

    /// Releases the point.
    #[wasm_bindgen(js_name = letGo)]
    pub fn let_go(&mut self) {
        self.hand = None;
    }
}
