"""The runs of `testdata/same_motion`, stepped and in one run, against the table shared by all front ends."""

import json
from typing import Any

import numpy as np
from numpy.typing import NDArray

import robot_dynamics as rd
from conftest import ROBOTS

Array = NDArray[np.float64]

FOLDER = ROBOTS.parent / "testdata" / "same_motion"


def test_python_takes_the_librarys_steps() -> None:
    runs = json.loads((FOLDER / "runs.json").read_text(encoding="utf-8"))
    lines = (FOLDER / "states.tsv").read_text(encoding="utf-8").splitlines()
    assert len(runs) == len(lines) > 0
    rounds_otherwise = None
    for run, line in zip(runs, lines, strict=True):
        name, numbers = line.split("\t")
        assert name == run["name"]
        expected = np.array([float(x) for x in numbers.split(" ")])
        stepped, whole = stepped_state(run), whole_state(run)
        assert np.array_equal(stepped, whole), f"{name}: stepped and in one run"
        if rounds_otherwise is None:
            # On a machine with other rounding, all runs have other bits.
            rounds_otherwise = not np.array_equal(stepped, expected)
        if not rounds_otherwise:
            assert np.array_equal(stepped, expected), name
        size = max(1.0, float(np.abs(expected).max()))
        np.testing.assert_allclose(stepped, expected, rtol=0.0, atol=run.get("rounding", 1e-9) * size, err_msg=name)


def options(run: dict[str, Any]) -> dict[str, Any]:
    """The options that a run and a simulation share."""
    return {
        "dt": run["step"],
        "integrator": run.get("method"),
        "conservative": run.get("conservative", False),
        "without": run.get("without", []),
        "ground": rd.Ground() if run.get("ground") else None,
    }


def start(run: dict[str, Any]) -> tuple[rd.Robot, Array, Array, dict[str, float]]:
    """The robot, its state and its controls."""
    robot = rd.load(ROBOTS / run["file"], floating_base=run.get("floating_base", False))
    sim = rd.Simulation(robot, **options(run))
    pose = run.get("pose", {})
    sim.reset(pose=pose if isinstance(pose, str) else None)
    q, v = sim.q.copy(), sim.v.copy()
    joints = {joint.name: joint for joint in robot.joints}
    for name, values in ({} if isinstance(pose, str) else pose).items():
        q[joints[name].q] = values
    for name, value in run.get("velocity", {}).items():
        v[joints[name].v] = value
    controls = dict(zip(sim.control_names, sim.controls.tolist(), strict=True)) | run.get("controls", {})
    return robot, q, v, controls


def stepped_state(run: dict[str, Any]) -> Array:
    robot, q, v, controls = start(run)
    sim = rd.Simulation(robot, **options(run))
    sim.reset(q, v, controls=controls or None)
    for _ in range(run["steps"]):
        sim.step()
    return np.concatenate([sim.q, sim.v])


def whole_state(run: dict[str, Any]) -> Array:
    robot, q, v, controls = start(run)
    motion = robot.simulate(q, v, duration=run["step"] * run["steps"], controls=controls or None, **options(run))
    return np.concatenate([motion.q[-1], motion.v[-1]])
