"""Write a URDF robot as USD text with attributes of double precision, by usd-core 26.11.

The bodies are flat, with poses in the world. Types of attributes in a file may be wider than those of the
schema: `quatd` for rotations of joints, `double` for masses.

    python -m venv venv
    venv/bin/pip install usd-core==26.11 numpy
    venv/bin/python bench/golden/make_usd_double.py
"""

import xml.etree.ElementTree as ElementTree
from pathlib import Path

import numpy as np
from pxr import Gf, Sdf, Usd, UsdGeom, UsdPhysics

ROOT = Path(__file__).resolve().parents[2]
ROBOT = "dual_arm"


def numbers(text: str) -> np.ndarray:
    """Return the numbers of an attribute."""
    return np.array([float(word) for word in text.split()])


def product(a: np.ndarray, b: np.ndarray) -> np.ndarray:
    """Return the product of two quaternions w, x, y, z."""
    vector = a[0] * b[1:] + b[0] * a[1:] + np.cross(a[1:], b[1:])
    return np.array([a[0] * b[0] - a[1:] @ b[1:], *vector])


def rotated(q: np.ndarray, v: np.ndarray) -> np.ndarray:
    """Return a vector, rotated by a quaternion."""
    return v + 2 * np.cross(q[1:], np.cross(q[1:], v) + q[0] * v)


def origin(element) -> tuple[np.ndarray, np.ndarray]:
    """Return the position and the rotation of an element's origin."""
    found = None if element is None else element.find("origin")
    if found is None:
        return np.zeros(3), np.array([1.0, 0, 0, 0])
    roll, pitch, yaw = numbers(found.get("rpy", "0 0 0")) / 2
    about = [np.array([np.cos(yaw), 0, 0, np.sin(yaw)]), np.array([np.cos(pitch), 0, np.sin(pitch), 0])]
    about.append(np.array([np.cos(roll), np.sin(roll), 0, 0]))
    return numbers(found.get("xyz", "0 0 0")), product(product(about[0], about[1]), about[2])


def x_onto(axis: np.ndarray) -> np.ndarray:
    """Return a rotation of x onto an axis."""
    axis = axis / np.linalg.norm(axis)
    if axis[0] < -0.999:
        return np.array([0.0, 0, 1, 0])
    q = np.array([1 + axis[0], 0, -axis[2], axis[1]])
    return q / np.linalg.norm(q)


def set_value(prim, name: str, kind, value) -> None:
    """Author an attribute in the layer: the stage refuses types that are not those of the schema."""
    spec = prim.GetStage().GetRootLayer().GetPrimAtPath(prim.GetPath())
    Sdf.AttributeSpec(spec, name, kind).default = value


def quaternion(q: np.ndarray) -> Gf.Quatd:
    """Return a quaternion of USD."""
    return Gf.Quatd(*map(float, q))


def add_link(stage, link, pose) -> None:
    """Add a body at its pose."""
    prim = UsdGeom.Xform.Define(stage, f"/{ROBOT}/{link.get('name')}").GetPrim()
    prim.ApplyAPI(UsdPhysics.RigidBodyAPI)
    xform = UsdGeom.Xformable(prim)
    xform.AddTranslateOp().Set(Gf.Vec3d(*map(float, pose[0])))
    xform.AddOrientOp(precision=UsdGeom.XformOp.PrecisionDouble).Set(quaternion(pose[1]))
    inertial = link.find("inertial")
    if inertial is None:
        return
    prim.AddAppliedSchema("PhysicsMassAPI")
    prim.AddAppliedSchema("NewtonMassAPI")
    at, turn = origin(inertial)
    inertia = inertial.find("inertia")
    xx, xy, xz, yy, yz, zz = (float(inertia.get(f"i{name}")) for name in ["xx", "xy", "xz", "yy", "yz", "zz"])
    own = np.array([[xx, xy, xz], [xy, yy, yz], [xz, yz, zz]])
    axes = np.array([rotated(turn, axis) for axis in np.eye(3)]).T
    own = axes @ own @ axes.T
    entries = [own[i] for i in [(0, 0), (1, 1), (2, 2), (0, 1), (0, 2), (1, 2)]]
    set_value(prim, "newton:inertia", Sdf.ValueTypeNames.DoubleArray, [float(entry) for entry in entries])
    set_value(prim, "physics:mass", Sdf.ValueTypeNames.Double, float(inertial.find("mass").get("value")))
    set_value(prim, "physics:centerOfMass", Sdf.ValueTypeNames.Point3d, Gf.Vec3d(*map(float, at)))


def add_joint(stage, joint) -> None:
    """Add a joint with its frames."""
    kinds = {"fixed": "Fixed", "revolute": "Revolute", "continuous": "Revolute", "prismatic": "Prismatic"}
    kind = kinds[joint.get("type")]
    prim = stage.DefinePrim(f"/{ROBOT}/joints/{joint.get('name')}", f"Physics{kind}Joint")
    at, turn = origin(joint)
    axis = joint.find("axis")
    align = x_onto(np.array([1.0, 0, 0]) if axis is None else numbers(axis.get("xyz")))
    for side, name in enumerate(["parent", "child"]):
        link = joint.find(name).get("link")
        prim.CreateRelationship(f"physics:body{side}", custom=False).SetTargets([f"/{ROBOT}/{link}"])
    set_value(prim, "physics:localPos0", Sdf.ValueTypeNames.Point3d, Gf.Vec3d(*map(float, at)))
    set_value(prim, "physics:localRot0", Sdf.ValueTypeNames.Quatd, quaternion(product(turn, align)))
    set_value(prim, "physics:localRot1", Sdf.ValueTypeNames.Quatd, quaternion(align))
    dynamics = joint.find("dynamics")
    if kind != "Fixed":
        set_value(prim, "physics:axis", Sdf.ValueTypeNames.Token, "X")
    if dynamics is not None:
        scale = np.pi / 180 if kind == "Revolute" else 1.0
        damping = float(dynamics.get("damping", 0)) * scale
        set_value(prim, "newton:damping", Sdf.ValueTypeNames.Double, damping)
        friction = float(dynamics.get("friction", 0))
        set_value(prim, "newton:friction", Sdf.ValueTypeNames.Double, friction)


def main() -> None:
    """Write the robot."""
    robot = ElementTree.parse(ROOT / "robots" / f"{ROBOT}.urdf").getroot()
    stage = Usd.Stage.CreateInMemory()
    UsdGeom.SetStageMetersPerUnit(stage, 1)
    UsdGeom.SetStageUpAxis(stage, "Z")
    stage.SetDefaultPrim(stage.DefinePrim(f"/{ROBOT}", "Xform"))
    joint_above = {joint.find("child").get("link"): joint for joint in robot.findall("joint")}

    def pose(link: str) -> tuple[np.ndarray, np.ndarray]:
        if link not in joint_above:
            return origin(None)
        at, turn = pose(joint_above[link].find("parent").get("link"))
        own_at, own_turn = origin(joint_above[link])
        return at + rotated(turn, own_at), product(turn, own_turn)

    links = robot.findall("link")
    for link in links:
        add_link(stage, link, pose(link.get("name")))
    for joint in robot.findall("joint"):
        add_joint(stage, joint)
    root = next(link.get("name") for link in links if link.get("name") not in joint_above)
    held = stage.DefinePrim(f"/{ROBOT}/joints/held", "PhysicsFixedJoint")
    held.CreateRelationship("physics:body1", custom=False).SetTargets([f"/{ROBOT}/{root}"])
    stage.GetRootLayer().Export(str(ROOT / "testdata" / "usd" / f"{ROBOT}.usda"))


if __name__ == "__main__":
    main()
