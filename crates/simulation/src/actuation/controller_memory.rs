//! The places and the memory of the states of controllers and motors.

use robot_dynamics_description::ActuatorDescription;

/// The places of an actuator's states among the activations.
#[derive(Clone, Copy, Debug, Default, PartialEq)]
pub(super) struct StatePlaces {
    pub(super) integral: Option<usize>,
    pub(super) temperature: Option<usize>,
    pub(super) deflection: Option<usize>,
    pub(super) current: Option<usize>,
}

/// Counts the states of all actuators, and returns their places.
pub(super) fn places<'a>(actuators: impl Iterator<Item = &'a ActuatorDescription>) -> Vec<StatePlaces> {
    let mut count = 0;
    let mut next = |is_there: bool| {
        is_there.then(|| {
            count += 1;
            count - 1
        })
    };
    actuators
        .map(|actuator| {
            let motor = actuator.motor.as_ref();
            StatePlaces {
                integral: next(actuator.integral.is_some()),
                temperature: next(motor.is_some_and(|motor| motor.winding.is_some())),
                deflection: next(motor.is_some_and(|motor| motor.friction.is_some())),
                current: next(motor.is_some_and(|motor| motor.current.is_some())),
            }
        })
        .collect()
}

impl StatePlaces {
    pub(super) fn count(self) -> usize {
        [self.integral, self.temperature, self.deflection, self.current].into_iter().flatten().count()
    }
}

/// The inputs of a controller and its motor at the last evaluation.
#[derive(Clone, Copy, Debug, Default)]
pub(super) struct ControllerInputs {
    /// ℓ̇.
    pub(super) velocity: f64,
    /// u − ℓ.
    pub(super) error: f64,
    /// The voltage at the terminals, as the torque K/R V.
    pub(super) terminals: f64,
    /// The current that the voltage drives in the end \[A\].
    pub(super) steady: f64,
    /// R i² \[W\].
    pub(super) heat: f64,
}

/// The memory of the states of controllers, empty without such states.
#[derive(Clone, Debug, Default)]
pub(super) struct ControllerMemory {
    /// The inputs of each actuator.
    pub(super) inputs: Vec<ControllerInputs>,
    /// The rates of all states.
    pub(super) rates: Vec<f64>,
}

impl ControllerMemory {
    /// For this many actuators, or none without controllers, and this many states.
    pub(super) fn new(actuators: usize, states: usize) -> Self {
        Self { inputs: vec![ControllerInputs::default(); actuators], rates: vec![0.0; states] }
    }
}
