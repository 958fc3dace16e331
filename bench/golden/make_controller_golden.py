#!/usr/bin/env python3
"""Writes testdata/mjcf/controller_states/golden.json: MuJoCo's torques of actuators with states at random
states, the rates of these states, and the ends of motions.

    python3 bench/golden/make_controller_golden.py

MuJoCo computes the force of a motor from the current at the end of a step (`actearly`), and integrates the
current in RK4 steps with an error of first order. Here `actearly` is off, and the motions are classical
Runge-Kutta steps over the accelerations and rates of `mj_forward`. Numbers are in MuJoCo's convention.
"""

import zlib

import environment

if __name__ == "__main__":
    environment.enter(environment.ROOT / "bench" / "robots" / "menagerie.txt")

import mujoco  # noqa: E402
import numpy as np  # noqa: E402

import golden_file  # noqa: E402

FILES = [f"testdata/mjcf/controller_states/{name}.xml" for name in ("pid", "motors")]
STATES = 12
STEP = 0.001
DURATION = 1.0


def load(path):
    """The model without contact, with forces of the current state of actuators."""
    model = mujoco.MjModel.from_xml_path(str(path))
    model.opt.disableflags |= int(mujoco.mjtDisableBit.mjDSBL_CONTACT)
    model.opt.timestep = STEP
    model.actuator_actearly[:] = 0
    return model


def state(model, random):
    """One random state with torques and rates."""
    data = mujoco.MjData(model)
    data.qpos, data.qvel = random.normal(0, 0.5, model.nq), random.normal(0, 1.0, model.nv)
    data.ctrl, data.act = random.normal(0, 1.0, model.nu), random.uniform(-3, 3, model.na)
    mujoco.mj_forward(model, data)
    return {
        "qpos": data.qpos.copy(),
        "qvel": data.qvel.copy(),
        "ctrl": data.ctrl.copy(),
        "act": data.act.copy(),
        "actuator_torques": data.qfrc_actuator.copy(),
        "rates": data.act_dot.copy(),
    }


def motion(model, random):
    """The end of a motion from states of actuators at 0."""
    data = mujoco.MjData(model)
    nq, nv = model.nq, model.nv
    assert nq == nv, "joints with one degree of freedom only"
    y = np.concatenate([random.normal(0, 0.2, nq), random.normal(0, 0.3, nv), np.zeros(model.na)])
    ctrl = random.normal(0, 0.6, model.nu)
    start = {"qpos": y[:nq].copy(), "qvel": y[nq : nq + nv].copy(), "ctrl": ctrl}

    def rate(y):
        data.qpos, data.qvel, data.act, data.ctrl = y[:nq], y[nq : nq + nv], y[nq + nv :], ctrl
        mujoco.mj_forward(model, data)
        return np.concatenate([data.qvel, data.qacc, data.act_dot])

    for _ in range(round(DURATION / STEP)):
        a = rate(y)
        b = rate(y + 0.5 * STEP * a)
        c = rate(y + 0.5 * STEP * b)
        d = rate(y + STEP * c)
        y = y + STEP / 6 * (a + 2 * b + 2 * c + d)
    ends = {"end_qpos": y[:nq], "end_qvel": y[nq : nq + nv], "end_act": y[nq + nv :]}
    return {"step": STEP, "duration": DURATION} | start | ends


def record(path):
    """All results of one file."""
    random = np.random.default_rng(zlib.crc32(path.name.encode()))
    model = load(path)
    return {"states": [state(model, random) for _ in range(STATES)], "motion": motion(model, random)}


def main():
    """Writes the file."""
    root = environment.ROOT
    result = {
        "provenance": golden_file.mujoco_provenance("make_controller_golden.py", "testdata/mjcf/controller_states/*.xml"),
        "files": {file: record(root / file) for file in FILES},
    }
    golden_file.write(root / "testdata/mjcf/controller_states/golden.json", result)


if __name__ == "__main__":
    main()
