"""Many states from Python: this package's batches and rollouts beside Pinocchio's pools and MuJoCo's batch
and rollout.

    pip install ./python pin mujoco
    python bench/peers/python_batches.py [ROBOT] [--states N] [--rounds N]

Each round runs every program once, so that other load affects all of them; ratios are within a round. Numbers
are compared before anything is timed. The output has medians, and the range of the ratios to this package
with the same number of threads. The speed-up by a second thread follows.
"""

import argparse
import statistics
import threading
import time
from collections.abc import Callable
from functools import partial
from pathlib import Path
from typing import Any

import numpy as np

import robot_dynamics as rd

ROBOTS = Path(__file__).parents[2] / "robots"
STEPS, STEP = 100, 1e-3
Ways = dict[str, Callable[[], Any]]


def main() -> None:
    parser = argparse.ArgumentParser(description=__doc__.splitlines()[0])
    parser.add_argument("robot", nargs="?", default="panda")
    parser.add_argument("--states", type=int, default=100_000)
    parser.add_argument("--rounds", type=int, default=7)
    options = parser.parse_args()
    path = str(ROBOTS / f"{options.robot}.urdf")
    robot = rd.load(path)
    count = options.states
    random = np.random.default_rng(1)
    q = robot.random_configuration(count, seed=1)
    v, a, tau = random.uniform(-1, 1, (3, count, robot.nv))
    few = count // 50
    runs: list[tuple[str, int, dict[int, Ways]]] = [
        ("inverse dynamics", count, {threads: inverse(robot, path, q, v, a, threads) for threads in (1, 2)}),
        ("forward dynamics", count, {threads: forward(robot, path, q, v, tau, threads) for threads in (1, 2)}),
        (
            f"one of {STEPS} steps",
            few * STEPS,
            {threads: rollouts(robot, path, q[:few], v[:few], threads) for threads in (1, 2)},
        ),
    ]
    print(f"{robot.name}: {count} states, {few} rollouts; median of {options.rounds} rounds")
    print("| | threads | ns each | time over this package's, of each round |\n| --- | ---: | ---: | ---: |")
    for name, size, by_threads in runs:
        times: dict[tuple[int, str], list[float]] = {(t, way): [] for t, ways in by_threads.items() for way in ways}
        for _ in range(options.rounds):
            for (threads, way), own in times.items():
                begun = time.perf_counter()
                by_threads[threads][way]()
                own.append((time.perf_counter() - begun) / size * 1e9)
        for (threads, way), own in times.items():
            ours = times[threads, "this package"]
            ratios = sorted(mine / theirs for mine, theirs in zip(own, ours, strict=True))
            spread = f"{statistics.median(ratios):.2f} ({ratios[0]:.2f} to {ratios[-1]:.2f})"
            print(f"| {name}, {way} | {threads} | {statistics.median(own):.0f} | {spread} |")
    two_threads(robot, q, v, tau, options.rounds)


def two_threads(robot: rd.Robot, q: Any, v: Any, tau: Any, rounds: int) -> None:
    """Two threads over one, beside two parallel calls of one thread on half of the states each, the machine's
    limit."""
    count = 4 * len(q)
    q, v, tau = (np.tile(x, (4, 1)) for x in (q, v, tau))
    out, few = np.zeros_like(v), count // 50
    steps: dict[str, Any] = {"steps": STEPS, "dt": STEP, "integrator": "semi-implicit-euler"}

    def forward(rows: slice, threads: int) -> None:
        robot.forward_dynamics(q[rows], v[rows], tau[rows], out=out[rows], threads=threads)

    def rollout(rows: slice, threads: int) -> None:
        robot.rollout(q[rows], v[rows], **steps, threads=threads)

    print("| two threads over one | the package's | two calls side by side |\n| --- | ---: | ---: |")
    for name, call, states in (("forward dynamics", forward, count), ("rollouts", rollout, few)):
        all_rows, near, far = slice(0, states), slice(0, states // 2), slice(states // 2, states)
        ways: Ways = {
            "one": partial(call, all_rows, 1),
            "two": partial(call, all_rows, 2),
            "by hand": partial(at_once, partial(call, near, 1), partial(call, far, 1)),
        }
        times: dict[str, list[float]] = {way: [] for way in ways}
        for _ in range(8 * rounds):
            for way, own in times.items():
                begun = time.perf_counter()
                ways[way]()
                own.append(time.perf_counter() - begun)
        cells = []
        for way in ("two", "by hand"):
            gains = sorted(one / both for one, both in zip(times["one"], times[way], strict=True))
            quartiles = gains[len(gains) // 4], gains[3 * len(gains) // 4]
            least = min(times["one"]) / min(times[way])
            cells.append(f"{statistics.median(gains):.2f} ({quartiles[0]:.2f} to {quartiles[1]:.2f}), least {least:.2f}")
        print(f"| {name}, {states} | {' | '.join(cells)} |")


def at_once(call: Callable[[], Any], other: Callable[[], Any]) -> None:
    """Both calls, each on a thread."""
    thread = threading.Thread(target=other)
    thread.start()
    call()
    thread.join()


def inverse(robot: rd.Robot, path: str, q: Any, v: Any, a: Any, threads: int) -> Ways:
    """Inverse dynamics by each program."""
    out = np.zeros_like(v)
    ours = robot.inverse_dynamics(q, v, a)
    ways: Ways = {"this package": lambda: robot.inverse_dynamics(q, v, a, out=out, threads=threads)}
    try:
        import pinocchio as pin
    except ImportError:
        return ways
    model = pin.buildModelFromUrdf(path)
    if hasattr(pin, "rneaInParallel"):
        pool = pin.ModelPool(model, threads)
        columns = [np.asfortranarray(x.T) for x in (q, v, a)]
        result = np.zeros_like(columns[1])
        pin.rneaInParallel(threads, pool, *columns, result)
        np.testing.assert_allclose(result.T, ours, atol=1e-9)
        ways["pin, rneaInParallel"] = lambda: pin.rneaInParallel(threads, pool, *columns, result)
    if threads == 1:
        data = model.createData()
        np.testing.assert_allclose(pin.rnea(model, data, q[0], v[0], a[0]), ours[0], atol=1e-9)

        def loop() -> None:
            for k in range(len(q)):
                out[k] = pin.rnea(model, data, q[k], v[k], a[k])

        ways["pin, a loop in Python"] = loop
    return ways


def forward(robot: rd.Robot, path: str, q: Any, v: Any, tau: Any, threads: int) -> Ways:
    """Forward dynamics by each program."""
    out = np.zeros_like(v)
    ours = robot.forward_dynamics(q, v, tau)
    ways: Ways = {"this package": lambda: robot.forward_dynamics(q, v, tau, out=out, threads=threads)}
    try:
        import pinocchio as pin
    except ImportError:
        pass
    else:
        model = pin.buildModelFromUrdf(path)
        pool = pin.ModelPool(model, threads)
        columns = [np.asfortranarray(x.T) for x in (q, v, tau)]
        result = np.zeros_like(columns[1])
        pin.abaInParallel(threads, pool, *columns, result)
        np.testing.assert_allclose(result.T, ours, rtol=1e-7, atol=1e-6)
        ways["pin, abaInParallel"] = lambda: pin.abaInParallel(threads, pool, *columns, result)
        if threads == 1:
            data = model.createData()

            def loop() -> None:
                for k in range(len(q)):
                    out[k] = pin.aba(model, data, q[k], v[k], tau[k])

            ways["pin, a loop in Python"] = loop
    scene = mujoco_model(path)
    if scene is not None:
        from mujoco.batch import Batch

        batch = Batch(scene, nsim=len(q), nthread=threads)
        batch.qpos, batch.qvel, batch.qfrc_applied = q, v, tau
        acceleration = batch.bind("qacc")
        batch.forward()
        if np.allclose(acceleration, ours, rtol=1e-6, atol=1e-5):
            ways["mujoco.batch, forward"] = batch.forward
        else:
            print("mujoco.batch: other accelerations (its reader changes the inertias): not timed")
    return ways


def rollouts(robot: rd.Robot, path: str, q: Any, v: Any, threads: int) -> Ways:
    """Motions without torques by each program, with semi-implicit Euler."""
    options: dict[str, Any] = {"steps": STEPS, "dt": STEP, "integrator": "semi-implicit-euler", "threads": threads}
    ours = robot.rollout(q, v, **options)
    ways: Ways = {"this package": lambda: robot.rollout(q, v, **options)}
    model = mujoco_model(path)
    if model is None:
        return ways
    import mujoco
    from mujoco import rollout
    from mujoco.batch import Batch

    model.opt.timestep = STEP
    # This package does not compute damping here either.
    model.opt.disableflags |= int(mujoco.mjtDisableBit.mjDSBL_DAMPER)
    start = np.hstack([np.zeros((len(q), 1)), q, v])
    data = [mujoco.MjData(model) for _ in range(threads)]
    nothing = np.zeros((len(q), STEPS, 0))
    kind = mujoco.mjtState.mjSTATE_FULLPHYSICS
    if mujoco.mj_stateSize(model, kind) != start.shape[1]:
        return ways
    with rollout.Rollout(nthread=threads) as pool:
        states, _ = pool.rollout(model, data, start, nothing)
    if not np.allclose(states[:, -1, 1 : 1 + robot.nq], ours.q, atol=1e-6):
        off = np.abs(states[:, -1, 1 : 1 + robot.nq] - ours.q).max()
        print(f"mujoco.rollout: ends elsewhere, by {off:.1e}: not timed")
        return ways
    kept = rollout.Rollout(nthread=threads)
    ways["mujoco.rollout, all states kept"] = lambda: kept.rollout(model, data, start, nothing)
    batch = Batch(model, nsim=len(q), nthread=threads)
    positions, velocities = batch.bind("qpos"), batch.bind("qvel")

    def stepped() -> None:
        positions[:], velocities[:] = q, v
        batch.step(nstep=STEPS)

    stepped()
    np.testing.assert_allclose(positions, ours.q, atol=1e-6)
    ways["mujoco.batch, step"] = stepped
    ways["this package, all states kept"] = lambda: robot.rollout(q, v, stride=1, **options)
    return ways


def mujoco_model(path: str) -> Any:
    """MuJoCo's model without contacts and limits; None if it cannot read the file."""
    try:
        import mujoco

        model = mujoco.MjModel.from_xml_path(path)
    except (ImportError, ValueError) as error:
        print(f"mujoco: {error}")
        return None
    model.opt.disableflags |= int(mujoco.mjtDisableBit.mjDSBL_CONTACT | mujoco.mjtDisableBit.mjDSBL_CONSTRAINT)
    return model


if __name__ == "__main__":
    main()
