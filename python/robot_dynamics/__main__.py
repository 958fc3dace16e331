"""Command ``python -m robot_dynamics``: quantities of Parquet files.

The command ``dynamics``, written in Rust, has all other functions.

    python -m robot_dynamics compute STATES.parquet --robot panda.urdf -o TORQUES.parquet --workers 8
    python -m robot_dynamics compute RECORDING/ --robot panda.urdf -o AUDIT.parquet --quantity audit \\
        --column 'q=observation.state[0:7]' --keep timestamp episode_index
    python -m robot_dynamics quantities
"""

from __future__ import annotations

import argparse
import os
import shutil
import signal
import sys
import warnings
from collections.abc import Callable
from typing import NoReturn

import robot_dynamics as rd
from robot_dynamics._native import _visible


def main(arguments: list[str] | None = None) -> int:
    """Run the command.

    Parameters
    ----------
    arguments : list of str, optional
        Arguments; default: those of the process.

    Returns
    -------
    int
        Exit code.
    """
    options = _parser().parse_args(arguments)
    try:
        result: int = options.run(options)
        return result
    except (rd.RobotDynamicsError, OSError, ValueError, ImportError) as error:
        print(_visible(f"error: {error}", True), file=sys.stderr)
        return 1


def _parser() -> argparse.ArgumentParser:
    parser = argparse.ArgumentParser(
        "python -m robot_dynamics", description="Quantities of a robot for the rows of Parquet files."
    )
    commands = parser.add_subparsers(required=True, metavar="COMMAND")
    listing = commands.add_parser("quantities", help="list the quantities and the columns that each reads")
    listing.set_defaults(run=_quantities)
    compute = commands.add_parser(
        "compute",
        help="compute quantities for the rows of Parquet files",
        description="Compute quantities for each row of Parquet files. To resume after an interruption, run the same "
        "command again. Results are the same bytes for any number of workers.",
    )
    compute.set_defaults(run=_compute)
    compute.add_argument(
        "states", metavar="STATES", help="Parquet file, or folder of such files, with list columns q, v, a, tau"
    )
    compute.add_argument(
        "--robot", required=True, metavar="R", help=f"file of a robot, or one of {', '.join(_EXAMPLES)}"
    )
    compute.add_argument(
        "-o", "--output", required=True, metavar="OUT", help="one file OUT.parquet, or a folder of files"
    )
    compute.add_argument(
        "--quantity", nargs="+", default=["inverse_dynamics"], metavar="Q", help="quantities; see `quantities`"
    )
    compute.add_argument(
        "--column", action="append", default=[], metavar="q=NAME", help="column of q; NAME[0:7] is a slice of its lists"
    )
    compute.add_argument("--keep", nargs="+", default=[], metavar="NAME", help="columns to copy to the result")
    compute.add_argument(
        "--dtype", choices=["float64", "float32"], help="type to compute in; default: that of the columns"
    )
    compute.add_argument(
        "--bad-rows", choices=["stop", "null"], default="stop", help="stop at a row without a valid result, or write null"
    )
    compute.add_argument("--floating-base", action="store_true", help="let the root link move freely")
    compute.add_argument(
        "--workers", type=_positive, metavar="N", help="number of threads, or of processes with --ray; default: one per core"
    )
    compute.add_argument(
        "--ray", metavar="ADDRESS", help="compute on this Ray cluster: auto, HOST:PORT, or local to start one here"
    )
    compute.add_argument("--quiet", action="store_true", help="print errors only")
    return parser


_EXAMPLES = ("two_r", "ur5", "panda", "quadruped", "humanoid")


def _compute(options: argparse.Namespace) -> int:
    try:
        from robot_dynamics import parquet
        from robot_dynamics.arrow import Computation
    except ModuleNotFoundError as error:
        raise ImportError("Parquet files need pyarrow: pip install robot-dynamics[arrow]") from error
    from robot_dynamics.progress import Progress

    def say(text: str) -> None:
        if not options.quiet:
            print(_visible(text, True), file=sys.stderr)

    computation = Computation(
        _robot(options, say),
        options.quantity,
        columns=dict(_column(text) for text in options.column),
        keep=options.keep,
        dtype=options.dtype,
        bad_states="null" if options.bad_rows == "null" else "raise",
        threads=1,
    )
    job = parquet.Job.of(computation, options.states, options.output)
    rows = sum(part.rows for part in job.parts)
    if job.is_done():
        shutil.rmtree(job.folder, ignore_errors=True)  # a run ended between the last two steps
        say(f"{job.output}: already holds this result, {rows} rows")
        return 0
    progress = Progress(rows, is_shown=False if options.quiet else None)

    def start(before: int) -> None:
        if before:
            say(f"{before} of {rows} rows are already computed, in {job.folder}")
        progress.start(before)

    if options.ray is None:
        runner = parquet.by_threads(options.workers or rd.num_threads(), progress)
    else:
        from robot_dynamics.ray import by_actors

        runner = by_actors(options.workers, options.ray, progress)
    before = signal.signal(signal.SIGTERM, _interrupt)
    try:
        parquet.run(job, runner, start)
    except (KeyboardInterrupt, rd.BadStatesError) as error:
        done = sum(job.is_finished(part) for part in job.parts)
        kept = f"{done} of {len(job.parts)} parts are finished and kept in {job.folder}"
        kept += "; run the same command again to continue"
        if isinstance(error, KeyboardInterrupt):
            print(_visible(f"\ninterrupted: {kept}", True), file=sys.stderr)
            return 130
        raise rd.BadStatesError(
            f"{error}; --bad-rows null writes null for such rows. {kept}", indices=error.indices, result=error.result
        ) from None
    finally:
        signal.signal(signal.SIGTERM, before)
        progress.close()
    say(f"{job.output}: {rows} rows")
    return 0


def _quantities(_: argparse.Namespace) -> int:
    from robot_dynamics.quantities import quantity, quantity_names

    robot = rd.example("two_r")
    for name in quantity_names():
        known = quantity(robot, name.replace("FRAME", robot.frame_names[0]))
        print(f"{name:52}{' '.join(known.reads)}")
    return 0


def _robot(options: argparse.Namespace, say: Callable[[str], None]) -> rd.Robot:
    if not os.path.exists(options.robot) and options.robot in _EXAMPLES:
        return rd.example(options.robot, floating_base=options.floating_base)
    with warnings.catch_warnings(record=True) as found:
        warnings.simplefilter("always")
        robot = rd.load(options.robot, floating_base=options.floating_base)
    for warning in found:
        say(f"warning: {warning.message}")
    return robot


def _column(text: str) -> tuple[str, str]:
    name, equals, column = text.partition("=")
    if not (name and equals and column):
        raise ValueError(f"--column {text}: write q=NAME with the column of q")
    return name, column


def _positive(text: str) -> int:
    if not text.isascii() or not text.isdigit() or int(text) == 0:
        raise argparse.ArgumentTypeError(f"{text!r} is not a positive number of workers")
    return int(text)


def _interrupt(*_: object) -> NoReturn:
    raise KeyboardInterrupt


if __name__ == "__main__":
    sys.exit(main())
