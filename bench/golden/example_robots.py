#!/usr/bin/env python3
"""Compares the command `dynamics` with Pinocchio on every URDF file of the package example-robot-data.

    python3 bench/golden/example_robots.py OUT [--command target/release/dynamics] [--states 5] [--only TEXT]

Each robot is tried twice, with its root fixed to the world and floating. OUT/ROBOT/ gets states.jsonl (one
state per line, as `dynamics compute` reads it) and golden.jsonl (the expected output), with joints in the
order of OUT/manifest.json. The command gets its own order, matched by name. The exit code is 1 if a number
differs by more than its bound.
"""

import argparse
import json
import subprocess
import sys
import zlib
from pathlib import Path

import environment

if __name__ == "__main__":
    environment.enter()

import numpy as np

from golden_file import plain
from reference import Robot, Unsupported

# Relative to the largest number of the quantity over a robot's states.
ROUNDING = 1e-12
QUANTITIES = {
    "mass_matrix": "M",
    "bias": "b",
    "gravity": "g",
    "coriolis_matrix": "C",
    "inverse_dynamics": "tau",
    "kinetic_energy": "T",
    "potential_energy": "V",
}


class NotCompared(Exception):
    """The reason why a robot's numbers were not compared."""


def reference(urdf, floating, count):
    """The robot, its states and its golden values; without forward dynamics if M is singular."""
    robot = Robot.from_urdf(urdf, floating)
    if robot.nv == 0:
        raise Unsupported("nothing moves")
    rng = np.random.default_rng(zlib.crc32(f"{urdf.stem} {floating}".encode()))
    states = [robot.random_state(rng) for _ in range(count)]
    values = [robot.dynamics(*(state[key] for key in ("q", "v", "a", "tau"))) for state in states]
    for value in values:
        if not np.linalg.cond(value["mass_matrix"]) < 1e14 or not np.all(np.isfinite(value["forward_dynamics"])):
            value["forward_dynamics"] = None
    return robot, states, values


def spoken(command, *arguments, given=None):
    """The command's output; if it fails, the first error line is the reason."""
    try:
        run = subprocess.run(
            [command, *arguments], input=given, capture_output=True, text=True, timeout=120, check=False
        )
    except subprocess.TimeoutExpired:
        raise NotCompared(f"{arguments[0]}: no answer within 120 s") from None
    if run.returncode != 0 and not run.stdout.startswith("{"):
        complaint = [line.strip() for line in run.stderr.splitlines() if line.strip()] or ["no message"]
        raise NotCompared(f"{arguments[0]}: {complaint[0]}")
    return run.stdout


def orders(robot, inspected):
    """For each entry of the command's q and v, the index of the same number in the reference's."""
    ours = {joint["name"]: joint for joint in inspected["joints"] if joint["nv"] > 0}
    theirs = {joint["name"]: joint for joint in robot.layout()}
    if set(ours) != set(theirs):
        missing, more = sorted(set(theirs) - set(ours)), sorted(set(ours) - set(theirs))
        raise NotCompared(f"joints differ: without {missing[:3]}, with {more[:3]} in addition")
    result = []
    for index, size in (("q_index", "nq"), ("v_index", "nv")):
        order = np.full(sum(joint[size] for joint in ours.values()), -1)
        for name, joint in ours.items():
            if joint[size] != theirs[name][size]:
                raise NotCompared(f"joint {name} has {size} = {joint[size]}, not {theirs[name][size]}")
            order[joint[index] : joint[index] + joint[size]] = theirs[name][index] + np.arange(joint[size])
        if np.any(order < 0):
            raise NotCompared(f"the joints' {index} leave gaps")
        result.append(order)
    return result


def compare(command, urdf, robot, states, values, extra=()):
    """{quantity: (worst difference, its bound)}."""
    base = [*extra, *(["--floating-base"] if robot.floating else [])]
    inspected = json.loads(spoken(command, "inspect", str(urdf), "--json", *base))
    by_q, by_v = orders(robot, inspected)
    lines = []
    for state, value in zip(states, values):
        # If M is singular, the forward dynamics is not requested.
        keys = ("q", "v", "a") if value["forward_dynamics"] is None else ("q", "v", "a", "tau")
        lines.append(json.dumps({key: plain(state[key][by_q if key == "q" else by_v]) for key in keys}))
    printed = spoken(command, "compute", str(urdf), *base, given="\n".join(lines) + "\n").splitlines()
    if len(printed) != len(states):
        raise NotCompared(f"compute: {len(printed)} lines for {len(states)} states")
    got = [json.loads(line) for line in printed]
    for line in got:
        if "error" in line:
            raise NotCompared(f"compute: {line['error']}")
    fixed = robot.fixed_body()
    whole = robot.moving_mass() + (fixed["mass"] if fixed else 0.0)
    height = 0.0
    if fixed:
        # Whether links fixed to the world count in V is a choice of its zero, the same for all states.
        offset = got[0]["potential_energy"] - values[0]["potential_energy"]
        height = min(0.0, 9.81 * fixed["mass"] * fixed["center_of_mass"][2], key=lambda h: abs(offset - h))
    mass = min(whole, robot.moving_mass(), key=lambda m: abs(m - inspected["mass"]))
    worst = {"m": (abs(inspected["mass"] - mass) / mass, ROUNDING)}
    for key, short in QUANTITIES.items():
        worst[short] = (difference(key, robot, states, values, got, by_v, height), ROUNDING)
    solved = [i for i, value in enumerate(values) if value["forward_dynamics"] is not None]
    if solved:
        # The state with the largest ratio to 10 cond(M) eps.
        key = "forward_dynamics"
        pairs = [(relative(got[i][key], values[i][key][by_v]), bound(values[i])) for i in solved]
        worst["a"] = max(pairs, key=lambda pair: pair[0] / pair[1])
    return worst


def bound(value):
    """10 cond(M) eps."""
    return 10 * np.linalg.cond(value["mass_matrix"]) * np.finfo(float).eps


def difference(key, robot, states, values, got, by_v, height):
    """The largest difference over the states, relative to the largest number over the states."""
    differences, scale = [0.0], 0.0
    for state, value, printed in zip(states, values, got):
        want, have = value[key], np.array(printed[key], dtype=float)
        if key == "potential_energy":
            want = want + height
        elif key == "coriolis_matrix" and robot.floating:
            # A floating base's C is not unique, but C v is.
            want, have = (want @ state["v"])[by_v], have @ state["v"][by_v]
        elif np.ndim(want) == 2:
            want = want[np.ix_(by_v, by_v)]
        elif np.ndim(want) == 1:
            want = want[by_v]
        if np.shape(have) != np.shape(want):
            raise NotCompared(f"{key}: shape {np.shape(have)}, not {np.shape(want)}")
        differences.append(np.max(np.abs(have - want), initial=0))
        scale = max(scale, np.max(np.abs(want), initial=0))
        if key in ("gravity", "coriolis_matrix", "bias", "potential_energy"):
            # These may vanish (an arm in a horizontal plane); the scale is then 1e-3 of the whole torque.
            scale = max(scale, 1e-3 * np.max(np.abs(value["inverse_dynamics"]), initial=0))
    worst = max(differences) if np.all(np.isfinite(differences)) else np.inf
    return worst / scale if scale else worst


def relative(have, want):
    """The largest difference relative to the largest number; infinite if the command has no number."""
    if have is None or np.shape(have) != np.shape(want):
        return np.inf
    return np.max(np.abs(np.array(have, dtype=float) - want)) / np.max(np.abs(want))


def cell(pair):
    """A difference for the table, marked if it exceeds its bound."""
    return "M singular" if pair is None else f"{pair[0]:.0e}" + ("" if pair[0] <= pair[1] else "!")


def write(folder, states, values):
    """states.jsonl and golden.jsonl."""
    folder.mkdir(parents=True, exist_ok=True)
    for name, rows in (("states.jsonl", states), ("golden.jsonl", values)):
        (folder / name).write_text("".join(json.dumps(plain(row)) + "\n" for row in rows))


def main():
    """Compares all robots and prints the table."""
    parser = argparse.ArgumentParser(description=__doc__, formatter_class=argparse.RawDescriptionHelpFormatter)
    parser.add_argument("out", type=Path, help="folder for states, reference values and manifest.json")
    parser.add_argument("--command", type=Path, default=environment.ROOT / "target" / "release" / "dynamics")
    parser.add_argument("--states", type=int, default=5, help="states for each robot")
    parser.add_argument("--option", action="append", default=[], help="a further option for the command")
    parser.add_argument("--only", default="", help="only robot files whose path contains this")
    arguments = parser.parse_args()
    present = arguments.command.exists()
    if not present:
        print(f"no {arguments.command}: only the reference is written", file=sys.stderr)
    robots, manifest = environment.robots_folder(), []
    shorts = ["m", *QUANTITIES.values(), "a"]
    print("| robot | base | loaded | joints | dof | mass | " + " | ".join(shorts) + " |")
    print("|" + " --- |" * (6 + len(shorts)))
    counts = {"compared": 0, "agree": 0}
    for urdf in sorted(robots.rglob("*.urdf")):
        path = str(urdf.relative_to(robots))
        if arguments.only not in path:
            continue
        for floating in (False, True):
            base = "floating" if floating else "fixed"
            entry = {"urdf": str(urdf), "robot": path, "base": base}
            cells, facts = [""] * len(shorts), ["", "", ""]
            try:
                robot, states, values = reference(urdf, floating, arguments.states)
                folder = f"{path.split('/')[0]}-{urdf.stem}-{base}"
                write(arguments.out / folder, states, values)
                entry |= {"folder": folder, "nq": robot.nq, "nv": robot.nv, "joints": robot.layout()}
                fixed = robot.fixed_body()
                mass = robot.moving_mass() + (fixed["mass"] if fixed else 0.0)
                facts = [str(len(robot.names)), str(robot.nv), f"{mass:.3f}"]
                loaded = "reference only"
                if present:
                    worst = compare(str(arguments.command), urdf, robot, states, values, arguments.option)
                    over = [name for name, (gap, limit) in worst.items() if not gap <= limit]
                    cells = [cell(worst.get(name)) for name in shorts]
                    loaded = "yes" if not over else "OFF: " + " ".join(over)
                    counts["compared"] += 1
                    counts["agree"] += not over
                    entry["worst"] = {name: {"relative": gap, "bound": limit} for name, (gap, limit) in worst.items()}
            except Unsupported as reason:
                loaded = f"not in the reference: {reason}"
            except NotCompared as reason:
                loaded = f"no: {reason}"
            except ValueError as reason:
                loaded = f"Pinocchio refuses it: {str(reason).splitlines()[0]}".replace(str(robots) + "/", "")
            entry["loaded"] = loaded
            manifest.append(entry)
            print(f"| {path} | {base} | {loaded} | " + " | ".join([*facts, *cells]) + " |", flush=True)
    arguments.out.mkdir(parents=True, exist_ok=True)
    (arguments.out / "manifest.json").write_text(json.dumps(manifest, indent=1) + "\n")
    if present:
        tried = sum("folder" in entry for entry in manifest)
        print(f"\n{counts['agree']} of {tried} robots within the bounds; {tried - counts['compared']} not compared")
    sys.exit(1 if counts["agree"] < counts["compared"] else 0)


if __name__ == "__main__":
    main()
