//! The values of a robot's sensors.

use pyo3::prelude::*;
use robot_dynamics::description::{SensorDescription, SensorKind, SensorObject};
use robot_dynamics::model::{FrameId, Model};
use robot_dynamics::simulation::{PointForce, SensorInputs, SensorSet};

use crate::errors::{Class, exception};
use crate::numbers::{array, configuration, shaped, vector};
use crate::robot::Robot;

/// A force on a link: the link, the point, force, moment, and the contact's normal.
type Pushed<'py> = (Bound<'py, PyAny>, [f64; 3], [f64; 3], [f64; 3], [f64; 3]);

/// A sensor to be added: name, kind, object, reference.
type Added = (String, String, Option<String>, Option<String>);

impl Robot {
    fn sensor_set(&self) -> PyResult<&SensorSet> {
        if let Some(set) = self.sensors.get() {
            return Ok(set);
        }
        let set = SensorSet::new(&self.model).map_err(exception)?;
        Ok(self.sensors.get_or_init(|| set))
    }
}

/// A list of so many finite numbers, or nothing.
fn forces(py: Python<'_>, name: &str, object: Option<&Bound<'_, PyAny>>, count: usize) -> PyResult<Vec<f64>> {
    let Some(object) = object else { return Ok(Vec::new()) };
    let (_, numbers) = shaped(py, name, object, &[count])?;
    match numbers.iter().position(|x| !x.is_finite()) {
        None => Ok(numbers),
        Some(index) => {
            let value = numbers[index];
            Err(Class::State.error(py, format!("{name}[{index}] is {value}; every number must be finite")))
        }
    }
}

#[pymethods]
impl Robot {
    /// See `sensors`.
    fn _sensors(&self) -> Vec<(&str, &'static str, usize)> {
        let sensors = self.model.description().sensors.iter();
        sensors.map(|sensor| (sensor.name.as_str(), sensor.kind.name(), sensor.kind.size())).collect()
    }

    /// See `sensor_values`.
    #[pyo3(signature = (q, v, a, *, time, actuator_forces, joint_limit_forces, tendon_limit_forces, wrenches))]
    fn _sensor_values<'py>(
        &self,
        py: Python<'py>,
        q: &Bound<'py, PyAny>,
        v: &Bound<'py, PyAny>,
        a: &Bound<'py, PyAny>,
        time: f64,
        actuator_forces: Option<&Bound<'py, PyAny>>,
        joint_limit_forces: Option<&Bound<'py, PyAny>>,
        tendon_limit_forces: Option<&Bound<'py, PyAny>>,
        wrenches: Vec<Pushed<'py>>,
    ) -> PyResult<Bound<'py, PyAny>> {
        let (set, description) = (self.sensor_set()?, self.model.description());
        let q = configuration(py, self, q)?;
        let (v, a) = (vector(py, self, "v", v)?, vector(py, self, "a", a)?);
        let actuators = forces(py, "actuator_forces", actuator_forces, description.actuators.len())?;
        let limits = forces(py, "joint_limit_forces", joint_limit_forces, self.model.nv())?;
        let tendons =
            forces(py, "tendon_limit_forces", tendon_limit_forces, description.tendon_names().count())?;
        let mut pushes = Vec::with_capacity(wrenches.len());
        for (link, point, force, moment, normal) in wrenches {
            let link: FrameId = self.frame_of(&link)?;
            let mut push = PointForce::new(link, point, force);
            (push.moment, push.normal) = (moment, normal);
            pushes.push(push);
        }
        let mut inputs = SensorInputs::new(&q, &v, &a);
        inputs.time = time;
        inputs.actuator_forces = &actuators;
        inputs.joint_limit_forces = &limits;
        inputs.tendon_limit_forces = &tendons;
        inputs.wrenches = &pushes;
        let mut values = vec![0.0; set.value_count()];
        let model: &Model = &self.model;
        self.scratch.with(model, |scratch| {
            set.evaluate(model, scratch.sensors(model, set), &inputs, &mut values);
        });
        array(py, &values)
    }

    /// See `with_sensors`.
    fn _with_sensors(&self, py: Python<'_>, sensors: Vec<Added>) -> PyResult<String> {
        let mut description = self.model.description().clone();
        for (name, kind, object, reference) in sensors {
            let Some(kind) = SensorKind::named(&kind) else {
                let kinds: Vec<_> = SensorKind::ALL.iter().map(|kind| kind.name()).collect();
                let kinds = kinds.join(", ");
                let message = format!("sensor `{name}`: there is no kind `{kind}`; there are {kinds}");
                return Err(Class::Description.error(py, message));
            };
            let object = object.map_or(SensorObject::Robot, SensorObject::Named);
            let mut sensor = SensorDescription::new(name, kind, object);
            sensor.reference = reference.map(SensorObject::Named);
            description.sensors.push(sensor);
        }
        Model::new(description.clone()).map_err(exception)?;
        self.state_of(&description)
    }
}
