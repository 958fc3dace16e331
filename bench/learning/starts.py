"""States of robots on the ground and random controls, by MuJoCo."""

import mujoco
import numpy as np
from mujoco.batch import Batch

SETTLING = 1.5
"""Simulated time before the timed motions [s]: the robots then lie or stand on the ground."""
AMPLITUDE = 0.5
"""Controls are uniform in this part of their range."""


def control_amplitudes(model: mujoco.MjModel) -> np.ndarray:
    """The largest absolute value of each control."""
    limited = model.actuator_ctrllimited.astype(bool)
    return AMPLITUDE * np.where(limited, model.actuator_ctrlrange[:, 1], 1.0)


def random_inputs(amplitudes: np.ndarray, steps: int, count: int, seed: int) -> np.ndarray:
    """Uniform inputs (steps, count, inputs)."""
    return np.random.default_rng(seed).uniform(-1, 1, (steps, count, len(amplitudes))) * amplitudes


def settled(
    model: mujoco.MjModel, field: str, amplitudes: np.ndarray, count: int, seed: int = 1
) -> tuple[np.ndarray, np.ndarray, np.ndarray]:
    """States (qpos, qvel) after a fall with random inputs, and the numbers of contacts and constraint rows
    (count, 2). `field` names MuJoCo's field of the inputs."""
    random = np.random.default_rng(seed)
    batch = Batch(model, nsim=count)
    qpos, inputs = batch.bind("qpos"), batch.bind(field)
    for joint in range(model.njnt):
        at = model.jnt_qposadr[joint]
        if model.jnt_type[joint] == int(mujoco.mjtJoint.mjJNT_FREE):
            qpos[:, at + 2] += random.uniform(0.02, 0.1, count)
            continue
        low, high = model.jnt_range[joint] if model.jnt_limited[joint] else (-1.0, 1.0)
        middle = np.clip(model.qpos0[at], low, high)
        qpos[:, at] = np.clip(middle + random.uniform(-0.2, 0.2, count), low, high)
    hold = 10
    for row in random_inputs(amplitudes, round(SETTLING / model.opt.timestep / hold), count, seed):
        inputs[:] = row
        batch.step(nstep=hold)
    starts, data, sizes = (qpos.copy(), batch.bind("qvel").copy()), mujoco.MjData(model), []
    for data.qpos[:], data.qvel[:] in zip(*starts, strict=True):
        mujoco.mj_fwdPosition(model, data)
        sizes.append((data.ncon, data.nefc))
    return *starts, np.array(sizes)
