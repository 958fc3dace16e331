//! Inverse kinematics with several tasks.

use std::sync::Arc;

use pyo3::prelude::*;
use pyo3::types::{PyDict, PyTuple};
use robot_dynamics::contact::ContactSet;
use robot_dynamics::control::InverseKinematicsOptions;
use robot_dynamics::control::task_kinematics::{
    CollisionAvoidance, KinematicLimits, KinematicObjective, KinematicTask, KinematicTaskId, TaskKinematics,
    TaskKinematicsError, TaskResidual, TaskSolution,
};
use robot_dynamics::mesh_corners;
use robot_dynamics::model::Model;

use crate::constraints::Constraints;
use crate::errors::{Class, exception};
use crate::exclusive::Exclusive;
use crate::numbers::{array, configuration, object, pose_of, record, several, shaped, vector_or_zeros};
use crate::robot::Robot;
use crate::threads::{count_of, default_count};

/// Weight, level, gain and damping of a task.
type Law = (f64, usize, f64, f64);

/// Tolerances of position and angle, most iterations and restarts, and the seed.
type Search = (f64, f64, usize, usize, u64);

fn options_of((position, angle, iterations, restarts, seed): Search) -> InverseKinematicsOptions {
    InverseKinematicsOptions::default()
        .with_tolerances(position, angle)
        .with_iterations(iterations)
        .with_restarts(restarts, seed)
}

/// The native half of `robot_dynamics.TaskKinematics`.
#[pyclass(subclass, frozen, module = "robot_dynamics._native")]
pub(crate) struct KinematicTasks {
    robot: Py<Robot>,
    own: Exclusive<(TaskKinematics<Arc<Model>>, Vec<KinematicTaskId>)>,
}

#[pymethods]
impl KinematicTasks {
    #[new]
    fn new(robot: &Bound<'_, Robot>) -> Self {
        let tasks = TaskKinematics::owning(Arc::new(robot.get().model.clone()));
        Self { robot: robot.clone().unbind(), own: Exclusive::new((tasks, Vec::new())) }
    }

    /// See `add_pose`, `add_center_of_mass`, `add_posture`, `add_look_at` and `add_constraints`.
    fn _add_task(&self, py: Python<'_>, objective: &Bound<'_, PyTuple>, law: Law) -> PyResult<usize> {
        let (weight, level, gain, damping) = law;
        let task = KinematicTask::new(objective_of(py, self.robot.get(), objective)?);
        let task = task.with_weight(weight).with_level(level).with_gain(gain).with_damping(damping);
        let (tasks, ids) = &mut *self.own.lock(py);
        ids.push(tasks.add_task(task).map_err(exception)?);
        Ok(ids.len() - 1)
    }

    /// See `set_target`.
    fn _set_objective(&self, py: Python<'_>, task: usize, objective: &Bound<'_, PyTuple>) -> PyResult<()> {
        let objective = objective_of(py, self.robot.get(), objective)?;
        let (tasks, ids) = &mut *self.own.lock(py);
        *tasks.objective_mut(id_of(py, ids, task)?) = objective;
        Ok(())
    }

    /// See `set_weight`.
    fn _set_weight(&self, py: Python<'_>, task: usize, weight: f64) -> PyResult<()> {
        let (tasks, ids) = &mut *self.own.lock(py);
        tasks.set_weight(id_of(py, ids, task)?, weight).map_err(exception)
    }

    /// See `set_limits`.
    fn _set_limits(
        &self,
        py: Python<'_>,
        lower: Option<&Bound<'_, PyAny>>,
        upper: Option<&Bound<'_, PyAny>>,
        velocity: Option<&Bound<'_, PyAny>>,
        acceleration: Option<&Bound<'_, PyAny>>,
        position_gain: f64,
    ) -> PyResult<()> {
        let (tasks, _) = &mut *self.own.lock(py);
        let nv = tasks.model().nv();
        let read = |name: &str, given: Option<&Bound<'_, PyAny>>| {
            given.map(|given| shaped(py, name, given, &[nv]).map(|(_, numbers)| numbers)).transpose()
        };
        let mut limits = KinematicLimits::of(tasks.model());
        limits.position_gain = position_gain;
        for (name, side, given) in [("lower", 0, lower), ("upper", 1, upper)] {
            if let Some(given) = read(name, given)? {
                limits.position.iter_mut().zip(given).for_each(|(own, given)| own[side] = given);
            }
        }
        limits.velocity = read("velocity", velocity)?.unwrap_or(limits.velocity);
        limits.acceleration = read("acceleration", acceleration)?.unwrap_or(limits.acceleration);
        tasks.set_limits(limits).map_err(exception)
    }

    /// See `set_damping`.
    fn _set_damping(&self, py: Python<'_>, damping: f64) -> PyResult<()> {
        self.own.lock(py).0.set_damping(damping).map_err(exception)
    }

    /// See `avoid_collisions`.
    fn _avoid_collisions(&self, py: Python<'_>, least_distance: f64, range: f64, gain: f64) -> PyResult<()> {
        let (tasks, _) = &mut *self.own.lock(py);
        let contacts = ContactSet::with_meshes(tasks.model(), &[], mesh_corners).map_err(exception)?;
        let contacts = contacts.with_links(tasks.model());
        let law = CollisionAvoidance { least_distance, range, gain };
        tasks.avoid_collisions(contacts, law).map_err(exception)
    }

    /// See `step`.
    fn _next_step<'py>(
        &self,
        py: Python<'py>,
        q: &Bound<'py, PyAny>,
        v: Option<&Bound<'py, PyAny>>,
        dt: f64,
    ) -> PyResult<Bound<'py, PyDict>> {
        let robot = self.robot.get();
        let (q, v) = (configuration(py, robot, q)?, vector_or_zeros(py, robot, "v", v)?);
        let step = py.detach(|| self.own.lock_detached().0.step(&q, &v, dt).cloned()).map_err(exception)?;
        record(
            py,
            [
                ("velocity", array(py, &step.velocity)?),
                ("q", array(py, &step.q)?),
                ("errors", object(py, pairs(&step.errors))?),
                ("distance", object(py, step.distance)?),
            ],
        )
    }

    /// See `solve`.
    fn _find<'py>(
        &self,
        py: Python<'py>,
        start: &Bound<'py, PyAny>,
        search: Search,
    ) -> PyResult<Bound<'py, PyDict>> {
        let (start, options) = (configuration(py, self.robot.get(), start)?, options_of(search));
        let found = py.detach(|| self.own.lock_detached().0.solve(&start, &options)).map_err(exception)?;
        solution(py, &found)
    }

    /// See `solve_many`.
    fn _find_many<'py>(
        &self,
        py: Python<'py>,
        task: usize,
        objectives: Vec<Bound<'py, PyTuple>>,
        starts: Vec<Bound<'py, PyAny>>,
        search: Search,
        threads: Option<Bound<'py, PyAny>>,
    ) -> PyResult<Vec<(bool, Bound<'py, PyDict>)>> {
        let (robot, options) = (self.robot.get(), options_of(search));
        let starts: Vec<Vec<f64>> =
            starts.iter().map(|start| configuration(py, robot, start)).collect::<PyResult<_>>()?;
        let objectives: Vec<KinematicObjective> =
            objectives.iter().map(|given| objective_of(py, robot, given)).collect::<PyResult<_>>()?;
        let threads = count_of(threads.as_ref())?.unwrap_or_else(default_count);
        let id = id_of(py, &self.own.lock(py).1, task)?;
        let found = py.detach(|| {
            let own = self.own.lock_detached().0.clone();
            own.solve_many(objectives.len(), threads, &options, |index, tasks| {
                *tasks.objective_mut(id) = objectives[index].clone();
                starts[index % starts.len()].clone()
            })
        });
        let all = found.into_iter().map(|found| match found {
            Ok(found) => Ok((true, solution(py, &found)?)),
            Err(TaskKinematicsError::Unreached { best, .. }) => Ok((false, solution(py, &best)?)),
            Err(error) => Err(exception(error)),
        });
        all.collect()
    }
}

/// The errors of tasks as pairs of position and angle.
fn pairs(errors: &[TaskResidual]) -> Vec<(f64, f64)> {
    errors.iter().map(|error| (error.position, error.angle)).collect()
}

fn solution<'py>(py: Python<'py>, found: &TaskSolution) -> PyResult<Bound<'py, PyDict>> {
    record(
        py,
        [
            ("q", array(py, &found.q)?),
            ("errors", object(py, pairs(&found.errors))?),
            ("iterations", object(py, found.iterations)?),
            ("restarts", object(py, found.restarts)?),
        ],
    )
}

fn id_of(py: Python<'_>, ids: &[KinematicTaskId], task: usize) -> PyResult<KinematicTaskId> {
    let missing = || Class::InverseKinematics.error(py, format!("there is no task {task}"));
    ids.get(task).copied().ok_or_else(missing)
}

/// The objective of its kind and its numbers.
fn objective_of(py: Python<'_>, robot: &Robot, given: &Bound<'_, PyTuple>) -> PyResult<KinematicObjective> {
    let kind: String = given.get_item(0)?.extract()?;
    let item = |index: usize| given.get_item(index);
    Ok(match kind.as_str() {
        "pose" => {
            let reference = item(2)?;
            let reference = if reference.is_none() { None } else { Some(robot.frame_of(&reference)?) };
            let (_, target) = shaped(py, "target", &item(3)?, &[4, 4])?;
            let (frame, weights) = (robot.frame_of(&item(1)?)?, several("weights", &item(4)?)?);
            KinematicObjective::Pose { frame, reference, target: pose_of(&target), weights }
        }
        "center_of_mass" => KinematicObjective::CenterOfMass {
            target: several("target", &item(1)?)?,
            weights: several("weights", &item(2)?)?,
        },
        "posture" => KinematicObjective::Posture { target: configuration(py, robot, &item(1)?)? },
        "look_at" => KinematicObjective::LookAt {
            frame: robot.frame_of(&item(1)?)?,
            axis: several("axis", &item(2)?)?,
            point: several("point", &item(3)?)?,
        },
        _ => {
            let constraints = item(1)?;
            let constraints = constraints.cast::<Constraints>()?;
            KinematicObjective::Constraints(constraints.get().of(py, robot)?.clone())
        }
    })
}
