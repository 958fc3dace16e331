"""Motions in time: simulations with their energy ledger, rollouts of many states, one step and its slopes."""

from __future__ import annotations

from collections.abc import Callable, Mapping, Sequence
from dataclasses import dataclass, field
from typing import TYPE_CHECKING, Any, Literal, NamedTuple, TypeAlias, TypedDict

import numpy as np
from numpy.typing import NDArray

from robot_dynamics import ground as grounds
from robot_dynamics._native import Constraints
from robot_dynamics.errors import BadStatesError, SimulationError
from robot_dynamics.ground import AnyGround
from robot_dynamics.numbers import Numbers

if TYPE_CHECKING:
    from robot_dynamics.robot import Robot

Array: TypeAlias = NDArray[np.float64]
Correction: TypeAlias = Literal["none", "velocity", "position"]
"""The quantities that an explicit row projects after each step under constraints."""
Controller: TypeAlias = Callable[[float, Array, Array], Numbers]
"""τ of (t, q, v)."""


@dataclass(frozen=True)
class Event:
    """Something to look out for during a simulation: a function of (t, q, v) that becomes 0."""

    name: str
    function: Callable[[float, Array, Array], float]
    direction: Literal["both", "rising", "falling"] = "both"
    terminal: bool = False
    """Whether the motion ends there."""


class Occurrence(NamedTuple):
    """An event that happened."""

    name: str
    time: float
    """[s]"""
    rising: bool
    q: Array
    v: Array


@dataclass(frozen=True)
class EnergyLedger:
    """The books of the energy, at the end of a motion [J]: start + work − dissipated = kinetic +
    potential."""

    start: float
    """E when it began."""
    kinetic: float
    potential: float
    work: float
    """What the motors did."""
    dissipated: float
    """What damping and friction took."""
    imbalance: float
    """By how much the books do not balance: the error of the method."""
    max_imbalance: float
    """The largest on the way."""
    energy_moved: float
    """max K + max V − min V, or what the motors did or damping took where that is more."""
    relative_imbalance: float
    """max_imbalance over energy_moved: the relative error of any motion."""
    drift: float
    """max |E − E₀| over |E₀| (max K where E₀ is 0) of a conservative motion; NaN where motors or damping
    acted, as E then changes."""


class Losses(TypedDict):
    """Energy that left a motion, by cause [J]."""

    damping: float
    friction: float
    stops: float
    corrections: float
    """By moving back what began beyond a stop or within another shape; negative where that put energy in."""
    sliding: float
    impacts: float


class StepStatistics(NamedTuple):
    """What the steps of an adaptive motion were."""

    accepted: int
    """Steps taken."""
    rejected: int
    """Steps tried and taken back, as their error was too large."""
    evaluations: int
    """Of the forward dynamics."""
    shortest: float
    """The shortest step [s]."""
    longest: float
    """The longest [s]."""
    quaternion_error: float
    """The largest | |quaternion| − 1 | at the ends of steps, before q was normalised."""


@dataclass(frozen=True)
class Motion:
    """A motion, sample by sample.

    >>> motion = rd.example("two_r").simulate([0.0, 0.0], duration=1.0)
    >>> motion.q.shape, motion.ledger.drift < 1e-9
    ((1001, 2), True)
    """

    times: Array = field(repr=False)
    """(samples,) [s]"""
    q: Array = field(repr=False)
    """(samples, nq)"""
    v: Array = field(repr=False)
    """(samples, nv)"""
    tau: Array = field(repr=False)
    """(samples, nv): the torques from each sample on, within the effort limits, with those of actuators [N·m
    or N]"""
    kinetic: Array = field(repr=False)
    """(samples,) [J]"""
    potential: Array = field(repr=False)
    """(samples,) [J]"""
    ledger: EnergyLedger
    peak_torque: Array = field(repr=False)
    """(nv,): the largest |τ| of each coordinate over all steps [N·m or N]"""
    events: tuple[Occurrence, ...]
    steps: int
    """Steps taken."""
    ended_by_event: bool
    position_drift: float | None = None
    """Under constraints: the largest |φ| [m or rad]."""
    velocity_drift: float | None = None
    """Under constraints: the largest |A v| [m/s or rad/s]."""
    energy_removed: float | None = None
    """Under constraints: what corrections of drift took [J]."""
    losses: Losses | None = None
    """What damping, friction, stops, sliding and impacts took, where the integrator tells them apart."""
    contact_forces: Array | None = field(default=None, repr=False)
    """On ground: its force on each link that can touch it, along the world's axes, the mean of the step
    before each sample, (samples, links, 3) [N]."""
    contact_links: tuple[str, ...] = field(default=(), repr=False)
    """Their names."""
    statistics: StepStatistics | None = field(default=None, repr=False)
    """Of adaptive steps: how many, how long."""
    coordinates: tuple[str, ...] = field(default=(), repr=False)
    """The names of v's coordinates."""
    configuration_names: tuple[str, ...] = field(default=(), repr=False)
    """The names of q's numbers: those of `coordinates`, or of a floating joint ``.x`` to ``.qw``."""
    position_limits: Array | None = field(default=None, repr=False)
    """Least and largest of q's numbers (nq, 2), infinite where the file gives none [rad or m]."""
    method: str = "rk4"
    """By which method the steps were taken."""
    left_out: tuple[str, ...] = field(default=(), repr=False)
    """The features that the robot's file states and the motion leaves out, each with the reason."""
    steps_at_effort_limits: Array | None = field(default=None, repr=False)
    """(nv,): in how many steps the torque that was asked for was cut off at the effort limit."""
    actuator_forces: Array | None = field(default=None, repr=False)
    """The force of each actuator before its gear, the mean of the step before each sample, (samples,
    actuators) [N·m or N]."""
    actuator_names: tuple[str, ...] = field(default=(), repr=False)
    """Their names."""

    @property
    def energy(self) -> Array:
        """K + V, (samples,) [J]."""
        total: Array = self.kinetic + self.potential
        return total

    def plot(self, axes: Any = None) -> Any:
        """Positions with their limits, velocities, torques and energies over time; needs matplotlib. Returns
        the axes, one for each.

        Limits are dotted lines of the colours of their curves, where they are near; `axes` takes four axes to
        draw into.
        """
        from robot_dynamics import plots

        return plots.motion(self, axes)

    def __repr__(self) -> str:
        time = self.times[-1] if len(self.times) else 0.0
        is_conservative = np.isfinite(self.ledger.drift)
        error = self.ledger.drift if is_conservative else self.ledger.relative_imbalance
        name = "drift" if is_conservative else "imbalance"
        return f"<Motion: {time:g} s, {len(self.times)} samples, energy {name} {error:.1e}>"


@dataclass(frozen=True)
class Rollout:
    """The motions of many states."""

    q: NDArray[Any]
    """Where they end, (..., nq)."""
    v: NDArray[Any]
    """(..., nv)"""
    q_trajectory: NDArray[Any]
    """The states after each `stride` steps, (..., samples, nq)."""
    v_trajectory: NDArray[Any]
    """(..., samples, nv)"""


class Course(NamedTuple):
    """What rollouts start from and are driven by, with the leading dimensions of the whole batch."""

    q: NDArray[Any]
    v: NDArray[Any]
    tau: NDArray[Any] | None
    each_step: bool
    """Whether `tau` has a row for each step."""

    @classmethod
    def of(cls, robot: Robot, q: Numbers, v: Numbers | None, tau: Numbers | None, steps: int) -> Course:
        """The arguments of `rollout`, broadcast."""
        states = np.asarray(q)
        velocities = np.zeros(robot.nv, states.dtype) if v is None else np.asarray(v)
        forces = None if tau is None else np.asarray(tau)
        lead = np.broadcast_shapes(states.shape[:-1], velocities.shape[:-1])
        is_each = forces is not None and forces.ndim > len(lead) + 1
        if is_each and forces is not None:
            if forces.shape[-2] != steps:
                raise ValueError(f"tau has shape {forces.shape}: its last axis but one must have steps = {steps}")
            lead = np.broadcast_shapes(lead, forces.shape[:-2])
            forces = np.broadcast_to(forces, (*lead, *forces.shape[-2:]))
        elif forces is not None:
            lead = np.broadcast_shapes(lead, forces.shape[:-1])
            forces = np.broadcast_to(forces, (*lead, forces.shape[-1]))
        return cls(
            np.broadcast_to(states, (*lead, states.shape[-1])),
            np.broadcast_to(velocities, (*lead, velocities.shape[-1])),
            forces,
            is_each,
        )


class LinearizedStep(NamedTuple):
    """The slopes of one step: (δq₁, δv₁) = A (δq₀, δv₀) + B δτ, q by displacements q ⊕ δq."""

    by_state: Array
    """A (2 nv, 2 nv)."""
    by_force: Array
    """B (2 nv, nv)."""


def switched_off(without: Sequence[str], dissipation: bool, stops: bool) -> list[str]:
    """The effects to leave out, by name."""
    if isinstance(without, str):
        raise TypeError(f"without={without!r}: give a list of names, [{without!r}]")
    return [*without, *([] if dissipation else ["dissipation"]), *([] if stops else ["limits"])]


def effort_limits(robot: Robot, conservative: bool, off: Sequence[str]) -> Array | None:
    """The limits (nv,) that cut torques off, infinite where there is none; `None` where none acts."""
    if conservative or "effort-limits" in {name.strip().replace("_", "-") for name in off}:
        return None
    limits: Array = np.maximum(robot._effort_limits(), 0.0)
    return limits if np.isfinite(limits).any() else None


def refuse_for_adaptive(**given: Any) -> None:
    """Adaptive steps know neither contact nor constraints."""
    for name, value in given.items():
        if value is not None:
            verb = "go" if name.endswith("s") else "goes"
            raise ValueError(f"{name} {verb} with integrator='implicit'; 'adaptive' knows no contact or constraints")


def simulate(
    robot: Robot,
    q: Numbers,
    v: Numbers | None = None,
    tau: Numbers | Controller | None = None,
    *,
    duration: float,
    step: float = 1e-3,
    integrator: str | None = None,
    conservative: bool = False,
    without: Sequence[str] = (),
    dissipation: bool = True,
    stops: bool = True,
    sample_every: int = 1,
    events: Sequence[Event] = (),
    stop_at_limits: bool = False,
    constraints: Constraints | None = None,
    stabilization: float | None = None,
    correction: Correction = "position",
    controls: Mapping[str, float] | None = None,
    ground: AnyGround | None = None,
    tolerance: float | None = None,
    control_period: float | None = None,
) -> Motion:
    """The motion from q (nq,) and v (nv,), zeros where not given, for `duration` seconds in steps of
    `step`.

    Everything that the robot's file states acts: damping, friction, limits, springs, actuators at their
    `controls` (0 where not named), equalities, and contact with the world's geometry and between links.
    `without` switches effects off by name (``dissipation``, ``limits``, ``effort-limits``, ``springs``,
    ``actuators``, ``equalities``, ``contacts``, ``link-contacts``); `dissipation` and `stops` are the
    first two of them. `conservative` is the textbook's free motion: no damping, friction, limits,
    actuators or contact. Effects that the method does not support are left out; `Motion.left_out` lists
    them.

    `tau` is held over each step, within the joints' effort limits: none, (nv,) for all steps, (steps, nv)
    for each, or a function of (t, q, v) that gives (nv,). Every `sample_every`-th step is a sample; so
    are the first and the last.

    `integrator` is ``rk4`` where everything that acts is smooth and not stiff, and ``implicit``
    elsewhere, unless it is given: a row of the library's table (``rk4``, ``variational-midpoint``, ...),
    ``implicit``, ``mujoco`` or ``adaptive``. ``implicit`` stays stable however stiff joints are, of order
    2; joints stick by their friction, limits are stops, and contacts are rigid with Coulomb's friction.
    ``mujoco`` takes MuJoCo's semi-implicit Euler steps under its law of constraints that yield.
    ``adaptive`` takes steps of order 9, or implicit ones of order 5 where damping is stiff, as long as
    `tolerance` (1e-9) allows; `step` is the time between samples alone. Damping acts, unless a joint has
    dry friction: then both are left out. A function of (t, q, v) is asked all along and must be smooth,
    unless its torques are held for `control_period` [s]; rows of torques are held for a `step`.

    `ground` is a `Ground`, a `HeightField` or ``"file"``, which asks for the planes and height fields of
    the robot's file and refuses a file without. `constraints` take the place of the file's equalities;
    `stabilization` [1/s] is Baumgarte's, `correction` says what an explicit row projects after each step.

    A motion that cannot be computed to its end raises `SimulationError`, whose `until` is the motion so
    far.

    >>> robot = rd.example("panda")
    >>> hold = lambda t, q, v: robot.gravity(q) - 0.1 * v
    >>> motion = robot.simulate(robot.neutral(), tau=hold, duration=0.1, without=["limits"])
    >>> bool(np.abs(motion.q[-1]).max() < 1e-9)
    True
    >>> fall = robot.simulate(np.full(7, 0.1), duration=1.0, step=0.01, integrator="adaptive", tolerance=1e-12, dissipation=False)
    >>> fall.ledger.drift < 1e-12, fall.steps == fall.statistics.accepted
    (True, True)
    """
    directions = {"both": 0, "rising": 1, "falling": -1}
    fields = [(event.name, event.function, directions[event.direction], event.terminal) for event in events]
    how = {"duration": duration, "sample_every": sample_every, "events": fields, "stop_at_limits": stop_at_limits}
    try:
        if integrator == "adaptive":
            refuse_for_adaptive(ground=ground, constraints=constraints)
        elif tolerance is not None or control_period is not None:
            raise ValueError(
                "tolerance and control_period go with integrator='adaptive'; "
                f"{integrator or 'the default'!r} takes steps of one length"
            )
        record = robot._simulate(
            q,
            v,
            tau,
            **how,
            controls=None if controls is None else dict(controls),
            step=step,
            integrator=integrator,
            conservative=conservative,
            without=switched_off(without, dissipation, stops),
            constraints=constraints,
            stabilization=stabilization,
            correction=correction,
            tolerance=tolerance,
            control_period=control_period,
            ground=grounds.native(ground),
        )
    except SimulationError as error:
        if isinstance(error.until, dict):
            error.until = _motion_of(robot, error.until)
        raise
    return _motion_of(robot, record)


def _motion_of(robot: Robot, record: dict[str, Any]) -> Motion:
    record["ledger"] = EnergyLedger(**record["ledger"])
    record["events"] = tuple(Occurrence(*event) for event in record["events"])
    if record.get("statistics") is not None:
        record["statistics"] = StepStatistics(**record["statistics"])
    names, limits = _configuration_layout(robot)
    return Motion(
        **record, coordinates=tuple(robot.coordinate_names), configuration_names=names, position_limits=limits
    )


def _configuration_layout(robot: Robot) -> tuple[tuple[str, ...], Array]:
    """The names of q's numbers, and their limits (nq, 2)."""
    names: list[str] = []
    limits = np.tile([-np.inf, np.inf], (robot.nq, 1))
    coordinates = robot.coordinate_names
    for name, _, _, _, (first, count), (first_v, count_v), _, (lower, upper, _, _), _ in robot._joints():
        own = coordinates[first_v : first_v + count_v]
        if count > count_v:  # a quaternion in place of three turns
            own = [f"{name}.{part}" for part in (*"xyz"[: count - 4], "qx", "qy", "qz", "qw")]
        else:
            limits[first : first + count] = lower, upper
        names += own
    return tuple(names), limits


def rollout(
    robot: Robot,
    q: Numbers,
    v: Numbers | None = None,
    tau: Numbers | None = None,
    *,
    steps: int,
    step: float = 1e-3,
    integrator: str | None = None,
    conservative: bool = False,
    without: Sequence[str] = (),
    dissipation: bool = True,
    stops: bool = True,
    stride: int = 0,
    threads: int | None = None,
    controls: Mapping[str, float] | None = None,
    ground: AnyGround | None = None,
) -> Rollout:
    """Moves states q (..., nq) and v (..., nv) over so many steps, each on its own, by all threads.

    `tau` is (..., nv), held over all steps, or (..., steps, nv), one for each; with one dimension more
    than the states it is the latter. Every `stride`-th state is kept, none for 0. The effects and the
    method are as in `simulate`. Explicit methods without actuators and springs (``integrator="rk4"``,
    ``"semi-implicit-euler"``, ...) move many states at once, float32 in float32; they know no limits and
    no contact. Others move one state after the other on each thread. The results are the same bits for
    any number of threads.

    >>> robot = rd.example("panda")
    >>> q = robot.random_configuration(1000, seed=1)
    >>> rollout = robot.rollout(q, steps=100, step=1e-3, stride=50, conservative=True)
    >>> rollout.q.shape, rollout.q_trajectory.shape
    ((1000, 7), (1000, 2, 7))
    >>> dog = rd.example("quadruped", floating_base=True)
    >>> q = np.tile([0, 0, 0.5, 0, 0, 0, 1, *[0, 0.7, -1.6] * 4], (4, 1))
    >>> q[:, 2] += [0.0, 0.1, 0.2, 0.3]  # dropped from there
    >>> end = dog.rollout(q, steps=2000, ground=rd.Ground())
    >>> bool(np.abs(end.v).max() < 1e-3)  # all four lie on the ground
    True
    """
    course = Course.of(robot, q, v, tau, steps)
    off = switched_off(without, dissipation, stops)
    torques, limits = course.tau, effort_limits(robot, conservative, off)
    if torques is not None and limits is not None:
        effort = limits.astype(torques.dtype)
        torques = np.clip(torques, -effort, effort)
    try:
        ends = robot._rollout(
            course.q,
            course.v,
            torques,
            course.each_step,
            steps=steps,
            stride=stride,
            threads=threads,
            controls=None if controls is None else dict(controls),
            step=step,
            integrator=integrator,
            conservative=conservative,
            without=off,
            ground=grounds.native(ground),
        )
    except BadStatesError as error:
        error.result = Rollout(*error.result)
        raise
    return Rollout(*ends)


def step(
    robot: Robot,
    q: Numbers,
    v: Numbers,
    tau: Numbers | None = None,
    *,
    step: float,
    integrator: str | None = None,
    conservative: bool = False,
    without: Sequence[str] = (),
    dissipation: bool = True,
    stops: bool = True,
    controls: Mapping[str, float] | None = None,
    ground: AnyGround | None = None,
) -> tuple[Array, Array]:
    """q and v of one state after one step, as `simulate` takes it; `rollout` moves many, and a
    `Simulation` goes on.

    >>> robot = rd.example("two_r")
    >>> q, v = robot.step([0.0, 0.0], [1.0, 0.0], step=1e-3)
    >>> bool(abs(q[0] - 1e-3) < 1e-5)
    True
    """
    moved: tuple[Array, Array] = robot._step(
        q,
        v,
        tau,
        None if controls is None else dict(controls),
        step=step,
        integrator=integrator,
        conservative=conservative,
        without=switched_off(without, dissipation, stops),
        ground=grounds.native(ground),
    )
    return moved


def linearize_step(
    robot: Robot,
    q: Numbers,
    v: Numbers,
    tau: Numbers | None = None,
    *,
    step: float,
    integrator: str | None = None,
    conservative: bool = False,
    without: Sequence[str] = (),
    dissipation: bool = True,
    stops: bool = True,
    controls: Mapping[str, float] | None = None,
    ground: AnyGround | None = None,
) -> LinearizedStep:
    """The slopes A and B of one step of one state, as `simulate` takes it: exact ones of an explicit
    method without actuators and springs.

    Those of other methods are central differences of steps in which those contacts go on that a step from
    q and v finds.

    >>> robot = rd.example("two_r")
    >>> A, B = robot.linearize_step([0.0, 0.0], [0.0, 0.0], step=1e-3)
    >>> A.shape, B.shape
    ((4, 4), (4, 2))
    """
    return LinearizedStep(
        *robot._linearize_step(
            q,
            v,
            tau,
            None if controls is None else dict(controls),
            step=step,
            integrator=integrator,
            conservative=conservative,
            without=switched_off(without, dissipation, stops),
            ground=grounds.native(ground),
        )
    )
