"""Checks of the laws of mechanics on one robot."""

from __future__ import annotations

from dataclasses import dataclass
from typing import TYPE_CHECKING

from robot_dynamics import _native, defaults
from robot_dynamics._native import _html as escape

if TYPE_CHECKING:
    from robot_dynamics.robot import Robot


@dataclass(frozen=True)
class Check:
    """One law, checked on one robot by two independent computations."""

    name: str
    """Name of the check."""
    law: str
    """The law in words."""
    found: float
    """Worst value found."""
    relation: str
    """Required relation of `found` to `allowed`: ``<=`` or ``>=``."""
    allowed: float
    """Bound that allows for rounding."""
    holds: bool
    """Whether the law holds."""
    place: str
    """Place of the worst value."""


@dataclass(frozen=True)
class Audit:
    """All checks of a robot.

    `repr` is a table of the checks. The audit is true if all laws hold.

    >>> audit = rd.example("two_r").audit()
    >>> bool(audit)
    True
    """

    checks: tuple[Check, ...]
    """The checks, in their order."""

    @property
    def short(self) -> tuple[Check, ...]:
        """Checks whose law does not hold."""
        return tuple(check for check in self.checks if not check.holds)

    def __bool__(self) -> bool:
        return not self.short

    def _rows(self) -> list[tuple[str, str, str, str, str]]:
        return [
            (
                _native._visible(check.law, False),
                f"{check.found:.1e}",
                f"{check.relation} {check.allowed:.1e}",
                "ok" if check.holds else "SHORT",
                _native._visible(check.place, False),
            )
            for check in self.checks
        ]

    def __repr__(self) -> str:
        rows = [("check", "worst found", "allowed", "verdict", "where"), *self._rows()]
        widths = [max(len(row[k]) for row in rows) for k in range(5)]
        lines = [
            f"{law:<{widths[0]}}  {found:>{widths[1]}}  {allowed:>{widths[2]}}  {verdict:<{widths[3]}}  {place}".rstrip()
            for law, found, allowed, verdict, place in rows
        ]
        end = "Nothing falls short." if self else f"{len(self.short)} fall short."
        return "\n".join([*lines, "", end])

    def _repr_html_(self) -> str:
        head = "".join(f"<th>{name}</th>" for name in ("check", "worst found", "allowed", "verdict", "where"))
        rows = "".join(
            "<tr>" + "".join(f"<td>{escape(cell)}</td>" for cell in row) + "</tr>" for row in self._rows()
        )
        return f"<table style=\"white-space: nowrap; text-align: left\"><thead><tr>{head}</tr></thead><tbody>{rows}</tbody></table>"


def audit(robot: Robot, *, states: int = defaults.AUDIT_STATES, seed: int = defaults.AUDIT_SEED) -> Audit:
    """Check each law of mechanics on this robot in random states, by two independent computations.

    Parameters
    ----------
    states : int
        Number of random states.
    seed : int
        Seed of the random states.

    Returns
    -------
    Audit
        All checks.

    Examples
    --------
    >>> [check.name for check in rd.example("two_r").audit().checks][:2]
    ['inertia_triangle', 'mass_matrix']
    """
    return Audit(tuple(Check(*check) for check in robot._audit(states, seed)))


def suspicions(robot: Robot) -> tuple[str, ...]:
    """Find numbers that look like a wrong unit.

    Angles in degrees are found only in a robot that was just read from a file.

    Returns
    -------
    tuple of str
        Descriptions of the numbers.

    Examples
    --------
    >>> rd.example("panda").suspicions()
    ()
    """
    return tuple(robot._suspicions())
