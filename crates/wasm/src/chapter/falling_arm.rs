//! The Lagrangian lab: a two-link arm, passive or under constant torques, with its energy and its forces.

use dynamics::{Dynamics, EnergyAccount, Integrator, PlanarArm, SystemEnergy, SystemStep};
use nalgebra::{Vector2, vector};
use wasm_bindgen::prelude::wasm_bindgen;

use super::arm_drawing::{tip_mobility, weights};
use super::closed_form::{elbow_and_tip, two_rods};
use super::lab_arm::LabArm;
use crate::LabError;
use crate::input::{integrator, not_negative, positive, vector};
use crate::samples::Samples;

/// Sampling period of the trail \[s\] and the number of samples kept: 30 s.
const INTERVAL: f64 = 0.01;
const KEPT: usize = 3000;

/// The energy of a falling arm \[J\].
#[wasm_bindgen]
#[derive(Clone, Copy, Debug)]
pub struct ArmEnergies {
    /// K.
    #[wasm_bindgen(readonly)]
    pub kinetic: f64,
    /// V.
    #[wasm_bindgen(readonly)]
    pub potential: f64,
    /// E = K + V.
    #[wasm_bindgen(readonly)]
    pub total: f64,
    /// E at the start.
    #[wasm_bindgen(readonly)]
    pub start: f64,
    /// The bound on K, |V| and |E| while E is constant.
    #[wasm_bindgen(readonly)]
    pub most: f64,
}

/// A two-link arm under constant torques, with its integrator and its energy account.
#[wasm_bindgen]
#[derive(Clone, Debug)]
pub struct FallingArm {
    /// Lengths and masses of the rods, gravity.
    rods: [f64; 5],
    system: LabArm,
    q: Vector2<f64>,
    qd: Vector2<f64>,
    /// The motors' torques \[N·m\].
    u: Vector2<f64>,
    integrator: Integrator,
    h: f64,
    steps: u64,
    time: f64,
    energy_account: EnergyAccount,
    samples: Samples<8>,
}

#[wasm_bindgen]
impl FallingArm {
    /// Two uniform rods at rest along the x axis: lengths \[m\], masses \[kg\], gravity \[m/s²\].
    ///
    /// # Errors
    /// Fails if a length or a mass is not positive.
    #[wasm_bindgen(constructor)]
    pub fn new(l1: f64, m1: f64, l2: f64, m2: f64, a_g: f64) -> Result<Self, LabError> {
        let arm = two_rods(l1, m1, l2, m2, a_g)?;
        let system = LabArm { arm, damping: 0.0, has_coriolis: true };
        let (q, qd, h) = (Vector2::zeros(), Vector2::zeros(), 1e-3);
        Ok(Self {
            rods: [l1, m1, l2, m2, a_g],
            system,
            q,
            qd,
            u: Vector2::zeros(),
            integrator: Integrator::RungeKutta4,
            h,
            steps: 0,
            time: 0.0,
            energy_account: EnergyAccount::open(&system as &dyn Dynamics<2>, &q, &qd),
            samples: Samples::new(INTERVAL, h, KEPT),
        })
    }

    /// Puts the arm at (q, q̇), and resets time and the energy account.
    ///
    /// # Errors
    /// Fails if a number is not finite.
    pub fn place(&mut self, q: &[f64], qd: &[f64]) -> Result<(), LabError> {
        (self.q, self.qd) = (vector("q", q)?, vector("qd", qd)?);
        self.energy_account = EnergyAccount::open(&self.system as &dyn Dynamics<2>, &self.q, &self.qd);
        (self.steps, self.time) = (0, 0.0);
        self.samples.clear();
        self.sample();
        Ok(())
    }

    /// Changes rods and gravity in the same state: lengths \[m\], masses \[kg\], gravity \[m/s²\]. Time goes
    /// on, and the energy account is reset.
    ///
    /// # Errors
    /// Fails if a length or a mass is not positive.
    #[wasm_bindgen(js_name = setRods)]
    pub fn set_rods(&mut self, l1: f64, m1: f64, l2: f64, m2: f64, a_g: f64) -> Result<(), LabError> {
        self.system.arm = two_rods(l1, m1, l2, m2, a_g)?;
        self.rods = [l1, m1, l2, m2, a_g];
        self.energy_account = EnergyAccount::open(&self.system as &dyn Dynamics<2>, &self.q, &self.qd);
        Ok(())
    }

    /// Sets the motors' torques \[N·m\]; the energy account includes their work.
    ///
    /// # Errors
    /// Fails if a number is not finite.
    #[wasm_bindgen(js_name = setTorque)]
    pub fn set_torque(&mut self, u1: f64, u2: f64) -> Result<(), LabError> {
        self.u = vector("the torque", &[u1, u2])?;
        Ok(())
    }

    /// Sets the viscous friction of both joints \[N·m·s/rad\]; the energy account includes its losses.
    ///
    /// # Errors
    /// Fails if it is negative or not finite.
    #[wasm_bindgen(js_name = setDamping)]
    pub fn set_damping(&mut self, damping: f64) -> Result<(), LabError> {
        self.system.damping = not_negative("the damping", damping)?;
        Ok(())
    }

    /// The viscous friction of both joints \[N·m·s/rad\].
    #[wasm_bindgen(getter)]
    pub fn damping(&self) -> f64 {
        self.system.damping
    }

    /// A second arm in the same state with the same method, its outer rod heavier by a factor. Time goes on,
    /// and its energy account starts anew.
    ///
    /// # Errors
    /// Fails if the factor is not positive.
    pub fn fork(&self, heavier: f64) -> Result<Self, LabError> {
        let [l1, m1, l2, m2, a_g] = self.rods;
        let mut other = Self::new(l1, m1, l2, m2 * positive("the factor", heavier)?, a_g)?;
        other.system = LabArm { arm: other.system.arm, ..self.system };
        other.u = self.u;
        (other.integrator, other.h) = (self.integrator, self.h);
        other.samples = Samples::new(INTERVAL, self.h, KEPT);
        other.place(self.q.as_slice(), self.qd.as_slice())?;
        other.time = self.time;
        Ok(other)
    }

    /// The distance between this arm's tip and another's \[m\].
    #[wasm_bindgen(js_name = tipDistance)]
    pub fn tip_distance(&self, other: &FallingArm) -> f64 {
        let tip = |arm: &Self| {
            let [.., x, y] = elbow_and_tip(&arm.system.arm, &arm.q);
            [x, y]
        };
        let (a, b) = (tip(self), tip(other));
        (a[0] - b[0]).hypot(a[1] - b[1])
    }

    /// Sets the integrator and the step \[s\]; the energy account goes on.
    ///
    /// # Errors
    /// Fails if the name is unknown or the step not positive.
    #[wasm_bindgen(js_name = setMethod)]
    pub fn set_method(&mut self, name: &str, h: f64) -> Result<(), LabError> {
        (self.integrator, self.h) = (integrator(name)?, positive("the step", h)?);
        self.steps = 0;
        self.samples = Samples::new(INTERVAL, self.h, KEPT);
        Ok(())
    }

    /// Whether C q̇ is part of the motion. Without it the energy is not conserved.
    #[wasm_bindgen(js_name = setCoriolis)]
    pub fn set_coriolis(&mut self, on: bool) {
        self.system.has_coriolis = on;
    }

    /// Advances by whole steps.
    ///
    /// # Errors
    /// Fails if the integrator fails or the energy is not finite; the state before that step is kept.
    pub fn advance(&mut self, steps: u32) -> Result<(), LabError> {
        let u = self.u;
        // With `dyn` the page downloads the integrators once.
        let system = self.system;
        let system: &dyn Dynamics<2> = &system;
        for _ in 0..steps {
            let next = self.integrator.step(system, &self.q, &self.qd, &u, self.h)?;
            let mut energy_account = self.energy_account;
            energy_account.record(system, (&self.q, &self.qd), (&next.0, &next.1), &u, self.h);
            if !energy_account.now().is_finite() {
                return Err(LabError::new(format!(
                    "the energy is not finite at {:.3} s; use a smaller step",
                    self.time
                )));
            }
            ((self.q, self.qd), self.energy_account) = (next, energy_account);
            self.steps += 1;
            self.time += self.h;
            if self.samples.due(self.steps) {
                self.sample();
            }
        }
        Ok(())
    }

    /// Time since the last placement \[s\].
    #[wasm_bindgen(getter)]
    pub fn time(&self) -> f64 {
        self.time
    }

    /// q \[rad\].
    #[wasm_bindgen(getter)]
    pub fn q(&self) -> Vec<f64> {
        self.q.as_slice().to_vec()
    }

    /// q̇ \[rad/s\].
    #[wasm_bindgen(getter)]
    pub fn qd(&self) -> Vec<f64> {
        self.qd.as_slice().to_vec()
    }

    /// Elbow and tip: x, y, x, y \[m\].
    #[wasm_bindgen(getter)]
    pub fn points(&self) -> Vec<f64> {
        elbow_and_tip(&self.system.arm, &self.q).to_vec()
    }

    /// K, V and E \[J\].
    #[wasm_bindgen(getter)]
    pub fn energies(&self) -> ArmEnergies {
        let (kinetic, potential) =
            (self.system.arm.kinetic_energy(&self.q, &self.qd), self.system.arm.potential_energy(&self.q));
        // V has its minimum where the stretched arm hangs; the rest of E can become K.
        let hanging = vector![-core::f64::consts::FRAC_PI_2, 0.0];
        let (least, start) = (self.system.arm.potential_energy(&hanging), self.energy_account.start());
        let most = (start - least).max(start.abs()).max(least.abs());
        ArmEnergies { kinetic, potential, total: kinetic + potential, start, most }
    }

    /// The work of the motors since the last reset of the energy account \[J\].
    #[wasm_bindgen(getter)]
    pub fn work(&self) -> f64 {
        self.energy_account.work()
    }

    /// The energy lost to joint friction since the last reset of the energy account \[J\].
    #[wasm_bindgen(getter)]
    pub fn dissipated(&self) -> f64 {
        self.energy_account.dissipated()
    }

    /// (E − E₀ − work + dissipated)/|E₀|, signed.
    #[wasm_bindgen(getter, js_name = relativeError)]
    pub fn relative_error(&self) -> f64 {
        self.relative(self.energy_account.imbalance())
    }

    /// The largest |E − E₀ − work + dissipated|/|E₀| so far.
    #[wasm_bindgen(getter)]
    pub fn drift(&self) -> f64 {
        self.relative(self.energy_account.max_imbalance())
    }

    /// Every link's centre of mass and weight: x, y \[m\], m a_g \[N\], …
    #[wasm_bindgen(getter)]
    pub fn weights(&self) -> Vec<f64> {
        weights(&PlanarArm::from(self.system.arm), &self.q)
    }

    /// J M⁻¹ Jᵀ of the tip: the greater eigenvalue, the smaller \[1/kg\], the direction of the greater, x and
    /// y.
    ///
    /// # Errors
    /// Fails if M is singular.
    #[wasm_bindgen(js_name = tipMobility)]
    pub fn tip_mobility(&self) -> Result<Vec<f64>, LabError> {
        Ok(tip_mobility(&PlanarArm::from(self.system.arm), &self.q)?)
    }

    /// M q̈, C q̇, g and b, two joints each, which add up to the torque \[N·m\].
    ///
    /// Without C q̇ in the motion, M q̈ belongs to that motion, and the sum is off by C q̇.
    ///
    /// # Errors
    /// Fails if the acceleration is undefined.
    #[wasm_bindgen(js_name = torqueStack)]
    pub fn torque_stack(&self) -> Result<Vec<f64>, LabError> {
        let LabArm { arm, .. } = &self.system;
        let inertial = arm.mass(&self.q) * self.system.try_forward(&self.q, &self.qd, &self.u)?;
        let product = arm.velocity_product(&self.q, &self.qd);
        let gravity = arm.gravity(&self.q);
        let friction = self.system.dissipation(&self.q, &self.qd);
        Ok([inertial, product, gravity, friction].iter().flat_map(|term| [term[0], term[1]]).collect())
    }

    /// M(q), in row-major order \[kg·m²\].
    pub fn mass(&self) -> Vec<f64> {
        self.system.arm.mass(&self.q).as_slice().to_vec()
    }

    /// Elbow and tip in another pose: x, y, x, y \[m\].
    ///
    /// # Errors
    /// Fails if an angle is not finite.
    #[wasm_bindgen(js_name = pointsAt)]
    pub fn points_at(&self, q1: f64, q2: f64) -> Result<Vec<f64>, LabError> {
        Ok(elbow_and_tip(&self.system.arm, &vector("q", &[q1, q2])?).to_vec())
    }

    /// Rows of eight: t, x and y of the tip, K, V, (E − E₀)/|E₀|, q₁, q₂.
    pub fn samples(&self) -> Vec<f64> {
        self.samples.flat()
    }

    fn sample(&mut self) {
        let [.., x, y] = elbow_and_tip(&self.system.arm, &self.q);
        let energies =
            [self.system.arm.kinetic_energy(&self.q, &self.qd), self.system.arm.potential_energy(&self.q)];
        let row = [self.time, x, y, energies[0], energies[1], self.relative_error(), self.q[0], self.q[1]];
        self.samples.push(row);
    }
}

impl FallingArm {
    /// A fraction of |E₀|, or zero if E₀ is zero.
    fn relative(&self, energy: f64) -> f64 {
        if energy == 0.0 { 0.0 } else { energy / self.energy_account.scale() }
    }

    /// The arm and the pose of the worked example.
    ///
    /// # Errors
    /// None for these parameters.
    pub fn worked_example() -> Result<Self, LabError> {
        let mut lab = Self::new(1.0, 2.0, 1.0, 1.0, 9.81)?;
        let quarter = core::f64::consts::FRAC_PI_4;
        lab.place(vector![quarter, 2.0 * quarter].as_slice(), &[0.0, 0.0])?;
        Ok(lab)
    }
}
