//! Electric motors with a controller of their voltage: current, temperature, friction by bristles.

#[cfg(feature = "serde")]
use serde::{Deserialize, Serialize};

/// An electric motor with the torque f = K i, where i = (V − K ℓ̇)/R without inductance.
///
/// V is the sum of the voltages at the terminals and, with a controller, of its voltage
/// R/K·τ + K ℓ̇ within ±[`voltage_limit`](Self::voltage_limit). τ is the torque that the controller requests.
#[derive(Clone, Copy, Debug, PartialEq)]
#[cfg_attr(feature = "serde", derive(Serialize, Deserialize))]
pub struct ElectricMotor {
    /// R at the reference temperature \[Ω\].
    pub resistance: f64,
    /// K \[N·m/A\], which is the constant of the back-EMF, too \[V·s/rad\].
    pub constant: f64,
    /// The largest voltage of the controller \[V\]; infinite for an unlimited one.
    #[cfg_attr(feature = "serde", serde(with = "crate::joint::number_or_infinity"))]
    pub voltage_limit: f64,
    /// The largest current of the controller \[A\]; infinite for an unlimited one. It bounds the requested
    /// torque to ± K times this current.
    #[cfg_attr(
        feature = "serde",
        serde(
            default = "infinite",
            skip_serializing_if = "is_infinite",
            with = "crate::joint::number_or_infinity"
        )
    )]
    pub current_limit: f64,
    /// The reduction of the current limit of a hot winding. It needs a winding and a finite current limit.
    #[cfg_attr(feature = "serde", serde(default, skip_serializing_if = "Option::is_none"))]
    pub derating: Option<Derating>,
    /// The dynamics of the current, if it has inductance.
    #[cfg_attr(feature = "serde", serde(default, skip_serializing_if = "Option::is_none"))]
    pub current: Option<CurrentDynamics>,
    /// The temperature of the winding, which changes R.
    #[cfg_attr(feature = "serde", serde(default, skip_serializing_if = "Option::is_none"))]
    pub winding: Option<WindingTemperature>,
    /// The friction of its bearings and gears, which the bounds of f do not limit.
    #[cfg_attr(feature = "serde", serde(default, skip_serializing_if = "Option::is_none"))]
    pub friction: Option<BristleFriction>,
}

/// The protection of a winding: the current limit falls linearly from its whole at `start` to 0 at `end`.
#[derive(Clone, Copy, Debug, PartialEq)]
#[cfg_attr(feature = "serde", derive(Serialize, Deserialize))]
pub struct Derating {
    /// The temperature at which the current limit begins to fall \[°C\].
    pub start: f64,
    /// The temperature at which it is 0 \[°C\].
    pub end: f64,
}

/// The operation of a motor at a torque and a speed without changes of its current.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct MotorLoad {
    /// i \[A\].
    pub current: f64,
    /// V = R i + K ℓ̇ \[V\].
    pub voltage: f64,
    /// V i, the power that the motor takes \[W\]; negative where it brakes and returns power.
    pub power: f64,
    /// R i², the power that heats the winding \[W\].
    pub heat: f64,
}

/// i̇ = ((V − K ℓ̇)/R − i)/T within bounds.
#[derive(Clone, Copy, Debug, PartialEq)]
#[cfg_attr(feature = "serde", derive(Serialize, Deserialize))]
pub struct CurrentDynamics {
    /// T, the inductance over the resistance \[s\].
    pub time_constant: f64,
    /// The largest |i̇| \[A/s\]; infinite for an unlimited one.
    #[cfg_attr(feature = "serde", serde(with = "crate::joint::number_or_infinity"))]
    pub rate_limit: f64,
}

/// The temperature of a winding: C Ṫ = R i² − T/R_th, where T is the rise above the ambient temperature.
/// R is the resistance at the reference temperature times 1 + α (T + T_ambient − T_reference).
#[derive(Clone, Copy, Debug, PartialEq)]
#[cfg_attr(feature = "serde", derive(Serialize, Deserialize))]
pub struct WindingTemperature {
    /// R_th \[K/W\].
    pub resistance: f64,
    /// C \[J/K\].
    pub capacity: f64,
    /// α \[1/K\].
    pub coefficient: f64,
    /// The temperature at which the resistance is known \[°C\].
    pub reference: f64,
    /// The ambient temperature \[°C\].
    pub ambient: f64,
}

/// Friction −σ₀ z − σ₁ ż by the deflection z of bristles, ż = ℓ̇ − σ₀ |ℓ̇| z/g(ℓ̇), where
/// g(ℓ̇) = F_C + (F_S − F_C) exp(−(ℓ̇/v_S)²). **(Canudas de Wit et al. 1995, LuGre)**
#[derive(Clone, Copy, Debug, PartialEq)]
#[cfg_attr(feature = "serde", derive(Serialize, Deserialize))]
pub struct BristleFriction {
    /// σ₀ \[N·m/rad or N/m\].
    pub stiffness: f64,
    /// σ₁ \[N·m·s/rad or N·s/m\].
    pub damping: f64,
    /// F_C, the friction of fast motion \[N·m or N\].
    pub coulomb: f64,
    /// F_S, the friction at rest \[N·m or N\].
    pub static_friction: f64,
    /// v_S, the velocity of the change between both \[rad/s or m/s\].
    pub stribeck_velocity: f64,
}

/// The smallest denominator, as in MuJoCo.
const SMALLEST: f64 = 1e-15;

impl ElectricMotor {
    /// A motor without inductance, heating, friction and bounds.
    ///
    /// ```
    /// let motor = robot_dynamics::description::ElectricMotor::new(2.0, 0.1);
    /// assert_eq!(motor.voltage(None, 12.0, 20.0), 12.0);
    /// assert_eq!(motor.steady_current(12.0, 20.0, 0.0), (12.0 - 0.1 * 20.0) / 2.0);
    /// ```
    pub const fn new(resistance: f64, constant: f64) -> Self {
        let (current, winding, friction) = (None, None, None);
        let (voltage_limit, current_limit, derating) = (f64::INFINITY, f64::INFINITY, None);
        Self { resistance, constant, voltage_limit, current_limit, derating, current, winding, friction }
    }

    /// A motor of a data sheet: its stall torque \[N·m\] and its speed without load \[rad/s\] at a voltage
    /// \[V\], which is the largest one. K = V/ω₀ and R = K V/τ₀.
    ///
    /// ```
    /// let motor = robot_dynamics::description::ElectricMotor::from_data_sheet(1.2, 300.0, 24.0);
    /// let torque = |speed: f64| motor.constant * motor.steady_current(24.0, speed, 0.0);
    /// assert!((torque(0.0) - 1.2).abs() < 1e-15 && torque(300.0).abs() < 1e-15);
    /// assert!((torque(150.0) - 0.6).abs() < 1e-15); // the torque-speed line
    /// ```
    pub fn from_data_sheet(stall_torque: f64, no_load_speed: f64, voltage: f64) -> Self {
        let constant = voltage / no_load_speed;
        Self { voltage_limit: voltage, ..Self::new(constant * voltage / stall_torque, constant) }
    }

    /// The bounds on the torque that a controller requests, at a rise of the temperature above the ambient
    /// one \[N·m\]: ± K times the current limit, reduced in a hot winding.
    ///
    /// ```
    /// use robot_dynamics::description::{Derating, ElectricMotor, WindingTemperature};
    /// let mut motor = ElectricMotor::new(2.0, 0.1);
    /// motor.current_limit = 5.0;
    /// motor.derating = Some(Derating { start: 100.0, end: 120.0 });
    /// let (resistance, capacity) = (1.0, 1.0);
    /// let (coefficient, reference, ambient) = (0.004, 20.0, 25.0);
    /// motor.winding = Some(WindingTemperature { resistance, capacity, coefficient, reference, ambient });
    /// assert_eq!(motor.torque_limit(50.0), 0.5);
    /// assert!((motor.torque_limit(80.0) - 0.375).abs() < 1e-15); // at 105 °C
    /// assert_eq!(motor.torque_limit(100.0), 0.0);
    /// ```
    pub fn torque_limit(&self, rise: f64) -> f64 {
        let share = match (self.derating, self.winding) {
            (Some(Derating { start, end }), Some(winding)) => {
                ((end - rise - winding.ambient) / (end - start)).clamp(0.0, 1.0)
            }
            _ => 1.0,
        };
        if share > 0.0 { share * self.constant * self.current_limit } else { 0.0 }
    }

    /// The bounds on the torque without a change of the current, at a speed of the shaft and a rise of the
    /// temperature \[N·m\]: those of the current limit and of the voltage limit.
    ///
    /// ```
    /// let mut motor = robot_dynamics::description::ElectricMotor::from_data_sheet(1.2, 300.0, 24.0);
    /// motor.current_limit = 10.0; // 0.8 N m
    /// let [lower, upper] = motor.torque_range(150.0, 0.0);
    /// assert!((upper - 0.6).abs() < 1e-15 && (lower + 0.8).abs() < 1e-15);
    /// ```
    pub fn torque_range(&self, velocity: f64, rise: f64) -> [f64; 2] {
        let by_current = self.torque_limit(rise);
        [-1.0, 1.0].map(|side| {
            let voltage = side * self.voltage_limit;
            let by_voltage = self.constant * self.steady_current(voltage, velocity, rise);
            by_voltage.clamp(-by_current, by_current)
        })
    }

    /// The operation at a torque and a speed of the shaft, at a rise of the temperature.
    ///
    /// ```
    /// let motor = robot_dynamics::description::ElectricMotor::new(2.0, 0.1);
    /// let load = motor.load(0.3, 50.0, 0.0);
    /// assert!((load.current - 3.0).abs() < 1e-15 && (load.voltage - (6.0 + 5.0)).abs() < 1e-14);
    /// assert!((load.power - load.heat - 0.3 * 50.0).abs() < 1e-12); // the rest is mechanical
    /// ```
    pub fn load(&self, torque: f64, velocity: f64, rise: f64) -> MotorLoad {
        let current = torque / self.constant;
        let resistance = self.resistance_at(rise);
        let voltage = resistance * current + self.constant * velocity;
        MotorLoad { current, voltage, power: voltage * current, heat: resistance * current * current }
    }

    /// Whether it has effects beyond f = K/R·V − K²/R ℓ̇.
    pub fn is_plain(&self) -> bool {
        let has_state = self.current.is_some() || self.winding.is_some() || self.friction.is_some();
        self.voltage_limit == f64::INFINITY && self.current_limit == f64::INFINITY && !has_state
    }

    /// R for a rise of the temperature above the ambient one \[Ω\].
    ///
    /// ```
    /// use robot_dynamics::description::{ElectricMotor, WindingTemperature};
    /// let mut motor = ElectricMotor::new(2.0, 0.1);
    /// let (resistance, capacity) = (1.0, 1.0);
    /// let (coefficient, reference, ambient) = (0.004, 20.0, 25.0);
    /// motor.winding = Some(WindingTemperature { resistance, capacity, coefficient, reference, ambient });
    /// assert!((motor.resistance_at(45.0) - 2.0 * (1.0 + 0.004 * 50.0)).abs() < 1e-15);
    /// ```
    pub fn resistance_at(&self, rise: f64) -> f64 {
        self.winding.map_or(self.resistance, |winding| {
            let above = rise + winding.ambient - winding.reference;
            self.resistance * (1.0 + winding.coefficient * above)
        })
    }

    /// V for the torque that a controller requests, if there is one, and for the voltage at the terminals.
    pub fn voltage(&self, request: Option<f64>, terminals: f64, velocity: f64) -> f64 {
        terminals
            + request.map_or(0.0, |torque| {
                let voltage = self.resistance / self.constant * torque + self.constant * velocity;
                voltage.max(-self.voltage_limit).min(self.voltage_limit)
            })
    }

    /// (V − K ℓ̇)/R, the current that V drives in the end \[A\].
    pub fn steady_current(&self, voltage: f64, velocity: f64, rise: f64) -> f64 {
        (voltage - self.constant * velocity) / self.resistance_at(rise).max(SMALLEST)
    }
}

impl CurrentDynamics {
    /// i̇ for the current that the voltage drives in the end \[A/s\].
    ///
    /// ```
    /// let inductance = robot_dynamics::description::CurrentDynamics { time_constant: 0.125, rate_limit: 5.0 };
    /// assert_eq!(inductance.rate(1.25, 1.0), 2.0);
    /// assert_eq!(inductance.rate(3.0, 1.0), 5.0);
    /// ```
    pub fn rate(&self, steady: f64, current: f64) -> f64 {
        let rate = (steady - current) / self.time_constant;
        rate.max(-self.rate_limit).min(self.rate_limit)
    }
}

impl WindingTemperature {
    /// Ṫ for the power that the winding loses as heat \[K/s\].
    pub fn rate(&self, heat: f64, rise: f64) -> f64 {
        (heat - rise / self.resistance) / self.capacity
    }
}

impl BristleFriction {
    /// ż \[rad/s or m/s\].
    ///
    /// ```
    /// let friction = robot_dynamics::description::BristleFriction {
    ///     stiffness: 100.0,
    ///     damping: 0.5,
    ///     coulomb: 0.2,
    ///     static_friction: 0.3,
    ///     stribeck_velocity: 0.01,
    /// };
    /// // Fast motion deflects the bristles until their force is F_C.
    /// assert!(friction.rate(0.2 / 100.0, 5.0).abs() < 1e-15);
    /// assert!((friction.force(0.2 / 100.0, 5.0) + 0.2).abs() < 1e-15);
    /// ```
    pub fn rate(&self, deflection: f64, velocity: f64) -> f64 {
        velocity - self.decay(velocity) * deflection
    }

    /// −σ₀ z − σ₁ ż \[N·m or N\].
    pub fn force(&self, deflection: f64, velocity: f64) -> f64 {
        -self.stiffness * deflection - self.damping * self.rate(deflection, velocity)
    }

    /// σ₀ |ℓ̇|/g(ℓ̇) \[1/s\].
    fn decay(&self, velocity: f64) -> f64 {
        let ratio = velocity / self.stribeck_velocity.max(SMALLEST);
        let g = self.coulomb + (self.static_friction - self.coulomb) * (-ratio * ratio).exp();
        self.stiffness * velocity.abs() / g.max(SMALLEST)
    }

    /// z after h \[s\] at a constant velocity.
    ///
    /// ```
    /// let friction = robot_dynamics::description::BristleFriction {
    ///     stiffness: 100.0,
    ///     damping: 0.5,
    ///     coulomb: 0.2,
    ///     static_friction: 0.3,
    ///     stribeck_velocity: 0.01,
    /// };
    /// assert!((friction.after(10.0, 0.0, 5.0) - 0.2 / 100.0).abs() < 1e-15);
    /// ```
    pub fn after(&self, h: f64, deflection: f64, velocity: f64) -> f64 {
        let decay = self.decay(velocity);
        // ∫₀ʰ exp(−a t) dt.
        let integral = if decay > 0.0 { -(-decay * h).exp_m1() / decay } else { h };
        deflection * (-decay * h).exp() + integral * velocity
    }
}

#[cfg(feature = "serde")]
fn infinite() -> f64 {
    f64::INFINITY
}

#[cfg(feature = "serde")]
#[allow(clippy::trivially_copy_pass_by_ref)] // serde passes a reference
fn is_infinite(limit: &f64) -> bool {
    *limit == f64::INFINITY
}
