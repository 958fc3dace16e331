//! The robot in motion.

use dynamics::{EnergyLedger, check_finite};
use multibody::{
    Controller, GravityCompensatedPd, JointKind, StepForces, energy_ledger, inverse_mass_matrix,
    normalize_quaternions,
};
use wasm_bindgen::prelude::wasm_bindgen;

use super::method::Method;
use super::robot::{Hold, INTERVAL, KEPT, Robot};
use super::torques::Step;
use crate::LabError;
use crate::input::{finite, not_negative, positive};
use crate::samples::Samples;

/// What may be unaccounted for, as a share of the energies: a stiff joint and a long step make energy out of nothing before
/// they make infinities.
const SHARE: f64 = 0.1;

#[wasm_bindgen]
impl Robot {
    /// Puts the robot at rest at q (quaternions are normalised, loops closed), sets time to zero, opens new books.
    ///
    /// # Errors
    /// If q has the wrong length or is not finite.
    pub fn place(&mut self, q: &[f64]) -> Result<(), LabError> {
        let rest = vec![0.0; self.model.nv()];
        self.place_moving(q, &rest)
    }

    /// The same in motion, at v.
    ///
    /// # Errors
    /// If q or v has the wrong length or is not finite.
    #[wasm_bindgen(js_name = placeMoving)]
    pub fn place_moving(&mut self, q: &[f64], v: &[f64]) -> Result<(), LabError> {
        finite("q", q, self.model.nq())?;
        finite("v", v, self.model.nv())?;
        self.q.copy_from_slice(q);
        normalize_quaternions(&self.model, &mut self.q);
        self.v.copy_from_slice(v);
        self.close();
        (self.steps, self.time, self.last) = (0, 0.0, None);
        self.method.start_anew(&self.model, (self.floor.contacts.as_ref(), &self.loops));
        self.ledger = energy_ledger(&self.model, &mut self.workspace, &self.q, &self.v);
        self.samples.clear();
        self.sample();
        Ok(())
    }

    /// Chooses the method (`implicit` or a row of the table of integrators), the step \[s\], and whether damping and friction
    /// act.
    ///
    /// # Errors
    /// If the name is unknown or the step not positive.
    #[wasm_bindgen(js_name = setMethod)]
    pub fn set_method(&mut self, name: &str, h: f64, dissipation: bool) -> Result<(), LabError> {
        self.h = positive("the step", h)?;
        self.method = Method::named(name, &self.model, (self.floor.contacts.as_ref(), &self.loops))?;
        self.dissipation = dissipation;
        self.steps = 0;
        self.samples = Samples::new(INTERVAL, h, KEPT);
        Ok(())
    }

    /// Holds the present pose with gravity compensation, each coordinate as an oscillator of this natural
    /// frequency \[rad/s\] and damping ratio: Kp = ω²/(M⁻¹)ᵢᵢ, Kd = 2ζω/(M⁻¹)ᵢᵢ at the pose.
    ///
    /// 1/(M⁻¹)ᵢᵢ is the inertia that a torque at coordinate i alone feels. All eigenvalues of M⁻¹Kd are then at
    /// most nv·2ζω, so that a light joint is not shaken by a gain meant for a heavy one. A floating base has no
    /// motors.
    ///
    /// # Errors
    /// If the frequency or the ratio is negative.
    pub fn hold(&mut self, frequency: f64, damping_ratio: f64) -> Result<(), LabError> {
        let here = self.q.clone();
        self.hold_at(&here, frequency, damping_ratio)
    }

    /// The same for another pose than the present one.
    ///
    /// # Errors
    /// If the pose is none of this robot, or the frequency or the ratio is negative.
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
        let mut limits: Vec<f64> =
            self.model.coordinate_limits().iter().map(|limits| limits.effort).collect();
        for joint in self.model.joints().iter().filter(|joint| joint.kind == JointKind::Floating) {
            limits[joint.v_index..joint.v_index + joint.nv].fill(0.0);
        }
        self.hold = Some(Hold {
            target: pose,
            stiffness: inertia.iter().map(|i| frequency * frequency * i).collect(),
            damping: inertia.iter().map(|i| 2.0 * ratio * frequency * i).collect(),
            limits,
        });
        Ok(())
    }

    /// The pose that the motors hold; empty where they rest.
    #[wasm_bindgen(getter)]
    pub fn held(&self) -> Vec<f64> {
        self.hold.as_ref().map_or_else(Vec::new, |hold| hold.target.clone())
    }

    /// The motors rest.
    pub fn release(&mut self) {
        self.hold = None;
    }

    /// Advances by whole steps.
    ///
    /// # Errors
    /// Where a step fails or blows up, or energy comes from nowhere; the state before it is kept.
    pub fn advance(&mut self, steps: u32) -> Result<(), LabError> {
        let mut holding = match &self.hold {
            Some(Hold { target, stiffness, damping, limits }) => {
                Some(GravityCompensatedPd::new(&self.model, target, stiffness, damping)?.with_limits(limits))
            }
            None => None,
        };
        let (mut q, mut v) = (self.q.clone(), self.v.clone());
        self.last = None;
        for _ in 0..steps {
            // The forces of this step: motors, then the hand. What else acts on a robot from outside is added here.
            match &mut holding {
                Some(motors) => motors.torque(self.time, &self.q, &self.v, &mut self.tau)?,
                None => self.tau.fill(0.0),
            }
            if let Some(hand) = &mut self.hand {
                hand.pull(&self.q, &self.v, &mut self.tau);
            }
            let forces = StepForces::new(&self.tau, self.dissipation);
            self.method.step(
                &self.model,
                &mut self.workspace,
                &mut self.stepping,
                &mut self.ledger,
                &forces,
                self.h,
                (&self.q, &self.v),
                (&mut q, &mut v),
            )?;
            check_finite("q", &q)?;
            check_finite("v", &v)?;
            core::mem::swap(&mut self.q, &mut q);
            core::mem::swap(&mut self.v, &mut v);
            self.steps += 1;
            self.time += self.h;
            if self.samples.due(self.steps) {
                self.samples.push(row(self.time, &self.ledger));
            }
        }
        if steps > 0 {
            // After the exchange q and v are those before the last step.
            self.last = Some(Step { q, v, tau: self.tau.clone(), h: self.h });
        }
        let off = self.ledger.imbalance();
        if off.abs() > SHARE * self.energy_at_stake() {
            return Err(LabError::new(format!(
                "{off:.1} J have come from nowhere by {:.2} s: the step is too long for this robot. Take a smaller step and \
                 reset.",
                self.time
            )));
        }
        Ok(())
    }

    /// Rows of four: t, K, V, unaccounted for.
    pub fn samples(&self) -> Vec<f64> {
        self.samples.flat()
    }

    pub(crate) fn sample(&mut self) {
        self.samples.push(row(self.time, &self.ledger));
    }
}

/// A row of the samples.
fn row(time: f64, ledger: &EnergyLedger) -> [f64; 4] {
    [time, ledger.kinetic(), ledger.potential(), ledger.imbalance()]
}
