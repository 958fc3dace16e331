//! The robot as Python holds it.

use std::collections::HashMap;
use std::path::PathBuf;
use std::sync::{Mutex, OnceLock};

use pyo3::exceptions::{PyIndexError, PyTypeError, PyValueError};
use pyo3::prelude::*;
use pyo3::pybacked::PyBackedBytes;
use pyo3::types::PyString;
use robot_dynamics::description::{LoadReport, RobotDescription};
use robot_dynamics::model::{FrameId, Model};
use robot_dynamics::plausibility::WrittenAngles;
use robot_dynamics::simulation::{SensorSet, Simulation};
use robot_dynamics::{
    LoadOptions, LoadedDescription, Srdf, load_description, load_description_from_files,
    load_description_from_text, with_native_code,
};

use crate::assets::file_set;
use crate::errors::{Class, exception};
use crate::ffi::ArrayNumber;
use crate::scratch::{Batch, Scratch, Slots};
use crate::simulation::options::Setup;

/// A robot: immutable, to be used by any number of threads at once. `robot_dynamics.load` makes one.
#[pyclass(frozen, subclass, module = "robot_dynamics._native")]
#[derive(Debug)]
pub struct Robot {
    pub(crate) model: Model,
    pub(crate) report: LoadReport,
    /// Angles as the file writes them; empty for a robot made from its state.
    pub(crate) angles: Vec<WrittenAngles>,
    /// All frames, in their order.
    pub(crate) frames: Vec<FrameId>,
    by_name: HashMap<String, usize>,
    /// Where quaternions begin in q.
    pub(crate) quaternions: Vec<usize>,
    /// Whether some link that a joint carries has moments that leave M no margin. A check of M then precedes
    /// each inverse.
    pub(crate) watches_rank: bool,
    /// The reason why M is singular in every configuration, if it is.
    pub(crate) massless: Option<String>,
    /// Made at the first use.
    pub(crate) sensors: OnceLock<SensorSet>,
    /// The simulation of the last rollout, with its arguments.
    pub(crate) prepared: Mutex<Option<Box<(Setup, Simulation)>>>,
    pub(crate) scratch: Slots<Scratch>,
    pub(crate) batches_f64: Slots<Batch<f64>>,
    pub(crate) batches_f32: Slots<Batch<f32>>,
}

/// Robots that come with the package; `build.rs` copies their files.
const EXAMPLES: [(&str, &str); 6] = [
    ("two_r", include_str!(concat!(env!("OUT_DIR"), "/two_r.urdf"))),
    ("ur5", include_str!(concat!(env!("OUT_DIR"), "/ur5.urdf"))),
    ("panda", include_str!(concat!(env!("OUT_DIR"), "/panda.urdf"))),
    ("quadruped", include_str!(concat!(env!("OUT_DIR"), "/quadruped.urdf"))),
    ("humanoid", include_str!(concat!(env!("OUT_DIR"), "/humanoid.urdf"))),
    ("gripper_and_box", include_str!(concat!(env!("OUT_DIR"), "/gripper_and_box.xml"))),
];

/// The file of a robot that comes with the package, as text.
#[pyfunction]
pub(crate) fn example_text(name: &str) -> PyResult<&'static str> {
    let found = EXAMPLES.into_iter().find(|(own, _)| *own == name);
    found.map(|(_, text)| text).ok_or_else(|| {
        let names: Vec<_> = EXAMPLES.iter().map(|(name, _)| *name).collect();
        PyValueError::new_err(format!("there is no example robot {name:?}; there are {}", names.join(", ")))
    })
}

/// Where quaternions begin in q: of the joints with a number more in q than in v.
fn quaternions_of(model: &Model) -> Vec<usize> {
    let joints = model.joints().iter().filter(|joint| joint.nq > joint.nv);
    joints.map(|joint| joint.q_index + joint.nq - 4).collect()
}

impl Robot {
    fn made(py: Python<'_>, described: LoadedDescription) -> PyResult<Self> {
        let angles = described.angles.clone();
        let robot = described.compile().map_err(|error| Class::Load.error(py, error))?;
        Ok(Self { angles, ..Self::of(robot.model, robot.report) })
    }

    pub(crate) fn of(model: Model, report: LoadReport) -> Self {
        let by_name: HashMap<String, usize> =
            model.frames().iter().enumerate().rev().map(|(k, frame)| (frame.name.clone(), k)).collect();
        // Frames are looked up by name, as in the library: of two frames with one name, the first counts.
        let frames = model.frames().iter().filter_map(|frame| model.frame(&frame.name)).collect();
        let names: Vec<&str> = model.massless_joints().collect();
        let massless = (!names.is_empty()).then(|| {
            format!(
                "M(q) is singular: {} of robot `{}` move no inertia; hold them still with `lock` or `lock_massless`",
                names.join(", "),
                model.name()
            )
        });
        Self {
            by_name,
            frames,
            quaternions: quaternions_of(&model),
            watches_rank: !model.is_always_regular(),
            massless,
            sensors: OnceLock::new(),
            prepared: Mutex::new(None),
            scratch: Slots::new(),
            batches_f64: Slots::new(),
            batches_f32: Slots::new(),
            report,
            angles: Vec::new(),
            model,
        }
    }

    /// The result of `_state` with another description.
    pub(crate) fn state_of(&self, description: &RobotDescription) -> PyResult<String> {
        let state = (description, &self.report);
        serde_json::to_string(&state).map_err(|error| PyValueError::new_err(error.to_string()))
    }

    /// Whether each quaternion in a configuration has unit length, to 1e-6 as the library asks.
    #[inline]
    pub(crate) fn has_unit_quaternions<T: ArrayNumber>(&self, q: &[T]) -> bool {
        self.quaternions.iter().all(|&first| {
            let squared: f64 = q[first..first + 4].iter().map(|x| x.double() * x.double()).sum();
            (squared.sqrt() - 1.0).abs() <= 1e-6
        })
    }

    /// A frame by its name or its index.
    pub(crate) fn frame_of(&self, frame: &Bound<'_, PyAny>) -> PyResult<FrameId> {
        if let Ok(name) = frame.cast::<PyString>()
            && let Ok(name) = name.to_cow()
        {
            return match self.by_name.get(&*name) {
                Some(&index) => Ok(self.frames[index]),
                None => match self.model.frame_named(&name) {
                    Ok(frame) => Ok(frame),
                    Err(error) => Err(exception(error)),
                },
            };
        }
        let index: i64 = frame.extract().map_err(|_| {
            PyTypeError::new_err("a frame is given by its name or its index, see `frame_names`")
        })?;
        let found = usize::try_from(index).ok().and_then(|index| self.frames.get(index));
        found.copied().ok_or_else(|| {
            PyIndexError::new_err(format!(
                "frame {index} is none of robot `{}`, which has {} from 0 on",
                self.model.name(),
                self.frames.len()
            ))
        })
    }
}

/// Name, index, parent joint, mass, centre of mass and inertia of a link.
type LinkFields<'a> = (&'a str, usize, Option<usize>, f64, [f64; 3], [[f64; 3]; 3]);

/// Name, index, kind, parent link, child link and parent joint of a joint. Then first entry and count in q
/// and in v; leader, ratio and offset of a mimic joint; limits; passive forces.
type JointFields<'a> = (
    (&'a str, usize, &'a str),
    (&'a str, &'a str, Option<usize>),
    (usize, usize),
    (usize, usize),
    Option<(&'a str, f64, f64)>,
    [f64; 4],
    [f64; 5],
);

#[pymethods]
impl Robot {
    /// Reads a robot: `kind` says what `source` is, the `path` of a file, its `text`, or the `json` of
    /// `_state`. `assets` has the files that the text names. `srdf` is a path like `source`, or a text.
    #[new]
    #[pyo3(signature = (kind, source, *, floating_base=false, strict=false, repair_inertia=false, package_path=None, confined=false, srdf=None, assets=None))]
    fn new(
        py: Python<'_>,
        kind: &str,
        source: &Bound<'_, PyAny>,
        floating_base: bool,
        strict: bool,
        repair_inertia: bool,
        package_path: Option<Vec<PathBuf>>,
        confined: bool,
        srdf: Option<&Bound<'_, PyAny>>,
        assets: Option<Vec<(PathBuf, PyBackedBytes)>>,
    ) -> PyResult<Self> {
        let package_path = package_path.unwrap_or_default();
        let srdf = match (srdf, kind) {
            (Some(path), "path") => Some(Srdf::File(path.extract()?)),
            (Some(text), _) => Some(Srdf::Text(text.extract()?)),
            (None, _) => None,
        };
        let options = LoadOptions { floating_base, strict, repair_inertia, package_path, confined, srdf };
        match kind {
            "path" => {
                let path: PathBuf = source.extract()?;
                let read = py.detach(|| load_description(&path, &options));
                Self::made(py, read.map_err(exception)?)
            }
            "text" => {
                let text: String = source.extract()?;
                let files = assets.map(|assets| file_set(&text, assets)).transpose()?;
                let read = py.detach(|| match &files {
                    Some((files, main)) => load_description_from_files(files, main, &options),
                    None => load_description_from_text(&text, &options),
                });
                Self::made(py, read.map_err(exception)?)
            }
            _ => {
                let text: String = source.extract()?;
                let (description, report): (RobotDescription, LoadReport) =
                    serde_json::from_str(&text).map_err(|error| Class::Load.error(py, error))?;
                let model = Model::new(description).map_err(|error| Class::Load.error(py, error))?;
                Ok(Self::of(with_native_code(model), report))
            }
        }
    }

    /// The description and the report as JSON, from which an equal robot is made.
    fn _state(&self) -> PyResult<String> {
        self.state_of(self.model.description())
    }

    /// Links in the file's order, as the fields of `robot_dynamics.Link`.
    fn _links(&self) -> Vec<LinkFields<'_>> {
        let links = self.model.links().iter();
        links
            .map(|link| {
                (
                    &*link.name,
                    link.index,
                    link.parent_joint,
                    link.mass(),
                    link.center_of_mass(),
                    link.inertia(),
                )
            })
            .collect()
    }

    /// Joints in the order of their coordinates, as the fields of `robot_dynamics.Joint`.
    fn _joints(&self) -> Vec<JointFields<'_>> {
        let joints = self.model.joints().iter();
        joints
            .map(|joint| {
                let (limits, passive) = (&joint.limits, &joint.passive);
                (
                    (&*joint.name, joint.index, joint.kind.name()),
                    (&*joint.parent_link, &*joint.child_link, joint.parent_joint),
                    (joint.q_index, joint.nq),
                    (joint.v_index, joint.nv),
                    joint.mimic.as_ref().map(|mimic| (&*mimic.joint, mimic.ratio, mimic.offset)),
                    [limits.lower, limits.upper, limits.velocity, limits.effort],
                    [passive.armature, passive.damping, passive.friction, passive.stiffness, passive.rest],
                )
            })
            .collect()
    }

    /// The features that the default simulation leaves out, one line for each reason, or why there is no such
    /// simulation.
    fn _left_out(&self, py: Python<'_>) -> Vec<String> {
        if self.model.nv() == 0 {
            return Vec::new();
        }
        match py.detach(|| robot_dynamics::simulation(&self.model).build()) {
            Ok(simulation) => simulation.unsupported_features().iter().map(ToString::to_string).collect(),
            Err(error) => vec![format!("everything: {error}")],
        }
    }

    /// The pairs of links whose collisions an SRDF file disables.
    fn _disabled_collisions(&self, py: Python<'_>, path: PathBuf) -> PyResult<Vec<(String, String)>> {
        let pairs = robot_dynamics::urdf::load_disabled_collisions(&path, self.model.description());
        pairs.map_err(|error| Class::Load.error(py, format!("{}: {error}", path.display())))
    }

    /// The report in the library's own words.
    fn _report_text(&self) -> String {
        self.report.to_string()
    }

    /// The warnings of the report, those of one kind in one text.
    fn _warning_groups(&self) -> Vec<String> {
        self.report.grouped_warnings().iter().map(ToString::to_string).collect()
    }

    /// The robot's name.
    #[getter]
    fn name(&self) -> &str {
        self.model.name()
    }

    /// How many numbers a configuration q has.
    #[getter]
    fn nq(&self) -> usize {
        self.model.nq()
    }

    /// How many numbers a velocity v has: the degrees of freedom.
    #[getter]
    fn nv(&self) -> usize {
        self.model.nv()
    }

    /// The mass [kg] of the links that `center_of_mass` counts: those that move, or all of a robot whose
    /// moving links have no mass.
    #[getter]
    fn mass(&self) -> f64 {
        self.model.mass()
    }

    /// The mass of all links [kg], those fixed to the world included.
    #[getter]
    fn total_mass(&self) -> f64 {
        self.model.total_mass()
    }

    /// See `actuated_dofs`.
    fn _actuated_dofs(&self) -> Vec<bool> {
        self.model.actuated_dofs().to_vec()
    }

    /// The acceleration of free fall in the world [m/s²].
    #[getter]
    fn gravity_vector(&self) -> (f64, f64, f64) {
        self.model.gravity().into()
    }

    /// The names of all frames: links, and what the file adds to them; an index into this list is a frame,
    /// too.
    #[getter]
    fn frame_names(&self) -> Vec<&str> {
        self.model.frames().iter().map(|frame| frame.name.as_str()).collect()
    }

    /// The names of v's coordinates, for example `shoulder` or `floating_base.vx`.
    #[getter]
    fn coordinate_names(&self) -> Vec<String> {
        self.model.coordinate_names()
    }

    /// Joints that move no inertia in any pose. If there are any, accelerations have no value.
    #[getter]
    fn massless_joints(&self) -> Vec<&str> {
        self.model.massless_joints().collect()
    }

    /// A number that identifies a robot. It is equal if every name and every digit of the descriptions are
    /// equal.
    #[getter]
    fn fingerprint(&self) -> u64 {
        self.model.fingerprint()
    }

    /// The code that computes each function called so far, a line each. It is machine code, made when a
    /// function is first called, or the function's recursion, with the reason.
    ///
    /// With the environment variable `ROBOT_DYNAMICS_NATIVE=0`, set before the start, the recursions compute
    /// all functions. Results then differ by rounding.
    ///
    /// >>> robot = rd.example("panda")
    /// >>> tau = robot.gravity(robot.neutral())
    /// >>> "gravity, f64, one state" in robot.native or "recursions" in robot.native
    /// True
    #[getter]
    fn native(&self) -> String {
        self.model.native().to_string()
    }

    fn __eq__(&self, other: &Bound<'_, PyAny>) -> bool {
        other.cast::<Self>().is_ok_and(|other| other.get().model.fingerprint() == self.model.fingerprint())
    }

    fn __hash__(&self) -> u64 {
        self.model.fingerprint()
    }
}
