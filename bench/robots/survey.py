#!/usr/bin/env python3
"""Compares the command `dynamics` with Pinocchio on every URDF file of a folder.

    python3 bench/robots/survey.py FOLDER RECORDS.jsonl [--command target/release/dynamics] [--states 3] [--jobs 2]
    python3 bench/robots/survey.py --summary RECORDS.jsonl docs/robots.md [--manifest MANIFEST.tsv]

Each file is tried with its root fixed to the world and floating, with one record per line. The exit code is 1
if a number differs by more than BOUND. bench/robots/README.md describes the comparison.
"""

import argparse
import json
import queue
import subprocess
import sys
import tempfile
import threading
from pathlib import Path
from xml.etree import ElementTree

HERE = Path(__file__).resolve().parent
sys.path.insert(0, str(HERE.parent / "golden"))
import environment  # noqa: E402

if __name__ == "__main__":
    environment.enter(HERE / "requirements.txt")

import numpy as np  # noqa: E402

from servant import Servant  # noqa: E402
from summary import write_summary  # noqa: E402
from written_out import armatures, written_out  # noqa: E402

# Bound of the errors relative to the row's size (see `errors`). A robot that is read differently differs by
# 1e-6 or more.
# The page counts files beyond 1e-12, the bound of this project's own tests.
BOUND = 1e-9
GRAVITY = 9.81


class NotCompared(Exception):
    """The reason why a file's numbers were not compared."""


class Refused(Exception):
    """The command's error for a file that it does not load."""


def spoken(command, *arguments, given=None):
    """The command's output."""
    try:
        run = subprocess.run([command, *arguments], input=given, capture_output=True, timeout=120, check=False)
    except subprocess.TimeoutExpired:
        raise NotCompared(f"{arguments[0]}: no answer within 120 s") from None
    printed, complaint = run.stdout.decode("utf-8", "replace"), run.stderr.decode("utf-8", "replace").strip()
    if run.returncode != 0 and not printed.startswith("{"):
        raise Refused(complaint or f"exit code {run.returncode}")
    return printed


def inspected(command, path, floating):
    """The output of `inspect --json`; raises Refused."""
    try:
        return json.loads(spoken(command, "inspect", str(path), "--json", *base(floating)))
    except json.JSONDecodeError as error:
        raise NotCompared(f"inspect: no JSON: {error}") from None


def base(floating):
    """The option that adds a floating base."""
    return ["--floating-base"] if floating else []


def orders(ours, theirs, floating):
    """For each entry of the command's q and v, the index of the same number in the reference's."""
    mine = {joint["name"]: joint for joint in ours if joint["nv"] > 0}
    other = {joint["name"]: joint for joint in theirs if joint["nv"] > 0}
    if floating:
        # The bases have names of the programs' own, and come first.
        for table in (mine, other):
            name = next((n for n, joint in table.items() if joint["q_index"] == 0 and joint["nq"] == 7), None)
            if name is None:
                raise NotCompared("no floating base")
            table[""] = table.pop(name)
    if set(mine) != set(other):
        missing, more = sorted(set(other) - set(mine)), sorted(set(mine) - set(other))
        raise NotCompared(f"joints differ: without {missing[:3]}, with {more[:3]} in addition")
    result = []
    for index, size in (("q_index", "nq"), ("v_index", "nv")):
        order = np.full(sum(joint[size] for joint in mine.values()), -1)
        for name, joint in mine.items():
            if joint[size] != other[name][size]:
                raise NotCompared(f"joint {name} has {size} = {joint[size]}, not {other[name][size]}")
            order[joint[index] : joint[index] + joint[size]] = other[name][index] + np.arange(joint[size])
        result.append(order)
    return result


def computed(command, path, floating, states, by_q, by_v):
    """The output of `compute` for the states."""
    lines = [json.dumps({"q": np.array(s["q"])[by_q].tolist(), "v": np.array(s["v"])[by_v].tolist()}) for s in states]
    printed = spoken(command, "compute", str(path), *base(floating), given="\n".join(lines).encode() + b"\n")
    got = [json.loads(line) for line in printed.splitlines()]
    if len(got) != len(states):
        raise NotCompared(f"compute: {len(got)} lines for {len(states)} states")
    for line in got:
        if "error" in line:
            raise NotCompared(f"compute: {line['error']}")
    return got


def errors(want, got, moved, by_v):
    """The largest errors of M, bias and gravity.

    Let s_i^2 be the largest inertia of the bodies that row i moves (see Robot.sizes of pinocchio_side.py),
    and m_i their mass. The error of M_ij is relative to s_i s_j. That of gravity is relative to its bound
    9.81 s_i sqrt(m_i). The scale of the bias is this bound plus s_i times the largest |C v|_j / s_j. It is at
    least s_i max s_j, the inertial force at 1 rad/s. A row with s_i below 1e-7 of the largest moves nothing.
    It contains the rounding of the other rows, so it counts as the largest.
    """
    mass, bias, gravity, size = (np.array(want[key], dtype=float) for key in (*KEYS, "size"))
    n = len(bias)
    mass = mass.reshape(n, n)[np.ix_(by_v, by_v)]
    bias, gravity, size, moved = bias[by_v], gravity[by_v], size[by_v], np.array(moved)[by_v]
    mine = [np.array(got[key], dtype=float).reshape(np.shape(x)) for key, x in zip(KEYS, (mass, bias, gravity))]
    if not np.max(size) > 0:
        raise NotCompared("M is zero: nothing that moves has mass")
    size = np.where(size < 1e-7 * np.max(size), np.max(size), size)
    weight = GRAVITY * size * np.sqrt(np.maximum(moved, 1e-16 * np.max(moved)))
    motion = weight + size * np.max(np.abs(bias - gravity) / size)
    # If only rotors have mass, nothing has weight; if a body is alike about all axes, C v is zero.
    motion, weight = np.maximum(motion, size * np.max(size)), np.maximum(weight, 1e-8 * size)
    scales = (np.outer(size, size), motion, weight)
    return [float(np.max(np.abs(a - b) / scale)) for a, b, scale in zip(mine, (mass, bias, gravity), scales)]


KEYS = ("mass_matrix", "bias", "gravity")


def compare(command, path, floating, reference, mine):
    """The largest errors over the states; raises NotCompared or Refused."""
    if "not compared" in reference:
        raise NotCompared(f"reference: {reference['not compared']}")
    by_q, by_v = orders(mine["joints"], reference["joints"], floating and not floats_already(mine, reference))
    if len(by_v) == 0:
        raise NotCompared("nothing moves")
    got = computed(command, path, floating, reference["states"], by_q, by_v)
    if not all(np.all(np.isfinite(value[key])) for value in reference["values"] for key in KEYS):
        raise NotCompared("reference: not finite")
    rows = [errors(want, have, reference["moved"], by_v) for want, have in zip(reference["values"], got)]
    return dict(zip(("M", "bias", "gravity"), np.max(rows, axis=0).tolist()))


def floats_already(mine, reference):
    """Whether the base of the command is a joint of the file, so that freeing the root changed nothing."""
    own = {joint["name"] for joint in reference.get("joints", [])}
    return any(joint["q_index"] == 0 and joint["nq"] == 7 and joint["name"] in own for joint in mine["joints"])


def attempt(command, path, floating, reference, mine):
    """The result of the comparison, as a part of the record."""
    if "refused" in reference or "died" in reference:
        return {}
    try:
        worst = compare(command, path, floating, reference, mine)
    except NotCompared as reason:
        return {"why": str(reason)}
    except Refused as reason:
        return {"why": f"compute: {reason}"}
    return {"worst": worst, "agrees": max(worst.values()) <= BOUND}


def warnings(mine):
    """The warnings of the load report."""
    findings = mine["report"].get("findings", [])
    return [finding["message"] for finding in findings if finding.get("severity") == "warning"]


def record(command, servants, folder, path, floating, states):
    """The record of one file and base."""
    name = str(path.relative_to(folder))
    request = {"file": str(path), "floating": floating, "states": states, "seed": f"{name} {floating}"}
    reference = servants["pinocchio"].ask(request)
    result = {"file": name, "base": "floating" if floating else "fixed"}
    for word in ("refused", "died"):
        if word in reference:
            # The first error is the cause; later ones are its consequences.
            said = next((line.strip() for line in reference.get("said", "").splitlines() if line.strip()), "")
            result["pinocchio"] = {word: reference[word].replace(str(path), "FILE")[:300], "said": said}
    if not floating:
        for other in ("drake", "mujoco"):
            theirs = servants[other].ask({"file": str(path)})
            result[other] = {key: theirs[key] for key in ("refused", "died", "nv", "mass") if key in theirs}
            if "refused" in theirs:
                result[other]["refused"] = theirs["refused"].replace(str(path), "FILE")[:400]
    try:
        mine = inspected(command, path, floating)
    except Refused as reason:
        return result | {"ours": {"refused": str(reason).replace(str(path), "FILE")}}
    except NotCompared as reason:
        return result | {"ours": {"died": str(reason)}}
    result["ours"] = {"nv": mine["nv"], "mass": mine["mass"], "floats": mine["floating_base"]}
    result["ours"]["warnings"] = warnings(mine)[:50]
    if floating and floats_already(mine, reference):
        # Pinocchio adds a second floating joint below the file's own; without it the robots are the same.
        reference = servants["pinocchio"].ask(request | {"floating": False})
        request["floating"], result["floats already"] = False, True
    direct = attempt(command, path, floating, reference, mine)
    result |= direct
    if direct.get("agrees") or direct.get("why") in ("nothing moves",):
        return result
    try:
        data = path.read_bytes()
        text, changes = written_out(data)
        rotors = armatures(data)
        if rotors:
            changes.append("the rotor inertia `armature` is in M")
    except (ElementTree.ParseError, ValueError) as error:
        return result | {"written": {"why": f"not written out: {error}"}}
    with tempfile.NamedTemporaryFile("w", suffix=".urdf", encoding="utf-8") as copy:
        copy.write(text)
        copy.flush()
        reference = servants["pinocchio"].ask(request | {"file": copy.name, "armature": rotors})
        written = attempt(command, path, floating, reference, mine)
    for word in ("refused", "died"):
        if word in reference:
            written["why"] = f"Pinocchio: {word}: {reference[word]} {reference.get('said', '')}"[:400]
    return result | {"written": written | {"changes": changes}}


def work(tasks, done, arguments, folder):
    """One thread with its own helper processes."""
    servants = {name: Servant(f"{name}_side.py") for name in ("pinocchio", "drake", "mujoco")}
    while True:
        try:
            path, floating = tasks.get_nowait()
        except queue.Empty:
            break
        try:
            done(record(str(arguments.command), servants, folder, path, floating, arguments.states))
        except Exception as error:  # noqa: BLE001: one file must not end the survey
            failure = {"file": str(path.relative_to(folder)), "base": "floating" if floating else "fixed"}
            done(failure | {"survey failed": f"{type(error).__name__}: {error}"})
    for servant in servants.values():
        servant.stop()


def survey(arguments):
    """Compares all files. Returns the number of files that differ."""
    folder = arguments.folder.resolve()
    tasks = queue.Queue()
    for path in sorted(path for path in folder.rglob("*") if path.suffix.lower() == ".urdf" and path.is_file()):
        if arguments.only in str(path):
            tasks.put((path, False))
            tasks.put((path, True))
    lock, off, total = threading.Lock(), [], tasks.qsize()
    with open(arguments.records, "w", encoding="utf-8") as out:

        def done(entry):
            with lock:
                out.write(json.dumps(entry, ensure_ascii=False) + "\n")
                out.flush()
                final = entry.get("written", entry) if not entry.get("agrees") else entry
                if final.get("agrees") is False or "survey failed" in entry:
                    off.append(entry["file"])
                    print(f"{entry['base']:8} {entry['file']}: {final.get('worst', entry)}", flush=True)

        threads = [threading.Thread(target=work, args=(tasks, done, arguments, folder)) for _ in range(arguments.jobs)]
        for thread in threads:
            thread.start()
        for thread in threads:
            thread.join()
    print(f"{total} tries, {len(off)} differ")
    return len(off)


def main():
    """The command line."""
    parser = argparse.ArgumentParser(description=__doc__, formatter_class=argparse.RawDescriptionHelpFormatter)
    parser.add_argument("folder", type=Path, help="folder of URDF files, searched through; with --summary: the records")
    parser.add_argument("records", type=Path, help="file for the records, one a line; with --summary: the page to write")
    parser.add_argument("--command", type=Path, default=environment.ROOT / "target" / "release" / "dynamics")
    parser.add_argument("--states", type=int, default=3, help="random states for each file and base")
    parser.add_argument("--jobs", type=int, default=2, help="files at a time")
    parser.add_argument("--only", default="", help="only files whose path contains this")
    parser.add_argument("--summary", action="store_true", help="write the page from the records, try nothing")
    parser.add_argument("--manifest", type=Path, help="what gather.py wrote: sources and versions for the page")
    arguments = parser.parse_args()
    if arguments.summary:
        write_summary(arguments.folder, arguments.records, arguments.manifest)
        return
    sys.exit(1 if survey(arguments) else 0)


if __name__ == "__main__":
    main()
