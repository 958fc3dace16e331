//! Controllers with several inputs, `<pid>` and `<dcmotor>`, as sums of forces that are affine in one input
//! each.
//!
//! The first input becomes an actuator with the terms without an input. Each further input becomes an
//! actuator that adds to it. Controllers with states are not supported.

use robot_dynamics_description::{ActuatorDescription, Affine, Cogging};

use super::settings::Settings;
use crate::element::Element;
use crate::reader::Reader;

/// An input of a controller.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(super) enum Input {
    Position,
    Velocity,
    Feedforward,
    Voltage,
}

impl Input {
    const ALL: [Self; 4] = [Self::Position, Self::Velocity, Self::Feedforward, Self::Voltage];

    const fn word(self) -> &'static str {
        match self {
            Self::Position => "pos",
            Self::Velocity => "vel",
            Self::Feedforward => "ff",
            Self::Voltage => "voltage",
        }
    }
}

/// The force of a controller: the terms without an input, and the factor of each input.
pub(super) struct Law {
    pub(super) bias: Affine,
    pub(super) gains: Vec<(Input, f64)>,
    pub(super) cogging: Option<Cogging>,
    /// The ratio of the critical damping, in the place of the damping.
    pub(super) damping_ratio: Option<f64>,
}

impl Settings {
    /// The inputs of a controller, in their order.
    fn inputs(&self) -> Vec<Input> {
        match self.inputs.as_deref() {
            None if self.gain_kind == "pid" => vec![Input::Position, Input::Velocity],
            None => vec![Input::Voltage],
            Some(words) => {
                let has = |input: &Input| words.split_whitespace().any(|word| word == input.word());
                Input::ALL.into_iter().filter(has).collect()
            }
        }
    }

    /// Whether this is a controller.
    pub(super) fn is_controller(&self) -> bool {
        matches!(self.gain_kind.as_str(), "pid" | "dcmotor")
    }

    /// The number of controls.
    pub(super) fn control_count(&self) -> usize {
        match self.gain_kind.as_str() {
            "pid" | "dcmotor" => self.inputs().len(),
            "so3" => 3 + usize::from(self.inputs.as_deref() == Some("quat")),
            _ => 1,
        }
    }

    /// The law of a controller; the reason if it is not supported.
    fn law(&self) -> Result<Law, &'static str> {
        if self.gain_kind == "pid" { self.pid() } else { self.dc_motor() }
    }

    fn pid(&self) -> Result<Law, &'static str> {
        let [constant, length, velocity, ..] = self.bias;
        if self.gain[0] > 0.0 {
            return Err("ki: the integral of the error of a controller is not in the model");
        }
        if self.dynamics_numbers[1] > 0.0 {
            return Err("slewmax: the bound on the rate of a setpoint is not in the model");
        }
        // In MJCF a positive velocity bias is a damping ratio.
        let damping_ratio = Some(velocity).filter(|&ratio| ratio > 0.0);
        let velocity = velocity.min(0.0);
        let gain = |input| match input {
            Input::Position => -length,
            Input::Velocity => -velocity,
            Input::Feedforward | Input::Voltage => 1.0,
        };
        let gains = self.inputs().into_iter().map(|input| (input, gain(input))).collect();
        Ok(Law { bias: Affine { constant, length, velocity }, gains, cogging: None, damping_ratio })
    }

    /// f = K/R V − K²/R ℓ̇ for the voltage V at the terminals. A controller adds R/K times its torque and K ℓ̇
    /// to V.
    fn dc_motor(&self) -> Result<Law, &'static str> {
        let [resistance, constant, _, _, stiffness, integral, damping, most, ..] = self.gain;
        let [electrical, _, thermal, _, _, bristles, _, slew, ..] = self.dynamics_numbers;
        let inputs = self.inputs();
        let is_controlled = inputs.iter().any(|input| *input != Input::Voltage);
        for (is_stated, reason) in [
            (electrical > 0.0, "inductance: the dynamics of the current are not in the model"),
            (thermal > 0.0, "thermal: the temperature of the winding is not in the model"),
            (bristles > 0.0, "lugre: the friction by bristles is not in the model"),
            (slew > 0.0, "controller: the bound on the rate of a setpoint is not in the model"),
            (integral > 0.0, "controller: the integral of the error is not in the model"),
            (most > 0.0 && is_controlled, "controller: the bound on its voltage is not in the model"),
            (inputs.is_empty(), "input=\"none\": a motor without an input is not in the model"),
        ] {
            if is_stated {
                return Err(reason);
            }
        }
        let bias = if is_controlled {
            Affine { constant: 0.0, length: -stiffness, velocity: -damping }
        } else {
            Affine { constant: 0.0, length: 0.0, velocity: -constant * constant / resistance }
        };
        let gain = |input| match input {
            Input::Position => stiffness,
            Input::Velocity => damping,
            Input::Feedforward => 1.0,
            Input::Voltage => constant / resistance,
        };
        let gains = inputs.into_iter().map(|input| (input, gain(input))).collect();
        let [amplitude, poles, phase, ..] = self.bias;
        let cogging = Some(Cogging { amplitude, poles, phase }).filter(|_| amplitude != 0.0);
        Ok(Law { bias, gains, cogging, damping_ratio: None })
    }
}

impl Reader<'_> {
    /// The law of a controller; `None`, with a warning, if it is not supported.
    pub(super) fn controller_law(&mut self, element: &Element, settings: &Settings) -> Option<Law> {
        let [resistance, constant, ..] = settings.gain;
        if settings.gain_kind == "dcmotor" && !(constant > 0.0 && resistance > 0.0) {
            let reason = "its motor constant and resistance must be positive; give `motorconst` and `resistance`, \
                          or `nominal`";
            self.refuse(element, reason);
            return None;
        }
        match settings.law() {
            Ok(law) => Some(law),
            Err(reason) => {
                self.report_ignored_physics(element, reason);
                None
            }
        }
    }

    /// The actuators of a controller: the given one with the first input, and those that add to it.
    pub(super) fn controller(
        &mut self,
        element: &Element,
        settings: &Settings,
        law: &Law,
        first: &ActuatorDescription,
    ) -> Vec<ActuatorDescription> {
        let (common, is_pid) = (first.control_range, settings.gain_kind == "pid");
        let mut all: Vec<ActuatorDescription> = Vec::new();
        for &(input, gain) in &law.gains {
            let mut actuator = if let Some(first) = all.first() {
                let name = format!("{}_{}", first.name, input.word());
                let mut own = ActuatorDescription::new(name, first.transmission.clone());
                own.adds_to = Some(first.name.clone());
                own
            } else {
                let mut own = first.clone();
                (own.bias, own.cogging) = (law.bias, law.cogging);
                own
            };
            actuator.gain = Affine::constant(gain);
            let range = match input {
                Input::Velocity if is_pid => Some("velrange"),
                Input::Feedforward if is_pid => Some("ffrange"),
                _ => None,
            };
            actuator.control_range = match range {
                None => common,
                Some(range) => self
                    .numbers::<2>(element, range)
                    .filter(|[lower, upper]| lower < upper)
                    .unwrap_or([f64::NEG_INFINITY, f64::INFINITY]),
            };
            all.push(actuator);
        }
        all
    }
}
