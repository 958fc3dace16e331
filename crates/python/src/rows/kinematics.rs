//! Frames and the centre of mass: places, velocities, accelerations, Jacobians, their slopes.

use pyo3::prelude::*;
use robot_dynamics::quantity::Quantity;

use super::table::{operand, rows, six};
use crate::call::call;
use crate::robot::Robot;
use crate::row::Shape::{Point, Pose, Poses, Rows, Six};
use crate::row::Work::{Each, Quantity as Of};
use crate::row::{Row, Work};

#[pymethods]
impl Robot {
    /// `world_from_frame` of frames, as homogeneous matrices [R p; 0 1]: x_world = R x_frame + p.
    ///
    /// q (..., nq) → (..., frames, 4, 4). `frames` lists names or indices; without it all frames, in the
    /// order of `frame_names`.
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
        let frames: Vec<_> = frames.iter().map(|frame| self.frame_of(py, frame)).collect::<PyResult<_>>()?;
        call(py, self, &ROW, &[q], &frames, out, threads)
    }
}

rows! {
    /// `world_from_frame` of one frame, as a homogeneous matrix [R p; 0 1]: x_world = R x_frame + p.
    ///
    /// q (..., nq) → (..., 4, 4).
    ///
    /// >>> rd.example("two_r").frame_pose([0.0, np.pi / 2], "tip")[:3, 3].round(12)
    /// array([1., 0., 1.])
    frame_pose(q) at frame => [Pose] Work::Poses;

    /// A frame's Jacobian along the world's axes, of the frame's origin (LOCAL_WORLD_ALIGNED).
    ///
    /// q (..., nq) → (..., 6, nv), rows linear then angular.
    ///
    /// >>> robot, q = rd.example("two_r"), [0.0, np.pi / 2]
    /// >>> robot.frame_jacobian_world_aligned(q, "tip")[[0, 2]].round(12) + 0.0  # along x, and up
    /// array([[-1., -1.],
    ///        [ 1.,  0.]])
    frame_jacobian_world_aligned(q) at frame => [Rows(6)] Of(Quantity::FrameJacobianWorldAligned);

    /// A frame's Jacobian along its own axes, of its origin (LOCAL).
    ///
    /// q (..., nq) → (..., 6, nv), rows linear then angular.
    ///
    /// >>> robot, q = rd.example("two_r"), [0.0, np.pi / 2]
    /// >>> R = robot.frame_pose(q, "tip")[:3, :3]
    /// >>> own, world = robot.frame_jacobian_in_frame(q, "tip"), robot.frame_jacobian_world_aligned(q, "tip")
    /// >>> bool(np.allclose(R @ own[:3], world[:3]))
    /// True
    frame_jacobian_in_frame(q) at frame => [Rows(6)] Of(Quantity::FrameJacobianInFrame);

    /// The Jacobian of the point of a frame's body that passes the world's origin, along the world's axes
    /// (WORLD).
    ///
    /// q (..., nq) → (..., 6, nv), rows linear then angular.
    ///
    /// >>> rd.example("two_r").frame_jacobian_in_world([0.0, np.pi / 2], "tip")[4]  # both turn about −y
    /// array([-1., -1.])
    frame_jacobian_in_world(q) at frame => [Rows(6)] Each(|m, s, x, f, [out, ..]| {
        robot_dynamics::algorithms::frame_jacobian_in_world(m, &mut s.workspace, x[0], f[0], out);
    });

    /// A frame's velocity along the world's axes, of its origin (LOCAL_WORLD_ALIGNED).
    ///
    /// q (..., nq), v (..., nv) → (..., 6), linear [m/s] then angular [rad/s].
    ///
    /// >>> robot, q, v = rd.example("two_r"), [0.0, np.pi / 2], [1.0, 0.5]
    /// >>> J = robot.frame_jacobian_world_aligned(q, "tip")
    /// >>> bool(np.allclose(robot.frame_velocity_world_aligned(q, v, "tip"), J @ v))
    /// True
    frame_velocity_world_aligned(q, v) at frame => [Six] Each(|m, s, x, f, [out, ..]| {
        let twist = robot_dynamics::algorithms::frame_velocity_world_aligned(m, &mut s.workspace, x[0], x[1], f[0]);
        six(out, twist.linear, twist.angular);
    });

    /// A frame's velocity along its own axes, of its origin (LOCAL).
    ///
    /// q (..., nq), v (..., nv) → (..., 6), linear [m/s] then angular [rad/s].
    ///
    /// >>> rd.example("two_r").frame_velocity_in_frame([0.0, 0.0], [1.0, 0.0], "tip").round(12)
    /// array([ 0.,  0.,  2.,  0., -1.,  0.])
    frame_velocity_in_frame(q, v) at frame => [Six] Each(|m, s, x, f, [out, ..]| {
        let twist = robot_dynamics::algorithms::frame_velocity_in_frame(m, &mut s.workspace, x[0], x[1], f[0]);
        six(out, twist.linear, twist.angular);
    });

    /// The velocity of the point of a frame's body that passes the world's origin, along the world's axes
    /// (WORLD).
    ///
    /// q (..., nq), v (..., nv) → (..., 6), linear [m/s] then angular [rad/s].
    ///
    /// >>> rd.example("two_r").frame_velocity_in_world([0.0, 0.0], [1.0, 0.0], "tip").round(12)
    /// array([ 0.,  0.,  0.,  0., -1.,  0.])
    frame_velocity_in_world(q, v) at frame => [Six] Each(|m, s, x, f, [out, ..]| {
        let twist = robot_dynamics::algorithms::frame_velocity_in_world(m, &mut s.workspace, x[0], x[1], f[0]);
        six(out, twist.linear, twist.angular);
    });

    /// A frame's acceleration as an observer in the world sees it, p̈ and ω̇ along the world's axes.
    ///
    /// q (..., nq), v (..., nv), a (..., nv) → (..., 6), linear [m/s²] then angular [rad/s²]. Gravity is not
    /// in it.
    ///
    /// >>> robot, zero = rd.example("two_r"), [0.0, 0.0]
    /// >>> robot.frame_classical_acceleration_world_aligned(zero, [1.0, 0.0], zero, "tip").round(12)[:2]  # −ω² r
    /// array([-2.,  0.])
    frame_classical_acceleration_world_aligned(q, v, a) at frame => [Six] Each(|m, s, x, f, [out, ..]| {
        let w = &mut s.workspace;
        let rate = robot_dynamics::algorithms::frame_classical_acceleration_world_aligned(m, w, x[0], x[1], x[2], f[0]);
        six(out, rate.linear, rate.angular);
    });

    /// A frame's spatial acceleration along its own axes: the rate of its velocity there (LOCAL).
    ///
    /// q (..., nq), v (..., nv), a (..., nv) → (..., 6), linear [m/s²] then angular [rad/s²]. Gravity is not
    /// in it.
    ///
    /// >>> robot, zero = rd.example("two_r"), [0.0, 0.0]
    /// >>> robot.frame_spatial_acceleration_in_frame(zero, zero, [1.0, 0.0], "tip").round(12)
    /// array([ 0.,  0.,  2.,  0., -1.,  0.])
    frame_spatial_acceleration_in_frame(q, v, a) at frame => [Six] Each(|m, s, x, f, [out, ..]| {
        let w = &mut s.workspace;
        let rate = robot_dynamics::algorithms::frame_spatial_acceleration_in_frame(m, w, x[0], x[1], x[2], f[0]);
        six(out, rate.linear, rate.angular);
    });

    /// A frame's spatial acceleration about the world's origin, along the world's axes (WORLD).
    ///
    /// q (..., nq), v (..., nv), a (..., nv) → (..., 6), linear [m/s²] then angular [rad/s²]. Gravity is not
    /// in it.
    ///
    /// >>> robot, zero = rd.example("two_r"), [0.0, 0.0]
    /// >>> robot.frame_spatial_acceleration_in_world(zero, zero, [1.0, 0.0], "tip").round(12)
    /// array([ 0.,  0.,  0.,  0., -1.,  0.])
    frame_spatial_acceleration_in_world(q, v, a) at frame => [Six] Each(|m, s, x, f, [out, ..]| {
        let w = &mut s.workspace;
        let rate = robot_dynamics::algorithms::frame_spatial_acceleration_in_world(m, w, x[0], x[1], x[2], f[0]);
        six(out, rate.linear, rate.angular);
    });

    /// J̇ v of `frame_jacobian_world_aligned`: a frame's acceleration without a.
    ///
    /// q (..., nq), v (..., nv) → (..., 6), linear [m/s²] then angular [rad/s²].
    ///
    /// >>> rd.example("two_r").frame_bias_acceleration_world_aligned([0.0, 0.0], [1.0, 0.0], "tip").round(12)[:2]
    /// array([-2.,  0.])
    frame_bias_acceleration_world_aligned(q, v) at frame => [Six] Each(|m, s, x, f, [out, ..]| {
        let rate = robot_dynamics::algorithms::frame_bias_acceleration_world_aligned(m, &mut s.workspace, x[0], x[1], f[0]);
        six(out, rate.linear, rate.angular);
    });

    /// J̇ v of `frame_jacobian_in_frame`.
    ///
    /// q (..., nq), v (..., nv) → (..., 6), linear [m/s²] then angular [rad/s²].
    ///
    /// >>> rd.example("two_r").frame_bias_acceleration_in_frame([0.0, 0.0], [0.0, 0.0], "tip") @ np.ones(6)
    /// np.float64(0.0)
    frame_bias_acceleration_in_frame(q, v) at frame => [Six] Each(|m, s, x, f, [out, ..]| {
        let rate = robot_dynamics::algorithms::frame_bias_acceleration_in_frame(m, &mut s.workspace, x[0], x[1], f[0]);
        six(out, rate.linear, rate.angular);
    });

    /// J̇ v of `frame_jacobian_in_world`.
    ///
    /// q (..., nq), v (..., nv) → (..., 6), linear [m/s²] then angular [rad/s²].
    ///
    /// >>> rd.example("two_r").frame_bias_acceleration_in_world([0.0, 0.0], [0.0, 0.0], "tip") @ np.ones(6)
    /// np.float64(0.0)
    frame_bias_acceleration_in_world(q, v) at frame => [Six] Each(|m, s, x, f, [out, ..]| {
        let rate = robot_dynamics::algorithms::frame_bias_acceleration_in_world(m, &mut s.workspace, x[0], x[1], f[0]);
        six(out, rate.linear, rate.angular);
    });

    /// ∂(frame_velocity_world_aligned)/∂q.
    ///
    /// q (..., nq), v (..., nv) → (..., 6, nv), by q as displacements q ⊕ δq; by v it is the Jacobian.
    ///
    /// >>> rd.example("two_r").frame_velocity_derivative_world_aligned([0.0, 0.0], [1.0, 0.0], "tip")[0].round(12)
    /// array([-2., -1.])
    frame_velocity_derivative_world_aligned(q, v) at frame => [Rows(6)] Each(|m, s, x, f, [out, ..]| {
        let w = &mut s.workspace;
        robot_dynamics::derivatives::frame_velocity_derivative_world_aligned(m, w, x[0], x[1], f[0], out);
    });

    /// ∂(frame_velocity_in_frame)/∂q.
    ///
    /// q (..., nq), v (..., nv) → (..., 6, nv), by q as displacements q ⊕ δq; by v it is the Jacobian.
    ///
    /// >>> rd.example("two_r").frame_velocity_derivative_in_frame([0.0, 0.0], [1.0, 0.0], "tip")[0].round(12)
    /// array([0., 1.])
    frame_velocity_derivative_in_frame(q, v) at frame => [Rows(6)] Each(|m, s, x, f, [out, ..]| {
        let w = &mut s.workspace;
        robot_dynamics::derivatives::frame_velocity_derivative_in_frame(m, w, x[0], x[1], f[0], out);
    });

    /// ∂(frame_classical_acceleration_world_aligned) by q and by v; by a it is the Jacobian.
    ///
    /// q (..., nq), v (..., nv), a (..., nv) → `by_position`, `by_velocity`, each (..., 6, nv).
    ///
    /// >>> robot, zero = rd.example("two_r"), [0.0, 0.0]
    /// >>> robot.frame_acceleration_derivatives_world_aligned(zero, [1.0, 0.0], zero, "tip").by_velocity[0].round(12)
    /// array([-4., -2.])
    frame_acceleration_derivatives_world_aligned(q, v, a) at frame => [Rows(6), Rows(6)]
        Each(|m, s, x, f, [by_q, by_v, ..]| {
            let w = &mut s.workspace;
            robot_dynamics::derivatives::frame_acceleration_derivatives_world_aligned(m, w, x[0], x[1], x[2], f[0], by_q, by_v);
        });

    /// ∂(frame_spatial_acceleration_in_frame) by q and by v; by a it is the Jacobian.
    ///
    /// q (..., nq), v (..., nv), a (..., nv) → `by_position`, `by_velocity`, each (..., 6, nv).
    ///
    /// >>> robot, zero = rd.example("two_r"), [0.0, 0.0]
    /// >>> robot.frame_acceleration_derivatives_in_frame(zero, zero, [1.0, 0.0], "tip").by_position[0].round(12)
    /// array([0., 1.])
    frame_acceleration_derivatives_in_frame(q, v, a) at frame => [Rows(6), Rows(6)]
        Each(|m, s, x, f, [by_q, by_v, ..]| {
            let w = &mut s.workspace;
            robot_dynamics::derivatives::frame_acceleration_derivatives_in_frame(m, w, x[0], x[1], x[2], f[0], by_q, by_v);
        });

    /// The centre of mass, in the world.
    ///
    /// q (..., nq) → (..., 3) [m].
    ///
    /// >>> rd.example("two_r").center_of_mass([0.0, 0.0]).round(12)  # (2 · 0.5 + 1 · 1.5) / 3
    /// array([0.83333333, 0.        , 0.        ])
    center_of_mass(q) => [Point] Of(Quantity::CenterOfMass);

    /// The Jacobian of the centre of mass, along the world's axes.
    ///
    /// q (..., nq) → (..., 3, nv).
    ///
    /// >>> robot, q, v = rd.example("two_r"), [0.3, 1.2], [1.0, -2.0]
    /// >>> bool(np.allclose(robot.center_of_mass_jacobian(q) @ v, robot.center_of_mass_velocity(q, v)))
    /// True
    center_of_mass_jacobian(q) => [Rows(3)] Of(Quantity::CenterOfMassJacobian);

    /// The velocity of the centre of mass, along the world's axes.
    ///
    /// q (..., nq), v (..., nv) → (..., 3) [m/s].
    ///
    /// >>> rd.example("two_r").center_of_mass_velocity([0.0, 0.0], [1.2, 0.0]).round(12)  # upwards
    /// array([0., 0., 1.])
    center_of_mass_velocity(q, v) => [Point] Each(|m, s, x, _, [out, ..]| {
        out.copy_from_slice(&robot_dynamics::algorithms::center_of_mass_velocity(m, &mut s.workspace, x[0], x[1]));
    });

    /// J̇ v of `center_of_mass_jacobian`: the acceleration of the centre of mass without a.
    ///
    /// q (..., nq), v (..., nv) → (..., 3) [m/s²].
    ///
    /// >>> rd.example("two_r").center_of_mass_bias_acceleration([0.0, 0.0], [1.2, 0.0]).round(12)
    /// array([-1.2,  0. ,  0. ])
    center_of_mass_bias_acceleration(q, v) => [Point] Each(|m, s, x, _, [out, ..]| {
        out.copy_from_slice(&robot_dynamics::algorithms::center_of_mass_bias_acceleration(m, &mut s.workspace, x[0], x[1]));
    });

    /// ∂(center_of_mass_velocity)/∂q.
    ///
    /// q (..., nq), v (..., nv) → (..., 3, nv), by q as displacements q ⊕ δq.
    ///
    /// >>> rd.example("two_r").center_of_mass_velocity_derivative([0.0, 0.0], [1.2, 0.0])[0].round(12)
    /// array([-1. , -0.2])
    center_of_mass_velocity_derivative(q, v) => [Rows(3)] Each(|m, s, x, _, [out, ..]| {
        robot_dynamics::derivatives::center_of_mass_velocity_derivative(m, &mut s.workspace, x[0], x[1], out);
    });
}
