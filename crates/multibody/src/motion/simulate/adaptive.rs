//! Runs with adaptive steps of high order: dense output, events, and a tolerance in place of a step.

mod course;
mod error;
mod local_error;
mod method;
mod motion;
mod stepper;

pub use error::{AdaptiveError, AdaptiveFailure};
pub use method::AdaptiveMethod;

use std::ops::ControlFlow;
use std::sync::atomic::AtomicBool;

use dynamics::EnergyLedger;

use self::course::Course;
use super::Run;
use super::ledger::open_start;
use super::{Controller, Event, EventOccurrence, Moment, Trajectory};
use crate::model::length::check_length;
use crate::{Model, Workspace, check_configuration};

/// The least and the most tolerance: below, a step's error is its rounding; above, it is none.
const TOLERANCES: (f64, f64) = (1e-13, 1e-2);

/// How an adaptive run is made: Runge–Kutta steps with error control, for accurate motions over short and middle times; explicit ones
/// of order 9, or implicit ones of order 5 where damping is stiff ([`AdaptiveMethod`]).
///
/// The state (q, v) together with the work and the dissipation is integrated as one equation; the local error of
/// each entry x is kept below tolerance·(1 + |x|) \[rad, m, s, J\]. Nothing of the motion's structure is kept: for
/// long runs take a variational row of [`Simulation`](super::Simulation). A joint with Coulomb friction is refused
/// where the dissipation acts.
#[derive(Clone, Copy, Debug)]
pub struct AdaptiveSimulation<'a> {
    /// The robot.
    pub model: &'a Model,
    /// The local error allowed, relative and absolute, from 1e-13 to 1e-2.
    pub tolerance: f64,
    /// What takes the steps.
    pub method: AdaptiveMethod,
    /// Whether the joints' damping acts.
    pub dissipation: bool,
    /// When the controller is asked.
    pub control: ControlTiming,
    /// Steps from one sample or control instant to the next after which the run is given up, rejected ones counted.
    pub max_steps: usize,
    /// Looked at before every step: once it is true the run ends where it is, also between samples.
    pub interrupt: Option<&'a AtomicBool>,
    /// Whether all samples are kept; the first and the last always are, and the observer sees each.
    pub keep_samples: bool,
}

/// When a controller is asked for its torque.
#[derive(Clone, Copy, Debug, Default, PartialEq)]
pub enum ControlTiming {
    /// At every evaluation of the motion: τ(t, q, v) as a continuous law. Steps are tried and taken back, so the
    /// torque must depend on (t, q, v) alone, and smoothly.
    #[default]
    Continuous,
    /// At the start and every so many seconds after it, and held in between, as a digital controller; no step goes
    /// across such an instant.
    Held {
        /// The control period \[s\].
        period: f64,
    },
}

/// What the steps of a run were.
#[derive(Clone, Copy, Debug, Default, PartialEq)]
#[non_exhaustive]
pub struct StepStatistics {
    /// Steps taken.
    pub accepted: usize,
    /// Steps tried and taken back as their error was too large.
    pub rejected: usize,
    /// Evaluations of the motion: of explicit steps 26 each, its polynomial counted, and 15 for a rejected one; of implicit ones those of
    /// Newton's method and of Jacobians by differences.
    pub evaluations: usize,
    /// The shortest step taken \[s\]; 0 before the first.
    pub shortest: f64,
    /// The longest \[s\].
    pub longest: f64,
}

/// How a run came to its end.
#[derive(Clone, Debug, PartialEq, Eq)]
pub enum AdaptiveEnd {
    /// At the last sample time.
    Finished,
    /// At a terminal event, the last of [`AdaptiveRun::events`].
    Event,
    /// The observer broke it off, or [`AdaptiveSimulation::interrupt`] was set.
    Interrupted,
}

/// What an adaptive run did.
#[derive(Clone, Debug)]
#[non_exhaustive]
pub struct AdaptiveRun {
    /// The samples at the times asked for, and the end.
    pub trajectory: Trajectory,
    /// The books, at the samples: work and dissipation are integrated with the motion.
    pub ledger: EnergyLedger,
    /// The events in the order of time.
    pub events: Vec<EventOccurrence>,
    /// What took the steps, explicit or implicit.
    pub method: AdaptiveMethod,
    /// What the steps were.
    pub statistics: StepStatistics,
    /// max | |quaternion| − 1 | at the ends of the steps, before q was normalised: a measure of the error.
    pub quaternion_error: f64,
    /// The largest |τ| of each coordinate at samples and control instants \[N·m or N\].
    pub peak_torque: Vec<f64>,
    /// How it ended.
    pub end: AdaptiveEnd,
    /// When it ended \[s\].
    pub time: f64,
    /// q at the end.
    pub q: Vec<f64>,
    /// v at the end.
    pub v: Vec<f64>,
}

/// What a run by fixed steps tells, too.
impl From<AdaptiveRun> for Run {
    fn from(run: AdaptiveRun) -> Self {
        Self {
            trajectory: run.trajectory,
            ledger: run.ledger,
            peak_torque: run.peak_torque,
            events: run.events,
            steps: run.statistics.accepted,
            time: run.time,
            interrupted: run.end == AdaptiveEnd::Interrupted,
            losses: None,
            ended_by_event: run.end == AdaptiveEnd::Event,
            contact_laws: None,
            contact_forces: Vec::new(),
            q: run.q,
            v: run.v,
        }
    }
}

impl AdaptiveSimulation<'_> {
    /// Runs from (q0, v0) at the first of `times` to the last \[s\], and samples at each by the steps' own
    /// polynomials; the observer is called at each sample and may break off. Between samples the steps are as long
    /// as the tolerance allows.
    ///
    /// `events` are looked for all along. Each is located to rounding on the step's polynomial: the time is as
    /// accurate as the motion.
    ///
    /// # Errors
    /// [`AdaptiveFailure`] with all that was computed: a bad start, times, tolerance or control period; a controller
    /// or an event's function that fails; numbers that are not finite; friction; a singular M at a step's end; no step
    /// small enough; too many steps, with the coordinate that asks for them. A run that ends so, or by
    /// [`interrupt`](Self::interrupt), has the end of its last step as its last sample.
    ///
    /// # Panics
    /// If v0 has the wrong length.
    ///
    /// ```
    /// use multibody::{AdaptiveSimulation, Base, ControlTiming, Event, LinkDescription, Model};
    /// use multibody::{RobotDescription, ZeroTorque, neutral};
    /// use nalgebra::Vector3;
    /// use std::ops::ControlFlow;
    /// // A brick thrown up at 3 m/s from 1 m: when is it at the top, and when on the floor?
    /// let mut robot = RobotDescription::new("brick");
    /// robot.base = Base::Floating;
    /// let brick = dynamics::MassProperties::solid_box(1000.0, Vector3::new(0.3, 0.2, 0.1))?;
    /// robot.links.push(LinkDescription::new("brick", brick));
    /// let model = Model::new(robot)?;
    /// let mut q = neutral(&model);
    /// q[2] = 1.0;
    /// let mut events = [
    ///     Event::new("top", |_, _: &[f64], v: &[f64]| v[2]).falling(),
    ///     Event::touchdown("floor", &model, model.frame("brick").expect("a link"), 0.0).terminal(),
    /// ];
    /// let run = AdaptiveSimulation { tolerance: 1e-12, ..AdaptiveSimulation::of(&model) }.run(
    ///     &q,
    ///     &[0.0, 0.0, 3.0, 0.0, 0.0, 0.0],
    ///     (0..=100).map(|k| f64::from(k) * 0.1),
    ///     &mut ZeroTorque,
    ///     &mut events,
    ///     |_| ControlFlow::Continue(()),
    /// )?;
    /// assert!((run.events[0].time - 3.0 / 9.81).abs() < 1e-12);
    /// assert!((run.time - (3.0 + (9.0f64 + 2.0 * 9.81).sqrt()) / 9.81).abs() < 1e-12);
    /// # Ok::<(), Box<dyn std::error::Error>>(())
    /// ```
    #[track_caller]
    pub fn run(
        &self,
        q0: &[f64],
        v0: &[f64],
        times: impl IntoIterator<Item = f64, IntoIter: DoubleEndedIterator>,
        controller: &mut dyn Controller,
        events: &mut [Event<'_>],
        mut observer: impl FnMut(&Moment<'_>) -> ControlFlow<()>,
    ) -> Result<AdaptiveRun, Box<AdaptiveFailure>> {
        let model = self.model;
        check_length("v0", v0.len(), model.nv());
        let mut workspace = Workspace::new(model);
        let checked = self.check(q0, v0);
        let overflow = |fastest: usize, _| {
            let coordinate = model.coordinate_names()[fastest].clone();
            AdaptiveError::NotFinite { quantity: "the energy", coordinate, time: 0.0 }
        };
        let (ledger, q, v, checked) = open_start(model, &mut workspace, q0, v0, checked, overflow);
        let mut run = AdaptiveRun {
            trajectory: Trajectory::new(model, 0),
            ledger,
            events: Vec::new(),
            method: self.method,
            statistics: StepStatistics::default(),
            quaternion_error: 0.0,
            peak_torque: vec![0.0; model.nv()],
            end: AdaptiveEnd::Finished,
            time: 0.0,
            q,
            v,
        };
        let mut times = times.into_iter();
        let span = match (times.next(), times.next_back()) {
            (Some(start), Some(end)) => Ok((start, end)),
            _ => Err(AdaptiveError::NoSpan),
        };
        let result = checked.and(span).and_then(|span| {
            run.time = span.0;
            let (run, observer) = (&mut run, &mut observer);
            let mut course = Course { simulation: self, workspace, run, samples: 0, observer };
            course.follow(span, &mut times, controller, events)
        });
        match result {
            Ok(()) => Ok(run),
            Err(error) => Err(Box::new(AdaptiveFailure { error, until: run })),
        }
    }

    fn check(&self, q0: &[f64], v0: &[f64]) -> Result<(), AdaptiveError> {
        let model = self.model;
        let name = |index: usize| model.coordinate_names()[index].clone();
        check_configuration(model, q0).map_err(AdaptiveError::Configuration)?;
        if let Some(index) = v0.iter().position(|v| !v.is_finite()) {
            return Err(AdaptiveError::NotFinite { quantity: "v", coordinate: name(index), time: 0.0 });
        }
        if let ControlTiming::Held { period } = self.control
            && !(period > 0.0 && period.is_finite())
        {
            return Err(AdaptiveError::Period { period });
        }
        let (least, most) = TOLERANCES;
        if !(least..=most).contains(&self.tolerance) {
            return Err(AdaptiveError::Tolerance { tolerance: self.tolerance, least, most });
        }
        match model.dofs.iter().find(|dof| self.dissipation && dof.passive.friction != 0.0) {
            Some(dof) => Err(AdaptiveError::Friction { coordinate: name(dof.coordinate) }),
            None => Ok(()),
        }
    }
}

impl<'a> AdaptiveSimulation<'a> {
    /// Tolerance 1e-9, the method that the robot needs, no dissipation, continuous control, a million steps between samples, nothing that interrupts,
    /// all samples kept.
    pub fn of(model: &'a Model) -> Self {
        Self {
            model,
            tolerance: 1e-9,
            method: AdaptiveMethod::Automatic,
            dissipation: false,
            control: ControlTiming::Continuous,
            max_steps: 1_000_000,
            interrupt: None,
            keep_samples: true,
        }
    }
}
