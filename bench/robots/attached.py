#!/usr/bin/env python3
"""Compares the command `dynamics` with MuJoCo on random MJCF files that attach and replicate parts of one
another.

    python3 bench/robots/attached.py [--files 300] [--seed 1] [--command target/release/dynamics]

Each file attaches parts of one or two others, and of itself: worlds, bodies and frames, some inside
replicates. They have default classes, tendons, actuators, equalities and poses. Both programs must reject the
file, or have the same joints with the same damping, and bodies of the same mass. Actuators, tendons,
equalities and poses must also agree, in the same order.

MuJoCo 4.0.0 stores the numbers of a pose in the joints of the attached model. A second attachment under
another prefix therefore shares the first one's pose. If a model is attached twice, poses are compared by name
only.
"""

import argparse
import json
import random
import re
import subprocess
import sys
import tempfile
from pathlib import Path

HERE = Path(__file__).resolve().parent
sys.path.insert(0, str(HERE.parent / "golden"))
import environment  # noqa: E402

if __name__ == "__main__":
    environment.enter(HERE / "menagerie.txt")

import mujoco  # noqa: E402


class Part:
    """A random tree of bodies with the elements that refer to them."""

    def __init__(self, rng, prefix, depth):
        self.rng, self.prefix = rng, prefix
        self.names = {"body": [], "joint": [], "site": [], "frame": []}
        self.bodies = self.tree(depth)

    def named(self, sort):
        """The next name of a kind."""
        names = self.names[sort]
        names.append(f"{self.prefix}{sort}{len(names)}")
        return names[-1]

    def tree(self, depth):
        """One or two bodies with children."""
        rng, text = self.rng, ""
        for _ in range(rng.randint(1, 2)):
            body, joint = self.named("body"), self.named("joint")
            size = rng.choice(["", ' size="0.2"'])
            own = f'<joint name="{joint}" axis="0 {rng.choice([0, 1])} 1"/><geom{size}/>'
            if rng.random() < 0.5:
                own += f'<site name="{self.named("site")}" pos="0 0 .1"/>'
            if depth > 0 and rng.random() < 0.7:
                inner = self.tree(depth - 1)
                if rng.random() < 0.5:
                    inner = f'<frame name="{self.named("frame")}" pos="0 0 1"{self.childclass()}>{inner}</frame>'
                own += inner
            text += f'<body name="{body}" pos="0 0 {rng.randint(1, 3)}"{self.childclass()}>{own}</body>'
        return text

    def childclass(self):
        """One of the classes, sometimes."""
        return f' childclass="{self.rng.choice("AB")}"' if self.rng.random() < 0.4 else ""

    def outside(self):
        """Tendons, actuators and equalities of the tree, and the number of actuators."""
        rng, joints, tendons, text = self.rng, self.names["joint"], [], ""
        for index in range(rng.randint(0, 2)):
            tendons.append(f"{self.prefix}tendon{index}")
            over = rng.sample(joints, min(len(joints), rng.randint(1, 2)))
            terms = "".join(f'<joint joint="{joint}" coef="{rng.randint(1, 3)}"/>' for joint in over)
            text += f'<tendon><fixed name="{tendons[-1]}">{terms}</fixed></tendon>'
        targets = [("joint", joint) for joint in joints] + [("tendon", tendon) for tendon in tendons]
        targets += [("site", site) for site in self.names["site"]]
        count = rng.randint(0, 3)
        for index in range(count):
            sort, target = rng.choice(targets)
            text += f'<actuator><motor name="{self.prefix}motor{index}" {sort}="{target}"/></actuator>'
        if rng.random() < 0.5 and len(joints) > 1:
            one, other = rng.sample(joints, 2)
            text += f'<equality><joint name="{self.prefix}like" joint1="{one}" joint2="{other}"/></equality>'
        if rng.random() < 0.4:
            world = rng.choice(["", ' body2="world"'])
            pinned = rng.choice(self.names["body"])
            text += f'<equality><connect name="{self.prefix}pin" body1="{pinned}"{world} anchor="0 0 0"/></equality>'
        return text, count


def classes(damping):
    """Defaults that differ from model to model."""
    inner = '<default class="B"><geom density="500"/></default>'
    inner = f'<default class="A"><joint damping="{damping + 1}"/>{inner}</default>'
    return f'<default><joint damping="{damping}"/><geom size="0.1"/>{inner}</default>'


def write(folder, rng, name):
    """A file and those that it attaches. Returns its path."""
    models = []
    for index in range(rng.randint(1, 2)):
        part = Part(rng, "", 2)
        outside, motors = part.outside()
        if rng.random() < 0.6:
            numbers = " ".join(f"{rng.random():.2f}" for _ in part.names["joint"])
            held = " ".join(["3"] * motors)
            controls = f' ctrl="{held}"' if motors else ""
            outside += f'<keyframe><key name="pose" qpos="{numbers}"{controls}/></keyframe>'
        text = f'<mujoco model="m{index}">{classes(10 * index + 10)}<worldbody>{part.bodies}</worldbody>{outside}</mujoco>'
        models.append((f"{name}_{index}.mjcf.xml", part.names))
        (folder / models[-1][0]).write_text(text)
    part = Part(rng, "own_", 1)

    def attach():
        prefix = f"{rng.choice('uvwxyz')}{rng.randint(0, 999)}_"
        if rng.random() < 0.15:
            return f'<attach body="{rng.choice(part.names["body"])}" prefix="{prefix}"/>'
        index = rng.randrange(len(models))
        sort = rng.choice(["", "body", "frame"])
        own = models[index][1].get(sort)
        which = f'{sort}="{rng.choice(own)}"' if own else ""
        return f'<attach model="m{index}" {which} prefix="{prefix}"/>'

    attached = ""
    for _ in range(rng.randint(1, 3)):
        one = attach()
        if rng.random() < 0.3:
            one = f'<frame pos="1 0 0" childclass="A">{one}</frame>'
        if rng.random() < 0.3:
            one = f'<replicate count="{rng.randint(1, 3)}" offset="1 0 0" sep="-">{one}</replicate>'
        attached += one
    bodies = f'<replicate count="2" offset="0 1 0">{part.bodies}</replicate>' if rng.random() < 0.3 else part.bodies
    inside = attach() if rng.random() < 0.5 else ""
    bodies += attached + f'<body name="last"><joint name="last"/><geom size="0.1"/>{inside}</body>'
    assets = "".join(f'<model file="{file}"/>' for file, _ in models)
    path = folder / f"{name}.xml"
    text = f"<asset>{assets}</asset><worldbody>{bodies}</worldbody>{part.outside()[0]}"
    path.write_text(f'<mujoco model="main">{classes(1)}{text}</mujoco>')
    return path


def theirs(path):
    """MuJoCo's model as data; None if it rejects the file."""
    try:
        model = mujoco.MjModel.from_xml_path(str(path))
    except ValueError:
        return None
    names = lambda sort, count: [getattr(model, sort)(index).name for index in range(count)]  # noqa: E731
    return {
        "joints": names("joint", model.njnt),
        "damping": [float(x) for x in model.dof_damping],
        "masses": {model.body(index).name: float(model.body_mass[index]) for index in range(1, model.nbody)},
        "actuators": names("actuator", model.nu),
        "tendons": names("tendon", model.ntendon),
        "equalities": names("equality", model.neq),
        "poses": {
            model.key(index).name: [model.key_qpos[index].tolist(), model.key_ctrl[index].tolist()]
            for index in range(model.nkey)
        },
    }


def ours(command, path):
    """The command's model as the same data."""
    run = subprocess.run([command, "inspect", str(path), "--json"], capture_output=True, timeout=100, check=False)
    if run.returncode != 0:
        return None
    robot = json.loads(run.stdout)
    joints = [joint for joint in robot["joints"] if joint["nv"] > 0]
    named = lambda list_of: [one["name"] for one in robot[list_of]]  # noqa: E731
    controls = len(robot["actuators"])
    return {
        "joints": [joint["name"] for joint in joints],
        "damping": [joint["passive"]["damping"] for joint in joints],
        "masses": {link["name"]: link["mass"] for link in robot["links"]},
        "actuators": named("actuators"),
        "tendons": named("tendons"),
        "equalities": named("equalities"),
        "poses": {
            pose["name"]: [[x for _, q in pose["positions"] for x in q], pose["controls"] or [0.0] * controls]
            for pose in robot["poses"]
        },
    }


def difference(path, own, other):
    """The difference in words; None without one."""
    if own is None or other is None:
        return None if own is other else f"refused by {'dynamics' if own is None else 'MuJoCo'} alone"
    for key in ("joints", "damping", "actuators", "tendons", "equalities"):
        if own[key] != other[key]:
            return f"{key}: {own[key]} {other[key]}"
    for body, mass in other["masses"].items():
        if abs(own["masses"].get(body, -1.0) - mass) > 1e-9 * mass:
            return f"mass of {body!r}: {own['masses'].get(body)} {mass}"
    models = re.findall(r'model="(m\d)"', path.read_text())
    same = own["poses"] == other["poses"] if len(set(models)) == len(models) else set(own["poses"]) == set(other["poses"])
    return None if same else f"poses: {own['poses']} {other['poses']}"


def main():
    """Counts equal files and lists differences."""
    parser = argparse.ArgumentParser(description=__doc__, formatter_class=argparse.RawDescriptionHelpFormatter)
    parser.add_argument("--files", type=int, default=300)
    parser.add_argument("--seed", type=int, default=1)
    parser.add_argument("--command", default=str(environment.ROOT / "target" / "release" / "dynamics"))
    given = parser.parse_args()
    rng, counts = random.Random(given.seed), {"same": 0, "refused by both": 0, "different": 0}
    with tempfile.TemporaryDirectory() as folder:
        for index in range(given.files):
            path = write(Path(folder), rng, f"main{index}")
            own, other = ours(given.command, path), theirs(path)
            found = difference(path, own, other)
            counts["different" if found else "same" if own else "refused by both"] += 1
            if found:
                print(f"seed {given.seed}, file {index}: {found}")
    print(counts)
    sys.exit(1 if counts["different"] else 0)


if __name__ == "__main__":
    main()
