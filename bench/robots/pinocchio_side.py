"""Pinocchio's M, bias and gravity of a file at random states, in this project's coordinates.

A joint without limits has one number (Pinocchio: cos, sin). A planar joint has x, y, theta and their rates
(Pinocchio: the velocity in the moving axes). Mimic joints have no number. One linear map of velocities,
v_pin = G(q) v, expresses all of this, so that

    M = G^T M_pin G,    bias = G^T rnea(q, G v, dG/dt v),    gravity = G^T g_pin.
"""

import re
import zlib

import numpy as np
import pinocchio as pin

from servant import serve
from written_out import followers

KINDS = [
    ("turn", re.compile(r"JointModelR([XYZ]|evoluteUnaligned)$")),
    ("unbounded turn", re.compile(r"JointModelR(UB[XYZ]|evoluteUnboundedUnaligned)$")),
    ("slide", re.compile(r"JointModelP([XYZ]|rismaticUnaligned)$")),
    ("planar", re.compile(r"JointModelPlanar$")),
    ("floating", re.compile(r"JointModelFreeFlyer$")),
]
# nq and nv in this project's coordinates.
SIZES = {"turn": (1, 1), "unbounded turn": (1, 1), "slide": (1, 1), "planar": (3, 3), "floating": (7, 6)}
BASE = "the floating base"


class Robot:
    """A model, and the index of each moving joint in q and v."""

    def __init__(self, model, mimics):
        self.model, self.joints, self.mimics = model, [], {}
        nq = nv = 0
        for i in range(1, model.njoints):
            name, short = model.names[i], model.joints[i].shortname()
            kind = next((kind for kind, pattern in KINDS if pattern.match(short)), None)
            if kind is None:
                raise ValueError(f"joint type {short} is not compared")
            if name in mimics:
                self.mimics[name] = mimics[name]
                sizes = (0, 0)
            else:
                sizes = SIZES[kind]
            place = dict(zip(("q_index", "nq", "v_index", "nv"), (nq, sizes[0], nv, sizes[1])))
            self.joints.append({"name": name, "kind": kind, "id": i} | place)
            nq, nv = nq + sizes[0], nv + sizes[1]
        self.nq, self.nv = nq, nv
        self.by_name = {joint["name"]: joint for joint in self.joints}

    def leader(self, name):
        """The independent joint at the end of a mimic chain, and q = ratio q_leader + offset."""
        ratio, offset, seen = 1.0, 0.0, {name}
        while name in self.mimics:
            name, k, c = self.mimics[name]
            if name in seen or name not in self.by_name:
                raise ValueError(f"a joint follows {name}, which is no moving joint or follows it in turn")
            seen.add(name)
            ratio, offset = ratio * k, offset + ratio * c
        return self.by_name[name], ratio, offset

    def random_state(self, rng):
        """Angles within 2.5 rad, translations within 0.5 m, any rotation of a floating joint, velocities
        within 2."""
        q = []
        for joint in (joint for joint in self.joints if joint["nq"]):
            if joint["kind"] == "floating":
                turn = rng.normal(size=4)
                q += [*rng.uniform(-1, 1, 3), *(turn / np.linalg.norm(turn))]
            elif joint["kind"] == "planar":
                q += [*rng.uniform(-0.5, 0.5, 2), rng.uniform(-2.5, 2.5)]
            else:
                size = 0.5 if joint["kind"] == "slide" else 2.5
                q.append(rng.uniform(-size, size))
        return np.array(q, dtype=float), rng.uniform(-2, 2, self.nv)

    def pinocchio(self, q, v):
        """Pinocchio's q, G, and dG/dt v."""
        full = np.zeros(self.model.nq)
        g, rate = np.zeros((self.model.nv, self.nv)), np.zeros(self.model.nv)
        for joint in self.joints:
            own = self.model.joints[joint["id"]]
            row, place = own.idx_v, slice(own.idx_q, own.idx_q + own.nq)
            if joint["kind"] == "floating":
                full[place] = q[joint["q_index"] :][:7]
                g[row : row + 6, joint["v_index"] : joint["v_index"] + 6] = np.eye(6)
            elif joint["kind"] == "planar":
                x, y, angle = q[joint["q_index"] :][:3]
                c, s, j = np.cos(angle), np.sin(angle), joint["v_index"]
                full[place] = [x, y, c, s]
                g[row : row + 3, j : j + 3] = [[c, s, 0], [-s, c, 0], [0, 0, 1]]
                rate[row : row + 2] = v[j + 2] * np.array([[-s, c], [-c, -s]]) @ v[j : j + 2]
            else:
                leader, ratio, offset = self.leader(joint["name"])
                if SIZES[leader["kind"]] != (1, 1):
                    raise ValueError(f"a joint follows {leader['name']}, which has more than one number")
                x = ratio * q[leader["q_index"]] + offset
                full[place] = [np.cos(x), np.sin(x)] if joint["kind"] == "unbounded turn" else [x]
                g[row, leader["v_index"]] = ratio
        return full, g, rate

    def values(self, q, v):
        """M, bias, gravity."""
        model, data = self.model, self.model.createData()
        full, g, rate = self.pinocchio(q, v)
        upper = np.triu(pin.crba(model, data, full, pin.Convention.LOCAL))
        mass = g.T @ (upper + np.triu(upper, 1).T) @ g
        # The joint of each number; mimic joints add to their leader's.
        size = np.abs(g).T ** 2 @ self.sizes(data)
        bias = g.T @ pin.rnea(model, data, full, g @ v, rate)
        gravity = g.T @ pin.computeGeneralizedGravity(model, data, full)
        size = np.sqrt(np.maximum(size, np.abs(np.diag(mass))))
        values = {"mass_matrix": mass, "bias": bias, "gravity": gravity, "size": size}
        return {key: value.tolist() for key, value in values.items()}

    def sizes(self, data):
        """For each of Pinocchio's velocities the largest inertia of the bodies that it moves: mass, or moment
        about any axis through the joint's origin."""
        sizes = np.zeros(self.model.nv)
        for joint in self.joints:
            own, body = self.model.joints[joint["id"]], data.Ycrb[joint["id"]]
            cross = pin.skew(body.lever)
            about = body.inertia - body.mass * cross @ cross
            moment = np.max(np.abs(np.linalg.eigvalsh(about))) if np.all(np.isfinite(about)) else np.nan
            rows = {"floating": [body.mass] * 3 + [moment] * 3, "planar": [body.mass] * 2 + [moment]}
            rows |= {"slide": [body.mass]}
            sizes[own.idx_v : own.idx_v + own.nv] = rows.get(joint["kind"], [moment])
        return sizes

    def moved_masses(self):
        """For each number of v the mass that it moves."""
        data = self.model.createData()
        pin.computeSubtreeMasses(self.model, data)
        moved = np.zeros(self.nv)
        for joint in self.joints:
            target = joint if joint["nv"] else self.leader(joint["name"])[0]
            place = slice(target["v_index"], target["v_index"] + target["nv"])
            moved[place] = np.maximum(moved[place], data.mass[joint["id"]])
        return moved


def answer(request):
    """The robot's joints, states and values; {"refused": why} if Pinocchio does not load the file."""
    path = request["file"]
    try:
        with open(path, "rb") as file:
            mimics = followers(file.read())
        base = (pin.JointModelFreeFlyer(), BASE) if request["floating"] else ()
        # The row of a fault uses Pinocchio's own mimic joints; the comparisons use G.
        own = {"mimic": True} if request.get("own mimics") else {}
        model = pin.buildModelFromUrdf(path, *base, **own)
        for name, value in request.get("armature", {}).items():
            joint = model.joints[model.getJointId(name)] if model.existJointName(name) else None
            if joint is not None and joint.nv == 1:
                model.armature[joint.idx_v] = value
    except Exception as error:  # noqa: BLE001: whatever the library throws is its answer
        return {"refused": f"{type(error).__name__}: {error}"}
    result = {"nv": model.nv}
    if request.get("own mimics"):
        upper = np.triu(pin.crba(model, model.createData(), pin.neutral(model)))
        return result | {"mass_matrix": upper.tolist()}
    try:
        robot = Robot(model, mimics)
        rng = np.random.default_rng(zlib.crc32(request.get("seed", path).encode()))
        states = [robot.random_state(rng) for _ in range(request["states"])]
        result["joints"] = robot.joints
        result["states"] = [{"q": q.tolist(), "v": v.tolist()} for q, v in states]
        result["values"] = [robot.values(q, v) for q, v in states]
        result["moved"] = robot.moved_masses().tolist()
    except Exception as error:  # noqa: BLE001
        result["not compared"] = f"{type(error).__name__}: {error}"
    return result


if __name__ == "__main__":
    serve(answer)
