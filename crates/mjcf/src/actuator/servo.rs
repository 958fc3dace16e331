//! Controllers with several inputs, `<pid>` and `<dcmotor>`, as sums of forces that are affine in one input
//! each.
//!
//! The first input becomes an actuator with the terms without an input, the integral and the motor. Each
//! further input becomes an actuator that adds to it. A motor without an input becomes an actuator whose
//! control has no effect.

use robot_dynamics_description::{
    Activation, ActuatorDescription, Affine, BristleFriction, Cogging, CurrentDynamics, ElectricMotor,
    IntegralAction, WindingTemperature,
};

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
    pub(super) integral: Option<IntegralAction>,
    pub(super) motor: Option<ElectricMotor>,
    /// The largest rate of the setpoint.
    rate_limit: Option<f64>,
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
        let law = if self.gain_kind == "pid" { self.pid() } else { self.dc_motor() };
        let has_position = law.gains.iter().any(|(input, _)| *input == Input::Position);
        if !has_position && (law.integral.is_some() || law.rate_limit.is_some()) {
            return Err(
                "the integral of the error and the bound on the rate of a setpoint need the input pos",
            );
        }
        Ok(law)
    }

    fn pid(&self) -> Law {
        let [constant, length, velocity, ..] = self.bias;
        let [limit, rate, ..] = self.dynamics_numbers;
        // In MJCF a positive velocity bias is a damping ratio.
        let damping_ratio = Some(velocity).filter(|&ratio| ratio > 0.0);
        let velocity = velocity.min(0.0);
        let gain = |input| match input {
            Input::Position => -length,
            Input::Velocity => -velocity,
            Input::Feedforward | Input::Voltage => 1.0,
        };
        let gains = self.inputs().into_iter().map(|input| (input, gain(input))).collect();
        Law {
            bias: Affine { constant, length, velocity },
            gains,
            cogging: None,
            integral: integral(self.gain[0], limit),
            motor: None,
            rate_limit: Some(rate).filter(|&rate| rate > 0.0),
            damping_ratio,
        }
    }

    /// f = K/R V − K²/R ℓ̇ for the voltage V at the terminals. A controller adds R/K times its torque and K ℓ̇
    /// to V.
    fn dc_motor(&self) -> Law {
        let [resistance, constant, _, _, stiffness, integral_gain, damping, ..] = self.gain;
        let [.., rate, limit, _] = self.dynamics_numbers;
        let inputs = self.inputs();
        let is_controlled = inputs.iter().any(|input| *input != Input::Voltage);
        let motor = Some(self.motor()).filter(|motor| !motor.is_plain());
        let bias = if is_controlled {
            Affine { constant: 0.0, length: -stiffness, velocity: -damping }
        } else if motor.is_some() {
            Affine::default()
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
        Law {
            bias,
            gains,
            cogging,
            integral: integral(integral_gain, limit),
            motor,
            rate_limit: Some(rate).filter(|&rate| rate > 0.0),
            damping_ratio: None,
        }
    }

    /// The current, the temperature and the friction of a motor.
    fn motor(&self) -> ElectricMotor {
        let [resistance, constant, coefficient, reference, _, _, _, most, ..] = self.gain;
        let [electrical, current_rate, warm, capacity, ambient, stiffness, damping, ..] =
            self.dynamics_numbers;
        let [_, _, _, coulomb, static_friction, stribeck_velocity, ..] = self.bias;
        let bound = |limit: f64| if limit > 0.0 { limit } else { f64::INFINITY };
        let mut motor = ElectricMotor::new(resistance, constant);
        if self.inputs().iter().any(|input| *input != Input::Voltage) {
            motor.voltage_limit = bound(most);
        }
        if electrical > 0.0 {
            motor.current =
                Some(CurrentDynamics { time_constant: electrical, rate_limit: bound(current_rate) });
        }
        if warm > 0.0 {
            motor.winding =
                Some(WindingTemperature { resistance: warm, capacity, coefficient, reference, ambient });
        }
        if stiffness > 0.0 {
            motor.friction =
                Some(BristleFriction { stiffness, damping, coulomb, static_friction, stribeck_velocity });
        }
        motor
    }
}

/// The integral term with this gain. A limit of 0 means that there is no limit.
fn integral(gain: f64, limit: f64) -> Option<IntegralAction> {
    let limit = if limit > 0.0 { limit } else { f64::INFINITY };
    (gain > 0.0).then_some(IntegralAction { gain, limit })
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
        let [_, _, warm, capacity, ..] = settings.dynamics_numbers;
        if settings.gain_kind == "dcmotor" && (warm > 0.0) != (capacity > 0.0) {
            self.refuse(element, "its thermal resistance and capacity must be positive");
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
        if law.gains.is_empty() {
            let mut passive = first.clone();
            (passive.gain, passive.bias, passive.control_range) = (Affine::default(), law.bias, [0.0; 2]);
            (passive.cogging, passive.motor) = (law.cogging, law.motor);
            passive.at_terminals = law.motor.is_some();
            return vec![passive];
        }
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
                (own.integral, own.motor) = (law.integral, law.motor);
                own
            };
            actuator.gain = Affine::constant(gain);
            actuator.at_terminals = input == Input::Voltage && law.motor.is_some();
            if let Some(rate) = law.rate_limit.filter(|_| input == Input::Position) {
                actuator.activation = Activation::RateLimit { rate };
            }
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
