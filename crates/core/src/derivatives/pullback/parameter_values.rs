//! The parameters of a robot as a vector, and the robot with other parameters.

use nalgebra::{Matrix3, Vector3};
use robot_dynamics_description::{JointKind, MassProperties, ModelError, PassiveForces, RobotDescription};
use robot_dynamics_number::{InputProblem, InvalidInput, check_finite};

use super::parameters::{PASSIVE_PARAMETERS_PER_JOINT, parameter_count};
use crate::{Model, PARAMETERS_PER_LINK, inertial_parameters};

/// The parameters of a robot as described: π of the moving links, the passive forces of the joints, gravity.
/// They are [`parameter_count`] numbers in the layout of [`ParameterCotangents`](crate::ParameterCotangents).
///
/// ```
/// use robot_dynamics::derivatives::parameter_values;
/// use robot_dynamics::description::pendulum;
/// use robot_dynamics::model::Model;
/// let values = parameter_values(&Model::new(pendulum(2.0, 0.5))?);
/// assert_eq!(values[..4], [2.0, 1.0, 0.0, 0.0]); // m and m c
/// assert_eq!(values[15..], [0.0, 0.0, -9.81]);
/// # Ok::<(), Box<dyn std::error::Error>>(())
/// ```
pub fn parameter_values(model: &Model) -> Vec<f64> {
    let mut values = inertial_parameters(model);
    for joint in model.moving_joints() {
        let PassiveForces { armature, damping, friction, stiffness, rest, .. } = joint.passive;
        values.extend([armature, damping, friction, stiffness, rest]);
    }
    values.extend(model.gravity());
    values
}

/// The description of the robot with other parameters, in the order of [`parameter_values`]. Geometry and
/// limits stay the same.
///
/// The parameters of a moving link include the links fixed to it, so these have no mass of their own in the
/// result. An inertia that no physical body has is accepted, as from a robot file; `physical_consistency`
/// detects it.
///
/// ```
/// use robot_dynamics::derivatives::{parameter_values, with_parameters};
/// use robot_dynamics::description::pendulum;
/// use robot_dynamics::model::Model;
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
/// [`ModelError`] names the number or the link at fault.
pub fn with_parameters(model: &Model, values: &[f64]) -> Result<RobotDescription, ModelError> {
    let expected = parameter_count(model);
    if values.len() != expected {
        let (owner, hint) = (format!("robot `{}`", model.name()), "");
        let problem = InputProblem::WrongLength { found: values.len(), expected, owner, hint };
        return Err(InvalidInput::new("the list of parameters", problem).into());
    }
    check_finite("parameters", values)?;
    let mut description = model.description().clone();
    let moving: Vec<&str> = model.moving_links().collect();
    let (inertial, rest) = values.split_at(PARAMETERS_PER_LINK * moving.len());
    let (passive, gravity) = rest.split_at(rest.len() - 3);
    description.gravity.copy_from_slice(gravity);
    for (joint, numbers) in model.moving_joints().zip(passive.chunks_exact(PASSIVE_PARAMETERS_PER_JOINT)) {
        let &[armature, damping, friction, stiffness, rest] = numbers else { continue };
        match description.joints.iter_mut().find(|own| own.name == joint.name) {
            Some(own) => {
                let passive = &mut own.passive;
                (passive.armature, passive.damping, passive.friction) = (armature, damping, friction);
                (passive.stiffness, passive.rest) = (stiffness, rest);
            }
            None if numbers.iter().all(|x| *x == 0.0) => {}
            None => return Err(ModelError::FloatingBase { joint: joint.name.clone() }),
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
        // Links fixed to the world keep their mass, which affects no motion.
        if let Some(carrier) = carrier {
            let all = &model.description().links;
            let carried = all.iter().find(|own| own.name == carrier).map(|own| own.gravity_compensation);
            #[allow(clippy::float_cmp)] // as written
            if link.mass_properties.is_some() && carried != Some(link.gravity_compensation) {
                return Err(ModelError::Carried { link: link.name.clone(), carrier: carrier.into() });
            }
            link.mass_properties = None;
        }
    }
    Ok(description)
}

/// The mass properties for ten numbers: m, m c, and Ixx, Ixy, Iyy, Ixz, Iyz, Izz about the link's origin.
/// `None` if all are 0.
fn mass_properties(link: &str, numbers: &[f64]) -> Result<Option<MassProperties>, ModelError> {
    let &[mass, hx, hy, hz, xx, xy, yy, xz, yz, zz] = numbers else { return Ok(None) };
    if numbers.iter().all(|x| *x == 0.0) {
        return Ok(None);
    }
    let moment = Vector3::new(hx, hy, hz);
    if mass == 0.0 && moment != Vector3::zeros() {
        return Err(ModelError::MomentWithoutMass { link: link.into() });
    }
    let center = if mass == 0.0 { moment } else { moment / mass };
    let about_origin = Matrix3::new(xx, xy, xz, xy, yy, yz, xz, yz, zz);
    // Steiner: I_c = I_o − m (|c|² 1 − c cᵀ).
    let shift = Matrix3::identity() * center.norm_squared() - center * center.transpose();
    let body = MassProperties::as_written(mass, center, about_origin - shift * mass);
    body.map(Some).map_err(|error| ModelError::Inertia { link: link.into(), error })
}
