//! Robots derived from another robot by adding, removing or moving parts.

use pyo3::exceptions::PyValueError;
use pyo3::prelude::*;
use robot_dynamics::description::{
    CurrentDynamics, Derating, EditNote, ElectricMotor, JointDescription, JointElasticity, JointKind, Limits,
    LinkDescription, MassProperties, ModelError, MotorDrive, Mount, RobotDescription, WindingTemperature,
};
use robot_dynamics::nalgebra::{Matrix3, Vector3};

use crate::errors::{Class, exception};
use crate::numbers::{self, pose_of, shaped};
use crate::robot::Robot;

/// Kind, axis, second axis and pitch of a joint.
pub(crate) type JointWords = (String, [f64; 3], [f64; 3], f64);

/// The joint of these words.
pub(crate) fn joint_kind((name, axis, second, pitch): &JointWords) -> PyResult<JointKind> {
    JointKind::named(name, *axis, *second, *pitch).ok_or_else(|| {
        PyValueError::new_err(format!(
            "joint is {name:?}; it must be fixed, revolute, continuous, prismatic, helical, universal, planar, \
             spherical or floating"
        ))
    })
}

/// Mass properties; an inertia of 0 without one.
pub(crate) fn mass_properties(
    py: Python<'_>,
    mass: f64,
    center_of_mass: &Bound<'_, PyAny>,
    inertia: Option<&Bound<'_, PyAny>>,
) -> PyResult<MassProperties> {
    let (_, center) = shaped(py, "center_of_mass", center_of_mass, &[3])?;
    let moments = match inertia {
        Some(inertia) => numbers::matrix(py, "inertia", inertia)?,
        None => robot_dynamics::nalgebra::DMatrix::zeros(3, 3),
    };
    if moments.shape() != (3, 3) {
        return Err(Class::Shape.error(py, "inertia must have shape (3, 3)"));
    }
    let moments = Matrix3::from_fn(|i, j| moments[(i, j)]);
    MassProperties::new(mass, Vector3::from_row_slice(&center), moments).map_err(exception)
}

/// The place of a robot or an object.
pub(crate) fn mount(
    py: Python<'_>,
    parent: &str,
    pose: &Bound<'_, PyAny>,
    joint: Option<JointWords>,
) -> PyResult<Mount> {
    let (_, pose) = shaped(py, "at", pose, &[4, 4])?;
    let mount = Mount::on(parent).with_pose(pose_of(&pose));
    match joint {
        Some(joint) => Ok(mount.with_joint(joint_kind(&joint)?)),
        None => Ok(mount),
    }
}

/// Resistance, constant, limits of voltage and current, the time constant of the current, the thermal model,
/// and derating.
type MotorWords = (f64, f64, f64, f64, Option<f64>, Option<[f64; 5]>, Option<[f64; 2]>);

type Noted = (String, Vec<String>);

impl Robot {
    /// The state of a robot with another description, and the notes of the edit.
    fn edited_with_notes(
        &self,
        edit: impl FnOnce(&mut RobotDescription) -> Result<Vec<EditNote>, ModelError>,
    ) -> PyResult<Noted> {
        let mut description = self.model.description().clone();
        let notes = edit(&mut description).map_err(exception)?;
        Ok((self.state_of(&description)?, notes.iter().map(ToString::to_string).collect()))
    }
}

#[pymethods]
impl Robot {
    /// See `with_frame`.
    fn _with_frame(
        &self,
        py: Python<'_>,
        name: &str,
        parent: &str,
        pose: &Bound<'_, PyAny>,
    ) -> PyResult<String> {
        let (_, pose) = shaped(py, "at", pose, &[4, 4])?;
        self.edited(|description| description.add_frame(name, parent, pose_of(&pose)))
    }

    /// See `with_link`.
    fn _with_link(
        &self,
        py: Python<'_>,
        name: &str,
        parent: &str,
        pose: &Bound<'_, PyAny>,
        joint: JointWords,
        joint_name: &str,
        limits: (f64, f64, f64, f64),
        mass: Option<f64>,
        center_of_mass: &Bound<'_, PyAny>,
        inertia: Option<&Bound<'_, PyAny>>,
    ) -> PyResult<String> {
        let (_, pose) = shaped(py, "at", pose, &[4, 4])?;
        let body = mass.map(|mass| mass_properties(py, mass, center_of_mass, inertia)).transpose()?;
        let (lower, upper, velocity, effort) = limits;
        let limits = Limits::new(lower, upper).with_velocity(velocity).with_effort(effort);
        let joint = JointDescription::new(joint_name, joint_kind(&joint)?, parent, name, pose_of(&pose));
        let joint = joint.with_limits(limits);
        self.edited(|description| description.add_link(LinkDescription::new(name, body), joint))
    }

    /// See `with_inertia`.
    fn _with_inertia(
        &self,
        py: Python<'_>,
        link: &str,
        mass: f64,
        center_of_mass: &Bound<'_, PyAny>,
        inertia: Option<&Bound<'_, PyAny>>,
    ) -> PyResult<String> {
        let body = mass_properties(py, mass, center_of_mass, inertia)?;
        self.edited(|description| description.set_mass_properties(link, body))
    }

    /// See `with_mass_scaled`.
    fn _with_mass_scaled(&self, factor: f64, link: Option<&str>) -> PyResult<String> {
        self.edited(|description| match link {
            Some(link) => description.scale_mass(link, factor),
            None => description.scale_masses(factor),
        })
    }

    /// See `with_root`.
    fn _with_root(&self, link: &str) -> PyResult<Noted> {
        self.edited_with_notes(|description| description.set_root(link))
    }

    /// See `without_joint`.
    fn _without_joint(&self, joint: &str) -> PyResult<Noted> {
        self.edited_with_notes(|description| description.remove_joint(joint))
    }

    /// See `without_equality`.
    fn _without_equality(&self, equality: &str) -> PyResult<Noted> {
        self.edited_with_notes(|description| description.remove_equality(equality))
    }

    /// See `with_attached`.
    fn _with_attached(
        &self,
        py: Python<'_>,
        robot: &Robot,
        parent: &str,
        pose: &Bound<'_, PyAny>,
        joint: Option<JointWords>,
        prefix: &str,
    ) -> PyResult<Noted> {
        let mount = mount(py, parent, pose, joint)?.with_prefix(prefix);
        self.edited_with_notes(|description| description.attach(robot.model.description(), &mount))
    }

    /// See `with_motor`.
    fn _with_motor(&self, joint: &str, drive: (f64, f64), motor: MotorWords) -> PyResult<String> {
        let ((gear, inertia), (resistance, constant, voltage_limit, current_limit, ..)) = (drive, motor);
        let mut own =
            ElectricMotor { voltage_limit, current_limit, ..ElectricMotor::new(resistance, constant) };
        let (.., time_constant, thermal, derating) = motor;
        own.current =
            time_constant.map(|time_constant| CurrentDynamics { time_constant, rate_limit: f64::INFINITY });
        own.winding = thermal.map(|[resistance, capacity, coefficient, reference, ambient]| {
            WindingTemperature { resistance, capacity, coefficient, reference, ambient }
        });
        own.derating = derating.map(|[start, end]| Derating { start, end });
        self.edited(|description| description.add_motor(joint, &MotorDrive::new(own, gear, inertia)))
    }

    /// See `with_elastic_joint`.
    fn _with_elastic_joint(
        &self,
        joint: &str,
        stiffness: f64,
        damping: f64,
        backlash: f64,
    ) -> PyResult<Noted> {
        let mut elasticity = JointElasticity::new(stiffness, damping);
        elasticity.backlash = backlash;
        self.edited_with_notes(|description| description.add_joint_elasticity(joint, &elasticity))
    }

    /// See `with_subtree_replaced`.
    fn _with_subtree_replaced(&self, joint: &str, robot: &Robot, prefix: &str) -> PyResult<Noted> {
        self.edited_with_notes(|description| {
            description.replace_subtree(joint, robot.model.description(), prefix)
        })
    }
}
