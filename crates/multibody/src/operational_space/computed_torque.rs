//! Computed torque: the motion's own inverse dynamics, and feedback through M.

use crate::place::check_length;
use crate::{Controller, Model, Workspace, difference, dissipation, inverse_dynamics};

/// Where a motion should be at a time.
#[derive(Clone, Debug, PartialEq)]
pub struct Reference {
    /// q\*, nq.
    pub q: Vec<f64>,
    /// v\*, nv \[rad/s or m/s\].
    pub v: Vec<f64>,
    /// a\*, nv.
    pub a: Vec<f64>,
}

/// τ = M(q)(a\* + Kp (q\* ⊖ q) + Kd (v\* − v)) + C v + g + b with diagonal gains. **(MLS §4.5; MR §11.4)**
///
/// The error of plain coordinates then obeys ë + Kd ė + Kp e = 0, whatever the robot. The joints' damping and
/// friction are compensated when asked for.
#[derive(Clone, Debug)]
pub struct ComputedTorque<'a, F> {
    model: &'a Model,
    workspace: Workspace,
    reference: F,
    stiffness: Vec<f64>,
    damping: Vec<f64>,
    with_dissipation: bool,
    error: Vec<f64>,
    acceleration: Vec<f64>,
}

impl<'a, F: FnMut(f64) -> Reference> ComputedTorque<'a, F> {
    /// Follows `reference(t)`; Kp \[1/s²\] and Kd \[1/s\] have nv entries, Kd = 2 √Kp is critically damped.
    ///
    /// # Panics
    /// If a gain vector has the wrong length.
    pub fn new(model: &'a Model, reference: F, stiffness: &[f64], damping: &[f64]) -> Self {
        let nv = model.nv();
        check_length("the stiffness", stiffness.len(), nv);
        check_length("the damping", damping.len(), nv);
        Self {
            model,
            workspace: Workspace::new(model),
            reference,
            stiffness: stiffness.to_vec(),
            damping: damping.to_vec(),
            with_dissipation: false,
            error: vec![0.0; nv],
            acceleration: vec![0.0; nv],
        }
    }

    /// With the joints' damping and friction compensated.
    #[must_use]
    pub fn with_dissipation(mut self) -> Self {
        self.with_dissipation = true;
        self
    }
}

impl<F: FnMut(f64) -> Reference> Controller for ComputedTorque<'_, F> {
    fn torque(&mut self, t: f64, q: &[f64], v: &[f64], tau: &mut [f64]) {
        let Reference { q: q_wanted, v: v_wanted, a } = (self.reference)(t);
        let nv = self.model.nv();
        check_length("the reference v", v_wanted.len(), nv);
        check_length("the reference a", a.len(), nv);
        difference(self.model, q, &q_wanted, &mut self.error);
        for k in 0..nv {
            self.acceleration[k] =
                a[k] + self.stiffness[k] * self.error[k] + self.damping[k] * (v_wanted[k] - v[k]);
        }
        inverse_dynamics(self.model, &mut self.workspace, q, v, &self.acceleration, tau);
        if self.with_dissipation {
            dissipation(self.model, v, &mut self.error);
            tau.iter_mut().zip(&self.error).for_each(|(tau, b)| *tau += b);
        }
    }
}
