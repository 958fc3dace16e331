//! Forces of the environment: the momentum observer, admittance, and controls of actuators for torques.

use std::sync::Arc;

use pyo3::prelude::*;
use robot_dynamics::control::PoseReference;
use robot_dynamics::description::Pose;
use robot_dynamics::model::Model;

use crate::controllers::pose_reference;
use crate::errors::exception;
use crate::exclusive::Exclusive;
use crate::numbers::{array, configuration, several, shaped, vector};
use crate::outcome::filled;
use crate::robot::Robot;

/// Estimates the external torque of a robot, such as that of a collision, without accelerations.
///
/// ṙ = K (τ_ext − r), where τ_ext = ṗ − Ṁ v + C v + g − τ and p = M v: r is τ_ext through a filter of first
/// order with the time constant 1/K. Friction of the joints (without `dissipation`), contacts, closed loops
/// and errors of the masses belong to τ_ext. The wrench at a frame is
/// `robot.operational_space(q, v, frame, rows).consistent_inverse.T @ r`. (De Luca, Mattone 2005)
///
/// Parameters
/// ----------
/// robot : Robot
///     Observed robot.
/// gains : array_like, shape (nv,)
///     K [1/s].
/// thresholds : array_like, shape (nv,), optional
///     |r| above which a coordinate counts as in collision [N·m or N].
/// dissipation : bool
///     Whether damping and friction of the model's joints are known.
///
/// Raises
/// ------
/// ShapeError
///     An array has the wrong shape.
/// StateError
///     A gain is not finite.
/// ControlError
///     A gain is not positive, or a threshold is negative.
///
/// Examples
/// --------
///
/// >>> robot, q = rd.example("panda"), np.array([0.0, 0.3, 0.0, -1.8, 0.0, 2.0, 0.6])
/// >>> observer = rd.MomentumObserver(robot, np.full(7, 100.0), thresholds=np.full(7, 2.0))
/// >>> hold = rd.GravityCompensatedPd(robot, q, np.full(7, 400.0), np.full(7, 40.0), gravity_at="state")
/// >>> sim = rd.Simulation(robot, dt=1e-3, without=["dissipation"])
/// >>> sim.reset(q)
/// >>> for step in range(400):
/// ...     if step == 200:
/// ...         sim.apply_wrench("panda_link8", force=(0.0, 30.0, 0.0))
/// ...     sim.torques = tau = hold(sim.time, sim.q, sim.v)
/// ...     sim.step()
/// ...     r = observer.update(sim.q, sim.v, tau, 1e-3)
/// >>> observer.collision is not None
/// True
/// >>> space = robot.operational_space(sim.q, sim.v, "panda_link8", ("x", "y", "z"))
/// >>> bool(np.allclose(space.consistent_inverse.T @ r, [0.0, 30.0, 0.0], atol=1.0))
/// True
#[pyclass(frozen, module = "robot_dynamics._native")]
pub(crate) struct MomentumObserver {
    robot: Py<Robot>,
    own: Exclusive<robot_dynamics::control::MomentumObserver<Arc<Model>>>,
}

#[pymethods]
impl MomentumObserver {
    #[new]
    #[pyo3(signature = (robot, gains, *, thresholds=None, dissipation=false))]
    fn new(
        py: Python<'_>,
        robot: &Bound<'_, Robot>,
        gains: &Bound<'_, PyAny>,
        thresholds: Option<&Bound<'_, PyAny>>,
        dissipation: bool,
    ) -> PyResult<Self> {
        let own = robot.get();
        let gains = vector(py, own, "gains", gains)?;
        let model = Arc::new(own.model.clone());
        let mut observer =
            robot_dynamics::control::MomentumObserver::new(model, &gains).map_err(exception)?;
        if let Some(thresholds) = thresholds {
            let (_, thresholds) = shaped(py, "thresholds", thresholds, &[own.model.nv()])?;
            observer = observer.with_thresholds(&thresholds).map_err(exception)?;
        }
        let observer = if dissipation { observer.with_dissipation() } else { observer };
        Ok(Self { robot: robot.clone().unbind(), own: Exclusive::new(observer) })
    }

    /// Takes a sample, and returns r. The first sample only stores the state.
    ///
    /// Parameters
    /// ----------
    /// q : array_like, shape (nq,)
    ///     Configuration at this sample.
    /// v : array_like, shape (nv,)
    ///     Velocity at this sample.
    /// tau : array_like, shape (nv,)
    ///     Torque of the motors since the last sample [N·m or N].
    /// dt : float
    ///     Time since the last sample [s].
    ///
    /// Returns
    /// -------
    /// ndarray, shape (nv,)
    ///     r [N·m or N].
    ///
    /// Raises
    /// ------
    /// ShapeError
    ///     An array has the wrong shape.
    /// StateError
    ///     A number is not finite, or q is not a configuration.
    /// ControlError
    ///     `dt` is not positive, or a result overflows.
    fn update<'py>(
        &self,
        py: Python<'py>,
        q: &Bound<'py, PyAny>,
        v: &Bound<'py, PyAny>,
        tau: &Bound<'py, PyAny>,
        dt: f64,
    ) -> PyResult<Bound<'py, PyAny>> {
        let robot = self.robot.get();
        let (q, v) = (configuration(py, robot, q)?, vector(py, robot, "v", v)?);
        let tau = vector(py, robot, "tau", tau)?;
        let mut own = self.own.lock(py);
        array(py, own.update(&q, &v, &tau, dt).map_err(exception)?)
    }

    /// r (nv,) after the last sample [N·m or N].
    #[getter]
    fn external_torque<'py>(&self, py: Python<'py>) -> PyResult<Bound<'py, PyAny>> {
        array(py, self.own.lock(py).external_torque())
    }

    /// Coordinate with the largest |r| relative to its threshold, if it is above it.
    #[getter]
    fn collision(&self, py: Python<'_>) -> Option<usize> {
        self.own.lock(py).collision()
    }

    /// Sets r = 0 and forgets the last sample.
    fn reset(&self, py: Python<'_>) {
        self.own.lock(py).reset();
    }
}

/// Moves a reference by a measured wrench: M ẍ + D ẋ + K x = f for its displacement x = (d, φ).
///
/// The commanded position is pʳ + d, and the commanded rotation exp(φ) Rʳ, along the world's axes. A
/// controller of the position follows it. Steps are exact for a wrench that is held. With K = 0 the frame can
/// be led by hand.
///
/// Parameters
/// ----------
/// inertia : array_like, shape (6,)
///     M along x, y, z, rx, ry, rz [kg, kg·m²].
/// damping : array_like, shape (6,)
///     D [N·s/m, N·m·s/rad].
/// stiffness : array_like, shape (6,)
///     K [N/m, N·m/rad].
///
/// Raises
/// ------
/// ShapeError
///     An array has the wrong shape.
/// ValueError
///     An inertia is not positive, or a damping or a stiffness is negative.
///
/// Examples
/// --------
///
/// >>> lead = rd.Admittance([2.0] * 6, [40.0] * 6, [0.0] * 6)
/// >>> for _ in range(1000):
/// ...     pose, velocity, acceleration = lead.step(np.eye(4), [8.0, 0.0, 0.0, 0.0, 0.0, 0.0], 1e-3)
/// >>> float(velocity[0].round(9))  # 8 N against 40 N·s/m
/// 0.2
#[pyclass(frozen, module = "robot_dynamics._native")]
pub(crate) struct Admittance {
    own: Exclusive<robot_dynamics::control::Admittance>,
}

#[pymethods]
impl Admittance {
    #[new]
    fn new(
        inertia: &Bound<'_, PyAny>,
        damping: &Bound<'_, PyAny>,
        stiffness: &Bound<'_, PyAny>,
    ) -> PyResult<Self> {
        let own = robot_dynamics::control::Admittance::new(
            several("inertia", inertia)?,
            several("damping", damping)?,
            several("stiffness", stiffness)?,
        );
        Ok(Self { own: Exclusive::new(own.map_err(exception)?) })
    }

    /// Advances the displacement, and returns the command at the end: a reference of `TaskControl`.
    ///
    /// Parameters
    /// ----------
    /// reference : array_like, shape (4, 4), or tuple of three array_like
    ///     Pose in the world, alone or with velocity (6,) and acceleration (6,) along the world's axes.
    /// wrench : array_like, shape (6,)
    ///     Force, then moment about the frame's origin, along the world's axes [N, N·m].
    /// dt : float
    ///     Step [s].
    ///
    /// Returns
    /// -------
    /// tuple of ndarray
    ///     Commanded pose (4, 4), velocity (6,) and acceleration (6,).
    ///
    /// Raises
    /// ------
    /// ShapeError
    ///     An array has the wrong shape.
    /// ValueError
    ///     A number is not finite, or `dt` is not positive.
    #[allow(clippy::type_complexity)] // three arrays
    fn step<'py>(
        &self,
        py: Python<'py>,
        reference: &Bound<'py, PyAny>,
        wrench: &Bound<'py, PyAny>,
        dt: f64,
    ) -> PyResult<(Bound<'py, PyAny>, Bound<'py, PyAny>, Bound<'py, PyAny>)> {
        let (reference, wrench) = (pose_reference(reference)?, several("wrench", wrench)?);
        let command = self.own.lock(py).step(&reference, &wrench, dt).map_err(exception)?;
        let PoseReference { pose: Pose { rotation: r, translation: p }, velocity, acceleration } = command;
        let row = |i: usize| [r[i][0], r[i][1], r[i][2], p[i]];
        let pose = [row(0), row(1), row(2), [0.0, 0.0, 0.0, 1.0]];
        let velocity = [velocity.linear, velocity.angular];
        let acceleration = [acceleration.linear, acceleration.angular];
        let pose = filled(py, &[4, 4], pose.as_flattened())?;
        Ok((pose, array(py, velocity.as_flattened())?, array(py, acceleration.as_flattened())?))
    }

    /// Displacement (6,): d [m], then φ [rad].
    #[getter]
    fn displacement<'py>(&self, py: Python<'py>) -> PyResult<Bound<'py, PyAny>> {
        array(py, &self.own.lock(py).displacement())
    }

    /// Returns to the reference, at rest.
    fn reset(&self, py: Python<'_>) {
        self.own.lock(py).reset();
    }
}

/// Controls of a robot's actuators whose joint torque is nearest to a given one.
///
/// It minimizes ‖R f + c − τ‖² with f = diag(g) u + o, within the bounds of f and u. Redundant actuators
/// share the torque with the least sum of squares of f. With τ = g(q) this is gravity compensation through
/// gears, tendons and frames.
///
/// Parameters
/// ----------
/// robot : Robot
///     Robot with actuators.
///
/// Raises
/// ------
/// ControlError
///     The force of an actuator is not an affine function of its control.
///
/// Examples
/// --------
///
/// >>> robot = rd.loads('''<mujoco><worldbody><body><joint name="hinge" axis="0 1 0"/>
/// ...   <geom size="0.1" pos="0.5 0 0" mass="2"/></body></worldbody>
/// ...   <actuator><motor joint="hinge" gear="50" ctrlrange="-1 1"/></actuator></mujoco>''')
/// >>> controls, residual = rd.ControlAllocation(robot).controls([0.0], [0.0], robot.gravity([0.0]))
/// >>> bool(np.isclose(controls[0] * 50.0, robot.gravity([0.0])[0])), residual < 1e-9
/// (True, True)
#[pyclass(frozen, module = "robot_dynamics._native")]
pub(crate) struct ControlAllocation {
    robot: Py<Robot>,
    own: Exclusive<robot_dynamics::control::ControlAllocation<Arc<Model>>>,
}

#[pymethods]
impl ControlAllocation {
    #[new]
    fn new(robot: &Bound<'_, Robot>) -> PyResult<Self> {
        let model = Arc::new(robot.get().model.clone());
        let own = robot_dynamics::control::ControlAllocation::new(model).map_err(exception)?;
        Ok(Self { robot: robot.clone().unbind(), own: Exclusive::new(own) })
    }

    /// Controls for a torque at a state.
    ///
    /// Parameters
    /// ----------
    /// q : array_like, shape (nq,)
    ///     Configuration.
    /// v : array_like, shape (nv,)
    ///     Velocity.
    /// tau : array_like, shape (nv,)
    ///     Torque [N·m or N].
    ///
    /// Returns
    /// -------
    /// tuple of ndarray and float
    ///     Controls, one for each actuator, and the largest difference between a coordinate's torque and τ.
    ///
    /// Raises
    /// ------
    /// ShapeError
    ///     An array has the wrong shape.
    /// StateError
    ///     A number is not finite, or q is not a configuration.
    fn controls<'py>(
        &self,
        py: Python<'py>,
        q: &Bound<'py, PyAny>,
        v: &Bound<'py, PyAny>,
        tau: &Bound<'py, PyAny>,
    ) -> PyResult<(Bound<'py, PyAny>, f64)> {
        let robot = self.robot.get();
        let (q, v) = (configuration(py, robot, q)?, vector(py, robot, "v", v)?);
        let tau = vector(py, robot, "tau", tau)?;
        let mut controls = vec![0.0; robot.model.description().actuators.len()];
        let residual = self.own.lock(py).controls(&q, &v, &tau, &mut controls).map_err(exception)?;
        Ok((array(py, &controls)?, residual))
    }

    /// Operation of the electric motors at the torque and the speed of the last call of `controls`.
    ///
    /// The winding is at ambient temperature, and the current does not change.
    ///
    /// Returns
    /// -------
    /// ndarray, shape (actuators, 4)
    ///     Current [A], voltage [V], power that the motor takes [W], and the part of it that heats the
    ///     winding [W]; NaN for an actuator without a motor.
    fn motor_loads<'py>(&self, py: Python<'py>) -> PyResult<Bound<'py, PyAny>> {
        let own = self.own.lock(py);
        let rows: Vec<[f64; 4]> = own
            .motor_loads()
            .map(|load| {
                load.map_or([f64::NAN; 4], |load| [load.current, load.voltage, load.power, load.heat])
            })
            .collect();
        filled(py, &[rows.len(), 4], rows.as_flattened())
    }
}
