"""Progress line of a long computation, on a terminal."""

from __future__ import annotations

import sys
import time
from threading import Lock
from typing import TextIO


class Progress:
    """Counter of rows that writes a progress bar, the rate and the remaining time.

    It writes only to a terminal, and any thread may count.

    Parameters
    ----------
    total : int
        Number of rows.
    stream : text file, optional
        Stream to write to; default: standard error.
    is_shown : bool, optional
        Whether to write; default: whether the stream is a terminal.

    Examples
    --------
    >>> from robot_dynamics.progress import Progress
    >>> print(Progress(2_000_000).line(500_000, 0, 0.05))
    [#######.....................]  25 %  0.5 of 2 M rows  10.0 M/s  0:00 left
    """

    def __init__(self, total: int, stream: TextIO | None = None, is_shown: bool | None = None) -> None:
        self._total = total
        self._stream = sys.stderr if stream is None else stream
        self._is_shown = self._stream.isatty() if is_shown is None else is_shown
        self._done = self._before = 0
        self._begun = self._said = time.monotonic()
        self._lock = Lock()

    def start(self, before: int) -> None:
        """Start the clock, with rows that were done before.

        Parameters
        ----------
        before : int
            Number of rows done before.
        """
        self._done = self._before = before
        self._begun = time.monotonic()

    def __call__(self, rows: int) -> None:
        """Count rows, and rewrite the line at most ten times a second.

        Parameters
        ----------
        rows : int
            Number of new rows.
        """
        with self._lock:
            self._done += rows
            now = time.monotonic()
            if self._is_shown and (now - self._said > 0.1 or self._done == self._total):
                self._said = now
                self._stream.write("\r" + self.line(self._done, self._before, now - self._begun) + "\x1b[K")
                self._stream.flush()

    def line(self, done: int, before: int, seconds: float) -> str:
        """Text of the progress line.

        Parameters
        ----------
        done : int
            Number of rows done.
        before : int
            Number of these that were done before the start.
        seconds : float
            Time since the start [s].

        Returns
        -------
        str
            The line.
        """
        share = done / self._total if self._total else 1.0
        bar = "#" * int(28 * share)
        rate = (done - before) / seconds if seconds > 0.0 else 0.0
        left = f"{_clock((self._total - done) / rate)} left" if rate > 0.0 else ""
        counted = f"{_count(done, self._total)} of {_count(self._total, self._total)} {_unit(self._total)}rows"
        return f"[{bar:.<28}] {100.0 * share:3.0f} %  {counted}  {rate / 1e6:.1f} M/s  {left}".rstrip()

    def close(self) -> None:
        """End the line."""
        if self._is_shown:
            self._stream.write("\n")
            self._stream.flush()


def _unit(total: int) -> str:
    return "M " if total >= 1_000_000 else ""


def _count(rows: int, total: int) -> str:
    return f"{rows / 1e6:.3g}" if total >= 1_000_000 else f"{rows}"


def _clock(seconds: float) -> str:
    minutes, rest = divmod(int(seconds), 60)
    return f"{minutes}:{rest:02}"
