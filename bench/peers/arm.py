#!/usr/bin/env python3
"""Instructions per state on a 64-bit ARM, emulated: NEON against the portable code, which the compiler
vectorises too.

    python3 bench/peers/arm.py [--robot panda talos] [--algorithm mass_matrix]

Two runs of different length are counted; their difference is that of the calls.
"""

import argparse
import os
import subprocess
import sys

import sides

if __name__ == "__main__":
    sides.enter()

from robots import ROBOTS, Robot

TARGET = "aarch64-unknown-linux-musl"
# A batch has 1024 states; the numbers of calls of the two runs.
STATES = 1024


def build():
    """The program, statically linked by Rust's own linker."""
    subprocess.run(["rustup", "target", "add", TARGET], check=True)
    environment = os.environ | {"CARGO_TARGET_AARCH64_UNKNOWN_LINUX_MUSL_LINKER": "rust-lld"}
    command = ["cargo", "build", "--release", "--locked", "--target", TARGET, "-p", "bench", "--bin", "peer_side"]
    subprocess.run(command, check=True, env=environment, cwd=sides.ROOT)
    folder = os.environ.get("CARGO_TARGET_DIR", str(sides.ROOT / "target"))
    return f"{folder}/{TARGET}/release/peer_side"


def count(program, side, robot, algorithm, calls, portable):
    """Instructions of a whole run; the emulator logs each."""
    files = [str(robot.folder / side.robot_file), str(robot.folder / f"states.{side.convention}.bin")]
    command = ["qemu-aarch64", "-singlestep", "-d", "exec,nochain", "-D", "/dev/stdout", program, *files]
    command += [algorithm, "calls", str(calls)] + ["portable"] * portable
    with subprocess.Popen(command, stdout=subprocess.PIPE) as run:
        lines = 0
        while block := run.stdout.read(1 << 20):
            lines += block.count(b"\n")
    if run.returncode:
        sys.exit(f"{' '.join(command)} failed")
    return lines


def main():
    """Counts and prints a table."""
    parser = argparse.ArgumentParser(description=__doc__, formatter_class=argparse.RawDescriptionHelpFormatter)
    parser.add_argument("--robot", nargs="+", choices=ROBOTS, default=["panda", "talos"])
    parser.add_argument("--algorithm", nargs="+", default=[*sides.CORE, *sides.BATCHES])
    arguments = parser.parse_args()
    program, side = build(), sides.ours()
    print("| robot | algorithm | portable | NEON | ratio |\n|" + " --- |" * 5)
    for name in arguments.robot:
        robot = Robot(name, sides.CACHE)
        for algorithm in arguments.algorithm:
            few, many = (STATES, 2 * STATES) if "_batch_" in algorithm else (8, 24)
            found = []
            for portable in (True, False):
                ends = [count(program, side, robot, algorithm, calls, portable) for calls in (few, many)]
                found.append((ends[1] - ends[0]) / (many - few))
            print(f"| {name} | {algorithm} | {found[0]:.0f} | {found[1]:.0f} | {found[0] / found[1]:.2f} |", flush=True)


if __name__ == "__main__":
    main()
