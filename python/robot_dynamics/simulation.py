"""Simulations that are advanced step by step, with their state, their inputs and the results of each step."""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from os import PathLike
from typing import TYPE_CHECKING, Literal, NamedTuple, Self

import numpy as np
from numpy.typing import NDArray

from robot_dynamics import _native, defaults
from robot_dynamics import ground as grounds
from robot_dynamics._native import Constraints
from robot_dynamics.errors import ShapeError
from robot_dynamics.ground import AnyGround
from robot_dynamics.motion import Correction, EnergyAccount, disabled_effects
from robot_dynamics.numbers import Numbers

if TYPE_CHECKING:
    from robot_dynamics.robot import Robot

Array = NDArray[np.float64]
Where = Sequence[int] | Sequence[bool] | NDArray[np.intp] | NDArray[np.bool_]
"""Selection of simulations of a batch: their numbers, or a mask."""


class ContactPoint(NamedTuple):
    """Contact of a shape with the ground or another shape, at the end of a step."""

    link: str
    """Name of the link."""
    shape: str
    """Name of its shape; empty if the file gives none."""
    other_link: str | None
    """Name of the other link; `None` for the ground."""
    other_shape: str
    """Name of the other shape or of the ground in the file."""
    ground: int | None
    """Number of the ground, with height fields after the planes; `None` for a link."""
    point: Array
    """Contact point in the world (3,) [m]."""
    normal: Array
    """Unit normal into `link`, in the world (3,)."""
    gap: float
    """Distance of the surfaces [m], negative if they overlap."""
    force: Array
    """Force on `link`, along the world's axes (3,) [N]. The opposite force acts on the other link."""
    moment: Array
    """Moment on `link` about `point`, along the world's axes (3,) [N·m]."""


class Simulation(_native.Simulation):
    """Simulation of one robot, advanced step by step.

    Everything that the robot's file states acts, as in `Robot.simulate`. Inputs (`torques`, `controls`,
    wrenches) are held until they are set again. Single steps give the same bits as one run. With
    ``integrator="adaptive"`` they agree within the tolerance.

    >>> robot = rd.example("panda")
    >>> sim = rd.Simulation(robot, without=["limits"])
    >>> sim.reset(np.full(7, 0.1))
    >>> for _ in range(100):  # your own controller
    ...     sim.torques = robot.gravity(sim.q) - 0.1 * sim.v
    ...     sim.step()
    >>> round(sim.time, 12), bool(np.abs(sim.q - 0.1).max() < 1e-9)
    (0.1, True)
    """

    def __new__(
        cls,
        robot: Robot,
        *,
        dt: float = defaults.DT,
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
        """Create the simulation of a robot at rest in its initial configuration.

        This is `qpos0` of MJCF, or else the neutral configuration.

        Parameters
        ----------
        robot : Robot
            Robot to simulate.
        dt : float
            Step size [s].
        integrator : str, optional
            Method; see `Robot.simulate`.
        conservative : bool
            Whether to leave out damping, friction, limits, actuators and contact.
        without : sequence of str
            Effects to leave out; see `Robot.simulate`.
        dissipation : bool
            Whether damping and friction act.
        stops : bool
            Whether position limits act.
        ground : Ground, HeightField or "file", optional
            Ground below the robot; see `Robot.simulate`.
        constraints : Constraints, optional
            Constraints that replace the equalities of the file.
        stabilization : float, optional
            Rate γ of Baumgarte's stabilization of `constraints` [1/s].
        correction : {"none", "velocity", "position"}
            Errors that an explicit method projects away after each step under constraints.
        tolerance : float, optional
            Local error that ``adaptive`` steps allow, relative and absolute; default: 1e-9.
        ignore_contacts : sequence of (str, str) or path
            Pairs of links that never touch, or an SRDF file with ``<disable_collisions>``.
        only_contacts : sequence of (str, str), optional
            Pairs of links that may touch; others touch only the ground. Default: all pairs.

        Returns
        -------
        Simulation
            The simulation.

        Raises
        ------
        SimulationError
            The integrator or the step is invalid.
        ValueError
            An option is invalid, or a link does not exist.

        Examples
        --------
        >>> arm = rd.example("panda")
        >>> sim = rd.Simulation(arm, ignore_contacts=[("panda_link1", "panda_link3")])
        >>> try:
        ...     rd.Simulation(arm, ignore_contacts=[("panda_link1", "link3")])
        ... except rd.SimulationInputError as error:
        ...     print(error)
        a pair of links is invalid: robot `panda` has no link `link3`; did you mean `panda_link3`?
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
        """Restart at time 0 from a state or a named pose.

        Torques, controls and wrenches become zero, except those of the pose or of `controls`.

        Parameters
        ----------
        q : array_like, shape (nq,), optional
            Configuration; default: the initial one of the file.
        v : array_like, shape (nv,), optional
            Velocity [rad/s or m/s]; default: 0.
        pose : str, optional
            Name of a pose of the file, with its velocity and controls; instead of `q` and `v`.
        controls : mapping of str to float, or array_like, shape (actuators,), optional
            Controls of the actuators.

        Raises
        ------
        StateError
            `q` or `v` is invalid.
        SimulationError
            The pose does not exist, or the simulation cannot start there.
        ValueError
            `pose` is given together with `q` or `v`.
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
        """Add a force and a moment on the link that carries a frame, held until `clear_wrenches`.

        Parameters
        ----------
        frame : str or int
            Name or number of the frame.
        force : sequence of float, shape (3,)
            Force [N].
        moment : sequence of float, shape (3,)
            Moment [N·m].
        axes : {"local_world_aligned", "local", "world"}
            Axes and reference point: the world's axes at the frame's origin, the frame's axes at its origin,
            or the world's axes at the world's origin.

        Raises
        ------
        FrameError
            The frame does not exist.
        ValueError
            `axes` is invalid.
        """
        self._apply_wrench(frame, tuple(map(float, force)), tuple(map(float, moment)), axes)

    @property
    def contacts(self) -> list[ContactPoint]:
        """Contacts at the end of the last step, with their forces."""
        return [ContactPoint(*fields) for fields in self._contacts()]

    @property
    def energy_account(self) -> EnergyAccount:
        """Energy account since the last reset."""
        return EnergyAccount(**self._energy_account())

    def copy(self) -> Self:
        """Copy of the simulation with the same state and inputs.

        Returns
        -------
        Simulation
            Independent copy.
        """
        return _native.Simulation.__new__(type(self), self.robot, like=self)

    def __repr__(self) -> str:
        return f"<Simulation of {self.robot.name}: t = {self.time:g} s, {self.method}, dt = {self.dt:g} s>"


class SimulationBatch(_native.SimulationBatch):
    """Simulations of one robot that step together, on all threads.

    Each simulation has its own state, inputs and contacts. It is set up once, so single steps cost no more
    than those of a long run. The results have the same bits as those of `Simulation`.

    `torques` and `controls` are held until they are set again. They have one row for each simulation, or one
    for all. `where` selects simulations by their numbers or by a mask.

    A simulation that fails stays at its last state, and the others continue. Then `BadSimulationsError` has
    the messages of all that failed.

    >>> dog = rd.example("quadruped", floating_base=True)
    >>> batch = rd.SimulationBatch(dog, 8, ground=rd.Ground())
    >>> q = np.tile([0, 0, 0.5, 0, 0, 0, 1, *[0, 0.7, -1.6] * 4], (8, 1))
    >>> q[:, 2] += 0.01 * np.arange(8)
    >>> batch.reset(q)
    >>> for _ in range(10):  # your own policy
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
        dt: float = defaults.DT,
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
        variants: Sequence[tuple[Robot, AnyGround | None]] = (),
    ) -> Self:
        """Create simulations of a robot at rest in its initial configuration.

        Parameters
        ----------
        robot : Robot
            Robot to simulate.
        count : int
            Number of simulations.
        dt : float
            Step size [s].
        integrator : str, optional
            Method; see `Robot.simulate`.
        conservative : bool
            Whether to leave out damping, friction, limits, actuators and contact.
        without : sequence of str
            Effects to leave out; see `Robot.simulate`.
        dissipation : bool
            Whether damping and friction act.
        stops : bool
            Whether position limits act.
        ground : Ground, HeightField or "file", optional
            Ground below the robot; see `Robot.simulate`.
        constraints : Constraints, optional
            Constraints that replace the equalities of the file.
        stabilization : float, optional
            Rate γ of Baumgarte's stabilization of `constraints` [1/s].
        correction : {"none", "velocity", "position"}
            Errors that an explicit method projects away after each step under constraints.
        tolerance : float, optional
            Local error that ``adaptive`` steps allow, relative and absolute; default: 1e-9.
        ignore_contacts : sequence of (str, str) or path
            Pairs of links that never touch, or an SRDF file with ``<disable_collisions>``.
        only_contacts : sequence of (str, str), optional
            Pairs of links that may touch; others touch only the ground. Default: all pairs.
        threads : int, optional
            Threads for a batch; default: `num_threads()`.
        variants : sequence of (Robot, Ground or HeightField or "file" or None), optional
            Robots with the same joints and actuators, which may differ in other properties such as masses,
            and their grounds. Simulation k has variant k modulo their number. They replace `robot` and
            `ground`.

        Returns
        -------
        SimulationBatch
            The simulations.

        Raises
        ------
        SimulationError
            The integrator or the step is invalid.
        SimulationInputError
            Two variants differ in their joints or actuators.
        ValueError
            An option is invalid, or a link does not exist.
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
        kinds = [(own, grounds.native(below)) for own, below in variants]
        return super().__new__(cls, robot, count, threads, kinds, **options)

    if TYPE_CHECKING:

        @property
        def robot(self) -> Robot: ...

    def step(self, count: int = 1, *, where: Where | None = None) -> None:
        """Take steps of all or of selected simulations, on all threads.

        A simulation that fails stays at its last valid state, and the others take all steps.

        Parameters
        ----------
        count : int
            Number of steps.
        where : sequence of int or of bool, optional
            Simulations to step; default: all.

        Raises
        ------
        BadSimulationsError
            Some simulations failed.
        IndexError
            A simulation does not exist.
        """
        self._step(count, None if where is None else self._numbers(where))

    def reset(self, q: Numbers | None = None, v: Numbers | None = None, *, where: Where | None = None) -> None:
        """Restart all or selected simulations at time 0.

        Their torques, controls and wrenches become zero.

        Parameters
        ----------
        q : array_like, shape (simulations, nq) or (nq,), optional
            Configurations; default: the initial one of the file.
        v : array_like, shape (simulations, nv) or (nv,), optional
            Velocities [rad/s or m/s]; default: 0.
        where : sequence of int or of bool, optional
            Simulations to restart; default: all.

        Raises
        ------
        BadSimulationsError
            Some states are invalid.
        IndexError
            A simulation does not exist.
        ShapeError
            An array has the wrong shape.
        """
        self._reset(q, v, None if where is None else self._numbers(where))

    def set_state(self, q: Numbers, v: Numbers, *, where: Where | None = None) -> None:
        """Continue all or selected simulations from other states, at the same times and with the same inputs.

        The energy accounts restart.

        Parameters
        ----------
        q : array_like, shape (simulations, nq) or (nq,)
            Configurations.
        v : array_like, shape (simulations, nv) or (nv,)
            Velocities [rad/s or m/s].
        where : sequence of int or of bool, optional
            Simulations to change; default: all.

        Raises
        ------
        BadSimulationsError
            Some states are invalid.
        IndexError
            A simulation does not exist.
        ShapeError
            An array has the wrong shape.

        Examples
        --------
        >>> batch = rd.SimulationBatch(rd.example("two_r"), 3)
        >>> batch.step(5)
        >>> batch.set_state([0.1, 0.2], [0.0, 0.0], where=[False, True, False])
        >>> batch.q[1].tolist(), round(batch.times[1], 3)
        ([0.1, 0.2], 0.005)
        """
        self._set_state(q, v, None if where is None else self._numbers(where))

    def set_position_control(
        self,
        stiffness: Numbers,
        damping: Numbers,
        *,
        limits: Numbers = np.inf,
        delay: int | Sequence[int] | NDArray[np.int64] = 0,
    ) -> None:
        """Control the positions of joints towards `targets`, with torques that each step evaluates again.

        Each step begins with τ = stiffness (target − q) − damping v, cut off at ±limits. This is added to
        `torques`, and the effort limits of the robot act on the sum. A restart by `reset` makes the
        configuration the target.

        Parameters
        ----------
        stiffness : float or array_like, shape (simulations, nv) or (nv,)
            Stiffness [N·m/rad or N/m]. It must be 0 for degrees of freedom of joints that have several, such
            as a floating base; a single number applies to all others.
        damping : float or array_like, shape (simulations, nv) or (nv,)
            Damping [N·m·s/rad or N·s/m]; as `stiffness`.
        limits : float or array_like, shape (simulations, nv) or (nv,)
            Largest torques of this control [N·m or N]; default: infinite.
        delay : int or sequence of int, shape (simulations,)
            Steps after which new targets act; until then the targets before them act. It is at most the
            number of steps between two assignments of `targets`.

        Raises
        ------
        SimulationInputError
            A gain or a limit is invalid.
        ShapeError
            An array has the wrong shape.

        Examples
        --------
        >>> batch = rd.SimulationBatch(rd.example("two_r"), 2, conservative=True)
        >>> batch.set_position_control(stiffness=200.0, damping=[40.0, 20.0])
        >>> batch.targets = [[0.5, 0.2], [-0.5, 0.1]]
        >>> batch.step(5000)
        >>> sag = (batch.targets - batch.q) * 200.0  # at rest the springs carry the weight
        >>> np.allclose(sag, batch.robot.gravity(batch.q), atol=1e-6)
        True
        """
        moved = np.zeros(self.robot.nv)
        for joint in self.robot.joints:
            if joint.v.stop - joint.v.start == 1:
                moved[joint.v] = 1.0
        given = [np.asarray(table, np.float64) for table in (stiffness, damping)]
        tables = [moved * table if table.ndim == 0 else table for table in given]
        most = np.asarray(limits, np.float64)
        if most.ndim == 0:
            most = np.full(self.robot.nv, most)
        delays = np.broadcast_to(np.asarray(delay), len(self))
        if delays.dtype.kind not in "iu" or (delays < 0).any():
            raise ValueError(f"delay is {delay!r}; it must be whole numbers of steps, at least 0")
        self._set_gains(tables[0], tables[1], most, delays.tolist())

    def set_wrenches(
        self,
        wrenches: Mapping[str, Numbers],
        axes: Literal["local", "world", "local_world_aligned"] = "local_world_aligned",
    ) -> None:
        """Set the forces and moments on frames, which replace earlier ones and are held until they are set
        again.

        Parameters
        ----------
        wrenches : mapping of str to array_like, shape (simulations, 6) or (6,)
            Force [N], then moment [N·m], on the link that carries each frame.
        axes : {"local_world_aligned", "local", "world"}
            Axes and reference point; see `Simulation.apply_wrench`.

        Raises
        ------
        FrameError
            A frame does not exist.
        ShapeError
            An array has the wrong shape.
        ValueError
            `axes` is invalid.
        """
        table = [np.broadcast_to(np.asarray(wrench, np.float64), (len(self), 6)) for wrench in wrenches.values()]
        self._set_wrenches(list(wrenches), np.concatenate([np.empty((len(self), 0)), *table], axis=1), axes)

    def contact_forces(self, links: Sequence[str]) -> NDArray[np.float64]:
        """Sum of the contact forces on links at the end of the last step, along the world's axes.

        Parameters
        ----------
        links : sequence of str
            Names of links, as in `Simulation.contacts`.

        Returns
        -------
        ndarray, shape (simulations, links, 3)
            Forces of the grounds and of other links [N].

        Raises
        ------
        ValueError
            A link does not exist.

        Examples
        --------
        >>> dog = rd.example("quadruped", floating_base=True)
        >>> batch = rd.SimulationBatch(dog, 2, ground=rd.Ground(), integrator="mujoco")
        >>> batch.reset([0, 0, 0.35, 0, 0, 0, 1, *[0, 0.7, -1.6] * 4])
        >>> batch.step(500)
        >>> feet = [name for name in dog.link_names if name.endswith("foot")]
        >>> batch.contact_forces(feet).shape
        (2, 4, 3)
        """
        unknown = [link for link in links if link not in self.robot.link_names]
        if unknown:
            raise ValueError(f"robot `{self.robot.name}` has no link {unknown[0]!r}; it has {', '.join(self.robot.link_names)}")
        return self._contact_forces(list(links))

    @property
    def sensors(self) -> dict[str, NDArray[np.float64]]:
        """Values of the robot's sensors (simulations, size) by name, at the end of the last step."""
        values, shown, at = self._sensors(), {}, 0
        for name, _, size in self.robot._sensors():
            shown[name] = values[:, at : at + size]
            at += size
        return shown

    def __getitem__(self, number: int) -> Simulation:
        """Copy of one simulation, with its state and inputs.

        Parameters
        ----------
        number : int
            Number of the simulation.

        Returns
        -------
        Simulation
            Independent copy.

        Raises
        ------
        IndexError
            The simulation does not exist.
        """
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
    **others: object,
) -> dict[str, object]:
    """Arguments of the compiled module."""
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
