"""Report on the content of a robot file."""

from __future__ import annotations

from collections.abc import Callable, Mapping, Sequence
from dataclasses import dataclass, field
from functools import cached_property
from typing import Any

from robot_dynamics import _native


@dataclass(frozen=True)
class Finding:
    """One finding of the reader of a robot file."""

    line: int
    """Line in the file; 0 for a finding on the whole file."""
    place: str
    """Element, for example ``link `hand```."""
    severity: str
    """``note``, ``warning`` or ``error``."""
    disposition: str
    """Disposition: read, defaulted, taken as written, repaired, ignored, ignored physics or refused."""
    message: str
    """Description of the finding."""

    def __str__(self) -> str:
        return _native._visible(f"line {self.line}: {self.place}: {self.message}", False)


@dataclass(frozen=True)
class LoadReport:
    """Report of the reader on one robot file.

    >>> report = rd.example("two_r").report
    >>> report.robot, len(report.warnings)
    ('two_r', 0)
    """

    robot: str
    """Name of the robot in the file."""
    counts: Mapping[str, int]
    """Numbers of links, of joints and of findings of each kind."""
    findings: tuple[Finding, ...] = field(repr=False)
    """All findings, by line."""
    text: str = field(repr=False, compare=False)
    """The report as text."""
    files: tuple[str, ...] = field(default=(), repr=False, compare=False)
    """Files that the robot was read from: its own, included ones, attached models, meshes, height fields.

    No method overwrites them.
    """

    grouped_warnings: tuple[str, ...] = field(default=(), repr=False, compare=False)
    """Warnings as text, one for each kind, with their number and the first places.

    Each becomes a `LoadWarning`.
    """
    _left_out: Callable[[], Sequence[str]] | None = field(default=None, repr=False, compare=False)
    _sensors: tuple[tuple[str, str], ...] = field(default=(), repr=False, compare=False)

    @property
    def sensors(self) -> tuple[tuple[str, str], ...]:
        """Name and kind of each sensor of the file.

        >>> rd.example("two_r").report.sensors
        ()
        """
        return self._sensors

    @cached_property
    def left_out(self) -> tuple[str, ...]:
        """Features that the file states and the default simulation leaves out, one line for each reason.

        The first access sets up a simulation.

        >>> rd.example("quadruped").report.left_out
        ()
        """
        return () if self._left_out is None else tuple(self._left_out())

    @property
    def warnings(self) -> tuple[Finding, ...]:
        """Findings on suspicious values, and on physics that the model leaves out."""
        return tuple(finding for finding in self.findings if finding.severity == "warning")

    def __str__(self) -> str:
        lines = [f"sensor {name}: {kind}" for name, kind in self.sensors]
        lines += [f"left out by the default simulation: {line}" for line in self.left_out]
        return "\n".join([self.text, *(_native._visible(line, False) for line in lines)])

    @classmethod
    def _of(
        cls,
        data: Mapping[str, Any],
        text: str,
        groups: Sequence[str],
        left_out: Callable[[], Sequence[str]] | None = None,
        sensors: Sequence[Mapping[str, Any]] = (),
    ) -> LoadReport:
        findings = tuple(
            Finding(
                line=finding["line"],
                place=finding["place"],
                severity=finding["severity"],
                disposition=_disposition(finding["disposition"]),
                message=finding["message"],
            )
            for finding in data["findings"]
        )
        files = tuple(data.get("files", ()))
        named = tuple((sensor["name"], sensor["kind"]) for sensor in sensors)
        return cls(data["robot"], dict(data["counts"]), findings, text, files, tuple(groups), left_out, named)


def _disposition(data: str | Mapping[str, Any]) -> str:
    words = {"AsWritten": "taken as written"}
    if isinstance(data, str):
        return words.get(data, data.lower())
    (name, fields), *_ = data.items()
    return "ignored physics" if fields.get("physics") else words.get(name, name.lower())
