//! The simulation of a run, and its effects.

use robot_dynamics::contact::HeightField;
use robot_dynamics::model::Model;
use robot_dynamics::simulation::{AdaptiveOptions, ControlTiming, Effect, Method, Simulation};

use super::arguments::Arguments;
use crate::failure::{Context, Failure};
use crate::interruption;

/// Largest number of adaptive steps between two samples: per second, plus a constant. An ordinary robot takes
/// some hundred a second.
const MAX_STEPS: (f64, usize) = (1e5, 10_000);

/// The simulation of a run.
pub(crate) struct Setup {
    pub simulation: Simulation,
    /// The reason for the method; empty if it was given.
    pub reason: String,
}

impl Setup {
    /// A simulation of everything in the file, except what is switched off. Motors that hold a pose replace
    /// the file's actuators.
    ///
    /// # Errors
    ///
    /// The arguments contradict each other.
    pub(crate) fn choose(arguments: &Arguments, model: &Model, is_held: bool) -> Result<Self, Failure> {
        let mut builder = robot_dynamics::simulation(model).dt(arguments.dt);
        builder = builder.interrupt(interruption::shared_flag());
        match arguments.integrator {
            Some(Method::Adaptive) => builder = builder.adaptive(adaptive(arguments, is_held)),
            Some(method) => builder = builder.method(method),
            None => {}
        }
        if arguments.conservative {
            builder = builder.conservative();
        }
        let by_hold = is_held.then_some(Effect::Actuators);
        for effect in arguments.without.iter().copied().chain(by_hold) {
            builder = builder.without(effect);
        }
        if let Some(friction) = arguments.friction {
            builder = builder.height_fields(move |shape| {
                robot_dynamics::height_field(shape).map(|field: HeightField| field.with_friction(friction))
            });
        }
        if let Some(ground) = arguments.half_space()? {
            builder = builder.ground(ground);
        }
        let simulation = builder.build().context(arguments.robot.shown())?;
        let reason = if arguments.integrator.is_some() { "" } else { simulation.reason() };
        Ok(Self { reason: reason.to_owned(), simulation })
    }

    pub(crate) fn method(&self) -> Method {
        self.simulation.method()
    }

    pub(crate) fn acts(&self, effect: Effect) -> bool {
        self.simulation.acting().contains(&effect)
    }

    /// Whether only motors that hold a pose can change the energy.
    pub(crate) fn conserves(&self) -> bool {
        let lossy = [Effect::Dissipation, Effect::Limits, Effect::Actuators, Effect::Contacts];
        !lossy.into_iter().any(|effect| self.acts(effect))
    }

    /// Whether the method separates losses.
    pub(crate) fn has_losses(&self) -> bool {
        self.simulation.losses().is_some()
    }

    /// The links that can touch the ground.
    pub(crate) fn ground_links(&self) -> &[String] {
        self.simulation.ground_links()
    }

    /// The summary's lines on unsupported features, one for each kind, with a count.
    pub(crate) fn left_out_lines(&self) -> Vec<String> {
        const MAX_LINES: usize = 4;
        let left_out = self.simulation.unsupported_features();
        let mut lines: Vec<String> = left_out.iter().take(MAX_LINES).map(ToString::to_string).collect();
        if left_out.len() > MAX_LINES {
            lines.push(format!("and {} more", left_out.len() - MAX_LINES));
        }
        lines
    }
}

/// Motors are sampled and held over periods of `--dt`, as with fixed steps.
fn adaptive(arguments: &Arguments, is_held: bool) -> AdaptiveOptions {
    // At most 1e5 times the longest reasonable --dt; the sum saturates.
    #[allow(clippy::cast_possible_truncation, clippy::cast_sign_loss)]
    let max_steps = ((MAX_STEPS.0 * arguments.dt) as usize).saturating_add(MAX_STEPS.1);
    AdaptiveOptions {
        tolerance: arguments.adaptive_tolerance(),
        control: if is_held {
            ControlTiming::Held { period: arguments.dt }
        } else {
            ControlTiming::Continuous
        },
        max_steps,
        ..AdaptiveOptions::default()
    }
}
