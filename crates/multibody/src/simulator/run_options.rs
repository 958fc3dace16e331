//! How a run is made beside its length.

use std::ops::ControlFlow;

use crate::motion::simulate::Observer;
use crate::{Controller, Event, Moment};

/// How a run is made beside its length.
#[derive(Default)]
#[non_exhaustive]
pub struct RunOptions<'r, 'e> {
    /// Gives the torques at the start of each step; without it those of [`Simulation::set_torques`](super::Simulation::set_torques) are held.
    pub controller: Option<&'r mut dyn Controller>,
    /// What is watched for.
    pub events: Option<&'r mut [Event<'e>]>,
    /// Sees the state at the start of each step and at the end, and may break off.
    pub observer: Option<Observer<'r>>,
    /// A sample is kept every so many steps; the first and the last state always, only they if this is 0.
    pub sample_every: usize,
}

impl<'r, 'e> RunOptions<'r, 'e> {
    /// Every state is kept; nobody controls, watches or observes.
    pub fn new() -> Self {
        Self { sample_every: 1, ..Self::default() }
    }

    /// With torques from this controller.
    #[must_use]
    pub fn controller(self, controller: &'r mut dyn Controller) -> Self {
        Self { controller: Some(controller), ..self }
    }

    /// With these events.
    #[must_use]
    pub fn events(self, events: &'r mut [Event<'e>]) -> Self {
        Self { events: Some(events), ..self }
    }

    /// With this observer.
    #[must_use]
    pub fn observer(self, observer: &'r mut dyn FnMut(&Moment<'_>) -> ControlFlow<()>) -> Self {
        Self { observer: Some(observer), ..self }
    }

    /// With a sample every so many steps.
    #[must_use]
    pub fn sample_every(self, steps: usize) -> Self {
        Self { sample_every: steps, ..self }
    }
}
