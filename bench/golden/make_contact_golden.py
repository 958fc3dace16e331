#!/usr/bin/env python3
"""Writes testdata/mjcf/contacts/golden.json: states before and after single steps of `mj_step`, with a
converged solver.

    python3 bench/golden/make_contact_golden.py

Each file of testdata/mjcf/contacts is simulated by MuJoCo's Euler method, from its own pose with small random
velocities. Every few steps the record gets the state before the step, the one after it, and the number of
active contacts. Numbers are in MuJoCo's convention.
"""

import datetime
import importlib.metadata
import zlib

import environment

if __name__ == "__main__":
    environment.enter(environment.ROOT / "bench" / "robots" / "menagerie.txt")

import mujoco  # noqa: E402
import numpy as np  # noqa: E402

import golden_file  # noqa: E402

FOLDER = environment.ROOT / "testdata" / "mjcf" / "contacts"
# Duration of a simulation, and the number of steps between records.
STEPS, EVERY = 150, 10
# Standard deviation of the velocities at the start [m/s and rad/s].
SPEED = 0.1


def precise(model):
    """Makes the solver run at full precision."""
    option = model.opt
    option.solver, option.jacobian = mujoco.mjtSolver.mjSOL_NEWTON, mujoco.mjtJacobian.mjJAC_DENSE
    option.tolerance, option.iterations, option.ls_tolerance, option.ls_iterations = 0, 400, 1e-6, 200
    option.disableflags |= mujoco.mjtDisableBit.mjDSBL_ISLAND
    return model


def record(path):
    """The recorded steps of one file, and the weights of its bodies."""
    model = precise(mujoco.MjModel.from_xml_path(str(path)))
    data = mujoco.MjData(model)
    data.qvel = np.random.default_rng(zlib.crc32(path.name.encode())).normal(0, SPEED, model.nv)
    steps = []
    for step in range(STEPS):
        qpos, qvel = data.qpos.copy(), data.qvel.copy()
        mujoco.mj_step(model, data)
        if step % EVERY == 0:
            acting = sum(1 for contact in data.contact if not contact.exclude)
            steps.append({"qpos": qpos, "qvel": qvel, "after_qpos": data.qpos.copy(), "after_qvel": data.qvel.copy(), "contacts": acting})
    bodies = {model.body(body).name: model.body_invweight0[body] for body in range(1, model.nbody)}
    return {"time_step": model.opt.timestep, "body_invweight0": bodies, "steps": steps}


def main():
    """Writes the file."""
    result = {
        "provenance": {
            "tool": "MuJoCo",
            "version": mujoco.__version__,
            "packages": {name: importlib.metadata.version(name) for name in ("mujoco", "numpy")},
            "command": "python3 bench/golden/make_contact_golden.py",
            "date": datetime.date.today().isoformat(),
            "robot_files": "this project's own: testdata/mjcf/contacts/*.xml",
        },
        "files": {str(path.relative_to(environment.ROOT)): record(path) for path in sorted(FOLDER.glob("*.xml"))},
    }
    golden_file.write(FOLDER / "golden.json", result)


if __name__ == "__main__":
    main()
