//! The motion as one first-order equation: ẏ = (N(q) v, a, τ·v, b·v).

use std::cell::RefCell;

use differential_equations::prelude::ODE;

use super::super::{Controller, ControllerError};
use super::error::AdaptiveError;
use crate::space::configuration_rate::configuration_rate;
use crate::{Model, Workspace, dissipation, forward_dynamics, normalize_quaternions};

/// y = (q, v, W, D): configuration, velocity, work of τ, and what damping took out, these two in units of [`energy`](Self::energy).
///
/// Quaternions in y are four numbers whose length the equation keeps and the steps keep to their tolerance; every
/// force is computed at the unit quaternion, so the length acts back on nothing.
pub(super) struct Motion<'a, 'c> {
    pub model: &'a Model,
    pub dissipation: bool,
    /// The unit of the books \[J\]: an implicit step is solved for to one absolute error in all of y.
    pub energy: f64,
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
    /// What first went wrong in the last evaluations.
    trouble: Option<Trouble>,
}

/// Why there is no rate at a state.
#[derive(Clone, Debug)]
pub(super) enum Trouble {
    /// Entry so of this quantity is not finite.
    NotFinite(&'static str, usize),
    /// The controller failed.
    Controller(ControllerError),
}

impl Trouble {
    /// The first entry that is not finite.
    pub(super) fn of(quantity: &'static str, x: &[f64]) -> Option<Self> {
        x.iter().position(|x| !x.is_finite()).map(|index| Self::NotFinite(quantity, index))
    }

    /// As an error at a time.
    pub(super) fn at(self, model: &Model, time: f64) -> AdaptiveError {
        match self {
            Self::NotFinite(quantity, index) => {
                let coordinate = model.coordinate_names().get(index).cloned().unwrap_or_default();
                AdaptiveError::NotFinite { quantity, coordinate, time }
            }
            Self::Controller(source) => AdaptiveError::Controller { time, source },
        }
    }
}

impl<'a, 'c> Motion<'a, 'c> {
    pub(super) fn new(model: &'a Model, dissipation: bool, energy: f64) -> Self {
        let nothing = vec![0.0; model.nv()];
        Self {
            model,
            dissipation,
            energy,
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
    pub(super) fn torque(&self, t: f64, q: &[f64], v: &[f64], tau: &mut [f64]) -> Result<(), Trouble> {
        let mut scratch = self.scratch.borrow_mut();
        match &mut scratch.controller {
            Some(controller) => controller.torque(t, q, v, tau).map_err(Trouble::Controller)?,
            None => tau.copy_from_slice(&scratch.tau),
        }
        Trouble::of(TORQUE, tau).map_or(Ok(()), Err)
    }

    pub(super) fn evaluations(&self) -> usize {
        self.scratch.borrow().evaluations
    }

    /// What first went wrong since this was asked last.
    pub(super) fn take_trouble(&self) -> Option<Trouble> {
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

/// What a torque is called in errors.
pub(super) const TORQUE: &str = "the controller's torque";

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
        if let Some(controller) = controller
            && let Err(error) = controller.torque(t, q, v, tau)
        {
            // No rate: the step is taken back.
            trouble.get_or_insert(Trouble::Controller(error));
            rate.fill(f64::NAN);
            return;
        }
        let dot = |a: &[f64], b: &[f64]| a.iter().zip(b).map(|(a, b)| a * b).sum::<f64>();
        let (q_rate, rest) = rate.split_at_mut(nq);
        let (acceleration, books) = rest.split_at_mut(nv);
        books.copy_from_slice(&[dot(tau, v) / self.energy, 0.0]);
        if self.dissipation {
            dissipation(model, v, lost);
            books[1] = dot(lost, v) / self.energy;
            force.iter_mut().zip(&*tau).zip(&*lost).for_each(|((f, tau), b)| *f = tau - b);
        } else {
            force.copy_from_slice(tau);
        }
        // The raw quaternion: then its length stays exactly what it is.
        configuration_rate(model, &y[..nq], v, q_rate);
        forward_dynamics(model, workspace, q, v, force, acceleration);
        if trouble.is_none() {
            *trouble = Trouble::of(TORQUE, tau).or_else(|| Trouble::of("the acceleration", acceleration));
        }
    }
}
