"""What the tests share: robots of every sort, and states of them."""

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

# Chains and trees, fixed and floating, with followers (gripper, hand).
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
        """Those of these names."""
        return [getattr(self, name) for name in names]


def load(name: str) -> rd.Robot:
    """A robot of the repository; a floating root where it has legs."""
    return rd.load(ROBOTS / f"{name}.urdf", floating_base=NAMES.get(name, False))


def states(robot: rd.Robot, count: int = 37, seed: int = 1) -> States:
    """Random states within the joint limits."""
    random = np.random.default_rng(seed)
    v, a, tau = random.uniform(-1.0, 1.0, (3, count, robot.nv))
    cotangent, coordinates = random.uniform(-1.0, 1.0, (count, robot.nv)), random.uniform(-1.0, 1.0, (count, robot.nq))
    return States(robot.random_configuration(count, seed=seed), v, a, 10.0 * tau, cotangent, coordinates)


def interrupted(program: str) -> tuple[str, float]:
    """What a program that says `ready` writes to its errors when it is interrupted then, and how long it
    takes [s]."""
    # The package that is tested, and not the folder that the tests are started in.
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
    """One arm."""
    return load("panda")


@pytest.fixture(scope="session")
def quadruped() -> rd.Robot:
    """One robot whose root floats."""
    return load("quadruped")
