#!/usr/bin/env python3
"""Writes testdata/mjcf/soft/golden.json: accelerations under MuJoCo's constraints, with a converged solver.

    python3 bench/golden/make_soft_golden.py                              # writes the file
    python3 bench/golden/make_soft_golden.py --states 1000 --out FILE     # as many states, elsewhere
    python3 bench/golden/make_soft_golden.py --robot MJCF --out FILE      # of that robot, with a fall

Random states near the ground, many beyond their limits. Forces replace motors; tendons have only limits, dry
friction and armature; there is no gravity compensation. Contacts are MuJoCo's, written with all inputs of the
law. `on_ground` tells whether all contacts are between one plane and points of primitives. Numbers are in
MuJoCo's convention.
"""

import argparse
import datetime
import importlib.metadata
import zlib
from pathlib import Path

import environment

if __name__ == "__main__":
    environment.enter(environment.ROOT / "bench" / "robots" / "menagerie.txt")

import mujoco  # noqa: E402
import numpy as np  # noqa: E402

import golden_file  # noqa: E402

FILES = ["testdata/mjcf/soft/walker.xml", "testdata/mjcf/soft/press.xml", "testdata/mjcf/soft/cables.xml", "testdata/mjcf/soft/ropes.xml", "testdata/mjcf/soft/tied_tendons.xml", "testdata/mjcf/soft/belts.xml", "testdata/mjcf/soft/welds.xml", "robots/arm.xml", "robots/quadruped.xml", "robots/hand.xml"]
# Largest depth of the lowest point below the ground [m].
DEEPEST = 0.05
# Dropped robots with height [m] and duration [s], to compare motion and contacts.
DROPPED, HEIGHT, MOTION, COUNTED = ["testdata/mjcf/soft/walker.xml", "robots/quadruped.xml"], 0.01, 0.2, 1.0

# The file with adhesion, its controls and the number of steps.
ADHESION, CONTROLS, ADHERED = "testdata/mjcf/soft/adhesion.xml", [1.8, 0.9, 1.0, 0.5], 300

FREE, HINGE, SLIDE = (int(kind) for kind in (mujoco.mjtJoint.mjJNT_FREE, mujoco.mjtJoint.mjJNT_HINGE, mujoco.mjtJoint.mjJNT_SLIDE))
PLANE = int(mujoco.mjtGeom.mjGEOM_PLANE)
# Shapes whose contact points with a plane are the same in both programs.
PRIMITIVES = [int(form) for form in (mujoco.mjtGeom.mjGEOM_SPHERE, mujoco.mjtGeom.mjGEOM_CAPSULE, mujoco.mjtGeom.mjGEOM_ELLIPSOID)]


def scene(path):
    """The file's model above a plane, with a solver at full precision, without motors, tendon springs and
    dampers, and gravity compensation."""
    spec = mujoco.MjSpec.from_file(str(path))
    if not any(geom.type == mujoco.mjtGeom.mjGEOM_PLANE for geom in spec.worldbody.geoms):
        # The format's default surface, not the file's.
        surface = {"contype": 1, "conaffinity": 1, "friction": [1, 0.005, 0.0001], "condim": 3, "solref": [0.02, 1], "solimp": [0.9, 0.95, 0.001, 0.5, 2]}
        spec.worldbody.add_geom(name="ground", type=mujoco.mjtGeom.mjGEOM_PLANE, size=[10, 10, 1], margin=0, **surface)
    model = spec.compile()
    option = model.opt
    option.cone, option.solver = mujoco.mjtCone.mjCONE_ELLIPTIC, mujoco.mjtSolver.mjSOL_NEWTON
    option.jacobian, option.tolerance, option.iterations = mujoco.mjtJacobian.mjJAC_DENSE, 0, 400
    option.ls_tolerance, option.ls_iterations = 1e-6, 200
    option.disableflags |= mujoco.mjtDisableBit.mjDSBL_ACTUATION
    model.tendon_stiffness[:], model.tendon_damping[:] = 0, 0
    model.body_gravcomp[:] = 0
    model.actuator_armature[:], model.actuator_damping[:] = 0, 0
    return model


def lower(model, data, depth):
    """Moves a free robot to a given depth in the ground."""
    if model.jnt_type[0] != FREE:
        return
    plane = next(i for i in range(model.ngeom) if model.geom_type[i] == PLANE)
    data.qpos[2] = 3
    lowest = np.inf
    mujoco.mj_kinematics(model, data)
    for geom in range(model.ngeom):
        if geom != plane and (model.geom_contype[geom] or model.geom_conaffinity[geom]):
            lowest = min(lowest, mujoco.mj_geomDistance(model, data, plane, geom, 10, None))
    if np.isfinite(lowest):
        data.qpos[2] -= lowest + depth


def state(model, random):
    """One random state, and its acceleration."""
    data = mujoco.MjData(model)
    for joint in range(model.njnt):
        at, kind = model.jnt_qposadr[joint], model.jnt_type[joint]
        if kind in (HINGE, SLIDE):
            low, high = model.jnt_range[joint] if model.jnt_limited[joint] else (-0.5, 0.5)
            data.qpos[at] = random.uniform(low - 0.05, high + 0.05)
        else:
            orientation = at + (3 if kind == FREE else 0)
            near = random.normal(0, 0.15, 4) + [1, 0, 0, 0]
            data.qpos[orientation : orientation + 4] = near / np.linalg.norm(near)
    data.qvel = random.normal(0, 0.5, model.nv)
    data.qfrc_applied = random.normal(0, 1, model.nv)
    lower(model, data, random.uniform(-0.1, 1) * DEEPEST)
    start = {"qpos": data.qpos.copy(), "qvel": data.qvel.copy(), "qfrc": data.qfrc_applied.copy()}
    mujoco.mj_forward(model, data)
    contacts, on_ground = [], True
    for contact in data.contact:
        if contact.exclude:
            continue
        first, second = contact.geom
        on_ground &= bool(model.geom_type[first] == PLANE and model.geom_type[second] in PRIMITIVES)
        sideways, other, turn = contact.surfacevel
        moved = {"surface_motion": [sideways * contact.frame[3:6] + other * contact.frame[6:9], turn * contact.frame[:3]]}
        contacts.append(
            {
                "body": model.body(model.geom_bodyid[second]).name,
                "other": model.body(model.geom_bodyid[first]).name,
                "point": contact.pos,
                "normal": contact.frame[:3],
                "distance": contact.dist,
                "margin": contact.includemargin,
                "condim": contact.dim,
                "friction": contact.friction,
                "solref": contact.solref,
                "solimp": contact.solimp,
            }
            | (moved if any(contact.surfacevel) else {})
        )
    return start | {"contacts": contacts, "on_ground": on_ground, "qacc": data.qacc.copy(), "constraint": data.qfrc_constraint.copy()}


def drop(model, random):
    """A fall from near the file's own pose by MuJoCo's Euler steps: its end, and the number of contacts in
    each step."""
    model.opt.integrator = mujoco.mjtIntegrator.mjINT_EULER
    data = mujoco.MjData(model)
    hinges = np.isin(model.jnt_type, [HINGE, SLIDE])
    data.qpos[model.jnt_qposadr[hinges]] += random.uniform(-0.05, 0.05, hinges.sum())
    lower(model, data, -HEIGHT)
    start, contacts, end = data.qpos.copy(), [], None
    for step in range(round(COUNTED / model.opt.timestep)):
        if step == round(MOTION / model.opt.timestep):
            end = {"end_qpos": data.qpos.copy(), "end_qvel": data.qvel.copy()}
        mujoco.mj_step(model, data)
        contacts.append(sum(1 for contact in data.contact if not contact.exclude))
    return {"start": start, "steps": round(MOTION / model.opt.timestep)} | end | {"contacts": contacts}


def adhere(path):
    """A motion with actuators that pull at contacts by Euler steps, from the file's own pose, with constant
    controls: the torques of the actuators in each tenth step, and the end."""
    model = mujoco.MjModel.from_xml_path(str(path))
    option = model.opt
    option.solver, option.jacobian = mujoco.mjtSolver.mjSOL_NEWTON, mujoco.mjtJacobian.mjJAC_DENSE
    option.tolerance, option.iterations, option.ls_tolerance, option.ls_iterations = 0, 400, 1e-6, 200
    data = mujoco.MjData(model)
    start, torques, near = data.qpos.copy(), [], 0
    data.ctrl = CONTROLS
    for step in range(ADHERED):
        mujoco.mj_step(model, data)
        near += sum(1 for contact in data.contact if contact.exclude == 1)
        if step % 10 == 0:
            torques.append({"qpos": data.qpos.copy(), "torques": data.qfrc_actuator.copy()})
    assert near > 10
    return {
        "start": start,
        "ctrl": CONTROLS,
        "steps": ADHERED,
        "torques": torques,
        "end_qpos": data.qpos.copy(),
        "end_qvel": data.qvel.copy(),
    }


def record(path, states, is_own=True):
    """All results of one file. A robot from elsewhere is dropped, with contact between links and ground only.
    """
    model = scene(path)
    if not is_own:
        model.geom_conaffinity[model.geom_type != PLANE] = 0
    random = np.random.default_rng(zlib.crc32(path.name.encode()))
    account = {
        "time_step": model.opt.timestep,
        "impratio": model.opt.impratio,
        "states": [state(model, random) for _ in range(states)],
    }
    dropped = not is_own or any(path.match(file) for file in DROPPED)
    return account | ({"drop": drop(model, random)} if dropped else {})


def main():
    """Writes the file."""
    parser = argparse.ArgumentParser(description=__doc__, formatter_class=argparse.RawDescriptionHelpFormatter)
    root = environment.ROOT
    parser.add_argument("--states", type=int, default=8)
    parser.add_argument("--robot", type=Path, help="an MJCF file in the place of the project's own")
    parser.add_argument("--out", type=Path, default=root / "testdata" / "mjcf" / "soft" / "golden.json")
    arguments = parser.parse_args()
    if arguments.robot:
        robot = arguments.robot.resolve()
        source, files = robot.name, {str(robot): record(robot, arguments.states, is_own=False)}
    else:
        source, files = "this project's own: testdata/mjcf/soft/*.xml, robots/*.xml", {file: record(root / file, arguments.states) for file in FILES}
    result = {
        "provenance": {
            "tool": "MuJoCo",
            "version": mujoco.__version__,
            "packages": {name: importlib.metadata.version(name) for name in ("mujoco", "numpy")},
            "command": "python3 bench/golden/make_soft_golden.py",
            "date": datetime.date.today().isoformat(),
            "robot_files": source,
        },
        "files": files,
    } | ({} if arguments.robot else {"adhesion": adhere(root / ADHESION)})
    golden_file.write(arguments.out, result)


if __name__ == "__main__":
    main()
