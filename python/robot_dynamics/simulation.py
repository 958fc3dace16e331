"""A simulation that is stepped from outside, with its state, its inputs and the results of each step."""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from os import PathLike
from typing import TYPE_CHECKING, Any, Literal, NamedTuple, Self

import numpy as np
from numpy.typing import NDArray

from robot_dynamics import _native
from robot_dynamics import ground as grounds
from robot_dynamics._native import Constraints
from robot_dynamics.errors import ShapeError
from robot_dynamics.ground import AnyGround
from robot_dynamics.motion import Correction, EnergyLedger, disabled_effects
from robot_dynamics.numbers import Numbers

if TYPE_CHECKING:
    from robot_dynamics.robot import Robot

Array = NDArray[np.float64]
Where = Sequence[int] | Sequence[bool] | NDArray[np.intp] | NDArray[np.bool_]
"""Which simulations of a batch: their numbers, or a truth value for each."""


class ContactPoint(NamedTuple):
    """A point where a shape touches a ground or another shape, at the end of a step."""

    link: str
    """The link that is touched."""
    shape: str
    """Its shape, empty where the file gives no name."""
    other_link: str | None
    """The other link; `None` for a ground."""
    other_shape: str
    """The other shape or the ground, by its name in the file."""
    ground: int | None
    """The number of the ground, height fields after the planes; `None` for a link."""
    point: Array
    """Where, in the world (3,) [m]."""
    normal: Array
    """Unit vector into `link`, in the world (3,)."""
    gap: float
    """Distance of the surfaces, negative where they overlap [m]."""
    force: Array
    """The force on `link`, along the world's axes (3,) [N]; the opposite acts on the other link."""
    moment: Array
    """The moment on `link` about `point`, along the world's axes (3,) [N·m]."""


class Simulation(_native.Simulation):
    """A robot in time, step by step.

    Everything that the robot's file states acts, as in `Robot.simulate`; `without` and `conservative` switch
    it off, `integrator` is chosen unless it is given. Inputs (`torques`, `controls`, wrenches) are held until
    they are set again. Stepped from outside it gives the bits of one run; ``integrator="adaptive"`` gives the
    same to its tolerance.

    >>> robot = rd.example("panda")
    >>> sim = rd.Simulation(robot, without=["limits"])
    >>> sim.reset(np.full(7, 0.1))
    >>> for _ in range(100):  # a controller of one's own
    ...     sim.torques = robot.gravity(sim.q) - 0.1 * sim.v
    ...     sim.step()
    >>> round(sim.time, 12), bool(np.abs(sim.q - 0.1).max() < 1e-9)
    (0.1, True)
    """

    def __new__(
        cls,
        robot: Robot,
        *,
        dt: float = 1e-3,
        integrator: str | None = None,
        conservative: bool = False,
        without: Sequence[str] = (),
        dissipation: bool = True,
        stops: bool = True,
        ground: AnyGround | None = None,
        constraints: Constraints | None = None,
        stabilization: float | None = None,
        correction: Correction = "position",
        tolerance: float | None = None,
        ignore_contacts: Sequence[tuple[str, str]] | str | PathLike[str] = (),
        only_contacts: Sequence[tuple[str, str]] | None = None,
    ) -> Self:
        """The simulation of a robot at rest in the configuration in which its file places it (`qpos0` of
        MJCF, else neutral).

        Links of the pairs in `ignore_contacts` never touch; it may be an SRDF file, whose
        ``<disable_collisions>`` are taken. With `only_contacts` these pairs of links alone may touch, beside
        grounds. `tolerance` (1e-9) is that of ``integrator="adaptive"``.

        >>> arm = rd.example("panda")
        >>> sim = rd.Simulation(arm, ignore_contacts=[("panda_link1", "panda_link3")])
        >>> rd.Simulation(arm, ignore_contacts=[("panda_link1", "link3")])
        Traceback (most recent call last):
        ...
        ValueError: robot `panda` has no link `link3`, which a pair of links names; did you mean `panda_link3`?
        """
        options = _options(
            robot,
            dt=dt,
            integrator=integrator,
            conservative=conservative,
            without=disabled_effects(without, dissipation, stops),
            ground=grounds.native(ground),
            constraints=constraints,
            stabilization=stabilization,
            correction=correction,
            tolerance=tolerance,
            ignore_contacts=ignore_contacts,
            only_contacts=only_contacts,
        )
        return super().__new__(cls, robot, **options)

    def reset(
        self,
        q: Numbers | None = None,
        v: Numbers | None = None,
        *,
        pose: str | None = None,
        controls: Mapping[str, float] | Numbers | None = None,
    ) -> None:
        """Starts anew at time 0 from q and v, as the file places the robot and at rest where not given, or
        from a `pose` of the file with its velocity and controls.

        Torques, controls and wrenches are zero afterwards, but for those given.
        """
        if pose is not None and (q is not None or v is not None):
            raise ValueError("give q and v, or the name of a pose")
        self._reset(q, v, pose)
        if controls is not None:
            self.controls = dict(controls) if isinstance(controls, Mapping) else np.asarray(controls, float)

    def apply_wrench(
        self,
        frame: str | int,
        force: Sequence[float] = (0.0, 0.0, 0.0),
        moment: Sequence[float] = (0.0, 0.0, 0.0),
        axes: Literal["local", "world", "local_world_aligned"] = "local_world_aligned",
    ) -> None:
        """Adds a force [N] and a moment [N·m] on the link that carries a frame, held until `clear_wrenches`.

        `axes` says along which axes and about which point: the frame's own at its origin, the world's at the
        world's origin, or, by default, the world's axes at the frame's origin.
        """
        self._apply_wrench(frame, tuple(map(float, force)), tuple(map(float, moment)), axes)

    @property
    def contacts(self) -> list[ContactPoint]:
        """The contacts at the end of the last step, with their forces."""
        return [ContactPoint(*fields) for fields in self._contacts()]

    @property
    def ledger(self) -> EnergyLedger:
        """The energy account since the last reset."""
        return EnergyLedger(**self._ledger())

    def copy(self) -> Self:
        """A simulation of its own in the same state."""
        return _native.Simulation.__new__(type(self), self.robot, like=self)

    def __repr__(self) -> str:
        return f"<Simulation of {self.robot.name}: t = {self.time:g} s, {self.method}, dt = {self.dt:g} s>"


class SimulationBatch(_native.SimulationBatch):
    """Many simulations of one robot, stepped together by all threads.

    Each has its own state, inputs and contacts and is set up once, so that a call of one step costs no more
    than a step of a long run. The results are those of `Simulation`, to the bit. Arguments are those of
    `Simulation`, and how many there are. `torques` and `controls` are held until they are set again: one row
    for each simulation, or one for all. `where` says which simulations are meant: their numbers, or a truth
    value for each. A simulation that fails stays where it was, the others go on, and the error afterwards has
    the messages of all that failed (`BadSimulationsError`).

    >>> dog = rd.example("quadruped", floating_base=True)
    >>> batch = rd.SimulationBatch(dog, 8, ground=rd.Ground())
    >>> q = np.tile([0, 0, 0.5, 0, 0, 0, 1, *[0, 0.7, -1.6] * 4], (8, 1))
    >>> q[:, 2] += 0.01 * np.arange(8)
    >>> batch.reset(q)
    >>> for _ in range(10):  # a policy of one's own
    ...     batch.torques = -0.1 * batch.v * (np.arange(18) > 5)
    ...     batch.step()
    >>> batch.reset(q[:2], where=[3, 5])
    >>> [round(time, 3) for time in batch.times[2:6]]
    [0.01, 0.0, 0.01, 0.0]
    """

    def __new__(
        cls,
        robot: Robot,
        count: int,
        *,
        dt: float = 1e-3,
        integrator: str | None = None,
        conservative: bool = False,
        without: Sequence[str] = (),
        dissipation: bool = True,
        stops: bool = True,
        ground: AnyGround | None = None,
        constraints: Constraints | None = None,
        stabilization: float | None = None,
        correction: Correction = "position",
        tolerance: float | None = None,
        ignore_contacts: Sequence[tuple[str, str]] | str | PathLike[str] = (),
        only_contacts: Sequence[tuple[str, str]] | None = None,
        threads: int | None = None,
    ) -> Self:
        """So many simulations of a robot, at rest in the configuration in which its file places it."""
        options = _options(
            robot,
            dt=dt,
            integrator=integrator,
            conservative=conservative,
            without=disabled_effects(without, dissipation, stops),
            ground=grounds.native(ground),
            constraints=constraints,
            stabilization=stabilization,
            correction=correction,
            tolerance=tolerance,
            ignore_contacts=ignore_contacts,
            only_contacts=only_contacts,
        )
        return super().__new__(cls, robot, count, threads, **options)

    def step(self, count: int = 1, *, where: Where | None = None) -> None:
        """Takes so many steps of each simulation, or of those of `where`, on all threads.

        A simulation that cannot go on stays where its last good step ended, the others take all steps.
        """
        self._step(count, None if where is None else self._numbers(where))

    def reset(self, q: Numbers | None = None, v: Numbers | None = None, *, where: Where | None = None) -> None:
        """Starts anew at time 0 from q and v, as the file places the robot and at rest where not given, all
        simulations or those of `where`.

        q is (count, nq), or (nq,) for all of them; v as well. Torques, controls and wrenches of these are
        zero afterwards.
        """
        self._reset(q, v, None if where is None else self._numbers(where))

    def set_state(self, q: Numbers, v: Numbers, *, where: Where | None = None) -> None:
        """Goes on from q and v, rows as of `reset`, at the same times with the same inputs: all simulations,
        or those of `where`.

        The energy accounts begin anew.

        >>> batch = rd.SimulationBatch(rd.example("two_r"), 3)
        >>> batch.step(5)
        >>> batch.set_state([0.1, 0.2], [0.0, 0.0], where=[False, True, False])
        >>> batch.q[1].tolist(), round(batch.times[1], 3)
        ([0.1, 0.2], 0.005)
        """
        self._set_state(q, v, None if where is None else self._numbers(where))

    def __getitem__(self, number: int) -> Simulation:
        """A copy of one simulation, with its state and inputs."""
        copy = self._copy(number)
        return _native.Simulation.__new__(Simulation, copy.robot, like=copy)

    def _numbers(self, where: Where) -> list[int]:
        given = np.asarray(where)
        if given.dtype == bool:
            if given.shape != (len(self),):
                raise ShapeError(f"where has shape {given.shape}, truth values must have ({len(self)},)")
            given = np.flatnonzero(given)
        elif given.ndim != 1 or (given.size > 0 and given.dtype.kind not in "iu"):
            raise TypeError(f"where is {where!r}; it must be a sequence of simulations' numbers, or a truth value for each")
        return [int(number) for number in given.tolist()]


def _options(
    robot: Robot,
    *,
    integrator: str | None,
    tolerance: float | None,
    ignore_contacts: Sequence[tuple[str, str]] | str | PathLike[str],
    only_contacts: Sequence[tuple[str, str]] | None,
    **others: Any,
) -> dict[str, Any]:
    """The arguments of the native half."""
    if tolerance is not None and integrator != "adaptive":
        raise ValueError(f"tolerance goes with integrator='adaptive'; {integrator or 'the default'!r} takes steps of one length")
    if isinstance(ignore_contacts, str | PathLike):
        ignore_contacts = robot._disabled_collisions(ignore_contacts)
    return {
        **others,
        "integrator": integrator,
        "tolerance": tolerance,
        "ignore_contacts": list(ignore_contacts),
        "only_contacts": None if only_contacts is None else list(only_contacts),
    }


__all__ = ["ContactPoint", "Simulation", "SimulationBatch"]
