#!/usr/bin/env python3
"""Measures this library beside an earlier commit, and beside an equal build of the current one.

    python3 bench/peers/before.py 1ece70f

Prints the table of docs/performance.md: medians of the rounds' ratios after / before, with their quartiles.
"""

import argparse
import shutil
import statistics

import sides

if __name__ == "__main__":
    sides.enter()

from history import ROBOTS, built
from robots import Robot


def ratios(robot, algorithm, having, rounds):
    """[(after / before, equal build / after)] of each round."""
    found = []
    for index in range(rounds):
        order = [(index + shift) % len(having) for shift in range(len(having))]
        times = {place: having[place].time(robot, algorithm, 30)["median_ns"] for place in order}
        found.append((times[1] / times[0], times[2] / times[1]))
    return found


def main():
    """Builds, measures in turns, prints."""
    parser = argparse.ArgumentParser(description=__doc__, formatter_class=argparse.RawDescriptionHelpFormatter)
    parser.add_argument("commit")
    parser.add_argument("--rounds", type=int, default=15)
    arguments = parser.parse_args()
    before, after = built(arguments.commit), built("HEAD")
    twin = after.program.with_name("peer_side_twin")
    shutil.copy(after.program, twin)
    having = [before, after, sides.Ours("twin", twin, sides.ALGORITHMS, "", 1)]
    print("| |" + "".join(f" {robot} |" for robot in ROBOTS))
    print("| --- |" + " ---: |" * len(ROBOTS))
    robots = [Robot(name, sides.CACHE) for name in ROBOTS]
    for algorithm in sides.ALGORITHMS:
        cells = []
        for robot in robots:
            found = ratios(robot, algorithm, having, arguments.rounds)
            low, middle, high = statistics.quantiles([ratio for ratio, _ in found], n=4)
            equal = statistics.median(ratio for _, ratio in found)
            cells.append(f"{middle:.3f} ({low:.3f} to {high:.3f}), {equal:.3f}")
        print(f"| {algorithm} | " + " | ".join(cells) + " |", flush=True)


if __name__ == "__main__":
    main()
