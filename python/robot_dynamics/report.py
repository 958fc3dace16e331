"""What became of every part of a robot file."""

from __future__ import annotations

from collections.abc import Callable, Mapping, Sequence
from dataclasses import dataclass, field
from functools import cached_property
from typing import Any

from robot_dynamics import _native


@dataclass(frozen=True)
class Finding:
    """One thing that the reader of a file has to say."""

    line: int
    """The file's line; 0 where it is about the whole file."""
    place: str
    """The element, for example ``link `hand```."""
    severity: str
    """``note``, ``warning`` or ``error``."""
    treatment: str
    """What was done: read, defaulted, taken as written, repaired, ignored, refused."""
    message: str
    """What was found."""

    def __str__(self) -> str:
        return _native._visible(f"line {self.line}: {self.place}: {self.message}", False)


@dataclass(frozen=True)
class LoadReport:
    """The reader's account of one file.

    >>> report = rd.example("two_r").report
    >>> report.robot, len(report.warnings)
    ('two_r', 0)
    """

    robot: str
    """The robot's name in the file."""
    counts: Mapping[str, int]
    """How many links, joints, findings of each kind."""
    findings: tuple[Finding, ...] = field(repr=False)
    """All findings, by line."""
    text: str = field(repr=False, compare=False)
    """The same in words."""
    files: tuple[str, ...] = field(default=(), repr=False, compare=False)
    """The files that the robot comes from: its own, included ones, attached models, meshes, height fields.
    None is written over."""

    grouped_warnings: tuple[str, ...] = field(default=(), repr=False, compare=False)
    """The warnings in words, those of one kind in one text, with their number and the first places; a
    `LoadWarning` each."""
    _left_out: Callable[[], Sequence[str]] | None = field(default=None, repr=False, compare=False)
    _sensors: tuple[tuple[str, str], ...] = field(default=(), repr=False, compare=False)

    @property
    def sensors(self) -> tuple[tuple[str, str], ...]:
        """The file's sensors: the name and the kind of each.

        >>> rd.example("two_r").report.sensors
        ()
        """
        return self._sensors

    @cached_property
    def left_out(self) -> tuple[str, ...]:
        """The features that the file states and the default simulation leaves out, one line for each reason.
        This sets up a simulation.

        >>> rd.example("quadruped").report.left_out
        ()
        """
        return () if self._left_out is None else tuple(self._left_out())

    @property
    def warnings(self) -> tuple[Finding, ...]:
        """What is suspicious, or physics that the model leaves out."""
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
                treatment=_treatment(finding["treatment"]),
                message=finding["message"],
            )
            for finding in data["findings"]
        )
        files = tuple(data.get("files", ()))
        named = tuple((sensor["name"], sensor["kind"]) for sensor in sensors)
        return cls(data["robot"], dict(data["counts"]), findings, text, files, tuple(groups), left_out, named)


def _treatment(data: str | Mapping[str, Any]) -> str:
    words = {"AsWritten": "taken as written"}
    if isinstance(data, str):
        return words.get(data, data.lower())
    (name, fields), *_ = data.items()
    return "ignored physics" if fields.get("physics") else words.get(name, name.lower())
