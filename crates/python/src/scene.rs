//! Scenes: robots and objects joined to one robot.

use pyo3::exceptions::PyValueError;
use pyo3::prelude::*;
use robot_dynamics::description::{JointKind, Mount, Object, Shape, Surface};

use crate::errors::exception;
use crate::numbers::{pose_of, shaped};
use crate::robot::Robot;

/// The scene that `robot_dynamics.Scene` builds.
#[pyclass(subclass, module = "robot_dynamics._native")]
#[derive(Debug)]
pub(crate) struct Scene {
    scene: robot_dynamics::description::Scene,
}

/// A joint by its name and its axis; a floating or spherical joint has no axis.
fn joint_kind(name: &str, axis: [f64; 3]) -> PyResult<JointKind> {
    Ok(match name {
        "fixed" => JointKind::Fixed,
        "floating" => JointKind::Floating,
        "spherical" => JointKind::Spherical,
        "revolute" => JointKind::Revolute { axis },
        "continuous" => JointKind::Continuous { axis },
        "prismatic" => JointKind::Prismatic { axis },
        "planar" => JointKind::Planar { normal: axis },
        _ => {
            return Err(PyValueError::new_err(format!(
                "joint is {name:?}; it must be fixed, floating, spherical, revolute, continuous, prismatic or planar"
            )));
        }
    })
}

/// A shape by its name and its lengths, as the methods `add_…` of `robot_dynamics.Scene` pass them.
fn shape_of(name: &str, lengths: &[f64]) -> PyResult<Shape> {
    Ok(match (name, lengths) {
        ("box", &[x, y, z]) => Shape::Box { size: [x, y, z] },
        ("sphere", &[radius]) => Shape::Sphere { radius },
        ("cylinder", &[radius, length]) => Shape::Cylinder { radius, length },
        ("capsule", &[radius, length]) => Shape::Capsule { radius, length },
        ("ellipsoid", &[x, y, z]) => Shape::Ellipsoid { half_axes: [x, y, z] },
        ("plane", []) => Shape::Plane { half_size: [0.0; 2] },
        _ => return Err(PyValueError::new_err(format!("no {name} has {} lengths", lengths.len()))),
    })
}

#[pymethods]
impl Scene {
    #[new]
    fn new(py: Python<'_>, name: String, gravity: &Bound<'_, PyAny>) -> PyResult<Self> {
        let (_, gravity) = shaped(py, "gravity", gravity, &[3])?;
        let scene = robot_dynamics::description::Scene::new(name);
        Ok(Self { scene: scene.with_gravity([gravity[0], gravity[1], gravity[2]]) })
    }

    /// See `add`. Returns the notes on what the scene does not take.
    fn _add(
        &mut self,
        py: Python<'_>,
        robot: &Robot,
        parent: &str,
        pose: &Bound<'_, PyAny>,
        joint: Option<&str>,
        axis: &Bound<'_, PyAny>,
        prefix: &str,
    ) -> PyResult<Vec<String>> {
        let (_, pose) = shaped(py, "at", pose, &[4, 4])?;
        let (_, axis) = shaped(py, "axis", axis, &[3])?;
        let mut mount = Mount::on(parent).with_pose(pose_of(&pose)).with_prefix(prefix);
        if let Some(joint) = joint {
            mount = mount.with_joint(joint_kind(joint, [axis[0], axis[1], axis[2]])?);
        }
        let before = self.scene.notes().len();
        let added = self.scene.add(robot.model.description(), &mount);
        added.map_err(exception)?;
        Ok(self.scene.notes()[before..].to_vec())
    }

    /// See `add_box` and the like.
    fn _add_object(
        &mut self,
        py: Python<'_>,
        name: &str,
        shape: &str,
        lengths: Vec<f64>,
        pose: &Bound<'_, PyAny>,
        mass: Option<f64>,
        density: Option<f64>,
        friction: Option<f64>,
    ) -> PyResult<()> {
        let (_, pose) = shaped(py, "at", pose, &[4, 4])?;
        let shape = shape_of(shape, &lengths)?;
        let object = match (mass, density) {
            (Some(_), Some(_)) => return Err(PyValueError::new_err("give mass or density, not both")),
            (Some(mass), None) => Object::of_mass(name, shape, mass),
            (None, Some(density)) => Object::of_density(name, shape, density),
            (None, None) => Object::fixed(name, shape),
        };
        let mut surface = Surface::default();
        if let Some(friction) = friction {
            surface.friction[0] = friction;
        }
        let added = self.scene.add_object(&object.with_surface(surface), pose_of(&pose));
        added.map_err(exception)
    }

    /// The scene as one robot: its description as JSON.
    fn _description(&self) -> PyResult<String> {
        let description = serde_json::to_string(self.scene.description());
        description.map_err(|error| PyValueError::new_err(error.to_string()))
    }
}
