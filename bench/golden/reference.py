"""Pinocchio's model of a robot, accessed in this project's conventions.

q has one number per independent joint, also for a joint without limits (Pinocchio: cos, sin). For a floating
base q starts with x y z, qx qy qz qw, and v with the linear and angular velocity in base axes. A mimic joint
has no entry in q and v. A constant linear map v = G y from the independent velocities y to all velocities
includes its motion: M_y = G^T M G, tau_y = G^T tau.

Pinocchio's functions return views into `data`: every result is copied, or multiplied by G, before `data` is
freed.
"""

import re
from xml.etree import ElementTree

import numpy as np
import pinocchio as pin

REVOLUTE = re.compile(r"JointModelR(X|Y|Z|evoluteUnaligned)$")
CONTINUOUS = re.compile(r"JointModelR(UB[XYZ]|evoluteUnboundedUnaligned)$")
PRISMATIC = re.compile(r"JointModelP(X|Y|Z|rismaticUnaligned)$")


class Unsupported(Exception):
    """The robot has a feature that the reference does not cover; the message names it."""


def kind_of(joint):
    """The joint's kind, by this project's name."""
    name = joint.shortname()
    for kind, pattern in (("Revolute", REVOLUTE), ("Continuous", CONTINUOUS), ("Prismatic", PRISMATIC)):
        if pattern.match(name):
            return kind
    if name == "JointModelFreeFlyer":
        return "Floating"
    raise Unsupported(f"joint type {name}")


def mimics_in(urdf):
    """{mimic joint: (joint, ratio, offset)} of the robot file; a fixed joint mimics no joint."""
    found = {}
    for joint in ElementTree.parse(urdf).getroot().iter("joint"):
        mimic = joint.find("mimic")
        if mimic is not None and joint.get("type") not in (None, "fixed"):
            ratio, offset = (float(mimic.get(key, default)) for key, default in (("multiplier", 1), ("offset", 0)))
            found[joint.get("name")] = (mimic.get("joint"), ratio, offset)
    return found


class Robot:
    """A Pinocchio model without mimic joints in q and v."""

    def __init__(self, model, mimics, armature=None):
        self.model = model
        self.floating = model.njoints > 1 and model.joints[1].shortname() == "JointModelFreeFlyer"
        self.first = 2 if self.floating else 1
        self.kinds = [kind_of(joint) for joint in list(model.joints)[self.first :]]
        self.names = list(model.names)[self.first :]
        if "Floating" in self.kinds:
            raise Unsupported("floating joint inside the tree")
        if armature is not None:
            model.armature = np.asarray(armature, dtype=float)
        self.mimics = {name: mimic for name, mimic in mimics.items() if name in self.names}
        self.independent = [name for name in self.names if name not in self.mimics]
        self.base_nq, self.base_nv = (7, 6) if self.floating else (0, 0)
        self.nq = self.base_nq + len(self.independent)
        self.nv = self.base_nv + len(self.independent)
        self.followers_from_leaders()

    @classmethod
    def from_urdf(cls, urdf, floating=False, armature=None):
        """The robot of a file; its root link floats or is fixed to the world."""
        arguments = (str(urdf), pin.JointModelFreeFlyer()) if floating else (str(urdf),)
        return cls(pin.buildModelFromUrdf(*arguments), mimics_in(urdf), armature)

    def followers_from_leaders(self):
        """G and c of (all joints' numbers) = G (independent joints' numbers) + c."""
        column = {name: i for i, name in enumerate(self.independent)}
        joints = np.zeros((len(self.names), len(self.independent)))
        offset = np.zeros(len(self.names))
        for row, name in enumerate(self.names):
            ratio, shift, seen = 1.0, 0.0, {name}
            while name in self.mimics:
                name, k, c = self.mimics[name]
                if name in seen or name not in self.names:
                    what = "which follows it in turn" if name in seen else "no moving joint of the robot"
                    raise Unsupported(f"joint {self.names[row]} follows {name}, {what}")
                ratio, shift = ratio * k, shift + ratio * c
                seen.add(name)
            joints[row, column[name]], offset[row] = ratio, shift
        self.joint_map, self.joint_offset = joints, offset
        base = self.base_nv
        self.g = np.zeros((self.model.nv, self.nv))
        self.g[:base, :base] = np.eye(base)
        # Pinocchio's v has its joints in the order of their names, with one number each.
        self.g[base:, base:] = joints

    def pinocchio_q(self, q):
        """Pinocchio's q: every joint, cos and sin for a continuous one."""
        numbers = list(q[: self.base_nq])
        for kind, x in zip(self.kinds, self.joint_map @ q[self.base_nq :] + self.joint_offset):
            numbers += [np.cos(x), np.sin(x)] if kind == "Continuous" else [x]
        return np.array(numbers, dtype=float)

    def layout(self):
        """The index of each independent joint in q and v."""
        rows = [{"name": "floating_base", "q_index": 0, "nq": 7, "v_index": 0, "nv": 6}] if self.floating else []
        for i, name in enumerate(self.independent):
            rows.append({"name": name, "q_index": self.base_nq + i, "nq": 1, "v_index": self.base_nv + i, "nv": 1})
        return rows

    def random_state(self, rng):
        """q, v, a, tau: angles within 2.5 rad, translations within 0.5 m, any rotation of the base."""
        q = [*rng.uniform(-1, 1, 3), *unit(rng.normal(size=4))] if self.floating else []
        slides = {name for name, kind in zip(self.names, self.kinds) if kind == "Prismatic"}
        q += [rng.uniform(-0.5, 0.5) if name in slides else rng.uniform(-2.5, 2.5) for name in self.independent]
        v, a, tau = (rng.uniform(-size, size, self.nv) for size in (2, 5, 20))
        return {"q": np.array(q, dtype=float), "v": v, "a": a, "tau": tau}

    def integrate(self, q, step):
        """The configuration after the displacement `step` (in the order of v); the base moves by a screw
        motion."""
        after = q.copy()
        if self.floating:
            moved = pin.XYZQUATToSE3(q[:7]) * pin.exp6(step[:6])
            after[:7] = pin.SE3ToXYZQUAT(moved)
        after[self.base_nq :] += step[self.base_nv :]
        return after

    def tip(self):
        """The joint with the most joints between it and the root; the last of several."""
        depth = [0] * self.model.njoints
        for i in range(1, self.model.njoints):
            depth[i] = depth[self.model.parents[i]] + 1
        return max(range(1, self.model.njoints), key=lambda i: (depth[i], i))

    def dynamics(self, q, v, a, tau):
        """The equation of motion M a + bias = tau and its parts."""
        model, g = self.model, self.g
        full_q, full_v, full_a = self.pinocchio_q(q), g @ v, g @ a
        data = model.createData()
        mass = g.T @ symmetric(pin.crba(model, data, full_q)) @ g
        out = {
            "mass_matrix": mass,
            "bias": g.T @ pin.nonLinearEffects(model, data, full_q, full_v),
            "gravity": g.T @ pin.computeGeneralizedGravity(model, data, full_q),
            "coriolis_matrix": g.T @ pin.computeCoriolisMatrix(model, data, full_q, full_v) @ g,
            "inverse_dynamics": g.T @ pin.rnea(model, data, full_q, full_v, full_a),
            "kinetic_energy": pin.computeKineticEnergy(model, data, full_q, full_v),
            "potential_energy": pin.computePotentialEnergy(model, data, full_q),
        }
        if self.mimics:
            try:
                out["forward_dynamics"] = np.linalg.solve(mass, tau - out["bias"])
            except np.linalg.LinAlgError:
                out["forward_dynamics"] = np.full(self.nv, np.nan)
        else:
            out["forward_dynamics"] = pin.aba(model, data, full_q, full_v, tau).copy()
        return out

    def momentum(self, q, v):
        """Centre of mass, its velocity, and the momentum about it, [linear, angular] in world axes."""
        model, full_q, full_v = self.model, self.pinocchio_q(q), self.g @ v
        data = model.createData()
        momentum = pin.computeCentroidalMomentum(model, data, full_q, full_v)
        momentum = np.concatenate([momentum.linear, momentum.angular])
        pin.centerOfMass(model, data, full_q, full_v)
        return {
            "center_of_mass": data.com[0].copy(),
            "center_of_mass_velocity": data.vcom[0].copy(),
            "centroidal_momentum": momentum,
            "centroidal_momentum_matrix": pin.computeCentroidalMap(model, data, full_q) @ self.g,
        }

    def kinematics(self, q, v):
        """Placements of the last joints and the tip's Jacobians, rows [linear, angular]."""
        model, full_q, full_v, tip = self.model, self.pinocchio_q(q), self.g @ v, self.tip()
        data = model.createData()
        pin.computeJointJacobians(model, data, full_q)
        pin.computeJointJacobiansTimeVariation(model, data, full_q, full_v)
        shown = sorted({*range(max(1, model.njoints - 3), model.njoints), tip})
        frames = {"world": pin.WORLD, "local": pin.LOCAL, "local_world_aligned": pin.LOCAL_WORLD_ALIGNED}
        return {
            "world_from_joint": {model.names[i]: data.oMi[i].homogeneous.copy() for i in shown},
            "tip_jacobian": {name: pin.getJointJacobian(model, data, tip, f) @ self.g for name, f in frames.items()},
            "tip_jacobian_rate": {
                name: pin.getJointJacobianTimeVariation(model, data, tip, f) @ self.g for name, f in frames.items()
            },
        }

    def derivatives(self, q, v, a, tau):
        """M^-1 and the derivatives of the inverse and forward dynamics by q (base: by its own axes' motion)
        and v."""
        model, g, full_q, full_v = self.model, self.g, self.pinocchio_q(q), self.g @ v

        def inverse(acceleration):
            data = model.createData()
            dq, dv, _ = pin.computeRNEADerivatives(model, data, full_q, full_v, g @ acceleration)
            return g.T @ dq @ g, g.T @ dv @ g

        by_q, by_v = inverse(a)
        out = {"inverse_dynamics_by_q": by_q, "inverse_dynamics_by_v": by_v}
        if self.mimics:
            values = self.dynamics(q, v, a, tau)
            minus_inverse = -np.linalg.inv(values["mass_matrix"])
            by_q, by_v = (minus_inverse @ d for d in inverse(values["forward_dynamics"]))
            out["inverse_mass_matrix"] = -minus_inverse
        else:
            data = model.createData()
            by_q, by_v, by_tau = pin.computeABADerivatives(model, data, full_q, full_v, tau)
            by_q, by_v, out["inverse_mass_matrix"] = by_q.copy(), by_v.copy(), symmetric(by_tau)
        out["forward_dynamics_by_q"], out["forward_dynamics_by_v"] = by_q, by_v
        return out

    def regressor(self, q, v, a):
        """Y of tau = Y pi, ten columns per moving link: m, m c, then xx xy yy xz yz zz about the link's
        origin."""
        full_q, full_v, full_a = self.pinocchio_q(q), self.g @ v, self.g @ a
        data = self.model.createData()
        return self.g.T @ pin.computeJointTorqueRegressor(self.model, data, full_q, full_v, full_a)

    def moving_mass(self):
        """Mass of the links that can move, without a fixed root and links fixed to it."""
        return pin.computeTotalMass(self.model) if self.model.njoints > 1 else 0.0

    def fixed_body(self):
        """Mass and centre of mass of the links that are fixed to the world, or None."""
        body = self.model.inertias[0]
        return None if self.floating or body.mass <= 0 else {"mass": body.mass, "center_of_mass": body.lever.copy()}


def unit(x):
    """x / |x|."""
    return x / np.linalg.norm(x)


def symmetric(m):
    """The symmetric matrix with m's upper triangle; Pinocchio may leave the lower one unset."""
    return np.triu(m) + np.triu(m, 1).T
