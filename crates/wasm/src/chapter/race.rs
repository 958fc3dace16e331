//! The integrator race: one fall by several integrators of the table.

use dynamics::{Dynamics, EnergyAccount, Integrator, Reach2R, SystemEnergy, SystemStep};
use nalgebra::Vector2;
use wasm_bindgen::prelude::wasm_bindgen;

use super::closed_form::elbow_and_tip;
use crate::LabError;
use crate::input::{integrator, positive, vector};

/// Number of time intervals of the plot.
const BUCKETS: u64 = 600;

/// Runs of the worked example's arm by several integrators, from one state and with one step.
#[wasm_bindgen]
#[derive(Clone, Debug)]
pub struct Race {
    arm: Reach2R,
    h: f64,
    runners: Vec<Runner>,
    steps: u64,
    bucket: u64,
    times: Vec<f64>,
}

/// One integrator's run.
#[derive(Clone, Debug)]
struct Runner {
    integrator: Integrator,
    q: Vector2<f64>,
    qd: Vector2<f64>,
    energy_account: EnergyAccount,
    /// The largest |E − E₀|/|E₀| in the current interval, and in each completed one.
    worst: f64,
    errors: Vec<f64>,
    /// The reason for leaving the race.
    fault: Option<String>,
}

#[wasm_bindgen]
impl Race {
    /// Starts at (q, q̇) with a step `h` \[s\] for `duration` \[s\], with the named integrators.
    ///
    /// # Errors
    /// Fails if a name is unknown, or a number not finite or not positive.
    #[wasm_bindgen(constructor)]
    #[allow(clippy::needless_pass_by_value)] // // wasm-bindgen passes lists by value
    pub fn new(names: Vec<String>, q: &[f64], qd: &[f64], h: f64, duration: f64) -> Result<Self, LabError> {
        let arm = Reach2R::worked_example();
        let (q, qd) = (vector("q", q)?, vector("qd", qd)?);
        let (h, duration) = (positive("the step", h)?, positive("the duration", duration)?);
        let runners = names.iter().map(|name| {
            Ok(Runner {
                integrator: integrator(name)?,
                q,
                qd,
                energy_account: EnergyAccount::open(&arm as &dyn Dynamics<2>, &q, &qd),
                worst: 0.0,
                errors: Vec::new(),
                fault: None,
            })
        });
        // Rounded up, so that the plot has at most `BUCKETS` points.
        #[allow(clippy::cast_possible_truncation, clippy::cast_sign_loss)]
        let bucket = ((duration / h).ceil() as u64).div_ceil(BUCKETS).max(1);
        Ok(Self {
            arm,
            h,
            runners: runners.collect::<Result<_, LabError>>()?,
            steps: 0,
            bucket,
            times: Vec::new(),
        })
    }

    /// Advances every runner that has not failed by whole steps.
    pub fn advance(&mut self, steps: u32) {
        for _ in 0..steps {
            self.steps += 1;
            let closes = self.steps.is_multiple_of(self.bucket);
            for runner in &mut self.runners {
                runner.advance(&self.arm, self.h);
                if closes && runner.fault.is_none() {
                    runner.errors.push(runner.worst);
                    runner.worst = 0.0;
                }
            }
            if closes {
                self.times.push(self.time());
            }
        }
    }

    /// Simulated time \[s\].
    #[wasm_bindgen(getter)]
    pub fn time(&self) -> f64 {
        self.steps as f64 * self.h
    }

    /// The times of the points of the plot \[s\].
    #[wasm_bindgen(getter)]
    pub fn times(&self) -> Vec<f64> {
        self.times.clone()
    }

    /// max |E − E₀|/|E₀| in each interval, for one runner; shorter than the times if the runner failed.
    ///
    /// # Errors
    /// Fails if the runner does not exist.
    pub fn errors(&self, runner: usize) -> Result<Vec<f64>, LabError> {
        Ok(self.runner(runner)?.errors.clone())
    }

    /// max |E − E₀|/|E₀| over the whole run so far.
    ///
    /// # Errors
    /// Fails if the runner does not exist.
    pub fn drift(&self, runner: usize) -> Result<f64, LabError> {
        Ok(self.runner(runner)?.energy_account.drift())
    }

    /// Elbow and tip of one runner: x, y, x, y \[m\].
    ///
    /// # Errors
    /// Fails if the runner does not exist.
    pub fn points(&self, runner: usize) -> Result<Vec<f64>, LabError> {
        Ok(elbow_and_tip(&self.arm, &self.runner(runner)?.q).to_vec())
    }

    /// The reason for a runner's failure; empty without one.
    ///
    /// # Errors
    /// Fails if the runner does not exist.
    pub fn fault(&self, runner: usize) -> Result<String, LabError> {
        Ok(self.runner(runner)?.fault.clone().unwrap_or_default())
    }

    fn runner(&self, index: usize) -> Result<&Runner, LabError> {
        let count = self.runners.len();
        self.runners.get(index).ok_or_else(|| LabError::new(format!("no runner {index} among {count}")))
    }
}

impl Runner {
    fn advance(&mut self, arm: &dyn Dynamics<2>, h: f64) {
        if self.fault.is_some() {
            return;
        }
        let zero = Vector2::zeros();
        match self.integrator.step(arm, &self.q, &self.qd, &zero, h) {
            Ok(next) => {
                let mut energy_account = self.energy_account;
                energy_account.record(arm, (&self.q, &self.qd), (&next.0, &next.1), &zero, h);
                let error = (energy_account.now() - energy_account.start()).abs() / energy_account.scale();
                if error.is_finite() {
                    self.worst = self.worst.max(error);
                    ((self.q, self.qd), self.energy_account) = (next, energy_account);
                } else {
                    self.fault = Some("the energy is not finite; use a smaller step".into());
                }
            }
            Err(error) => self.fault = Some(error.to_string()),
        }
    }
}
