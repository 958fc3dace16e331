//! The workbench: a two-link arm under PD control with gravity compensation.

use dynamics::{Dynamics, HoldRun, PdHold, Reach2R, hold, rk4_step};
use nalgebra::{Vector2, vector};
use wasm_bindgen::prelude::wasm_bindgen;

use super::closed_form::elbow_and_tip;
use crate::LabError;
use crate::input::{finite, not_negative, vector};
use crate::samples::Samples;

/// Control period and integrator step \[s\], sampling period \[s\], and the number of samples kept.
const STEP: f64 = 1e-3;
const INTERVAL: f64 = 0.01;
const KEPT: usize = 1200;
/// The predicted run: its length in steps, and the tolerance of settling \[rad\].
const STEPS: usize = 6000;
const BAND: f64 = 0.01;

/// Torques of the two joints \[N·m\].
#[wasm_bindgen]
#[derive(Clone, Copy, Debug)]
pub struct HoldTorques {
    /// Joint 1, current.
    #[wasm_bindgen(readonly)]
    pub joint1: f64,
    /// Joint 2, current.
    #[wasm_bindgen(readonly)]
    pub joint2: f64,
    /// Joint 1, largest since the start.
    #[wasm_bindgen(readonly)]
    pub peak1: f64,
    /// Joint 2, largest since the start.
    #[wasm_bindgen(readonly)]
    pub peak2: f64,
}

/// The predicted response to the gains.
#[wasm_bindgen]
#[derive(Clone, Copy, Debug)]
pub struct HoldForecast {
    /// M₁₁ at the waypoint \[kg·m²\].
    #[wasm_bindgen(readonly)]
    pub inertia: f64,
    /// ζ of joint 1 at the waypoint.
    #[wasm_bindgen(readonly)]
    pub ratio: f64,
    /// The overshoot of joint 1 \[rad\].
    #[wasm_bindgen(readonly)]
    pub overshoot: f64,
    /// The settling time of both joints \[s\]; `undefined` if they do not settle.
    #[wasm_bindgen(readonly)]
    pub settles: Option<f64>,
}

/// The arm of the worked example and its controller.
#[wasm_bindgen]
#[derive(Clone, Debug)]
pub struct Workbench {
    arm: Reach2R,
    control: PdHold<2>,
    q: Vector2<f64>,
    qd: Vector2<f64>,
    steps: u64,
    peak: Vector2<f64>,
    samples: Samples<5>,
}

state_getters! {
    Workbench:
    /// q \[rad\].
    q,
    /// q̇ \[rad/s\].
    qd
}

#[wasm_bindgen]
impl Workbench {
    /// The arm of the worked example, or the same arm in a horizontal plane without gravity.
    #[wasm_bindgen(constructor)]
    pub fn new(gravity: bool) -> Self {
        let mut arm = Reach2R::worked_example();
        if !gravity {
            arm.a_g = 0.0;
        }
        let zero = Vector2::zeros();
        let control =
            PdHold { target: zero, stiffness: zero, damping: zero, limits: dynamics::REACH_TORQUE_LIMITS };
        Self {
            arm,
            control,
            q: zero,
            qd: zero,
            steps: 0,
            peak: zero,
            samples: Samples::new(INTERVAL, STEP, KEPT),
        }
    }

    /// Restarts at rest at q \[rad\].
    ///
    /// # Errors
    /// Fails if a number is not finite.
    pub fn place(&mut self, q: &[f64]) -> Result<(), LabError> {
        self.place_moving(q, &[0.0, 0.0])
    }

    /// Restarts at q \[rad\] with q̇ \[rad/s\].
    ///
    /// # Errors
    /// Fails if a number is not finite.
    #[wasm_bindgen(js_name = placeMoving)]
    pub fn place_moving(&mut self, q: &[f64], qd: &[f64]) -> Result<(), LabError> {
        (self.q, self.qd) = (vector("q", q)?, vector("qd", qd)?);
        (self.steps, self.peak) = (0, Vector2::zeros());
        self.samples.clear();
        self.sample();
        Ok(())
    }

    /// Sets the waypoint q\* \[rad\].
    ///
    /// # Errors
    /// Fails if a number is not finite.
    #[wasm_bindgen(js_name = setTarget)]
    pub fn set_target(&mut self, target: &[f64]) -> Result<(), LabError> {
        self.control.target = vector("the waypoint", target)?;
        Ok(())
    }

    /// Sets the gains Kp \[N·m/rad\], Kd \[N·m·s/rad\] and the limits \[N·m\], two joints each.
    ///
    /// # Errors
    /// Fails if a number is negative or not finite.
    #[wasm_bindgen(js_name = setControl)]
    pub fn set_control(
        &mut self,
        stiffness: &[f64],
        damping: &[f64],
        limits: &[f64],
    ) -> Result<(), LabError> {
        for (name, values) in [("the stiffness", stiffness), ("the damping", damping), ("the limit", limits)]
        {
            finite(name, values, 2)?;
            values.iter().try_for_each(|&value| not_negative(name, value).map(drop))?;
        }
        self.control.stiffness = vector("the stiffness", stiffness)?;
        self.control.damping = vector("the damping", damping)?;
        self.control.limits = vector("the limits", limits)?;
        Ok(())
    }

    /// Advances by steps of a millisecond.
    ///
    /// # Errors
    /// Fails if a step fails; the state before it is kept.
    pub fn advance(&mut self, steps: u32) -> Result<(), LabError> {
        for _ in 0..steps {
            let torque = self.control.torque(&self.arm, &self.q, &self.qd);
            let next = rk4_step(&self.arm as &dyn Dynamics<2>, &self.q, &self.qd, &torque, STEP)?;
            self.peak = self.peak.sup(&torque.abs());
            (self.q, self.qd) = next;
            self.steps += 1;
            if self.samples.due(self.steps) {
                self.sample();
            }
        }
        Ok(())
    }

    /// Elbow and tip at q, then at the waypoint: four pairs x, y \[m\].
    #[wasm_bindgen(getter)]
    pub fn points(&self) -> Vec<f64> {
        let (now, then) = (elbow_and_tip(&self.arm, &self.q), elbow_and_tip(&self.arm, &self.control.target));
        now.into_iter().chain(then).collect()
    }

    /// The current τ, and its peak since the start.
    #[wasm_bindgen(getter)]
    pub fn torque(&self) -> HoldTorques {
        let now = self.control.torque(&self.arm, &self.q, &self.qd);
        HoldTorques { joint1: now[0], joint2: now[1], peak1: self.peak[0], peak2: self.peak[1] }
    }

    /// The joints (from 0) whose torque limit is below the weight at the waypoint.
    #[wasm_bindgen(getter)]
    pub fn overloaded(&self) -> Vec<u32> {
        let joints = self.control.overloaded_joints(&self.arm);
        joints.into_iter().filter_map(|joint| u32::try_from(joint).ok()).collect()
    }

    /// The prediction by a run of 6 s from q at rest.
    ///
    /// # Errors
    /// Fails if q is not finite or a step fails.
    pub fn predict(&self, q: &[f64]) -> Result<HoldForecast, LabError> {
        let run = HoldRun { step: STEP, steps: STEPS, band: BAND };
        let report =
            hold(&self.arm as &dyn Dynamics<2>, &self.control, &vector("q", q)?, &vector![0.0, 0.0], &run)?;
        let target = &self.control.target;
        Ok(HoldForecast {
            inertia: self.arm.mass(target)[(0, 0)],
            ratio: self.control.damping_ratio(&self.arm, target)[0],
            overshoot: report.overshoot[0],
            settles: report.settling_time,
        })
    }

    /// Rows of five: t, q1, q2, τ1, τ2.
    pub fn samples(&self) -> Vec<f64> {
        self.samples.flat()
    }

    fn sample(&mut self) {
        let torque = self.control.torque(&self.arm, &self.q, &self.qd);
        self.samples.push([self.time(), self.q[0], self.q[1], torque[0], torque[1]]);
    }
}
