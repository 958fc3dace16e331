#!/usr/bin/env python3
"""Measures the gain of each optimisation: commits of this repository side by side on one machine.

    python3 bench/peers/history.py --json docs/performance/steps.jsonl

Each commit is built with the default profile. Commits run in turns on the robots and states of run.py.
"""

import argparse
import json
import shutil
import statistics
import subprocess
from pathlib import Path

import sides

if __name__ == "__main__":
    sides.enter()

from robots import Robot
from run import machine

# Commits and their descriptions.
STEPS = [
    ("f0839eb", "plain recursions"),
    ("08a1b17", "vector registers, own sine and cosine"),
    ("43a255b", "fewer instructions"),
    ("a50222a", "frames and Coriolis in registers"),
    ("HEAD", "today"),
]
MEASURED = [*sides.CORE, "coriolis_matrix", "frame_poses", "jacobian"]
ROBOTS = ["panda", "talos"]


def commit_of(name):
    """The commit's full name."""
    command = ["git", "rev-parse", f"{name}^{{commit}}"]
    return subprocess.run(command, cwd=sides.ROOT, capture_output=True, text=True, check=True).stdout.strip()


def built(name):
    """This project's program at a commit."""
    commit = commit_of(name)
    if name == "HEAD":
        return sides.Ours(commit[:7], sides.ours().program, MEASURED, "", 1)
    program = sides.CACHE / "bin" / f"ours-{commit[:12]}"
    if not program.exists():
        sides.say(f"building {name}")
        folder = sides.CACHE / "history" / commit[:12]
        shutil.rmtree(folder, ignore_errors=True)
        folder.mkdir(parents=True)
        archive = subprocess.run(["git", "archive", commit], cwd=sides.ROOT, capture_output=True, check=True)
        # With current file times (-m); otherwise the build would reuse an older commit's results.
        subprocess.run(["tar", "-xm"], cwd=folder, input=archive.stdout, check=True)
        arguments = ["-p", "bench", "--bin", "peer_side", "--locked"]
        release = sides.cargo(folder, arguments, sides.CACHE / "history" / "target")
        program.parent.mkdir(parents=True, exist_ok=True)
        shutil.copy(release / "peer_side", program)
        shutil.rmtree(folder)
    return sides.Ours(name, program, MEASURED, "", 1)


def main():
    """Builds, measures in turns, prints."""
    parser = argparse.ArgumentParser(description=__doc__, formatter_class=argparse.RawDescriptionHelpFormatter)
    parser.add_argument("--rounds", type=int, default=15)
    parser.add_argument("--json", type=Path, metavar="OUT", help="the JSON lines go to this file too")
    arguments = parser.parse_args()
    steps = [(built(name), what) for name, what in STEPS]
    lines = [json.dumps({"machine": machine()})]
    for name in ROBOTS:
        robot = Robot(name, sides.CACHE)
        for algorithm in MEASURED:
            found = {side.name: [] for side, _ in steps}
            for index in range(arguments.rounds):
                shift = index % len(steps)
                for side, _ in steps[shift:] + steps[:shift]:
                    found[side.name].append(side.time(robot, algorithm, 30))
            for side, what in steps:
                times = found[side.name]
                record = {"robot": name, "algorithm": algorithm, "commit": side.name, "step": what}
                record["ns"] = round(statistics.median(x["median_ns"] for x in times), 1)
                record["least_ns"] = round(min(x["min_ns"] for x in times), 1)
                lines.append(json.dumps(record | {"rounds": arguments.rounds}))
                print(lines[-1], flush=True)
    if arguments.json:
        arguments.json.parent.mkdir(parents=True, exist_ok=True)
        arguments.json.write_text("\n".join(lines) + "\n")


if __name__ == "__main__":
    main()
