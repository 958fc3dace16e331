"""A robot's functions in CasADi: values and Jacobians agree with the library, and programs are solved."""

from pathlib import Path
from typing import Any

import numpy as np
import pytest
from numpy.testing import assert_allclose

import robot_dynamics as rd
from conftest import load, states
from test_examples import run

ca: Any = pytest.importorskip("casadi")

from robot_dynamics import casadi as rdc  # noqa: E402


@pytest.mark.parametrize("name", ["two_r", "gripper"])
def test_values_and_jacobians_are_the_librarys(name: str, tmp_path: Path) -> None:
    robot = load(name)
    s = states(robot, 3)
    for solution in ("inverse_dynamics", "forward_dynamics"):
        function = rdc.external(robot, solution, folder=tmp_path)
        third = s.a if solution == "inverse_dynamics" else s.tau
        symbols = [ca.MX.sym(own, robot.nv) for own in "qvx"]
        jacobian = ca.Function("J", symbols, [ca.jacobian(function(*symbols), ca.vertcat(*symbols))])
        for k in range(3):
            state = (s.q[k], s.v[k], third[k])
            expected = getattr(robot, solution)(*state)
            scale = max(1.0, np.abs(expected).max())
            assert_allclose(np.array(function(*state)).ravel(), expected, rtol=0, atol=1e-9 * scale)
            derivatives = [*getattr(robot, f"{solution}_derivatives")(*state)]
            if solution == "inverse_dynamics":
                derivatives.append(robot.mass_matrix(s.q[k]))
            found, expected = np.array(ca.DM(jacobian(*state))), np.hstack(derivatives)
            assert_allclose(found, expected, rtol=0, atol=1e-9 * max(1.0, np.abs(expected).max()))


def test_compiled_code_is_cached_for_each_robot(tmp_path: Path) -> None:
    robot = load("two_r")
    heavy, q = robot.with_gravity_scaled(2.0), [0.3, 1.2]
    first = rdc.external(robot, "gravity", folder=tmp_path)
    made = {file: file.stat().st_mtime_ns for file in tmp_path.iterdir()}
    again = rdc.external(robot, "gravity", folder=tmp_path)
    assert {file: file.stat().st_mtime_ns for file in tmp_path.iterdir()} == made and len(made) == 2
    other = rdc.external(heavy, "gravity", folder=tmp_path)
    assert_allclose(np.array(first(q)).ravel(), robot.gravity(q), rtol=1e-13)
    assert np.array_equal(np.array(again(q)), np.array(first(q)))
    assert_allclose(np.array(other(q)).ravel(), heavy.gravity(q), rtol=1e-13)
    rotation, place = rdc.external(robot, "frame_pose:tip")(q)
    pose = robot.frame_pose(q, "tip")
    assert_allclose(np.array(place).ravel(), pose[:3, 3], atol=1e-14)
    assert_allclose(np.array(rotation).ravel(), pose[:3, :3].ravel(), atol=1e-14)


def test_missing_functions_and_compilers_raise_errors(monkeypatch: pytest.MonkeyPatch, tmp_path: Path) -> None:
    robot = load("two_r")
    with pytest.raises(rd.GenerateError, match="wisdom"):
        rdc.external(robot, "wisdom")
    with pytest.raises(rd.GenerateError, match="nose"):
        rdc.external(robot, "frame_pose:nose")
    monkeypatch.setenv("CC", "no-such-compiler")
    with pytest.raises(rd.GenerateError, match="no C compiler: no-such-compiler not found"):
        rdc.external(robot, "bias", folder=tmp_path)
    monkeypatch.setenv("CC", "false")
    with pytest.raises(rd.GenerateError, match="does not compile"):
        rdc.external(robot, "bias", folder=tmp_path)
    assert not any(tmp_path.iterdir())


def test_an_arm_reaches_with_the_least_cost(tmp_path: Path) -> None:
    found = run("reach", tmp_path)
    # Away from the middles of the pieces the torques are nearly the same, and within their limits.
    assert found["costs"][0] == pytest.approx(found["cost"], rel=0.05) and found["use"] < 1.0
    assert found["costs"][0] < 0.6 * found["costs"][1]
    assert found["miss"] < 1e-3 and found["speed"] < 1e-2
