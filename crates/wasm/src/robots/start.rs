//! The start of a run: a valid pose, and a step that balances the energy.

use robot_dynamics::model::neutral;
use wasm_bindgen::prelude::wasm_bindgen;

use super::choice::Choice;
use super::robot::Robot;
use crate::LabError;

/// Margin of a limit around zero, below which a joint starts in the middle of its range \[rad or m\].
const LEEWAY: f64 = 0.05;

/// Steps to try \[s\], the duration of each trial \[s\], and the allowed residual as a fraction of the
/// energies.
const STEPS: [f64; 4] = [1e-3, 5e-4, 2e-4, 1e-4];
const TRIAL: f64 = 0.05;
const SHARE: f64 = 1e-4;

#[wasm_bindgen]
impl Robot {
    /// The first pose of the file, or the neutral configuration with joints that exclude zero, or nearly so,
    /// in the middle of their range. A pose in the ground is lifted.
    #[wasm_bindgen(js_name = startPose)]
    pub fn start_pose(&self) -> Vec<f64> {
        let mut q = self.first_pose();
        self.lift(&mut q);
        q
    }

    fn first_pose(&self) -> Vec<f64> {
        let named = self.model.description().poses.first().and_then(|pose| self.model.named_pose(&pose.name));
        if let Some((q, _)) = named {
            return q;
        }
        let mut q = neutral(&self.model);
        for coordinate in self.coordinates() {
            let (Some(place), lower, upper) = (coordinate.place, coordinate.lower, coordinate.upper) else {
                continue;
            };
            if (lower > -LEEWAY || upper < LEEWAY) && (lower + upper).is_finite() {
                q[place as usize] = 0.5 * (lower + upper);
            }
        }
        q
    }

    /// The largest of a few steps \[s\] that keeps the energy balanced for a twentieth of a second of falling
    /// from the start pose. Leaves the robot there at rest.
    ///
    /// # Errors
    /// Fails if the start pose is invalid.
    #[wasm_bindgen(js_name = steadyStep)]
    pub fn steady_step(&mut self) -> Result<f64, LabError> {
        let start = self.start_pose();
        let mut steady = STEPS[STEPS.len() - 1];
        for h in STEPS {
            self.set_up(Choice { step: h, ..self.choice.clone() })?;
            self.place(&start)?;
            #[allow(clippy::cast_possible_truncation, clippy::cast_sign_loss)] // // a few hundred
            let steps = (TRIAL / h).round() as u32;
            if self.advance(steps).is_ok()
                && self.simulation.energy_account().imbalance().abs() < SHARE * self.energy_at_stake()
            {
                steady = h;
                break;
            }
        }
        self.set_up(Choice { step: steady, ..self.choice.clone() })?;
        self.place(&start)?;
        Ok(steady)
    }

    /// The reference for an energy imbalance \[J\].
    pub(crate) fn energy_at_stake(&self) -> f64 {
        let energy_account = self.simulation.energy_account();
        [energy_account.start(), energy_account.now(), energy_account.work(), energy_account.dissipated()]
            .iter()
            .fold(1.0, |most: f64, e| most.max(e.abs()))
    }
}
