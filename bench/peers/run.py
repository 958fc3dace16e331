#!/usr/bin/env python3
"""Measures this project beside its peers: the same robots, the same random states, in turns.

    python3 bench/peers/run.py                       all robots; about 5 minutes once built
    python3 bench/peers/run.py --quick               under 3 minutes once built
    python3 bench/peers/run.py --robot panda talos   only these

bench/README.md describes measurements and noise.
"""

import argparse
import json
import os
import platform
import statistics
import subprocess
from pathlib import Path

import sides

if __name__ == "__main__":
    sides.enter()

from agreement import check, condition_numbers
from robots import ROBOTS, STATES, Robot


def measure(robot, having, algorithm, rounds, milliseconds):
    """{side: [(median_ns, min_ns) of each round]}; the order of the programs rotates from round to round."""
    times = {side.name: [] for side in having}
    for index in range(rounds):
        shift = index % len(having)
        for side in having[shift:] + having[:shift]:
            result = side.time(robot, algorithm, milliseconds)
            times[side.name].append((result["median_ns"], result["min_ns"]))
    return times


def records(robot, algorithm, times, peer_sides):
    """One record for each peer."""
    mine = times.get("ours")
    for side in peer_sides:
        if side.name not in times:
            continue
        peer = times[side.name]
        record = {"robot": robot.name, "algorithm": algorithm, "ours_ns": None, "peer": side.name}
        record["peer_ns"] = round(statistics.median(x for x, _ in peer), 1)
        record |= {"ratio": None, "spread": None, "ours_min_ns": None}
        record["peer_min_ns"] = round(min(x for _, x in peer), 1)
        if mine:
            ratios = [theirs / ours for (ours, _), (theirs, _) in zip(mine, peer)]
            record["ours_ns"] = round(statistics.median(x for x, _ in mine), 1)
            record["ours_min_ns"] = round(min(x for _, x in mine), 1)
            record["ratio"] = round(statistics.median(ratios), 3)
            record["spread"] = [round(min(ratios), 3), round(max(ratios), 3)]
        yield record | {"rounds": len(peer), "spelled": side.spelled(robot, algorithm)}


def table(found, peer_sides):
    """The records as a table: ns of each program, and its ratio to this project's with the range."""
    print("\nns per call, median over the rounds; in brackets peer / ours, its median and its range over the rounds\n")
    print("| robot | algorithm | ours | " + " | ".join(side.name for side in peer_sides) + " |")
    print("|" + " --- |" * (3 + len(peer_sides)))
    rows = {}
    for record in found:
        rows.setdefault((record["robot"], record["algorithm"]), {})[record["peer"]] = record
    for (robot, algorithm), by_peer in rows.items():
        ours = next(iter(by_peer.values()))["ours_ns"]
        cells = [robot, algorithm, "n/a" if ours is None else f"{ours:.0f}"]
        for side in peer_sides:
            record = by_peer.get(side.name)
            if record is None:
                cells.append("")
            elif record["ratio"] is None:
                cells.append(f"{record['peer_ns']:.0f}")
            else:
                low, high = record["spread"]
                cells.append(f"{record['peer_ns']:.0f} ({record['ratio']:.2f}; {low:.2f}-{high:.2f})")
        print("| " + " | ".join(cells) + " |")


def machine():
    """The machine and versions of the figures."""
    info = Path("/proc/cpuinfo").read_text().splitlines()
    processor = next((line.split(":")[1].strip() for line in info if line.startswith("model name")), "?")
    rustc = subprocess.run(["rustc", "--version"], capture_output=True, text=True, check=True).stdout.strip()
    clang = subprocess.run([sides.clang(), "--version"], capture_output=True, text=True, check=True).stdout
    return {
        "processor": processor,
        "cores": os.cpu_count(),
        "system": platform.platform(),
        "rustc": rustc,
        "clang": clang.splitlines()[0],
        "load": [round(x, 2) for x in os.getloadavg()],
        "states": STATES,
    }


def main():
    """Builds, checks, measures, prints."""
    parser = argparse.ArgumentParser(description=__doc__, formatter_class=argparse.RawDescriptionHelpFormatter)
    parser.add_argument("--quick", action="store_true", help="fewer rounds, shorter passes")
    parser.add_argument("--robot", nargs="+", choices=ROBOTS, default=list(ROBOTS), help="only these robots")
    parser.add_argument("--algorithm", nargs="+", choices=sides.ALGORITHMS, default=sides.ALGORITHMS)
    parser.add_argument("--rounds", type=int, help="how often every side has its turn")
    parser.add_argument("--json", type=Path, metavar="OUT", help="the JSON lines go to this file too")
    arguments = parser.parse_args()
    rounds = arguments.rounds or (5 if arguments.quick else 9)
    milliseconds = 40 if arguments.quick else 200

    mine, peer_sides = sides.ours(), sides.peers()
    peer_sides.append(sides.one_thread(mine))
    print(json.dumps({"machine": machine()}))
    for side in [mine, *peer_sides]:
        print(f"{side.name}: {side.note}")
    found = []
    for name in arguments.robot:
        robot = Robot(name, sides.CACHE)
        condition = condition_numbers(robot, mine)
        worst = {}
        for algorithm in arguments.algorithm:
            for side, gap in check(robot, [mine, *peer_sides], algorithm, condition).items():
                key = f"{side} beside f32" if "_batch_f32" in algorithm else side
                worst[key] = max(gap, worst.get(key, 0.0))
        print(
            f"{name}: all agree on {len(robot.states)} states; worst relative difference "
            + ", ".join(f"{side} {gap:.0e}" for side, gap in worst.items()),
            flush=True,
        )
        for algorithm in arguments.algorithm:
            for side in peer_sides:
                has_it = algorithm in side.algorithms
                if has_it and isinstance(side, sides.Pinocchio) and side.has_choice(robot, algorithm):
                    side.choose(robot, algorithm, milliseconds / 2)
            having = [side for side in [mine, *peer_sides] if algorithm in side.algorithms]
            times = measure(robot, having, algorithm, rounds, milliseconds)
            found += records(robot, algorithm, times, peer_sides)
    lines = "".join(json.dumps(record) + "\n" for record in found)
    table(found, peer_sides)
    print("\n" + lines, end="")
    print(json.dumps({"load at the end": [round(x, 2) for x in os.getloadavg()]}))
    if arguments.json:
        arguments.json.write_text(json.dumps({"machine": machine()}) + "\n" + lines)


if __name__ == "__main__":
    main()
