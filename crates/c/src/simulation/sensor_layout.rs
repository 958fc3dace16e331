//! The names of sensors and the places of their values.

use std::ffi::CString;

use robot_dynamics::simulation::Simulation;

use crate::arrays::c_text;

/// The sensors' names and the place of their values.
pub(super) struct Sensors {
    pub(super) names: Vec<CString>,
    /// The first value of each, and the number of all.
    pub(super) starts: Vec<usize>,
}

impl Sensors {
    pub(super) fn of(simulation: &Simulation) -> Self {
        let (mut names, mut starts) = (Vec::new(), vec![0]);
        for (name, values) in simulation.sensors() {
            names.push(c_text(&name));
            starts.push(starts[starts.len() - 1] + values.len());
        }
        Self { names, starts }
    }
}
