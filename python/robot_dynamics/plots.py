"""Pictures of results, with matplotlib."""

from __future__ import annotations

from typing import TYPE_CHECKING, Any

from robot_dynamics import _native

if TYPE_CHECKING:
    from robot_dynamics.motion import Motion
    from robot_dynamics.planning import TimedPath


def _axes(axes: Any, count: int) -> Any:
    if axes is not None:
        if len(axes) != count:
            raise ValueError(f"axes has {len(axes)} entries, this picture needs {count}")
        return axes
    try:
        from matplotlib import pyplot
    except ImportError as error:
        raise ImportError("plots need matplotlib: pip install robot-dynamics[plot]") from error
    _, axes = pyplot.subplots(count, 1, sharex=True, figsize=(7.0, 2.2 * count), layout="constrained")
    return axes


def _coordinates(axis: Any, times: Any, table: Any, names: tuple[str, ...], label: str) -> None:
    for column, name in zip(table.T, names, strict=True):
        axis.plot(times, column, linewidth=1.0, label=_label(name))
    axis.set_ylabel(label)
    axis.margins(x=0.0)


def _label(name: str) -> str:
    """A name as matplotlib draws it: a dollar sign would begin a formula."""
    return _native._visible(name, False).replace("$", r"\$")


def _finish(axes: Any, names: tuple[str, ...]) -> Any:
    axes[-1].set_xlabel("t [s]")
    if len(names) <= 12:
        axes[0].legend(fontsize="x-small", ncols=min(5, len(names)), loc="lower center", bbox_to_anchor=(0.5, 1.0))
    return axes


def motion(of: Motion, axes: Any = None) -> Any:
    """Velocities, torques, energies of a simulation."""
    axes = _axes(axes, 3)
    _coordinates(axes[0], of.times, of.v, of.coordinates, "v [rad/s or m/s]")
    _coordinates(axes[1], of.times, of.tau, of.coordinates, "τ [N·m or N]")
    for name, values in (("K", of.kinetic), ("V", of.potential), ("E = K + V", of.energy)):
        axes[2].plot(of.times, values, linewidth=1.0, label=name)
    axes[2].set_ylabel("energy [J]")
    axes[2].legend(fontsize="x-small", ncols=3)
    for event in of.events:
        for axis in axes:
            axis.axvline(event.time, color="0.5", linewidth=0.6, linestyle=":")
    return _finish(axes, of.coordinates)


def timed_path(of: TimedPath, axes: Any = None) -> Any:
    """Velocities and torques of a timed path."""
    axes = _axes(axes, 2)
    _coordinates(axes[0], of.times, of.v, of.coordinates, "v [rad/s or m/s]")
    _coordinates(axes[1], of.times, of.tau, of.coordinates, "τ [N·m or N]")
    return _finish(axes, of.coordinates)
