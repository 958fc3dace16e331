//! The memory of actuation.

use robot_dynamics_core::{Model, Workspace};

use super::controller_memory::ControllerMemory;
use super::difference::DifferenceMemory;
use super::spatial_tendon::SpatialTendons;
use super::transmission::TransmissionMemory;
use crate::FluidWorkspace;

/// The memory of [`Actuation`](super::Actuation)'s calls.
#[derive(Clone, Debug)]
pub struct ActuationWorkspace {
    pub(super) transmissions: TransmissionMemory,
    /// The workspace of the robot with the carried masses.
    pub(super) carried: Option<Workspace>,
    pub(super) weight: Vec<f64>,
    /// The force of each actuator, and the total force of the actuators on each tendon.
    pub(super) forces: Vec<f64>,
    pub(super) cogging: Vec<f64>,
    pub(super) on_tendons: Vec<f64>,
    pub(super) controllers: ControllerMemory,
    /// Allocated if there is a fluid.
    pub(super) fluid: Option<FluidWorkspace>,
    /// Allocated by the first call that asks for derivatives.
    pub(super) differences: Option<DifferenceMemory>,
}

impl ActuationWorkspace {
    /// For this many degrees of freedom, actuators and tendons; `carried` is the robot with the carried
    /// masses.
    pub(super) fn new(
        (nv, actuators, tendons): (usize, usize, usize),
        spatial: Option<&SpatialTendons>,
        controllers: ControllerMemory,
        carried: Option<&Model>,
    ) -> Self {
        Self {
            transmissions: TransmissionMemory::new(nv, spatial),
            carried: carried.map(Workspace::new),
            weight: vec![0.0; nv],
            forces: vec![0.0; actuators],
            cogging: vec![0.0; actuators],
            on_tendons: vec![0.0; tendons],
            controllers,
            fluid: None,
            differences: None,
        }
    }

    /// The forces of a fluid in the last call, if there is one.
    pub(crate) fn last_fluid_forces(&self) -> Option<&[f64]> {
        self.fluid.as_ref().map(FluidWorkspace::last_forces)
    }

    /// The rates of the states of controllers and motors at the last evaluation of actuators.
    pub(crate) fn state_rates(&self) -> &[f64] {
        &self.controllers.rates
    }

    /// Each actuator's force in the last call.
    pub(crate) fn actuator_forces(&self) -> &[f64] {
        &self.forces
    }
}
