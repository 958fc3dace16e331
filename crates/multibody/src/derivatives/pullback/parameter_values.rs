//! The numbers that the cotangents of parameters belong to: read off a robot, and a robot with others.

use dynamics::{InertiaError, MassProperties};
use nalgebra::{Matrix3, Vector3};
use thiserror::Error;

use super::parameters::{PASSIVE_PARAMETERS_PER_JOINT, parameter_count};
use crate::joint::kind::JointKind;
use crate::{Model, PARAMETERS_PER_LINK, PassiveForces, RobotDescription, inertial_parameters};

/// Why numbers are no parameters of a robot.
#[derive(Clone, Debug, PartialEq, Error)]
#[non_exhaustive]
pub enum ParameterError {
    /// More or fewer than the robot has.
    #[error("the robot has {expected} parameters, got {found}")]
    Count {
        /// [`parameter_count`].
        expected: usize,
        /// How many were given.
        found: usize,
    },
    /// A number that is not finite.
    #[error("parameter {index} is {value}; every number must be finite")]
    NonFinite {
        /// Which.
        index: usize,
        /// The number.
        value: f64,
    },
    /// A passive force of a floating base, which has none.
    #[error("`{joint}` is the floating base: it has no passive forces, its five parameters must be 0")]
    FloatingBase {
        /// The joint's name.
        joint: String,
    },
    /// No inertia at all.
    #[error("link `{link}`: {error}")]
    Inertia {
        /// The moving link.
        link: String,
        /// What is wrong with it.
        error: InertiaError,
    },
    /// Something outside carries another part of a fixed link's weight than of the moving link's, and which is which is lost.
    #[error(
        "link `{link}` is fixed to `{carrier}`, of whose weight another part is carried: they have no parameters together"
    )]
    Carried {
        /// The link.
        link: String,
        /// The moving link that it counts with.
        carrier: String,
    },
    /// A first moment without a mass.
    #[error("link `{link}` has mass 0 and a first moment m c that is not 0")]
    MomentWithoutMass {
        /// The moving link.
        link: String,
    },
}

/// The parameters of a robot as it was described, [`parameter_count`] of them, laid out as
/// [`ParameterCotangents`](crate::ParameterCotangents) says: π of the moving links, the passive forces of the joints, gravity.
///
/// ```
/// use multibody::{Model, parameter_values, pendulum};
/// let values = parameter_values(&Model::new(pendulum(2.0, 0.5))?);
/// assert_eq!(values[..4], [2.0, 1.0, 0.0, 0.0]); // m and m c
/// assert_eq!(values[15..], [0.0, 0.0, -9.81]);
/// # Ok::<(), Box<dyn std::error::Error>>(())
/// ```
pub fn parameter_values(model: &Model) -> Vec<f64> {
    let mut values = inertial_parameters(model);
    for joint in model.moving_joints() {
        let PassiveForces { armature, damping, friction, stiffness, rest } = joint.passive;
        values.extend([armature, damping, friction, stiffness, rest]);
    }
    values.extend(model.gravity());
    values
}

/// The description of the robot with other parameters, in the order of [`parameter_values`]; its geometry and limits stay.
///
/// What is fixed to a moving link counts with the link, so that the links fixed to it have no mass of their own in the
/// result. An inertia that no body has is taken as it is, as from a robot file;
/// [`physical_consistency`](crate::physical_consistency) finds them.
///
/// ```
/// use multibody::{Model, parameter_values, pendulum, with_parameters};
/// let model = Model::new(pendulum(2.0, 0.5))?;
/// let mut values = parameter_values(&model);
/// values[11] = 0.3; // damping of the hinge
/// let damped = Model::new(with_parameters(&model, &values)?)?;
/// assert_eq!(damped.joints()[0].passive.damping, 0.3);
/// assert_eq!(damped.inverse_dynamics(&[0.3], &[1.0], &[2.0])?, model.inverse_dynamics(&[0.3], &[1.0], &[2.0])?);
/// # Ok::<(), Box<dyn std::error::Error>>(())
/// ```
///
/// # Errors
/// [`ParameterError`] names the number or the link at fault.
pub fn with_parameters(model: &Model, values: &[f64]) -> Result<RobotDescription, ParameterError> {
    let expected = parameter_count(model);
    if values.len() != expected {
        return Err(ParameterError::Count { expected, found: values.len() });
    }
    if let Some(index) = values.iter().position(|x| !x.is_finite()) {
        return Err(ParameterError::NonFinite { index, value: values[index] });
    }
    let mut description = model.description().clone();
    let moving: Vec<&str> = model.moving_links().collect();
    let (inertial, rest) = values.split_at(PARAMETERS_PER_LINK * moving.len());
    let (passive, gravity) = rest.split_at(rest.len() - 3);
    description.gravity.copy_from_slice(gravity);
    for (joint, numbers) in model.moving_joints().zip(passive.chunks_exact(PASSIVE_PARAMETERS_PER_JOINT)) {
        let &[armature, damping, friction, stiffness, rest] = numbers else { continue };
        match description.joints.iter_mut().find(|own| own.name == joint.name) {
            Some(own) => own.passive = PassiveForces { armature, damping, friction, stiffness, rest },
            None if numbers.iter().all(|x| *x == 0.0) => {}
            None => return Err(ParameterError::FloatingBase { joint: joint.name.clone() }),
        }
    }
    let fixed_to = |child: &str| {
        let joints = &model.description().joints;
        let joint = joints.iter().find(|joint| joint.child == child && joint.kind == JointKind::Fixed);
        joint.map(|joint| joint.parent.as_str())
    };
    for link in &mut description.links {
        if let Some(k) = moving.iter().position(|name| *name == link.name) {
            let numbers = &inertial[k * PARAMETERS_PER_LINK..(k + 1) * PARAMETERS_PER_LINK];
            link.mass_properties = mass_properties(&link.name, numbers)?;
            continue;
        }
        let mut carrier = fixed_to(&link.name);
        while let Some(name) = carrier
            && !moving.contains(&name)
        {
            carrier = fixed_to(name);
        }
        // What hangs on the world keeps its mass, which nothing feels.
        if let Some(carrier) = carrier {
            let all = &model.description().links;
            let carried = all.iter().find(|own| own.name == carrier).map(|own| own.gravity_compensation);
            #[allow(clippy::float_cmp)] // as written
            if link.mass_properties.is_some() && carried != Some(link.gravity_compensation) {
                return Err(ParameterError::Carried { link: link.name.clone(), carrier: carrier.into() });
            }
            link.mass_properties = None;
        }
    }
    Ok(description)
}

/// The body of ten numbers: m, m c, and Ixx, Ixy, Iyy, Ixz, Iyz, Izz about the link's origin; none where all are 0.
fn mass_properties(link: &str, numbers: &[f64]) -> Result<Option<MassProperties>, ParameterError> {
    let &[mass, hx, hy, hz, xx, xy, yy, xz, yz, zz] = numbers else { return Ok(None) };
    if numbers.iter().all(|x| *x == 0.0) {
        return Ok(None);
    }
    let moment = Vector3::new(hx, hy, hz);
    if mass == 0.0 && moment != Vector3::zeros() {
        return Err(ParameterError::MomentWithoutMass { link: link.into() });
    }
    let center = if mass == 0.0 { moment } else { moment / mass };
    let about_origin = Matrix3::new(xx, xy, xz, xy, yy, yz, xz, yz, zz);
    // Steiner: I_c = I_o − m (|c|² 1 − c cᵀ).
    let shift = Matrix3::identity() * center.norm_squared() - center * center.transpose();
    let body = MassProperties::as_written(mass, center, about_origin - shift * mass);
    body.map(Some).map_err(|error| ParameterError::Inertia { link: link.into(), error })
}
