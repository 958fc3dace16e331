#!/usr/bin/env python3
"""WebAssembly in Node.js: a module with vector registers (simd128) beside one without.

    python3 bench/peers/wasm.py [--rounds 9] [--robot panda humanoid]

The modules run in turns, each first in every other round. Ratios are within a round. The table has their
median and range, and the smallest times of all rounds. `rustup target add wasm32-wasip1` is needed first.
"""

import argparse
import json
import os
import statistics
import subprocess
import sys
import tempfile
from pathlib import Path

ROOT = Path(__file__).resolve().parent.parent.parent
TARGET = "wasm32-wasip1"
BUILDS = {"plain": "", "simd128": "-C target-feature=+simd128"}


def build(folder):
    """Each build's module; cargo writes both to one path."""
    target = Path(os.environ.get("CARGO_TARGET_DIR", ROOT / "target"))
    for name, flags in BUILDS.items():
        command = ["cargo", "build", "--release", "--locked", "--target", TARGET, "-p", "bench", "--bin", "measure_scaling"]
        subprocess.run(command, check=True, cwd=ROOT, env=os.environ | {"RUSTFLAGS": flags})
        (folder / f"{name}.wasm").write_bytes((target / TARGET / "release" / "measure_scaling.wasm").read_bytes())


def measured(folder, name, robots):
    """Nanoseconds per state of each robot, algorithm, form and number, on the best registers of the
    module."""
    found = folder / "found.jsonl"
    command = ["node", "--no-warnings", str(ROOT / "xtask" / "wasi.mjs"), str(folder / f"{name}.wasm"), str(found)]
    subprocess.run([*command, *robots], check=True, stderr=subprocess.DEVNULL)
    records = [json.loads(line) for line in found.read_text().splitlines()]
    own = "portable" if name == "plain" else name
    keys = ("robot", "algorithm", "form", "number")
    return {tuple(r[k] for k in keys): r["ns"] for r in records if r.get("instructions") == own}


def main():
    """Builds, measures in turns, prints a table."""
    parser = argparse.ArgumentParser(description=__doc__, formatter_class=argparse.RawDescriptionHelpFormatter)
    parser.add_argument("--robot", nargs="+", default=["panda", "humanoid"])
    parser.add_argument("--rounds", type=int, default=9)
    arguments = parser.parse_args()
    with tempfile.TemporaryDirectory() as scratch:
        folder = Path(scratch)
        build(folder)
        rounds = []
        for i in range(arguments.rounds):
            order = list(BUILDS) if i % 2 == 0 else list(reversed(BUILDS))
            rounds.append({name: measured(folder, name, arguments.robot) for name in order})
            print(f"round {i + 1} of {arguments.rounds}", file=sys.stderr)
    print("| robot | algorithm | plain, ns | simd128, ns | ratio |\n| --- | --- | ---: | ---: | ---: |")
    for key in rounds[0]["plain"]:
        plain, registers = ([one[name][key] for one in rounds] for name in BUILDS)
        ratios = [a / b for a, b in zip(plain, registers)]
        robot, algorithm, form, number = key
        what = algorithm if form == "one state" else f"{algorithm}, batch {number}"
        spread = f"{statistics.median(ratios):.2f} ({min(ratios):.2f} to {max(ratios):.2f})"
        print(f"| {robot} | {what} | {min(plain):.0f} | {min(registers):.0f} | {spread} |")


if __name__ == "__main__":
    main()
