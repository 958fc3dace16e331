#!/usr/bin/env python3
"""Converts every robot file of folders to the other format with the command `dynamics`, and writes the table
of docs/convert.md.

    python3 bench/robots/converted.py FOLDER [FOLDER ...] [--every 10] [--command target/release/dynamics] --records RECORDS.jsonl
    python3 bench/robots/converted.py --page docs/convert.md --records RECORDS.jsonl

It takes every EVERYth URDF file, and all MJCF files that are complete (with bodies). The command reads its
output back and compares M with the robot's at 3 poses; that error is recorded. MuJoCo loads each resulting
MJCF file, and M and the bias are compared as in `menagerie.py`. Each file is then converted back to its
original format.
"""

import argparse
import collections
import json
import re
import sys
import tempfile
import zlib
from pathlib import Path

HERE = Path(__file__).resolve().parent
sys.path.insert(0, str(HERE.parent / "golden"))
import environment  # noqa: E402

if __name__ == "__main__":
    environment.enter(HERE / "menagerie.txt")

import menagerie  # noqa: E402
import mujoco  # noqa: E402
import numpy as np  # noqa: E402

STATES = 3


def by_mujoco(command, path):
    """The largest error of M and bias of the file as the command and as MuJoCo read it."""
    model = mujoco.MjModel.from_xml_path(str(path))
    names = [name for name, *_ in menagerie.moving(model)]
    mine = json.loads(menagerie.spoken(command, "inspect", str(path), "--json"))
    if names != [joint["name"] for joint in mine["joints"] if joint["nv"] > 0]:
        raise menagerie.Differs("other joints")
    if model.nv == 0:
        return 0.0
    random = np.random.default_rng(zlib.crc32(path.name.encode()))
    states = [menagerie.random_state(model, random) for _ in range(STATES)]
    lines = "".join(json.dumps({"q": q.tolist(), "v": v.tolist()}) + "\n" for q, v in states)
    printed = menagerie.spoken(command, "compute", str(path), given=lines.encode()).splitlines()
    exact = menagerie.with_inertias(mujoco.MjModel.from_xml_path(str(path)), {link["name"]: link for link in mine["links"]})
    worst = 0.0
    for (q, v), line in zip(states, printed):
        own = json.loads(line)
        mass, bias = np.array(own["mass_matrix"]).reshape(model.nv, model.nv), np.array(own["bias"])
        theirs = menagerie.evaluated(exact, q, v)
        least = 1e-3 * np.max(np.abs(mass))
        worst = max(worst, menagerie.relative(mass, theirs[0]), menagerie.relative(bias, theirs[1], least))
    return worst


def converted(command, source, target):
    """The error of M that the command reports; raises Differs."""
    said = menagerie.spoken(command, "convert", str(source), str(target))
    found = re.search(r"M agrees to (\S+)", said)
    return float(found[1]) if found else 0.0


def record(command, path, name):
    """The result for a file; None if the command cannot read it, or it has no bodies."""
    is_urdf = path.suffix == ".urdf"
    try:
        menagerie.spoken(command, "inspect", str(path))
    except menagerie.Differs:
        return None
    result = {"file": name, "from": "URDF" if is_urdf else "MJCF"}
    with tempfile.TemporaryDirectory() as folder:
        there, back = (Path(folder) / ("robot" + ending) for ending in ((".xml", ".urdf") if is_urdf else (".urdf", ".xml")))
        try:
            result["M"] = converted(command, path, there)
            result["back"] = converted(command, there, back)
        except menagerie.Differs as reason:
            return result | {"refused": re.sub(r"\s+", " ", str(reason).replace(str(path), "FILE").replace(folder, "."))[-300:]}
        written = there if is_urdf else back
        try:
            result["mujoco"] = by_mujoco(command, written)
        except ValueError as reason:
            result["mujoco refuses"] = str(reason).splitlines()[0].replace(folder, ".")[:120]
        except menagerie.Differs as reason:
            result["mujoco differs"] = str(reason)[:200]
    return result


def table(records):
    """The page's lines."""
    lines = ["| | URDF to MJCF | MJCF to URDF |", "| --- | ---: | ---: |"]
    sides = [[one for one in records if one["from"] == side] for side in ("URDF", "MJCF")]
    done = [[one for one in side if "M" in one and "back" in one] for side in sides]

    def row(what, count):
        lines.append(f"| {what} | " + " | ".join(str(count(k)) for k in (0, 1)) + " |")

    row("files that are read", lambda k: len(sides[k]))
    row("converted, and back", lambda k: len(done[k]))
    row("refused", lambda k: sum("refused" in one for one in sides[k]))
    row("M the same to 1e-12, there and back", lambda k: sum(max(one["M"], one["back"]) <= 1e-12 for one in done[k]))
    row("largest difference of M", lambda k: f"{max((max(one['M'], one['back']) for one in done[k]), default=0):.0e}")
    row("MuJoCo loads the MJCF file", lambda k: sum("mujoco" in one for one in done[k]))
    row("of these M and bias are MuJoCo's to 1e-12", lambda k: sum(one.get("mujoco", 1) <= 1e-12 for one in done[k]))
    row("to 1e-9", lambda k: sum(one.get("mujoco", 1) <= 1e-9 for one in done[k]))
    row("MuJoCo refuses it", lambda k: sum("mujoco refuses" in one for one in done[k]))
    row("other joints than MuJoCo's", lambda k: sum("mujoco differs" in one for one in done[k]))
    for title, key in (("Refused", "refused"), ("Refused by MuJoCo", "mujoco refuses")):
        if not any(key in one for one in records):
            continue
        why = collections.Counter(re.sub(r"'[^']*'|\"[^\"]*\"|[0-9.]+", "…", one[key]) for one in records if key in one)
        lines += ["", f"## {title}", "", "| files | why |", "| ---: | --- |"]
        lines += [f"| {count} | {reason.replace('|', '/')} |" for reason, count in why.most_common()]
    return lines


HEAD = """# Converted robots

`bench/robots/converted.py` writes this page; do not edit it by hand. Published robot files, which are not
part of this repository, are converted by `dynamics convert` to the other format and back. The command reads
its output again and compares M at 3 poses. MuJoCo VERSION loads the MJCF file, and its M and bias are
compared with this program's on that file, with the inertias written into MuJoCo's model as
[docs/mjcf.md](mjcf.md) explains. MuJoCo refuses robots that move a link without mass or with impossible
moments; files with such links are converted nevertheless.

"""


def main():
    """Reads the arguments and converts."""
    parser = argparse.ArgumentParser(description=__doc__, formatter_class=argparse.RawDescriptionHelpFormatter)
    parser.add_argument("folders", nargs="*", type=Path)
    parser.add_argument("--every", type=int, default=10)
    parser.add_argument("--command", default="target/release/dynamics")
    parser.add_argument("--records", type=Path, required=True)
    parser.add_argument("--page", type=Path)
    arguments = parser.parse_args()
    if arguments.page:
        records = [json.loads(line) for line in arguments.records.read_text().splitlines()]
        arguments.page.write_text(HEAD.replace("VERSION", mujoco.__version__) + "\n".join(table(records)) + "\n")
        return
    records, seen = [], set()
    for folder in arguments.folders:
        chosen = sorted(folder.rglob("*.urdf"))[:: arguments.every] + sorted(folder.rglob("*.xml"))
        for path in chosen:
            key = tuple(path.parts[-2:])
            text = path.read_text(errors="replace")
            if key in seen or (path.suffix == ".xml" and not re.search(r"<mujoco[\s>]", text)) or "<body" not in text and path.suffix == ".xml":
                continue
            seen.add(key)
            one = record(arguments.command, path, str(path.relative_to(folder)))
            if one is not None:
                records.append(one)
                print(json.dumps(one), flush=True)
    arguments.records.write_text("".join(json.dumps(one) + "\n" for one in records))


if __name__ == "__main__":
    main()
