//! A robot as text: its file in either format, and generated code for it.

use std::path::{Path, PathBuf};

use pyo3::exceptions::PyValueError;
use pyo3::prelude::*;
use robot_dynamics::description::{Base, LoadReport, RandomRobotOptions};
use robot_dynamics::model::Model;
use robot_dynamics::output::{file_read_at, write_files};
use robot_dynamics::text::{lines, one_line, xml};
use robot_dynamics::{Format, with_native_code};
use robot_dynamics_generate::{
    Arithmetic, Function, GenerateError, Precision, Request, Sine, Target, generate,
};

use crate::errors::{exception, exception_of};
use crate::robot::Robot;

/// The text, and for each omission its place, its description, and whether it affects the physics.
type Written = (String, Vec<(String, String, bool)>);

#[pymethods]
impl Robot {
    /// See `to_text`.
    #[pyo3(signature = (format, folder))]
    fn _to_text(&self, format: &str, folder: Option<PathBuf>) -> PyResult<Written> {
        let format = match format {
            "urdf" => Format::Urdf,
            "mjcf" => Format::Mjcf,
            _ => {
                return Err(PyValueError::new_err(format!(
                    "format = {format:?} must be \"urdf\" or \"mjcf\""
                )));
            }
        };
        let written =
            robot_dynamics::write(self.model.description(), format, folder.as_deref()).map_err(exception)?;
        let left_out = written.left_out.into_iter().map(|own| (own.place, own.message, own.physics));
        Ok((written.text, left_out.collect()))
    }

    /// The one of the robot's files that is at this path; links are resolved.
    fn _file_read_at(&self, path: PathBuf) -> Option<PathBuf> {
        file_read_at(path, &self.report.files).map(Path::to_owned)
    }

    /// See `generate`.
    #[allow(clippy::fn_params_excessive_bools)] // Python's keywords
    #[pyo3(signature = (target, functions, folder, *, single, fused, platform_sine, lanes, name, states))]
    fn _generate(
        &self,
        py: Python<'_>,
        target: &str,
        functions: Vec<String>,
        folder: Option<PathBuf>,
        single: bool,
        fused: bool,
        platform_sine: bool,
        lanes: bool,
        name: Option<String>,
        states: u16,
    ) -> PyResult<Vec<(String, String)>> {
        let names = Target::ALL.map(Target::name);
        let target = Target::ALL.into_iter().find(|own| own.name() == target).ok_or_else(|| {
            PyValueError::new_err(format!("target = {target:?} must be one of {}", names.join(", ")))
        })?;
        let functions = functions
            .iter()
            .map(|name| name.parse())
            .collect::<Result<Vec<Function>, _>>()
            .map_err(exception_of::<GenerateError>)?;
        let precision = if single { Precision::Single } else { Precision::Double };
        let mut arithmetic = Arithmetic::new(precision);
        if fused {
            arithmetic = arithmetic.with_fused();
        }
        if platform_sine {
            arithmetic = arithmetic.with_sine(Sine::Platform);
        }
        let mut request = Request::new(target, functions).with_arithmetic(arithmetic);
        (request.name, request.states, request.lanes) = (name, usize::from(states), lanes);
        let generated = py.detach(|| generate(&self.model, &request)).map_err(exception)?;
        if let Some(folder) = folder {
            for path in generated.paths(&folder) {
                if let Some(file) = file_read_at(&path, &self.report.files) {
                    return Err(PyValueError::new_err(format!(
                        "{} is {}, which the robot was read from; choose another folder or name",
                        path.display(),
                        file.display()
                    )));
                }
            }
            generated.write(folder).map_err(exception)?;
        }
        Ok(generated.files.into_iter().map(|file| (file.name, file.text)).collect())
    }

    /// The poses that the file names, MJCF's keyframes, with their q and v.
    fn _poses(&self) -> Vec<(&str, Vec<f64>, Vec<f64>)> {
        let names = self.model.description().poses.iter().map(|pose| pose.name.as_str());
        names
            .filter_map(|name| {
                let (q, v) = self.model.named_pose(name)?;
                Some((name, q, v))
            })
            .collect()
    }

    /// The names of the actuators, which `simulate(controls=…)` lets act.
    #[getter]
    fn actuator_names(&self) -> Vec<&str> {
        self.model.description().actuators.iter().map(|actuator| actuator.name.as_str()).collect()
    }
}

/// A text in which each invisible character is replaced by its escape; line ends stay if `keeps_lines`.
#[pyfunction]
pub(crate) fn _visible(text: &str, keeps_lines: bool) -> String {
    let written = if keeps_lines { lines(text) } else { one_line(text) };
    written.into_owned()
}

/// The text escaped for HTML, between tags or in an attribute.
#[pyfunction]
pub(crate) fn _html(text: &str) -> String {
    xml(text).into_owned()
}

/// Writes a text file as a whole or not at all.
#[pyfunction]
pub(crate) fn _write_text(path: PathBuf, text: &str) -> PyResult<()> {
    write_files(&[(path, text)]).map_err(|error| error.cause.into())
}

/// See `random_robot`.
#[pyfunction]
#[pyo3(signature = (seed, joints, floating_base))]
pub(crate) fn _random_robot(seed: u64, joints: usize, floating_base: bool) -> PyResult<String> {
    let base = if floating_base { Base::Floating } else { Base::Fixed };
    let options = RandomRobotOptions { joints, base, ..RandomRobotOptions::default() };
    let description = robot_dynamics::description::random_robot(seed, &options);
    let model = Model::new(description).map_err(exception)?;
    let robot = Robot::of(with_native_code(model), LoadReport::default());
    robot.state_of(robot.model.description())
}
