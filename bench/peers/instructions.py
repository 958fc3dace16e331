#!/usr/bin/env python3
"""Instructions per call under valgrind, which are independent of the machine's load.

    python3 bench/peers/instructions.py [--robot panda talos] [--algorithm mass_matrix] [--peers]

Two runs of different length are counted; their difference is that of the calls.
"""

import argparse
import os
import re
import subprocess
import sys

import sides

if __name__ == "__main__":
    sides.enter()

from robots import ROBOTS, Robot

FEW, MANY = 1024, 3072
# Valgrind counts a `rep stosb` once for each byte, so the C library is told to fill and copy by vector
# instructions.
NO_REP = "glibc.cpu.x86_rep_stosb_threshold=1000000000:glibc.cpu.x86_rep_movsb_threshold=1000000000"


def count(side, robot, algorithm, calls):
    """Instructions of a whole run."""
    files = [str(robot.folder / side.robot_file), str(robot.folder / f"states.{side.convention}.bin")]
    valgrind = ["valgrind", "--tool=callgrind", "--callgrind-out-file=/dev/null"]
    command = [*valgrind, str(side.program), *files, side.spelled(robot, algorithm), "calls", str(calls)]
    environment = os.environ | {"GLIBC_TUNABLES": NO_REP}
    done = subprocess.run(command, capture_output=True, text=True, check=False, env=environment)
    found = re.search(r"Collected : (\d+)", done.stderr)
    if done.returncode != 0 or not found:
        sys.exit(f"{' '.join(command)}\n{done.stderr}")
    return int(found[1])


def main():
    """Counts and prints a table."""
    parser = argparse.ArgumentParser(description=__doc__, formatter_class=argparse.RawDescriptionHelpFormatter)
    parser.add_argument("--robot", nargs="+", choices=ROBOTS, default=["panda", "talos"])
    parser.add_argument("--algorithm", nargs="+", choices=sides.SINGLE, default=sides.CORE)
    parser.add_argument("--peers", action="store_true", help="the peers that valgrind can run, too")
    arguments = parser.parse_args()
    compared = [sides.ours()]
    if arguments.peers:
        compared += [side for side in sides.peers() if not side.name.endswith("native")]
    print("| robot | algorithm | " + " | ".join(side.name for side in compared) + " |")
    print("|" + " --- |" * (2 + len(compared)))
    for name in arguments.robot:
        robot = Robot(name, sides.CACHE)
        for algorithm in arguments.algorithm:
            cells = []
            for side in compared:
                if algorithm not in side.algorithms:
                    cells.append("")
                    continue
                more = count(side, robot, algorithm, MANY) - count(side, robot, algorithm, FEW)
                cells.append(f"{more / (MANY - FEW):.0f}")
            print(f"| {name} | {algorithm} | " + " | ".join(cells) + " |", flush=True)


if __name__ == "__main__":
    main()
