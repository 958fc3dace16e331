#!/usr/bin/env python3
"""Writes docs/faults.md: the results of Pinocchio, Drake, MuJoCo and this project for the files of
testdata/faults.

    python3 bench/robots/faults.py [--command target/release/dynamics] [--check]

--check writes nothing and ends with 1 if the page is out of date.
"""

import argparse
import json
import re
import subprocess
import sys
from pathlib import Path

HERE = Path(__file__).resolve().parent
sys.path.insert(0, str(HERE.parent / "golden"))
import environment  # noqa: E402

if __name__ == "__main__":
    environment.enter(HERE / "requirements.txt")

from servant import Servant  # noqa: E402

FAULTS = environment.ROOT / "testdata" / "faults"
PAGE = environment.ROOT / "docs" / "faults.md"
# A file's name is its fault. The files of FREED are read with a floating root.
FREED = ("joint_named_floating_base", "joint_named_root_joint", "root_floats")
GROUPS = {
    "Masses and inertias": """triangle triangle_by_rounding negative_moment negative_moment_by_rounding negative_mass
        zero_mass_with_inertia mass_without_inertia inertia_without_mass mass_without_value moment_missing
        second_inertial second_mass second_inertia massless_leaf massless_leaf_by_zeros point_mass_on_axis
        massless_between massless_fixed_leaf""",
    "Numbers": """mass_nan mass_infinite mass_overflows moment_nan origin_nan number_with_decimal_comma
        numbers_with_commas number_with_unit number_as_word number_empty number_with_space two_numbers_for_three
        four_numbers_for_three""",
    "Limits and friction": """limits_infinite limits_reversed limit_nan limit_missing limit_lower_only effort_missing
        effort_zero effort_negative second_limit limit_on_fixed limit_on_continuous damping_negative
        damping_on_fixed""",
    "Axes and origins": """axis_missing axis_not_unit axis_zero axis_zero_on_fixed axis_without_xyz second_axis
        second_origin""",
    "Names": """robot_without_name robot_with_empty_name link_without_name link_with_empty_name joint_without_name
        joint_with_empty_name two_links_of_one_name two_joints_of_one_name joint_named_as_link
        joint_named_floating_base joint_named_root_joint""",
    "The tree": """parent_unknown parent_world_missing child_unknown parent_missing second_parent joint_to_itself
        cycle cycle_beside_root two_parents two_roots no_links""",
    "Kinds of joints": """joint_type_unknown joint_type_missing joint_type_in_capitals root_floats floating_inside
        planar_about_x spherical""",
    "Mimic joints": """mimic_of_nothing mimic_of_itself mimic_ring mimic_of_fixed mimic_chain
        mimic_on_fixed""",
    "The text": """prefix_not_declared element_unknown attribute_unknown xacro_left doctype declaration_late
        tag_not_closed attribute_twice text_outside_the_robot two_robots empty another_format not_utf8
        latin1_declared byte_order_mark""",
}
HEAD = """# How faulty files are handled

Each file of `testdata/faults` is a small robot with one fault. `python3 bench/robots/faults.py` writes this
page (Pinocchio {pin}, Drake {drake}, MuJoCo {mujoco}). A test compares this project's column with the actual
results.

Apart from the fault, the robot is one hinge about y that turns an arm of 1 kg at a distance of 0.3 m, with
the moments 0.02, 0.01 and 0.015 kg·m². A correct result is M = 0.01 + 0.3² = 0.1 kg·m²; about x it would be
0.11, about z 0.015. If a program loads a file, the cell gives the result: M for one degree of freedom,
otherwise the number of degrees of freedom (nv).

Drake's root is welded to the world, as in the other programs, except where "root freed" is stated. Pinocchio
is asked for mimic joints (`mimic=True`), which it does not create by default. MuJoCo welds every root. "says
so" means a message on the terminal, which a program that calls the library may not show.

This project's cells begin with the most severe finding of its load report: **error** (refused), **warning**
(loaded as written, with a message), **note** (defaulted or ignored), or "nothing to say".

## Limits

Readers of all formats stay within these limits, so that a small file cannot fill the memory. An error names
the limit that a file exceeds, and the place.

| quantity | limit |
| --- | --- |
| text of all files of a robot | 64 MiB |
| elements in all files, and in the copies of `<replicate>` and `<attach>` | 1,000,000 |
| characters in all files, and in the names and attributes of copies | 134,217,728 |
| numbers in height fields, meshes that give an inertia, and poses | 50,000,000 |
| nested elements in a file | 200 in URDF, 500 in MJCF |
| attributes on an element | 200 |
| files that include or attach one another in a chain | 50 |
| size of a mesh file | 512 MiB |
| heights or pixels in the file of a height field | 16,777,216 |
| comparisons of corners to divide the polygons of an OBJ file | 1,000,000,000; the number grows with the square of the corners of a polygon |

An included or attached file, a mesh and a height field must be a regular file. A pipe or a device is refused.
"""


def words(stem):
    """A file's name as the description of its fault."""
    return stem.replace("_", " ") + (", root freed" if stem in FREED else "")


def short(text, most=110):
    """A message on one line for a table, without paths and source locations."""
    text = re.sub(r"\S*\.urdf(:\d+)?:?\s*", "", text.replace("\n", " "))
    text = re.sub(r"\s+at line \d+ in \S+", ". ", text)
    text = re.sub(r"From file: .* message:\s*", "", text)
    text = re.sub(r"Failure at \S+ in (\w+)\(\):", r"in \1:", text)
    text = re.sub(r",?\s*Element (name )?'[^']*', (id|line) \d+.*", "", text)
    text = re.sub(r"^(error|RuntimeError|ValueError|Error|XML Error|SystemExit)[:.]\s*", "", text.strip())
    text = re.sub(r"^(error|RuntimeError|ValueError|Error|XML Error)[:.]\s*", "", text.strip())
    text = " ".join(text.split()).replace("|", "\\|").rstrip(". ")
    return text if len(text) <= most else text[: most - 1].rstrip() + "…"


def taken(nv, mass_matrix):
    """The model that resulted from a file."""
    if nv == 0:
        return "nothing moves"
    return f"M = {mass_matrix[0][0]:.4g}" if nv == 1 else f"nv = {nv}"


def peer(answer):
    """A cell for another program."""
    if "died" in answer:
        return f"**ends the process** ({answer['died']})"
    said = " ".join([*answer.get("warned", []), answer.get("said", "")]).strip()
    if "refused" in answer:
        first = said.split(" at line ")[0] if "not contain a valid URDF model" in answer["refused"] else ""
        return f"refuses: {short(first or answer['refused'])}"
    what = taken(answer["nv"], answer["mass_matrix"])
    return f"{what}; says so: {short(said.split(' at line ')[0], 70)}" if said else what


def ours(command, path, freed):
    """This project's cell."""
    arguments = ["--floating-base"] if freed else []
    run = subprocess.run([command, "inspect", str(path), "--json", *arguments], capture_output=True, text=True, check=False)
    if run.returncode != 0:
        return f"**error**: {first_error(run.stderr, path)}"
    found = json.loads(run.stdout)
    nv = found["nv"]
    matrix = [[0.0]]
    if nv == 1:
        state = json.dumps({"q": [0.0], "v": [0.0]}) + "\n"
        shown = subprocess.run([command, "compute", str(path)], input=state, capture_output=True, text=True, check=False)
        matrix = json.loads(shown.stdout)["mass_matrix"]
    what = taken(nv, matrix)
    findings = [finding for finding in found["report"]["findings"] if finding["disposition"] != "Read"]
    for severity in ("warning", "note"):
        for finding in findings:
            if finding["severity"] == severity:
                return f"{what}; **{severity}**: {clause(finding['message'])}"
    return f"{what}; nothing to say"


def first_error(text, path):
    """The first error of a rejected file, without its place."""
    lines = [line.strip() for line in text.strip().splitlines()]
    heads = [line for line in lines if not re.search(r": \d+ errors$", line)]
    message = heads[0].removeprefix("error: ").replace(f"{path}: ", "")
    return clause(re.sub(r"^line \d+(, column \d+)?: ", "", message))


def clause(message):
    """A message without the advice after it."""
    return message.split("; ")[0].replace("|", "\\|").replace("<", "\\<")


def page(command):
    """The page's text."""
    listed = [stem for stems in GROUPS.values() for stem in stems.split()]
    present = sorted(path.stem for path in FAULTS.glob("*.urdf"))
    if sorted(listed) != present:
        sys.exit(f"the groups of faults.py and {FAULTS} differ: {sorted(set(listed) ^ set(present))}")
    servants = {name: Servant(f"{name}_side.py") for name in ("pinocchio", "drake", "mujoco")}
    pinned = environment.pinned(HERE / "requirements.txt")
    text = [HEAD.format(pin=pinned["pin"], drake=pinned["drake"], mujoco=pinned["mujoco"])]
    for group, stems in GROUPS.items():
        text += [f"## {group}\n", "| fault | Pinocchio | Drake | MuJoCo | this project |", "| --- " * 5 + "|"]
        for stem in stems.split():
            path, freed = FAULTS / f"{stem}.urdf", stem in FREED
            request = {"file": str(path), "floating": freed, "fixed": not freed, "own mimics": True}
            cells = [peer(servant.ask(request)) for servant in servants.values()]
            link = f"[{words(stem)}](../testdata/faults/{stem}.urdf)"
            text.append(f"| {link} | {' | '.join(cells)} | {ours(command, path, freed)} |")
        text.append("")
    for servant in servants.values():
        servant.stop()
    return "\n".join(text).rstrip() + "\n"


def main():
    """The command line."""
    parser = argparse.ArgumentParser(description=__doc__, formatter_class=argparse.RawDescriptionHelpFormatter)
    parser.add_argument("--command", type=Path, default=environment.ROOT / "target" / "release" / "dynamics")
    parser.add_argument("--out", type=Path, default=PAGE, help="the page")
    parser.add_argument("--check", action="store_true", help="compare with the page, write nothing")
    arguments = parser.parse_args()
    text = page(str(arguments.command))
    if arguments.check:
        if arguments.out.read_text(encoding="utf-8") != text:
            sys.exit(f"{arguments.out} is not what would be written")
        return
    arguments.out.write_text(text, encoding="utf-8")


if __name__ == "__main__":
    main()
