"""Sensors and joint reactions, against other methods of the same robot."""

import numpy as np
import pytest
import robot_dynamics as rd
from numpy.testing import assert_allclose

FILE = """<mujoco><compiler angle="radian"/><worldbody><body name="arm">
  <joint name="hinge" axis="0 1 0" range="-1 1"/>
  <inertial pos="0.3 0 0" mass="2" diaginertia="0.1 0.1 0.1"/>
  <body name="tool" pos="0.6 0 0">
    <inertial pos="0.1 0 0" mass="0.5" diaginertia="0.01 0.01 0.01"/>
    <site name="pad" pos="0.2 0 0" size="0.05"/>
  </body>
</body></worldbody>
<actuator><motor name="motor" joint="hinge" gear="3"/></actuator>
<sensor>
  <accelerometer name="imu" site="pad"/> <touch name="touch" site="pad"/> <actuatorfrc name="drive" actuator="motor"/>
  <jointactuatorfrc name="torque" joint="hinge"/> <force name="flange" site="pad"/>
</sensor></mujoco>"""


@pytest.fixture
def arm() -> rd.Robot:
    """Two links welded together on a hinge, with the sensors of its file."""
    return rd.loads(FILE)


def test_sensors_of_a_file_have_names_kinds_and_values(arm: rd.Robot) -> None:
    sizes = {"imu": 3, "touch": 1, "drive": 1, "torque": 1, "flange": 3}
    assert {sensor.name: sensor.size for sensor in arm.sensors} == sizes
    assert arm.sensors[0].kind == "accelerometer"
    q, v, a = [0.4], [1.5], [-2.0]
    tip = arm.frame_poses(q, ["pad"])[0]
    pressed = rd.PointForce("tool", tip[:3, 3], [0.0, 0.0, 7.0], normal=[0.0, 0.0, 1.0])
    shown = arm.sensor_values(q, v, a, actuator_forces=[0.5], wrenches=[pressed])
    rate = arm.frame_acceleration(q, v, a, "pad")[:3]
    assert_allclose(shown["imu"], tip[:3, :3].T @ (rate + [0, 0, 9.81]), rtol=0, atol=1e-12)
    assert_allclose([shown["touch"][0], shown["drive"][0], shown["torque"][0]], [7.0, 0.5, 1.5], rtol=0, atol=1e-12)
    assert arm.sensor_values(q, v, a)["touch"] == 0.0
    # The push applies this force, so the flange does not.
    flange = tip[:3, :3] @ shown["flange"]
    without = arm.sensor_values(q, v, a)["flange"]
    assert_allclose(tip[:3, :3] @ without - flange, [0.0, 0.0, 7.0], rtol=0, atol=1e-12)


def test_sensors_can_be_added_to_any_robot() -> None:
    reach = ("framepos", "panda_link8", "panda_link1")
    robot = rd.example("panda").with_sensors({"imu": ("accelerometer", "panda_link8"), "grip": reach})
    q, rest = robot.neutral(), np.zeros(robot.nv)
    shown = robot.sensor_values(q, rest, rest)
    pose, seen = robot.frame_poses(q, ["panda_link8", "panda_link1"])
    assert_allclose(shown["imu"], pose[:3, :3].T @ [0, 0, 9.81], rtol=0, atol=1e-12)
    assert_allclose(shown["grip"], seen[:3, :3].T @ (pose[:3, 3] - seen[:3, 3]), rtol=0, atol=1e-12)
    assert rd.example("panda").sensors == () and rd.example("panda").sensor_values(q, rest, rest) == {}
    with pytest.raises(rd.DescriptionError, match="nowhere"):
        robot.with_sensors({"x": ("gyro", "nowhere")})
    with pytest.raises(rd.DescriptionError, match="no kind `camera`"):
        robot.with_sensors({"x": ("camera", "panda_link8")})
    with pytest.raises(rd.StateError):
        robot.sensor_values(q, rest * np.nan, rest)


def test_reactions_along_the_axes_are_the_torques(arm: rd.Robot) -> None:
    q, v, a = np.linspace(-1, 1, 5)[:, None], np.ones((5, 1)), np.full((5, 1), -2.0)
    push = {"pad": [1.0, 2.0, 3.0, 0.1, 0.2, 0.3]}
    reactions = arm.joint_reactions(q, v, a, push)
    assert reactions.shape == (5, len(arm.joints), 6)
    hinge = next(k for k, joint in enumerate(arm.joints) if joint.name == "hinge")
    torques = arm.inverse_dynamics_with_wrenches(q, v, a, push)
    assert_allclose(reactions[:, hinge, 4], torques[:, 0], rtol=0, atol=1e-12)
    assert_allclose(arm.joint_reactions(q[2], v[2], a[2], push), reactions[2], rtol=0, atol=1e-12)
    # At rest the first joint carries everything.
    still = arm.joint_reactions([0.3], [0.0], [0.0])
    assert_allclose(np.linalg.norm(still[hinge, :3]), 9.81 * 2.5, rtol=1e-12)
