#!/usr/bin/env python3
"""Writes testdata/mjcf/sensors/golden.json: the values of MuJoCo's sensors at random states, with their
inputs.

    python3 bench/golden/make_sensor_golden.py

Accelerations, forces of actuators and limits, and contact forces are MuJoCo's own. Numbers are in MuJoCo's
convention.
"""

import zlib
from pathlib import Path

import environment

if __name__ == "__main__":
    environment.enter(environment.ROOT / "bench" / "robots" / "menagerie.txt")

import mujoco  # noqa: E402
import numpy as np  # noqa: E402

import golden_file  # noqa: E402

FILES = ["testdata/mjcf/sensors/arm.xml", "testdata/mjcf/sensors/walker.xml"]
STATES = 12
FREE, HINGE, SLIDE = (int(kind) for kind in (mujoco.mjtJoint.mjJNT_FREE, mujoco.mjtJoint.mjJNT_HINGE, mujoco.mjtJoint.mjJNT_SLIDE))


def contact_wrenches(model, data):
    """Force and moment of each contact on each of its moving bodies, in world axes at the contact's point."""
    wrenches = []
    for index, contact in enumerate(data.contact):
        local = np.zeros(6)
        mujoco.mj_contactForce(model, data, index, local)
        axes = contact.frame.reshape(3, 3)
        for geom, sign in zip(contact.geom, (-1, 1), strict=True):
            body = model.geom_bodyid[geom]
            if body:
                wrenches.append(
                    {
                        "body": model.body(body).name,
                        "point": contact.pos.copy(),
                        "force": sign * axes.T @ local[:3],
                        "moment": sign * axes.T @ local[3:],
                        "normal": sign * axes[0],
                    }
                )
    return wrenches


def limit_forces(model, data):
    """The generalised forces of joint limits, and the force of each tendon's limit along its length."""
    joints, tendons = np.zeros(model.nv), np.zeros(model.ntendon)
    rows = np.zeros((data.nefc, model.nv))
    if mujoco.mj_isSparse(model):
        mujoco.mju_sparse2dense(rows, data.efc_J, data.efc_J_rownnz, data.efc_J_rowadr, data.efc_J_colind)
    else:
        rows = data.efc_J.reshape(data.nefc, model.nv)
    for row, kind, at, force in zip(rows, data.efc_type, data.efc_id, data.efc_force, strict=True):
        if kind == mujoco.mjtConstraint.mjCNSTR_LIMIT_JOINT:
            joints += row * force
        elif kind == mujoco.mjtConstraint.mjCNSTR_LIMIT_TENDON:
            shorter = data.ten_length[at] > model.tendon_range[at].mean()
            tendons[at] += -force if shorter else force
    return joints, tendons


def state(model, random):
    """One random state with its values."""
    data = mujoco.MjData(model)
    data.time = random.uniform(0, 10)
    for joint in range(model.njnt):
        at, kind = model.jnt_qposadr[joint], model.jnt_type[joint]
        if kind in (HINGE, SLIDE):
            low, high = model.jnt_range[joint] if model.jnt_limited[joint] else (-0.5, 0.5)
            beyond = 0.2 * (high - low)
            data.qpos[at] = random.uniform(low - beyond, high + beyond)
        else:
            orientation = at + (3 if kind == FREE else 0)
            # Away from zero rotation on a ball joint, and near it on a standing trunk.
            near = random.normal(0, 0.05 if kind == FREE else 1, 4) + ([1, 0, 0, 0] if kind == FREE else 0)
            data.qpos[orientation : orientation + 4] = near / np.linalg.norm(near)
    data.qvel = random.normal(0, 0.7, model.nv)
    data.ctrl = random.normal(0, 0.8, model.nu)
    if model.jnt_type[0] == FREE:
        # Lowers the robot until its lowest geom is 1 cm deep in the plane.
        data.qpos[2] = 3
        mujoco.mj_kinematics(model, data)
        others = range(1, model.ngeom)
        data.qpos[2] -= min(mujoco.mj_geomDistance(model, data, 0, geom, 10, None) for geom in others) + 0.01
    mujoco.mj_forward(model, data)
    joints, tendons = limit_forces(model, data)
    return {
        "time": data.time,
        "qpos": data.qpos.copy(),
        "qvel": data.qvel.copy(),
        "qacc": data.qacc.copy(),
        "actuator_force": data.actuator_force.copy(),
        "joint_limit_force": joints,
        "tendon_limit_force": tendons,
        "contacts": contact_wrenches(model, data),
        "sensordata": data.sensordata.copy(),
    }


def record(path):
    """All results of one file."""
    model = mujoco.MjModel.from_xml_path(str(path))
    random = np.random.default_rng(zlib.crc32(path.name.encode()))
    names = [model.sensor(index).name for index in range(model.nsensor)]
    kinds = [mujoco.mjtSensor(kind).name.removeprefix("mjSENS_").lower() for kind in model.sensor_type]
    return {"names": names, "kinds": kinds, "sizes": model.sensor_dim.copy(), "states": [state(model, random) for _ in range(STATES)]}


def main():
    """Writes the file."""
    root = environment.ROOT
    result = {
        "provenance": golden_file.mujoco_provenance("make_sensor_golden.py", "testdata/mjcf/sensors/*.xml"),
        "files": {file: record(root / Path(file)) for file in FILES},
    }
    golden_file.write(root / "testdata" / "mjcf" / "sensors" / "golden.json", result)


if __name__ == "__main__":
    main()
