"""Optimal control: the controls that minimise a cost along the steps of a robot.

A problem has N nodes:

    minimise Σ ℓ_k(x_k, u_k) + ℓ_N(x_N)
    with  x_0 given,  x_{k+1} = f_k(x_k, u_k),  l ≤ u_k ≤ h,  l_k ≤ c_k(x_k, u_k) ≤ h_k

A state is x = (q, v). A difference δx = (δq, δv) has n = 2 nv numbers, so quaternions need no constraint.

>>> robot = rd.example("two_r")
>>> problem = rd.optimal.Problem(rd.optimal.SmoothStep(robot, dt=0.02), (robot.neutral(), np.zeros(2)), nodes=40)
>>> problem.set_running_cost(rd.optimal.LeastSquares(rd.optimal.ControlResidual(), 1e-4))
>>> problem.set_terminal_cost(rd.optimal.LeastSquares(rd.optimal.StateResidual(([1.0, 0.5], [0.0, 0.0])), 100.0))
>>> solution = problem.solve()
>>> solution.is_solved, bool(np.abs(solution.q[-1] - [1.0, 0.5]).max() < 0.01)
(True, True)

The solver is FDDP with multiple shooting and bounds on the controls. Constraints are handled by an augmented
Lagrangian around it.
"""

from __future__ import annotations

from collections.abc import Callable, Sequence
from dataclasses import dataclass, field
from typing import TYPE_CHECKING, Any, ClassVar, Literal, NamedTuple, Self, TypeAlias

import numpy as np
from numpy.typing import NDArray

from robot_dynamics import _native, defaults
from robot_dynamics._native import Constraints
from robot_dynamics.numbers import Numbers, ReferenceFrame

if TYPE_CHECKING:
    from robot_dynamics.robot import Robot
    from robot_dynamics.simulation import Simulation

Array: TypeAlias = NDArray[np.float64]
State: TypeAlias = Numbers | tuple[Numbers, Numbers]
"""A state: the pair (q, v), or one array with the numbers of both."""
Nodes: TypeAlias = int | range | slice | None
"""A node, a range of nodes, or all."""


@dataclass(frozen=True, eq=False)
class SmoothStep:
    """Step of a robot by an explicit integrator, without contact: τ = S u, constant over the step.

    Its derivatives are exact. The sign of dry friction is held constant in them.
    """

    _kind: ClassVar[str] = "smooth_step"

    robot: Robot
    """Robot that moves."""
    dt: float = field(default=defaults.DT, kw_only=True)
    """Step size [s]."""
    integrator: str = field(default="semi-implicit-euler", kw_only=True)
    """Explicit integrator."""
    dissipation: bool = field(default=True, kw_only=True)
    """Whether damping and friction act."""
    actuation: Numbers | str | None = field(default=None, kw_only=True)
    """S: a matrix (nv, controls), ``"motors"`` for one control for each coordinate with a motor, or `None`
    for one control for each coordinate."""


@dataclass(frozen=True, eq=False)
class SimulationStep:
    """Step of a simulation, with everything that acts in it: contact, stops, friction, actuators.

    Contacts are found by the simulator, so no phases are stated. A contact that sticks has no slope in the
    directions that it blocks, so a start should move the robot.
    """

    _kind: ClassVar[str] = "simulation_step"

    simulation: Simulation
    """Simulation; its state does not matter, and it does not change."""
    actuation: Numbers | str | None = field(default=None, kw_only=True)
    """S of τ = S u, as in `SmoothStep`; or ``"actuators"`` for the controls of the robot's actuators without
    states: motors with gears, servos and tendons."""


@dataclass(frozen=True, eq=False)
class HeldContactStep:
    """Step of semi-implicit Euler with held contacts, such as the feet of a phase of a gait.

    M a + C v + g = S u + Aᵀλ with A a = −Ȧv − d A v − p φ. The contacts are held for the whole phase: λ may
    pull and slip. `FrictionPyramidResidual` in a cost or a constraint keeps it within friction. Damping and
    friction of the joints are not included.
    """

    _kind: ClassVar[str] = "held_contact_step"

    robot: Robot
    """Robot that moves."""
    constraints: Constraints
    """Held rows."""
    dt: float = field(default=defaults.DT, kw_only=True)
    """Step size [s]."""
    damping: float = field(default=0.0, kw_only=True)
    """d [1/s]; below about 2/dt."""
    stiffness: float = field(default=0.0, kw_only=True)
    """p [1/s²]; with 0 a contact is held where it is."""
    actuation: Numbers | str | None = field(default=None, kw_only=True)
    """S, as in `SmoothStep`."""


@dataclass(frozen=True, eq=False)
class ImpactStep:
    """Impact on contacts: q′ = q, v′ = v + M⁻¹Aᵀι with A v′ = −e A v. It has no controls."""

    _kind: ClassVar[str] = "impact_step"

    robot: Robot
    """Robot that lands."""
    constraints: Constraints
    """Rows of the contacts that close."""
    restitution: float = field(default=0.0, kw_only=True)
    """e, from 0 to 1; 0 for contacts that hold."""


@dataclass(frozen=True, eq=False)
class LinearDynamics:
    """x′ = A x + B u + c on plain numbers."""

    _kind: ClassVar[str] = "linear"

    a: Numbers
    """A (n, n)."""
    b: Numbers
    """B (n, controls)."""
    offset: Numbers | None = None
    """c (n,); default: zeros."""


Dynamics: TypeAlias = SmoothStep | SimulationStep | HeldContactStep | ImpactStep | LinearDynamics


@dataclass(frozen=True, eq=False)
class StateResidual:
    """x ⊖ x*, the displacement from a target state (n,)."""

    _kind: ClassVar[str] = "state"

    target: State
    """Target x*: the pair (q, v), or the numbers of both."""


@dataclass(frozen=True, eq=False)
class ControlResidual:
    """u − u* (controls,)."""

    _kind: ClassVar[str] = "control"

    target: Numbers | float | None = None
    """Target u*; default: zeros."""


@dataclass(frozen=True, eq=False)
class FrameTranslationResidual:
    """p − p*, the origin of a frame in the world from its target (3,) [m]."""

    _kind: ClassVar[str] = "frame_translation"

    frame: str | int
    """Name of the frame, or its index in `frame_names`."""
    target: Numbers
    """Target p* (3,) [m]."""


@dataclass(frozen=True, eq=False)
class FrameRotationResidual:
    """log(R*ᵀ R), the rotation vector of a frame relative to its target (3,) [rad]."""

    _kind: ClassVar[str] = "frame_rotation"

    frame: str | int
    """Name of the frame, or its index in `frame_names`."""
    target: Numbers
    """Target R*, world from frame (3, 3)."""


@dataclass(frozen=True, eq=False)
class FramePlacementResidual:
    """log(T*⁻¹ T), the pose of a frame relative to its target (6,), linear part first."""

    _kind: ClassVar[str] = "frame_placement"

    frame: str | int
    """Name of the frame, or its index in `frame_names`."""
    target: Numbers
    """Target T*, world from frame (4, 4)."""


@dataclass(frozen=True, eq=False)
class FrameVelocityResidual:
    """V − V*, the velocity of a frame from its target (6,), linear part first."""

    _kind: ClassVar[str] = "frame_velocity"

    frame: str | int
    """Name of the frame, or its index in `frame_names`."""
    target: Numbers | None = None
    """Target V* (6,) [m/s, rad/s]; default: rest."""
    reference_frame: ReferenceFrame = field(default="local_world_aligned", kw_only=True)
    """Axes of the velocity."""


@dataclass(frozen=True, eq=False)
class CenterOfMassResidual:
    """c − c*, the centre of mass in the world from its target (3,) [m]."""

    _kind: ClassVar[str] = "center_of_mass"

    target: Numbers
    """Target c* (3,) [m]."""


@dataclass(frozen=True, eq=False)
class ContactForceResidual:
    """λ − λ*, the forces of held contacts from their targets (rows,) [N, N·m]."""

    _kind: ClassVar[str] = "contact_force"

    step: HeldContactStep
    """Step that holds the contacts, the same as that of the nodes."""
    target: Numbers | float | None = None
    """Targets λ*, one for each row of the constraints; default: zeros."""


@dataclass(frozen=True, eq=False)
class FrictionPyramidResidual:
    """Five numbers of a point contact, not negative within friction: μλ_z ± λ_x, μλ_z ± λ_y, λ_z.

    As a cost: ``LeastSquares(FrictionPyramidResidual(step, "foot", 0.7), 1.0, lower=0.0)``.
    """

    _kind: ClassVar[str] = "friction_pyramid"

    step: HeldContactStep
    """Step that holds the contacts, the same as that of the nodes."""
    contact: str
    """Name of the contact in the constraints; it must have the rows x, y and z."""
    friction: float
    """μ."""


@dataclass(frozen=True, eq=False)
class FunctionResidual:
    """r(q, v, u), or r(x, u) for plain numbers, computed by a Python function.

    >>> power = rd.optimal.FunctionResidual(lambda q, v, u: v[:1] * u[:1], 1)
    >>> problem = rd.optimal.Problem(rd.optimal.SmoothStep(rd.example("two_r")), np.zeros(4), nodes=5)
    >>> problem.set_running_cost(rd.optimal.LeastSquares(power))
    """

    _kind: ClassVar[str] = "function"

    function: Callable[..., Numbers]
    """Function of (q, v, u) that returns r (dimension,). At the last node u is empty."""
    dimension: int
    """Number of entries of r."""
    derivatives: Callable[..., tuple[Numbers, Numbers]] | None = field(default=None, kw_only=True)
    """Function of (q, v, u) that returns ∂r/∂(q, v) (dimension, nq + nv) by coordinates and ∂r/∂u (dimension,
    controls). Without it, derivatives are central differences with a step of 1e-5."""

    @classmethod
    def of_jax(cls, function: Callable[..., Any], dimension: int) -> Self:
        """Residual of a function written with `jax.numpy`, with its exact derivatives.

        Needs jax, with 64-bit numbers enabled.

        Parameters
        ----------
        function : callable
            Function of (q, v, u) that returns r (dimension,).
        dimension : int
            Number of entries of r.

        Returns
        -------
        FunctionResidual
            The residual; the function is compiled at its first call.

        Raises
        ------
        ImportError
            jax is missing.
        ValueError
            64-bit numbers are not enabled in jax.
        """
        import jax

        if not jax.config.jax_enable_x64:
            raise ValueError('enable 64-bit numbers first: jax.config.update("jax_enable_x64", True)')
        value = jax.jit(function)
        slopes = jax.jit(lambda *arguments: jax.jacfwd(function, tuple(range(len(arguments))))(*arguments))

        def evaluate(*arguments: Array) -> Array:
            return np.asarray(value(*arguments), np.float64)

        def derivatives(*arguments: Array) -> tuple[Array, Array]:
            parts = [np.asarray(part, np.float64) for part in slopes(*arguments)]
            return np.concatenate(parts[:-1], axis=1), parts[-1]

        return cls(evaluate, dimension, derivatives=derivatives)


Residual: TypeAlias = (
    StateResidual
    | ControlResidual
    | FrameTranslationResidual
    | FrameRotationResidual
    | FramePlacementResidual
    | FrameVelocityResidual
    | CenterOfMassResidual
    | ContactForceResidual
    | FrictionPyramidResidual
    | FunctionResidual
)


@dataclass(frozen=True, eq=False)
class LeastSquares:
    """Term ½ Σ wᵢ rᵢ² of a cost. With `lower` or `upper`, r counts only beyond these limits.

    The terms of a running cost count at each node. A cost per second takes weights multiplied by the step.
    """

    residual: Residual
    """r(x, u)."""
    weights: Numbers | float = 1.0
    """Weights w: one number, or one for each entry of r."""
    lower: Numbers | float | None = field(default=None, kw_only=True)
    """Lower end of the interval in which r costs nothing; default: none if `upper` is given."""
    upper: Numbers | float | None = field(default=None, kw_only=True)
    """Upper end of this interval."""


class Iteration(NamedTuple):
    """One iteration of the solver."""

    iteration: int
    """Its number, from 0."""
    cost: float
    """Cost after it."""
    defect: float
    """Largest entry of a defect f(x_k, u_k) ⊖ x_{k+1} after it."""
    gradient: float
    """Largest derivative of the Lagrangian by a control that is not at its bound, before it."""
    predicted_decrease: float
    """Decrease of the merit that the linear-quadratic model predicts for a full step."""
    step_length: float
    """Length of the step; 0 if all were rejected."""
    regularization: float
    """μ of Quu + μ 1."""


@dataclass(frozen=True, eq=False)
class Solution:
    """Trajectory that a solver found, with the gains of its policy."""

    states: Array = field(repr=False)
    """States (N + 1, nq + nv)."""
    controls: Array | list[Array] = field(repr=False)
    """Controls (N, controls); a list of arrays if the numbers of controls differ."""
    gains: Array | list[Array] = field(repr=False)
    """K of u = u_k + K (x ⊖ x_k) (N, controls, n). Rows of controls at a bound are zero."""
    cost: float
    """Cost."""
    is_solved: bool
    """Whether this is a local minimum, to the tolerances or to rounding."""
    termination: str
    """Reason for the end of the solver."""
    defect: float
    """Largest entry of a defect f(x_k, u_k) ⊖ x_{k+1}."""
    gradient: float
    """Largest derivative of the Lagrangian by a control that is not at its bound."""
    violation: float
    """Largest violation of a constraint."""
    log: list[Iteration] = field(repr=False)
    """Iterations; with constraints, those of all inner solutions."""
    nq: int = field(default=0, repr=False)
    """Number of coordinates of q; 0 for plain numbers."""

    @property
    def q(self) -> Array:
        """Configurations (N + 1, nq)."""
        return self.states[:, : self.nq]

    @property
    def v(self) -> Array:
        """Velocities (N + 1, nv); the states themselves for plain numbers."""
        return self.states[:, self.nq :]


class SamplingIteration(NamedTuple):
    """One iteration of a sampling."""

    iteration: int
    """Its number, from 0."""
    mean_cost: float
    """Cost of the mean before it."""
    best_cost: float
    """Least cost of all samples so far."""
    effective_samples: float
    """(Σw)²/Σw² of the weights; near 1 a single sample decides."""
    failed: int
    """Samples whose dynamics or cost could not be computed."""


@dataclass(frozen=True, eq=False)
class SampledSolution:
    """Controls that a sampling found."""

    states: Array = field(repr=False)
    """States (N + 1, nq + nv)."""
    controls: Array | list[Array] = field(repr=False)
    """Controls (N, controls); a list of arrays if the numbers of controls differ."""
    cost: float
    """Cost."""
    initial_cost: float
    """Cost of the controls before the first iteration; infinite if their dynamics failed."""
    failed: int
    """Failed samples of all iterations."""
    termination: str
    """Reason for the end. A sampling has no test of optimality, so it never converges."""
    log: list[SamplingIteration] = field(repr=False)
    """Iterations."""
    nq: int = field(default=0, repr=False)
    """Number of coordinates of q; 0 for plain numbers."""

    @property
    def q(self) -> Array:
        """Configurations (N + 1, nq)."""
        return self.states[:, : self.nq]

    @property
    def v(self) -> Array:
        """Velocities (N + 1, nv); the states themselves for plain numbers."""
        return self.states[:, self.nq :]


class MpcTimes(NamedTuple):
    """Times of the periods of a controller, the first without [s]."""

    periods: int
    """Number of periods."""
    median: float
    """Median [s]."""
    percentile_99_9: float
    """Time that 99.9 % of the periods do not exceed [s]."""
    longest: float
    """Longest period [s]."""
    over_budget: int
    """Number of periods that took longer than the budget."""


class Problem:
    """Optimal control problem with N nodes.

    Parameters
    ----------
    dynamics : SmoothStep, SimulationStep, HeldContactStep, ImpactStep or LinearDynamics
        Step f of all nodes.
    initial_state : array_like, shape (nq + nv,), or a pair of arrays (q, v)
        x_0.
    nodes : int
        N.

    Raises
    ------
    ControlError
        There are no nodes or no controls, or the state is invalid.
    ShapeError
        An array has the wrong shape.
    SimulationInputError
        The step or the integrator is invalid.
    TypeError
        The dynamics are of another type.
    """

    def __init__(self, dynamics: Dynamics, initial_state: State, *, nodes: int) -> None:
        self._native = _native.OptimalProblem(dynamics, initial_state, nodes)

    def __repr__(self) -> str:
        return f"<Problem with {self.nodes} nodes>"

    @property
    def nodes(self) -> int:
        """Number of nodes N."""
        return self._native.nodes

    @property
    def controls(self) -> list[int]:
        """Number of controls of each node (N,)."""
        return self._native.controls

    def set_initial_state(self, state: State) -> None:
        """Change x_0.

        Parameters
        ----------
        state : array_like, shape (nq + nv,), or a pair of arrays (q, v)
            New x_0.

        Raises
        ------
        ControlError
            The state is invalid.
        ShapeError
            It has the wrong shape.
        """
        self._native._set_initial_state(state)

    def set_dynamics(self, dynamics: Dynamics, *, nodes: Nodes) -> None:
        """Give some nodes other dynamics, as the phases of a gait have.

        If the number of controls changes, these nodes lose their cost and bounds.

        Parameters
        ----------
        dynamics : SmoothStep, SimulationStep, HeldContactStep, ImpactStep or LinearDynamics
            Step of these nodes, of the same robot.
        nodes : int, range or slice
            The nodes.

        Raises
        ------
        ControlError
            The states are those of another robot.
        IndexError
            A node does not exist.
        """
        self._native._set_dynamics(*_range(nodes, self.nodes), dynamics)

    def set_running_cost(self, *terms: LeastSquares, nodes: Nodes = None) -> None:
        """Set the cost ℓ_k of some nodes: the sum of terms. It replaces their earlier cost.

        Parameters
        ----------
        *terms : LeastSquares
            Terms of the cost.
        nodes : int, range or slice, optional
            The nodes; default: all.

        Raises
        ------
        ControlError
            A weight or a target is invalid.
        FrameError
            A frame does not exist.
        ShapeError
            A target has the wrong shape.
        IndexError
            A node does not exist.
        TypeError
            A term is of another type.
        """
        self._native._set_running_cost(*_range(nodes, self.nodes), list(terms))

    def set_terminal_cost(self, *terms: LeastSquares) -> None:
        """Set the cost ℓ_N of the last state: the sum of terms.

        Parameters
        ----------
        *terms : LeastSquares
            Terms of the cost, which must not depend on controls.

        Raises
        ------
        ControlError
            A weight or a target is invalid, or a term depends on controls.
        FrameError
            A frame does not exist.
        ShapeError
            A target has the wrong shape.
        TypeError
            A term is of another type.
        """
        self._native._set_terminal_cost(list(terms))

    def set_control_bounds(
        self, lower: Numbers | float | None, upper: Numbers | float | None, *, nodes: Nodes = None
    ) -> None:
        """Bound the controls of some nodes.

        Parameters
        ----------
        lower, upper : array_like, shape (controls,), float or None
            Bounds: one number for all, or one each; `None` for no bound.
        nodes : int, range or slice, optional
            The nodes; default: all.

        Raises
        ------
        ControlError
            A lower bound is above its upper bound.
        ShapeError
            A bound has the wrong shape.
        IndexError
            A node does not exist.
        """
        self._native._set_control_bounds(*_range(nodes, self.nodes), lower, upper)

    def set_effort_limits(self, *, nodes: Nodes = None) -> None:
        """Bound the controls of some nodes by the effort limits of the robot's joints.

        Parameters
        ----------
        nodes : int, range or slice, optional
            The nodes; default: all.

        Raises
        ------
        ControlError
            The controls are not those of the motors.
        IndexError
            A node does not exist.
        """
        self._native._set_effort_limits(*_range(nodes, self.nodes))

    def add_constraint(
        self,
        residual: Residual,
        lower: Numbers | float | None,
        upper: Numbers | float | None,
        *,
        nodes: Nodes = None,
    ) -> None:
        """Add l ≤ c(x, u) ≤ h at some nodes; equal bounds are an equality.

        Parameters
        ----------
        residual : Residual
            c(x, u).
        lower, upper : array_like, shape (dimension,), float or None
            Bounds: one number for all, or one each; `None` for no bound.
        nodes : int, range or slice, optional
            The nodes; default: all.

        Raises
        ------
        ControlError
            A bound or a target is invalid.
        FrameError
            A frame does not exist.
        ShapeError
            An array has the wrong shape.
        IndexError
            A node does not exist.
        """
        self._native._add_constraint(*_range(nodes, self.nodes), residual, lower, upper)

    def add_terminal_constraint(
        self, residual: Residual, lower: Numbers | float | None, upper: Numbers | float | None
    ) -> None:
        """Add l ≤ c(x_N) ≤ h at the last state; equal bounds are an equality.

        Parameters
        ----------
        residual : Residual
            c(x), which must not depend on controls.
        lower, upper : array_like, shape (dimension,), float or None
            Bounds: one number for all, or one each; `None` for no bound.

        Raises
        ------
        ControlError
            A bound or a target is invalid, or c depends on controls.
        FrameError
            A frame does not exist.
        ShapeError
            An array has the wrong shape.
        """
        self._native._add_terminal_constraint(residual, lower, upper)

    def solve(
        self,
        start: Solution | None = None,
        *,
        states: Numbers | Sequence[Numbers] | None = None,
        controls: Numbers | Sequence[Numbers] | None = None,
        max_iterations: int = defaults.OPTIMAL_MAX_ITERATIONS,
        gradient_tolerance: float = defaults.OPTIMAL_GRADIENT_TOLERANCE,
        defect_tolerance: float = defaults.OPTIMAL_DEFECT_TOLERANCE,
        decrease_tolerance: float = defaults.OPTIMAL_DECREASE_TOLERANCE,
        constraint_tolerance: float = defaults.OPTIMAL_CONSTRAINT_TOLERANCE,
        threads: int = 1,
        time_limit: float | None = None,
        callback: Callable[[Iteration], object] | None = None,
    ) -> Solution:
        """Find controls that minimise the cost.

        The result is a local minimum, which depends on the start. Without a start, all states are x_0 and all
        controls zero. Ctrl-C ends the call.

        Parameters
        ----------
        start : Solution, optional
            Solution from which to start.
        states : array_like, shape (N + 1, nq + nv), optional
            States from which to start; they need not satisfy the dynamics. Needs `controls`.
        controls : array_like, shape (N, controls), optional
            Controls from which to start; without `states`, they are rolled out from x_0.
        max_iterations : int
            Largest number of iterations; with constraints, of each inner solution.
        gradient_tolerance : float
            Largest derivative of the Lagrangian by a control that is not at its bound.
        defect_tolerance : float
            Largest entry of a defect.
        decrease_tolerance : float
            The solver ends below this predicted decrease of the cost, relative to it.
        constraint_tolerance : float
            Largest violation of a constraint.
        threads : int
            Threads that linearise the nodes.
        time_limit : float, optional
            The solver starts no iteration after this time [s].
        callback : callable, optional
            Function of an `Iteration`, called after each; a true result ends the solver.

        Returns
        -------
        Solution
            The trajectory. `is_solved` and `termination` tell whether and why the solver ended.

        Raises
        ------
        ControlError
            An option is invalid, or the dynamics or a cost cannot be computed along the start.
        ShapeError
            An array has the wrong shape.
        ValueError
            Both `start` and arrays are given, or states without controls.
        """
        if start is not None:
            if states is not None or controls is not None:
                raise ValueError("give start, or states and controls, not both")
            states, controls = start.states, start.controls
        if states is not None and controls is None:
            raise ValueError("states need controls; give both, or controls alone")
        options = {
            "max_iterations": max_iterations,
            "gradient_tolerance": gradient_tolerance,
            "defect_tolerance": defect_tolerance,
            "decrease_tolerance": decrease_tolerance,
            "threads": threads,
            "time_limit": time_limit,
        }
        told = None if callback is None else lambda fields: callback(Iteration(*fields))
        record = self._native._solve(options, constraint_tolerance, _rows(states, controls), told)
        return _solution(record, self._native._sizes()[0])

    def sample(
        self,
        deviation: Numbers | float,
        *,
        law: Literal["mppi", "cross_entropy"] = "mppi",
        temperature: float = 1.0,
        elites: int = 16,
        least_deviation: float = 0.05,
        samples: int = 256,
        iterations: int = 20,
        correlation: float = 0.0,
        seed: int = 0,
        threads: int = 1,
        time_limit: float | None = None,
        controls: Numbers | Sequence[Numbers] | None = None,
    ) -> SampledSolution:
        """Improve controls by random samples, without derivatives.

        For costs and dynamics without useful derivatives, or to find a start for `solve`. Bounds on the
        controls hold; constraints must be costs. The result depends on the seed, not on the number of
        threads.

        Parameters
        ----------
        deviation : array_like, shape (controls,), or float
            Standard deviation of each control.
        law : {"mppi", "cross_entropy"}
            Model predictive path integrals: the mean becomes the average of all samples with weights
            exp(−(J − J_min)/temperature). Cross entropy: mean and deviation become those of the best samples.
        temperature : float
            Temperature of ``"mppi"``, in the unit of the cost.
        elites : int
            Number of best samples of ``"cross_entropy"``.
        least_deviation : float
            Smallest deviation of ``"cross_entropy"``, as a share of the first.
        samples : int
            Samples of an iteration.
        iterations : int
            Number of iterations.
        correlation : float
            Correlation of the noise of consecutive nodes, from 0 to below 1.
        seed : int
            Seed of the random numbers.
        threads : int
            Threads that evaluate samples.
        time_limit : float, optional
            No iteration starts after this time [s].
        controls : array_like, shape (N, controls), optional
            Controls from which to start; default: those nearest to zero within their bounds.

        Returns
        -------
        SampledSolution
            The best controls and their states.

        Raises
        ------
        ControlError
            An option is invalid, the problem has constraints, or all samples of an iteration failed.
        ValueError
            The law does not exist.
        """
        options = {
            "law": law,
            "deviation": deviation,
            "temperature": temperature,
            "elites": elites,
            "least_deviation": least_deviation,
            "samples": samples,
            "iterations": iterations,
            "correlation": correlation,
            "seed": seed,
            "threads": threads,
            "time_limit": time_limit,
        }
        record = self._native._sample(options, _rows(None, controls))
        log = [SamplingIteration(*fields) for fields in record.pop("log")]
        found = _equal_rows(record.pop("controls"))
        return SampledSolution(**record, controls=found, log=log, nq=self._native._sizes()[0])


class Mpc:
    """Model predictive controller: it solves a problem again at each period, from the measured state.

    One period is one node. A step shifts the last solution by a node, improves it by a few iterations and
    returns the first controls.

    Parameters
    ----------
    problem : Problem
        Problem without constraints beyond the bounds of controls; later changes of it do not count.
    start : Solution, optional
        Solution from which the first period starts.
    iterations : int
        Largest number of iterations of each period but the first.
    time_budget : float, optional
        Time of a period [s]: after the first iteration none starts that would exceed it.
    max_iterations : int
        Largest number of iterations of the first period.
    threads : int
        Threads that linearise the nodes.

    Raises
    ------
    ControlError
        An option is invalid, or the problem has constraints.

    Examples
    --------
    >>> mass = rd.optimal.LinearDynamics([[1.0, 0.1], [0.0, 1.0]], [[0.005], [0.1]])
    >>> problem = rd.optimal.Problem(mass, [1.0, 0.0], nodes=30)
    >>> at_rest = rd.optimal.LeastSquares(rd.optimal.StateResidual([0.0, 0.0]), [1.0, 0.1])
    >>> problem.set_running_cost(at_rest, rd.optimal.LeastSquares(rd.optimal.ControlResidual(), 0.01))
    >>> problem.set_control_bounds(-0.5, 0.5)
    >>> mpc, x = rd.optimal.Mpc(problem), np.array([1.0, 0.0])
    >>> for _ in range(100):
    ...     x = np.array([[1.0, 0.1], [0.0, 1.0]]) @ x + np.array([0.005, 0.1]) * mpc.step(x)
    >>> bool(np.linalg.norm(x) < 0.01), mpc.times.periods
    (True, 99)
    """

    def __init__(
        self,
        problem: Problem,
        start: Solution | None = None,
        *,
        iterations: int = 2,
        time_budget: float | None = None,
        max_iterations: int = defaults.OPTIMAL_MAX_ITERATIONS,
        threads: int = 1,
    ) -> None:
        options = {
            "max_iterations": max_iterations,
            "gradient_tolerance": defaults.OPTIMAL_GRADIENT_TOLERANCE,
            "defect_tolerance": defaults.OPTIMAL_DEFECT_TOLERANCE,
            "decrease_tolerance": defaults.OPTIMAL_DECREASE_TOLERANCE,
            "threads": threads,
            "time_limit": None,
        }
        rows = _rows(None, None) if start is None else _rows(start.states, start.controls)
        self._nodes, self._nq = problem.nodes, problem._native._sizes()[0]
        self._native = _native.OptimalMpc(problem._native, options, iterations, time_budget, rows)

    def step(self, state: State) -> Array:
        """Compute the controls of the next period.

        Parameters
        ----------
        state : array_like, shape (nq + nv,), or a pair of arrays (q, v)
            Measured state.

        Returns
        -------
        ndarray, shape (controls,)
            The controls.

        Raises
        ------
        ControlError
            The state is invalid, or the dynamics cannot be computed along the plan.
        ShapeError
            The state has the wrong shape.
        """
        return self._native._next_controls(state)

    def set_running_cost(self, *terms: LeastSquares, nodes: Nodes = None) -> None:
        """Change the cost of some nodes, for example its target; the plan stays.

        Parameters
        ----------
        *terms : LeastSquares
            Terms of the cost.
        nodes : int, range or slice, optional
            The nodes; default: all.

        Raises
        ------
        ControlError
            A weight or a target is invalid.
        FrameError
            A frame does not exist.
        ShapeError
            A target has the wrong shape.
        IndexError
            A node does not exist.
        """
        self._native._set_running_cost(*_range(nodes, self._nodes), list(terms))

    def set_terminal_cost(self, *terms: LeastSquares) -> None:
        """Change the cost of the last state; the plan stays.

        Parameters
        ----------
        *terms : LeastSquares
            Terms of the cost.

        Raises
        ------
        ControlError
            A weight or a target is invalid, or a term depends on controls.
        FrameError
            A frame does not exist.
        ShapeError
            A target has the wrong shape.
        """
        self._native._set_terminal_cost(list(terms))

    @property
    def plan(self) -> Solution:
        """Plan of the last step.

        Raises
        ------
        ControlError
            There was no step yet.
        """
        return _solution(self._native._plan(), self._nq)

    @property
    def times(self) -> MpcTimes:
        """Times of the periods so far, the first without."""
        return MpcTimes(*self._native._times())


Rows: TypeAlias = tuple[list[Array] | None, list[Array] | None]


def _rows(states: Any, controls: Any) -> Rows:
    """States and controls by node."""
    by_node = [None if part is None else [np.asarray(row) for row in part] for part in (states, controls)]
    return by_node[0], by_node[1]


def _equal_rows(rows: list[Array]) -> Array | list[Array]:
    """One array if all rows have the same length."""
    return np.stack(rows) if len({len(row) for row in rows}) == 1 else rows


def _solution(record: dict[str, Any], nq: int) -> Solution:
    """Result of the native half."""
    controls, gains = _equal_rows(record.pop("controls")), _equal_rows(record.pop("gains"))
    log = [Iteration(*fields) for fields in record.pop("log")]
    return Solution(**record, controls=controls, gains=gains, log=log, nq=nq)


def _range(nodes: Nodes, count: int) -> tuple[int, int]:
    """First node and the end of a range of nodes."""
    if nodes is None:
        return 0, count
    if isinstance(nodes, slice):
        nodes = range(*nodes.indices(count))
    if not isinstance(nodes, range):
        nodes = range(nodes, nodes + 1)
    if nodes.step != 1 or not 0 <= nodes.start < nodes.stop <= count:
        raise IndexError(f"nodes = {nodes} must be consecutive nodes among 0 to {count - 1}")
    return nodes.start, nodes.stop
