#!/usr/bin/env python3
"""Steps per second and energy per step of many robots on a GPU, by MuJoCo Warp and MJX.

    pip install mujoco mujoco-warp mujoco-mjx jax[cuda13] nvidia-ml-py
    python bench/learning/mjwarp.py FILE … [--out FOLDER] [--limit SECONDS]

The files are MJCF files with their ground. Every pair of a program and a file has a process of its own, so
that a failure stops no other. All processes first compile side by side, which fills the caches of both
programs. Then they run in turns. No new process starts after `--limit` seconds, and running ones are stopped.
"""

import argparse
import json
import os
import subprocess
import sys
import tempfile
import time
from pathlib import Path
from typing import Any

HERE = Path(__file__).resolve().parent
ROBOTS = HERE.parents[1] / "robots"


def command(options: argparse.Namespace, program: str, file: Path, *more: str) -> list[str]:
    """Command line of one process."""
    cones = ["--elliptic"] if options.elliptic else []
    return [sys.executable, str(HERE / "gpu_worlds.py"), program, str(file), *cones, *more]


def worlds_of(options: argparse.Namespace, program: str) -> list[int]:
    """Numbers of worlds: all for MuJoCo Warp, one for MJX, which compiles anew for each number."""
    return options.worlds if program == "mjwarp" else options.worlds[:1]


def compile_all(options: argparse.Namespace, pairs: list[tuple[str, Path]], end: float) -> None:
    """Fills the caches by processes that run at the same time."""
    running = []
    for program, file in pairs:
        count = str(worlds_of(options, program)[0])
        words = command(options, program, file, "--worlds", count, "--compile-only")
        log = (options.out / f"compile_{program}_{file.stem}.log").open("w")
        running.append((program, file, subprocess.Popen(words, stdout=log, stderr=subprocess.STDOUT)))
    for program, file, process in running:
        try:
            process.wait(timeout=max(1.0, end - time.monotonic()))
        except subprocess.TimeoutExpired:
            process.kill()
            print(f"{program} {file.name}: compilation stopped", flush=True)


def run_one(options: argparse.Namespace, program: str, file: Path, end: float) -> list[dict[str, Any]]:
    """The rows of one process."""
    counts = [str(count) for count in worlds_of(options, program)]
    words = command(options, program, file, "--seconds", str(options.seconds), "--worlds", *counts)
    left = end - time.monotonic()
    failure = {"program": program, "robot": file.name, "worlds": 0}
    if left < 5:
        return [{**failure, "failure": "no time left"}]
    log = options.out / f"run_{program}_{file.stem}.log"
    with log.open("w") as output:
        process = subprocess.Popen(words, stdout=output, stderr=subprocess.STDOUT)
        try:
            process.wait(timeout=left)
        except subprocess.TimeoutExpired:
            process.kill()
    lines = [line for line in log.read_text().splitlines() if line.startswith('{"program"')]
    rows = [json.loads(line) for line in lines]
    return rows if rows else [{**failure, "failure": f"no result; see {log.name}"}]


def line(row: dict[str, Any]) -> str:
    """A row of the table."""
    head = f"| {row['robot']} | {row['program']} | {row['worlds']} |"
    if "failure" in row:
        return f"{head} {row['failure']} | | | | |"
    rates, joules = row["steps_per_second"], row["joules_per_step"]
    spread = f"{row['median'] / 1e6:.2f} ({min(rates) / 1e6:.2f} to {max(rates) / 1e6:.2f})"
    energy = "" if joules is None else f"{1e6 * joules:.1f}"
    watts = "" if row["watts"] is None else f"{row['watts']:.0f}"
    return f"{head} {spread} | {energy} | {watts} | {row.get('contacts', '')} | {row['finite_worlds']} |"


def main() -> None:
    """Runs everything and prints the table last."""
    raw = argparse.RawDescriptionHelpFormatter
    parser = argparse.ArgumentParser(description=__doc__, formatter_class=raw)
    parser.add_argument("files", nargs="*", type=Path, default=[ROBOTS / "quadruped.xml"])
    parser.add_argument("--programs", nargs="+", default=["mjwarp", "mjx"])
    parser.add_argument("--worlds", type=int, nargs="+", default=[4096, 8192, 32768])
    parser.add_argument("--elliptic", action="store_true", help="elliptic friction cones, as in this library")
    parser.add_argument("--seconds", type=float, default=2.0, help="duration of each case")
    parser.add_argument("--limit", type=float, default=150.0, help="duration of everything [s]")
    parser.add_argument("--out", type=Path, help="folder for the logs and results.json")
    options = parser.parse_args()
    options.out = options.out or Path(tempfile.mkdtemp())
    options.out.mkdir(parents=True, exist_ok=True)
    os.environ.setdefault("JAX_COMPILATION_CACHE_DIR", str(options.out.parent / "jax_cache"))
    os.environ.setdefault("JAX_PERSISTENT_CACHE_MIN_COMPILE_TIME_SECS", "1")
    os.environ.setdefault("XLA_PYTHON_CLIENT_PREALLOCATE", "false")
    begin = time.monotonic()
    end = begin + options.limit
    pairs = [(program, file) for program in options.programs for file in options.files]
    compile_all(options, pairs, begin + 0.6 * options.limit)
    print(f"compiled after {time.monotonic() - begin:.0f} s", flush=True)
    rows = []
    for program, file in pairs:
        rows += run_one(options, program, file, end)
        (options.out / "results.json").write_text(json.dumps(rows))
    print("| robot | program | worlds | million steps/s | µJ per step | W | contacts | finite worlds |")
    print("| --- | --- | ---: | ---: | ---: | ---: | ---: | ---: |")
    for row in rows:
        print(line(row))


if __name__ == "__main__":
    main()
