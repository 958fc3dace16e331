//! The states of controllers and motors, which depend on the motion: the integral of an error, the
//! temperature of a winding, the deflection of bristles and the current.
//!
//! They follow the activations of all actuators, by actuators, in this order.

use robot_dynamics_description::check_length;

use super::controller_memory::ControllerMemory;
use super::law::within;
use super::{Actuation, ActuationWorkspace};

impl Actuation {
    /// The number of entries of the activations: one for each actuator, and then the states of controllers
    /// and motors, by actuators. These are the integral of the error, the temperature, the deflection of
    /// bristles and the current, as far as an actuator has them.
    ///
    /// ```
    /// use robot_dynamics::description::{ActuatorDescription, IntegralAction, Transmission, pendulum};
    /// use robot_dynamics::model::Model;
    /// use robot_dynamics::simulation::Actuation;
    /// let mut robot = pendulum(2.0, 0.5);
    /// let mut servo = ActuatorDescription::new("servo", Transmission::joint("hinge", 1.0)).servo(100.0, 5.0);
    /// servo.integral = Some(IntegralAction { gain: 20.0, limit: f64::INFINITY });
    /// robot.actuators.push(servo);
    /// let model = Model::new(robot)?;
    /// let actuation = Actuation::new(&model)?;
    /// assert_eq!((actuation.control_count(), actuation.activation_count()), (1, 2));
    /// let (mut memory, mut tau) = (actuation.workspace(), [0.0]);
    /// actuation.forces(&model, &mut memory, &[0.5, 0.03], &[0.5], &[0.0], &mut tau);
    /// assert_eq!(tau, [20.0 * 0.03]);
    /// # Ok::<(), robot_dynamics::description::ModelError>(())
    /// ```
    pub fn activation_count(&self) -> usize {
        self.actuators.len() + self.state_count()
    }

    /// Whether some actuator has an integral term or a motor.
    pub(crate) fn has_controllers(&self) -> bool {
        self.has_controllers
    }

    /// The number of states of controllers and motors.
    pub(crate) fn state_count(&self) -> usize {
        self.places.iter().map(|places| places.count()).sum()
    }

    /// The states among the activations; none if only the controls are given.
    pub(super) fn states_of<'u>(&self, u: &'u [f64]) -> &'u [f64] {
        u.get(self.actuators.len()..).unwrap_or(&[])
    }

    /// # Panics
    /// If `u` has neither one entry for each actuator, nor those of the states in addition.
    #[track_caller]
    pub(crate) fn check_controls(&self, u: &[f64]) {
        if u.len() != self.activation_count() {
            check_length("the controls", u.len(), self.actuators.len());
        }
    }

    /// The fastest current of a motor, as 1/T \[1/s\].
    pub(crate) fn fastest_current(&self) -> f64 {
        let motors = self.actuators.iter().filter_map(|(actuator, _)| actuator.motor.as_ref());
        let rates = motors.filter_map(|motor| motor.current).map(|dynamics| 1.0 / dynamics.time_constant);
        rates.fold(0.0, f64::max)
    }

    /// Adds the integral terms to the forces, and replaces requested torques by those of the motors. Computes
    /// the rates of all states. Without values all states are 0.
    pub(super) fn apply_controllers(&self, workspace: &mut ActuationWorkspace, states: &[f64]) {
        let ActuationWorkspace { forces, cogging, controllers, .. } = workspace;
        let ControllerMemory { inputs, rates } = controllers;
        let at = |place: Option<usize>| place.and_then(|place| states.get(place)).copied();
        for (k, (actuator, _)) in self.actuators.iter().enumerate().filter(|_| self.has_controllers) {
            let (places, input) = (self.places[k], &mut inputs[k]);
            if let Some(integral) = actuator.integral {
                let value = at(places.integral).unwrap_or(0.0);
                forces[k] += integral.gain * value;
                set(rates, places.integral, integral.rate(input.error, value));
            }
            let Some(motor) = &actuator.motor else { continue };
            let (rise, velocity) = (at(places.temperature).unwrap_or(0.0), input.velocity);
            let limit = motor.torque_limit(rise);
            let request = (!actuator.at_terminals).then(|| within(forces[k], [-limit, limit]));
            let terminals = motor.resistance / motor.constant * input.terminals;
            let voltage = motor.voltage(request, terminals, velocity);
            input.steady = motor.steady_current(voltage, velocity, rise);
            let current = match motor.current {
                None => input.steady,
                Some(_) => at(places.current).unwrap_or(0.0),
            };
            input.heat = motor.resistance_at(rise) * current * current;
            forces[k] = motor.constant * current;
            if let Some(friction) = &motor.friction {
                let deflection = at(places.deflection).unwrap_or(0.0);
                cogging[k] += friction.force(deflection, velocity);
                set(rates, places.deflection, friction.rate(deflection, velocity));
            }
            if let Some(winding) = &motor.winding {
                set(rates, places.temperature, winding.rate(input.heat, rise));
            }
            if let Some(dynamics) = &motor.current {
                set(rates, places.current, dynamics.rate(input.steady, current));
            }
        }
    }

    /// Advances the states by h \[s\] with the inputs of the last evaluation held. Each state alone is
    /// advanced exactly.
    pub(crate) fn evolve_states(&self, workspace: &ActuationWorkspace, h: f64, states: &mut [f64]) {
        let ControllerMemory { inputs, .. } = &workspace.controllers;
        for (k, (actuator, _)) in self.actuators.iter().enumerate().filter(|_| self.has_controllers) {
            let (places, input) = (self.places[k], &inputs[k]);
            if let Some(place) = places.integral {
                states[place] += h * input.error;
            }
            let Some(motor) = &actuator.motor else { continue };
            if let (Some(place), Some(winding)) = (places.temperature, &motor.winding) {
                let (end, time) = (winding.resistance * input.heat, winding.resistance * winding.capacity);
                states[place] += (end - states[place]) * -(-h / time).exp_m1();
            }
            if let (Some(place), Some(friction)) = (places.deflection, &motor.friction) {
                states[place] = friction.after(h, states[place], input.velocity);
            }
            if let (Some(place), Some(dynamics)) = (places.current, &motor.current) {
                let change = (input.steady - states[place]) * -(-h / dynamics.time_constant).exp_m1();
                let most = h * dynamics.rate_limit;
                states[place] += change.max(-most).min(most);
            }
        }
        self.bound_states(states);
    }

    /// Returns the integrals to their limits.
    pub(crate) fn bound_states(&self, states: &mut [f64]) {
        for (places, (actuator, _)) in self.places.iter().zip(&self.actuators) {
            if let (Some(place), Some(integral)) = (places.integral, actuator.integral) {
                let value = within(states[place], [-integral.limit, integral.limit]);
                states[place] = within(value, actuator.activation_range);
            }
        }
    }
}

fn set(rates: &mut [f64], place: Option<usize>, rate: f64) {
    if let Some(place) = place {
        rates[place] = rate;
    }
}
