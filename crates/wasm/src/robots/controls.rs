//! The controls of the file's actuators, as a function of time.

use robot_dynamics::description::ActuatorDescription;
use wasm_bindgen::prelude::wasm_bindgen;

use super::control_line::ControlLine;
use super::robot::Robot;
use super::text::shown;
use crate::LabError;
use crate::input::finite;

/// For a sequence of poses: the time at each pose, and the time of each linear transition \[s\].
const KEPT: f64 = 0.5;
const REACHED: f64 = 0.5;

/// An actuator of the file.
#[wasm_bindgen(getter_with_clone)]
#[derive(Clone, Debug)]
pub struct RobotControl {
    /// Its name.
    #[wasm_bindgen(readonly)]
    pub name: String,
    /// Lower bound of the control; infinite if unbounded.
    #[wasm_bindgen(readonly)]
    pub lower: f64,
    /// Upper bound.
    #[wasm_bindgen(readonly)]
    pub upper: f64,
}

/// A pose of the file.
#[wasm_bindgen(getter_with_clone)]
#[derive(Clone, Debug)]
pub struct RobotPose {
    /// Its name.
    #[wasm_bindgen(readonly)]
    pub name: String,
    /// q.
    #[wasm_bindgen(readonly)]
    pub q: Vec<f64>,
    /// v.
    #[wasm_bindgen(readonly)]
    pub v: Vec<f64>,
    /// Its controls; empty if the pose has none.
    #[wasm_bindgen(readonly)]
    pub controls: Vec<f64>,
}

#[wasm_bindgen]
impl Robot {
    /// The file's actuators, in the order of the controls.
    pub fn actuators(&self) -> Vec<RobotControl> {
        let control = |actuator: &ActuatorDescription| {
            let [lower, upper] = actuator.control_range;
            RobotControl { name: shown(&actuator.name), lower, upper }
        };
        self.model.description().actuators.iter().map(control).collect()
    }

    /// The file's poses by their names.
    #[wasm_bindgen(js_name = namedPoses)]
    pub fn named_poses(&self) -> Vec<RobotPose> {
        let poses = self.model.description().poses.iter();
        let found = poses.filter_map(|pose| {
            let (q, v) = self.model.named_pose(&pose.name)?;
            Some(RobotPose { name: shown(&pose.name), q, v, controls: pose.controls.clone() })
        });
        found.collect()
    }

    /// The current controls.
    pub fn controls(&self) -> Vec<f64> {
        let mut controls = vec![0.0; self.model.description().actuators.len()];
        self.controls.at(self.time(), &mut controls);
        controls
    }

    /// Sets constant controls.
    ///
    /// # Errors
    /// Fails if their number is wrong or one is not finite.
    #[wasm_bindgen(js_name = setControls)]
    pub fn set_controls(&mut self, controls: &[f64]) -> Result<(), LabError> {
        finite("the controls", controls, self.model.description().actuators.len())?;
        self.controls = ControlLine::constant(controls.to_vec());
        Ok(())
    }

    /// Sets the controls to those of the file's poses in turn, from time 0 on. Each pose lasts half a second,
    /// as does each linear transition; the last pose stays. With fewer than two such poses nothing changes.
    #[wasm_bindgen(js_name = posesInTurn)]
    pub fn poses_in_turn(&mut self) {
        let poses = &self.model.description().poses;
        let given: Vec<&Vec<f64>> =
            poses.iter().map(|pose| &pose.controls).filter(|u| !u.is_empty()).collect();
        if given.len() < 2 {
            return;
        }
        let mut line = ControlLine::default();
        for (k, controls) in given.into_iter().enumerate() {
            let start = (KEPT + REACHED) * k as f64;
            for time in [start, start + KEPT] {
                line.times.push(time);
                line.controls.push(controls.clone());
            }
        }
        self.controls = line;
    }
}
