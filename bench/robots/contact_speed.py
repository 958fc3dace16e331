#!/usr/bin/env python3
"""Steps per second on the ground, beside MuJoCo's mj_step, in one run on the same robots from the same
starts.

    cargo build --release --locked -p robot-dynamics-cli
    python3 bench/robots/contact_speed.py [--rounds 5]

Both programs take steps of 1 ms on one core: a fall of 10 cm to rest, and a second at rest. For MuJoCo that
second is the last of the fall; the command starts it from the end of its fall. Cones are elliptic, the
robot's shapes make contact with the ground only, and there are no motors. MuJoCo steps in one call of
mj_step. The command writes only its summary, with the energy balance.
"""

import argparse
import csv
import re
import statistics
import subprocess
import sys
import tempfile
import time
from pathlib import Path

ROOT = Path(__file__).resolve().parents[2]
sys.path.insert(0, str(ROOT / "bench" / "golden"))

import environment  # noqa: E402

if __name__ == "__main__":
    environment.enter(ROOT / "bench" / "robots" / "menagerie.txt")

import mujoco  # noqa: E402

COMMAND = ROOT / "target" / "release" / "dynamics"
ROBOTS = ["quadruped.urdf", "quadruped.xml", "humanoid.urdf"]
SECONDS, DROP = 4, 0.1


def lift(model, data):
    """Puts the lowest point 10 cm above the ground."""
    plane = model.geom("the ground").id
    data.qpos[2] += 2
    mujoco.mj_kinematics(model, data)
    shapes = [i for i in range(model.ngeom) if model.geom_contype[i]]
    data.qpos[2] += DROP - min(mujoco.mj_geomDistance(model, data, plane, i, 10, None) for i in shapes)


def scene(file):
    """The robot above a plane, with contact between its shapes and the plane only."""
    spec = mujoco.MjSpec.from_file(str(file))
    spec.worldbody.add_geom(name="the ground", type=mujoco.mjtGeom.mjGEOM_PLANE, size=[10, 10, 1])
    model = spec.compile()
    plane = model.geom("the ground").id
    for i in range(model.ngeom):
        touches = bool(model.geom_contype[i] or model.geom_conaffinity[i])
        moves = model.body_weldid[model.geom_bodyid[i]] != 0
        model.geom_contype[i], model.geom_conaffinity[i] = (int(touches), 0) if moves else (0, int(i == plane))
    model.opt.cone, model.opt.timestep = mujoco.mjtCone.mjCONE_ELLIPTIC, 1e-3
    model.opt.disableflags |= mujoco.mjtDisableBit.mjDSBL_ACTUATION
    return model


def theirs(model, start):
    """MuJoCo's steps per second, over all and over the last second."""
    data = mujoco.MjData(model)
    data.qpos[:] = start
    times = []
    for seconds in (SECONDS - 1, 1):
        begin = time.perf_counter()
        mujoco.mj_step(model, data, nstep=1000 * seconds)
        times.append(time.perf_counter() - begin)
    return 1000 * SECONDS / sum(times), 1000 / times[1]


def command(robot, integrator, start, seconds, *more):
    """A run of the command."""
    arguments = [COMMAND, "simulate", robot, "--ground", "--integrator", integrator, "--pose", start, "--duration", str(seconds), *more]
    if robot.suffix == ".urdf":
        arguments.append("--floating-base")
    done = subprocess.run(arguments, capture_output=True, text=True, check=True)
    return float(re.search(r"([0-9]+) steps/s", done.stdout)[1])


def ours(robot, integrator, start, rest):
    """The command's steps per second, over the fall and from its end."""
    return command(robot, integrator, start, SECONDS), command(robot, integrator, rest, 1)


def ending(robot, integrator, start):
    """The end of a run, by joint names."""
    with tempfile.TemporaryDirectory() as folder:
        file = Path(folder) / "run.csv"
        command(robot, integrator, start, SECONDS, "--csv", str(file))
        with file.open(newline="") as lines:
            *_, last = csv.DictReader(lines)
    joints = {}
    for column, value in last.items():
        found = re.fullmatch(r"q (.+?)(?:\.(?:q?[xyz]|qw))? \[.*\]", column)
        if found:
            joints.setdefault(found[1], []).append(value)
    return ",".join(f"{name}={','.join(values)}" for name, values in joints.items())


def pose(model, start):
    """The start, by joint names."""
    words = []
    for joint in range(model.njnt):
        at = model.jnt_qposadr[joint]
        if model.jnt_type[joint] == int(mujoco.mjtJoint.mjJNT_FREE):
            words.append(f"{model.joint(joint).name}=0,0,{start[at + 2]},0,0,0,1")
        else:
            words.append(f"{model.joint(joint).name}={start[at]}")
    return ",".join(words)


def main():
    """Prints a table."""
    parser = argparse.ArgumentParser(description=__doc__, formatter_class=argparse.RawDescriptionHelpFormatter)
    parser.add_argument("--rounds", type=int, default=5)
    rounds = parser.parse_args().rounds
    print(f"MuJoCo {mujoco.__version__}; steps/s, median of {rounds} rounds (least to most)")
    for name in ROBOTS:
        robot = ROOT / "robots" / name
        with tempfile.TemporaryDirectory() as folder:
            file = robot
            if robot.suffix == ".urdf":
                file = Path(folder) / "robot.xml"
                subprocess.run([COMMAND, "convert", "--floating-base", robot, file], capture_output=True, check=True)
            model = scene(file)
        data = mujoco.MjData(model)
        for joint in range(model.njnt):
            if model.jnt_limited[joint]:
                low, high = model.jnt_range[joint]
                value = data.qpos[model.jnt_qposadr[joint]]
                data.qpos[model.jnt_qposadr[joint]] = value if low <= value <= high else (low + high) / 2
        lift(model, data)
        fall = data.qpos.copy()
        results = {"mj_step": [], "mujoco": [], "implicit": []}
        start = pose(model, fall)
        rests = {integrator: ending(robot, integrator, start) for integrator in ("mujoco", "implicit")}
        for _ in range(rounds):
            results["mj_step"].append(theirs(model, fall))
            for integrator in ("mujoco", "implicit"):
                results[integrator].append(ours(robot, integrator, start, rests[integrator]))
        for side, rows in results.items():
            cells = []
            for part, what in enumerate(("all", "at rest")):
                values = sorted(row[part] for row in rows)
                ratio = statistics.median(a[part] / b[part] for a, b in zip(rows, results["mj_step"]))
                cells.append(f"{what} {statistics.median(values):8.0f} ({values[0]:.0f} to {values[-1]:.0f}), {ratio:.2f} of mj_step")
            print(f"{name:15} {side:9} {'; '.join(cells)}", flush=True)


if __name__ == "__main__":
    main()
