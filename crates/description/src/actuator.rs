//! Actuators: what they act on, and their force as a function of control, length and velocity.

use core::fmt;

#[cfg(feature = "serde")]
use serde::{Deserialize, Serialize};

use crate::{Activation, ElectricMotor, IntegralAction, Muscle};

/// An actuator with the bounded force f = gain(ℓ, ℓ̇)·u + bias(ℓ, ℓ̇) on a joint, a tendon or a frame. u is
/// the control, or its filtered value.
///
/// A motor has gain 1 and bias 0. A position servo has gain k and bias −k ℓ − d ℓ̇. A [`Muscle`] has curves in
/// place of gain and bias.
#[derive(Clone, PartialEq)]
#[cfg_attr(feature = "serde", derive(Serialize, Deserialize))]
#[non_exhaustive]
pub struct ActuatorDescription {
    /// Its name, unique among actuators.
    pub name: String,
    /// The joint, tendon or frame of the force.
    pub transmission: Transmission,
    /// The factor of the control.
    pub gain: Affine,
    /// The term that does not depend on the control.
    pub bias: Affine,
    /// The curves of a muscle, which replace gain and bias.
    #[cfg_attr(feature = "serde", serde(default, skip_serializing_if = "Option::is_none"))]
    pub muscle: Option<Muscle>,
    /// The torque by the poles of an electric motor, which the bounds of f do not limit.
    #[cfg_attr(feature = "serde", serde(default, skip_serializing_if = "Option::is_none"))]
    pub cogging: Option<Cogging>,
    /// The integral term of a controller, whose u is the setpoint of ℓ.
    #[cfg_attr(feature = "serde", serde(default, skip_serializing_if = "Option::is_none"))]
    pub integral: Option<IntegralAction>,
    /// The motor of which the sum of f and its integral term is the requested torque.
    #[cfg_attr(feature = "serde", serde(default, skip_serializing_if = "Option::is_none"))]
    pub motor: Option<ElectricMotor>,
    /// Whether f stands for a voltage R/K·f at the terminals of its motor or of the motor that it adds to.
    /// The bound on the voltage of the motor's controller does not limit it.
    #[cfg_attr(feature = "serde", serde(default, skip_serializing_if = "core::ops::Not::not"))]
    pub at_terminals: bool,
    /// The name of an earlier actuator on the same transmission to whose f the f of this one is added. The
    /// bounds of that actuator limit the sum, and f of this one is 0 then. This is a further input of a
    /// controller, such as its velocity setpoint.
    #[cfg_attr(feature = "serde", serde(default, skip_serializing_if = "Option::is_none"))]
    pub adds_to: Option<String>,
    /// The dynamics from the control to u.
    pub activation: Activation,
    /// Bounds of u with dynamics, at which it stops; infinite without.
    #[cfg_attr(
        feature = "serde",
        serde(
            default = "unbounded",
            skip_serializing_if = "is_unbounded",
            with = "crate::joint::numbers_or_infinity"
        )
    )]
    pub activation_range: [f64; 2],
    /// Bounds of the control; infinite for an unlimited one.
    #[cfg_attr(feature = "serde", serde(with = "crate::joint::numbers_or_infinity"))]
    pub control_range: [f64; 2],
    /// Bounds of f \[N·m or N\]; infinite for an unlimited force.
    #[cfg_attr(feature = "serde", serde(with = "crate::joint::numbers_or_infinity"))]
    pub force_range: [f64; 2],
}

impl ActuatorDescription {
    /// A motor, f = u, without bounds.
    ///
    /// ```
    /// use robot_dynamics::description::{ActuatorDescription, Transmission};
    /// let motor = ActuatorDescription::new("elbow_motor", Transmission::joint("elbow", 50.0));
    /// assert_eq!((motor.gain.constant, motor.bias.constant), (1.0, 0.0));
    /// ```
    pub fn new(name: impl Into<String>, transmission: Transmission) -> Self {
        Self {
            name: name.into(),
            transmission,
            gain: Affine::constant(1.0),
            bias: Affine::default(),
            muscle: None,
            cogging: None,
            integral: None,
            motor: None,
            at_terminals: false,
            adds_to: None,
            activation: Activation::None,
            activation_range: unbounded(),
            control_range: unbounded(),
            force_range: unbounded(),
        }
    }

    /// A position servo: f = stiffness·(u − ℓ) − damping·ℓ̇.
    ///
    /// ```
    /// use robot_dynamics::description::{ActuatorDescription, Transmission};
    /// let servo = ActuatorDescription::new("servo", Transmission::joint("elbow", 1.0)).servo(100.0, 5.0);
    /// assert_eq!(servo.force(0.5, 0.2, 0.1), 100.0 * (0.5 - 0.2) - 5.0 * 0.1);
    /// ```
    pub fn servo(self, stiffness: f64, damping: f64) -> Self {
        let bias = Affine { constant: 0.0, length: -stiffness, velocity: -damping };
        Self { gain: Affine::constant(stiffness), bias, ..self }
    }

    /// f for the control or activation u at this length and velocity, within its bounds. u itself is not
    /// clamped. States of a controller and of a motor are at 0, and the motor has no effect.
    ///
    /// ```
    /// use robot_dynamics::description::{ActuatorDescription, Transmission};
    /// let mut motor = ActuatorDescription::new("motor", Transmission::joint("elbow", 1.0));
    /// motor.force_range = [-2.0, 2.0];
    /// assert_eq!(motor.force(3.0, 0.0, 0.0), 2.0);
    /// ```
    pub fn force(&self, u: f64, length: f64, velocity: f64) -> f64 {
        self.bounded_force(self.unbounded_force(u, length, velocity), length)
    }

    /// A force within the bounds, with the cogging torque at this length.
    pub fn bounded_force(&self, force: f64, length: f64) -> f64 {
        let cogging = self.cogging.map_or(0.0, |cogging| cogging.torque(length));
        force.max(self.force_range[0]).min(self.force_range[1]) + cogging
    }

    /// f without its bounds and without cogging.
    pub fn unbounded_force(&self, u: f64, length: f64, velocity: f64) -> f64 {
        match &self.muscle {
            Some(muscle) => muscle.force(u, length, velocity),
            None => self.gain.at(length, velocity) * u + self.bias.at(length, velocity),
        }
    }
}

fn unbounded() -> [f64; 2] {
    [f64::NEG_INFINITY, f64::INFINITY]
}

#[cfg(feature = "serde")]
fn is_unbounded(range: &[f64; 2]) -> bool {
    *range == unbounded()
}

/// Optional fields and the activation range appear only if they act, because the fingerprint of a robot is
/// made of this text.
impl fmt::Debug for ActuatorDescription {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        let Self {
            name,
            transmission,
            gain,
            bias,
            muscle,
            cogging,
            integral,
            motor,
            at_terminals,
            adds_to,
            activation,
            activation_range,
            control_range,
            force_range,
        } = self;
        let mut text = f.debug_struct("ActuatorDescription");
        text.field("name", name).field("transmission", transmission).field("gain", gain).field("bias", bias);
        if let Some(muscle) = muscle {
            text.field("muscle", muscle);
        }
        if let Some(cogging) = cogging {
            text.field("cogging", cogging);
        }
        if let Some(integral) = integral {
            text.field("integral", integral);
        }
        if let Some(motor) = motor {
            text.field("motor", motor);
        }
        if *at_terminals {
            text.field("at_terminals", at_terminals);
        }
        if let Some(leader) = adds_to {
            text.field("adds_to", leader);
        }
        text.field("activation", activation);
        if *activation_range != unbounded() {
            text.field("activation_range", activation_range);
        }
        text.field("control_range", control_range).field("force_range", force_range).finish()
    }
}

/// The torque amplitude·sin(poles·ℓ + phase) of an electric motor, which depends on its position alone.
#[derive(Clone, Copy, Debug, Default, PartialEq)]
#[cfg_attr(feature = "serde", derive(Serialize, Deserialize))]
pub struct Cogging {
    /// The largest torque \[N·m\].
    pub amplitude: f64,
    /// Periods in a turn of the motor.
    pub poles: f64,
    /// The phase at ℓ = 0 \[rad\].
    pub phase: f64,
}

impl Cogging {
    /// The torque at this length \[N·m\].
    ///
    /// ```
    /// let cogging = robot_dynamics::description::Cogging { amplitude: 0.2, poles: 6.0, phase: 0.0 };
    /// assert!((cogging.torque(std::f64::consts::PI / 12.0) - 0.2).abs() < 1e-15);
    /// ```
    pub fn torque(&self, length: f64) -> f64 {
        self.amplitude * (self.poles * length + self.phase).sin()
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
    /// let servo = robot_dynamics::description::Affine { constant: 1.0, length: -2.0, velocity: -3.0 };
    /// assert_eq!(servo.at(0.5, 1.0), -3.0);
    /// ```
    pub fn at(&self, length: f64, velocity: f64) -> f64 {
        self.constant + self.length * length + self.velocity * velocity
    }
}

/// The coordinates that an actuator's force acts on.
#[derive(Clone, Debug, PartialEq)]
#[cfg_attr(feature = "serde", derive(Serialize, Deserialize))]
pub enum Transmission {
    /// The DoFs of a joint: ℓ̇ = gearᵀ v and τ = gear·f. ℓ is gear₀ q for a joint of one DoF, and 0 for a
    /// floating one. For a spherical joint it is the component of the rotation vector along the gear.
    Joint {
        /// Its name.
        joint: String,
        /// One number for each DoF, in the order of v; the remaining ones are not read.
        gear: [f64; 6],
    },
    /// A tendon: ℓ is gear times the tendon's.
    Tendon {
        /// Its name.
        tendon: String,
        /// The gear.
        gear: f64,
    },
    /// A wrench on a frame along the frame's axes, gear·f, linear before angular, as of a thruster. ℓ = 0,
    /// and ℓ̇ is gearᵀ times the frame's velocity.
    Frame {
        /// The name of a link or frame.
        frame: String,
        /// Force and moment for a unit f.
        gear: [f64; 6],
    },
    /// The DoFs of a spherical or floating joint along the axes of the joint's frame, which do not move with
    /// the child: τ = Rᵀ gear·f, where R is the child's rotation in the joint's frame. ℓ is as for
    /// [`Joint`](Self::Joint).
    JointInParent {
        /// Its name.
        joint: String,
        /// Linear before angular for a floating joint, angular alone for a spherical one.
        gear: [f64; 6],
        /// Whether the angular part is along the child's axes instead, as for a free joint of MuJoCo.
        moment_in_child: bool,
    },
    /// A wrench on a frame along the axes of a reference frame, and its opposite on the reference. It acts
    /// on the joints between both. ℓ is gearᵀ times the frame's position and rotation vector in the
    /// reference, and ℓ̇ is gearᵀ times its velocity along the same axes.
    RelativeFrame {
        /// The name of a link or frame.
        frame: String,
        /// The name of the link or frame of the reference.
        reference: String,
        /// Force and moment for a unit f.
        gear: [f64; 6],
    },
    /// The contacts of a link's own shapes, at which f pulls the link toward its partners along the normals,
    /// in equal parts. ℓ = 0. Method `mujoco` alone applies the force.
    Contacts {
        /// The name of the link.
        link: String,
    },
    /// A slider that moves a crank's pin by a rod. ℓ is gear times the slider's position along its z axis a,
    /// aᵀd − √((aᵀd)² + r² − dᵀd). The pin is at d from the slider's origin, and r is the rod's length. If
    /// the rod does not reach the pin, ℓ is gear·aᵀd.
    SliderCrank {
        /// The name of the frame of the pin.
        crank: String,
        /// The name of the frame whose z axis is the slider's.
        slider: String,
        /// r \[m\].
        rod_length: f64,
        /// The gear.
        gear: f64,
    },
}

impl Transmission {
    /// Acts on a joint of one DoF.
    ///
    /// ```
    /// use robot_dynamics::description::Transmission;
    /// let Transmission::Joint { gear, .. } = Transmission::joint("elbow", 50.0) else { unreachable!() };
    /// assert_eq!(gear[..2], [50.0, 0.0]);
    /// ```
    pub fn joint(joint: impl Into<String>, gear: f64) -> Self {
        Self::Joint { joint: joint.into(), gear: [gear, 0.0, 0.0, 0.0, 0.0, 0.0] }
    }

    /// The names of the links and frames that it refers to.
    ///
    /// ```
    /// use robot_dynamics::description::Transmission;
    /// let thrust = Transmission::Frame { frame: "rotor".into(), gear: [0.0, 0.0, 1.0, 0.0, 0.0, 0.1] };
    /// assert_eq!(thrust.frames().collect::<Vec<_>>(), ["rotor"]);
    /// ```
    pub fn frames(&self) -> impl Iterator<Item = &str> {
        let names = match self {
            Self::Frame { frame, .. } => [Some(frame), None],
            Self::RelativeFrame { frame, reference, .. } => [Some(frame), Some(reference)],
            Self::SliderCrank { crank, slider, .. } => [Some(crank), Some(slider)],
            Self::Joint { .. } | Self::JointInParent { .. } | Self::Tendon { .. } | Self::Contacts { .. } => {
                [None, None]
            }
        };
        names.into_iter().flatten().map(String::as_str)
    }
}
