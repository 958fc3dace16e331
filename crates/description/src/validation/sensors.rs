//! Checks of the sensors of a description: their objects and their numbers.

use super::checks::{check, index_names, unknown};
use super::names::Names;
use crate::sensor::ObjectSort;
use crate::{JointKind, ModelError, RobotDescription, SensorDescription, SensorKind, SensorObject, Shape};

pub(super) fn check_sensors(description: &RobotDescription, names: &Names<'_>) -> Result<(), ModelError> {
    index_names("sensor", description.sensors.iter().map(|sensor| sensor.name.as_str()))?;
    for sensor in &description.sensors {
        let owner = format!("sensor `{}`", sensor.name);
        check_object(description, names, sensor, &owner)?;
        if let Some(reference) = &sensor.reference {
            if !sensor.kind.takes_reference() {
                return Err(bad(sensor, "it takes no reference; remove it"));
            }
            check_frame(description, names, sensor, &owner, reference)?;
        } else if sensor.kind == SensorKind::InsideSite {
            return Err(bad(sensor, "it needs the frame of its zone as its reference"));
        }
        let is_bounded = |zone: &Shape| zone.volume().is_some();
        if sensor.zone.as_ref().is_some_and(|zone| !is_bounded(zone)) {
            return Err(bad(sensor, "its zone must be a box, ball, ellipsoid, cylinder or capsule"));
        }
        if sensor.kind == SensorKind::InsideSite && sensor.zone.is_none() {
            return Err(bad(sensor, "it needs a zone"));
        }
        for value in sensor.field {
            check(value.is_finite(), &owner, "magnetic field", value, "finite")?;
        }
        check(sensor.cutoff >= 0.0, &owner, "cutoff", sensor.cutoff, "zero or positive")?;
        check(sensor.noise >= 0.0, &owner, "noise", sensor.noise, "zero or positive")?;
    }
    Ok(())
}

fn bad(sensor: &SensorDescription, reason: impl Into<String>) -> ModelError {
    ModelError::BadSensor { sensor: sensor.name.clone(), kind: sensor.kind.name(), reason: reason.into() }
}

fn check_object(
    description: &RobotDescription,
    names: &Names<'_>,
    sensor: &SensorDescription,
    owner: &str,
) -> Result<(), ModelError> {
    let sort = sensor.kind.sort();
    let name = match &sensor.object {
        object if sort == ObjectSort::Frame => return check_frame(description, names, sensor, owner, object),
        SensorObject::Named(name) => name,
        SensorObject::Robot if sort == ObjectSort::Robot => return Ok(()),
        _ => "",
    };
    let (what, found) = match sort {
        ObjectSort::Robot => {
            return Err(bad(sensor, "it is of the robot as a whole and has no other object"));
        }
        ObjectSort::Joint | ObjectSort::Ball => ("joint", names.joints.contains_key(name)),
        ObjectSort::Tendon => ("tendon", description.tendon_names().any(|own| own == name)),
        ObjectSort::Actuator => ("actuator", description.actuators.iter().any(|own| own.name == *name)),
        ObjectSort::Frame | ObjectSort::Link => ("link", names.links.contains_key(name)),
    };
    if name.is_empty() {
        return Err(bad(sensor, format!("it needs the name of a {what}")));
    }
    if !found {
        return Err(unknown(owner, what, name));
    }
    let Some(joint) = names.joints.get(name).filter(|_| what == "joint") else { return Ok(()) };
    if sort == ObjectSort::Joint && joint.kind.nv() != 1 {
        let kind = joint.kind.name();
        return Err(bad(
            sensor,
            format!("joint `{name}` is {kind}; it needs a joint of one degree of freedom"),
        ));
    }
    if sort == ObjectSort::Ball && joint.kind != JointKind::Spherical {
        return Err(bad(
            sensor,
            format!("joint `{name}` is {}; it needs a spherical joint", joint.kind.name()),
        ));
    }
    if joint.mimic.is_some() && sensor.kind.needs_own_force() {
        return Err(bad(
            sensor,
            format!("joint `{name}` follows another, on which its forces act; name that"),
        ));
    }
    Ok(())
}

/// A frame or link, a link's centre of mass, or a shape.
fn check_frame(
    description: &RobotDescription,
    names: &Names<'_>,
    sensor: &SensorDescription,
    owner: &str,
    object: &SensorObject,
) -> Result<(), ModelError> {
    let (sort, name, found) = match object {
        SensorObject::Robot => return Err(bad(sensor, "it needs a frame, a link or a shape")),
        SensorObject::Named(name) => {
            let is_frame = description.frames.iter().any(|own| own.name == *name);
            ("frame or link", name, is_frame || names.links.contains_key(name.as_str()))
        }
        SensorObject::CenterOfMass(name) => ("link", name, names.links.contains_key(name.as_str())),
        SensorObject::Shape(name) => {
            let found = !name.is_empty() && description.shapes.iter().any(|own| own.name == *name);
            ("shape", name, found)
        }
    };
    if found { Ok(()) } else { Err(unknown(owner, sort, name)) }
}
