#!/usr/bin/env python3
"""Writes testdata/mjcf/derivatives.json: the derivatives of MuJoCo's forces of actuators, tendons, springs,
dampers, compensated weight and fluids by position, velocity, controls and activations.

    python3 bench/golden/make_derivative_golden.py

F = qfrc_actuator + qfrc_passive. Its derivatives are central differences of eighth order. A state counts if
differences with half the increment agree with them to AGREE of the largest entry. `from_qderiv` is the
largest difference from MuJoCo's own derivative by velocity (`qDeriv` of its integrator `implicitfast`), which
leaves out some terms, such as those of bounded forces. States are in MuJoCo's convention. Derivatives are in
this library's: the linear velocity of a free body and its displacement are in the body's axes.
"""

import zlib

import environment

if __name__ == "__main__":
    environment.enter(environment.ROOT / "bench" / "robots" / "menagerie.txt")

import mujoco  # noqa: E402
import numpy as np  # noqa: E402

import golden_file  # noqa: E402

NAMES = (
    "actuators", "controllers", "muscles", "placement_springs", "polynomials", "replicated_drives", "spatial_tendons",
    "spring_damper", "tendons", "transmissions", "yielding_springs", "fluid/drone", "fluid/swimmer", "fluid/shapes",
    "fluid/insect", "controller_states/pid", "controller_states/motors",
)  # fmt: skip
STATES, TRIES = 3, 200
# The increments [rad, m, rad/s, m/s, ...], and the weights of the differences at 1 to 4 of them.
STEP = 2e-3
WEIGHTS = (4 / 5, -1 / 5, 4 / 105, -1 / 280)
AGREE = 1e-11
FREE, BALL = int(mujoco.mjtJoint.mjJNT_FREE), int(mujoco.mjtJoint.mjJNT_BALL)


class Forces:
    """F of a model near a state."""

    def __init__(self, model, random):
        self.model, self.data = model, mujoco.MjData(model)
        self.qpos = random.uniform(-1, 1, model.nq)
        mujoco.mj_normalizeQuat(model, self.qpos)
        self.v = random.uniform(-1, 1, model.nv)
        self.ctrl, self.act = random.uniform(-1, 1, model.nu), random.uniform(-1, 1, model.na)

    def turn(self, qpos):
        """G of v_mujoco = G v."""
        turn = np.eye(self.model.nv)
        for joint in np.flatnonzero(self.model.jnt_type == FREE):
            at, dof, matrix = self.model.jnt_qposadr[joint], self.model.jnt_dofadr[joint], np.empty(9)
            mujoco.mju_quat2Mat(matrix, qpos[at + 3 : at + 7])
            turn[dof : dof + 3, dof : dof + 3] = matrix.reshape(3, 3)
        return turn

    def at(self, displacement, faster, control, activation):
        """F at a displaced state."""
        model, data, qpos = self.model, self.data, self.qpos.copy()
        mujoco.mj_integratePos(model, qpos, self.turn(self.qpos) @ displacement, 1.0)
        turn = self.turn(qpos)
        data.qpos, data.qvel = qpos, turn @ (self.v + faster)
        data.ctrl, data.act = self.ctrl + control, self.act + activation
        mujoco.mj_forward(model, data)
        return turn.T @ (data.qfrc_actuator + data.qfrc_passive)

    def derivatives(self, step):
        """The derivatives by position, velocity, controls and activations."""
        sizes = [self.model.nv, self.model.nv, self.model.nu, self.model.na]
        blocks = []
        for block, size in enumerate(sizes):
            columns = []
            for k in range(size):
                inputs = [np.zeros(n) for n in sizes]
                column = np.zeros(self.model.nv)
                for times, weight in enumerate(WEIGHTS, start=1):
                    for sign in (1, -1):
                        inputs[block][k] = sign * times * step
                        column += sign * weight / step * self.at(*inputs)
                columns.append(column)
            blocks.append(np.array(columns).T.reshape(self.model.nv, size))
        return blocks

    def own_by_velocity(self):
        """MuJoCo's own derivative by velocity, in this library's convention."""
        model, data = self.model, self.data
        turn = self.turn(self.qpos)
        data.qpos, data.qvel, data.ctrl, data.act = self.qpos, turn @ self.v, self.ctrl, self.act
        mujoco.mj_step(model, data)
        dense = np.zeros((model.nv, model.nv))
        for row in range(model.nv):
            entries = slice(model.D_rowadr[row], model.D_rowadr[row] + model.D_rownnz[row])
            dense[row, model.D_colind[entries]] = data.qDeriv[entries]
        return turn.T @ dense @ turn


def worst(found, expected):
    """The largest difference relative to the largest entry."""
    return np.max(np.abs(found - expected), initial=0.0) / max(np.max(np.abs(expected), initial=0.0), 1e-3)


def states(name, model):
    """The states whose derivatives are certain, and the largest difference from MuJoCo's own derivatives."""
    random = np.random.default_rng(zlib.crc32(f"derivatives of {name}".encode()))
    rows, own = [], 0.0
    for _ in range(TRIES):
        forces = Forces(model, random)
        far, near = forces.derivatives(STEP), forces.derivatives(STEP / 2)
        if max(worst(a, b) for a, b in zip(far, near)) > AGREE:
            continue
        own = max(own, worst(forces.own_by_velocity(), far[1]))
        by = dict(zip(("by_position", "by_velocity", "by_control", "by_activation"), far))
        rows.append({"qpos": forces.qpos, "qvel": forces.turn(forces.qpos) @ forces.v, "ctrl": forces.ctrl, "act": forces.act} | by)
        if len(rows) == STATES:
            return rows, own
    raise SystemExit(f"{name}: only {len(rows)} states of {TRIES} are smooth")


def main():
    """Writes the file."""
    root, files = environment.ROOT, {}
    for name in NAMES:
        file = f"testdata/mjcf/{name}.xml"
        model = mujoco.MjModel.from_xml_path(str(root / file))
        model.opt.disableflags |= int(mujoco.mjtDisableBit.mjDSBL_CONSTRAINT)
        model.opt.integrator = mujoco.mjtIntegrator.mjINT_IMPLICITFAST
        model.actuator_actearly[:] = 0
        rows, own = states(name, model)
        files[file] = {"step": model.opt.timestep, "from_qderiv": float(f"{own:.1e}"), "states": rows}
    provenance = golden_file.mujoco_provenance("make_derivative_golden.py", "testdata/mjcf/**/*.xml")
    golden_file.write(root / "testdata/mjcf/derivatives.json", {"provenance": provenance, "files": files})


if __name__ == "__main__":
    main()
