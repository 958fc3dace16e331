//! The simulation of a run, and what acts in it.

use multibody::simulator::{Effect, Simulation};
use multibody::{HeightField, Model};

use super::Arguments;
use super::method::Method;
use crate::failure::{Context, Failure};
use crate::interruption;

/// The simulation, or what an adaptive run is told instead.
pub(crate) struct Setup {
    /// `None` of adaptive steps.
    pub simulation: Option<Simulation>,
    pub method: Method,
    /// Why that method was chosen; empty where it was given.
    pub reason: String,
    /// What acts.
    pub acting: Vec<Effect>,
    /// What the file states and the run leaves out, one line for each reason.
    pub left_out: Vec<String>,
}

impl Setup {
    /// Everything that the file states, but for what is switched off; motors that hold a pose take the place of the file's actuators.
    ///
    /// # Errors
    /// What was asked for does not go together.
    pub(crate) fn choose(arguments: &Arguments, model: &Model, is_held: bool) -> Result<Self, Failure> {
        if arguments.integrator == Some(Method::Adaptive) {
            return Ok(Self::adaptive(arguments, model));
        }
        let mut builder = robot_dynamics::simulation(model).step(arguments.step);
        builder = builder.interrupt(interruption::shared_flag());
        if let Some(Method::Steps(method)) = arguments.integrator {
            builder = builder.method(method);
        }
        if arguments.conservative {
            builder = builder.conservative();
        }
        let by_hold = is_held.then_some(Effect::Actuators);
        for effect in arguments.without.iter().copied().chain(by_hold) {
            builder = builder.without(effect);
        }
        if let Some(srdf) = &arguments.srdf {
            let pairs = robot_dynamics::urdf::load_disabled_collisions(srdf, model.description())
                .context(srdf.display())?;
            builder = builder.ignore_contacts(pairs);
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
        Ok(Self {
            method: Method::Steps(simulation.method()),
            reason: if arguments.integrator.is_some() {
                String::new()
            } else {
                simulation.reason().to_owned()
            },
            acting: simulation.acting().to_vec(),
            left_out: simulation.unsupported_features().iter().map(ToString::to_string).collect(),
            simulation: Some(simulation),
        })
    }

    /// Adaptive steps know damping that is smooth, and nothing else of what a file states beside the rigid bodies.
    fn adaptive(arguments: &Arguments, model: &Model) -> Self {
        let is_off = |effect| arguments.conservative || arguments.without.contains(&effect);
        let description = model.description();
        let joints = || description.joints.iter();
        let has_friction = joints().any(|joint| joint.passive.friction != 0.0);
        let has_damping = joints().any(|joint| joint.passive.damping != 0.0);
        let mut left_out = Vec::new();
        let mut leave = |is_there: bool, effect, what: &str| {
            if is_there && !is_off(effect) {
                left_out.push(format!("{what}: `adaptive` does not know them, `implicit` does"));
            }
        };
        leave(has_friction, Effect::Dissipation, "damping and dry friction");
        let has_limits =
            joints().any(|joint| joint.limits.lower.is_finite() || joint.limits.upper.is_finite());
        leave(has_limits, Effect::Limits, "position limits");
        leave(!description.actuators.is_empty(), Effect::Actuators, "actuators");
        leave(!description.tendons.is_empty(), Effect::Springs, "tendons");
        leave(
            description.equalities.iter().any(|equality| equality.active),
            Effect::Equalities,
            "equalities",
        );
        let acts = has_damping && !has_friction && !is_off(Effect::Dissipation);
        Self {
            simulation: None,
            method: Method::Adaptive,
            reason: String::new(),
            acting: if acts { vec![Effect::Dissipation] } else { Vec::new() },
            left_out,
        }
    }

    pub(crate) fn acts(&self, effect: Effect) -> bool {
        self.acting.contains(&effect)
    }

    /// Whether nothing takes energy out or puts it in but motors that hold a pose.
    pub(crate) fn conserves(&self) -> bool {
        let lossy = [Effect::Dissipation, Effect::Limits, Effect::Actuators, Effect::Contacts];
        !lossy.into_iter().any(|effect| self.acts(effect))
    }

    /// Whether the method tells losses apart.
    pub(crate) fn has_losses(&self) -> bool {
        self.simulation.as_ref().is_some_and(|simulation| simulation.losses().is_some())
    }

    /// The links that can touch a ground.
    pub(crate) fn ground_links(&self) -> &[String] {
        self.simulation.as_ref().map_or(&[], Simulation::ground_links)
    }

    /// The words of the summary for what is left out: each kind once, with a count where there are several of it.
    pub(crate) fn left_out_lines(&self) -> Vec<String> {
        const SHOWN: usize = 4;
        let mut lines: Vec<String> = self.left_out.iter().take(SHOWN).cloned().collect();
        if self.left_out.len() > SHOWN {
            lines.push(format!("and {} more", self.left_out.len() - SHOWN));
        }
        lines
    }
}
