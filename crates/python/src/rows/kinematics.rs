//! Poses, velocities, accelerations and Jacobians of frames, and those of the centre of mass.

use pyo3::prelude::*;
use robot_dynamics::algorithms::{
    ReferenceFrame, frame_acceleration as acceleration, frame_bias_acceleration as bias,
    frame_velocity as velocity,
};
use robot_dynamics::derivatives::{
    FrameAccelerationDerivativesMut, FrameAccelerationInputs,
    frame_acceleration_derivatives as acceleration_derivatives,
    frame_velocity_derivative as velocity_derivative,
};
use robot_dynamics::quantity::Quantity;

use super::table::{frame_rows, operand, rows, six};
use crate::call::call;
use crate::robot::Robot;
use crate::row::Shape::Poses;
use crate::row::Work::{Each, Quantity as Of};
use crate::row::{Row, Work, of_frame};

#[pymethods]
impl Robot {
    /// `world_from_frame` of frames, as homogeneous matrices [R p; 0 1]: x_world = R x_frame + p.
    ///
    /// Parameters
    /// ----------
    /// q : array_like, shape (..., nq)
    ///     Configuration.
    /// frames : sequence of str or int, optional
    ///     Names of frames, or their indices in `frame_names`; default: all frames, in the order of
    ///     `frame_names`.
    /// out : ndarray, shape (..., frames, 4, 4), optional
    ///     Array that receives the result.
    /// threads : int, optional
    ///     Threads for a batch; default: `num_threads()`.
    ///
    /// Returns
    /// -------
    /// ndarray, shape (..., frames, 4, 4)
    ///     `world_from_frame` of each frame.
    ///
    /// Raises
    /// ------
    /// FrameError
    ///     A frame does not exist.
    /// StateError
    ///     The state is invalid; `BadStatesError` for a batch.
    /// ShapeError
    ///     An array has the wrong shape.
    /// DTypeError
    ///     An array is neither float64 nor float32, or both occur.
    ///
    /// Examples
    /// --------
    ///
    /// >>> robot = rd.example("two_r")
    /// >>> robot.frame_poses([0.0, np.pi / 2], ["tip"])[0, :3, 3].round(12)  # 1 m along x, then 1 m up
    /// array([1., 0., 1.])
    #[pyo3(signature = (q, frames=None, *, out=None, threads=None))]
    fn frame_poses<'py>(
        &self,
        py: Python<'py>,
        q: &Bound<'py, PyAny>,
        frames: Option<Vec<Bound<'py, PyAny>>>,
        out: Option<&Bound<'py, PyAny>>,
        threads: Option<&Bound<'py, PyAny>>,
    ) -> PyResult<Bound<'py, PyAny>> {
        const ROW: Row =
            Row { name: "frame_poses", operands: &[operand!(q)], results: &[Poses], work: Work::Poses };
        let Some(frames) = frames else { return call(py, self, &ROW, &[q], &self.frames, out, threads) };
        let frames: Vec<_> = frames.iter().map(|frame| self.frame_of(frame)).collect::<PyResult<_>>()?;
        call(py, self, &ROW, &[q], &frames, out, threads)
    }
}

rows! {
    /// `world_from_frame` of one frame, as a homogeneous matrix [R p; 0 1]: x_world = R x_frame + p.
    frame_pose(q) at frame => [Pose "`world_from_frame`."]
    /// >>> rd.example("two_r").frame_pose([0.0, np.pi / 2], "tip")[:3, 3].round(12)
    /// array([1., 0., 1.])
    = Work::Poses;

    /// The centre of mass, in the world.
    center_of_mass(q) => [Point "Position in the world [m]."]
    /// >>> rd.example("two_r").center_of_mass([0.0, 0.0]).round(12)  # (2 · 0.5 + 1 · 1.5) / 3
    /// array([0.83333333, 0.        , 0.        ])
    = Of(Quantity::CenterOfMass);

    /// The Jacobian of the centre of mass, along the world's axes.
    center_of_mass_jacobian(q) => [Rows(3) "J, along the world's axes."]
    /// >>> robot, q, v = rd.example("two_r"), [0.3, 1.2], [1.0, -2.0]
    /// >>> bool(np.allclose(robot.center_of_mass_jacobian(q) @ v, robot.center_of_mass_velocity(q, v)))
    /// True
    = Of(Quantity::CenterOfMassJacobian);

    /// The velocity of the centre of mass, along the world's axes.
    center_of_mass_velocity(q, v) => [Point "Velocity, along the world's axes [m/s]."]
    /// >>> rd.example("two_r").center_of_mass_velocity([0.0, 0.0], [1.2, 0.0]).round(12)  # upwards
    /// array([0., 0., 1.])
    = Each(|m, s, x, _, [out, ..]| {
        out.copy_from_slice(&robot_dynamics::algorithms::center_of_mass_velocity(m, &mut s.workspace, x[0], x[1]));
    });

    /// J̇ v of `center_of_mass_jacobian`: the acceleration of the centre of mass without a.
    center_of_mass_bias_acceleration(q, v) => [Point "Acceleration, along the world's axes [m/s²]."]
    /// >>> rd.example("two_r").center_of_mass_bias_acceleration([0.0, 0.0], [1.2, 0.0]).round(12)
    /// array([-1.2,  0. ,  0. ])
    = Each(|m, s, x, _, [out, ..]| {
        out.copy_from_slice(&robot_dynamics::algorithms::center_of_mass_bias_acceleration(m, &mut s.workspace, x[0], x[1]));
    });

    /// ∂(center_of_mass_velocity)/∂q.
    ///
    /// Derivatives by q are by displacements q ⊕ δq.
    center_of_mass_velocity_derivative(q, v) => [Rows(3) "Derivative by q, along the world's axes."]
    /// >>> rd.example("two_r").center_of_mass_velocity_derivative([0.0, 0.0], [1.2, 0.0])[0].round(12)
    /// array([-1. , -0.2])
    = Each(|m, s, x, _, [out, ..]| {
        robot_dynamics::derivatives::center_of_mass_velocity_derivative(m, &mut s.workspace, x[0], x[1], out);
    });
}

frame_rows! {
    /// A frame's Jacobian J: `frame_velocity` is J v in the same reference frame.
    ///
    /// Pinocchio has the same reference frames by the same names.
    frame_jacobian(q) => [Rows(6) "J, linear rows, then angular rows."]
    /// >>> robot, q = rd.example("two_r"), [0.0, np.pi / 2]
    /// >>> robot.frame_jacobian(q, "tip")[[0, 2]].round(12) + 0.0  # along x, and up
    /// array([[-1., -1.],
    ///        [ 1.,  0.]])
    /// >>> R = robot.frame_pose(q, "tip")[:3, :3]
    /// >>> own, world = robot.frame_jacobian(q, "tip", "local"), robot.frame_jacobian(q, "tip")
    /// >>> bool(np.allclose(R @ own[:3], world[:3]))
    /// True
    /// >>> robot.frame_jacobian(q, "tip", "world")[4]  # both joints rotate about −y
    /// array([-1., -1.])
    = [
        Of(Quantity::FrameJacobianLocal),
        Of(Quantity::FrameJacobianWorld),
        Of(Quantity::FrameJacobianLocalWorldAligned),
    ];

    /// A frame's velocity: J v with J of `frame_jacobian` in the same reference frame.
    ///
    /// By `reference_frame`, ``"local"`` is ṗ of the frame's origin p and ω along the frame's axes, and
    /// ``"local_world_aligned"`` both along the world's axes. In ``"world"`` they are ṗ − ω × p and ω along
    /// the world's axes.
    frame_velocity(q, v) => [Six "Linear [m/s], then angular [rad/s]."]
    /// >>> robot, q, v = rd.example("two_r"), [0.0, np.pi / 2], [1.0, 0.5]
    /// >>> bool(np.allclose(robot.frame_velocity(q, v, "tip"), robot.frame_jacobian(q, "tip") @ v))
    /// True
    /// >>> robot.frame_velocity([0.0, 0.0], [1.0, 0.0], "tip", "local").round(12)
    /// array([ 0.,  0.,  2.,  0., -1.,  0.])
    /// >>> robot.frame_velocity([0.0, 0.0], [1.0, 0.0], "tip", "world").round(12)
    /// array([ 0.,  0.,  0.,  0., -1.,  0.])
    = of_frame(|m, s, x, f, seen, [out, ..]| {
        let twist = velocity(m, &mut s.workspace, x[0], x[1], f, seen);
        six(out, twist.linear, twist.angular);
    });

    /// A frame's acceleration: the time derivative of the numbers of `frame_velocity` in the same reference
    /// frame, J a + J̇ v. It does not include gravity.
    ///
    /// In ``"local_world_aligned"`` it is p̈, the classical acceleration of the frame's origin. In
    /// ``"local"`` it is the spatial acceleration p̈ − ω × ṗ along the frame's axes, and in ``"world"`` that
    /// at the world's origin. These two equal Pinocchio's ``getFrameAcceleration``. Its
    /// ``getFrameAcceleration(LOCAL_WORLD_ALIGNED)`` is p̈ − ω × ṗ; its
    /// ``getFrameClassicalAcceleration(LOCAL_WORLD_ALIGNED)`` equals this function.
    frame_acceleration(q, v, a) => [Six "Linear [m/s²], then angular [rad/s²]."]
    /// >>> robot, zero = rd.example("two_r"), [0.0, 0.0]
    /// >>> robot.frame_acceleration(zero, [1.0, 0.0], zero, "tip").round(12)[:2]  # −ω² r
    /// array([-2.,  0.])
    /// >>> robot.frame_acceleration(zero, zero, [1.0, 0.0], "tip", "local").round(12)
    /// array([ 0.,  0.,  2.,  0., -1.,  0.])
    /// >>> robot.frame_acceleration(zero, zero, [1.0, 0.0], "tip", "world").round(12)
    /// array([ 0.,  0.,  0.,  0., -1.,  0.])
    = of_frame(|m, s, x, f, seen, [out, ..]| {
        let rate = acceleration(m, &mut s.workspace, x[0], x[1], x[2], f, seen);
        six(out, rate.linear, rate.angular);
    });

    /// J̇ v of `frame_jacobian` in the same reference frame: `frame_acceleration` at a = 0.
    frame_bias_acceleration(q, v) => [Six "Linear [m/s²], then angular [rad/s²]."]
    /// >>> robot = rd.example("two_r")
    /// >>> robot.frame_bias_acceleration([0.0, 0.0], [1.0, 0.0], "tip").round(12)[:2]
    /// array([-2.,  0.])
    /// >>> robot.frame_bias_acceleration([0.0, 0.0], [0.0, 0.0], "tip", "local") @ np.ones(6)
    /// np.float64(0.0)
    = of_frame(|m, s, x, f, seen, [out, ..]| {
        let rate = bias(m, &mut s.workspace, x[0], x[1], f, seen);
        six(out, rate.linear, rate.angular);
    });

    /// ∂/∂q of `frame_velocity` in the same reference frame; ∂/∂v is `frame_jacobian`.
    ///
    /// Derivatives by q are by displacements q ⊕ δq.
    frame_velocity_derivative(q, v) => [Rows(6) "Derivative by q, linear rows, then angular rows."]
    /// >>> robot = rd.example("two_r")
    /// >>> robot.frame_velocity_derivative([0.0, 0.0], [1.0, 0.0], "tip")[0].round(12)
    /// array([-2., -1.])
    /// >>> robot.frame_velocity_derivative([0.0, 0.0], [1.0, 0.0], "tip", "local")[0].round(12)
    /// array([0., 1.])
    = of_frame(|m, s, x, f, seen, [out, ..]| {
        velocity_derivative(m, &mut s.workspace, x[0], x[1], f, seen, out);
    });

    /// ∂/∂q and ∂/∂v of `frame_acceleration` in the same reference frame; ∂/∂a is `frame_jacobian`.
    ///
    /// Derivatives by q are by displacements q ⊕ δq.
    frame_acceleration_derivatives(q, v, a) => FrameAccelerationDerivatives[
        Rows(6) by_position "derivative by q",
        Rows(6) by_velocity "derivative by v",
    ]
    /// >>> robot, zero = rd.example("two_r"), [0.0, 0.0]
    /// >>> robot.frame_acceleration_derivatives(zero, [1.0, 0.0], zero, "tip").by_velocity[0].round(12)
    /// array([-4., -2.])
    /// >>> robot.frame_acceleration_derivatives(zero, zero, [1.0, 0.0], "tip", "local").by_position[0].round(12)
    /// array([0., 1.])
    = of_frame(|m, s, x, f, seen, [by_q, by_v, ..]| {
        let inputs = FrameAccelerationInputs { q: x[0], v: x[1], a: x[2], frame: f, reference_frame: seen };
        let results = FrameAccelerationDerivativesMut { by_position: by_q, by_velocity: by_v };
        acceleration_derivatives(m, &mut s.workspace, inputs, results);
    });
}
