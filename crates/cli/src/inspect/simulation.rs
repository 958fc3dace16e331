//! The default simulation of a robot: its method, and the features of the file that act or are left out.

use std::fmt::Write;

use multibody::Model;
use multibody::simulator::{Effect, Simulation, UnsupportedFeatures};
use multibody::text::one_line;
use serde::Serialize;

/// Larger robots are not simulated to say what a simulation leaves out: its memory grows as nv².
const MOST_FREEDOMS: usize = 1000;
const MOST_SHAPES: usize = 10_000;

/// The default simulation, or the reason why none is set up.
#[derive(Serialize)]
pub(crate) struct DefaultSimulation {
    method: Option<&'static str>,
    /// Why that method.
    reason: String,
    acting: Vec<&'static str>,
    left_out: Vec<UnsupportedFeatures>,
}

impl DefaultSimulation {
    pub(crate) fn of(model: &Model) -> Self {
        let nothing =
            |reason: String| Self { method: None, reason, acting: Vec::new(), left_out: Vec::new() };
        let (nv, shapes) = (model.nv(), model.description().shapes.len());
        if nv == 0 {
            return nothing("no joint moves".into());
        }
        if nv > MOST_FREEDOMS || shapes > MOST_SHAPES {
            return nothing(format!(
                "not set up: {nv} degrees of freedom and {shapes} shapes, of at most {MOST_FREEDOMS} and {MOST_SHAPES}; `simulate` says it"
            ));
        }
        match robot_dynamics::simulation(model).build() {
            Ok(simulation) => Self::built(&simulation),
            Err(error) => nothing(error.to_string()),
        }
    }

    fn built(simulation: &Simulation) -> Self {
        Self {
            method: Some(simulation.method().name()),
            reason: simulation.reason().to_owned(),
            acting: simulation.acting().iter().copied().map(Effect::name).collect(),
            left_out: simulation.unsupported_features(),
        }
    }

    pub(super) fn text(&self) -> String {
        let Self { method, reason, acting, left_out } = self;
        let Some(method) = method else { return format!("Default simulation: {}\n", one_line(reason)) };
        let acting =
            if acting.is_empty() { "nothing beside the rigid bodies".into() } else { acting.join(", ") };
        let mut text = format!("Default simulation: by {method}: {}\n  acts: {acting}\n", one_line(reason));
        for group in left_out {
            let _ = writeln!(text, "  leaves out {}", one_line(&group.to_string()));
        }
        text
    }
}
