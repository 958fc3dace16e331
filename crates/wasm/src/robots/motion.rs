//! The motion of the robot.

use std::sync::Arc;

use dynamics::EnergyAccount;
use robot_dynamics::algorithms::inverse_mass_matrix;
use robot_dynamics::model::normalize_quaternions;
use robot_dynamics::simulation::{Controller, GravityCompensatedPd};
use wasm_bindgen::prelude::wasm_bindgen;

use super::robot::{Hold, INTERVAL, KEPT, Robot};
use super::step::CompletedStep;
use crate::LabError;
use crate::input::{finite, not_negative};
use crate::samples::Samples;

/// Allowed energy residual as a fraction of the energies. With stiff joints and long steps the energy grows
/// before it becomes infinite.
const SHARE: f64 = 0.1;

#[wasm_bindgen]
impl Robot {
    /// Puts the robot at rest at q (with quaternions normalised and loops closed), and resets time and the
    /// energy account.
    ///
    /// # Errors
    /// Fails if q has the wrong length or is not finite.
    pub fn place(&mut self, q: &[f64]) -> Result<(), LabError> {
        let rest = vec![0.0; self.model.nv()];
        self.place_moving(q, &rest)
    }

    /// Puts the robot at q with velocity v.
    ///
    /// # Errors
    /// Fails if q or v has the wrong length or is not finite.
    #[wasm_bindgen(js_name = placeMoving)]
    pub fn place_moving(&mut self, q: &[f64], v: &[f64]) -> Result<(), LabError> {
        finite("q", q, self.model.nq())?;
        finite("v", v, self.model.nv())?;
        let (mut q, mut v) = (q.to_vec(), v.to_vec());
        normalize_quaternions(&self.model, &mut q);
        self.close(&mut q, &mut v);
        self.simulation.reset(&q, &v)?;
        (self.since, self.last) = (0.0, None);
        self.samples.clear();
        self.sample();
        Ok(())
    }

    /// Holds the current pose with gravity compensation. Each coordinate is an oscillator of this natural
    /// frequency \[rad/s\] and damping ratio: Kp = ω²/(M⁻¹)ᵢᵢ, Kd = 2ζω/(M⁻¹)ᵢᵢ at the pose.
    ///
    /// 1/(M⁻¹)ᵢᵢ is the effective inertia for a torque at coordinate i alone. All eigenvalues of M⁻¹Kd are
    /// then at most nv·2ζω, which avoids excessive gains at light joints. A floating base has no motors.
    /// Meanwhile the file's actuators are switched off, and torques are limited to the effort limits.
    ///
    /// # Errors
    /// Fails if the frequency or the ratio is negative.
    pub fn hold(&mut self, frequency: f64, damping_ratio: f64) -> Result<(), LabError> {
        let here = self.q();
        self.hold_at(&here, frequency, damping_ratio)
    }

    /// Holds a given pose.
    ///
    /// # Errors
    /// Fails if the pose is invalid, or the frequency or the ratio is negative.
    #[wasm_bindgen(js_name = holdAt)]
    pub fn hold_at(&mut self, pose: &[f64], frequency: f64, damping_ratio: f64) -> Result<(), LabError> {
        finite("the pose", pose, self.model.nq())?;
        let mut pose = pose.to_vec();
        normalize_quaternions(&self.model, &mut pose);
        let (frequency, ratio) =
            (not_negative("the frequency", frequency)?, not_negative("ζ", damping_ratio)?);
        let nv = self.model.nv();
        let mut inverse = vec![0.0; nv * nv];
        inverse_mass_matrix(&self.model, &mut self.workspace, &pose, &mut inverse);
        let inertia: Vec<f64> = (0..nv).map(|i| 1.0 / inverse[i * nv + i]).collect();
        let hold = Hold {
            target: pose,
            stiffness: inertia.iter().map(|i| frequency * frequency * i).collect(),
            damping: inertia.iter().map(|i| 2.0 * ratio * frequency * i).collect(),
        };
        self.set_hold(Some(hold))
    }

    /// The held pose; empty if the motors are off.
    #[wasm_bindgen(getter)]
    pub fn held(&self) -> Vec<f64> {
        self.hold.as_ref().map_or_else(Vec::new, |hold| hold.target.clone())
    }

    /// Switches the motors off.
    ///
    /// # Errors
    /// Fails if the file's actuators cannot be switched on again.
    pub fn release(&mut self) -> Result<(), LabError> {
        self.set_hold(None)
    }

    /// The largest number of steps in which the torque of a coordinate was at its effort limit.
    #[wasm_bindgen(getter, js_name = stepsAtLimit)]
    pub fn steps_at_limit(&self) -> usize {
        self.simulation.steps_at_effort_limits().iter().copied().max().unwrap_or(0)
    }

    /// Advances by whole steps.
    ///
    /// # Errors
    /// Fails if a step fails, or if the motion or its energy diverges; the state before it is kept.
    pub fn advance(&mut self, steps: u32) -> Result<(), LabError> {
        let model = Arc::clone(&self.model);
        let mut holding = match &self.hold {
            Some(Hold { target, stiffness, damping }) => {
                // The simulation limits torques and counts the steps.
                let unlimited = vec![f64::INFINITY; model.nv()];
                Some(GravityCompensatedPd::new(&model, target, stiffness, damping)?.with_limits(&unlimited))
            }
            None => None,
        };
        let mut torques = vec![0.0; model.nv()];
        let mut controls = vec![0.0; self.simulation.controls().len()];
        self.last = None;
        for step in 0..steps {
            // The inputs of this step: motors that hold a pose, the file's actuators, and the hand.
            let (q, v) = (self.simulation.q().to_vec(), self.simulation.v().to_vec());
            if let Some(motors) = &mut holding {
                motors.torque(self.simulation.time(), &q, &v, &mut torques)?;
            }
            self.controls.at(self.time(), &mut controls);
            let pull = self.hand.as_mut().map(|hand| hand.pull(&q, &v, &mut self.pull));
            self.simulation.set_torques(&torques);
            self.simulation.set_controls(&controls);
            self.simulation.set_wrenches(pull.as_slice());
            self.simulation.step()?;
            if step + 1 == steps {
                self.last = Some(self.step_from(q, v));
            }
            if self.samples.due(self.simulation.steps() as u64) {
                self.sample();
            }
        }
        let off = self.simulation.energy_account().imbalance();
        if off.abs() > SHARE * self.energy_at_stake() {
            return Err(LabError::new(format!(
                "{off:.1} J have come from nowhere by {:.2} s: the step is too long for this robot. Take a smaller step and \
                 reset.",
                self.time()
            )));
        }
        Ok(())
    }

    /// Rows of four: t, K, V, residual.
    pub fn samples(&self) -> Vec<f64> {
        self.samples.flat()
    }

    pub(crate) fn sample(&mut self) {
        self.samples.push(row(self.time(), self.simulation.energy_account()));
    }

    /// Starts new samples for a new step.
    pub(crate) fn begin_samples(&mut self) {
        self.samples = Samples::new(INTERVAL, self.choice.step, KEPT);
        self.sample();
    }
}

impl Robot {
    /// Rebuilds the simulation, since motors that hold a pose replace the file's actuators.
    fn set_hold(&mut self, hold: Option<Hold>) -> Result<(), LabError> {
        let is_another = self.hold.is_some() != hold.is_some();
        let before = core::mem::replace(&mut self.hold, hold);
        if is_another && !self.model.description().actuators.is_empty() {
            self.set_up(self.choice.clone()).inspect_err(|_| self.hold = before)?;
        }
        Ok(())
    }

    /// The step just taken from that state.
    fn step_from(&self, q: Vec<f64>, v: Vec<f64>) -> CompletedStep {
        let simulation = &self.simulation;
        let mut tau = simulation.applied_torques().to_vec();
        for (k, tau) in tau.iter_mut().enumerate() {
            *tau += simulation.actuator_torques().get(k).unwrap_or(&0.0);
            *tau += if self.hand.is_some() { self.pull[k] } else { 0.0 };
        }
        CompletedStep { q, v, tau, h: simulation.dt() }
    }
}

/// One row of the samples.
fn row(time: f64, energy_account: &EnergyAccount) -> [f64; 4] {
    [time, energy_account.kinetic(), energy_account.potential(), energy_account.imbalance()]
}
