"""Steps of one file's robot in many worlds on a GPU, by MuJoCo Warp or by MJX; a process of `mjwarp.py`."""

import argparse
import json
import statistics
import time
from collections.abc import Callable
from pathlib import Path
from typing import Any

import mujoco
import numpy as np
from energy import EnergyMeter
from starts import control_amplitudes, random_inputs, settled

STARTS, HOLD = 64, 10
Run = Callable[[int], None]
"""Runs a number of blocks of `HOLD` steps and waits for the end."""


def tiled(model: mujoco.MjModel, worlds: int) -> tuple[np.ndarray, np.ndarray, np.ndarray, np.ndarray]:
    """States and controls of all worlds, and the numbers (contacts, constraint rows) of the starts."""
    amplitudes = control_amplitudes(model)
    qpos, qvel, sizes = settled(model, "ctrl", amplitudes, STARTS)
    copies = -(-worlds // STARTS)
    controls = random_inputs(amplitudes, 8, worlds, 2)
    return np.tile(qpos, (copies, 1))[:worlds], np.tile(qvel, (copies, 1))[:worlds], controls, sizes


def mjwarp(model: mujoco.MjModel, worlds: int) -> tuple[Run, Callable[[], dict[str, Any]]]:
    """MuJoCo Warp: a captured graph of one step, as in its own benchmark."""
    import mujoco_warp as mjw
    import warp as wp

    wp.init()
    qpos, qvel, controls, sizes = tiled(model, worlds)
    contacts, rows = (int(1.5 * largest) + 8 for largest in sizes.max(axis=0))
    m = mjw.put_model(model)
    d = mjw.put_data(model, mujoco.MjData(model), nworld=worlds, nconmax=contacts, njmax=rows)
    wp.copy(d.qpos, wp.array(qpos, dtype=wp.float32))
    wp.copy(d.qvel, wp.array(qvel, dtype=wp.float32))
    inputs = [wp.array(row, dtype=wp.float32) for row in controls]
    mjw.step(m, d)  # compiles
    with wp.ScopedCapture() as capture:
        mjw.step(m, d)
    wp.synchronize()

    def run(blocks: int) -> None:
        for block in range(blocks):
            wp.copy(d.ctrl, inputs[block % len(inputs)])
            for _ in range(HOLD):
                wp.capture_launch(capture.graph)
        wp.synchronize()

    def facts() -> dict[str, Any]:
        finite = np.isfinite(d.qpos.numpy()).all(axis=1)
        return {
            "finite_worlds": int(finite.sum()),
            "contacts": float(d.nacon.numpy()[0]) / worlds,
            "most_rows": int(d.nefc.numpy().max()),
            "room_for_rows": rows,
            "solver_iterations": float(d.solver_niter.numpy().mean()),
        }

    return run, facts


def mjx(model: mujoco.MjModel, worlds: int) -> tuple[Run, Callable[[], dict[str, Any]]]:
    """MJX: one compiled scan over the steps of all worlds."""
    import jax
    from mujoco import mjx as library

    qpos, qvel, controls, _ = tiled(model, worlds)
    m = library.put_model(model)

    @jax.vmap
    def start(q: Any, v: Any) -> Any:
        return library.make_data(model).replace(qpos=q, qvel=v)

    @jax.jit
    def block(data: Any, control: Any) -> Any:
        data = data.replace(ctrl=control)
        step = jax.vmap(library.step, in_axes=(None, 0))
        return jax.lax.scan(lambda one, _: (step(m, one), None), data, length=HOLD)[0]

    state = {"data": jax.jit(start)(jax.numpy.asarray(qpos), jax.numpy.asarray(qvel))}
    inputs = [jax.numpy.asarray(row) for row in controls]

    def run(blocks: int) -> None:
        for number in range(blocks):
            state["data"] = block(state["data"], inputs[number % len(inputs)])
        state["data"].qpos.block_until_ready()

    def facts() -> dict[str, Any]:
        return {"finite_worlds": int(np.isfinite(np.asarray(state["data"].qpos)).all(axis=1).sum())}

    run(1)  # compiles
    return run, facts


PROGRAMS = {"mjwarp": mjwarp, "mjx": mjx}


def measure(run: Run, worlds: int, seconds: float, rounds: int) -> dict[str, Any]:
    """Steps per second of each round, and the energy of one step [J]."""
    run(2)
    begin = time.perf_counter()
    run(2)
    blocks = max(1, round(seconds / rounds * 2 / (time.perf_counter() - begin)))
    rates = []
    with EnergyMeter() as meter:
        for _ in range(rounds):
            begin = time.perf_counter()
            run(blocks)
            rates.append(blocks * HOLD * worlds / (time.perf_counter() - begin))
    total = rounds * blocks * HOLD * worlds
    joules = None if meter.joules is None else meter.joules / total
    energy = {"joules_per_step": joules, "energy_source": meter.source, "watts": meter.watts}
    return {"steps_per_second": rates, "median": statistics.median(rates), **energy}


def main() -> None:
    """Prints one line of JSON for each number of worlds."""
    parser = argparse.ArgumentParser(description=__doc__)
    parser.add_argument("program", choices=PROGRAMS)
    parser.add_argument("file", type=Path)
    parser.add_argument("--worlds", type=int, nargs="+", required=True)
    parser.add_argument("--seconds", type=float, default=2.0)
    parser.add_argument("--rounds", type=int, default=5)
    parser.add_argument("--elliptic", action="store_true")
    parser.add_argument("--compile-only", action="store_true")
    options = parser.parse_args()
    model = mujoco.MjModel.from_xml_path(str(options.file))
    if options.elliptic:
        model.opt.cone = mujoco.mjtCone.mjCONE_ELLIPTIC
    for worlds in options.worlds:
        row = {"program": options.program, "robot": options.file.name, "worlds": worlds}
        try:
            begin = time.perf_counter()
            run, facts = PROGRAMS[options.program](model, worlds)
            row["compile_seconds"] = time.perf_counter() - begin
            if not options.compile_only:
                row |= measure(run, worlds, options.seconds, options.rounds) | facts()
        except Exception as error:  # the other cases still run
            row["failure"] = f"{type(error).__name__}: {error}".splitlines()[0][:200]
        print(json.dumps(row), flush=True)


if __name__ == "__main__":
    main()
