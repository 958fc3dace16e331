"""The fastest motion along paths of the Panda: this package beside TOPP-RA, on one path and one grid.

    pip install ./python toppra
    python bench/peers/paths.py [--rounds N]

Both take the natural cubic spline with the same knots, limits of torque, velocity and acceleration, and the
grid points of this package's result. TOPP-RA computes torques by this package's inverse dynamics, in Python;
that time is given apart, as the time of its constraints. The time of this package includes its refinement of
the grid, the verification and 501 samples. Times are medians of all rounds, with the smallest and the
largest.
"""

import argparse
import logging
import statistics
import time
from collections.abc import Callable
from pathlib import Path
from typing import Any

import numpy as np
import toppra
from toppra import algorithm, constraint

import robot_dynamics as rd

ROBOTS = Path(__file__).parents[2] / "robots"
ACCELERATION = np.array([15.0, 7.5, 10.0, 12.5, 15.0, 20.0, 20.0])
SMOOTH = np.array(
    [
        [0.0, -0.4, 0.0, -2.2, 0.0, 1.9, 0.8],
        [0.8, 0.3, -0.4, -1.4, 0.5, 1.2, 1.4],
        [1.4, 0.9, 0.3, -0.9, -0.6, 2.3, 0.2],
        [0.3, 0.5, 0.9, -1.9, -1.2, 1.5, -0.9],
        [-0.9, -0.2, 0.4, -2.5, 0.1, 2.8, 0.5],
    ]
)


def knots_of(waypoints: np.ndarray) -> np.ndarray:
    """Centripetal knots on [0, 1], as `time_optimal` uses them."""
    steps = np.linalg.norm(np.diff(waypoints, axis=0), axis=1) ** 0.5
    ends = np.cumsum(steps)
    return np.concatenate([[0.0], ends / ends[-1]])


def noisy(count: int) -> np.ndarray:
    """Points of the smooth path with noise of 1e-3 rad."""
    spline = toppra.SplineInterpolator(knots_of(SMOOTH), SMOOTH, bc_type="natural")
    points = spline(np.linspace(0.0, 1.0, count))
    return points + np.random.default_rng(1).uniform(-1e-3, 1e-3, points.shape)


def timed(call: Callable[[], Any], rounds: int) -> tuple[Any, str]:
    """The result, and the median and range of the time [ms]."""
    result, times = call(), []
    for _ in range(rounds):
        start = time.perf_counter()
        call()
        times.append(1e3 * (time.perf_counter() - start))
    return result, f"{statistics.median(times):8.1f} ({min(times):.1f} to {max(times):.1f})"


def peer(robot: rd.Robot, waypoints: np.ndarray, grid: np.ndarray) -> tuple[Any, Callable[[], float | None]]:
    """The constraints of TOPP-RA, and a call that solves for the duration."""
    path = toppra.SplineInterpolator(knots_of(waypoints), waypoints, bc_type="natural")
    velocity, effort = robot.limits.velocity, robot.limits.effort

    def both(limit: np.ndarray) -> np.ndarray:
        return np.column_stack([-limit, limit])

    limits = [
        constraint.JointVelocityConstraint(both(velocity)),
        constraint.JointAccelerationConstraint(both(ACCELERATION)),
        constraint.JointTorqueConstraint(
            lambda q, v, a: robot.inverse_dynamics(q, v, a),
            both(effort),
            np.zeros(robot.nv),
            discretization_scheme=constraint.DiscretizationType.Interpolation,
        ),
    ]

    def solve() -> float | None:
        solver = algorithm.TOPPRA(limits, path, gridpoints=grid, solver_wrapper="seidel")
        _, speeds, _ = solver.compute_parameterization(0.0, 0.0)
        if speeds is None:
            return None
        return float(np.sum(2.0 * np.diff(grid) / (speeds[1:] + speeds[:-1])))

    return (limits, path), solve


def main() -> None:
    parser = argparse.ArgumentParser(description=__doc__.splitlines()[0])
    parser.add_argument("--rounds", type=int, default=15)
    rounds = parser.parse_args().rounds
    logging.getLogger("toppra").setLevel(logging.ERROR)
    robot = rd.load(ROBOTS / "panda.urdf")
    print(f"{'path':>22} {'pieces':>7} {'duration [s]':>13} {'TOPP-RA [s]':>12} {'this [ms]':>26} {'TOPP-RA [ms]':>26}")
    for name, waypoints, intervals in (
        ("5 waypoints", SMOOTH, 200),
        ("5 waypoints", SMOOTH, 1000),
        ("200 noisy waypoints", noisy(200), 1000),
    ):
        def own() -> rd.TimedPath:
            return robot.time_optimal(waypoints, acceleration=ACCELERATION, intervals=intervals)

        path, own_time = timed(own, rounds)
        (limits, peer_path), solve = peer(robot, waypoints, path.grid)
        duration, peer_time = timed(solve, max(3, rounds // 5))
        _, constraints = timed(lambda: [one.compute_constraint_params(peer_path, path.grid) for one in limits], 3)
        other = "none" if duration is None else f"{duration:.5f}"
        print(
            f"{name:>22} {len(path.grid) - 1:7} {path.duration:13.5f} {other:>12} {own_time:>26} {peer_time:>26}"
            f"  of it constraints {constraints.strip()}"
        )


if __name__ == "__main__":
    main()
