#!/usr/bin/env python3
"""Writes testdata/mjcf/golden.json: MuJoCo's results for the MJCF files of testdata/mjcf and robots.

    python3 bench/golden/make_mjcf_golden.py            # writes the file
    python3 bench/golden/make_mjcf_golden.py --check    # compares with the committed file, writes nothing

Numbers are in MuJoCo's convention: quaternions w x y z, free joints' linear velocity in world axes. The
states are random with the CRC-32 of the file's name as seed. Contacts, limits and friction are switched off.
The motion is by MuJoCo's RK4, also without equalities, from a pose near the file's own with constant
controls.
"""

import argparse
import datetime
import importlib.metadata
import json
import sys
import zlib
from pathlib import Path

import environment

if __name__ == "__main__":
    environment.enter(environment.ROOT / "bench" / "robots" / "menagerie.txt")

import mujoco  # noqa: E402
import numpy as np  # noqa: E402

import golden_file  # noqa: E402

OUT = environment.ROOT / "testdata" / "mjcf" / "golden.json"
STATES = 3
# Duration and step of the motion, and the step with a free body or a muscle [s]. The coordinates of free
# bodies and the integration of muscles' activations, and so their errors, differ from this library's.
DURATION, STEP, SHORT_STEP = 1.0, 0.001, 0.0002


def motors(model, target, kind, values):
    """The armature of a joint or tendon from its actuators, by their gears; MuJoCo stores it separately."""
    kinds = [int(kind)] + [int(mujoco.mjtTrn.mjTRN_JOINTINPARENT)] * (kind == mujoco.mjtTrn.mjTRN_JOINT)
    own = [i for i in range(len(model.actuator_trntype)) if model.actuator_trntype[i] in kinds and model.actuator_trnid[i][0] == target]
    return sum(float(values[i] * model.actuator_gear[i][0] ** 2) for i in own)


def joints(model):
    """MuJoCo's data of each joint."""
    rows = []
    for i in range(model.njnt):
        dof = model.jnt_dofadr[i]
        rows.append(
            {
                "name": model.joint(i).name,
                "kind": ["free", "ball", "slide", "hinge"][model.jnt_type[i]],
                "limited": bool(model.jnt_limited[i]),
                "range": model.jnt_range[i],
                "force_limited": bool(model.jnt_actfrclimited[i]),
                "force_range": model.jnt_actfrcrange[i],
                "stiffness": model.jnt_stiffness[i],
                "spring_reference": model.qpos_spring[model.jnt_qposadr[i]],
                "damping": model.dof_damping[dof] + motors(model, i, mujoco.mjtTrn.mjTRN_JOINT, model.actuator_damping),
                "armature": model.dof_armature[dof] + motors(model, i, mujoco.mjtTrn.mjTRN_JOINT, model.actuator_armature),
                "friction": model.dof_frictionloss[dof],
            }
        )
    return rows


def controls(model):
    """The actuator of each control, and the number of the control among those of the actuator."""
    return [(i, k) for i in range(len(model.actuator_trntype)) for k in range(model.actuator_ctrlnum[i])]


def per_control(model, values):
    """The outputs of actuators, one number for each control."""
    return np.array([values[model.actuator_outadr[i]] for i, _ in controls(model)])


def actuators(model):
    """MuJoCo's data of each control. The first one of an actuator has its name and the range of its force."""
    return [
        {
            "name": "" if k else model.actuator(i).name,
            "control_limited": bool(model.actuator_ctrllimited[control]),
            "control_range": model.actuator_ctrlrange[control],
            "force_limited": bool(model.actuator_forcelimited[i]) and not k,
            "force_range": model.actuator_forcerange[i],
        }
        for control, (i, k) in enumerate(controls(model))
    ]


def tendons(model):
    """MuJoCo's data of each tendon."""
    return [
        {
            "name": model.tendon(i).name,
            "stiffness": model.tendon_stiffness[i],
            "damping": model.tendon_damping[i] + motors(model, i, mujoco.mjtTrn.mjTRN_TENDON, model.actuator_damping),
            "armature": model.tendon_armature[i] + motors(model, i, mujoco.mjtTrn.mjTRN_TENDON, model.actuator_armature),
            "friction": model.tendon_frictionloss[i],
            "spring": model.tendon_lengthspring[i],
            "limited": bool(model.tendon_limited[i]),
            "range": model.tendon_range[i],
        }
        for i in range(model.ntendon)
    ]


def equalities(model):
    """The residual of each equality at the first state."""
    return [
        {
            "name": model.equality(i).name,
            "kind": ["connect", "weld", "joint"][model.eq_type[i]],
            "active": bool(model.eq_active0[i]),
            "solref": model.eq_solref[i],
        }
        for i in range(model.neq)
    ]


def normalized(model, qpos):
    """Unit quaternions."""
    mujoco.mj_normalizeQuat(model, qpos)
    return qpos


def state(model, random):
    """One random state and MuJoCo's results."""
    model.opt.disableflags |= mujoco.mjtDisableBit.mjDSBL_CONTACT
    model.opt.enableflags |= mujoco.mjtEnableBit.mjENBL_ENERGY
    data = mujoco.MjData(model)
    data.qpos = normalized(model, random.uniform(-1, 1, model.nq))
    data.qvel, data.ctrl = random.uniform(-1, 1, model.nv), random.uniform(-1, 1, model.nu)
    data.act = random.uniform(-1, 1, model.na)
    data.eq_active = 0
    mujoco.mj_forward(model, data)
    mass = np.zeros((model.nv, model.nv))
    mujoco.mj_fullM(model, data, mass)
    return {
        "qpos": data.qpos.copy(),
        "qvel": data.qvel.copy(),
        "ctrl": data.ctrl.copy(),
        "act": data.act.copy(),
        "mass_matrix": mass,
        "bias": data.qfrc_bias.copy(),
        "spring": data.qfrc_spring.copy(),
        "damper": data.qfrc_damper.copy(),
        "passive": data.qfrc_passive.copy(),
        "potential_energy": data.energy[0],
        "body_positions": data.xpos.copy(),
        "body_rotations": data.xmat.copy(),
        "site_positions": data.site_xpos.copy(),
        "site_rotations": data.site_xmat.copy(),
        "tendon_lengths": data.ten_length.copy(),
        "actuator_lengths": per_control(model, data.actuator_length),
        "actuator_velocities": per_control(model, data.actuator_velocity),
        "actuator_forces": per_control(model, data.actuator_force) * [k == 0 for _, k in controls(model)],
    } | ({"actuator_torques": data.qfrc_actuator.copy()} if model.nu else {})


def motion(path, random):
    """A state near the file's own pose, and the end of MuJoCo's RK4 motion from it."""
    model = mujoco.MjModel.from_xml_path(str(path))
    model.opt.disableflags |= mujoco.mjtDisableBit.mjDSBL_CONSTRAINT
    is_free = (model.jnt_type == int(mujoco.mjtJoint.mjJNT_FREE)).any()
    is_muscle = (model.actuator_dyntype == int(mujoco.mjtDyn.mjDYN_MUSCLE)).any()
    step = SHORT_STEP if is_free or is_muscle else STEP
    model.opt.integrator, model.opt.timestep = mujoco.mjtIntegrator.mjINT_RK4, step
    # The exact filter is exact in Euler's steps; in RK4 steps it adds an error of first order.
    exact, filtered = int(mujoco.mjtDyn.mjDYN_FILTEREXACT), int(mujoco.mjtDyn.mjDYN_FILTER)
    model.actuator_dyntype[model.actuator_dyntype == exact] = filtered
    data = mujoco.MjData(model)
    data.qpos = normalized(model, model.qpos0 + random.uniform(-0.3, 0.3, model.nq))
    data.qvel, data.ctrl = random.uniform(-0.3, 0.3, model.nv), random.uniform(-1, 1, model.nu)
    start = {"qpos": data.qpos.copy(), "qvel": data.qvel.copy(), "ctrl": data.ctrl.copy()}
    for _ in range(round(DURATION / step)):
        mujoco.mj_step(model, data)
    return start | {"step": step, "duration": DURATION, "end_qpos": data.qpos.copy(), "end_qvel": data.qvel.copy()}


def record(path):
    """All results of one file."""
    model = mujoco.MjModel.from_xml_path(str(path))
    random = np.random.default_rng(zlib.crc32(path.name.encode()))
    return {
        "gravity": model.opt.gravity if not model.opt.disableflags & mujoco.mjtDisableBit.mjDSBL_GRAVITY else [0, 0, 0],
        "time_step": model.opt.timestep,
        "qpos0": model.qpos0,
        "bodies": [
            {
                "name": model.body(i).name,
                "mass": model.body_mass[i],
                "gravity_compensation": model.body_gravcomp[i],
            }
            for i in range(model.nbody)
        ],
        "sites": [model.site(i).name for i in range(model.nsite)],
        "joints": joints(model),
        "actuators": actuators(model),
        "tendons": tendons(model),
        "equalities": equalities(model),
        "keys": [
            {"name": model.key(i).name, "qpos": model.key_qpos[i], "qvel": model.key_qvel[i], "ctrl": model.key_ctrl[i]}
            for i in range(model.nkey)
        ],
        "states": [state(model, random) for _ in range(STATES)],
        "motion": motion(path, random),
    }


def main():
    """Writes or compares."""
    parser = argparse.ArgumentParser(description=__doc__, formatter_class=argparse.RawDescriptionHelpFormatter)
    parser.add_argument("--check", action="store_true")
    check = parser.parse_args().check
    root = environment.ROOT
    files = sorted([*(root / "testdata" / "mjcf").glob("*.xml"), *(root / "robots").glob("*.xml")])
    result = {
        "provenance": {
            "tool": "MuJoCo",
            "version": mujoco.__version__,
            "packages": {name: importlib.metadata.version(name) for name in ("mujoco", "numpy")},
            "command": "python3 bench/golden/make_mjcf_golden.py",
            "date": datetime.date.today().isoformat(),
            "robot_files": "this project's own: testdata/mjcf/*.xml, robots/*.xml",
        },
        "files": {str(path.relative_to(root)): record(path) for path in files},
    }
    if not check:
        golden_file.write(OUT, result)
        return
    old, new = json.loads(OUT.read_text()), golden_file.plain(result)
    for side in (old, new):
        side["provenance"].pop("date")
    gap = golden_file.difference(old, new, golden_file.ROUNDING)
    print(f"{OUT.relative_to(root)}: {gap if isinstance(gap, str) else f'same within {gap:.1e}'}")
    if isinstance(gap, str):
        sys.exit(1)


if __name__ == "__main__":
    main()
