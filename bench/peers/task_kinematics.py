"""Differential inverse kinematics: this package beside Pink and mink, on the same tasks and targets.

    pip install ./python pin-pink mink "qpsolvers[daqp]"
    python bench/peers/task_kinematics.py [--rounds N]

Each library follows the same moving poses for 4 s with steps of 5 ms: one quadratic program a step within
the limits of position and velocity, solved by DAQP in Pink and mink. A Panda follows one pose with a
posture. A humanoid with a floating base keeps its pelvis and its feet, and moves both hands. A step is
timed with its parts in Python: the median of all rounds, and the medians of the fastest and the slowest
round. The table also lists the largest error of position after two seconds, and the lines of code of each
side.
"""

import argparse
import inspect
import statistics
import tempfile
import time
from collections.abc import Callable, Iterator
from pathlib import Path
from typing import Any

import mink
import mujoco
import numpy as np
import pink
import pinocchio

import robot_dynamics as rd

ROBOTS = Path(__file__).parents[2] / "robots"
STEP, STEPS, POSTURE = 5e-3, 800, 1e-2

Targets = Callable[[float], dict[str, np.ndarray]]
Stepper = Iterator[np.ndarray]


def panda() -> tuple[rd.Robot, np.ndarray, Targets]:
    robot, start = rd.load(ROBOTS / "panda.urdf"), np.array([0.0, -0.4, 0.0, -2.2, 0.0, 1.9, 0.8])
    hand = robot.frame_pose(start, "panda_link8")

    def targets(t: float) -> dict[str, np.ndarray]:
        pose = hand.copy()
        pose[:3, 3] += [0.0, 0.15 * np.sin(2.0 * t), 0.1 * (1.0 - np.cos(2.0 * t))]
        return {"panda_link8": pose}

    return robot, start, targets


def humanoid() -> tuple[rd.Robot, np.ndarray, Targets]:
    robot = rd.load(ROBOTS / "humanoid.urdf", floating_base=True)
    start = robot.neutral()
    for side, sign in (("left", 1.0), ("right", -1.0)):
        bent = {"hip_pitch": -0.3, "knee": 0.6, "ankle_pitch": -0.3, "elbow": -1.2, "shoulder_roll": sign * 0.2}
        for name, angle in bent.items():
            joint = next(own for own in robot.joints if own.name == f"{side}_{name}")
            start[joint.q] = np.clip(angle, joint.limits.lower, joint.limits.upper)
    frames = ("pelvis", "left_foot", "right_foot", "left_hand", "right_hand")
    poses = {frame: robot.frame_pose(start, frame) for frame in frames}

    def targets(t: float) -> dict[str, np.ndarray]:
        moved = {frame: pose.copy() for frame, pose in poses.items()}
        moved["left_hand"][:3, 3] += [0.0, 0.0, 0.08 * np.sin(2.0 * t)]
        moved["right_hand"][:3, 3] += [0.08 * np.sin(2.0 * t), 0.0, 0.0]
        return moved

    return robot, start, targets


def own_side(robot: rd.Robot, start: np.ndarray, targets: Targets) -> Stepper:
    tasks = rd.TaskKinematics(robot)
    ids = {frame: tasks.add_pose(frame, pose) for frame, pose in targets(0.0).items()}
    tasks.add_posture(start, weight=POSTURE**2)
    q = start
    while True:
        t = yield q
        for frame, pose in targets(t).items():
            tasks.set_target(ids[frame], pose)
        q = tasks.step(q, dt=STEP).q


def pink_side(robot: rd.Robot, start: np.ndarray, targets: Targets) -> Stepper:
    file = ROBOTS / f"{robot.name}.urdf"
    floating = (pinocchio.JointModelFreeFlyer(),) if "floating_base" in robot.joint_names else ()
    model = pinocchio.buildModelFromUrdf(str(file), *floating)
    configuration = pink.Configuration(model, model.createData(), robot.to_pinocchio(start).q)
    tasks = {frame: pink.tasks.FrameTask(frame, 1.0, 1.0) for frame in targets(0.0)}
    posture = pink.tasks.PostureTask(POSTURE)
    posture.set_target_from_configuration(configuration)
    while True:
        t = yield robot.from_pinocchio(configuration.q).q
        for frame, pose in targets(t).items():
            tasks[frame].set_target(pinocchio.SE3(pose[:3, :3], pose[:3, 3]))
        velocity = pink.solve_ik(configuration, [*tasks.values(), posture], STEP, "daqp", safety_break=False)
        configuration.integrate_inplace(velocity, STEP)


def mink_side(robot: rd.Robot, start: np.ndarray, targets: Targets) -> Stepper:
    with tempfile.TemporaryDirectory() as folder:
        robot.write(Path(folder) / "robot.xml")
        model = mujoco.MjModel.from_xml_path(str(Path(folder) / "robot.xml"))
    configuration = mink.Configuration(model, robot.to_mujoco(start).qpos)
    bodies = {model.body(index).name for index in range(model.nbody)}
    sorts = {frame: "body" if frame in bodies else "site" for frame in targets(0.0)}
    tasks = {frame: mink.FrameTask(frame, sort, 1.0, 1.0) for frame, sort in sorts.items()}
    posture = mink.PostureTask(model, POSTURE)
    posture.set_target_from_configuration(configuration)
    speeds = {own.name: own.limits.velocity for own in robot.joints if np.isfinite(own.limits.velocity)}
    limits = [mink.ConfigurationLimit(model), mink.VelocityLimit(model, speeds)]
    while True:
        t = yield robot.from_mujoco(configuration.q).q
        for frame, pose in targets(t).items():
            tasks[frame].set_target(mink.SE3.from_matrix(pose))
        velocity = mink.solve_ik(configuration, [*tasks.values(), posture], STEP, "daqp", limits=limits)
        configuration.integrate_inplace(velocity, STEP)


def run(side: Callable[..., Any], robot: rd.Robot, start: np.ndarray, targets: Targets) -> tuple[list[float], float]:
    """The time of each step [s], and the largest error of position from the second second on [m]."""
    stepper = side(robot, start, targets)
    next(stepper)
    times, worst = [], 0.0
    for k in range(1, STEPS + 1):
        begin = time.perf_counter()
        q = stepper.send(k * STEP)
        times.append(time.perf_counter() - begin)
        if k * STEP >= 2.0:
            for frame, pose in targets(k * STEP).items():
                worst = max(worst, float(np.linalg.norm(robot.frame_pose(q, frame)[:3, 3] - pose[:3, 3])))
    return times, worst


def main() -> None:
    parser = argparse.ArgumentParser(description=__doc__.splitlines()[0])
    parser.add_argument("--rounds", type=int, default=5)
    rounds = parser.parse_args().rounds
    print(f"{'robot':>9} {'library':>13} {'a step [µs]':>12} {'rounds [µs]':>18} {'error [mm]':>11} {'lines':>6}")
    for robot, start, targets in (panda(), humanoid()):
        for name, side in (("this package", own_side), ("Pink", pink_side), ("mink", mink_side)):
            results = [run(side, robot, start, targets) for _ in range(rounds)]
            medians = [1e6 * statistics.median(times) for times, _ in results]
            every = 1e6 * statistics.median([one for times, _ in results for one in times])
            error = 1e3 * max(worst for _, worst in results)
            lines = len(inspect.getsource(side).splitlines()) - 1
            spread = f"{min(medians):.0f} to {max(medians):.0f}"
            print(f"{robot.name:>9} {name:>13} {every:12.0f} {spread:>18} {error:11.3f} {lines:6}")


if __name__ == "__main__":
    main()
