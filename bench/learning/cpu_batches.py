#!/usr/bin/env python3
"""Steps per second of many robots on the ground: `SimulationBatch` beside MuJoCo's batch and rollout.

    pip install ./python mujoco
    python bench/learning/cpu_batches.py --humanoid humanoid.xml [--json FILE] [--quick]

`humanoid.xml` is the file `model/humanoid/humanoid.xml` of MuJoCo's repository. Both programs start from the
same states on the ground and get the same random controls, which are held over `--hold` steps. `mujoco` and
`rigid` are this library's two contact laws: MuJoCo's law, where the motions are compared with MuJoCo's, and
the default, rigid contact with Coulomb friction. The programs take turns in each round; ratios are within a
round. The rate per core divides the steps by the processor time of all threads. Other load affects it less.
"""

import argparse
import json
import os
import platform
import statistics
import time
from collections.abc import Callable
from pathlib import Path
from typing import Any, NamedTuple

import mujoco
import numpy as np
from mujoco import rollout
from mujoco.batch import Batch
from scenes import ROBOTS, Scene, scene
from starts import random_inputs, settled

import robot_dynamics as rd

LAWS = {"mujoco": "mujoco", "rigid": "implicit"}


class Way(NamedTuple):
    """One way to run the motions."""

    prepare: Callable[[], Any]
    """Sets the initial states, outside the timing."""
    run: Callable[[], Any]
    """All steps."""
    end: Callable[[], Any]
    """Final configurations (count, nq), in MuJoCo's convention."""


class Task(NamedTuple):
    """Motions of one scene."""

    scene: Scene
    qpos: np.ndarray
    qvel: np.ndarray
    inputs: np.ndarray
    """Inputs (holds, count, inputs), each held over `hold` steps."""
    hold: int


def ours(task: Task, law: str, threads: int) -> Way:
    """This library's batch."""
    scene, count = task.scene, len(task.qpos)
    batch = rd.SimulationBatch(scene.robot, count, integrator=LAWS[law], threads=threads, **scene.options)
    start = scene.robot.from_mujoco(task.qpos, task.qvel)

    def run() -> None:
        for row in task.inputs:
            setattr(batch, scene.inputs, row)
            batch.step(task.hold)

    def end() -> np.ndarray:
        return scene.robot.to_mujoco(batch.q).qpos

    return Way(lambda: batch.reset(start.q, start.v), run, end)


def mujoco_batch(task: Task, threads: int) -> Way:
    """MuJoCo's batch, one call for each control."""
    batch = Batch(task.scene.model, nsim=len(task.qpos), nthread=threads)
    qpos, qvel, field = (batch.bind(name) for name in ("qpos", "qvel", task.scene.field))

    def prepare() -> None:
        batch.reset()
        qpos[:], qvel[:] = task.qpos, task.qvel

    def run() -> None:
        for row in task.inputs:
            field[:] = row
            batch.step(nstep=task.hold)

    return Way(prepare, run, qpos.copy)


def mujoco_rollout(task: Task, threads: int) -> Way:
    """MuJoCo's rollout: one call with all controls, which returns the state after each step."""
    model, spec = task.scene.model, mujoco.mjtState
    count, kind = len(task.qpos), spec.mjSTATE_FULLPHYSICS.value
    pool = rollout.Rollout(nthread=threads)
    data = [mujoco.MjData(model) for _ in range(threads)]
    start = np.zeros((count, mujoco.mj_stateSize(model, kind)))
    start[:, 1 : 1 + model.nq + model.nv] = np.hstack([task.qpos, task.qvel])
    controls = np.repeat(task.inputs.swapaxes(0, 1), task.hold, axis=1).copy()
    inputs = spec.mjSTATE_CTRL if task.scene.field == "ctrl" else spec.mjSTATE_QFRC_APPLIED
    states = np.empty((count, controls.shape[1], start.shape[1]))
    sensors = np.empty((count, controls.shape[1], model.nsensordata))

    def run() -> None:
        outputs = {"state": states, "sensordata": sensors}
        pool.rollout([model] * count, data, start, controls, control_spec=inputs.value, **outputs)

    return Way(lambda: None, run, lambda: states[:, -1, 1 : 1 + model.nq].copy())


def task_of(scene: Scene, count: int, steps: int, hold: int) -> tuple[Task, float]:
    """Motions from states on the ground, and the mean number of contacts in these states."""
    qpos, qvel, sizes = settled(scene.model, scene.field, scene.amplitudes, count)
    inputs = random_inputs(scene.amplitudes, steps // hold, count, 2)
    return Task(scene, qpos, qvel, inputs, hold), float(sizes[:, 0].mean())


def agreement(scene: Scene, count: int) -> list[dict[str, Any]]:
    """Differences of the configurations from MuJoCo's under MuJoCo's law, after some steps."""
    rows = []
    for steps in (1, 10, 100):
        task, _ = task_of(scene, count, steps, 1)
        ends = []
        for way in (ours(task, "mujoco", 1), mujoco_batch(task, 1)):
            way.prepare()
            way.run()
            ends.append(way.end())
        apart = np.abs(ends[0] - ends[1]).max(axis=1)
        rows.append({"robot": scene.name, "steps": steps, "median": np.median(apart), "largest": apart.max()})
    return rows


def measure(scene: Scene, options: argparse.Namespace, threads: int, hold: int) -> list[dict[str, Any]]:
    """Steps per second of every way, which take turns in each round."""
    count = options.robots * threads
    task, contacts = task_of(scene, count, options.steps, hold)
    ways = {
        "mujoco.batch": mujoco_batch(task, threads),
        "mujoco.rollout": mujoco_rollout(task, threads),
        **{f"ours, {law}": ours(task, law, threads) for law in LAWS},
    }
    total = count * len(task.inputs) * hold
    rates: dict[str, list[float]] = {name: [] for name in ways}
    busy: dict[str, list[float]] = {name: [] for name in ways}
    failed: dict[str, str] = {}
    for number in range(options.rounds + 1):  # the first round is a warm-up
        for name, way in ways.items():
            if name in failed:
                continue
            try:
                way.prepare()
                begin, used = time.perf_counter(), time.process_time()
                way.run()
                rate, per_core = total / (time.perf_counter() - begin), total / (time.process_time() - used)
            except (rd.BadSimulationsError, RuntimeError) as error:
                failed[name] = str(error).splitlines()[0]
                continue
            if number > 0:
                rates[name].append(rate)
                busy[name].append(per_core)
    rows = []
    for name, own in rates.items():
        row = {"robot": scene.name, "threads": threads, "hold": hold, "way": name, "contacts": contacts}
        if name in failed:
            rows.append({**row, "failure": failed[name]})
            continue
        row |= {"steps_per_second": own, "steps_per_core_second": busy[name]}
        rows.append(row | {"ratios": ratios(rates, name), "ratios_per_core": ratios(busy, name)})
    return rows


def ratios(rates: dict[str, list[float]], name: str) -> list[float]:
    """Sorted ratios to MuJoCo's batch within each round."""
    return sorted(mine / theirs for mine, theirs in zip(rates[name], rates["mujoco.batch"], strict=True))


def line(row: dict[str, Any]) -> str:
    """A row of the table."""
    head = f"| {row['robot']} | {row['threads']} | {row['hold']} | {row['way']} |"
    if "failure" in row:
        return f"{head} {row['failure']} | | | |"
    rates, over = sorted(row["steps_per_second"]), row["ratios_per_core"]
    middle, spread = statistics.median(rates) / 1e3, f"{rates[0] / 1e3:.1f} to {rates[-1] / 1e3:.1f}"
    per_core = statistics.median(row["steps_per_core_second"]) / 1e3
    ratio = f"{statistics.median(over):.2f} ({over[0]:.2f} to {over[-1]:.2f})"
    wall = statistics.median(row["ratios"])
    return f"{head} {middle:.1f} ({spread}) | {per_core:.1f} | {wall:.2f} | {ratio} |"


def machine() -> dict[str, Any]:
    """The machine and the versions."""
    processor = platform.processor()
    info = Path("/proc/cpuinfo")
    if info.exists():
        names = [text for text in info.read_text().splitlines() if text.startswith("model name")]
        processor = names[0].split(":")[1].strip() if names else processor
    versions = {"python": platform.python_version(), "numpy": np.__version__, "mujoco": mujoco.__version__}
    cores = len(os.sched_getaffinity(0))
    return {"processor": processor, "cores": cores, "load": os.getloadavg()[0], **versions}


def arguments() -> argparse.Namespace:
    """The arguments of the command line."""
    raw = argparse.RawDescriptionHelpFormatter
    parser = argparse.ArgumentParser(description=__doc__, formatter_class=raw)
    parser.add_argument("files", nargs="*", type=Path, help="robot files; default: two of robots/")
    parser.add_argument("--humanoid", type=Path, help="MuJoCo's humanoid.xml")
    parser.add_argument("--threads", type=int, nargs="+", help="default: 1, 2, 4, ... and all cores")
    parser.add_argument("--hold", type=int, nargs="+", default=[1, 5], help="steps of one control")
    parser.add_argument("--robots", type=int, default=64, help="robots for each thread")
    parser.add_argument("--steps", type=int, default=100, help="steps of each robot")
    parser.add_argument("--rounds", type=int, default=5)
    parser.add_argument("--json", type=Path, help="file for all numbers")
    parser.add_argument("--quick", action="store_true", help="few steps and rounds, to try the script")
    options = parser.parse_args()
    if options.quick:
        options.robots, options.steps, options.rounds = 8, 20, 2
    if options.threads is None:
        cores = len(os.sched_getaffinity(0))
        options.threads = sorted({*(2**power for power in range(8) if 2**power < cores), cores})
    return options


def main() -> None:
    """Prints the tables and writes the numbers."""
    options = arguments()
    files = options.files or [ROBOTS / "quadruped.xml", ROBOTS / "quadruped.urdf"]
    if options.humanoid is not None:
        files = [options.humanoid, *files]
    scenes = [scene(path) for path in files]
    result: dict[str, Any] = {"machine": machine(), "agreement": [], "rates": []}
    print(result["machine"])
    print("\n| robot | steps | median difference from MuJoCo | largest |\n| --- | ---: | ---: | ---: |")
    for one in scenes:
        for row in agreement(one, 32):
            result["agreement"].append(row)
            numbers = f"{row['median']:.1e} | {row['largest']:.1e}"
            print(f"| {row['robot']} | {row['steps']} | {numbers} |", flush=True)
    columns = "1000 steps/s | per core | over mujoco.batch | the same per core"
    print(f"\n| robot | threads | hold | program | {columns} |")
    print("| --- | ---: | ---: | --- | ---: | ---: | ---: | ---: |")
    for one in scenes:
        for threads in options.threads:
            for hold in options.hold:
                for row in measure(one, options, threads, hold):
                    result["rates"].append(row)
                    print(line(row), flush=True)
        if options.json is not None:
            options.json.write_text(json.dumps(result, default=float))


if __name__ == "__main__":
    main()
