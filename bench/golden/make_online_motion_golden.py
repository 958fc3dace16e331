#!/usr/bin/env python3
"""Writes testdata/online_motion/golden.json: the motions of Ruckig from random states to random targets.

    python3 bench/golden/make_online_motion_golden.py

Each case has the limits, states and targets of three coordinates, the duration of the synchronised motion,
the shortest duration of each coordinate alone, and q, v and a at a third of the duration. Half of the cases
start and end at rest; the others move.
"""

import importlib.metadata

import environment

REQUIREMENTS = environment.HERE / "motion_requirements.txt"
if __name__ == "__main__":
    environment.enter(REQUIREMENTS)

import numpy as np  # noqa: E402
import ruckig  # noqa: E402

import golden_file  # noqa: E402

CASES = 300
SEED = 20250611


def target_is_reachable(limits, v, a):
    """Whether the velocity around a state stays within its limit; Ruckig refuses other targets."""
    turn = 0.5 * a**2 / limits["jerk"]
    return np.all(np.abs(v) + turn <= limits["velocity"])


def case(random, moves):
    """One random case, and the motion of Ruckig."""
    while True:
        limits = {
            "velocity": random.uniform(0.5, 3.0, 3),
            "acceleration": random.uniform(1.0, 6.0, 3),
            "jerk": random.uniform(5.0, 60.0, 3),
        }
        states = []
        for _ in range(2):
            v, a = (random.uniform(-0.9, 0.9, 3) * limits[name] * moves for name in ("velocity", "acceleration"))
            states.append((random.uniform(-2.0, 2.0, 3), v, a))
        if all(target_is_reachable(limits, v, a) for _, v, a in states):
            break
    motion = ruckig.InputParameter(3)
    motion.current_position, motion.current_velocity, motion.current_acceleration = states[0]
    motion.target_position, motion.target_velocity, motion.target_acceleration = states[1]
    motion.max_velocity, motion.max_acceleration, motion.max_jerk = (
        limits[name] for name in ("velocity", "acceleration", "jerk")
    )
    trajectory = ruckig.Trajectory(3)
    result = ruckig.Ruckig(3).calculate(motion, trajectory)
    assert result == ruckig.Result.Working, result
    names = ("q", "v", "a")
    return {
        **limits,
        "start": dict(zip(names, states[0])),
        "target": dict(zip(names, states[1])),
        "duration": trajectory.duration,
        "alone": trajectory.independent_min_durations,
        "third": dict(zip(names, trajectory.at_time(trajectory.duration / 3.0))),
    }


def main():
    random = np.random.default_rng(SEED)
    packages = {name: importlib.metadata.version(name) for name in ("ruckig", "numpy")}
    record = {
        "provenance": {
            "tool": "Ruckig",
            "version": packages["ruckig"],
            "packages": packages,
            "command": "python3 bench/golden/make_online_motion_golden.py",
        },
        "cases": [case(random, float(k % 2)) for k in range(CASES)],
    }
    path = environment.ROOT / "testdata" / "online_motion" / "golden.json"
    path.parent.mkdir(exist_ok=True)
    golden_file.write(path, record)
    print(f"{path}: {CASES} cases")


if __name__ == "__main__":
    main()
