#!/usr/bin/env python3
"""Drops published robots with floating bases onto the ground, and checks the ends of the runs.

    python3 bench/robots/ground.py FOLDER... [--robots 40] [--duration 10]

Invalid files and robots without usable collision shapes are left out; the files are chosen with a fixed seed.
Every tenth step is checked for a decrease of the losses by damping, friction, stops, sliding and impacts.
"""

import argparse
import csv
import random
import re
import subprocess
import tempfile
from pathlib import Path

COMMAND = Path(__file__).resolve().parents[2] / "target/release/dynamics"


def most_fall(table: Path) -> float:
    """The largest decrease of a loss between two rows [J]; 0 without a decrease."""
    with table.open(newline="") as rows:
        reader = csv.reader(rows)
        columns = [k for k, name in enumerate(next(reader)) if name.endswith("took out [J]")]
        before, fall = [0.0] * len(columns), 0.0
        for row in reader:
            now = [float(row[k]) for k in columns]
            fall = max([fall, *(a - b for a, b in zip(before, now, strict=True))])
            before = now
    return fall


def main() -> None:
    """Runs every file, and prints a line for each."""
    parser = argparse.ArgumentParser(description=__doc__)
    parser.add_argument("folders", type=Path, nargs="+")
    parser.add_argument("--robots", type=int, default=40)
    parser.add_argument("--duration", default="10")
    parser.add_argument("--command", type=Path, default=COMMAND)
    arguments = parser.parse_args()
    files = sorted(file for folder in arguments.folders for kind in ("*.urdf", "*.xml") for file in folder.rglob(kind))
    # One collection has a thousand bodies without a joint.
    files = [file for file in files if "random_urdfs" not in file.parts]
    random.Random(1).shuffle(files)
    whole, failed, falls, rested = [], [], [], 0
    folder = tempfile.TemporaryDirectory()
    table = Path(folder.name) / "run.csv"
    for file in files:
        if len(whole) + len(failed) == arguments.robots:
            break
        run = [arguments.command, "simulate", file, "--lock-massless", "--ground", "--duration", arguments.duration]
        run += ["--csv", table, "--sample-period", "0.01"]
        try:
            done = subprocess.run([*run, "--floating-base"], capture_output=True, text=True, timeout=900)
            if "floating" in done.stderr and done.returncode:
                done = subprocess.run(run, capture_output=True, text=True, timeout=900)
        except subprocess.TimeoutExpired:
            failed.append(file)
            print(f"{file}: not complete after 15 minutes", flush=True)
            continue
        books = re.search(r"residual, max.*: ([-+.e0-9]+)", done.stdout)
        depth = re.search(r"largest penetration after a step: ([-+.e0-9]+) m", done.stdout)
        gap = re.search(r"the lowest point is ([-+.e0-9]+) m (above|below)", done.stdout)
        speed = re.search(r"(at rest|fastest coordinate).* ([-+.e0-9]+) rad/s or m/s", done.stdout)
        rate = re.search(r"([0-9]+) steps/s", done.stdout)
        if done.returncode == 0 and books and depth and gap and rate:
            fall = most_fall(table)
            falls.append(fall)
            whole.append((float(books[1]), float(depth[1])))
            rested += bool(speed and speed[1] == "at rest")
            ends = f"{speed[1]} {speed[2]}" if speed else "in the air"
            print(f"{file}: energy residual {books[1]}, lowest point {gap[1]} m {gap[2]}, largest penetration {depth[1]} m, {ends}, {rate[1]} steps/s, losses fall by {fall:.0e} J", flush=True)
        elif "diverged" in done.stderr or "step failed" in done.stderr:
            failed.append(file)
            print(f"{file}: {done.stderr.strip().splitlines()[-1]}", flush=True)
    books = sorted(part for part, _ in whole)
    deepest = max(depth for _, depth in whole)
    print(f"{len(whole)} complete, {len(failed)} failed; {rested} at rest; largest penetration {deepest:.1e} m")
    print(f"losses fall by {max(falls):.0e} J at most")
    print(f"energy residual: median {books[len(books) // 2]:.1e}, largest {books[-1]:.1e}")


if __name__ == "__main__":
    main()
