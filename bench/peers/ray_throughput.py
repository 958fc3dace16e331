"""The overhead of a cluster: a robot's quantity by Ray, with one and two workers, beside the plain batch.

    pip install ./python[ray]
    python bench/peers/ray_throughput.py [--states 10000000] [--rounds 5] [--robot panda] [--quantity inverse_dynamics]

All methods compute the same states, in blocks of 250 000, and their results are compared bit for bit first.
Each round runs every method once, so that other load affects all of them; ratios are within a round. The
output has medians, and the range of the ratios. The script asserts that workers read the states without a
copy.
"""

import argparse
import os
import statistics
import tempfile
import time
from collections.abc import Callable
from pathlib import Path
from typing import Any

import numpy as np
import pyarrow as pa
import pyarrow.parquet as pq

import robot_dynamics as rd
from robot_dynamics import arrow, parquet
from robot_dynamics.columns import column_of

BLOCK = 250_000
NONE = np.zeros(0, np.intp)


def blocks(robot: rd.Robot, computation: arrow.Computation, count: int) -> list[Any]:
    """Random states as tables of `BLOCK` rows."""
    tables = []
    for k, size in enumerate([BLOCK] * (count // BLOCK)):
        random = np.random.default_rng(k)
        state = {name: random.uniform(-1.0, 1.0, (size, robot.nv)) for name in computation.reads}
        state["q"] = robot.random_configuration(size, seed=k + 1)
        tables.append(pa.table({name: column_of(state[name], NONE) for name in computation.reads}))
    return tables


def main() -> None:
    parser = argparse.ArgumentParser(description=__doc__.splitlines()[0])
    parser.add_argument("--states", type=int, default=10_000_000)
    parser.add_argument("--rounds", type=int, default=5)
    parser.add_argument("--robot", default="panda")
    parser.add_argument("--quantity", default="inverse_dynamics")
    parser.add_argument("--folder", help="where Parquet files go meanwhile")
    options = parser.parse_args()
    os.environ.setdefault("RAY_USAGE_STATS_ENABLED", "0")
    import ray

    from robot_dynamics.ray import Workers, compute

    robot = rd.example(options.robot)
    computation = arrow.Computation(robot, [options.quantity], threads=1)
    tables = blocks(robot, computation, options.states)
    count, given = len(tables) * BLOCK, sum(table.nbytes for table in tables)
    produced = computation(tables[0]).nbytes * len(tables)
    ray.init(
        num_cpus=8,
        include_dashboard=False,
        log_to_driver=False,
        object_store_memory=int(2.5 * (given + produced)) + 10**9,
    )
    ray.data.DataContext.get_current().enable_progress_bars = False
    references = [ray.put(table) for table in tables]
    # From here on the blocks are those in shared memory, which the plain batch also reads.
    tables = ray.get(references)
    check(robot, options.quantity, computation, tables[0])

    method = getattr(robot, options.quantity)
    arrays = [[arrow_array(table, name, width(robot, name)) for name in computation.reads] for table in tables]

    def plain(threads: int) -> None:
        for state in arrays:
            method(*state, threads=threads)

    def by_arrow() -> None:
        for table in tables:
            computation(table)

    pools = {workers: Workers(robot, workers) for workers in (1, 2)}
    kept = ray.put(computation)

    def by_workers(workers: int) -> None:
        results = pools[workers].map(_stored, [(kept, reference) for reference in references])
        assert len(results) == len(references)

    def by_data(workers: int) -> None:
        dataset = ray.data.from_arrow_refs(references)
        assert compute(dataset, robot, options.quantity, workers=workers).materialize().count() == count

    ways: dict[str, Callable[[], None]] = {
        "plain batch, 1 thread": lambda: plain(1),
        "plain batch, 2 threads": lambda: plain(2),
        "Arrow tables, 1 thread": by_arrow,
        "`Workers.map`, 1 worker": lambda: by_workers(1),
        "`Workers.map`, 2 workers": lambda: by_workers(2),
        "`ray.data`, 1 worker": lambda: by_data(1),
        "`ray.data`, 2 workers": lambda: by_data(2),
    }
    with tempfile.TemporaryDirectory(dir=options.folder) as temporary:
        source, out = Path(temporary) / "states.parquet", Path(temporary) / "out.parquet"
        with pq.ParquetWriter(source, tables[0].schema, use_dictionary=False) as writer:
            for table in tables:
                writer.write_table(table)
        file = source.stat().st_size

        def by_command(workers: int) -> None:
            out.unlink(missing_ok=True)
            parquet.run(parquet.Job.of(computation, source, out), parquet.by_threads(workers))

        def by_files() -> None:
            folder = Path(temporary) / "out"
            parquet.run(parquet.Job.of(computation, source, folder), parquet.by_threads(2))
            for path in folder.iterdir():
                path.unlink()
            folder.rmdir()

        ways["Parquet to Parquet, 1 thread"] = lambda: by_command(1)
        ways["Parquet to Parquet, 2 threads"] = lambda: by_command(2)
        ways["Parquet to a folder, 2 threads"] = by_files
        times: dict[str, list[float]] = {name: [] for name in ways}
        for _ in range(options.rounds):
            for name, way in ways.items():
                begun = time.perf_counter()
                way()
                times[name].append(time.perf_counter() - begun)
    first = times["plain batch, 1 thread"]
    print(f"{robot.name}, {options.quantity}: {count} states of {given // count} bytes, results of {produced // count}")
    print(f"Parquet: {file / count:.0f} bytes a state; {options.rounds} rounds; {os.cpu_count()} cores")
    print("| way | ns a state | million states a second | time over the plain batch of that round |")
    print("| --- | ---: | ---: | ---: |")
    for name, own in times.items():
        ratios = sorted(mine / theirs for mine, theirs in zip(own, first, strict=True))
        middle = statistics.median(own)
        spread = f"{statistics.median(ratios):.2f} ({ratios[0]:.2f} to {ratios[-1]:.2f})"
        print(f"| {name} | {middle / count * 1e9:.1f} | {count / middle / 1e6:.1f} | {spread} |")
    overhead(pools[1], pools[2])
    ray.shutdown()


def _stored(robot: rd.Robot, kept: Any, table: Any) -> int:
    """Computes a block in shared memory, asserts that it was not copied, and puts the result there."""
    import ray

    for name in table.column_names:
        (chunk,) = table[name].chunks
        view = arrow_array(table, name, chunk.type.list_size)
        assert view.ctypes.data == chunk.values.buffers()[1].address + 8 * chunk.offset * chunk.type.list_size
    return int(ray.put(kept(table)) is not None)


def arrow_array(table: Any, name: str, wide: int) -> Any:
    """A column as an array without a copy."""
    from robot_dynamics.columns import array_of

    (batch,) = table.to_batches()
    return array_of(batch, name, name, wide, slice(None), "robot")


def width(robot: rd.Robot, name: str) -> int:
    return robot.nq if name == "q" else robot.nv


def check(robot: rd.Robot, quantity: str, computation: arrow.Computation, table: Any) -> None:
    """The results of all methods on one block, as bytes."""
    from robot_dynamics.ray import Workers

    workers = Workers(robot, 2)
    pieces = [table.slice(start, 50_000) for start in range(0, BLOCK, 50_000)]
    found = pa.concat_tables(workers.map(lambda _, piece: computation(piece), [(piece,) for piece in pieces]))
    assert found.combine_chunks().equals(computation(table).combine_chunks())
    workers.close()


def overhead(one: Any, two: Any) -> None:
    """The cost of a call of a worker that does nothing."""
    for pool in (one, two):
        rounds = []
        for _ in range(5):
            begun = time.perf_counter()
            pool.map(lambda robot, k: k, [(k,) for k in range(500)])
            rounds.append((time.perf_counter() - begun) / 500 * 1e6)
        spread = f"{statistics.median(rounds):.0f} ({min(rounds):.0f} to {max(rounds):.0f})"
        print(f"a call that does nothing, {len(pool)} worker(s): {spread} µs")


if __name__ == "__main__":
    main()
