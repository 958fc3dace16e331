"""Threads, forks, signals, memory."""

import gc
import multiprocessing
import os
import sys
import threading
import time
from concurrent.futures import ThreadPoolExecutor
from typing import Any

import numpy as np
import pytest

import robot_dynamics as rd
from conftest import States, interrupted, states

HAS_FORK = hasattr(os, "fork")


def test_many_threads_share_one_robot(quadruped: rd.Robot) -> None:
    s = states(quadruped, 400)
    expected = quadruped.inverse_dynamics(s.q, s.v, s.a)
    singles = np.stack([quadruped.inverse_dynamics(s.q[k], s.v[k], s.a[k]) for k in range(400)])
    start = threading.Barrier(8)

    def work(seed: int) -> None:
        random = np.random.default_rng(seed)
        start.wait()
        for _ in range(150):
            k = random.integers(400)
            assert np.array_equal(quadruped.inverse_dynamics(s.q[k], s.v[k], s.a[k]), singles[k])
            threads = int(random.integers(1, 4))
            assert np.array_equal(quadruped.inverse_dynamics(s.q, s.v, s.a, threads=threads), expected)
            assert np.isfinite(quadruped.christoffel_symbols(s.q[:3], threads=2)).all()

    with ThreadPoolExecutor(8) as pool:
        list(pool.map(work, range(8)))


def test_a_batch_leaves_the_interpreter_to_others(panda: rd.Robot) -> None:
    s = states(panda, 100_000)
    ticks, done = [0], threading.Event()

    def count() -> None:
        while not done.is_set():
            ticks[0] += 1
            time.sleep(0.001)

    other = threading.Thread(target=count)
    other.start()
    begun, before = time.perf_counter(), ticks[0]
    for _ in range(3):
        panda.christoffel_symbols(s.q[:30_000], threads=1)
    seconds, counted = time.perf_counter() - begun, ticks[0] - before
    done.set()
    other.join()
    # The counter would stop while a call held the lock. A loaded machine counts slowly.
    assert counted > 20 * seconds


@pytest.mark.skipif(not HAS_FORK, reason="no fork on this system")
@pytest.mark.filterwarnings("ignore:.*fork.*:DeprecationWarning")
# The warning is of JAX, if its tests ran in this process. This test does not use JAX.
@pytest.mark.filterwarnings("ignore:os.fork:RuntimeWarning")
def test_a_fork_computes_as_its_parent() -> None:
    robot = rd.example("panda")
    s = states(robot, 5000)
    expected = robot.inverse_dynamics(s.q, s.v, s.a, threads=3)  # starts a thread pool
    busy = ThreadPoolExecutor(2)
    running = [busy.submit(robot.mass_matrix, np.tile(s.q, (20, 1)), threads=2) for _ in range(4)]
    context = multiprocessing.get_context("fork")
    with context.Pool(2) as pool:
        waiting = pool.starmap_async(_compute, [(robot, s, threads) for threads in (3, 2, 1, 3)])
        results = waiting.get(timeout=60)
    assert all(np.array_equal(result, expected) for result in results)
    assert all(future.result().shape == (100_000, 7, 7) for future in running)
    assert np.array_equal(robot.inverse_dynamics(s.q, s.v, s.a, threads=3), expected)


@pytest.mark.parametrize("method", ["spawn"])
def test_a_robot_travels_to_another_process(method: str) -> None:
    robot = rd.example("panda")
    s = states(robot, 50)
    with multiprocessing.get_context(method).Pool(1) as pool:
        result = pool.apply(_compute, (robot, s, 2))
    assert np.array_equal(result, robot.inverse_dynamics(s.q, s.v, s.a))


def _compute(robot: rd.Robot, s: States, threads: int) -> Any:
    return robot.inverse_dynamics(s.q, s.v, s.a, threads=threads)


@pytest.mark.skipif(os.name != "posix", reason="signals of POSIX")
@pytest.mark.parametrize("call", ["robot.christoffel_symbols(q, threads=2)", "robot.mass_matrix(q, threads=1)"])
def test_an_interrupt_ends_a_long_batch(call: str) -> None:
    program = f"""
import numpy as np, robot_dynamics as rd
robot = rd.example("humanoid", floating_base=True)
q = np.lib.stride_tricks.as_strided(robot.neutral(), (2000, robot.nq), (0, 8)).copy()
print("ready", flush=True)
while True:
    {call}
"""
    errors, seconds = interrupted(program)
    assert "KeyboardInterrupt" in errors and seconds < 10.0


def test_calls_leave_no_memory_behind(panda: rd.Robot) -> None:
    resource = pytest.importorskip("resource")
    q, v = np.zeros(7), np.zeros(7)
    out = np.zeros(7)
    rest = [np.zeros((3, 7)), [0.0] * 7, np.zeros(7, np.float32)]

    def rounds(count: int) -> None:
        for _ in range(count):
            panda.gravity(q, out=out)
            panda.bias(q, v)
            panda.potential_energy(q)
            panda.frame_pose(q, "panda_link8")
        for _ in range(count // 50):
            for other in rest:
                panda.gravity(other)  # type: ignore[call-overload]
            panda.inverse_dynamics_derivatives(q, v, v)
            with pytest.raises(rd.StateError):
                panda.gravity(q * np.nan)
            with pytest.raises(rd.BadStatesError):
                panda.gravity(np.full((2, 7), np.nan))

    def peak() -> Any:
        gc.collect()
        return resource.getrusage(resource.RUSAGE_SELF).ru_maxrss

    rounds(5000)
    before = peak()
    rounds(250_000)  # a million calls
    # 64 bytes a call would be 64 MB.
    assert peak() - before < 20_000 * (1024 if sys.platform == "darwin" else 1)


def test_references_are_neither_lost_nor_kept(panda: rd.Robot) -> None:
    q, out = np.zeros(7), np.zeros(7)
    robot = rd.example("two_r")
    before = [sys.getrefcount(thing) for thing in (q, out, robot, None)]
    for _ in range(1000):
        panda.gravity(q, out=out)
        panda.gravity(q)
        robot.gravity([0.0, 0.0])
        panda.frame_poses(q, ["panda_link8", 0])
    after = [sys.getrefcount(thing) for thing in (q, out, robot, None)]
    assert after[:3] == before[:3] and abs(after[3] - before[3]) < 100


def test_default_threads_are_chosen_for_the_process() -> None:
    try:
        rd.set_num_threads(3)
        assert rd.num_threads() == 3
    finally:
        rd.set_num_threads(None)
    assert rd.num_threads() >= 1
    with pytest.raises(ValueError, match="threads = 0"):
        rd.set_num_threads(0)
