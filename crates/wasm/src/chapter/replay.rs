//! Replay: one path of the two-link arm at a variable speed.

use core::f64::consts::TAU;

use dynamics::{
    FourierLoop, Path, PathDynamics, REACH_REPLAY_SPEED, REACH_TORQUE_LIMITS, Reach2R,
    fastest_constant_speed, peak_torque, reach_replay,
};
use wasm_bindgen::prelude::wasm_bindgen;

use super::closed_form::elbow_and_tip;
use crate::LabError;
use crate::input::{number, positive};

/// Number of samples of the loop for its peak torques.
const SAMPLES: usize = 2000;

/// The arm of the worked example on its closed path. The speed along the path is an argument.
#[wasm_bindgen]
#[derive(Clone, Copy, Debug)]
pub struct Replay {
    arm: Reach2R,
    path: FourierLoop<2, 2>,
}

#[wasm_bindgen]
impl Replay {
    /// The path of the library's example.
    #[wasm_bindgen(constructor)]
    #[allow(clippy::new_without_default)] // // a JavaScript constructor
    pub fn new() -> Self {
        Self { arm: Reach2R::worked_example(), path: reach_replay() }
    }

    /// The torque limits of the two joints \[N·m\].
    #[wasm_bindgen(getter)]
    pub fn limits(&self) -> Vec<f64> {
        REACH_TORQUE_LIMITS.as_slice().to_vec()
    }

    /// Duration of one loop at 1× \[s\].
    #[wasm_bindgen(getter)]
    pub fn duration(&self) -> f64 {
        TAU / REACH_REPLAY_SPEED
    }

    /// q1, q2 and x, y of elbow and tip at the fraction `turn` of the loop.
    ///
    /// # Errors
    /// Fails if `turn` is not finite.
    pub fn pose(&self, turn: f64) -> Result<Vec<f64>, LabError> {
        let q = self.path.at(number("turn", turn)? * TAU).q;
        Ok([q[0], q[1]].into_iter().chain(elbow_and_tip(&self.arm, &q)).collect())
    }

    /// τ of both joints at the fraction `turn` of the loop at `times` the speed, b ṡ² + c; then c alone.
    ///
    /// # Errors
    /// Fails if an argument is not finite.
    pub fn torque(&self, turn: f64, times: f64) -> Result<Vec<f64>, LabError> {
        let terms = PathDynamics::new(&self.arm, &self.path.at(number("turn", turn)? * TAU));
        let torque = terms.torque(number("the speed", times)? * REACH_REPLAY_SPEED, 0.0);
        Ok(vec![torque[0], torque[1], terms.c[0], terms.c[1]])
    }

    /// The largest |τ| of each joint over the loop at `times` the speed.
    ///
    /// # Errors
    /// Fails if `times` is not finite.
    #[wasm_bindgen(js_name = peakTorque)]
    pub fn peak_torque(&self, times: f64) -> Result<Vec<f64>, LabError> {
        let speed = number("the speed", times)? * REACH_REPLAY_SPEED;
        Ok(peak_torque(&self.arm, &self.path, speed, SAMPLES).as_slice().to_vec())
    }

    /// The largest speed of the loop within the limits, as a multiple of 1×.
    ///
    /// # Errors
    /// Fails if gravity alone exceeds the limits.
    #[wasm_bindgen(js_name = fastestSpeed)]
    pub fn fastest_speed(&self) -> Result<f64, LabError> {
        fastest_constant_speed(&self.arm, &self.path, &REACH_TORQUE_LIMITS, SAMPLES)
            .map(|speed| speed / REACH_REPLAY_SPEED)
            .ok_or_else(|| LabError::new("gravity alone exceeds a torque limit on this path"))
    }

    /// Rows of seven over one loop at `times` the speed: t, q1, q2, x, y of the tip, τ1, τ2.
    ///
    /// # Errors
    /// Fails if `times` is not positive or the number of rows is zero.
    #[wasm_bindgen(js_name = loopSamples)]
    pub fn loop_samples(&self, times: f64, count: u32) -> Result<Vec<f64>, LabError> {
        let (times, rows_asked) = (positive("the speed", times)?, count);
        let count = positive("the count", count.into())?;
        let mut rows = Vec::new();
        for i in 0..=rows_asked {
            let turn = f64::from(i) / count;
            let (pose, torque) = (self.pose(turn)?, self.torque(turn, times)?);
            rows.extend([
                turn * self.duration() / times,
                pose[0],
                pose[1],
                pose[4],
                pose[5],
                torque[0],
                torque[1],
            ]);
        }
        Ok(rows)
    }
}
