//! An actuator as a robot's file states it: what it acts on, and its force as a function of control, length and velocity.

#[cfg(feature = "serde")]
use serde::{Deserialize, Serialize};

/// f = gain(ℓ, ℓ̇)·u + bias(ℓ, ℓ̇), bounded, on a joint, a tendon or a frame; u is the control, or its filtered value.
///
/// A motor has gain 1 and bias 0; a position servo gain k and bias −k ℓ − d ℓ̇.
#[derive(Clone, Debug, PartialEq)]
#[cfg_attr(feature = "serde", derive(Serialize, Deserialize))]
#[non_exhaustive]
pub struct ActuatorDescription {
    /// Its name, unique among actuators.
    pub name: String,
    /// What it acts on.
    pub transmission: Transmission,
    /// The factor of the control.
    pub gain: Affine,
    /// What is added.
    pub bias: Affine,
    /// How the control becomes u.
    pub activation: Activation,
    /// Bounds of the control; infinite where there are none.
    #[cfg_attr(feature = "serde", serde(with = "super::joint_description::numbers_or_infinity"))]
    pub control_range: [f64; 2],
    /// Bounds of f \[N·m or N\]; infinite where there are none.
    #[cfg_attr(feature = "serde", serde(with = "super::joint_description::numbers_or_infinity"))]
    pub force_range: [f64; 2],
}

impl ActuatorDescription {
    /// A motor, f = u, without bounds.
    ///
    /// ```
    /// use multibody::{ActuatorDescription, Transmission};
    /// let motor = ActuatorDescription::new("elbow_motor", Transmission::joint("elbow", 50.0));
    /// assert_eq!((motor.gain.constant, motor.bias.constant), (1.0, 0.0));
    /// ```
    pub fn new(name: impl Into<String>, transmission: Transmission) -> Self {
        let unbounded = [f64::NEG_INFINITY, f64::INFINITY];
        Self {
            name: name.into(),
            transmission,
            gain: Affine::constant(1.0),
            bias: Affine::default(),
            activation: Activation::None,
            control_range: unbounded,
            force_range: unbounded,
        }
    }

    /// A position servo: f = stiffness·(u − ℓ) − damping·ℓ̇.
    ///
    /// ```
    /// use multibody::{ActuatorDescription, Transmission};
    /// let servo = ActuatorDescription::new("servo", Transmission::joint("elbow", 1.0)).servo(100.0, 5.0);
    /// assert_eq!(servo.force(0.5, 0.2, 0.1), 100.0 * (0.5 - 0.2) - 5.0 * 0.1);
    /// ```
    pub fn servo(self, stiffness: f64, damping: f64) -> Self {
        let bias = Affine { constant: 0.0, length: -stiffness, velocity: -damping };
        Self { gain: Affine::constant(stiffness), bias, ..self }
    }

    /// f for the control or activation u at that length and velocity, within its bounds; u is taken as it is.
    ///
    /// ```
    /// use multibody::{ActuatorDescription, Transmission};
    /// let mut motor = ActuatorDescription::new("motor", Transmission::joint("elbow", 1.0));
    /// motor.force_range = [-2.0, 2.0];
    /// assert_eq!(motor.force(3.0, 0.0, 0.0), 2.0);
    /// ```
    pub fn force(&self, u: f64, length: f64, velocity: f64) -> f64 {
        let force = self.gain.at(length, velocity) * u + self.bias.at(length, velocity);
        force.max(self.force_range[0]).min(self.force_range[1])
    }
}

/// c + k ℓ + d ℓ̇.
#[derive(Clone, Copy, Debug, Default, PartialEq)]
#[cfg_attr(feature = "serde", derive(Serialize, Deserialize))]
pub struct Affine {
    /// c.
    pub constant: f64,
    /// k.
    pub length: f64,
    /// d.
    pub velocity: f64,
}

impl Affine {
    /// c alone.
    pub const fn constant(constant: f64) -> Self {
        Self { constant, length: 0.0, velocity: 0.0 }
    }

    /// Its value.
    ///
    /// ```
    /// let servo = multibody::Affine { constant: 1.0, length: -2.0, velocity: -3.0 };
    /// assert_eq!(servo.at(0.5, 1.0), -3.0);
    /// ```
    pub fn at(&self, length: f64, velocity: f64) -> f64 {
        self.constant + self.length * length + self.velocity * velocity
    }
}

/// What an actuator acts on.
#[derive(Clone, Debug, PartialEq)]
#[cfg_attr(feature = "serde", derive(Serialize, Deserialize))]
#[non_exhaustive]
pub enum Transmission {
    /// The freedoms of a joint: ℓ̇ = gearᵀ v and τ = gear·f, with ℓ = gear₀ q for a joint of one freedom, the rotation vector
    /// along the gear for a spherical one, and 0 for a floating one.
    Joint {
        /// Its name.
        joint: String,
        /// One number for each freedom, in the order of v; those beyond are not read.
        gear: [f64; 6],
    },
    /// A tendon: ℓ is gear times the tendon's.
    Tendon {
        /// Its name.
        tendon: String,
        /// The gear.
        gear: f64,
    },
    /// A wrench on a frame along the frame's axes, gear·f, linear before angular: thrusters. ℓ = 0, ℓ̇ = gearᵀ times the
    /// frame's velocity.
    Frame {
        /// A link or frame by name.
        frame: String,
        /// Force and moment per f.
        gear: [f64; 6],
    },
}

impl Transmission {
    /// To a joint of one freedom.
    ///
    /// ```
    /// use multibody::Transmission;
    /// let Transmission::Joint { gear, .. } = Transmission::joint("elbow", 50.0) else { unreachable!() };
    /// assert_eq!(gear[..2], [50.0, 0.0]);
    /// ```
    pub fn joint(joint: impl Into<String>, gear: f64) -> Self {
        Self::Joint { joint: joint.into(), gear: [gear, 0.0, 0.0, 0.0, 0.0, 0.0] }
    }
}

/// How the control becomes what the force is computed from.
#[derive(Clone, Copy, Debug, Default, PartialEq)]
#[cfg_attr(feature = "serde", derive(Serialize, Deserialize))]
#[non_exhaustive]
pub enum Activation {
    /// u is the control.
    #[default]
    None,
    /// u̇ is the control.
    Integrator,
    /// u̇ = (control − u)/T.
    Filter {
        /// T \[s\].
        time_constant: f64,
    },
}
