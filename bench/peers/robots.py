"""The robots and states of all programs, each in its own file format and convention of base velocities.

All programs get the same tree: the moving joints of Pinocchio's model of the robot file, with links that
fixed joints connect merged.
"""

import json
import struct
import sys
import zlib
from xml.etree import ElementTree

import numpy as np
import pinocchio as pin

from sides import ROOT

sys.path.insert(0, str(ROOT / "bench" / "golden"))
import environment as golden_environment
from described_robot import describe
from golden_file import plain
from reference import Robot as Reference

# name: (file of this repository, or of example-robot-data/robots; floating base)
ROBOTS = {
    "panda": ("robots/panda.urdf", False),
    "talos": ("talos_data/robots/talos_reduced.urdf", True),
    "ur5": ("robots/ur5.urdf", False),
    "anymal_c": ("anymal_c_simple_description/urdf/anymal.urdf", True),
}
STATES = 1024
# dynibo's gravity, for the comparison of its numbers.
STANDARD_GRAVITY = 9.80665


def numbers(*parts):
    """The numbers as decimals that parse to the same value."""
    return " ".join(repr(float(x)) for part in parts for x in np.ravel(part))


class Robot:
    """One robot: its description, its states, and its files for every program."""

    def __init__(self, name, cache, count=STATES):
        self.name = name
        file, self.floating = ROBOTS[name]
        urdf = ROOT / file if file.startswith("robots/") else golden_environment.robots_folder() / file
        reference = Reference.from_urdf(urdf, self.floating)
        if reference.mimics:
            raise ValueError(f"{name} has joints that follow others: not every side knows them")
        self.description = describe(reference, name)
        self.joints = self.description["joints"]
        self.nq, self.nv = reference.nq, reference.nv
        self.tip = reference.tip() - reference.first
        links = [link["name"] for link in self.description["links"]]
        # 0 is the root link, k + 1 the link that joint k moves.
        self.parents = [links.index(joint["parent"]) for joint in self.joints]
        self.masses = {link["name"]: link["mass_properties"] for link in self.description["links"]}
        self.root = links[0]
        self.folder = cache / "robots" / name
        self.folder.mkdir(parents=True, exist_ok=True)
        rng = np.random.default_rng(zlib.crc32(name.encode()))
        self.states = [reference.random_state(rng) for _ in range(count)]
        self.rotations = [rotation(state["q"]) if self.floating else None for state in self.states]
        self.write()

    def write(self):
        """All files."""
        (self.folder / "robot.json").write_text(json.dumps({"description": plain(self.description)}))
        standard = plain(self.description | {"gravity": [0.0, 0.0, -STANDARD_GRAVITY]})
        (self.folder / "robot.standard_gravity.json").write_text(json.dumps({"description": standard}))
        (self.folder / "robot.txt").write_text(self.as_text())
        (self.folder / "robot.xml").write_text(self.as_mjcf())
        (self.folder / "robot.urdf").write_text(self.as_urdf())
        for convention in ("body", "mixed", "world"):
            rows = [self.in_convention(i, convention) for i in range(len(self.states))]
            header = struct.pack("<4Q", len(rows), self.nq, self.nv, self.tip)
            data = header + np.array(rows, dtype="<f8").tobytes()
            (self.folder / f"states.{convention}.bin").write_bytes(data)

    def base_from_body(self, i, convention):
        """T with v = T v_body for the base's six numbers; it is orthogonal, so forces transform by the same
        T."""
        r, zero, one = self.rotations[i], np.zeros((3, 3)), np.eye(3)
        return {
            "body": np.eye(6),
            "mixed": np.block([[r, zero], [zero, one]]),  # linear in world axes, angular in base axes
            "world": np.block([[zero, r], [r, zero]]),  # angular, linear, in world axes
        }[convention]

    def in_convention(self, i, convention):
        """q v a tau of a state in a program's convention."""
        q, v, a, tau = (self.states[i][key].copy() for key in ("q", "v", "a", "tau"))
        if self.floating and convention != "body":
            turn = self.base_from_body(i, convention)
            # The acceleration of the base's origin is the rate of its velocity's components plus omega x v.
            a[:3] += np.cross(v[3:6], v[:3])
            for vector in (v, a, tau):
                vector[:6] = turn @ vector[:6]
            if convention == "mixed":
                q[3:7] = q[[6, 3, 4, 5]]  # w first
        return np.concatenate([q, v, a, tau])

    def back(self, i, convention, algorithm, result):
        """A program's result in the convention of the states: base velocities in base axes."""
        if not self.floating or convention == "body" or algorithm == "frame_poses":
            return result
        turn = np.eye(self.nv)
        turn[:6, :6] = self.base_from_body(i, convention)
        if algorithm == "mass_matrix":
            return (turn.T @ result.reshape(self.nv, self.nv) @ turn).ravel()
        if algorithm == "jacobian":
            return (result.reshape(6, self.nv) @ turn).ravel()
        result = turn.T @ result
        if algorithm == "forward_dynamics":
            v = self.states[i]["v"]
            result[:3] -= np.cross(v[3:6], v[:3])
        return result

    def as_text(self):
        """The format of pinocchio_side.cpp."""

        def mass(link):
            properties = self.masses[link]
            return numbers(*(properties[key] for key in ("mass", "center_of_mass", "inertia")))

        lines = [f"{int(self.floating)} {len(self.joints)}"]
        lines += [mass(self.root)] if self.floating else []
        for parent, joint in zip(self.parents, self.joints):
            (kind, motion), place = next(iter(joint["kind"].items())), joint["parent_from_joint"]
            where = numbers(place["rotation"], place["translation"], motion["axis"])
            lines.append(f"{parent} {int(kind == 'Prismatic')} {where} {mass(joint['child'])}")
        return "\n".join(lines) + "\n"

    def as_mjcf(self):
        """MuJoCo's format, contacts off."""
        mujoco = ElementTree.Element("mujoco")
        ElementTree.SubElement(mujoco, "compiler", angle="radian")
        option = ElementTree.SubElement(mujoco, "option", gravity="0 0 -9.81")
        ElementTree.SubElement(option, "flag", contact="disable")
        world = ElementTree.SubElement(mujoco, "worldbody")
        bodies = [world]
        if self.floating:
            bodies = [ElementTree.SubElement(world, "body", name="root")]
            ElementTree.SubElement(bodies[0], "freejoint")
            self.inertial(bodies[0], self.root)
        for k, (parent, joint) in enumerate(zip(self.parents, self.joints)):
            (kind, motion), place = next(iter(joint["kind"].items())), joint["parent_from_joint"]
            x, y, z, w = pin.Quaternion(np.array(place["rotation"])).coeffs()
            pose = {"pos": numbers(place["translation"]), "quat": numbers([w, x, y, z])}
            body = ElementTree.SubElement(bodies[parent], "body", name=f"l{k}", **pose)
            kind = "slide" if kind == "Prismatic" else "hinge"
            ElementTree.SubElement(body, "joint", name=f"j{k}", type=kind, axis=numbers(motion["axis"]))
            self.inertial(body, joint["child"])
            bodies.append(body)
        return ElementTree.tostring(mujoco, encoding="unicode")

    def inertial(self, body, link):
        """Mass properties in MuJoCo's order: xx yy zz xy xz yz."""
        properties = self.masses[link]
        xx, xy, xz, yy, yz, zz = properties["inertia"]
        mass, center = numbers([properties["mass"]]), numbers(properties["center_of_mass"])
        inertia = numbers([xx, yy, zz, xy, xz, yz])
        ElementTree.SubElement(body, "inertial", mass=mass, pos=center, fullinertia=inertia)

    def as_urdf(self):
        """URDF with joints j0, j1, ... and links l0, l1, ..."""
        robot = ElementTree.Element("robot", name=self.name)

        def add_link(name, link):
            element = ElementTree.SubElement(robot, "link", name=name)
            if properties := self.masses[link]:
                inertial = ElementTree.SubElement(element, "inertial")
                ElementTree.SubElement(inertial, "origin", xyz=numbers(properties["center_of_mass"]), rpy="0 0 0")
                ElementTree.SubElement(inertial, "mass", value=numbers([properties["mass"]]))
                keys = ("ixx", "ixy", "ixz", "iyy", "iyz", "izz")
                values = {key: numbers([x]) for key, x in zip(keys, properties["inertia"])}
                ElementTree.SubElement(inertial, "inertia", **values)

        add_link("root", self.root)
        for k, (parent, joint) in enumerate(zip(self.parents, self.joints)):
            (kind, motion), place = next(iter(joint["kind"].items())), joint["parent_from_joint"]
            add_link(f"l{k}", joint["child"])
            kind = "prismatic" if kind == "Prismatic" else "revolute"
            element = ElementTree.SubElement(robot, "joint", name=f"j{k}", type=kind)
            rpy = numbers(pin.rpy.matrixToRpy(np.array(place["rotation"])))
            ElementTree.SubElement(element, "origin", xyz=numbers(place["translation"]), rpy=rpy)
            ElementTree.SubElement(element, "parent", link=f"l{parent - 1}" if parent else "root")
            ElementTree.SubElement(element, "child", link=f"l{k}")
            ElementTree.SubElement(element, "axis", xyz=numbers(motion["axis"]))
            ElementTree.SubElement(element, "limit", lower="-10", upper="10", effort="1000", velocity="100")
        return ElementTree.tostring(robot, encoding="unicode")


def rotation(q):
    """world_from_base of a floating base, q = x y z, qx qy qz qw."""
    return pin.XYZQUATToSE3(np.array(q[:7])).rotation
