"""Motion in time: simulations, rollouts of many states, single steps and their derivatives."""

from __future__ import annotations

from collections.abc import Callable, Mapping, Sequence
from dataclasses import dataclass, field
from typing import TYPE_CHECKING, Any, Literal, NamedTuple, TypeAlias, TypedDict

import numpy as np
from numpy.typing import NDArray

from robot_dynamics import defaults
from robot_dynamics import ground as grounds
from robot_dynamics._native import Constraints, Delayed
from robot_dynamics.errors import BadStatesError, ShapeError, SimulationError
from robot_dynamics.ground import AnyGround
from robot_dynamics.numbers import Numbers

if TYPE_CHECKING:
    from robot_dynamics.robot import Robot

Array: TypeAlias = NDArray[np.float64]
Correction: TypeAlias = Literal["none", "velocity", "position"]
"""The errors that an explicit method projects away after each step under constraints."""
Controller: TypeAlias = Callable[[float, Array, Array], Numbers]
"""Torques τ (nv,) as a function of (t, q, v)."""


@dataclass(frozen=True)
class Event:
    """An event of a simulation: the time at which a function of (t, q, v) becomes 0."""

    name: str
    """Name of the event."""
    function: Callable[[float, Array, Array], float]
    """Function of (t, q, v) whose zeros are the event."""
    direction: Literal["both", "rising", "falling"] = "both"
    """Direction in which the function crosses 0: rising, falling, or both."""
    terminal: bool = False
    """Whether the motion ends at the event."""


class Occurrence(NamedTuple):
    """One event of a motion."""

    name: str
    """Name of the `Event`."""
    time: float
    """Time of the event [s]."""
    rising: bool
    """Whether the function rises there."""
    q: Array
    """Configuration at the event (nq,)."""
    v: Array
    """Velocity at the event (nv,)."""


@dataclass(frozen=True)
class EnergyAccount:
    """Energy account at the end of a motion [J]: start + work − dissipated = kinetic + potential."""

    start: float
    """Energy E = K + V at the start."""
    kinetic: float
    """Kinetic energy K at the end."""
    potential: float
    """Potential energy V at the end."""
    work: float
    """Work of the motors."""
    dissipated: float
    """Energy that damping and friction dissipate."""
    imbalance: float
    """Residual of the account at the end: the error of the method."""
    max_imbalance: float
    """Largest residual during the motion."""
    energy_moved: float
    """max K + max V − min V, or the work or the dissipated energy if that is larger."""
    relative_imbalance: float
    """max_imbalance / energy_moved: the relative error of any motion."""
    drift: float
    """max |E − E₀| / |E₀| of a conservative motion, with max K in place of |E₀| if E₀ is 0.

    NaN if motors or damping act, because E then changes.
    """


class Losses(TypedDict):
    """Energy that leaves a motion, by cause [J]."""

    damping: float
    """Energy that damping dissipates."""
    friction: float
    """Energy that dry friction of joints and tendons dissipates."""
    stops: float
    """Energy that position limits dissipate."""
    corrections: float
    """Energy removed by corrections of states that start beyond a position limit or inside another shape.

    Negative if the corrections add energy.
    """
    sliding: float
    """Energy that sliding contacts dissipate."""
    impacts: float
    """Energy that impacts dissipate."""


class StepStatistics(NamedTuple):
    """Statistics of adaptive steps."""

    accepted: int
    """Number of accepted steps."""
    rejected: int
    """Number of steps rejected because their error was too large."""
    evaluations: int
    """Number of evaluations of the forward dynamics."""
    shortest: float
    """Shortest step [s]."""
    longest: float
    """Longest step [s]."""
    quaternion_error: float
    """Largest | |quaternion| − 1 | at the end of a step, before q is normalised."""


@dataclass(frozen=True)
class Motion:
    """A simulated motion, sample by sample.

    >>> motion = rd.example("two_r").simulate([0.0, 0.0], duration=1.0)
    >>> motion.q.shape, motion.energy_account.drift < 1e-9
    ((1001, 2), True)
    """

    times: Array = field(repr=False)
    """Sample times (samples,) [s]."""
    q: Array = field(repr=False)
    """Configurations (samples, nq)."""
    v: Array = field(repr=False)
    """Velocities (samples, nv) [rad/s or m/s]."""
    tau: Array = field(repr=False)
    """Torques that act from each sample on (samples, nv) [N·m or N].

    They are within the effort limits and include the torques of actuators.
    """
    kinetic: Array = field(repr=False)
    """Kinetic energy (samples,) [J]."""
    potential: Array = field(repr=False)
    """Potential energy (samples,) [J]."""
    energy_account: EnergyAccount
    """Energy account of the motion."""
    peak_torque: Array = field(repr=False)
    """Largest |τ| of each coordinate over all steps (nv,) [N·m or N]."""
    events: tuple[Occurrence, ...]
    """Events of the motion, in their order."""
    steps: int
    """Number of steps."""
    ended_by_event: bool
    """Whether a terminal event ended the motion."""
    position_drift: float | None = None
    """Under constraints: the largest |φ| [m or rad]."""
    velocity_drift: float | None = None
    """Under constraints: the largest |A v| [m/s or rad/s]."""
    energy_removed: float | None = None
    """Under constraints: the energy that corrections of drift remove [J]."""
    losses: Losses | None = None
    """Dissipated energy by cause, if the integrator separates the causes."""
    contact_forces: Array | None = field(default=None, repr=False)
    """Ground forces on the links in `contact_links`, along the world's axes (samples, links, 3) [N].

    Each is the mean over the step before the sample. `None` without ground contact.
    """
    contact_links: tuple[str, ...] = field(default=(), repr=False)
    """Names of the links that can touch the ground."""
    statistics: StepStatistics | None = field(default=None, repr=False)
    """Statistics of adaptive steps; `None` for other methods."""
    coordinates: tuple[str, ...] = field(default=(), repr=False)
    """Names of the coordinates of v."""
    configuration_names: tuple[str, ...] = field(default=(), repr=False)
    """Names of the numbers of q: those of `coordinates`, or ``.x`` to ``.qw`` of a floating joint."""
    position_limits: Array | None = field(default=None, repr=False)
    """Smallest and largest value of each number of q (nq, 2) [rad or m]; infinite without a limit."""
    method: str = "rk4"
    """Name of the integration method."""
    left_out: tuple[str, ...] = field(default=(), repr=False)
    """Features that the robot's file states and the motion omits, each with the reason."""
    steps_at_effort_limits: Array | None = field(default=None, repr=False)
    """Number of steps in which the requested torque exceeds the effort limit (nv,)."""
    actuator_forces: Array | None = field(default=None, repr=False)
    """Force of each actuator before its gear (samples, actuators) [N·m or N].

    Each is the mean over the step before the sample.
    """
    actuator_names: tuple[str, ...] = field(default=(), repr=False)
    """Names of the actuators."""

    @property
    def energy(self) -> Array:
        """Total energy K + V (samples,) [J]."""
        total: Array = self.kinetic + self.potential
        return total

    def plot(self, axes: Any = None) -> Any:
        """Plot positions with their limits, velocities, torques and energies over time.

        Limits near a curve are dotted lines of the same colour. Needs matplotlib.

        Parameters
        ----------
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
        from robot_dynamics import plots

        return plots.plot_motion(self, axes)

    def __repr__(self) -> str:
        time = self.times[-1] if len(self.times) else 0.0
        is_conservative = np.isfinite(self.energy_account.drift)
        error = self.energy_account.drift if is_conservative else self.energy_account.relative_imbalance
        name = "drift" if is_conservative else "imbalance"
        return f"<Motion: {time:g} s, {len(self.times)} samples, energy {name} {error:.1e}>"


@dataclass(frozen=True)
class Rollout:
    """Motions of many states."""

    q: NDArray[Any]
    """Final configurations (..., nq)."""
    v: NDArray[Any]
    """Final velocities (..., nv) [rad/s or m/s]."""
    q_trajectory: NDArray[Any]
    """Configurations after each `stride` steps (..., samples, nq)."""
    v_trajectory: NDArray[Any]
    """Velocities after each `stride` steps (..., samples, nv) [rad/s or m/s]."""


class RolloutInputs(NamedTuple):
    """Initial states and torques of a rollout, with the leading dimensions of the whole batch."""

    q: NDArray[Any]
    """Initial configurations (..., nq)."""
    v: NDArray[Any]
    """Initial velocities (..., nv)."""
    tau: NDArray[Any] | None
    """Torques (..., nv) or (..., steps, nv), or `None`."""
    each_step: bool
    """Whether `tau` has a row for each step."""

    @classmethod
    def of(cls, robot: Robot, q: Numbers, v: Numbers | None, tau: Numbers | None, steps: int) -> RolloutInputs:
        """Broadcast the arguments of `rollout`."""
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
    """Derivatives of one step: (δq₁, δv₁) = A (δq₀, δv₀) + B δτ, with δq a displacement q ⊕ δq."""

    by_state: Array
    """A (..., 2 nv, 2 nv)."""
    by_force: Array
    """B (..., 2 nv, nv)."""


def disabled_effects(without: Sequence[str], dissipation: bool, stops: bool) -> list[str]:
    """Names of the effects to leave out."""
    if isinstance(without, str):
        raise TypeError(f"without={without!r}: give a list of names, [{without!r}]")
    return [*without, *([] if dissipation else ["dissipation"]), *([] if stops else ["limits"])]


def effort_limits(robot: Robot, conservative: bool, off: Sequence[str]) -> Array | None:
    """Effort limits (nv,) that clip torques, infinite without a limit; `None` if no limit acts."""
    if conservative or "effort-limits" in {name.strip().replace("_", "-") for name in off}:
        return None
    limits: Array = np.maximum(robot._effort_limits(), 0.0)
    return limits if np.isfinite(limits).any() else None


def check_adaptive_options(**given: object) -> None:
    """Raise ValueError for options that adaptive steps do not support: contact and constraints."""
    for name, value in given.items():
        if value is not None:
            verb = "go" if name.endswith("s") else "goes"
            raise ValueError(f"{name} {verb} with integrator='implicit'; 'adaptive' does not support contact or constraints")


def simulate(
    robot: Robot,
    q: Numbers,
    v: Numbers | None = None,
    tau: Numbers | Controller | Delayed | None = None,
    *,
    duration: float,
    dt: float = defaults.DT,
    integrator: str | None = None,
    conservative: bool = False,
    without: Sequence[str] = (),
    dissipation: bool = True,
    stops: bool = True,
    sample_period: float | Literal["ends"] | None = None,
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
    """Simulate the motion from a state for `duration` seconds.

    Everything that the robot's file states acts: damping, friction, limits, springs, actuators,
    equalities, and contact with the world's geometry and between links. Effects that the method does not
    support are left out; `Motion.left_out` lists them.

    Unless `integrator` is given, the method is ``rk4`` if all acting effects are smooth and not stiff,
    and ``implicit`` otherwise.

    - ``implicit`` has order 2 and stays stable for joints of any stiffness. Joints stick by dry friction,
      position limits are stops, and contacts are rigid with Coulomb friction.
    - ``mujoco`` takes MuJoCo's semi-implicit Euler steps with its compliant constraints.
    - ``adaptive`` takes explicit steps of order 9, or implicit steps of order 5 if damping is stiff. It
      chooses their length by `tolerance`. Damping acts, unless a joint has dry friction: then both are
      left out.
    - The methods of the library's table have fixed steps: ``rk4``, ``semi-implicit-euler``,
      ``explicit-euler``, ``variational-midpoint`` and ``variational-yoshida4``.

    Parameters
    ----------
    q : array_like, shape (nq,)
        Initial configuration.
    v : array_like, shape (nv,), optional
        Initial velocity [rad/s or m/s]; default: 0.
    tau : array_like, shape (nv,) or (steps, nv), or callable, optional
        Torques [N·m or N] for all steps or for each step; a function of (t, q, v) that returns (nv,); or
        `Delayed`. Each is held over a step and clipped to the effort limits. With ``adaptive`` rows are
        held for `dt`. A function is then evaluated continuously and must be smooth, unless
        `control_period` is given.
    duration : float
        Duration [s].
    dt : float
        Step size [s]; with ``adaptive`` the time between samples.
    integrator : str, optional
        Method: ``implicit``, ``mujoco``, ``adaptive`` or one of the table, such as ``rk4``.
    conservative : bool
        Whether to leave out damping, friction, limits, actuators and contact.
    without : sequence of str
        Effects to leave out: ``dissipation``, ``limits``, ``effort-limits``, ``springs``, ``actuators``,
        ``equalities``, ``contacts``, ``link-contacts``.
    dissipation : bool
        Whether damping and friction act.
    stops : bool
        Whether position limits act.
    sample_period : float or "ends", optional
        Time between samples [s], rounded to the nearest whole number of steps, at least one; default: each
        step. The first and the last state are always samples, with ``"ends"`` the only ones.
    events : sequence of Event
        Events to find.
    stop_at_limits : bool
        Whether the motion ends where a joint reaches a position limit.
    constraints : Constraints, optional
        Constraints that replace the equalities of the file.
    stabilization : float, optional
        Rate γ of Baumgarte's stabilization of `constraints` [1/s].
    correction : {"none", "velocity", "position"}
        Errors that an explicit method projects away after each step under constraints.
    controls : mapping of str to float, optional
        Controls of actuators by name; the others are 0.
    ground : Ground, HeightField or "file", optional
        Ground below the robot. ``"file"`` requires planes or height fields in the robot's file.
    tolerance : float, optional
        Local error that ``adaptive`` steps allow, relative and absolute; default: 1e-9.
    control_period : float, optional
        With ``adaptive``, the time for which each torque of a function is held [s].

    Returns
    -------
    Motion
        The sampled motion with its energy account.

    Raises
    ------
    SimulationError
        The motion cannot be computed to its end; `until` is the motion so far.
    StateError
        `q` or `v` is invalid.
    ShapeError
        An array has the wrong shape.
    ValueError
        An option is invalid, or options exclude each other.

    Examples
    --------
    >>> robot = rd.example("panda")
    >>> hold = lambda t, q, v: robot.gravity(q) - 0.1 * v
    >>> motion = robot.simulate(robot.neutral(), tau=hold, duration=0.1, without=["limits"])
    >>> bool(np.abs(motion.q[-1]).max() < 1e-9)
    True
    >>> fall = robot.simulate(np.full(7, 0.1), duration=1.0, dt=0.01, integrator="adaptive", tolerance=1e-12, dissipation=False)
    >>> fall.energy_account.drift < 1e-12, fall.steps == fall.statistics.accepted
    (True, True)
    """
    directions = {"both": 0, "rising": 1, "falling": -1}
    fields = [(event.name, event.function, directions[event.direction], event.terminal) for event in events]
    try:
        if integrator == "adaptive":
            check_adaptive_options(ground=ground, constraints=constraints)
        elif tolerance is not None or control_period is not None:
            raise ValueError(
                "tolerance and control_period go with integrator='adaptive'; "
                f"{integrator or 'the default'!r} takes steps of one length"
            )
        record = robot._simulate(
            q,
            v,
            tau,
            duration=duration,
            sample_period=sample_period,
            events=fields,
            stop_at_limits=stop_at_limits,
            controls=None if controls is None else dict(controls),
            dt=dt,
            integrator=integrator,
            conservative=conservative,
            without=disabled_effects(without, dissipation, stops),
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
    """The motion of a record of the compiled module."""
    record["energy_account"] = EnergyAccount(**record["energy_account"])
    record["events"] = tuple(Occurrence(*event) for event in record["events"])
    if record.get("statistics") is not None:
        record["statistics"] = StepStatistics(**record["statistics"])
    names, limits = configuration_layout(robot)
    return Motion(
        **record, coordinates=tuple(robot.coordinate_names), configuration_names=names, position_limits=limits
    )


def configuration_layout(robot: Robot) -> tuple[tuple[str, ...], Array]:
    """Names of the numbers of q, and their limits (nq, 2)."""
    names: list[str] = []
    limits = np.tile([-np.inf, np.inf], (robot.nq, 1))
    coordinates = robot.coordinate_names
    for joint in robot.joints:
        own = coordinates[joint.v]
        count = joint.q.stop - joint.q.start
        if count > len(own):  # a quaternion in place of three rotations
            own = [f"{joint.name}.{part}" for part in (*"xyz"[: count - 4], "qx", "qy", "qz", "qw")]
        else:
            limits[joint.q] = joint.limits.lower, joint.limits.upper
        names += own
    return tuple(names), limits


def rollout(
    robot: Robot,
    q: Numbers,
    v: Numbers | None = None,
    tau: Numbers | None = None,
    *,
    steps: int,
    dt: float = defaults.DT,
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
    """Integrate many states over a number of steps, in parallel.

    The effects and the method are those of `simulate`. Explicit methods without actuators and springs
    (``integrator="rk4"``, ``"semi-implicit-euler"``, ...) integrate many states at once, without position
    limits and contact; float32 stays float32. Other methods integrate one state after the other on each
    thread, in float64. The results have the same bits for any number of threads.

    Parameters
    ----------
    q : array_like, shape (..., nq)
        Initial configurations.
    v : array_like, shape (..., nv), optional
        Initial velocities [rad/s or m/s]; default: 0.
    tau : array_like, shape (..., nv) or (..., steps, nv), optional
        Torques [N·m or N], held over all steps or given for each step; default: 0. With one dimension
        more than the states, they are given for each step.
    steps : int
        Number of steps.
    dt : float
        Step size [s].
    integrator : str, optional
        Method; see `simulate`.
    conservative : bool
        Whether to leave out damping, friction, limits, actuators and contact.
    without : sequence of str
        Effects to leave out; see `simulate`.
    dissipation : bool
        Whether damping and friction act.
    stops : bool
        Whether position limits act.
    stride : int
        Number of steps between samples of the trajectory; 0 for no trajectory.
    threads : int, optional
        Threads for a batch; default: `num_threads()`.
    controls : mapping of str to float, optional
        Controls of actuators by name; the others are 0.
    ground : Ground, HeightField or "file", optional
        Ground below the robot; see `simulate`.

    Returns
    -------
    Rollout
        Final states and trajectories.

    Raises
    ------
    BadStatesError
        Some states have no valid motion; `result` has the others.
    SimulationError
        The integrator or the step is invalid.
    ValueError
        `tau` does not have `steps` rows, or an option is invalid.
    TypeError
        float32 states for a method that computes in float64.

    Examples
    --------
    >>> robot = rd.example("panda")
    >>> q = robot.random_configuration(1000, seed=1)
    >>> rollout = robot.rollout(q, steps=100, dt=1e-3, stride=50, conservative=True)
    >>> rollout.q.shape, rollout.q_trajectory.shape
    ((1000, 7), (1000, 2, 7))
    >>> dog = rd.example("quadruped", floating_base=True)
    >>> q = np.tile([0, 0, 0.5, 0, 0, 0, 1, *[0, 0.7, -1.6] * 4], (4, 1))
    >>> q[:, 2] += [0.0, 0.1, 0.2, 0.3]  # dropped from there
    >>> end = dog.rollout(q, steps=2000, ground=rd.Ground())
    >>> bool(np.abs(end.v).max() < 1e-3)  # all four lie on the ground
    True
    """
    inputs = RolloutInputs.of(robot, q, v, tau, steps)
    off = disabled_effects(without, dissipation, stops)
    torques, limits = inputs.tau, effort_limits(robot, conservative, off)
    if torques is not None and limits is not None:
        effort = limits.astype(torques.dtype)
        torques = np.clip(torques, -effort, effort)
    try:
        ends = robot._rollout(
            inputs.q,
            inputs.v,
            torques,
            inputs.each_step,
            steps=steps,
            stride=stride,
            threads=threads,
            controls=None if controls is None else dict(controls),
            dt=dt,
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
    dt: float,
    integrator: str | None = None,
    conservative: bool = False,
    without: Sequence[str] = (),
    dissipation: bool = True,
    stops: bool = True,
    controls: Mapping[str, float] | None = None,
    ground: AnyGround | None = None,
) -> tuple[Array, Array]:
    """Compute one step of one state, as `simulate` does.

    Use `rollout` for many states, and `Simulation` for successive steps.

    Parameters
    ----------
    q : array_like, shape (nq,)
        Configuration.
    v : array_like, shape (nv,)
        Velocity [rad/s or m/s].
    tau : array_like, shape (nv,), optional
        Torques [N·m or N]; default: 0.
    dt : float
        Step size [s].
    integrator : str, optional
        Method; see `simulate`. ``adaptive`` is invalid here.
    conservative : bool
        Whether to leave out damping, friction, limits, actuators and contact.
    without : sequence of str
        Effects to leave out; see `simulate`.
    dissipation : bool
        Whether damping and friction act.
    stops : bool
        Whether position limits act.
    controls : mapping of str to float, optional
        Controls of actuators by name; the others are 0.
    ground : Ground, HeightField or "file", optional
        Ground below the robot; see `simulate`.

    Returns
    -------
    q : ndarray, shape (nq,)
        Configuration after the step.
    v : ndarray, shape (nv,)
        Velocity after the step [rad/s or m/s].

    Raises
    ------
    SimulationError
        The step fails, or the integrator or the step size is invalid.
    StateError
        `q`, `v` or `tau` is invalid.

    Examples
    --------
    >>> robot = rd.example("two_r")
    >>> q, v = robot.step([0.0, 0.0], [1.0, 0.0], dt=1e-3)
    >>> bool(abs(q[0] - 1e-3) < 1e-5)
    True
    """
    moved: tuple[Array, Array] = robot._step(
        q,
        v,
        tau,
        None if controls is None else dict(controls),
        dt=dt,
        integrator=integrator,
        conservative=conservative,
        without=disabled_effects(without, dissipation, stops),
        ground=grounds.native(ground),
    )
    return moved


def linearize_step(
    robot: Robot,
    q: Numbers,
    v: Numbers,
    tau: Numbers | None = None,
    *,
    dt: float,
    integrator: str | None = None,
    conservative: bool = False,
    without: Sequence[str] = (),
    dissipation: bool = True,
    stops: bool = True,
    controls: Mapping[str, float] | None = None,
    ground: AnyGround | None = None,
    threads: int | None = None,
) -> LinearizedStep:
    """Derivatives A and B of one step of each state: (δq₁, δv₁) = A (δq₀, δv₀) + B δτ.

    They are exact for explicit methods without actuators and springs. For ``implicit`` they are those of the
    step's equations, through contact, impacts, stops, friction and closed loops. Other steps use central
    differences: fluids, rebounds, and other methods. The contacts are those that a step from q and v finds.

    Parameters
    ----------
    q : array_like, shape (..., nq)
        Configuration.
    v : array_like, shape (..., nv)
        Velocity [rad/s or m/s].
    tau : array_like, shape (..., nv), optional
        Torques [N·m or N]; default: 0.
    dt : float
        Step size [s].
    integrator : str, optional
        Method; see `simulate`. ``adaptive`` is invalid here.
    conservative : bool
        Whether to leave out damping, friction, limits, actuators and contact.
    without : sequence of str
        Effects to leave out; see `simulate`.
    dissipation : bool
        Whether damping and friction act.
    stops : bool
        Whether position limits act.
    controls : mapping of str to float, optional
        Controls of actuators by name; the others are 0.
    ground : Ground, HeightField or "file", optional
        Ground below the robot; see `simulate`.
    threads : int, optional
        Threads for a batch; default: `num_threads()`.

    Returns
    -------
    LinearizedStep
        A (..., 2 nv, 2 nv) and B (..., 2 nv, nv).

    Raises
    ------
    BadStatesError
        Some states of a batch have no valid derivatives; `result` has the others.
    SimulationError
        The step fails, or the integrator or the step size is invalid.
    StateError
        `q`, `v` or `tau` is invalid.

    Examples
    --------
    >>> robot = rd.example("two_r")
    >>> A, B = robot.linearize_step([0.0, 0.0], [0.0, 0.0], dt=1e-3)
    >>> A.shape, B.shape
    ((4, 4), (4, 2))
    >>> robot.linearize_step(np.zeros((50, 2)), np.zeros(2), dt=1e-3).by_state.shape
    (50, 4, 4)
    """
    options: dict[str, Any] = {
        "dt": dt,
        "integrator": integrator,
        "conservative": conservative,
        "without": disabled_effects(without, dissipation, stops),
        "ground": grounds.native(ground),
    }
    values = None if controls is None else dict(controls)
    if all(np.asarray(x).ndim <= 1 for x in (q, v, tau) if x is not None):
        return LinearizedStep(*robot._linearize_step(q, v, tau, values, **options))
    widths = {"q": robot.nq, "v": robot.nv, "tau": robot.nv}
    given = {name: np.asarray(x, dtype=float) for name, x in (("q", q), ("v", v), ("tau", tau)) if x is not None}
    for name, x in given.items():
        if x.shape[-1:] != (widths[name],):
            raise ShapeError(f"{name} has shape {x.shape}, robot `{robot.name}` needs (..., {widths[name]})")
    lead = np.broadcast_shapes(*(x.shape[:-1] for x in given.values()))
    rows = {
        name: np.ascontiguousarray(np.broadcast_to(x, (*lead, x.shape[-1]))).reshape(-1, x.shape[-1])
        for name, x in given.items()
    }
    forces = rows.get("tau", np.empty((0, robot.nv)))
    return LinearizedStep(
        *robot._linearize_steps(rows["q"], rows["v"], forces, values, list(lead), threads, **options)
    )
