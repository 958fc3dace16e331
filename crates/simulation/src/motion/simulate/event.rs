//! Events along a motion and the times of their occurrence.

use robot_dynamics_core::{FrameId, Model, Workspace, frame_pose};

use super::root::find_root;
use crate::{CallbackError, IntoCallbackResult};

/// An event at a change of sign of a function g(t, q, v).
///
/// ```
/// use robot_dynamics::simulation::Event;
/// // The first joint passes 1 rad on its way up, and the run ends there.
/// let event = Event::new("raised", |_t, q: &[f64], _v: &[f64]| q[0] - 1.0).rising().terminal();
/// assert_eq!(event.name(), "raised");
/// ```
pub struct Event<'a> {
    name: String,
    function: Box<Function<'a>>,
    counts: Crossing,
    is_terminal: bool,
}

/// g(t, q, v).
type Function<'a> = dyn FnMut(f64, &[f64], &[f64]) -> Result<f64, CallbackError> + 'a;

/// The direction of the crossing.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
enum Crossing {
    Both,
    Rising,
    Falling,
}

/// An occurrence of an event.
#[derive(Clone, Debug, PartialEq)]
#[non_exhaustive]
pub struct EventOccurrence {
    /// The index of the event in the run's list.
    pub event: usize,
    /// The name of the event.
    pub name: String,
    /// The time \[s\].
    pub time: f64,
    /// Whether g increased.
    pub rising: bool,
    /// The configuration at that time.
    pub q: Vec<f64>,
    /// The velocity at that time.
    pub v: Vec<f64>,
}

impl<'a> Event<'a> {
    /// An event at g = 0, crossed in either direction; the run continues. g must be continuous in (t, q, v)
    /// and finite. If it can fail, it returns a `Result` with any error, which ends the run.
    ///
    /// Each step evaluates g eight times. Two crossings that are closer together than that can be missed.
    pub fn new<R: IntoCallbackResult<f64>>(
        name: impl Into<String>,
        mut function: impl FnMut(f64, &[f64], &[f64]) -> R + 'a,
    ) -> Self {
        let function = Box::new(move |t: f64, q: &[f64], v: &[f64]| function(t, q, v).outcome());
        Self { name: name.into(), function, counts: Crossing::Both, is_terminal: false }
    }

    /// Restricts the event to crossings from negative to positive.
    #[must_use]
    pub fn rising(mut self) -> Self {
        self.counts = Crossing::Rising;
        self
    }

    /// Restricts the event to crossings from positive to negative.
    #[must_use]
    pub fn falling(mut self) -> Self {
        self.counts = Crossing::Falling;
        self
    }

    /// Ends the run at the event.
    #[must_use]
    pub fn terminal(mut self) -> Self {
        self.is_terminal = true;
        self
    }

    /// The name of the event.
    pub fn name(&self) -> &str {
        &self.name
    }

    /// An event for each position limit of the model's joints with one coordinate, crossed outward: `JOINT at
    /// its upper limit`, `… lower …`.
    pub fn joint_limits(model: &Model) -> Vec<Event<'static>> {
        let mut events = Vec::new();
        for joint in model.joints().iter().filter(|joint| joint.nq == joint.nv) {
            for i in joint.q() {
                let (lower, upper) = (joint.limits.lower, joint.limits.upper);
                if upper.is_finite() {
                    let name = format!("`{}` at its upper limit", joint.name);
                    events.push(Event::new(name, move |_, q: &[f64], _: &[f64]| q[i] - upper).rising());
                }
                if lower.is_finite() {
                    let name = format!("`{}` at its lower limit", joint.name);
                    events.push(Event::new(name, move |_, q: &[f64], _: &[f64]| q[i] - lower).falling());
                }
            }
        }
        events
    }

    /// The origin of a frame descends to the height z in the world \[m\], as at the start of a contact.
    ///
    /// # Panics
    /// A run panics if the frame belongs to another model.
    #[track_caller]
    pub fn touchdown(name: impl Into<String>, model: &'a Model, frame: FrameId, height: f64) -> Self {
        let mut workspace = Workspace::new(model);
        let above = move |_: f64, q: &[f64], _: &[f64]| {
            frame_pose(model, &mut workspace, q, frame).translation[2] - height
        };
        Event::new(name, above).falling()
    }

    /// g, or the cause of a missing value.
    fn value(&mut self, time: f64, q: &[f64], v: &[f64]) -> Result<f64, NoValue> {
        let cause = match (self.function)(time, q, v) {
            Ok(value) if value.is_finite() => return Ok(value),
            Ok(value) => Cause::NotFinite(value),
            Err(source) => Cause::Failed(source),
        };
        Err(NoValue { name: self.name.clone(), time, cause })
    }

    fn counts(&self, rising: bool) -> bool {
        match self.counts {
            Crossing::Both => true,
            Crossing::Rising => rising,
            Crossing::Falling => !rising,
        }
    }
}

impl std::fmt::Debug for Event<'_> {
    fn fmt(&self, f: &mut std::fmt::Formatter<'_>) -> std::fmt::Result {
        f.debug_struct("Event")
            .field("name", &self.name)
            .field("counts", &self.counts)
            .field("is_terminal", &self.is_terminal)
            .finish_non_exhaustive()
    }
}

/// The failure of an event's function; each kind of run converts it to its own error.
pub struct NoValue {
    pub name: String,
    pub time: f64,
    pub cause: Cause,
}

/// The cause; see [`NoValue`].
pub enum Cause {
    NotFinite(f64),
    Failed(CallbackError),
}

/// The number of evaluations of g in each step.
const EVALUATIONS: usize = 8;

/// Writes the state (q, v) at a time inside the step.
pub(super) type StateAt<'s> = dyn FnMut(f64, &mut Vec<f64>, &mut Vec<f64>) + 's;

/// The events of a run and the last value of each g.
pub struct EventDetector<'e, 'a> {
    events: &'e mut [Event<'a>],
    last: Vec<f64>,
    q: Vec<f64>,
    v: Vec<f64>,
}

/// A crossing inside a step.
pub(super) struct EventCrossing {
    pub occurrence: EventOccurrence,
    pub is_terminal: bool,
}

impl<'e, 'a> EventDetector<'e, 'a> {
    /// Evaluates the events at the start. A g that is zero there does not count as a crossing.
    ///
    /// # Errors
    /// The function of an event has no value.
    pub fn start(events: &'e mut [Event<'a>], t: f64, q: &[f64], v: &[f64]) -> Result<Self, NoValue> {
        let last = events.iter_mut().map(|event| event.value(t, q, v)).collect::<Result<_, _>>()?;
        Ok(Self { events, last, q: q.to_vec(), v: v.to_vec() })
    }

    /// The crossings in (t₀, t₁], sorted by time.
    ///
    /// # Errors
    /// The function of an event has no value.
    pub(super) fn find_crossings(
        &mut self,
        t0: f64,
        t1: f64,
        state_at: &mut StateAt<'_>,
    ) -> Result<Vec<EventCrossing>, NoValue> {
        let mut found = Vec::new();
        if self.events.is_empty() {
            return Ok(found);
        }
        let Self { events, last, q, v } = self;
        let mut before = t0;
        for part in 1..=EVALUATIONS {
            let now =
                if part == EVALUATIONS { t1 } else { t0 + (t1 - t0) * (part as f64 / EVALUATIONS as f64) };
            for (index, event) in events.iter_mut().enumerate() {
                state_at(now, q, v);
                let g = event.value(now, q, v)?;
                let (g_before, rising) = (last[index], g > last[index]);
                last[index] = g;
                // A start from zero is not a crossing: it was counted when it was reached, or it is the start
                // of the run.
                let crossed = (g_before < 0.0 && g >= 0.0) || (g_before > 0.0 && g <= 0.0);
                if !crossed || !event.counts(rising) {
                    continue;
                }
                let mut trouble = None;
                let time = find_root((before, g_before), (now, g), |t| {
                    state_at(t, q, v);
                    // A zero ends the search.
                    event.value(t, q, v).unwrap_or_else(|error| {
                        trouble.get_or_insert(error);
                        0.0
                    })
                });
                if let Some(error) = trouble {
                    return Err(error);
                }
                state_at(time, q, v);
                let (name, q, v) = (event.name.clone(), q.clone(), v.clone());
                let occurrence = EventOccurrence { event: index, name, time, rising, q, v };
                found.push(EventCrossing { occurrence, is_terminal: event.is_terminal });
            }
            before = now;
        }
        found.sort_by(|a, b| a.occurrence.time.total_cmp(&b.occurrence.time));
        Ok(found)
    }

    /// Whether there are no events.
    pub(super) fn is_empty(&self) -> bool {
        self.events.is_empty()
    }

    /// Whether some event is terminal.
    pub(super) fn has_terminal(&self) -> bool {
        self.events.iter().any(|event| event.is_terminal)
    }

    /// g of one event.
    ///
    /// # Errors
    /// The function has no value.
    pub(super) fn value(&mut self, event: usize, t: f64, q: &[f64], v: &[f64]) -> Result<f64, NoValue> {
        self.events[event].value(t, q, v)
    }

    /// ġ of one event at t along the step, by a finite difference over `width` around t, inside \[t₀, t₁\].
    ///
    /// # Errors
    /// The function has no value.
    pub(super) fn derivative(
        &mut self,
        event: usize,
        t: f64,
        (width, t0, t1): (f64, f64, f64),
        state_at: &mut StateAt<'_>,
    ) -> Result<f64, NoValue> {
        let Self { events, q, v, .. } = self;
        let (from, to) = ((t - 0.5 * width).max(t0), (t + 0.5 * width).min(t1));
        state_at(from, q, v);
        let before = events[event].value(from, q, v)?;
        state_at(to, q, v);
        Ok((events[event].value(to, q, v)? - before) / (to - from))
    }
}
