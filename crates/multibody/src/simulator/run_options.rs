//! How a run is made beside its length.

use std::ops::ControlFlow;

use crate::motion::simulate::Observer;
use crate::{Controller, Event, StepInfo};

/// How a run is made beside its length.
#[derive(Default)]
#[non_exhaustive]
pub struct RunOptions<'r, 'e> {
    /// Gives the torques at the start of each step; without it those of [`Simulation::set_torques`](super::Simulation::set_torques) are held.
    pub controller: Option<&'r mut dyn Controller>,
    /// The events to look for.
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

    /// With these events, looked for all along: [`Run::events`](crate::Run::events).
    ///
    /// Inside a step the state is q(t) = q₀ ⊕ Θ(t), Θ the cubic with the step's displacement and end velocities, off by
    /// |Θ⁗| h⁴/384 at most. v follows from Θ̇, off by O(h³); in rows of first and second order it is the line between
    /// the end velocities, off by O(h²). So crossings of a function of q are found to the row's order up to 4, of v up
    /// to 3; adaptive steps have a polynomial of their own order.
    ///
    /// A terminal event ends the run by a step of the same method from the last step's start, cut so short that it ends
    /// there, its length improved by one step of Newton's method: that end is as accurate as any step's. It is the last
    /// sample, and the controller and the observer are asked there too.
    ///
    /// ```
    /// use multibody::{Base, Event, LinkDescription, Model, RobotDescription, neutral};
    /// use multibody::simulator::{RunOptions, SimulationBuilder};
    /// // A brick thrown up at 3 m/s from 1 m: when is it at the top, and when on the floor?
    /// let mut robot = RobotDescription::new("brick");
    /// robot.base = Base::Floating;
    /// let brick = dynamics::MassProperties::solid_box(1000.0, nalgebra::Vector3::new(0.3, 0.2, 0.1))?;
    /// robot.links.push(LinkDescription::new("brick", brick));
    /// let model = Model::new(robot)?;
    /// let mut q = neutral(&model);
    /// q[2] = 1.0;
    /// let mut events = [
    ///     Event::new("top", |_, _: &[f64], v: &[f64]| v[2]).falling(),
    ///     Event::touchdown("floor", &model, model.frame("brick").expect("a link"), 0.0).terminal(),
    /// ];
    /// let v = [0.0, 0.0, 3.0, 0.0, 0.0, 0.0];
    /// let mut simulation = SimulationBuilder::new(&model).step(0.01).build()?;
    /// let run = simulation.run_from(&q, &v, 1000, RunOptions::new().events(&mut events))?;
    /// assert!((run.events[0].time - 3.0 / 9.81).abs() < 1e-12);
    /// assert!(run.ended_by_event && run.q[2].abs() < 1e-12);
    /// assert!((run.time - (3.0 + (9.0f64 + 2.0 * 9.81).sqrt()) / 9.81).abs() < 1e-12);
    /// # Ok::<(), Box<dyn std::error::Error>>(())
    /// ```
    #[must_use]
    pub fn events(self, events: &'r mut [Event<'e>]) -> Self {
        Self { events: Some(events), ..self }
    }

    /// With this observer.
    #[must_use]
    pub fn observer(self, observer: &'r mut dyn FnMut(&StepInfo<'_>) -> ControlFlow<()>) -> Self {
        Self { observer: Some(observer), ..self }
    }

    /// With a sample every so many steps.
    #[must_use]
    pub fn sample_every(self, steps: usize) -> Self {
        Self { sample_every: steps, ..self }
    }
}
