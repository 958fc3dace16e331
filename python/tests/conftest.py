"""Robots and random states for the tests."""

import os
import signal
import subprocess
import sys
import time
from dataclasses import dataclass
from pathlib import Path

import numpy as np
import pytest
from numpy.typing import NDArray

import robot_dynamics as rd

ROBOTS = Path(__file__).parents[2] / "robots"

# Chains and trees, with fixed and floating base, and with mimic joints (gripper, hand).
NAMES = {
    "two_r": False,
    "panda": False,
    "gantry": False,
    "gripper": False,
    "dual_arm": False,
    "quadruped": True,
    "humanoid": True,
}


@dataclass(frozen=True)
class States:
    """Random states of a robot, the first axis being the batch."""

    q: NDArray[np.float64]
    v: NDArray[np.float64]
    a: NDArray[np.float64]
    tau: NDArray[np.float64]
    cotangent: NDArray[np.float64]
    coordinates: NDArray[np.float64]

    def given(self, names: list[str]) -> list[NDArray[np.float64]]:
        """Arrays of these names."""
        return [getattr(self, name) for name in names]


def present(array: NDArray[np.float64] | None) -> NDArray[np.float64]:
    """An array that must not be missing."""
    assert array is not None
    return array


def load(name: str) -> rd.Robot:
    """Load a robot of the repository, with a floating base if it has legs."""
    return rd.load(ROBOTS / f"{name}.urdf", floating_base=NAMES.get(name, False))


def states(robot: rd.Robot, count: int = 37, seed: int = 1) -> States:
    """Random states within the joint limits."""
    random = np.random.default_rng(seed)
    v, a, tau = random.uniform(-1.0, 1.0, (3, count, robot.nv))
    cotangent, coordinates = random.uniform(-1.0, 1.0, (count, robot.nv)), random.uniform(-1.0, 1.0, (count, robot.nq))
    return States(robot.random_configuration(count, seed=seed), v, a, 10.0 * tau, cotangent, coordinates)


def interrupted(program: str) -> tuple[str, float]:
    """Interrupt a program after it prints `ready`; returns its standard error and the time it takes [s]."""
    # Import the tested package, not the working directory of the tests.
    environment = {**os.environ, "PYTHONPATH": str(Path(rd.__file__).parents[1])}
    command = [sys.executable, "-P", "-c", program]
    with subprocess.Popen(
        command, stdout=subprocess.PIPE, stderr=subprocess.PIPE, text=True, env=environment
    ) as process:
        assert process.stdout is not None and process.stdout.readline() == "ready\n"
        time.sleep(0.5)
        begun = time.perf_counter()
        process.send_signal(signal.SIGINT)
        try:
            _, errors = process.communicate(timeout=30)
        finally:
            process.kill()
        assert process.returncode != 0
    return errors, time.perf_counter() - begun


@pytest.fixture(params=NAMES, scope="session")
def robot(request: pytest.FixtureRequest) -> rd.Robot:
    """Each robot in turn."""
    return load(request.param)


@pytest.fixture(scope="session")
def panda() -> rd.Robot:
    """A robot arm with fixed base."""
    return load("panda")


@pytest.fixture(scope="session")
def quadruped() -> rd.Robot:
    """A robot with floating base."""
    return load("quadruped")
