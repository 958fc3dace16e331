//! The motion as one first-order equation: ẏ = (N(q) v, a, τ·v, b·v).

use std::cell::RefCell;

use differential_equations::prelude::ODE;

use super::super::Controller;
use crate::configuration_rate::configuration_rate;
use crate::{Model, Workspace, dissipation, forward_dynamics, normalize_quaternions};

/// y = (q, v, W, D): configuration, velocity, work of τ, and what damping took out.
///
/// Quaternions in y are four numbers whose length the equation keeps and the steps keep to their tolerance; every
/// force is computed at the unit quaternion, so the length acts back on nothing.
pub(super) struct Motion<'a, 'c> {
    pub model: &'a Model,
    pub dissipation: bool,
    scratch: RefCell<Scratch<'c>>,
}

struct Scratch<'c> {
    workspace: Workspace,
    /// Asked at every evaluation; none while τ is held.
    controller: Option<&'c mut dyn Controller>,
    tau: Vec<f64>,
    q: Vec<f64>,
    lost: Vec<f64>,
    force: Vec<f64>,
    evaluations: usize,
    /// The first number of the last evaluations that was not finite.
    trouble: Option<(&'static str, usize)>,
}

impl<'a, 'c> Motion<'a, 'c> {
    pub(super) fn new(model: &'a Model, dissipation: bool) -> Self {
        let nothing = vec![0.0; model.nv()];
        Self {
            model,
            dissipation,
            scratch: RefCell::new(Scratch {
                workspace: Workspace::new(model),
                controller: None,
                tau: nothing.clone(),
                q: vec![0.0; model.nq()],
                lost: nothing.clone(),
                force: nothing,
                evaluations: 0,
                trouble: None,
            }),
        }
    }

    /// Lets a controller be asked at every evaluation.
    pub(super) fn control(&self, controller: &'c mut dyn Controller) {
        self.scratch.borrow_mut().controller = Some(controller);
    }

    /// Holds τ.
    pub(super) fn hold(&self, tau: &[f64]) {
        self.scratch.borrow_mut().tau.copy_from_slice(tau);
    }

    /// τ at a state: the controller's, or what is held.
    pub(super) fn torque(&self, t: f64, q: &[f64], v: &[f64], tau: &mut [f64]) {
        let mut scratch = self.scratch.borrow_mut();
        match &mut scratch.controller {
            Some(controller) => controller.torque(t, q, v, tau),
            None => tau.copy_from_slice(&scratch.tau),
        }
    }

    pub(super) fn evaluations(&self) -> usize {
        self.scratch.borrow().evaluations
    }

    /// The first number that was not finite since this was asked last.
    pub(super) fn take_trouble(&self) -> Option<(&'static str, usize)> {
        self.scratch.borrow_mut().trouble.take()
    }

    /// (q with unit quaternions, v) of y.
    pub(super) fn split(&self, y: &[f64], q: &mut Vec<f64>, v: &mut Vec<f64>) {
        let (nq, nv) = (self.model.nq(), self.model.nv());
        q.clear();
        q.extend_from_slice(&y[..nq]);
        normalize_quaternions(self.model, q);
        v.clear();
        v.extend_from_slice(&y[nq..nq + nv]);
    }
}

impl ODE<f64, Vec<f64>> for Motion<'_, '_> {
    fn diff(&self, t: f64, y: &Vec<f64>, rate: &mut Vec<f64>) {
        let model = self.model;
        let (nq, nv) = (model.nq(), model.nv());
        let mut scratch = self.scratch.borrow_mut();
        let Scratch { workspace, controller, tau, q, lost, force, evaluations, trouble } = &mut *scratch;
        *evaluations += 1;
        q.copy_from_slice(&y[..nq]);
        normalize_quaternions(model, q);
        let v = &y[nq..nq + nv];
        if let Some(controller) = controller {
            controller.torque(t, q, v, tau);
        }
        let dot = |a: &[f64], b: &[f64]| a.iter().zip(b).map(|(a, b)| a * b).sum::<f64>();
        let (q_rate, rest) = rate.split_at_mut(nq);
        let (acceleration, books) = rest.split_at_mut(nv);
        books.copy_from_slice(&[dot(tau, v), 0.0]);
        if self.dissipation {
            dissipation(model, v, lost);
            books[1] = dot(lost, v);
            force.iter_mut().zip(&*tau).zip(&*lost).for_each(|((f, tau), b)| *f = tau - b);
        } else {
            force.copy_from_slice(tau);
        }
        // The raw quaternion: then its length stays exactly what it is.
        configuration_rate(model, &y[..nq], v, q_rate);
        forward_dynamics(model, workspace, q, v, force, acceleration);
        if trouble.is_none() {
            let seen =
                |quantity, x: &[f64]| x.iter().position(|x| !x.is_finite()).map(|index| (quantity, index));
            *trouble =
                seen("the controller's torque", tau).or_else(|| seen("the acceleration", acceleration));
        }
    }
}
