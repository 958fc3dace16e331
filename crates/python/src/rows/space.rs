//! The configuration space: moving along it and the way between two of its points.

use pyo3::prelude::*;
use robot_dynamics::number::SplitMix64;

use super::table::rows;
use crate::outcome;
use crate::robot::Robot;
use crate::row::Work::Each;

#[pymethods]
impl Robot {
    /// The configuration in which every coordinate is 0 and every quaternion the identity.
    ///
    /// Returns
    /// -------
    /// ndarray, shape (nq,)
    ///     Configuration.
    ///
    /// Examples
    /// --------
    ///
    /// >>> rd.example("quadruped", floating_base=True).neutral()[:7]
    /// array([0., 0., 0., 0., 0., 0., 1.])
    fn neutral<'py>(&self, py: Python<'py>) -> PyResult<Bound<'py, PyAny>> {
        outcome::filled(py, &[self.model.nq()], &robot_dynamics::model::neutral(&self.model))
    }

    /// Random configurations within the joint limits.
    ///
    /// Without limits they are from −π to π, or −1 m to 1 m; rotations are uniform. The same seed gives the
    /// same configurations.
    ///
    /// Parameters
    /// ----------
    /// size : int or sequence of int, optional
    ///     Leading dimensions of the result; default: one configuration.
    /// seed : int
    ///     Seed of the random numbers, not negative.
    ///
    /// Returns
    /// -------
    /// ndarray, shape (..., nq)
    ///     Configurations.
    ///
    /// Raises
    /// ------
    /// TypeError
    ///     `size` or `seed` is not a whole number.
    /// OverflowError
    ///     `size` or `seed` is negative.
    ///
    /// Examples
    /// --------
    ///
    /// >>> robot = rd.example("panda")
    /// >>> q = robot.random_configuration(1000, seed=1)
    /// >>> q.shape, bool(np.all((robot.limits.lower <= q) & (q <= robot.limits.upper)))
    /// ((1000, 7), True)
    #[pyo3(signature = (size=None, *, seed))]
    fn random_configuration<'py>(
        &self,
        py: Python<'py>,
        size: Option<&Bound<'py, PyAny>>,
        seed: u64,
    ) -> PyResult<Bound<'py, PyAny>> {
        let mut shape: Vec<usize> = match size {
            None => Vec::new(),
            Some(size) => match size.extract() {
                Ok(one) => vec![one],
                Err(_) => size.extract()?,
            },
        };
        let states: usize = shape.iter().product();
        shape.push(self.model.nq());
        let mut random = SplitMix64::new(seed);
        let numbers: Vec<f64> = (0..states)
            .flat_map(|_| robot_dynamics::model::random_within_limits(&self.model, &mut random))
            .collect();
        outcome::filled(py, &shape, &numbers)
    }

    /// π: mass, first moments m c and six second moments about the link's origin of each link that moves,
    /// (10·moving links,).
    ///
    /// In the order of `inertial_parameter_names` [kg, kg·m, kg·m²].
    ///
    /// >>> robot = rd.example("two_r")
    /// >>> bool(np.isclose(robot.inertial_parameters[::10].sum(), robot.mass))
    /// True
    #[getter]
    fn inertial_parameters<'py>(&self, py: Python<'py>) -> PyResult<Bound<'py, PyAny>> {
        let parameters = robot_dynamics::algorithms::inertial_parameters(&self.model);
        outcome::filled(py, &[parameters.len()], &parameters)
    }

    /// The names of π's entries.
    ///
    /// >>> rd.example("two_r").inertial_parameter_names[10:12]
    /// ['link2.m', 'link2.hx']
    #[getter]
    fn inertial_parameter_names(&self) -> Vec<String> {
        robot_dynamics::control::inertial_parameter_names(&self.model)
    }
}

rows! {
    /// q ⊕ d: the configuration reached by moving along d, a velocity times a time.
    ///
    /// It is q + d for angles and lengths; quaternions turn about d in the body's axes.
    integrate(q, d) => [Configuration "Configuration."]
    /// >>> rd.example("two_r").integrate([0.3, 1.2], [0.1, -0.2]).round(12)
    /// array([0.4, 1. ])
    = Each(|m, _, x, _, [out, ..]| robot_dynamics::model::integrate(m, x[0], x[1], out));

    /// q1 ⊖ q0: the displacement d with q0 ⊕ d = q1, the shortest way.
    difference(q0, q1) => [Vector "Displacement d [rad or m]."]
    /// >>> robot = rd.example("quadruped", floating_base=True)
    /// >>> q0, d = robot.neutral(), np.full(robot.nv, 0.1)
    /// >>> bool(np.allclose(robot.difference(q0, robot.integrate(q0, d)), d))
    /// True
    = Each(|m, _, x, _, [out, ..]| robot_dynamics::model::difference(m, x[0], x[1], out));

    /// q0 ⊕ s (q1 ⊖ q0): the configuration at s on the shortest way, 0 at q0 and 1 at q1.
    interpolate(q0, q1, s) => [Configuration "Configuration."]
    /// >>> rd.example("two_r").interpolate([0.0, 0.0], [1.0, -2.0], 0.5)
    /// array([ 0.5, -1. ])
    = Each(|m, _, x, _, [out, ..]| robot_dynamics::model::interpolate(m, x[0], x[1], x[2][0], out));
}
