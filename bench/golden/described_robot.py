"""A robot as the numbers of this project's `RobotDescription`, from Pinocchio's model and back."""

import numpy as np
import pinocchio as pin

from reference import Robot

EARTH_GRAVITY = [0.0, 0.0, -9.81]
# Pinocchio's value for "no limit".
UNLIMITED = np.finfo(float).max


def describe(robot, name):
    """The description of a robot: a link per moving joint, named after it, and a root link.

    A root that is fixed to the world has no mass properties here. It does not move, and Pinocchio leaves it
    out of the centre of mass and the energies.
    """
    model, data = robot.model, robot.model.createData()
    if not np.array_equal(model.gravity.linear, EARTH_GRAVITY):
        raise AssertionError(f"gravity is {model.gravity.linear}")
    root = 1 if robot.floating else 0
    link = {root: "base_link"} | {i: f"{model.names[i]}_link" for i in range(robot.first, model.njoints)}
    links, joints = [], []
    for i, link_name in link.items():
        fixed_root = i == root and not robot.floating
        numbers = None if fixed_root else mass_properties(model.inertias[i])
        links.append({"name": link_name, "mass_properties": numbers})
    for i in range(robot.first, model.njoints):
        joint, joint_name = model.joints[i], model.names[i]
        motion = np.array(data.joints[i].S, dtype=float).reshape(6)
        kind = robot.kinds[i - robot.first]
        mimic = robot.mimics.get(joint_name)
        joints.append(
            {
                "name": joint_name,
                "kind": {kind: {"axis": motion[:3] if kind == "Prismatic" else motion[3:]}},
                "parent": link[model.parents[i]],
                "child": link[i],
                "parent_from_joint": pose(model.jointPlacements[i]),
                "limits": limits(model, joint, kind),
                "passive": {
                    "armature": model.armature[joint.idx_v],
                    "damping": 0.0,
                    "friction": 0.0,
                    "stiffness": 0.0,
                    "rest": 0.0,
                },
                "mimic": mimic and dict(zip(("joint", "ratio", "offset"), mimic)),
            }
        )
    base = "Floating" if robot.floating else "Fixed"
    description = {"name": name, "gravity": EARTH_GRAVITY, "base": base}
    return description | {"links": links, "joints": joints, "frames": []}


def mass_properties(inertia):
    """Mass, centre of mass, and inertia about it along the link's axes: xx xy xz yy yz zz."""
    i = inertia.inertia
    six = [i[0, 0], i[0, 1], i[0, 2], i[1, 1], i[1, 2], i[2, 2]]
    return {"mass": inertia.mass, "center_of_mass": inertia.lever.copy(), "inertia": six}


def pose(placement):
    """Rotation in row-major order and translation."""
    return {"rotation": placement.rotation.copy(), "translation": placement.translation.copy()}


def limits(model, joint, kind):
    """The joint's limits; a continuous joint has none on its position."""

    def bound(x):
        return float(np.sign(x) * np.inf) if abs(x) >= UNLIMITED else float(x)

    lower, upper = -np.inf, np.inf
    if kind != "Continuous":
        lower, upper = bound(model.lowerPositionLimit[joint.idx_q]), bound(model.upperPositionLimit[joint.idx_q])
    velocity, effort = bound(model.velocityLimit[joint.idx_v]), bound(model.effortLimit[joint.idx_v])
    return {"lower": lower, "upper": upper, "velocity": velocity, "effort": effort}


def rebuilt(description):
    """The robot from the description's numbers alone; each continuous joint has its angle as coordinate."""
    model, ids = pin.Model(), {}
    properties = {link["name"]: link["mass_properties"] for link in description["links"]}

    def add_body(joint_id, link):
        numbers = properties[link]
        if numbers is None:
            return
        xx, xy, xz, yy, yz, zz = numbers["inertia"]
        about = np.array([[xx, xy, xz], [xy, yy, yz], [xz, yz, zz]])
        body = pin.Inertia(numbers["mass"], np.array(numbers["center_of_mass"]), about)
        model.appendBodyToJoint(joint_id, body, pin.SE3.Identity())

    root = description["links"][0]["name"]
    ids[root] = 0
    if description["base"] == "Floating":
        ids[root] = model.addJoint(0, pin.JointModelFreeFlyer(), pin.SE3.Identity(), "root_joint")
        add_body(ids[root], root)
    for joint in description["joints"]:
        (kind, parameters), place = next(iter(joint["kind"].items())), joint["parent_from_joint"]
        plain = pin.JointModelPrismaticUnaligned if kind == "Prismatic" else pin.JointModelRevoluteUnaligned
        placement = pin.SE3(np.array(place["rotation"]), np.array(place["translation"]))
        axis = np.array(parameters["axis"])
        ids[joint["child"]] = model.addJoint(ids[joint["parent"]], plain(axis), placement, joint["name"])
        add_body(ids[joint["child"]], joint["child"])
    mimics = {j["name"]: tuple(j["mimic"].values()) for j in description["joints"] if j["mimic"]}
    base = 6 if description["base"] == "Floating" else 0
    armature = [0.0] * base + [joint["passive"]["armature"] for joint in description["joints"]]
    return Robot(model, mimics, armature)
