//! The default simulation of a robot: its method, and the features of the file that it includes or leaves
//! out.

use std::fmt::Write;

use robot_dynamics::model::Model;
use robot_dynamics::simulation::{Effect, Simulation, UnsupportedFeatures};
use robot_dynamics::text::one_line;
use serde::Serialize;

/// Limits above which no simulation is built for this report, since its memory grows as nv².
const MAX_DOFS: usize = 1000;
const MAX_SHAPES: usize = 10_000;

/// The default simulation, or the reason for its absence.
#[derive(Serialize)]
pub(crate) struct DefaultSimulation {
    method: Option<&'static str>,
    /// The reason for the method.
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
            return nothing("the robot has no degree of freedom".into());
        }
        if nv > MAX_DOFS || shapes > MAX_SHAPES {
            return nothing(format!(
                "not built for {nv} degrees of freedom and {shapes} shapes (at most {MAX_DOFS} and {MAX_SHAPES}); \
                 `dynamics simulate` shows it"
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
        let acting = if acting.is_empty() { "rigid bodies only".into() } else { acting.join(", ") };
        let mut text = format!("Default simulation: {method}: {}\n  includes: {acting}\n", one_line(reason));
        for group in left_out {
            let _ = writeln!(text, "  leaves out {}", one_line(&group.to_string()));
        }
        text
    }
}
