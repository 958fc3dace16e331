"""Quantities of Parquet files of any size: part by part, each kept as soon as it is finished, by any number
of workers.

A part is a row group of the input. Its result is a file of its own in the folder ``OUT.parts``, written under
another name and then renamed, so that it is there entirely or not at all. It carries the fingerprint of its
job: of robot, quantities, options, version and input. Who is interrupted, or killed, starts the same job
again and it goes on with the parts that are missing. What a part contains depends on nothing else, so results
are the same bytes for any number of workers. When all are there they become one file, or the folder itself is
the result.
"""

from __future__ import annotations

import hashlib
import json
import os
import shutil
import uuid
from collections.abc import Callable, Generator, Iterable, Iterator
from concurrent.futures import FIRST_COMPLETED, ThreadPoolExecutor, wait
from contextlib import closing, contextmanager
from dataclasses import dataclass
from functools import cached_property
from itertools import chain
from pathlib import Path
from threading import Event
from typing import Any, TypeAlias

import pyarrow as pa
import pyarrow.parquet as pq

from robot_dynamics import _native
from robot_dynamics.arrow import Computation
from robot_dynamics.errors import BadStatesError, ColumnError
from robot_dynamics.files import refuse_file_read

try:
    import fcntl
except ImportError:  # not on Windows
    fcntl = None  # type: ignore[assignment]

Counter = Callable[[int], None]
"""Told of so many rows more."""
JOB = b"robot_dynamics.job"
"""Where a result has the fingerprint of its job."""
_LOCK = ".lock"
_BATCH_BYTES = 1 << 24


class Stopped(Exception):
    """Work was ended before it was done."""


@dataclass(frozen=True)
class Part:
    """A row group of the input."""

    number: int
    path: str
    row_group: int
    first: int
    """Its first row in the file."""
    rows: int


@dataclass(frozen=True)
class Job:
    """A computation for all rows of Parquet files. It can be pickled."""

    computation: Computation
    paths: tuple[str, ...]
    output: Path
    """A file that ends in ``.parquet``, or a folder."""

    @classmethod
    def of(cls, computation: Computation, source: str | os.PathLike[str], output: str | os.PathLike[str]) -> Job:
        """The job of one file, or of all files ``*.parquet`` in a folder, in the order of their paths."""
        given, out = Path(source), Path(output)
        if given.is_dir():
            paths = tuple(sorted(str(path) for path in given.rglob("*.parquet") if path.is_file()))
            if not paths:
                raise FileNotFoundError(f"{given}: no file *.parquet in this folder")
        elif given.is_file():
            paths = (str(given),)
        else:
            raise FileNotFoundError(f"{given}: no such file")
        if not out.parent.is_dir():
            raise FileNotFoundError(f"{out}: no folder {out.parent}")
        if (
            any(out.exists() and out.samefile(path) for path in [str(given), *paths])
            or given.resolve() in out.resolve().parents
        ):
            raise ValueError(f"{out}: the results would lie over the input")
        refuse_file_read(computation.robot, out)
        # Workers may be in other folders.
        return cls(computation, tuple(os.path.abspath(path) for path in paths), Path(os.path.abspath(out)))

    @property
    def folder(self) -> Path:
        """Where finished parts are."""
        return self.output.with_name(f"{self.output.name}.parts")

    @cached_property
    def parts(self) -> tuple[Part, ...]:
        """All parts, in the order of the rows."""
        parts: list[Part] = []
        for path in self.paths:
            first, footer = 0, _opened(path).metadata
            for group in range(footer.num_row_groups):
                rows = footer.row_group(group).num_rows
                parts.append(Part(len(parts), path, group, first, rows))
                first += rows
        return tuple(parts)

    @cached_property
    def schema(self) -> Any:
        """The columns of the results, which all files have to agree on."""
        found: Any = None
        for path in self.paths:
            try:
                schema = self.computation.schema(_opened(path).schema_arrow)
            except ColumnError as error:
                raise ColumnError(f"{path}: {error}") from None
            if found is not None and not schema.equals(found):
                raise ColumnError(f"{path}: its results are {_kinds(schema)}, those of {self.paths[0]} {_kinds(found)}")
            found = schema
        return found.with_metadata({JOB: self.fingerprint})

    @cached_property
    def fingerprint(self) -> str:
        """What the results depend on, as a hash: where this is equal, finished parts are kept.

        Of each file of the input it knows place, size, time of the last change, and the footer with the
        extremes of the columns; so a file that was only copied or touched is computed again, too.
        """
        own = self.computation
        options = [own.quantities, own.columns, own.keep, own.dtype, own.bad_states]
        known = [_native.__version__, own.robot.fingerprint, options, [_identity(path) for path in self.paths]]
        return hashlib.blake2b(json.dumps(known).encode(), digest_size=16).hexdigest()

    def for_worker(self) -> Job:
        """What another process needs to write parts: all but the list of files, of which there may be
        many."""
        lean = Job(self.computation, (), self.output)
        vars(lean)["schema"] = self.schema
        return lean

    def file(self, part: Part) -> Path:
        """Where the result of a part is."""
        return self.folder / f"part-{part.number:06}.parquet"

    def is_finished(self, part: Part) -> bool:
        """Whether the result of a part is there, and is this job's."""
        return self._is_own(self.file(part), part.rows)

    def is_done(self) -> bool:
        """Whether the output is this job's result already."""
        if self.output.is_dir():
            files = [self.output / self.file(part).name for part in self.parts]
            return all(self._is_own(path, part.rows) for path, part in zip(files, self.parts, strict=True))
        return self._is_own(self.output, sum(part.rows for part in self.parts))

    def _is_own(self, path: Path, rows: int) -> bool:
        try:
            with pq.ParquetFile(path) as file:
                known = (file.schema_arrow.metadata or {}).get(JOB)
                return bool(known == self.fingerprint.encode() and file.metadata.num_rows == rows)
        except (OSError, pa.ArrowInvalid):
            return False

    def write(self, part: Part, count: Counter | None = None, is_stopped: Callable[[], bool] = lambda: False) -> Part:
        """Computes a part and keeps its result. A result is there entirely or not at all, whatever
        happens."""
        own, path = self.computation, self.file(part)
        unfinished = path.with_name(f".{path.name}.{uuid.uuid4().hex}")  # workers of other machines write here, too
        read = list(dict.fromkeys([*own.keep, *(column for column, _ in own.sources.values())]))
        first = part.first
        try:
            with pq.ParquetFile(part.path) as file, self._writer(unfinished) as writer:
                width = sum(
                    _bytes(field.type) for field in (*self.schema, *(file.schema_arrow.field(name) for name in read))
                )
                size = min(max(_BATCH_BYTES // max(width, 1), 256), 1 << 16)
                batches = file.iter_batches(size, row_groups=[part.row_group], columns=read, use_threads=False)
                for batch in batches:
                    if is_stopped():
                        raise Stopped
                    try:
                        result, bad = own.rows(batch, first)
                    except ColumnError as error:
                        raise ColumnError(f"{part.path}: {error}") from None
                    if bad and own.bad_states == "raise":
                        raise _complaint(part, bad, result)
                    writer.write_batch(result.cast(self.schema))
                    first += batch.num_rows
                    if count is not None:
                        count(batch.num_rows)
            os.replace(unfinished, path)
        finally:
            unfinished.unlink(missing_ok=True)
        return part

    def _writer(self, path: Path) -> Any:
        # Computed numbers do not repeat: a dictionary of them is work for nothing.
        return pq.ParquetWriter(path, self.schema, use_dictionary=list(self.computation.keep), write_page_checksum=True)

    def finish(self, numbers: Iterable[int], count: Counter | None = None) -> None:
        """The output of the parts, whose numbers are given as they get ready, in any order."""
        if self.output.suffix != ".parquet":
            for _ in numbers:
                pass
            if self.output.is_dir():
                self.output.rmdir()
            (self.folder / _LOCK).unlink(missing_ok=True)
            os.replace(self.folder, self.output)
            return
        unfinished = self.folder / ".whole"
        try:
            with self._writer(unfinished) as writer:
                ready: set[int] = set()
                following = 0
                for number in numbers:
                    ready.add(number)
                    while following in ready:
                        self._append(writer, self.parts[following])
                        following += 1
            os.replace(unfinished, self.output)
        finally:
            unfinished.unlink(missing_ok=True)
        shutil.rmtree(self.folder)

    def _append(self, writer: Any, part: Part) -> None:
        path = self.file(part)
        try:
            # Pages are compared with their checksums.
            with pq.ParquetFile(path, page_checksum_verification=True) as file:
                for batch in file.iter_batches(1 << 16):
                    writer.write_batch(batch)
        except (OSError, pa.ArrowInvalid) as error:
            path.unlink(missing_ok=True)
            raise OSError(
                f"{path}: damaged since it was written, and now removed; start again, the others are kept: {error}"
            ) from None


Runner: TypeAlias = Callable[[Job, list[Part]], Generator[Part, None, None]]
"""Writes parts of a job, and gives each when it is there."""


def run(job: Job, runner: Runner, on_start: Callable[[int], None] = lambda _: None) -> None:
    """Computes what is not yet there of a job, and finishes it. `on_start` is told how many rows were there
    before."""
    # What is wrong with the input is said before anything is made of it.
    known = {job.file(part).name for part in job.parts if job.schema is not None}
    if job.output.suffix != ".parquet" and job.output.exists() and (job.output.is_file() or any(job.output.iterdir())):
        raise FileExistsError(f"{job.output}: is there and holds something else; choose another output, or remove it")
    job.folder.mkdir(exist_ok=True)
    with _alone(job.folder):
        try:
            _run(job, runner, on_start, known)
        except BaseException:
            if not any(job.folder.glob("part-*")):
                shutil.rmtree(job.folder)
            raise


def _run(job: Job, runner: Runner, on_start: Callable[[int], None], known: set[str]) -> None:
    for path in job.folder.iterdir():  # what a killed worker left behind
        if path.name not in known and path.name != _LOCK:
            path.unlink()
    before = [part for part in job.parts if job.is_finished(part)]
    kept = {part.number for part in before}
    on_start(sum(part.rows for part in before))

    # Closed whatever ends this: no worker goes on when the folder is looked at.
    with closing(runner(job, [part for part in job.parts if part.number not in kept])) as parts:
        job.finish(chain(sorted(kept), (part.number for part in parts)))


@contextmanager
def _alone(folder: Path) -> Iterator[None]:
    """Keeps others from the same work meanwhile, where the system has locks that end with their process."""
    if fcntl is None:
        yield
        return
    with (folder / _LOCK).open("w") as file:
        try:
            fcntl.flock(file, fcntl.LOCK_EX | fcntl.LOCK_NB)
        except OSError:
            raise BlockingIOError(f"{folder}: another process is at this work") from None
        yield


def by_threads(workers: int, count: Counter | None = None) -> Runner:
    """A runner with so many threads in this process, as reading, computing and writing do not hold Python's
    lock."""

    def runner(job: Job, parts: list[Part]) -> Generator[Part, None, None]:
        stop = Event()
        with ThreadPoolExecutor(workers, "robot-dynamics") as pool:
            waiting = {pool.submit(job.write, part, count, stop.is_set) for part in parts}
            try:
                while waiting:
                    # A moment at a time: an interrupt is heard on every system.
                    done, waiting = wait(waiting, timeout=0.2, return_when=FIRST_COMPLETED)
                    yield from (future.result() for future in done)
            finally:
                stop.set()
                pool.shutdown(wait=True, cancel_futures=True)

    return runner


def _complaint(part: Part, bad: list[tuple[str, int, str]], result: Any) -> BadStatesError:
    name, row, reason = bad[0]
    rows = sorted({row for _, row, _ in bad})
    return BadStatesError(
        f"{part.path}, row {row}: no `{name}`: {reason}", indices=pa.array(rows).to_numpy(), result=result
    )


def _opened(path: str) -> Any:
    try:
        with pq.ParquetFile(path) as file:
            return _Footer(file.metadata, file.schema_arrow)
    except pa.ArrowInvalid as error:
        raise ValueError(f"{path}: not a Parquet file: {str(error).splitlines()[0]}") from None


@dataclass(frozen=True)
class _Footer:
    metadata: Any
    schema_arrow: Any


def _identity(path: str) -> list[Any]:
    state = os.stat(path)
    with open(path, "rb") as file:
        file.seek(max(state.st_size - 8, 0))
        length = int.from_bytes(file.read(4), "little")
        file.seek(max(state.st_size - 8 - length, 0))
        footer = hashlib.blake2b(file.read(), digest_size=16).hexdigest()
    return [os.path.abspath(path), state.st_size, state.st_mtime_ns, footer]


def _bytes(kind: Any) -> int:
    """About how long a value is."""
    if pa.types.is_fixed_size_list(kind):
        return int(kind.list_size) * _bytes(kind.value_type)
    try:
        return max(int(kind.bit_width) // 8, 1)
    except ValueError:
        return 64


def _kinds(schema: Any) -> str:
    return ", ".join(f"{field.name}: {field.type}" for field in schema)
