//! Loops, contacts, rolling, couplings: A(q) v = 0 beside the equation of motion.

use pyo3::exceptions::PyValueError;
use pyo3::prelude::*;
use pyo3::types::PyDict;
use robot_dynamics::constraints::{
    Baumgarte, Constraint, ConstraintError, ConstraintOptions, ConstraintSet, ContactSupport, Coupling,
    FrameConstraint, NoSlip, Plane, RollingDisc, RollingRow, SpatialAxis, SupportProblem,
    constrained_forward_dynamics, constrained_inverse_dynamics, constraint_drift, constraint_projections,
    contact_impulse, project_position, project_velocity, supported_inverse_dynamics,
};
use robot_dynamics::model::Workspace;
use robot_dynamics::simulation::Integrator;

pub(crate) use crate::constraint_set::Constraints;
use crate::errors::{Class, exception, exception_of};
use crate::numbers::{array, array_of, configuration, object, pose_of, record, vector, vector_or_zeros};
use crate::outcome;
use crate::robot::Robot;

/// A constraint as the Python half describes it: name, kind, frames or coordinates, numbers, rows.
type Fields = (String, String, Vec<String>, Vec<f64>, Vec<String>);

#[pymethods]
impl Constraints {
    /// The constraints of a robot; `robot_dynamics.Robot.constraints` makes them.
    #[new]
    fn new(py: Python<'_>, robot: &Bound<'_, Robot>, fields: Vec<Fields>) -> PyResult<Self> {
        let robot = robot.get();
        let mut constraints = Vec::with_capacity(fields.len());
        for (name, kind, places, numbers, rows) in fields {
            constraints.push((name.clone(), constraint(py, robot, &name, &kind, &places, &numbers, &rows)?));
        }
        let set = ConstraintSet::new(&robot.model, constraints).map_err(exception_of::<ConstraintError>)?;
        Ok(Self { set, fingerprint: robot.model.fingerprint(), robot: robot.model.name().into() })
    }

    /// The names of the rows, for example `pin.x`.
    #[getter]
    fn row_names(&self) -> Vec<String> {
        self.set.row_names().to_vec()
    }

    fn __len__(&self) -> usize {
        self.set.len()
    }

    fn __repr__(&self) -> String {
        format!("<Constraints of '{}': {}>", self.robot, self.set.row_names().join(", "))
    }
}

impl Constraints {
    /// The set; an error if it was made for another robot.
    pub(crate) fn of(&self, py: Python<'_>, robot: &Robot) -> PyResult<&ConstraintSet> {
        if self.fingerprint == robot.model.fingerprint() {
            return Ok(&self.set);
        }
        Err(Class::Constraint.error(
            py,
            format!(
                "the constraints are of robot `{}`, not of this `{}`: make them anew",
                self.robot,
                robot.model.name()
            ),
        ))
    }
}

/// Frame, point in it, normal in the world, friction.
type SupportFields = (String, [f64; 3], [f64; 3], f64);

pub(crate) fn check_actuated(py: Python<'_>, robot: &Robot, actuated: &[bool]) -> PyResult<()> {
    let (found, nv) = (actuated.len(), robot.model.nv());
    if found == nv {
        return Ok(());
    }
    Err(Class::Shape.error(py, format!("actuated has {found} entries, it must have nv = {nv}")))
}

/// The directions of a frame constraint by their names.
pub(crate) fn spatial_axes(rows: &[String]) -> PyResult<Vec<SpatialAxis>> {
    const ALL: [SpatialAxis; 6] =
        [SpatialAxis::X, SpatialAxis::Y, SpatialAxis::Z, SpatialAxis::Rx, SpatialAxis::Ry, SpatialAxis::Rz];
    let find = |name: &String| {
        ALL.into_iter().find(|row| row.name() == name).ok_or_else(|| {
            PyValueError::new_err(format!("there is no row {name:?}; rows are x, y, z, rx, ry, rz"))
        })
    };
    rows.iter().map(find).collect()
}

fn constraint(
    py: Python<'_>,
    robot: &Robot,
    name: &str,
    kind: &str,
    places: &[String],
    numbers: &[f64],
    rows: &[String],
) -> PyResult<Constraint> {
    let model = &robot.model;
    let frame = |k: usize| {
        let place = places.get(k).map_or("", String::as_str);
        model
            .frame_named(place)
            .map_err(|error| Class::of(&error).error(py, format!("constraint `{name}`: {error}")))
    };
    let three = |from: usize| -> PyResult<[f64; 3]> {
        let slice = numbers.get(from..from + 3).and_then(|three| three.try_into().ok());
        slice.ok_or_else(|| PyValueError::new_err(format!("constraint `{name}` has too few numbers")))
    };
    Ok(match kind {
        "frame" => FrameConstraint::between(frame(0)?, frame(1)?, &spatial_axes(rows)?).into(),
        "point_contact" => FrameConstraint::point_contact(frame(0)?, three(0)?).into(),
        "contact" => {
            if numbers.len() != 16 {
                return Err(PyValueError::new_err(format!("constraint `{name}`: a pose has 4 by 4 numbers")));
            }
            FrameConstraint::contact(frame(0)?, pose_of(numbers), &spatial_axes(rows)?).into()
        }
        "no_slip" => NoSlip { frame: frame(0)?, rows: spatial_axes(rows)? }.into(),
        "rolling" => {
            const ALL: [RollingRow; 3] = [RollingRow::Forward, RollingRow::Side, RollingRow::Normal];
            let radius = numbers.get(3).copied().unwrap_or(f64::NAN);
            let mut disc = RollingDisc::on_floor(frame(0)?, three(0)?, radius);
            disc.plane = Plane::new(three(4)?, three(7)?);
            let find = |row: &String| {
                ALL.into_iter().find(|own| own.name() == row).ok_or_else(|| {
                    PyValueError::new_err(format!("there is no row {row:?}; rows are forward, side, normal"))
                })
            };
            disc.rows = rows.iter().map(find).collect::<PyResult<_>>()?;
            disc.into()
        }
        _ => {
            let (offset, factors) = numbers.split_last().unwrap_or((&0.0, &[]));
            let terms: Vec<_> = places.iter().map(String::as_str).zip(factors.iter().copied()).collect();
            Coupling::new(model, &terms, *offset).map_err(exception_of::<ConstraintError>)?.into()
        }
    })
}

/// Options of a step under constraints.
pub(crate) fn options_of(integrator: Integrator, stabilization: Option<f64>) -> ConstraintOptions {
    ConstraintOptions {
        integrator,
        stabilization: stabilization.map(|rate| Baumgarte { rate }),
        ..ConstraintOptions::default()
    }
}

#[pymethods]
impl Robot {
    /// See `constraint_rows`.
    fn _constraint_rows<'py>(
        &self,
        py: Python<'py>,
        constraints: &Bound<'py, Constraints>,
        q: &Bound<'py, PyAny>,
        v: Option<&Bound<'py, PyAny>>,
    ) -> PyResult<Bound<'py, PyDict>> {
        let set = constraints.get().of(py, self)?;
        let (q, v) = (configuration(py, self, q)?, vector_or_zeros(py, self, "v", v)?);
        let (rows, drift) = self.scratch.with(&self.model, |scratch| {
            let drift = constraint_drift(&self.model, &mut scratch.workspace, set, &q, &v);
            (set.rows(&self.model, &mut scratch.workspace, &q, &v), drift)
        });
        record(
            py,
            [
                ("matrix", array_of(py, &rows.matrix)?),
                ("bias", array(py, rows.bias.as_slice())?),
                ("position_error", array(py, rows.position_error.as_slice())?),
                ("position_drift", object(py, drift.position)?),
                ("velocity_drift", object(py, drift.velocity)?),
            ],
        )
    }

    /// See `constrained_forward_dynamics`.
    fn _constrained_forward_dynamics<'py>(
        &self,
        py: Python<'py>,
        constraints: &Bound<'py, Constraints>,
        q: &Bound<'py, PyAny>,
        v: &Bound<'py, PyAny>,
        tau: Option<&Bound<'py, PyAny>>,
        stabilization: Option<f64>,
    ) -> PyResult<Bound<'py, PyDict>> {
        let set = constraints.get().of(py, self)?;
        let (q, v) = (configuration(py, self, q)?, vector(py, self, "v", v)?);
        let tau = vector_or_zeros(py, self, "tau", tau)?;
        let options = options_of(Integrator::RungeKutta4, stabilization);
        let motion = self
            .with_workspace(|w| constrained_forward_dynamics(&self.model, w, set, &options, &q, &v, &tau))
            .map_err(exception_of::<ConstraintError>)?;
        record(
            py,
            [
                ("acceleration", array(py, motion.acceleration.as_slice())?),
                ("multipliers", array(py, motion.multipliers.as_slice())?),
                ("rank", object(py, motion.rank)?),
                (
                    "dependent",
                    object(py, motion.dependent.iter().map(ToString::to_string).collect::<Vec<_>>())?,
                ),
                ("residual", object(py, motion.residual)?),
            ],
        )
    }

    /// See `constrained_inverse_dynamics`.
    fn _constrained_inverse_dynamics<'py>(
        &self,
        py: Python<'py>,
        constraints: &Bound<'py, Constraints>,
        q: &Bound<'py, PyAny>,
        v: &Bound<'py, PyAny>,
        a: &Bound<'py, PyAny>,
        actuated: Option<Vec<bool>>,
    ) -> PyResult<Bound<'py, PyDict>> {
        let set = constraints.get().of(py, self)?;
        let (q, v, a) = (configuration(py, self, q)?, vector(py, self, "v", v)?, vector(py, self, "a", a)?);
        let actuated = actuated.unwrap_or_else(|| self.model.actuated_dofs().to_vec());
        check_actuated(py, self, &actuated)?;
        let torque = self
            .with_workspace(|w| constrained_inverse_dynamics(&self.model, w, set, &q, &v, &a, &actuated))
            .map_err(exception_of::<ConstraintError>)?;
        record(
            py,
            [
                ("tau", array(py, torque.tau.as_slice())?),
                ("multipliers", array(py, torque.multipliers.as_slice())?),
                ("residual", object(py, torque.residual)?),
            ],
        )
    }

    /// See `supported_inverse_dynamics`.
    fn _supported_inverse_dynamics<'py>(
        &self,
        py: Python<'py>,
        supports: Vec<SupportFields>,
        constraints: Option<&Bound<'py, Constraints>>,
        q: &Bound<'py, PyAny>,
        v: &Bound<'py, PyAny>,
        a: &Bound<'py, PyAny>,
        actuated: Option<Vec<bool>>,
        force_weight: f64,
    ) -> PyResult<Bound<'py, PyDict>> {
        let point = |(place, point, normal, friction): SupportFields| -> PyResult<ContactSupport> {
            let frame = self.model.frame_named(&place).map_err(exception)?;
            Ok(ContactSupport::new(frame, point, normal, friction))
        };
        let points = supports.into_iter().map(point).collect::<PyResult<Vec<_>>>()?;
        let all = SupportProblem::new(&points).with_force_weight(force_weight);
        let all = match constraints {
            Some(set) => all.with_constraints(set.get().of(py, self)?),
            None => all,
        };
        let (q, v, a) = (configuration(py, self, q)?, vector(py, self, "v", v)?, vector(py, self, "a", a)?);
        let actuated = actuated.unwrap_or_else(|| self.model.actuated_dofs().to_vec());
        check_actuated(py, self, &actuated)?;
        let torque = self
            .with_workspace(|w| supported_inverse_dynamics(&self.model, w, &all, &q, &v, &a, &actuated))
            .map_err(exception_of::<ConstraintError>)?;
        let forces = torque.forces.as_flattened();
        record(
            py,
            [
                ("tau", array(py, torque.tau.as_slice())?),
                ("forces", outcome::filled(py, &[torque.forces.len(), 3], forces)?),
                ("multipliers", array(py, torque.multipliers.as_slice())?),
                ("missing", array(py, torque.missing.as_slice())?),
            ],
        )
    }

    /// See `contact_impulse`.
    fn _contact_impulse<'py>(
        &self,
        py: Python<'py>,
        constraints: &Bound<'py, Constraints>,
        q: &Bound<'py, PyAny>,
        v: &Bound<'py, PyAny>,
        restitution: f64,
    ) -> PyResult<Bound<'py, PyDict>> {
        let set = constraints.get().of(py, self)?;
        let (q, v) = (configuration(py, self, q)?, vector(py, self, "v", v)?);
        let options = ConstraintOptions::default();
        let after = self
            .with_workspace(|w| contact_impulse(&self.model, w, set, &options, &q, &v, restitution))
            .map_err(exception_of::<ConstraintError>)?;
        record(
            py,
            [
                ("velocity", array(py, after.velocity.as_slice())?),
                ("impulse", array(py, after.impulse.as_slice())?),
                ("energy_lost", object(py, after.energy_lost)?),
                ("rank", object(py, after.rank)?),
            ],
        )
    }

    /// See `project`.
    fn _project<'py>(
        &self,
        py: Python<'py>,
        constraints: &Bound<'py, Constraints>,
        q: &Bound<'py, PyAny>,
        v: Option<&Bound<'py, PyAny>>,
        tolerance: f64,
    ) -> PyResult<(Bound<'py, PyAny>, Bound<'py, PyAny>)> {
        let set = constraints.get().of(py, self)?;
        let (mut q, mut v) = (configuration(py, self, q)?, vector_or_zeros(py, self, "v", v)?);
        let options = ConstraintOptions::default();
        self.with_workspace(|w| {
            project_position(&self.model, w, set, &options, tolerance, &mut q)?;
            project_velocity(&self.model, w, set, &options, &q, &mut v)
        })
        .map_err(exception_of::<ConstraintError>)?;
        Ok((array(py, &q)?, array(py, &v)?))
    }

    /// See `constraint_projections`.
    fn _constraint_projections<'py>(
        &self,
        py: Python<'py>,
        constraints: &Bound<'py, Constraints>,
        q: &Bound<'py, PyAny>,
    ) -> PyResult<(Bound<'py, PyAny>, Bound<'py, PyAny>)> {
        let (set, q) = (constraints.get().of(py, self)?, configuration(py, self, q)?);
        let options = ConstraintOptions::default();
        let projections = self
            .with_workspace(|w| constraint_projections(&self.model, w, set, &options, &q))
            .map_err(exception_of::<ConstraintError>)?;
        Ok((array_of(py, &projections.velocity)?, array_of(py, &projections.force)?))
    }
}

impl Robot {
    /// Computes with memory for one state.
    pub(crate) fn with_workspace<R>(&self, compute: impl FnOnce(&mut Workspace) -> R) -> R {
        self.scratch.with(&self.model, |scratch| compute(&mut scratch.workspace))
    }
}
