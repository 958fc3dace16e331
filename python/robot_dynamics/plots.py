"""Pictures of results, with matplotlib."""

from __future__ import annotations

from typing import TYPE_CHECKING, Any

from robot_dynamics import _native

if TYPE_CHECKING:
    from robot_dynamics.motion import Motion
    from robot_dynamics.planning import TimedPath


LEGENDS = 12
"""Most names in the legend of a picture; of more curves the first are named, with the number of the
others."""


def _axes(axes: Any, count: int) -> Any:
    if axes is not None:
        if len(axes) != count:
            raise ValueError(f"axes has {len(axes)} entries, this picture needs {count}")
        return axes
    try:
        from matplotlib import pyplot
    except ImportError as error:
        raise ImportError("plots need matplotlib: pip install robot-dynamics[plot]") from error
    _, axes = pyplot.subplots(count, 1, sharex=True, figsize=(9.0, 2.2 * count), layout="constrained")
    return axes


def _curves(axis: Any, times: Any, table: Any, names: tuple[str, ...], label: str) -> list[Any]:
    """A curve for each column, of ten colours in three styles; gives their colours."""
    drawn = []
    for k, (column, name) in enumerate(zip(table.T, names, strict=True)):
        (line,) = axis.plot(
            times, column, linewidth=1.0, color=f"C{k % 10}", linestyle=("-", "--", ":")[k // 10 % 3], label=_label(name)
        )
        drawn.append(line)
    axis.set_ylabel(label)
    axis.margins(x=0.0)
    return drawn


def _limits(axis: Any, lines: list[Any], limits: Any) -> None:
    """The position limits of each curve as thin lines of its colour, where they lie within twice the range of
    the curves."""
    low, high = axis.get_ylim()
    reach = max(high - low, 1e-9)
    for line, ends in zip(lines, limits, strict=True):
        for end in ends:
            if low - reach <= end <= high + reach:
                axis.axhline(end, color=line.get_color(), linewidth=0.8, linestyle=(0, (1, 3)))


def _label(name: str) -> str:
    """A name as matplotlib draws it: a dollar sign would begin a formula."""
    return _native._visible(name, False).replace("$", r"\$")


def _name_curves(axis: Any, lines: list[Any]) -> None:
    """The legend of an axis, beside it."""
    named = lines if len(lines) <= LEGENDS else lines[: LEGENDS - 1]
    title = f"the first {len(named)} of {len(lines)}" if len(named) < len(lines) else None
    axis.legend(
        handles=named, title=title, title_fontsize="x-small", fontsize="x-small", loc="upper left", bbox_to_anchor=(1.0, 1.0)
    )


def motion(of: Motion, axes: Any = None) -> Any:
    """Positions with their limits, velocities, torques, energies of a simulation."""
    axes = _axes(axes, 4)
    lines = _curves(axes[0], of.times, of.q, of.configuration_names, "q [rad or m]")
    if of.position_limits is not None:
        _limits(axes[0], lines, of.position_limits)
    _name_curves(axes[0], lines)
    lines = _curves(axes[1], of.times, of.v, of.coordinates, "v [rad/s or m/s]")
    if of.configuration_names != of.coordinates:
        _name_curves(axes[1], lines)
    _curves(axes[2], of.times, of.tau, of.coordinates, "τ [N·m or N]")
    energies = [("K", of.kinetic), ("V", of.potential), ("E = K + V", of.energy)]
    drawn = [axes[3].plot(of.times, values, linewidth=1.0, label=name)[0] for name, values in energies]
    axes[3].set_ylabel("energy [J]")
    _name_curves(axes[3], drawn)
    for event in of.events:
        for axis in axes:
            axis.axvline(event.time, color="0.5", linewidth=0.6, linestyle=":")
    axes[-1].set_xlabel("t [s]")
    return axes


def timed_path(of: TimedPath, axes: Any = None) -> Any:
    """Velocities and torques of a timed path."""
    axes = _axes(axes, 2)
    _name_curves(axes[0], _curves(axes[0], of.times, of.v, of.coordinates, "v [rad/s or m/s]"))
    _curves(axes[1], of.times, of.tau, of.coordinates, "τ [N·m or N]")
    axes[-1].set_xlabel("t [s]")
    return axes
