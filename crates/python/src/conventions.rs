//! States and forces in the conventions of other libraries.

use pyo3::prelude::*;
use robot_dynamics::conventions::{
    PinocchioLayout, acceleration_from_mujoco, acceleration_to_mujoco, configuration_from_mujoco,
    configuration_to_mujoco, force_from_mujoco, force_to_mujoco, velocity_from_mujoco, velocity_to_mujoco,
};
use robot_dynamics::model::Model;

use crate::errors::Class;
use crate::numbers::shaped;
use crate::outcome;
use crate::robot::Robot;

/// Conversions of one library, with theirs → ours as `from`.
enum Convention<'a> {
    Mujoco(&'a Model),
    Pinocchio(PinocchioLayout),
}

/// A conversion of one state: q and v of ours, the numbers, and the result.
type Conversion<'a> = &'a dyn Fn(&[f64], &[f64], &[f64], &mut [f64]);

impl<'a> Convention<'a> {
    fn new(name: &str, model: &'a Model) -> Self {
        match name {
            "mujoco" => Self::Mujoco(model),
            _ => Self::Pinocchio(PinocchioLayout::new(model)),
        }
    }

    /// The length of their q.
    fn nq(&self) -> usize {
        match self {
            Self::Mujoco(model) => model.nq(),
            Self::Pinocchio(layout) => layout.nq(),
        }
    }

    fn configuration(&self, back: bool, from: &[f64], to: &mut [f64]) {
        match (self, back) {
            (Self::Mujoco(model), false) => configuration_to_mujoco(model, from, to),
            (Self::Mujoco(model), true) => configuration_from_mujoco(model, from, to),
            (Self::Pinocchio(layout), false) => layout.configuration_to_pinocchio(from, to),
            (Self::Pinocchio(layout), true) => layout.configuration_from_pinocchio(from, to),
        }
    }

    fn velocity(&self, back: bool, q: &[f64], from: &[f64], to: &mut [f64]) {
        match (self, back) {
            (Self::Mujoco(model), false) => velocity_to_mujoco(model, q, from, to),
            (Self::Mujoco(model), true) => velocity_from_mujoco(model, q, from, to),
            (Self::Pinocchio(layout), false) => layout.velocity_to_pinocchio(q, from, to),
            (Self::Pinocchio(layout), true) => layout.velocity_from_pinocchio(q, from, to),
        }
    }

    fn acceleration(&self, back: bool, q: &[f64], v: &[f64], from: &[f64], to: &mut [f64]) {
        match (self, back) {
            (Self::Mujoco(model), false) => acceleration_to_mujoco(model, q, v, from, to),
            (Self::Mujoco(model), true) => acceleration_from_mujoco(model, q, v, from, to),
            (Self::Pinocchio(layout), false) => layout.acceleration_to_pinocchio(q, v, from, to),
            (Self::Pinocchio(layout), true) => layout.acceleration_from_pinocchio(q, v, from, to),
        }
    }

    fn force(&self, back: bool, q: &[f64], from: &[f64], to: &mut [f64]) {
        match (self, back) {
            (Self::Mujoco(model), false) => force_to_mujoco(model, q, from, to),
            (Self::Mujoco(model), true) => force_from_mujoco(model, q, from, to),
            (Self::Pinocchio(layout), false) => layout.force_to_pinocchio(q, from, to),
            (Self::Pinocchio(layout), true) => layout.force_from_pinocchio(q, from, to),
        }
    }
}

#[pymethods]
impl Robot {
    /// See `to_mujoco` and `to_pinocchio`; `back` converts in the other direction. All arrays have a row per
    /// state; the names are those of the arguments.
    fn _convert<'py>(
        &self,
        py: Python<'py>,
        convention: &str,
        back: bool,
        names: [String; 4],
        given: [Option<Bound<'py, PyAny>>; 4],
    ) -> PyResult<Vec<Option<Bound<'py, PyAny>>>> {
        let convention = Convention::new(convention, &self.model);
        let (nq, nv) = (self.model.nq(), self.model.nv());
        let (width, own_width) = if back { (convention.nq(), nq) } else { (nq, convention.nq()) };
        let mut read: [Option<Vec<f64>>; 4] = Default::default();
        let mut count = 0;
        for (k, (name, given)) in names.iter().zip(&given).enumerate() {
            let Some(given) = given else { continue };
            let rows = if k == 0 { usize::MAX } else { count };
            let (shape, numbers) = shaped(py, name, given, &[rows, if k == 0 { width } else { nv }])?;
            (count, read[k]) = (shape[0], Some(numbers));
        }
        let [q, v, a, tau] = &read;
        let q = q.as_deref().unwrap_or_default();
        let mut configurations = vec![0.0; count * own_width];
        for (k, to) in configurations.chunks_exact_mut(own_width.max(1)).enumerate() {
            convention.configuration(back, &q[k * width..(k + 1) * width], to);
        }
        let ours = if back { &configurations[..] } else { q };
        for k in 0..count {
            if !self.has_unit_quaternions(&ours[k * nq..(k + 1) * nq]) {
                let message = format!("{}[{k}] has a quaternion without unit length", names[0]);
                return Err(Class::State.error(py, message));
            }
        }
        let converted = |from: &[f64], velocities: &[f64], convert: Conversion<'_>| {
            let mut to = vec![0.0; count * nv];
            let rows = from.chunks_exact(nv.max(1)).zip(to.chunks_exact_mut(nv.max(1)));
            for (k, (from, to)) in rows.enumerate() {
                let v = velocities.get(k * nv..(k + 1) * nv).unwrap_or_default();
                convert(&ours[k * nq..(k + 1) * nq], v, from, to);
            }
            to
        };
        let velocity = |q: &[f64], _: &[f64], from: &[f64], to: &mut [f64]| {
            convention.velocity(back, q, from, to);
        };
        let acceleration = |q: &[f64], v: &[f64], from: &[f64], to: &mut [f64]| {
            convention.acceleration(back, q, v, from, to);
        };
        let force = |q: &[f64], _: &[f64], from: &[f64], to: &mut [f64]| {
            convention.force(back, q, from, to);
        };
        let velocities = v.as_ref().map(|v| converted(v, &[], &velocity));
        let own_v = if back { velocities.as_ref() } else { v.as_ref() };
        let own_v = own_v.map_or(&[][..], |v| v);
        let accelerations = a.as_ref().map(|a| converted(a, own_v, &acceleration));
        let forces = tau.as_ref().map(|tau| converted(tau, &[], &force));
        let array = |numbers: Vec<f64>, width: usize| outcome::filled(py, &[count, width], &numbers);
        let rows = [velocities, accelerations, forces];
        let first = Some(array(configurations, own_width)?);
        let rest = rows.into_iter().map(|numbers| numbers.map(|numbers| array(numbers, nv)).transpose());
        std::iter::once(Ok(first)).chain(rest).collect()
    }
}
