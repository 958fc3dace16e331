"""Quantities of Parquet files of any size: computed part by part by any number of workers, and resumable.

A part is a row group of the input. Its result is a file of its own in the folder ``OUT.parts``. The file is
written under another name and then renamed, so it exists completely or not at all. It carries the fingerprint
of its job: robot, quantities, options, version and input.

To resume after an interruption, start the same job again: it computes the missing parts. A part depends on
its row group and the job only, so results have the same bytes for any number of workers. At the end the parts
are merged into one file, or the folder itself becomes the result.
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
"""Function that is called with a number of new rows."""
JOB = b"robot_dynamics.job"
"""Key of the job's fingerprint in the metadata of a result."""
_LOCK = ".lock"
_BATCH_BYTES = 1 << 24


class Stopped(Exception):
    """Work ended before it was complete."""


@dataclass(frozen=True)
class Part:
    """Row group of the input."""

    number: int
    """Number of the part in the job."""
    path: str
    """File of the input."""
    row_group: int
    """Number of the row group in the file."""
    first: int
    """Number of its first row in the file."""
    rows: int
    """Number of its rows."""


@dataclass(frozen=True)
class Job:
    """Computation for all rows of Parquet files. It can be pickled."""

    computation: Computation
    """Quantities to compute."""
    paths: tuple[str, ...]
    """Files of the input."""
    output: Path
    """File that ends in ``.parquet``, or folder."""

    @classmethod
    def of(cls, computation: Computation, source: str | os.PathLike[str], output: str | os.PathLike[str]) -> Job:
        """Create the job of one file, or of all files ``*.parquet`` in a folder in the order of their paths.

        Parameters
        ----------
        computation : Computation
            Quantities to compute.
        source : path
            File or folder of the input.
        output : path
            File that ends in ``.parquet``, or folder.

        Returns
        -------
        Job
            The job.

        Raises
        ------
        FileNotFoundError
            The input or the folder of the output does not exist.
        ValueError
            The output would replace a file of the input or of the robot.
        """
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
            raise ValueError(f"{out}: the results would replace the input")
        refuse_file_read(computation.robot, out)
        # Workers may have other working directories.
        return cls(computation, tuple(os.path.abspath(path) for path in paths), Path(os.path.abspath(out)))

    @property
    def folder(self) -> Path:
        """Folder of the finished parts."""
        return self.output.with_name(f"{self.output.name}.parts")

    @cached_property
    def parts(self) -> tuple[Part, ...]:
        """All parts, in the order of the rows.

        Raises
        ------
        ValueError
            A file is not a Parquet file.
        """
        parts: list[Part] = []
        for path in self.paths:
            first, footer = 0, _read_footer(path).metadata
            for group in range(footer.num_row_groups):
                rows = footer.row_group(group).num_rows
                parts.append(Part(len(parts), path, group, first, rows))
                first += rows
        return tuple(parts)

    @cached_property
    def schema(self) -> Any:
        """Columns of the results, which must be the same for all files.

        Raises
        ------
        ColumnError
            A column is missing or has the wrong type, or two files differ.
        """
        found: Any = None
        for path in self.paths:
            try:
                schema = self.computation.schema(_read_footer(path).schema_arrow)
            except ColumnError as error:
                raise ColumnError(f"{path}: {error}") from None
            if found is not None and not schema.equals(found):
                own, first = _describe_columns(schema), _describe_columns(found)
                raise ColumnError(f"{path}: its results are {own}, and those of {self.paths[0]} {first}")
            found = schema
        return found.with_metadata({JOB: self.fingerprint})

    @cached_property
    def fingerprint(self) -> str:
        """Hash of everything that the results depend on. Finished parts with the same fingerprint are kept.

        For each input file the hash includes path, size, modification time and the footer, which has the
        extremes of the columns. A copied or touched file is therefore computed again.
        """
        own = self.computation
        options = [own.quantities, own.columns, own.keep, own.dtype, own.bad_states]
        known = [_native.__version__, own.robot.fingerprint, options, [_file_state(path) for path in self.paths]]
        return hashlib.blake2b(json.dumps(known).encode(), digest_size=16).hexdigest()

    def for_worker(self) -> Job:
        """Job that another process needs to write parts: without the list of files, which may be long.

        Returns
        -------
        Job
            The job without its input files.
        """
        lean = Job(self.computation, (), self.output)
        vars(lean)["schema"] = self.schema
        return lean

    def file(self, part: Part) -> Path:
        """File of the result of a part.

        Parameters
        ----------
        part : Part
            Part of this job.

        Returns
        -------
        pathlib.Path
            Path of the file.
        """
        return self.folder / f"part-{part.number:06}.parquet"

    def is_finished(self, part: Part) -> bool:
        """Whether the result of a part exists and belongs to this job.

        Parameters
        ----------
        part : Part
            Part of this job.

        Returns
        -------
        bool
            Whether the part is finished.
        """
        return self._is_result(self.file(part), part.rows)

    def is_done(self) -> bool:
        """Whether the output is already the result of this job.

        Returns
        -------
        bool
            Whether the job is complete.
        """
        if self.output.is_dir():
            files = [self.output / self.file(part).name for part in self.parts]
            return all(self._is_result(path, part.rows) for path, part in zip(files, self.parts, strict=True))
        return self._is_result(self.output, sum(part.rows for part in self.parts))

    def _is_result(self, path: Path, rows: int) -> bool:
        try:
            with pq.ParquetFile(path) as file:
                known = (file.schema_arrow.metadata or {}).get(JOB)
                return bool(known == self.fingerprint.encode() and file.metadata.num_rows == rows)
        except (OSError, pa.ArrowInvalid):
            return False

    def write(self, part: Part, count: Counter | None = None, is_stopped: Callable[[], bool] = lambda: False) -> Part:
        """Compute a part and write its result, completely or not at all.

        Parameters
        ----------
        part : Part
            Part to compute.
        count : callable, optional
            Function that is called with numbers of new rows.
        is_stopped : callable
            Function that returns whether to stop.

        Returns
        -------
        Part
            The same part.

        Raises
        ------
        Stopped
            `is_stopped` returned true.
        BadStatesError
            A row has no valid result.
        ColumnError
            A column is missing or has the wrong type.
        """
        own, path = self.computation, self.file(part)
        # The name is unique, because workers on other machines write to the same folder.
        unfinished = path.with_name(f".{path.name}.{uuid.uuid4().hex}")
        read = list(dict.fromkeys([*own.keep, *(column for column, _ in own.sources.values())]))
        first = part.first
        try:
            with pq.ParquetFile(part.path) as file, self._writer(unfinished) as writer:
                width = sum(
                    _value_size(field.type) for field in (*self.schema, *(file.schema_arrow.field(name) for name in read))
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
                        raise _bad_rows_error(part, bad, result)
                    writer.write_batch(result.cast(self.schema))
                    first += batch.num_rows
                    if count is not None:
                        count(batch.num_rows)
            os.replace(unfinished, path)
        finally:
            unfinished.unlink(missing_ok=True)
        return part

    def _writer(self, path: Path) -> Any:
        # Computed numbers seldom repeat, so a dictionary of them saves nothing.
        return pq.ParquetWriter(path, self.schema, use_dictionary=list(self.computation.keep), write_page_checksum=True)

    def finish(self, numbers: Iterable[int]) -> None:
        """Create the output from the parts.

        Parameters
        ----------
        numbers : iterable of int
            Numbers of the parts as they are finished, in any order.

        Raises
        ------
        OSError
            A part was damaged after it was written. It is removed.
        """
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
            # Reading verifies the checksums of the pages.
            with pq.ParquetFile(path, page_checksum_verification=True) as file:
                for batch in file.iter_batches(1 << 16):
                    writer.write_batch(batch)
        except (OSError, pa.ArrowInvalid) as error:
            path.unlink(missing_ok=True)
            raise OSError(
                f"{path}: was damaged after it was written, and is now removed; start again, other parts are kept: {error}"
            ) from None


Runner: TypeAlias = Callable[[Job, list[Part]], Generator[Part, None, None]]
"""Function that writes parts of a job and yields each when it is finished."""


def run(job: Job, runner: Runner, on_start: Callable[[int], None] = lambda _: None) -> None:
    """Compute the missing parts of a job and create its output.

    Parameters
    ----------
    job : Job
        The job.
    runner : callable
        Function that writes parts and yields them, such as that of `by_threads`.
    on_start : callable
        Function that is called with the number of rows already finished.

    Raises
    ------
    FileExistsError
        The output folder has other content.
    BlockingIOError
        Another process computes this job.
    BadStatesError
        A row has no valid result.
    ColumnError
        A column is missing or has the wrong type.
    """
    # Reading the schema first reports errors of the input before any file is written.
    known = {job.file(part).name for part in job.parts if job.schema is not None}
    if job.output.suffix != ".parquet" and job.output.exists() and (job.output.is_file() or any(job.output.iterdir())):
        raise FileExistsError(f"{job.output}: exists with other content; choose another output, or remove it")
    job.folder.mkdir(exist_ok=True)
    with _lock_folder(job.folder):
        try:
            _run(job, runner, on_start, known)
        except BaseException:
            if not any(job.folder.glob("part-*")):
                shutil.rmtree(job.folder)
            raise


def _run(job: Job, runner: Runner, on_start: Callable[[int], None], known: set[str]) -> None:
    for path in job.folder.iterdir():  # incomplete files of a killed worker
        if path.name not in known and path.name != _LOCK:
            path.unlink()
    before = [part for part in job.parts if job.is_finished(part)]
    kept = {part.number for part in before}
    on_start(sum(part.rows for part in before))

    # Closing the runner stops its workers before the folder is examined, also after an error.
    with closing(runner(job, [part for part in job.parts if part.number not in kept])) as parts:
        job.finish(chain(sorted(kept), (part.number for part in parts)))


@contextmanager
def _lock_folder(folder: Path) -> Iterator[None]:
    """Lock the folder against other processes, on systems with locks that end with their process."""
    if fcntl is None:
        yield
        return
    with (folder / _LOCK).open("w") as file:
        try:
            fcntl.flock(file, fcntl.LOCK_EX | fcntl.LOCK_NB)
        except OSError:
            raise BlockingIOError(f"{folder}: another process computes this job") from None
        yield


def by_threads(workers: int, count: Counter | None = None) -> Runner:
    """Create a runner that uses threads of this process.

    Reading, computing and writing release Python's interpreter lock.

    Parameters
    ----------
    workers : int
        Number of threads.
    count : callable, optional
        Function that is called with numbers of new rows.

    Returns
    -------
    callable
        Runner for `run`.
    """

    def runner(job: Job, parts: list[Part]) -> Generator[Part, None, None]:
        stop = Event()
        with ThreadPoolExecutor(workers, "robot-dynamics") as pool:
            waiting = {pool.submit(job.write, part, count, stop.is_set) for part in parts}
            try:
                while waiting:
                    # Short waits let an interrupt take effect on every system.
                    done, waiting = wait(waiting, timeout=0.2, return_when=FIRST_COMPLETED)
                    yield from (future.result() for future in done)
            finally:
                stop.set()
                pool.shutdown(wait=True, cancel_futures=True)

    return runner


def _bad_rows_error(part: Part, bad: list[tuple[str, int, str]], result: Any) -> BadStatesError:
    name, row, reason = bad[0]
    rows = sorted({row for _, row, _ in bad})
    return BadStatesError(
        f"{part.path}, row {row}: no `{name}`: {reason}", indices=pa.array(rows).to_numpy(), result=result
    )


def _read_footer(path: str) -> Any:
    try:
        with pq.ParquetFile(path) as file:
            return _Footer(file.metadata, file.schema_arrow)
    except pa.ArrowInvalid as error:
        raise ValueError(f"{path}: not a Parquet file: {str(error).splitlines()[0]}") from None


@dataclass(frozen=True)
class _Footer:
    metadata: Any
    schema_arrow: Any


def _file_state(path: str) -> list[Any]:
    state = os.stat(path)
    with open(path, "rb") as file:
        file.seek(max(state.st_size - 8, 0))
        length = int.from_bytes(file.read(4), "little")
        file.seek(max(state.st_size - 8 - length, 0))
        footer = hashlib.blake2b(file.read(), digest_size=16).hexdigest()
    return [os.path.abspath(path), state.st_size, state.st_mtime_ns, footer]


def _value_size(kind: Any) -> int:
    """Approximate size of a value [bytes]."""
    if pa.types.is_fixed_size_list(kind):
        return int(kind.list_size) * _value_size(kind.value_type)
    try:
        return max(int(kind.bit_width) // 8, 1)
    except ValueError:
        return 64


def _describe_columns(schema: Any) -> str:
    return ", ".join(f"{field.name}: {field.type}" for field in schema)
