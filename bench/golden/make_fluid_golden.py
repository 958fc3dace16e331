#!/usr/bin/env python3
"""Writes testdata/mjcf/fluid/golden.json: MuJoCo's forces of a fluid at random states, the added masses of
ellipsoids, and motions by its RK4 and by its Euler steps.

    python3 bench/golden/make_fluid_golden.py

Numbers are in MuJoCo's convention.
"""

import zlib

import environment

if __name__ == "__main__":
    environment.enter(environment.ROOT / "bench" / "robots" / "menagerie.txt")

import mujoco  # noqa: E402
import numpy as np  # noqa: E402

import golden_file  # noqa: E402

FILES = [f"testdata/mjcf/fluid/{name}.xml" for name in ("drone", "swimmer", "shapes", "insect")]
STATES = 8
STEP = 0.001
HINGE, SLIDE, BALL, FREE = (int(getattr(mujoco.mjtJoint, f"mjJNT_{kind}")) for kind in ("HINGE", "SLIDE", "BALL", "FREE"))


def place(model, data, random, spread):
    """A random configuration and velocity."""
    for joint in range(model.njnt):
        at, kind = model.jnt_qposadr[joint], model.jnt_type[joint]
        if kind in (HINGE, SLIDE):
            data.qpos[at] = random.normal(0, spread)
        else:
            orientation = at + (3 if kind == FREE else 0)
            quaternion = random.normal(0, spread, 4) + [1, 0, 0, 0]
            data.qpos[orientation : orientation + 4] = quaternion / np.linalg.norm(quaternion)
    data.qvel = random.normal(0, 1.0, model.nv)


def state(model, random):
    """One random state with the forces of the fluid."""
    data = mujoco.MjData(model)
    place(model, data, random, 0.5)
    mujoco.mj_forward(model, data)
    return {"qpos": data.qpos.copy(), "qvel": data.qvel.copy(), "qfrc_fluid": data.qfrc_fluid.copy()}


def motion(model, random, integrator, duration):
    """The end of a motion without contact."""
    model.opt.integrator = integrator
    model.opt.timestep = STEP
    model.opt.disableflags |= int(mujoco.mjtDisableBit.mjDSBL_CONTACT)
    data = mujoco.MjData(model)
    place(model, data, random, 0.1)
    start = {"qpos": data.qpos.copy(), "qvel": data.qvel.copy()}
    for _ in range(round(duration / STEP)):
        mujoco.mj_step(model, data)
    return {"step": STEP, "duration": duration, **start, "end_qpos": data.qpos.copy(), "end_qvel": data.qvel.copy()}


def record(path):
    """All results of one file."""
    model = mujoco.MjModel.from_xml_path(str(path))
    random = np.random.default_rng(zlib.crc32(path.name.encode()))
    states = [state(model, random) for _ in range(STATES)]
    added = {
        model.body(model.geom_bodyid[geom]).name: model.geom_fluid[geom, 6:].copy()
        for geom in range(model.ngeom)
        if model.geom_fluid[geom, 0] > 0 and model.body_geomnum[model.geom_bodyid[geom]] == 1
    }
    if path.stem == "insect":
        return {"states": states, "added": added}
    integrators = mujoco.mjtIntegrator
    return {
        "states": states,
        "added": added,
        "motion": motion(model, random, integrators.mjINT_RK4, 1.0),
        "euler": motion(model, random, integrators.mjINT_EULER, 0.2),
    }


def main():
    """Writes the file."""
    root = environment.ROOT
    result = {
        "provenance": golden_file.mujoco_provenance("make_fluid_golden.py", "testdata/mjcf/fluid/*.xml"),
        "files": {file: record(root / file) for file in FILES},
    }
    golden_file.write(root / "testdata/mjcf/fluid/golden.json", result)


if __name__ == "__main__":
    main()
