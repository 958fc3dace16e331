//! The options of a run.

use std::ops::ControlFlow;

use robot_dynamics_number::InvalidInput;

use crate::motion::simulate::{Observer, steps_in};
use crate::{Controller, Event, StepInfo};

/// The options of a run: controller, events, observer and samples.
#[derive(Default)]
#[non_exhaustive]
pub struct RunOptions<'r, 'e> {
    /// Computes the torques at the start of each step. Without a controller, the torques of
    /// [`Simulation::set_torques`](super::Simulation::set_torques) are held.
    pub controller: Option<&'r mut dyn Controller>,
    /// The events to locate.
    pub events: Option<&'r mut [Event<'e>]>,
    /// Receives the state at the start of each step and at the end of the run, and can stop the run.
    pub observer: Option<Observer<'r>>,
    /// The interval between samples. The first and the last state are always kept.
    pub samples: SampleInterval,
}

/// The interval between the samples of a run.
#[derive(Clone, Copy, Debug, PartialEq)]
pub enum SampleInterval {
    /// Only the first and the last state are kept.
    Ends,
    /// A number of steps; 0 is as [`Ends`](Self::Ends).
    Steps(usize),
    /// A time \[s\], rounded to the nearest whole number of steps, at least one.
    Seconds(f64),
}

impl Default for SampleInterval {
    /// Each step is a sample.
    fn default() -> Self {
        Self::Steps(1)
    }
}

impl SampleInterval {
    /// The number of steps between samples, for steps of this length \[s\]; 0 for none between the ends.
    ///
    /// # Errors
    /// [`InvalidInput`] if a time is negative or not finite.
    ///
    /// ```
    /// use robot_dynamics::simulation::SampleInterval;
    /// assert_eq!(SampleInterval::Seconds(0.0302).steps(0.01)?, 3);
    /// # Ok::<(), robot_dynamics::InvalidInput>(())
    /// ```
    pub fn steps(self, step: f64) -> Result<usize, InvalidInput> {
        match self {
            Self::Ends => Ok(0),
            Self::Steps(steps) => Ok(steps),
            Self::Seconds(interval) => {
                Ok(steps_in(interval, step).map_err(|error| error.of("the interval between samples"))?.max(1))
            }
        }
    }
}

impl<'r, 'e> RunOptions<'r, 'e> {
    /// Keeps every state, without a controller, events or an observer.
    pub fn new() -> Self {
        Self::default()
    }

    /// Sets the controller.
    #[must_use]
    pub fn controller(self, controller: &'r mut dyn Controller) -> Self {
        Self { controller: Some(controller), ..self }
    }

    /// Sets the events to locate during the whole run; see [`Run::events`](crate::Run::events).
    ///
    /// Inside a step the state is interpolated as q(t) = q₀ ⊕ Θ(t), where the cubic Θ has the step's
    /// displacement and end velocities. Its error is at most |Θ⁗| h⁴/384. The velocity follows from Θ̇ with
    /// the error O(h³). For rows of first and second order, v is linear between the end velocities, with the
    /// error O(h²). The times of crossings therefore have the row's order, up to 4 for functions of q and up
    /// to 3 for functions of v. Adaptive steps use a polynomial of their own order.
    ///
    /// A terminal event ends the run. A shorter step of the same method, from the start of the last step,
    /// ends at the event. One step of Newton's method refines its length. The end state is therefore as
    /// accurate as that of any step. It is the last sample, and the controller and the observer are called
    /// there too.
    ///
    /// ```
    /// use robot_dynamics::description::{Base, LinkDescription, RobotDescription};
    /// use robot_dynamics::model::{Model, neutral};
    /// use robot_dynamics::simulation::{Event, RunOptions, SimulationBuilder};
    /// // Throw a brick up at 3 m/s from 1 m: when is it at the top, and when on the floor?
    /// let mut robot = RobotDescription::new("brick");
    /// robot.base = Base::Floating;
    /// let brick = robot_dynamics::description::MassProperties::solid_box(1000.0, nalgebra::Vector3::new(0.3, 0.2, 0.1))?;
    /// robot.links.push(LinkDescription::new("brick", brick));
    /// let model = Model::new(robot)?;
    /// let mut q = neutral(&model);
    /// q[2] = 1.0;
    /// let mut events = [
    ///     Event::new("top", |_, _: &[f64], v: &[f64]| v[2]).falling(),
    ///     Event::touchdown("floor", &model, model.frame("brick").expect("a link"), 0.0).terminal(),
    /// ];
    /// let v = [0.0, 0.0, 3.0, 0.0, 0.0, 0.0];
    /// let mut simulation = SimulationBuilder::new(&model).dt(0.01).build()?;
    /// let run = simulation.run_from(&q, &v, 10.0, RunOptions::new().events(&mut events))?;
    /// assert!((run.events[0].time - 3.0 / 9.81).abs() < 1e-12);
    /// assert!(run.ended_by_event && run.q[2].abs() < 1e-12);
    /// assert!((run.time - (3.0 + (9.0f64 + 2.0 * 9.81).sqrt()) / 9.81).abs() < 1e-12);
    /// # Ok::<(), Box<dyn std::error::Error>>(())
    /// ```
    #[must_use]
    pub fn events(self, events: &'r mut [Event<'e>]) -> Self {
        Self { events: Some(events), ..self }
    }

    /// Sets the observer.
    #[must_use]
    pub fn observer(self, observer: &'r mut dyn FnMut(&StepInfo<'_>) -> ControlFlow<()>) -> Self {
        Self { observer: Some(observer), ..self }
    }

    /// Sets the time between samples \[s\], rounded to the nearest whole number of steps, at least one.
    #[must_use]
    pub fn sample_period(self, seconds: f64) -> Self {
        Self { samples: SampleInterval::Seconds(seconds), ..self }
    }

    /// Sets the number of steps between samples. With 0 only the first and the last state are kept.
    #[must_use]
    pub fn sample_every(self, steps: usize) -> Self {
        Self { samples: SampleInterval::Steps(steps), ..self }
    }

    /// Keeps only the first and the last state.
    #[must_use]
    pub fn sample_ends(self) -> Self {
        Self { samples: SampleInterval::Ends, ..self }
    }
}
