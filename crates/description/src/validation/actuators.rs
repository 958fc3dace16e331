//! Checks of the actuators of a description.

use super::checks::{check, check_range, index_names, unknown};
use super::names::Names;
use robot_dynamics_number::InvalidInput;

use crate::{
    Activation, ActuatorDescription, BristleFriction, Cogging, CurrentDynamics, Derating, ElectricMotor,
    JointKind, ModelError, Muscle, RobotDescription, Transmission,
};

const NOT_A_LEADER: &str =
    "`adds_to` must name an earlier actuator with the same transmission, which adds to no other";
const NOT_A_BALL: &str = "a force along the axes of the joint's frame needs a spherical or floating joint; \
                          use the transmission `Joint` for this one";

pub(super) fn check_actuators(description: &RobotDescription, names: &Names<'_>) -> Result<(), ModelError> {
    index_names("actuator", description.actuators.iter().map(|actuator| actuator.name.as_str()))?;
    for (index, actuator) in description.actuators.iter().enumerate() {
        check_leader(&description.actuators[..index], actuator)?;
        let owner = format!("actuator `{}`", actuator.name);
        let gear = check_transmission(description, names, actuator)?;
        let laws = [actuator.gain, actuator.bias];
        let numbers = laws.iter().flat_map(|law| [law.constant, law.length, law.velocity]);
        for number in gear.iter().copied().chain(numbers) {
            check(number.is_finite(), &owner, "gear, gain or bias", number, "finite")?;
        }
        if let Some(Cogging { amplitude, poles, phase }) = actuator.cogging {
            for number in [amplitude, poles, phase] {
                check(number.is_finite(), &owner, "cogging", number, "finite")?;
            }
        }
        check_activation(&owner, &actuator.activation)?;
        if let Some(integral) = actuator.integral {
            check(integral.gain.is_finite(), &owner, "integral gain", integral.gain, "finite")?;
            check(integral.limit > 0.0, &owner, "limit of the integral", integral.limit, "positive")?;
        }
        if let Some(motor) = &actuator.motor {
            check_motor(&owner, motor)?;
        }
        if let Some(muscle) = &actuator.muscle {
            check_muscle(&owner, muscle)?;
        }
        check_range(&owner, "activation range", actuator.activation_range)?;
        check_range(&owner, "control range", actuator.control_range)?;
        check_range(&owner, "force range", actuator.force_range)?;
    }
    Ok(())
}

/// Checks the actuator that an actuator adds to, among those before it.
fn check_leader(earlier: &[ActuatorDescription], actuator: &ActuatorDescription) -> Result<(), ModelError> {
    let Some(name) = &actuator.adds_to else { return Ok(()) };
    let leader = earlier.iter().find(|own| own.name == *name);
    let is_valid =
        leader.is_some_and(|leader| leader.adds_to.is_none() && leader.transmission == actuator.transmission);
    if is_valid {
        return Ok(());
    }
    Err(ModelError::Transmission { actuator: actuator.name.clone(), problem: NOT_A_LEADER })
}

/// Checks the names and returns the gear.
fn check_transmission<'a>(
    description: &RobotDescription,
    names: &Names<'_>,
    actuator: &'a ActuatorDescription,
) -> Result<&'a [f64], ModelError> {
    let ActuatorDescription { name: actuator, transmission, .. } = actuator;
    let owner = &format!("actuator `{actuator}`");
    for frame in transmission.frames() {
        if !description.frames.iter().any(|own| own.name == *frame) {
            names.link(owner, frame)?;
        }
    }
    Ok(match transmission {
        Transmission::Joint { joint, gear } => {
            names.joints.get(joint.as_str()).ok_or_else(|| unknown(owner, "joint", joint))?;
            gear
        }
        Transmission::JointInParent { joint, gear, .. } => {
            let found = names.joints.get(joint.as_str()).ok_or_else(|| unknown(owner, "joint", joint))?;
            if !matches!(found.kind, JointKind::Spherical | JointKind::Floating | JointKind::Fixed) {
                return Err(ModelError::Transmission { actuator: actuator.into(), problem: NOT_A_BALL });
            }
            gear
        }
        Transmission::Tendon { tendon, gear } => {
            let found = description.tendon_names().any(|own| own == tendon);
            if !found {
                return Err(unknown(owner, "tendon", tendon));
            }
            core::slice::from_ref(gear)
        }
        Transmission::Contacts { link } => {
            names.link(owner, link)?;
            &[]
        }
        Transmission::Frame { gear, .. } | Transmission::RelativeFrame { gear, .. } => gear,
        Transmission::SliderCrank { rod_length, gear, .. } => {
            let is_valid = *rod_length > 0.0 && rod_length.is_finite();
            check(is_valid, owner, "length of the rod", *rod_length, "positive and finite")?;
            core::slice::from_ref(gear)
        }
    })
}

fn check_activation(owner: &str, activation: &Activation) -> Result<(), ModelError> {
    match *activation {
        Activation::None | Activation::Integrator => Ok(()),
        Activation::Filter { time_constant } => {
            check(time_constant > 0.0, owner, "time constant", time_constant, "positive")
        }
        Activation::RateLimit { rate } => check(rate > 0.0, owner, "limit of the rate", rate, "positive"),
        Activation::Muscle { rise, fall, width } => {
            for time_constant in [rise, fall] {
                let is_valid = time_constant > 0.0 && time_constant.is_finite();
                check(is_valid, owner, "time constant", time_constant, "positive and finite")?;
            }
            check(width >= 0.0, owner, "width of the change of its time constants", width, "zero or positive")
        }
    }
}

pub(crate) fn check_motor(owner: &str, motor: &ElectricMotor) -> Result<(), ModelError> {
    let positive = |quantity, value: f64| {
        check(value > 0.0 && value.is_finite(), owner, quantity, value, "positive and finite")
    };
    positive("resistance", motor.resistance)?;
    positive("motor constant", motor.constant)?;
    check(motor.voltage_limit > 0.0, owner, "voltage limit", motor.voltage_limit, "positive")?;
    check(motor.current_limit > 0.0, owner, "current limit", motor.current_limit, "positive")?;
    if let Some(Derating { start, end }) = motor.derating {
        let is_finite = start.is_finite() && end.is_finite();
        check(is_finite && start < end, owner, "end of the derating", end, "above its start")?;
        let limit = motor.current_limit;
        check(limit.is_finite(), owner, "current limit with derating", limit, "finite")?;
        if motor.winding.is_none() {
            return Err(InvalidInput::unmet(format!("the derating of {owner}"), "needs a winding").into());
        }
    }
    if let Some(CurrentDynamics { time_constant, rate_limit }) = motor.current {
        positive("time constant of the current", time_constant)?;
        check(rate_limit > 0.0, owner, "limit of the rate of the current", rate_limit, "positive")?;
    }
    if let Some(winding) = motor.winding {
        positive("thermal resistance", winding.resistance)?;
        positive("thermal capacity", winding.capacity)?;
        for number in [winding.coefficient, winding.reference, winding.ambient] {
            check(number.is_finite(), owner, "temperature or its coefficient", number, "finite")?;
        }
    }
    if let Some(friction) = motor.friction {
        positive("stiffness of bristles", friction.stiffness)?;
        let BristleFriction { damping, coulomb, static_friction, stribeck_velocity, .. } = friction;
        for number in [damping, coulomb, static_friction, stribeck_velocity] {
            check(number >= 0.0, owner, "friction by bristles", number, "zero or positive")?;
        }
    }
    Ok(())
}

fn check_muscle(owner: &str, muscle: &Muscle) -> Result<(), ModelError> {
    let Muscle {
        peak_force,
        length_range,
        range,
        active_range: [shortest, longest],
        shortening_velocity,
        passive_force,
        lengthening_force,
    } = *muscle;
    for ([lower, upper], quantity) in [(length_range, "length range"), (range, "operating range")] {
        let is_valid = lower < upper && (upper - lower).is_finite();
        check(is_valid, owner, quantity, upper - lower, "an interval of positive length")?;
    }
    for (is_valid, quantity, value, expected) in [
        (peak_force.is_finite(), "peak force", peak_force, "finite"),
        (shortest < 1.0, "shortest active length", shortest, "below the optimal length 1"),
        (longest > 1.0, "longest active length", longest, "above the optimal length 1"),
        (shortening_velocity > 0.0, "velocity of shortening", shortening_velocity, "positive"),
        (passive_force.is_finite(), "passive force", passive_force, "finite"),
        (lengthening_force >= 1.0, "force of lengthening", lengthening_force, "at least 1"),
    ] {
        check(is_valid, owner, quantity, value, expected)?;
    }
    Ok(())
}
