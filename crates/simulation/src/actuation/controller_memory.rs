//! The memory of the states of controllers and motors.

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
