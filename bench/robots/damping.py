#!/usr/bin/env python3
"""Simulates published robots with the damping, friction and limits of their files, and counts motions that
diverge.

    python3 bench/robots/damping.py FOLDER [--integrator rk4 ...] [--robots 400] [--duration 2]

Invalid files and robots without joints are left out; the files are chosen with a fixed seed.
"""

import argparse
import random
import re
import subprocess
from pathlib import Path

COMMAND = Path(__file__).resolve().parents[2] / "target/release/dynamics"


def main() -> None:
    """Runs every file with every requested integrator."""
    parser = argparse.ArgumentParser(description=__doc__)
    parser.add_argument("folder", type=Path)
    parser.add_argument("--integrator", nargs="+", default=["implicit", "rk4"])
    parser.add_argument("--robots", type=int, default=400)
    parser.add_argument("--duration", default="2")
    parser.add_argument("--command", type=Path, default=COMMAND)
    arguments = parser.parse_args()
    files = sorted(arguments.folder.rglob("*.urdf"))
    # One collection has a thousand bodies without a joint.
    files = [file for file in files if "random_urdfs" not in file.parts]
    random.Random(1).shuffle(files)
    for integrator in arguments.integrator:
        ended: dict[str, int] = {"whole": 0, "diverged": 0, "no motion": 0}
        missed: list[tuple[float, Path]] = []
        for file in files[: arguments.robots]:
            run = [arguments.command, "simulate", file, "--lock-massless", "--integrator", integrator]
            done = subprocess.run([*run, "--duration", arguments.duration], capture_output=True, text=True, timeout=600)
            found = re.search(r"residual, max.*: ([-+.e0-9]+)", done.stdout)
            if done.returncode == 0 and found:
                ended["whole"] += 1
                missed.append((float(found[1]), file))
            elif "diverged" in done.stderr or "step failed" in done.stderr:
                ended["diverged"] += 1
                print(f"{integrator}: {file}: {done.stderr.strip().splitlines()[-1]}")
            else:
                ended["no motion"] += 1
        missed.sort(reverse=True)
        print(f"{integrator}: {ended}; energy residual, median {missed[len(missed) // 2][0]:.1e}")
        for part, file in missed[:5]:
            print(f"  {part:.1e} {file}")


if __name__ == "__main__":
    main()
