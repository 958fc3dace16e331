"""Plots of results, with matplotlib."""

from __future__ import annotations

from typing import TYPE_CHECKING, Any

from robot_dynamics import _native

if TYPE_CHECKING:
    from robot_dynamics.motion import Motion
    from robot_dynamics.planning import TimedPath


LONGEST_LEGEND = 12
"""Most names in a legend; of more curves the legend names the first and states the total."""


def _make_axes(axes: Any, count: int) -> Any:
    """Given axes, or those of a new figure."""
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


def _draw_curves(axis: Any, times: Any, table: Any, names: tuple[str, ...], label: str) -> list[Any]:
    """Draw a curve for each column, in ten colours and three line styles; returns the lines."""
    drawn = []
    for k, (column, name) in enumerate(zip(table.T, names, strict=True)):
        (line,) = axis.plot(
            times, column, linewidth=1.0, color=f"C{k % 10}", linestyle=("-", "--", ":")[k // 10 % 3], label=_label(name)
        )
        drawn.append(line)
    axis.set_ylabel(label)
    axis.margins(x=0.0)
    return drawn


def _draw_limits(axis: Any, lines: list[Any], limits: Any) -> None:
    """Draw the position limits of each curve as thin lines of its colour.

    Limits farther from the curves than their range are left out.
    """
    low, high = axis.get_ylim()
    reach = max(high - low, 1e-9)
    for line, ends in zip(lines, limits, strict=True):
        for end in ends:
            if low - reach <= end <= high + reach:
                axis.axhline(end, color=line.get_color(), linewidth=0.8, linestyle=(0, (1, 3)))


def _label(name: str) -> str:
    """Name with dollar signs escaped, which would start a formula in matplotlib."""
    return _native._visible(name, False).replace("$", r"\$")


def _add_legend(axis: Any, lines: list[Any]) -> None:
    """Add the legend beside an axis."""
    named = lines if len(lines) <= LONGEST_LEGEND else lines[: LONGEST_LEGEND - 1]
    title = f"the first {len(named)} of {len(lines)}" if len(named) < len(lines) else None
    axis.legend(
        handles=named, title=title, title_fontsize="x-small", fontsize="x-small", loc="upper left", bbox_to_anchor=(1.0, 1.0)
    )


def plot_motion(motion: Motion, axes: Any = None) -> Any:
    """Plot positions with their limits, velocities, torques and energies of a simulation; see `Motion.plot`.

    Parameters
    ----------
    motion : Motion
        Motion to plot.
    axes : sequence of 4 matplotlib axes, optional
        Axes to draw on; default: those of a new figure.

    Returns
    -------
    sequence of matplotlib axes
        One for each of the four plots.

    Raises
    ------
    ImportError
        matplotlib is missing.
    ValueError
        `axes` does not have four entries.
    """
    axes = _make_axes(axes, 4)
    lines = _draw_curves(axes[0], motion.times, motion.q, motion.configuration_names, "q [rad or m]")
    if motion.position_limits is not None:
        _draw_limits(axes[0], lines, motion.position_limits)
    _add_legend(axes[0], lines)
    lines = _draw_curves(axes[1], motion.times, motion.v, motion.coordinates, "v [rad/s or m/s]")
    if motion.configuration_names != motion.coordinates:
        _add_legend(axes[1], lines)
    _draw_curves(axes[2], motion.times, motion.tau, motion.coordinates, "τ [N·m or N]")
    energies = [("K", motion.kinetic), ("V", motion.potential), ("E = K + V", motion.energy)]
    drawn = [axes[3].plot(motion.times, values, linewidth=1.0, label=name)[0] for name, values in energies]
    axes[3].set_ylabel("energy [J]")
    _add_legend(axes[3], drawn)
    for event in motion.events:
        for axis in axes:
            axis.axvline(event.time, color="0.5", linewidth=0.6, linestyle=":")
    axes[-1].set_xlabel("t [s]")
    return axes


def plot_timed_path(path: TimedPath, axes: Any = None) -> Any:
    """Plot velocities and torques of a timed path; see `TimedPath.plot`.

    Parameters
    ----------
    path : TimedPath
        Path to plot.
    axes : sequence of 2 matplotlib axes, optional
        Axes to draw on; default: those of a new figure.

    Returns
    -------
    sequence of matplotlib axes
        One for each of the two plots.

    Raises
    ------
    ImportError
        matplotlib is missing.
    ValueError
        `axes` does not have two entries.
    """
    axes = _make_axes(axes, 2)
    _add_legend(axes[0], _draw_curves(axes[0], path.times, path.v, path.coordinates, "v [rad/s or m/s]"))
    _draw_curves(axes[1], path.times, path.tau, path.coordinates, "τ [N·m or N]")
    axes[-1].set_xlabel("t [s]")
    return axes
