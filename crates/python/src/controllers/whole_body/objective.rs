//! The objectives of tasks.

use pyo3::exceptions::PyTypeError;
use pyo3::prelude::*;
use robot_dynamics::algorithms::{SpatialAcceleration, Twist};
use robot_dynamics::constraints::SpatialAxis;
use robot_dynamics::control::whole_body::{ALL_AXES, Objective, PdGains};
use robot_dynamics::control::{PoseReference, Reference, TaskReference};

use crate::constraints::spatial_axes;
use crate::numbers::{configuration, halves, pose_of, several, shaped, vector, vector_or_zeros};
use crate::robot::Robot;

/// The objective that an object describes.
pub(super) fn objective_of(py: Python<'_>, robot: &Robot, object: &Bound<'_, PyAny>) -> PyResult<Objective> {
    let kind = object.getattr("_kind").and_then(|kind| kind.extract::<String>());
    let frame = || robot.frame_of(&object.getattr("frame")?);
    let number = |name: &str| object.getattr(name)?.extract::<f64>();
    Ok(match kind.as_deref() {
        Ok("frame_pose") => {
            let (_, pose) = shaped(py, "the target pose", &object.getattr("pose")?, &[4, 4])?;
            let [velocity, acceleration] = rates::<6>(object)?.map(halves);
            let reference = PoseReference {
                pose: pose_of(&pose),
                velocity: twist(velocity),
                acceleration: spatial_acceleration(acceleration),
            };
            Objective::FramePose { frame: frame()?, axes: axes(object)?, reference, gains: gains(object)? }
        }
        Ok("frame_velocity") => {
            let [velocity, acceleration] = rates::<6>(object)?.map(halves);
            Objective::FrameVelocity {
                frame: frame()?,
                axes: axes(object)?,
                velocity: twist(velocity),
                acceleration: spatial_acceleration(acceleration),
                damping: number("damping")?,
            }
        }
        Ok("center_of_mass") => {
            let position = several("the target position", &object.getattr("position")?)?;
            let [velocity, acceleration] = rates(object)?;
            let reference = TaskReference { position, velocity, acceleration };
            Objective::CenterOfMass { reference, gains: gains(object)? }
        }
        Ok("posture") => {
            let or_zeros = |name: &str| {
                let given = object.getattr(name)?;
                vector_or_zeros(py, robot, name, (!given.is_none()).then_some(&given))
            };
            let q = configuration(py, robot, &object.getattr("q")?)?;
            let reference = Reference { q, v: or_zeros("velocity")?, a: or_zeros("acceleration")? };
            Objective::Posture { reference, gains: gains(object)? }
        }
        Ok("angular_momentum") => Objective::AngularMomentum {
            momentum: several_or_zeros("momentum", object)?,
            rate: several_or_zeros("rate", object)?,
            damping: number("damping")?,
        },
        Ok("torque") => {
            Objective::Torque { torque: vector(py, robot, "the target torque", &object.getattr("torque")?)? }
        }
        Ok("contact_forces") => Objective::ContactForces,
        _ => {
            let found = object.get_type().name()?;
            let message = format!(
                "an objective must be a FramePose, FrameVelocity, CenterOfMass, Posture, AngularMomentum, Torque or \
                 ContactForces of robot_dynamics.whole_body, got {found}"
            );
            return Err(PyTypeError::new_err(message));
        }
    })
}

/// kp and kd; without kd the error decays without oscillation.
fn gains(object: &Bound<'_, PyAny>) -> PyResult<PdGains> {
    let critical = PdGains::critical(object.getattr("stiffness")?.extract()?);
    let damping: Option<f64> = object.getattr("damping")?.extract()?;
    Ok(damping.map_or(critical, |damping| PdGains { damping, ..critical }))
}

/// The directions of a frame; all without a choice.
fn axes(object: &Bound<'_, PyAny>) -> PyResult<Vec<SpatialAxis>> {
    let names: Option<Vec<String>> = object.getattr("rows")?.extract()?;
    names.map_or_else(|| Ok(ALL_AXES.to_vec()), |names| spatial_axes(&names))
}

/// The velocity and the acceleration of a target.
fn rates<const N: usize>(object: &Bound<'_, PyAny>) -> PyResult<[[f64; N]; 2]> {
    Ok([several_or_zeros("velocity", object)?, several_or_zeros("acceleration", object)?])
}

fn several_or_zeros<const N: usize>(name: &str, object: &Bound<'_, PyAny>) -> PyResult<[f64; N]> {
    let given = object.getattr(name)?;
    if given.is_none() { Ok([0.0; N]) } else { several(&format!("the target {name}"), &given) }
}

fn twist([linear, angular]: [[f64; 3]; 2]) -> Twist {
    Twist { linear, angular }
}

fn spatial_acceleration([linear, angular]: [[f64; 3]; 2]) -> SpatialAcceleration {
    SpatialAcceleration { linear, angular }
}
