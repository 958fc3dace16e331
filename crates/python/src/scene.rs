//! Scenes: robots and objects joined to one robot.

use std::path::PathBuf;

use pyo3::exceptions::PyValueError;
use pyo3::prelude::*;
use robot_dynamics::description::{Mount, Object, Shape};
use robot_dynamics::{MeshMass, MeshSolid, mesh_object};

use crate::edits::{JointWords, mass_properties, mount};
use crate::errors::exception;
use crate::numbers::shaped;
use crate::robot::Robot;

/// The scene that `robot_dynamics.Scene` builds.
#[pyclass(subclass, module = "robot_dynamics._native")]
#[derive(Debug)]
pub(crate) struct Scene {
    scene: robot_dynamics::description::Scene,
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
        joint: Option<JointWords>,
        prefix: &str,
    ) -> PyResult<Vec<String>> {
        let mount = mount(py, parent, pose, joint)?.with_prefix(prefix);
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
        parent: &str,
        pose: &Bound<'_, PyAny>,
        joint: Option<JointWords>,
        mass: Option<f64>,
        density: Option<f64>,
        friction: Option<f64>,
    ) -> PyResult<()> {
        let object = match shape {
            "table" | "wall" if mass.is_some() || density.is_some() => {
                return Err(PyValueError::new_err(format!("a {shape} is fixed and has no mass")));
            }
            "table" => Object::table(name, [lengths[0], lengths[1], lengths[2]]),
            "wall" => {
                let ends = [[lengths[0], lengths[1]], [lengths[2], lengths[3]]];
                Object::wall(name, ends, lengths[4], lengths[5])
            }
            _ => {
                let shape = shape_of(shape, &lengths)?;
                match (mass, density) {
                    (Some(_), Some(_)) => {
                        return Err(PyValueError::new_err("give mass or density, not both"));
                    }
                    (Some(mass), None) => Object::of_mass(name, shape, mass),
                    (None, Some(density)) => Object::of_density(name, shape, density),
                    (None, None) => Object::fixed(name, shape),
                }
            }
        };
        self.add_object(object, friction, mount(py, parent, pose, joint)?)
    }

    /// See `add_mesh`.
    fn _add_mesh(
        &mut self,
        py: Python<'_>,
        name: &str,
        path: PathBuf,
        scale: [f64; 3],
        parent: &str,
        pose: &Bound<'_, PyAny>,
        joint: Option<JointWords>,
        mass: Option<f64>,
        density: Option<f64>,
        center_of_mass: &Bound<'_, PyAny>,
        inertia: Option<&Bound<'_, PyAny>>,
        solid: &str,
        friction: Option<f64>,
    ) -> PyResult<()> {
        let mass = match (mass, density, inertia) {
            (None, None, None) => MeshMass::Fixed,
            (Some(mass), None, None) => MeshMass::Mass(mass),
            (None, Some(density), None) => MeshMass::Density(density),
            (Some(mass), None, Some(inertia)) => {
                MeshMass::Given(mass_properties(py, mass, center_of_mass, Some(inertia))?)
            }
            _ => return Err(PyValueError::new_err("give mass, density, or mass and inertia")),
        };
        let solid = match solid {
            "exact" => MeshSolid::Exact,
            "hull" => MeshSolid::Hull,
            _ => return Err(PyValueError::new_err(format!("solid is {solid:?}; it must be exact or hull"))),
        };
        let object = py.detach(|| mesh_object(name, path, scale, mass, solid)).map_err(exception)?;
        self.add_object(object, friction, mount(py, parent, pose, joint)?)
    }

    /// The scene as one robot: its description as JSON.
    fn _description(&self) -> PyResult<String> {
        let description = serde_json::to_string(self.scene.description());
        description.map_err(|error| PyValueError::new_err(error.to_string()))
    }
}

impl Scene {
    fn add_object(&mut self, object: Object, friction: Option<f64>, mount: Mount) -> PyResult<()> {
        let object = match friction {
            Some(friction) => object.with_friction(friction),
            None => object,
        };
        self.scene.add_object(&object, mount).map_err(exception)
    }
}
