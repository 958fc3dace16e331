"""A cluster of processes on this machine: the same bits for any number of workers, also if some are killed.
"""

import os
import signal
import threading
import time
from collections.abc import Iterator
from pathlib import Path
from typing import Any

import numpy as np
import pyarrow as pa
import pyarrow.parquet as pq
import pytest

import robot_dynamics as rd
from conftest import states
from robot_dynamics import arrow, parquet
from robot_dynamics.__main__ import main
from robot_dynamics.sampling import Mppi

ray = pytest.importorskip("ray")
# The warnings of Ray do not concern this package.
pytestmark = [pytest.mark.filterwarnings("ignore"), pytest.mark.skipif(os.name != "posix", reason="kills processes")]

PANDA = rd.example("panda")


@pytest.fixture(scope="module", autouse=True)
def cluster(tmp_path_factory: pytest.TempPathFactory) -> Iterator[None]:
    """A cluster with processes for two workers, which import the tested package."""
    # The workers of Ray import from the driver's working directory first. Beside the sources they would
    # import these instead of the installed package.
    started = Path.cwd()
    os.chdir(tmp_path_factory.mktemp("elsewhere"))
    os.environ["RAY_USAGE_STATS_ENABLED"] = "0"
    os.environ["RAY_ENABLE_UV_RUN_RUNTIME_ENV"] = "0"
    path = str(Path(rd.__file__).parents[1])
    environment = {"env_vars": {"PYTHONPATH": os.pathsep.join([path, str(Path(__file__).parent)])}}
    options = {"include_dashboard": False, "log_to_driver": False, "object_store_memory": 200_000_000}
    ray.init(num_cpus=3, runtime_env=environment, **options)
    ray.data.DataContext.get_current().enable_progress_bars = False
    yield
    ray.shutdown()
    os.chdir(started)


def die_once(marker: Path) -> None:
    """Kill this process during its work, unless another was killed before."""
    try:
        os.close(os.open(marker, os.O_CREAT | os.O_EXCL))
    except FileExistsError:
        return
    os.kill(os.getpid(), signal.SIGKILL)


def test_rollouts_are_the_same_bits_and_survive_a_kill(tmp_path: Path) -> None:
    from robot_dynamics.ray import Workers

    s = states(PANDA, 4000)
    options: dict[str, Any] = {"steps": 200, "dt": 1e-3, "stride": 50}
    plain = PANDA.rollout(s.q, s.v, s.tau, **options)
    for count in (1, 2):
        workers = Workers(PANDA, count)
        first = workers.processes()
        assert len(set(first)) == count == len(workers) and os.getpid() not in first
        killer = threading.Timer(0.05, os.kill, (first[0], signal.SIGKILL))
        killer.start()
        found = workers.rollout(s.q, s.v, s.tau, group=100, **options)
        for name in ("q", "v", "q_trajectory", "v_trajectory"):
            assert np.array_equal(getattr(found, name), getattr(plain, name)), name
        killer.join()
        after = workers.processes()
        assert first[0] not in after and len(set(after)) == count  # it was killed and replaced
        held = workers.rollout(s.q[:150], s.v[:150], np.tile(s.tau[:150, np.newaxis], (1, 5, 1)), group=64, steps=5)
        assert np.array_equal(held.q, PANDA.rollout(s.q[:150], s.v[:150], s.tau[:150], steps=5).q)
        if count == 2:
            q = s.q[:200].copy()
            q[[7, 150], 3] = np.nan
            with pytest.raises(
                rd.BadStatesError, match="2 of 200 states have no rollout, the first is state 7"
            ) as error:
                workers.rollout(q, s.v[:200], group=64, steps=5)
            assert error.value.indices.tolist() == [7, 150]
            good = np.delete(np.arange(200), [7, 150])
            expected = PANDA.rollout(q[good], s.v[good], steps=5)
            assert np.array_equal(error.value.result.q[good], expected.q)
        workers.close()


def test_map_keeps_the_order_and_raises_the_error_of_a_worker(tmp_path: Path) -> None:
    from robot_dynamics.ray import Workers

    workers = Workers(PANDA, 2)
    before = workers.processes()

    def gravity(robot: rd.Robot, number: int, q: Any) -> Any:
        assert not q.flags.writeable  # shared memory is read-only
        if number == 7:
            die_once(tmp_path / "died")
        time.sleep(0.01 * (number % 3))
        return number, rd.num_threads(), robot.gravity(q)

    many = states(PANDA, 3000).q
    found = workers.map(gravity, [(k, many) for k in range(20)])
    assert [number for number, _, _ in found] == list(range(20)) and {threads for _, threads, _ in found} == {1}
    expected = PANDA.gravity(many)
    assert all(np.array_equal(result, expected) for _, _, result in found)
    assert (tmp_path / "died").exists() and len(set(before) - set(workers.processes())) == 1
    bad = many[:10].copy()
    bad[4, 0] = np.nan
    with pytest.raises(rd.BadStatesError, match="state 4") as error:
        workers.map(lambda robot, q: robot.gravity(q), [(bad,)])
    assert error.value.indices.tolist() == [4]
    workers.close()


def test_workers_without_a_machine_keep_nobody_waiting(monkeypatch: pytest.MonkeyPatch) -> None:
    from robot_dynamics import ray as module

    monkeypatch.setattr(module, "_ANSWER_LIMIT", 1.0)
    workers = module.Workers(PANDA, 5)  # with three cores, two of the workers never start
    found = workers.map(lambda robot, number: (number, os.getpid()), [(k,) for k in range(30)])
    assert [number for number, _ in found] == list(range(30)) and len({process for _, process in found}) <= 3
    workers.close()


def test_a_pipeline_is_the_plain_batch_and_survives_a_kill(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    from robot_dynamics import ray as module

    s = states(PANDA, 20_000)
    table = pa.table({"q": list(s.q), "v": list(s.v), "a": list(s.a), "tau": list(s.tau), "index": np.arange(20_000)})

    class Mortal(module.Compute):
        def __call__(self, batch: Any) -> Any:
            if 8000 in batch["index"].to_pylist():
                die_once(tmp_path / "died")
            return super().__call__(batch)

    monkeypatch.setattr(module, "Compute", Mortal)
    dataset = ray.data.from_arrow([table[2000 * k : 2000 * (k + 1)] for k in range(10)])
    result = module.compute(dataset, PANDA, "inverse_dynamics", "audit", keep=["index"], workers=2)
    result.write_parquet(str(tmp_path / "out"))
    assert (tmp_path / "died").exists()
    plain = arrow.compute(PANDA, table, "inverse_dynamics", "audit", keep=["index"]).combine_chunks()
    assert pq.read_table(tmp_path / "out").sort_by("index").combine_chunks().equals(plain)


def test_a_plan_by_sampling_is_the_same_bits(tmp_path: Path) -> None:
    from robot_dynamics.ray import Workers

    robot = rd.example("two_r")

    def cost(q: Any, v: Any, tau: Any) -> Any:
        return ((q - [np.pi / 2, 0.0]) ** 2).sum(axis=(1, 2)) + 0.01 * (v**2).sum(axis=(1, 2))

    def control(run: Any) -> Mppi:
        options: dict[str, Any] = {"horizon": 30, "dt": 0.02, "samples": 500, "group": 64, "seed": 3}
        return Mppi(robot, cost, noise=[3.0, 1.0], temperature=1.0, run=run, **options)

    def plans(run: Any) -> Any:
        mine = control(run)
        return np.stack([mine.plan([1.0, 0.1], [0.0, 0.0]) for _ in range(4)]), mine.least_cost

    expected, least = plans(None)
    still = cost(*(x[np.newaxis] for x in control(None).motion([1.0, 0.1], [0.0, 0.0])))[0]
    assert least < 0.7 * still
    for count in (1, 2):
        workers = Workers(robot, count)
        killer = threading.Timer(0.02, os.kill, (workers.processes()[0], signal.SIGKILL))
        killer.start()
        found, same = plans(workers.map)
        killer.join()
        assert np.array_equal(found, expected) and same == least
        workers.close()


def test_the_command_on_a_cluster_survives_a_kill(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    from robot_dynamics import ray as module

    s = states(PANDA, 20_000)
    table = pa.table({name: list(getattr(s, name)) for name in ("q", "v", "tau")})
    pq.write_table(table, tmp_path / "states.parquet", row_group_size=1000)
    given = [
        "compute",
        str(tmp_path / "states.parquet"),
        "--robot",
        "panda",
        "--quantity",
        "forward_dynamics_derivatives",
    ]

    class Mortal(module._PartWorker):
        def write(self, part: Any) -> Any:
            if part.number == 7:
                die_once(tmp_path / "died")
            return super().write(part)

    monkeypatch.setattr(module, "_PartWorker", Mortal)
    assert main([*given, "-o", str(tmp_path / "out.parquet"), "--ray", "auto", "--workers", "2"]) == 0
    assert (tmp_path / "died").exists()
    assert main([*given, "-o", str(tmp_path / "plain.parquet"), "--workers", "1"]) == 0
    assert (tmp_path / "out.parquet").read_bytes() == (tmp_path / "plain.parquet").read_bytes()
    # An error in a worker is raised like one in a thread.
    rows = s.q.tolist()
    rows[1500][2] = float("nan")
    pq.write_table(table.set_column(0, "q", pa.array(rows)), tmp_path / "bad.parquet", row_group_size=1000)
    with pytest.raises(rd.BadStatesError, match=r"bad.parquet, row 1500: no `gravity`: q\[2\]"):
        computation = arrow.Computation(PANDA, ["gravity"], threads=1)
        parquet.run(
            parquet.Job.of(computation, tmp_path / "bad.parquet", tmp_path / "no.parquet"), module.by_actors(2, "auto")
        )


def test_the_example_finds_what_is_wrong(tmp_path: Path) -> None:
    from test_examples import run

    found = run("energy_audit_on_ray", tmp_path)
    assert found["suspicious"] == [5] and found["rows"] == 8 * 1200
    good = np.delete(found["shares"], 5)
    assert found["shares"][5] > 0.1 and good.max() < 0.005


def test_environments_are_the_same_bits_for_any_workers_and_after_kills(tmp_path: Path) -> None:
    from robot_dynamics.gym import Walk
    from robot_dynamics.ray import Environments

    def make() -> Walk:
        return Walk(3, horizon=15, noise=0.01, command_time=0.2)

    def policy(seen: Any, random: np.random.Generator) -> Any:
        return random.uniform(-1.2, 1.2, (len(seen), 12))

    def run(workers: int, killed: set[int]) -> list[Any]:
        envs = Environments(make, 4, workers, seed=7, checkpoint_every=8)
        found: list[Any] = [envs.reset()]
        assert len(envs) == 4 and envs.num_envs == 12
        actions = np.random.default_rng(1).uniform(-1.2, 1.2, (20, 12, 12))
        for k in range(6):
            if k in killed:
                os.kill(envs.processes()[-1], signal.SIGKILL)
            found += envs.step(actions[k]) if k % 2 else envs.collect(policy, 6)
        if not killed:
            envs.save(tmp_path / f"checkpoint{workers}")
            found += envs.collect(policy, 6)
        envs.close()
        return found

    expected = run(1, set())
    assert expected[1].shape == (6, 12, 50) and expected[2].dtype == np.float32 and expected[25].any()
    for workers, killed in ((2, {0, 3, 4}), (3, {5})):
        found = run(workers, killed)
        assert len(found) == len(expected) - 6
        assert all(np.array_equal(x, y) for x, y in zip(found, expected, strict=False))
    # Groups differ, and other processes continue from the file.
    assert not np.array_equal(expected[0][:3], expected[0][3:6])
    later = Environments(make, 4, 2, seed=0)
    assert np.array_equal(later.load(tmp_path / "checkpoint1"), expected[-10])
    assert all(np.array_equal(x, y) for x, y in zip(later.collect(policy, 6), expected[-6:], strict=True))
    later.close()


def test_groups_are_plain_environments_and_errors_change_nothing() -> None:
    from robot_dynamics.gym import SwingUp
    from robot_dynamics.ray import Environments

    envs = Environments(lambda: SwingUp(2, horizon=6), 2, 2, seed=3)
    plain = [SwingUp(2, horizon=6) for _ in range(2)]
    sequences = [np.random.SeedSequence(3, spawn_key=(number, 0)) for number in range(2)]
    seeds = [int(sequence.generate_state(1, np.uint64)[0] >> 1) for sequence in sequences]
    seen = [own.reset(seed=seed)[0] for own, seed in zip(plain, seeds, strict=True)]
    assert np.array_equal(envs.reset(), np.concatenate(seen))

    def fails(seen: Any, random: np.random.Generator) -> Any:
        raise RuntimeError("no policy")

    for action in np.random.default_rng(1).uniform(-1.0, 1.0, (10, 4, 1)):
        parts = [own.step(rows) for own, rows in zip(plain, np.split(action, 2), strict=True)]
        found = envs.step(action)
        assert np.array_equal(found[0], np.concatenate([part[0] for part in parts]))
        assert np.array_equal(found[1], np.concatenate([part[1] for part in parts]).astype(np.float32))
    with pytest.raises(RuntimeError, match="no policy"):
        envs.collect(fails, 2)
    action = np.full((4, 1), 0.5)
    parts = [own.step(rows) for own, rows in zip(plain, np.split(action, 2), strict=True)]
    assert np.array_equal(envs.step(action)[0], np.concatenate([part[0] for part in parts]))
    with pytest.raises(ValueError, match=r"actions have shape \(3, 1\), they must have one row for each of 4"):
        envs.step(np.zeros((3, 1)))
    with pytest.raises(ValueError, match="each must be at least 1"):
        Environments(SwingUp, 0)
    envs.close()
