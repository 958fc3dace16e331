"""The native half of `robot_dynamics`; use that package. Written by `stubs.py`."""

from collections.abc import Callable, Mapping, Sequence
from os import PathLike
from pathlib import Path
from typing import Any, Self, TypeAlias, TypeVar, final, overload

import numpy as np
from numpy.typing import NDArray
from typing_extensions import disjoint_base

from robot_dynamics.numbers import ControlReference, Numbers, ReferenceFrame
from robot_dynamics.results import DissipationPullback, ForwardDynamicsDerivatives, ForwardDynamicsPullback, ForwardDynamicsPullbackWithParameters, ForwardDynamicsSecondDerivatives, FrameAccelerationDerivatives, InverseDynamicsDerivatives, InverseDynamicsPullback, InverseDynamicsPullbackWithParameters, InverseDynamicsSecondDerivatives

_F = TypeVar("_F", np.float64, np.float32)

_Array: TypeAlias = NDArray[np.float64]
_Path: TypeAlias = str | PathLike[str]
_Three: TypeAlias = Sequence[float]
# Kind, axis, second axis and pitch of a joint.
_JointWords: TypeAlias = tuple[str, _Three, _Three, float]
# The fields of a class of the Python half, which states their types.
_Record: TypeAlias = dict[str, Any]
# States and controls by node.
_Rows: TypeAlias = tuple[Sequence[object] | None, Sequence[object] | None]
# Arrays of numpy, or addresses of a device and counts of numbers.
_Memory: TypeAlias = Sequence[object]
# Names and shapes of tables.
_Tables: TypeAlias = list[tuple[str, list[int]]]

__all__ = ['Admittance', 'BaseParameters', 'ComputedTorque', 'Constraints', 'ControlAllocation', 'CpuFunctions', 'CudaDevice', 'CudaFunctions', 'Delayed', 'GravityCompensatedPd', 'ImpedanceControl', 'ImplicitGains', 'JerkLimitedMotion', 'JointMap', 'KinematicTasks', 'MomentumObserver', 'OptimalMpc', 'OptimalProblem', 'PayloadFilter', 'PolynomialMotion', 'ReachableSet', 'Robot', 'Scene', 'Simulation', 'SimulationBatch', 'Snapshot', 'TaskControl', 'WholeBody', '__version__', '_contact_links', '_defaults', '_device_signature', '_html', '_nanoseconds', '_random_robot', '_trajectory_text', '_visible', '_write_text', '_xla_handlers', 'dlqr', 'example_text', 'num_threads', 'quantities', 'set_num_threads']

__version__: str

def _contact_links(robot: Robot) -> list[str]:
    """The link of each contact point of a step with contact, in the order of its multipliers."""

def _defaults() -> _Record:
    """The default values of options that the Rust library defines."""

def _device_signature(robot: Robot, name: str) -> tuple[_Tables, _Tables]:
    """The tables that a function reads and writes: name and shape of each."""

def _html(text: str) -> str:
    """The text escaped for HTML, between tags or in an attribute."""

def _nanoseconds(robot: Robot, name: str, state: Sequence[Numbers], rounds: int) -> float:
    """The least time of one call of a quantity from Rust, over rounds of a hundred calls [ns]."""

def _random_robot(seed: int, joints: int, floating_base: bool) -> str:
    """See `random_robot`."""

def _trajectory_text(format: str, names: tuple[Sequence[str], Sequence[str]], times: Numbers, states: Sequence[Numbers]) -> str:
    """The text of a motion: `format` is `csv`, `json` or `yaml`, the last two of a ROS message."""

def _visible(text: str, keeps_lines: bool) -> str:
    """A text in which each invisible character is replaced by its escape; line ends stay if `keeps_lines`."""

def _write_text(path: _Path, text: str) -> None:
    """Writes a text file as a whole or not at all."""

def _xla_handlers() -> dict[str, object]:
    """The functions that programs of XLA call, by the names of their targets."""

def dlqr(a: Numbers, b: Numbers, q: Numbers, r: Numbers) -> _Record:
    """The gain K of u = −K x that minimises Σ xᵀQ x + uᵀR u along xₖ₊₁ = A xₖ + B uₖ, and its cost; see
    `robot_dynamics.dlqr`.
    """

def example_text(name: str) -> str:
    """The file of a robot that comes with the package, as text."""

def num_threads() -> int:
    """The number of threads that compute a batch by default.

    Returns
    -------
    int
        One per core, or the number that `set_num_threads` chose.

    Examples
    --------
    >>> rd.num_threads() >= 1
    True
    """

def quantities() -> list[tuple[str, list[str], int]]:
    """The library's table of algorithms: the name and the inputs of each. The tests check that each has a
    method.
    """

def set_num_threads(threads: int | None, /) -> None:
    """Chooses how many threads compute a batch by default.

    Results are the same bits for any number of threads. Workers of a cluster are processes side by side and
    should use one thread each.

    Parameters
    ----------
    threads : int or None
        Number of threads, from 1 to 4096; `None` for one per core.

    Raises
    ------
    ValueError
        The number is out of range.
    TypeError
        `threads` is not a whole number.

    Examples
    --------
    >>> rd.set_num_threads(1)
    >>> rd.num_threads()
    1
    >>> rd.set_num_threads(None)
    """

@final
class Admittance:
    """Moves a reference by a measured wrench: M ẍ + D ẋ + K x = f for its displacement x = (d, φ).

    The commanded position is pʳ + d, and the commanded rotation exp(φ) Rʳ, along the world's axes. A
    controller of the position follows it. Steps are exact for a wrench that is held. With K = 0 the frame can
    be led by hand.

    Parameters
    ----------
    inertia : array_like, shape (6,)
        M along x, y, z, rx, ry, rz [kg, kg·m²].
    damping : array_like, shape (6,)
        D [N·s/m, N·m·s/rad].
    stiffness : array_like, shape (6,)
        K [N/m, N·m/rad].

    Raises
    ------
    ShapeError
        An array has the wrong shape.
    ValueError
        An inertia is not positive, or a damping or a stiffness is negative.

    Examples
    --------

    >>> lead = rd.Admittance([2.0] * 6, [40.0] * 6, [0.0] * 6)
    >>> for _ in range(1000):
    ...     pose, velocity, acceleration = lead.step(np.eye(4), [8.0, 0.0, 0.0, 0.0, 0.0, 0.0], 1e-3)
    >>> float(velocity[0].round(9))  # 8 N against 40 N·s/m
    0.2
    """
    def __new__(cls, inertia: Numbers, damping: Numbers, stiffness: Numbers) -> Self: ...
    @property
    def displacement(self) -> NDArray[np.float64]:
        """Displacement (6,): d [m], then φ [rad]."""
    def reset(self) -> None:
        """Returns to the reference, at rest."""
    def step(self, reference: ControlReference, wrench: Numbers, dt: float) -> tuple[NDArray[np.float64], NDArray[np.float64], NDArray[np.float64]]:
        """Advances the displacement, and returns the command at the end: a reference of `TaskControl`.

        Parameters
        ----------
        reference : array_like, shape (4, 4), or tuple of three array_like
            Pose in the world, alone or with velocity (6,) and acceleration (6,) along the world's axes.
        wrench : array_like, shape (6,)
            Force, then moment about the frame's origin, along the world's axes [N, N·m].
        dt : float
            Step [s].

        Returns
        -------
        tuple of ndarray
            Commanded pose (4, 4), velocity (6,) and acceleration (6,).

        Raises
        ------
        ShapeError
            An array has the wrong shape.
        ValueError
            A number is not finite, or `dt` is not positive.
        """

@final
class BaseParameters:
    """The combinations β of inertial parameters that torques determine; `robot_dynamics.Robot.base_parameters`
    finds them.
    """
    def __len__(self, /) -> int: ...
    @property
    def combinations(self) -> NDArray[np.float64]:
        """The matrix of β = combinations · π."""
    @property
    def hidden(self) -> list[str]:
        """The changes of the parameters that change no torque, in words."""
    @property
    def invisible(self) -> list[str]:
        """The parameters that affect no torque."""
    @property
    def names(self) -> list[str]:
        """Each combination in words, for example `upper.Iyy + fore.m`."""
    def nearest_parameters(self, values: Numbers, nominal: Numbers) -> NDArray[np.float64]:
        """Finds the π nearest to a given one that has these β.

        Parameters
        ----------
        values : array_like, shape (combinations,)
            β, in the order of `names`.
        nominal : array_like, shape (10·moving links,)
            The given π, in the order of `Robot.inertial_parameter_names` [kg, kg·m, kg·m²].

        Returns
        -------
        ndarray, shape (10·moving links,)
            π with these β.

        Raises
        ------
        ShapeError
            An array has the wrong shape.
        IdentificationError
            A number is not finite.
        """
    def values(self, parameters: Numbers) -> NDArray[np.float64]:
        """Computes β = combinations · π.

        Parameters
        ----------
        parameters : array_like, shape (10·moving links,)
            π, in the order of `Robot.inertial_parameter_names` [kg, kg·m, kg·m²], and then the joint terms.

        Returns
        -------
        ndarray, shape (combinations,)
            β, in the order of `names`.

        Raises
        ------
        ShapeError
            The array has the wrong shape.
        IdentificationError
            A number is not finite.
        """

@final
class ComputedTorque:
    """Follows a motion: τ = M(q)(aʳ + Kp (qʳ ⊖ q) + Kd (vʳ − v)) + C v + g with diagonal gains.

    The error of plain coordinates obeys ë + Kd ė + Kp e = 0 whatever the robot. MLS §4.5. Coordinates without
    a motor (`robot.actuated_dofs`), as those of a floating base, have torque 0 and move freely. The others
    follow the motion in spite of it while nothing else touches the robot. The controller is a function of
    (t, q, v); in `simulate` it runs in the library.

    Parameters
    ----------
    robot : Robot
        Robot to control.
    reference : array_like, tuple of three array_like, or function
        Reference (qʳ, vʳ, aʳ), or qʳ alone at rest, or a function of t [s] that returns one of these.
    stiffness : array_like, shape (nv,)
        Kp [1/s²].
    damping : array_like, shape (nv,)
        Kd [1/s]; Kd = 2 √Kp is critically damped.
    dissipation : bool
        Whether to compensate the damping and friction of the joints.

    Raises
    ------
    StateError
        A number is not finite, or the reference is not a configuration.
    ShapeError
        An array has the wrong shape.

    Examples
    --------

    >>> robot = rd.example("two_r")
    >>> swing = lambda t: ([np.sin(t), np.cos(t)], [np.cos(t), -np.sin(t)], [-np.sin(t), -np.cos(t)])
    >>> follow = rd.ComputedTorque(robot, swing, [100.0, 100.0], [20.0, 20.0])
    >>> motion = robot.simulate([0.0, 0.5], tau=follow, duration=2.0, without=["effort-limits"])
    >>> bool(np.abs(motion.q[-1] - [np.sin(2.0), np.cos(2.0)]).max() < 1e-2)
    True
    """
    def __call__(self, t: float, q: Numbers, v: Numbers) -> NDArray[np.float64]: ...
    def __new__(cls, robot: Robot, reference: ControlReference | Callable[[float], ControlReference], stiffness: Numbers, damping: Numbers, *, dissipation: bool = False) -> Self: ...

@final
class Constraints:
    """Constraints of one robot, by name."""
    def __len__(self, /) -> int: ...
    def __new__(cls, robot: Robot, fields: Sequence[tuple[str, str, list[str], list[float], list[str]]]) -> Self: ...
    @property
    def row_names(self) -> list[str]:
        """The names of the rows, for example `pin.x`."""

@final
class ControlAllocation:
    """Controls of a robot's actuators whose joint torque is nearest to a given one.

    It minimizes ‖R f + c − τ‖² with f = diag(g) u + o, within the bounds of f and u. Redundant actuators
    share the torque with the least sum of squares of f. With τ = g(q) this is gravity compensation through
    gears, tendons and frames.

    Parameters
    ----------
    robot : Robot
        Robot with actuators.

    Raises
    ------
    ControlError
        The force of an actuator is not an affine function of its control.

    Examples
    --------

    >>> robot = rd.loads('''<mujoco><worldbody><body><joint name="hinge" axis="0 1 0"/>
    ...   <geom size="0.1" pos="0.5 0 0" mass="2"/></body></worldbody>
    ...   <actuator><motor joint="hinge" gear="50" ctrlrange="-1 1"/></actuator></mujoco>''')
    >>> controls, residual = rd.ControlAllocation(robot).controls([0.0], [0.0], robot.gravity([0.0]))
    >>> bool(np.isclose(controls[0] * 50.0, robot.gravity([0.0])[0])), residual < 1e-9
    (True, True)
    """
    def __new__(cls, robot: Robot) -> Self: ...
    def controls(self, q: Numbers, v: Numbers, tau: Numbers) -> tuple[NDArray[np.float64], float]:
        """Controls for a torque at a state.

        Parameters
        ----------
        q : array_like, shape (nq,)
            Configuration.
        v : array_like, shape (nv,)
            Velocity.
        tau : array_like, shape (nv,)
            Torque [N·m or N].

        Returns
        -------
        tuple of ndarray and float
            Controls, one for each actuator, and the largest difference between a coordinate's torque and τ.

        Raises
        ------
        ShapeError
            An array has the wrong shape.
        StateError
            A number is not finite, or q is not a configuration.
        """
    def motor_loads(self) -> NDArray[np.float64]:
        """Operation of the electric motors at the torque and the speed of the last call of `controls`.

        The winding is at ambient temperature, and the current does not change.

        Returns
        -------
        ndarray, shape (actuators, 4)
            Current [A], voltage [V], power that the motor takes [W], and the part of it that heats the
            winding [W]; NaN for an actuator without a motor.
        """

@final
class CpuFunctions:
    """Functions of a robot on this processor, with the arguments and results of those of a device."""
    def __new__(cls, robot: Robot, functions: Sequence[str], single: bool) -> Self: ...
    def _compute(self, name: str, inputs: _Memory, outputs: _Memory) -> None:
        """Computes a function on arrays of numpy, which are contiguous and of the compiled type."""
    def _xla_handle(self) -> int:
        """The number by which programs of XLA call these functions. They stay in memory from now on."""

@final
class CudaDevice:
    """A CUDA device."""
    def __new__(cls, ordinal: int, compiler: _Path | None = None) -> Self: ...
    def _compile(self, robot: Robot, functions: Sequence[str], single: bool) -> CudaFunctions:
        """Compiles functions of a robot."""
    @property
    def name(self) -> str:
        """Name of the device."""

@final
class CudaFunctions:
    """Functions of a robot that are compiled for a CUDA device."""
    def _compute(self, name: str, inputs: _Memory, outputs: _Memory, stream: int, columns: bool) -> None:
        """Computes a function on memory of the device: addresses, and their counts of numbers."""
    def _rollout(self, name: str, steps: int, states: Sequence[_Memory], held: _Memory, outputs: _Memory, stream: int, columns: bool) -> None:
        """Computes steps in places for states."""
    def _xla_handle(self) -> int:
        """The number by which programs of XLA call these functions. They stay in memory from now on."""

@final
class Delayed:
    """A law whose torque acts after a delay, as through a bus or a computer.

    τ(t) is the torque of the law's last call at or before t − d, and 0 until the first torque arrives. It is
    a torque of `simulate`, which calls it at every step.

    Parameters
    ----------
    robot : Robot
        Robot to control.
    law : function or controller
        Function of (t, q, v) that returns τ (nv,), or a controller of this package.
    delay : float
        d [s].

    Raises
    ------
    ControlError
        The delay is not positive.

    Examples
    --------

    >>> robot = rd.example("two_r")
    >>> late = rd.Delayed(robot, lambda t, q, v: [1.0, 0.0], 0.05)
    >>> motion = robot.simulate([0.0, 0.0], tau=late, duration=0.1, dt=0.01)
    >>> motion.tau[:, 0].tolist()
    [0.0, 0.0, 0.0, 0.0, 0.0, 1.0, 1.0, 1.0, 1.0, 1.0, 1.0]
    """
    def __new__(cls, robot: Robot, law: Callable[[float, NDArray[np.float64], NDArray[np.float64]], Numbers], delay: float) -> Self: ...

@final
class GravityCompensatedPd:
    """Holds a pose: τ = g + Kp (qʳ ⊖ q) − Kd v with diagonal gains, each coordinate cut off at its effort limit.

    Coordinates without a motor (`robot.actuated_dofs`), as those of a floating base, have torque 0. The
    controller is a function of (t, q, v); in `simulate` it runs in the library.

    Parameters
    ----------
    robot : Robot
        Robot to control.
    target : array_like, shape (nq,)
        Configuration qʳ to hold.
    stiffness : array_like, shape (nv,)
        Kp [N·m/rad or N/m].
    damping : array_like, shape (nv,)
        Kd [N·m·s/rad or N·s/m].
    limits : array_like, shape (nv,), optional
        Largest torques [N·m or N]; default: the effort limits of the robot.
    gravity_at : {"target", "state"}
        Configuration at which g is computed: `target`, or that of the robot.
    implicit_period : float, optional
        How long each torque is held [s]. The gains then act at the end of that time, and the law is stable at
        any stiffness: see `ImplicitGains`.

    Raises
    ------
    StateError
        A number is not finite, or `target` is not a configuration.
    ShapeError
        An array has the wrong shape.
    ControlError
        `implicit_period` is not positive, or a gain is negative with it.
    ValueError
        A limit is negative, or `gravity_at` is unknown.

    Examples
    --------

    >>> robot = rd.example("panda")
    >>> hold = rd.GravityCompensatedPd(robot, np.full(7, 0.2), np.full(7, 50.0), np.full(7, 10.0), gravity_at="state")
    >>> motion = robot.simulate(np.zeros(7), tau=hold, duration=0.5, dt=1e-4, sample_period=0.01, without=["limits"])
    >>> bool(np.abs(motion.q[-1] - 0.2).max() < np.abs(motion.q[0] - 0.2).max())
    True
    """
    def __call__(self, t: float, q: Numbers, v: Numbers) -> NDArray[np.float64]: ...
    def __new__(cls, robot: Robot, target: Numbers, stiffness: Numbers, damping: Numbers, *, limits: Numbers | None = None, gravity_at: str = 'target', implicit_period: float | None = None) -> Self: ...

@final
class ImpedanceControl:
    """Makes a frame answer a wrench f as a damped spring: Λ (ẍ − ẍʳ) = D ė + K e + f with e = xʳ ⊖ x.

    τ = Jᵀ(Λ ẍʳ + D ė + K e + μ + p) + (1 − JᵀJ̄ᵀ) τ₀. The frame keeps its own inertia Λ, and f is not
    measured. With `inertia`, M_d (ẍ − ẍʳ) = D ė + K e + f for a constant diagonal M_d; that needs the
    measured `wrench`. Gains are along the world's axes x, y, z, rx, ry, rz. Null space, rows, damping near
    singular poses and effort limits are those of `TaskControl`. The controller is a function of (t, q, v); in
    `simulate` it runs in the library.

    Parameters
    ----------
    robot : Robot
        Robot to control.
    frame : str or int
        Name of the frame, or its index in `frame_names`.
    reference : array_like, tuple of three array_like, or function
        Target of the frame, as for `TaskControl`.
    stiffness : array_like, shape (6,)
        K [N/m, N·m/rad].
    damping : array_like, shape (6,)
        D [N·s/m, N·m·s/rad].
    null_damping : float
        kn, damping in the null space [1/s].
    inertia : array_like, shape (6,), optional
        M_d [kg, kg·m²]; default: the frame's own Λ.
    wrench : array_like, shape (6,), or function, optional
        Force and moment that the environment exerts at the sensor, along the sensor's axes [N, N·m]. A
        function of t [s] returns them. It is needed with `inertia`.
    sensor : str or int, optional
        Frame of the sensor, on the link of `frame`; default: `frame`.
    rows : sequence of str, optional
        Controlled directions, as for `TaskControl`.
    posture : array_like, shape (nq,), optional
        Configuration qʳ to which the null space is pulled.
    posture_stiffness : float
        kr [1/s²].
    limits : array_like, shape (nv,), optional
        Largest torques [N·m or N]; default: the effort limits of the robot.

    Raises
    ------
    FrameError
        A frame does not exist.
    ShapeError
        An array has the wrong shape.
    StateError
        `posture` is not a configuration.
    ControlError
        A gain is invalid, or the sensor is on another link.
    ValueError
        A row is unknown, given twice, or a turn of a reference without orientation; a limit is negative; or
        only one of `inertia` and `wrench` is given.

    Examples
    --------

    >>> robot, q = rd.example("panda"), np.array([0.0, 0.3, 0.0, -1.8, 0.0, 2.0, 0.6])
    >>> here = robot.frame_pose(q, "panda_link8")
    >>> soft = rd.ImpedanceControl(robot, "panda_link8", here, stiffness=[400, 400, 400, 30, 30, 30],
    ...                            damping=[40, 40, 40, 3, 3, 3], null_damping=5.0)
    >>> sim = rd.Simulation(robot, dt=1e-3)
    >>> sim.reset(q)
    >>> sim.apply_wrench("panda_link8", force=(0.0, 8.0, 0.0))
    >>> for _ in range(3000):
    ...     sim.torques = soft(sim.time, sim.q, sim.v)
    ...     sim.step()
    >>> bool(abs((robot.frame_pose(sim.q, "panda_link8") - here)[1, 3] - 8.0 / 400.0) < 2e-3)  # f / K
    True
    """
    def __call__(self, t: float, q: Numbers, v: Numbers) -> NDArray[np.float64]: ...
    def __new__(cls, robot: Robot, frame: str | int, reference: ControlReference | Callable[[float], ControlReference], *, stiffness: Numbers, damping: Numbers, null_damping: float = 0.0, inertia: Numbers | None = None, wrench: Numbers | Callable[[float], Numbers] | None = None, sensor: str | int | None = None, rows: Sequence[str] | None = None, posture: Numbers | None = None, posture_stiffness: float = 0.0, limits: Numbers | None = None) -> Self: ...

@final
class ImplicitGains:
    """Makes a law of one's own stable at any stiffness: its gains act at the end of the control period.

    The law's torque at (q, v) is τ₀, and its gains are K = −∂τ/∂q and D = −∂τ/∂v. The result is
    τ = τ₀ − K h (v + h a) − D h a, with a from (M + h D + h² K) a = τ₀ − C v − g − h K v.

    A robot that is held by τ for h moves as under the linearly implicit Euler method. (Tan, Liu, Turk 2011)
    The controller is a function of (t, q, v), for `simulate` and for steps of `Simulation`.

    Parameters
    ----------
    robot : Robot
        Robot to control.
    law : function or controller
        Function of (t, q, v) that returns τ₀ (nv,), not clipped; or a controller of this package.
    stiffness : array_like, shape (nv,)
        K [N·m/rad or N/m].
    damping : array_like, shape (nv,)
        D [N·m·s/rad or N·s/m].
    period : float
        h, how long each torque is held [s].
    limits : array_like, shape (nv,), optional
        Largest torques [N·m or N]; default: the effort limits of the robot.

    Raises
    ------
    ShapeError
        An array has the wrong shape.
    StateError
        A number is not finite.
    ControlError
        A gain is negative, or `period` is not positive.
    ValueError
        A limit is negative.

    Examples
    --------

    >>> robot, home = rd.example("panda"), np.array([0.0, -0.4, 0.0, -2.2, 0.0, 1.9, 0.8])
    >>> kp, kd = np.full(7, 1e6), np.full(7, 10.0)
    >>> law = rd.ImplicitGains(robot, lambda t, q, v: kp * (home - q) - kd * v, kp, kd, 1e-3)
    >>> motion = robot.simulate(home + 0.01, tau=law, duration=1.0, dt=1e-3)
    >>> bool(np.abs(motion.q[-1] - home).max() < 1e-4)
    True
    """
    def __call__(self, t: float, q: Numbers, v: Numbers) -> NDArray[np.float64]: ...
    def __new__(cls, robot: Robot, law: Callable[[float, NDArray[np.float64], NDArray[np.float64]], Numbers], stiffness: Numbers, damping: Numbers, period: float, *, limits: Numbers | None = None) -> Self: ...

@disjoint_base
class JerkLimitedMotion:
    """The native half of `robot_dynamics.OnlineMotion`."""
    def __new__(cls, robot: Robot, period: float, acceleration: Numbers, jerk: Numbers, velocity: Numbers | None, lower: Numbers | None, upper: Numbers | None) -> Self: ...
    def _follow_target(self, q: Numbers, v: Numbers | None, a: Numbers | None) -> None:
        """See `follow_target`."""
    def _put_state(self, q: Numbers, v: Numbers | None, a: Numbers | None) -> None:
        """See `set_state`."""
    def _put_target(self, q: Numbers, v: Numbers | None, a: Numbers | None) -> None:
        """See `set_target`."""
    def _remaining(self) -> float:
        """See `plan`."""
    def _state_row(self, number: int) -> NDArray[np.float64]:
        """The row of the state: 0 for q, 1 for v, 2 for a, 3 for the jerk."""
    def _take_step(self) -> bool:
        """See `step`."""

@final
class JointMap:
    """Converts q and v between a robot with joints locked and the whole robot.

    Parameters
    ----------
    full : Robot
        The whole robot.
    reduced : Robot
        The part: the same robot with joints locked.
    reference : array_like, shape (nq of the whole robot,), optional
        Configuration in which the locked joints stay; default: that of `Robot.lock`.

    Raises
    ------
    DescriptionError
        The part is not the whole robot with joints locked.
    StateError
        `reference` is invalid.
    ShapeError
        `reference` has the wrong shape.

    Examples
    --------
    >>> whole = rd.example("panda")
    >>> part = whole.lock("panda_joint7")
    >>> joints = rd.JointMap(whole, part)
    >>> joints.expand_velocity(np.ones(part.nv))
    array([1., 1., 1., 1., 1., 1., 0.])
    """
    def __new__(cls, full: Robot, reduced: Robot, reference: Numbers | None = None) -> Self: ...
    def expand_configuration(self, q: Numbers) -> NDArray[np.float64]:
        """Computes the whole robot's q from the part's q.

        Parameters
        ----------
        q : array_like, shape (nq of the part,)
            Configuration of the part.

        Returns
        -------
        ndarray, shape (nq of the whole robot,)
            Configuration of the whole robot.

        Raises
        ------
        StateError
            `q` is invalid.
        ShapeError
            `q` has the wrong shape.
        """
    def expand_velocity(self, v: Numbers) -> NDArray[np.float64]:
        """Computes the whole robot's v from the part's v; it is 0 for the locked joints.

        Parameters
        ----------
        v : array_like, shape (nv of the part,)
            Velocity of the part [rad/s or m/s].

        Returns
        -------
        ndarray, shape (nv of the whole robot,)
            Velocity of the whole robot [rad/s or m/s].

        Raises
        ------
        StateError
            `v` is invalid.
        ShapeError
            `v` has the wrong shape.
        """
    @property
    def locked_joints(self) -> list[str]:
        """The joints that are locked in the part."""
    @property
    def q_indices(self) -> list[int]:
        """The indices of the part's q in the whole robot's q."""
    def restrict_configuration(self, q: Numbers) -> NDArray[np.float64]:
        """Computes the part's q from the whole robot's q.

        Parameters
        ----------
        q : array_like, shape (nq of the whole robot,)
            Configuration of the whole robot.

        Returns
        -------
        ndarray, shape (nq of the part,)
            Configuration of the part.

        Raises
        ------
        StateError
            `q` is invalid.
        ShapeError
            `q` has the wrong shape.
        """
    def restrict_velocity(self, v: Numbers) -> NDArray[np.float64]:
        """Computes the part's v from the whole robot's v.

        Parameters
        ----------
        v : array_like, shape (nv of the whole robot,)
            Velocity of the whole robot [rad/s or m/s].

        Returns
        -------
        ndarray, shape (nv of the part,)
            Velocity of the part [rad/s or m/s].

        Raises
        ------
        StateError
            `v` is invalid.
        ShapeError
            `v` has the wrong shape.
        """
    @property
    def v_indices(self) -> list[int]:
        """The indices of the part's v in the whole robot's v."""

@disjoint_base
class KinematicTasks:
    """The native half of `robot_dynamics.TaskKinematics`."""
    def __new__(cls, robot: Robot) -> Self: ...
    def _add_task(self, objective: object, law: tuple[float, int, float, float]) -> int:
        """See `add_pose`, `add_center_of_mass`, `add_posture`, `add_look_at` and `add_constraints`."""
    def _avoid_collisions(self, least_distance: float, range: float, gain: float) -> None:
        """See `avoid_collisions`."""
    def _find(self, start: Numbers, search: tuple[float, float, int, int, int]) -> _Record:
        """See `solve`."""
    def _find_many(self, task: int, objectives: Sequence[tuple[object, ...]], starts: Sequence[Numbers], search: tuple[float, float, int, int, int], threads: int | None) -> list[tuple[bool, _Record]]:
        """See `solve_many`."""
    def _next_step(self, q: Numbers, v: Numbers | None, dt: float) -> _Record:
        """See `step`."""
    def _set_damping(self, damping: float) -> None:
        """See `set_damping`."""
    def _set_limits(self, lower: Numbers | None, upper: Numbers | None, velocity: Numbers | None, acceleration: Numbers | None, position_gain: float) -> None:
        """See `set_limits`."""
    def _set_objective(self, task: int, objective: object) -> None:
        """See `set_target`."""
    def _set_weight(self, task: int, weight: float) -> None:
        """See `set_weight`."""

@final
class MomentumObserver:
    """Estimates the external torque of a robot, such as that of a collision, without accelerations.

    ṙ = K (τ_ext − r), where τ_ext = ṗ − Ṁ v + C v + g − τ and p = M v: r is τ_ext through a filter of first
    order with the time constant 1/K. Friction of the joints (without `dissipation`), contacts, closed loops
    and errors of the masses belong to τ_ext. The wrench at a frame is
    `robot.operational_space(q, v, frame, rows).consistent_inverse.T @ r`. (De Luca, Mattone 2005)

    Parameters
    ----------
    robot : Robot
        Observed robot.
    gains : array_like, shape (nv,)
        K [1/s].
    thresholds : array_like, shape (nv,), optional
        |r| above which a coordinate counts as in collision [N·m or N].
    dissipation : bool
        Whether damping and friction of the model's joints are known.

    Raises
    ------
    ShapeError
        An array has the wrong shape.
    StateError
        A gain is not finite.
    ControlError
        A gain is not positive, or a threshold is negative.

    Examples
    --------

    >>> robot, q = rd.example("panda"), np.array([0.0, 0.3, 0.0, -1.8, 0.0, 2.0, 0.6])
    >>> observer = rd.MomentumObserver(robot, np.full(7, 100.0), thresholds=np.full(7, 2.0))
    >>> hold = rd.GravityCompensatedPd(robot, q, np.full(7, 400.0), np.full(7, 40.0), gravity_at="state")
    >>> sim = rd.Simulation(robot, dt=1e-3, without=["dissipation"])
    >>> sim.reset(q)
    >>> for step in range(400):
    ...     if step == 200:
    ...         sim.apply_wrench("panda_link8", force=(0.0, 30.0, 0.0))
    ...     sim.torques = tau = hold(sim.time, sim.q, sim.v)
    ...     sim.step()
    ...     r = observer.update(sim.q, sim.v, tau, 1e-3)
    >>> observer.collision is not None
    True
    >>> space = robot.operational_space(sim.q, sim.v, "panda_link8", ("x", "y", "z"))
    >>> bool(np.allclose(space.consistent_inverse.T @ r, [0.0, 30.0, 0.0], atol=1.0))
    True
    """
    def __new__(cls, robot: Robot, gains: Numbers, *, thresholds: Numbers | None = None, dissipation: bool = False) -> Self: ...
    @property
    def collision(self) -> int | None:
        """Coordinate with the largest |r| relative to its threshold, if it is above it."""
    @property
    def external_torque(self) -> NDArray[np.float64]:
        """r (nv,) after the last sample [N·m or N]."""
    def reset(self) -> None:
        """Sets r = 0 and forgets the last sample."""
    def update(self, q: Numbers, v: Numbers, tau: Numbers, dt: float) -> NDArray[np.float64]:
        """Takes a sample, and returns r. The first sample only stores the state.

        Parameters
        ----------
        q : array_like, shape (nq,)
            Configuration at this sample.
        v : array_like, shape (nv,)
            Velocity at this sample.
        tau : array_like, shape (nv,)
            Torque of the motors since the last sample [N·m or N].
        dt : float
            Time since the last sample [s].

        Returns
        -------
        ndarray, shape (nv,)
            r [N·m or N].

        Raises
        ------
        ShapeError
            An array has the wrong shape.
        StateError
            A number is not finite, or q is not a configuration.
        ControlError
            `dt` is not positive, or a result overflows.
        """

@final
class OptimalMpc:
    """The native half of `robot_dynamics.optimal.Mpc`."""
    def __new__(cls, problem: OptimalProblem, options: _Record, iterations: int, time_budget: float | None, rows: _Rows) -> Self: ...
    def _next_controls(self, state: object) -> _Array:
        """See `step`."""
    def _plan(self) -> _Record:
        """See `plan`."""
    def _set_running_cost(self, first: int, end: int, terms: Sequence[object]) -> None:
        """See `set_running_cost`."""
    def _set_terminal_cost(self, terms: Sequence[object]) -> None:
        """See `set_terminal_cost`."""
    def _times(self) -> tuple[int, float, float, float, int]:
        """See `times`."""

@final
class OptimalProblem:
    """The native half of `robot_dynamics.optimal.Problem`."""
    def __new__(cls, dynamics: object, initial_state: object, nodes: int) -> Self: ...
    def _add_constraint(self, first: int, end: int, residual: object, lower: object, upper: object) -> None:
        """See `add_constraint`."""
    def _add_terminal_constraint(self, residual: object, lower: object, upper: object) -> None:
        """See `add_terminal_constraint`."""
    def _sample(self, options: _Record, rows: _Rows) -> _Record:
        """See `sample`."""
    def _set_control_bounds(self, first: int, end: int, lower: object, upper: object) -> None:
        """See `set_control_bounds`."""
    def _set_dynamics(self, first: int, end: int, dynamics: object) -> None:
        """See `set_dynamics`."""
    def _set_effort_limits(self, first: int, end: int) -> None:
        """See `set_effort_limits`."""
    def _set_initial_state(self, initial_state: object) -> None:
        """See `set_initial_state`."""
    def _set_running_cost(self, first: int, end: int, terms: Sequence[object]) -> None:
        """See `set_running_cost`."""
    def _set_terminal_cost(self, terms: Sequence[object]) -> None:
        """See `set_terminal_cost`."""
    def _sizes(self) -> tuple[int, int]:
        """(nq, nv), or (0, n) for plain numbers."""
    def _solve(self, options: _Record, constraint_tolerance: float, rows: _Rows, callback: Callable[[tuple[Any, ...]], object] | None) -> _Record:
        """See `solve`."""
    @property
    def controls(self) -> list[int]:
        """Number of controls of each node (N,)."""
    @property
    def nodes(self) -> int:
        """Number of nodes N; a trajectory has N + 1 states."""

@disjoint_base
class PayloadFilter:
    """The native half of `robot_dynamics.PayloadEstimator`."""
    def __len__(self, /) -> int: ...
    def __new__(cls, robot: Robot, frame: str | int, noise: Numbers, forgetting: float, prior: tuple[Numbers, Numbers] | None, offsets: Numbers | None) -> Self: ...
    def _payload(self) -> _Record:
        """See `payload`."""
    def _push(self, q: Numbers, v: Numbers, a: Numbers, tau: Numbers) -> None:
        """See `push`."""
    def _reset(self) -> None:
        """See `reset`."""
    @property
    def covariance(self) -> NDArray[np.float64]:
        """The covariance of the parameters (10, 10)."""
    @property
    def parameters(self) -> NDArray[np.float64]:
        """The ten parameters about the frame's origin and along its axes: m, m c, Ixx, Ixy, Iyy, Ixz, Iyz, Izz
        [kg, kg·m, kg·m²].
        """

@final
class PolynomialMotion:
    """The polynomials of `robot_dynamics.certified.Motion`."""
    def __new__(cls, kind: str, times: Numbers, points: Numbers) -> Self: ...
    def _coefficients(self) -> _Array:
        """The coefficients (pieces, coordinates, 6)."""
    def _durations(self) -> _Array:
        """The durations of the pieces (pieces,)."""
    def _state(self, number: int, time: float) -> list[_Array]:
        """q, v and a at a time from the start of a piece."""

@final
class ReachableSet:
    """The set of `robot_dynamics.certified.ReachableSet`."""
    def _box(self) -> _Array:
        """The bounds of x, y and z."""
    def _farthest(self, direction: Numbers) -> tuple[float, float, _Array]:
        """See `ReachableSet.farthest`: the proven and the attained number, and a configuration."""

@disjoint_base
class Robot:
    """A robot: immutable, to be used by any number of threads at once. `robot_dynamics.load` makes one."""
    def __eq__(self, value: object, /) -> bool: ...
    def __hash__(self, /) -> int: ...
    def __ne__(self, value: object, /) -> bool: ...
    def __new__(cls, kind: str, source: str, *, floating_base: bool = False, strict: bool = False, repair_inertia: bool = False, package_path: Sequence[str] | None = None, confined: bool = False, srdf: str | None = None, assets: Sequence[tuple[str, bytes]] | None = None) -> Self: ...
    def _actuated_dofs(self) -> list[bool]:
        """See `actuated_dofs`."""
    def _audit(self, states: int, seed: int) -> list[tuple[str, str, float, str, float, bool, str]]:
        """See `audit`."""
    def _base_parameters(self, states: int, seed: int, terms: Sequence[str]) -> BaseParameters:
        """See `base_parameters`."""
    def _certify_digits(self, q: Numbers, v: Numbers | None, a: Numbers | None, tau: Numbers | None) -> list[tuple[str, _Array, _Array, _Array, float, float]]:
        """See `certify_digits`."""
    def _certify_mass_matrix(self, lower: Numbers | None, upper: Numbers | None, max_boxes: int) -> _Record:
        """See `certify_mass_matrix`."""
    def _certify_reach(self, frame: str | int, lower: Numbers | None, upper: Numbers | None, cells: int, threads: int | None) -> ReachableSet:
        """See `certify_reach`."""
    def _certify_torques(self, motion: PolynomialMotion, robots: tuple[Sequence[tuple[str | None, tuple[float, float]]], tuple[float, float], Sequence[tuple[float, float]] | None], payload: tuple[str | int, tuple[float, float], list[tuple[float, float]], float] | None, search_limits: tuple[float, int], threads: int | None) -> _Record:
        """See `certify_torques`."""
    def _constrained_forward_dynamics(self, constraints: Constraints, q: Numbers, v: Numbers, tau: Numbers | None, stabilization: float | None) -> _Record:
        """See `constrained_forward_dynamics`."""
    def _constrained_forward_dynamics_derivatives(self, constraints: Constraints, q: Numbers, v: Numbers, tau: Numbers | None, stabilization: float | None) -> _Record:
        """See `constrained_forward_dynamics_derivatives`."""
    def _constrained_forward_dynamics_pullback(self, constraints: Constraints, q: Numbers, v: Numbers, tau: Numbers | None, acceleration: Numbers | None, multipliers: Numbers | None, stabilization: float | None) -> _Record:
        """See `constrained_forward_dynamics_pullback`."""
    def _constrained_inverse_dynamics(self, constraints: Constraints, q: Numbers, v: Numbers, a: Numbers, actuated: Sequence[bool] | None) -> _Record:
        """See `constrained_inverse_dynamics`."""
    def _constrained_inverse_dynamics_derivatives(self, constraints: Constraints, q: Numbers, v: Numbers, a: Numbers, actuated: Sequence[bool] | None) -> _Record:
        """See `constrained_inverse_dynamics_derivatives`."""
    def _constrained_inverse_dynamics_pullback(self, constraints: Constraints, q: Numbers, v: Numbers, a: Numbers, tau: Numbers | None, multipliers: Numbers | None, actuated: Sequence[bool] | None) -> _Record:
        """See `constrained_inverse_dynamics_pullback`."""
    def _constraint_projections(self, constraints: Constraints, q: Numbers) -> tuple[_Array, _Array]:
        """See `constraint_projections`."""
    def _constraint_rows(self, constraints: Constraints, q: Numbers, v: Numbers | None) -> _Record:
        """See `constraint_rows`."""
    def _contact_impulse(self, constraints: Constraints, q: Numbers, v: Numbers, restitution: float) -> _Record:
        """See `contact_impulse`."""
    def _contact_impulse_derivatives(self, constraints: Constraints, q: Numbers, v: Numbers, restitution: float) -> _Record:
        """See `contact_impulse_derivatives`."""
    def _contact_impulse_pullback(self, constraints: Constraints, q: Numbers, v: Numbers, velocity: Numbers | None, impulse: Numbers | None, restitution: float) -> _Record:
        """See `contact_impulse_pullback`."""
    def _convert(self, convention: str, back: bool, names: Sequence[str], given: Sequence[NDArray[Any] | None]) -> list[_Array | None]:
        """See `to_mujoco` and `to_pinocchio`; `back` converts in the other direction. All arrays have a row per
        state; the names are those of the arguments.
        """
    def _design_excitation(self, limits: tuple[Numbers | None, Numbers | None, Numbers | None, Numbers | None], design: tuple[float, int, bool, int | None, str, int, int], terms: Sequence[str], noise: Numbers | None) -> _Record:
        """See `design_excitation`."""
    def _differentiable_row(self, **options: object) -> tuple[str, bool]:
        """The explicit method of a simulation with these options whose gradients are known, and whether damping
        and friction act.
        """
    def _disabled_collisions(self, path: _Path) -> list[tuple[str, str]]:
        """The pairs of links whose collisions an SRDF file disables."""
    def _effort_limits(self) -> _Array:
        """The effort limits of all coordinates."""
    def _file_read_at(self, path: _Path) -> Path | None:
        """The one of the robot's files that is at this path; links are resolved."""
    def _fluid_force_derivatives(self, q: Numbers, v: Numbers) -> tuple[_Array, _Array]:
        """See `fluid_force_derivatives`."""
    def _fluid_forces(self, q: Numbers, v: Numbers) -> _Array:
        """See `fluid_forces`."""
    def _generate(self, target: str, functions: Sequence[str], folder: _Path | None, *, single: bool, fused: bool, platform_sine: bool, lanes: bool, name: str | None, states: int) -> list[tuple[str, str]]:
        """See `generate`."""
    def _identify(self, arrays: tuple[Numbers, Numbers, Numbers, Numbers], setup: tuple[bool, list[str], Numbers | None, list[tuple[str, Numbers]]], base: BaseParameters | None) -> _Record:
        """See `identify`."""
    def _identify_consistent(self, arrays: tuple[Numbers, Numbers, Numbers, Numbers], setup: tuple[bool, list[str], Numbers | None, list[tuple[str, Numbers]]], weights: tuple[float, float, float], nominal: tuple[list[str], Numbers | None, list[tuple[str, float]]]) -> _Record:
        """See `identify_consistent`."""
    def _identify_nonlinear(self, arrays: tuple[Numbers, Numbers, Numbers, Numbers], setup: tuple[bool, list[str], Numbers | None, list[tuple[str, Numbers]]], weights: tuple[float, float, float], nominal: tuple[list[str], Numbers | None, list[tuple[str, float]]], search: tuple[Numbers | None, bool, int]) -> _Record:
        """See `identify_nonlinear`."""
    def _inverse_kinematics(self, frame: str | int, target: Numbers, start: Numbers | None, *, position_tolerance: float, angle_tolerance: float, max_iterations: int, max_restarts: int, seed: int) -> _Record:
        """See `inverse_kinematics`."""
    def _joints(self) -> list[tuple[tuple[str, int, str], tuple[str, str, int | None], tuple[int, int], tuple[int, int], tuple[str, float, float] | None, list[float], list[float]]]:
        """Joints in the order of their coordinates, as the fields of `robot_dynamics.Joint`."""
    def _left_out(self) -> list[str]:
        """The features that the default simulation leaves out, one line for each reason, or why there is no such
        simulation.
        """
    def _linearize_step(self, q: Numbers, v: Numbers, tau: Numbers | None, controls: dict[str, float] | None, **options: object) -> tuple[_Array, _Array]:
        """See `linearize_step`."""
    @overload
    def _linearize_steps(self, q: NDArray[_F], v: NDArray[_F], tau: NDArray[_F], controls: dict[str, float] | None, lead: NDArray[_F], threads: int | None, **options: object) -> NDArray[_F]: ...
    @overload
    def _linearize_steps(self, q: Numbers, v: Numbers, tau: Numbers, controls: dict[str, float] | None, lead: Numbers, threads: int | None, **options: object) -> NDArray[np.float64]:
        """See `linearize_step`. Plain float64 arrays with a row for each state of a batch of shape `lead`; tau
        may be empty.
        """
    def _links(self) -> list[tuple[str, int, int | None, float, list[float], list[list[float]]]]:
        """Links in the file's order, as the fields of `robot_dynamics.Link`."""
    def _lock(self, joints: Sequence[tuple[str, Sequence[float] | None]]) -> str:
        """See `lock`."""
    def _lock_massless(self) -> tuple[str, list[str]]:
        """See `lock_massless`."""
    def _operational_space(self, q: Numbers, v: Numbers | None, frame: str | int, rows: Sequence[str]) -> _Record:
        """See `operational_space`."""
    def _physical_consistency(self, parameters: Numbers) -> list[tuple[str, float, float, float, bool]]:
        """See `physical_consistency`."""
    def _poses(self) -> list[tuple[str, list[float], list[float]]]:
        """The poses that the file names, MJCF's keyframes, with their q and v."""
    def _project(self, constraints: Constraints, q: Numbers, v: Numbers | None, tolerance: float) -> tuple[_Array, _Array]:
        """See `project`."""
    def _report_text(self) -> str:
        """The report in the library's own words."""
    def _result_shapes(self, name: str) -> list[list[int]]:
        """The shapes of the results of a row of the table, for one state and one frame."""
    def _rollout(self, q: Numbers, v: Numbers, tau: Numbers | None, each_step: bool, *, steps: int, stride: int, threads: int | None, controls: dict[str, float] | None, **options: object) -> list[NDArray[Any]]:
        """See `rollout`."""
    def _rollout_pullback(self, q: Numbers, v: Numbers, tau: Numbers | None, by_position: Numbers, by_velocity: Numbers, trajectory: tuple[Numbers, Numbers] | None, *, each_step: bool, steps: int, stride: int, spacing: int, parameters: bool, threads: int | None, controls: dict[str, float] | None, **options: object) -> tuple[tuple[NDArray[Any], NDArray[Any], NDArray[Any] | None, NDArray[Any] | None], tuple[int, int, int, str | None] | None]:
        """See `rollout_pullback`. All arrays have the leading dimensions of the batch."""
    def _sensor_values(self, q: Numbers, v: Numbers, a: Numbers, *, time: float, actuator_forces: Numbers | None, joint_limit_forces: Numbers | None, tendon_limit_forces: Numbers | None, wrenches: Sequence[tuple[str | int, _Three, _Three, _Three, _Three]]) -> _Array:
        """See `sensor_values`."""
    def _sensors(self) -> list[tuple[str, str, int]]:
        """See `sensors`."""
    def _simulate(self, q: Numbers, v: Numbers | None, tau: Numbers | Callable[[float, _Array, _Array], Numbers] | Delayed | None, *, duration: float, sample_period: float | str | None, events: Sequence[tuple[str, Callable[[float, _Array, _Array], float], int, bool]], stop_at_limits: bool, controls: dict[str, float] | None, **options: object) -> _Record:
        """See `simulate`."""
    def _state(self) -> str:
        """The description and the report as JSON, from which an equal robot is made."""
    def _step(self, q: Numbers, v: Numbers, tau: Numbers | None, controls: dict[str, float] | None, **options: object) -> tuple[_Array, _Array]:
        """See `step`."""
    def _supported_inverse_dynamics(self, supports: Sequence[tuple[str, _Three, _Three, float]], constraints: Constraints | None, q: Numbers, v: Numbers, a: Numbers, actuated: Sequence[bool] | None, force_weight: float) -> _Record:
        """See `supported_inverse_dynamics`."""
    def _suspicions(self) -> list[str]:
        """See `suspicions`."""
    def _time_optimal(self, waypoints: Numbers, limits: _Record, intervals: int | None, speeds: tuple[float, float], both_ends: bool, samples: int) -> _Record:
        """See `time_optimal`."""
    def _to_text(self, format: str, folder: _Path | None) -> tuple[str, list[tuple[str, str, bool]]]:
        """See `to_text`."""
    def _warning_groups(self) -> list[str]:
        """The warnings of the report, those of one kind in one text."""
    def _with_actuated_joints(self, joints: Sequence[str]) -> str:
        """See `with_actuated_joints`."""
    def _with_attached(self, robot: Robot, parent: str, pose: Numbers, joint: _JointWords | None, prefix: str) -> tuple[str, list[str]]:
        """See `with_attached`."""
    def _with_elastic_joint(self, joint: str, stiffness: float, damping: float, backlash: float) -> tuple[str, list[str]]:
        """See `with_elastic_joint`."""
    def _with_fluid(self, density: float, viscosity: float, wind: _Three) -> str:
        """See `with_fluid`."""
    def _with_frame(self, name: str, parent: str, pose: Numbers) -> str:
        """See `with_frame`."""
    def _with_gravity_scaled(self, factor: float) -> str:
        """See `with_gravity_scaled`."""
    def _with_inertia(self, link: str, mass: float, center_of_mass: Numbers, inertia: Numbers | None) -> str:
        """See `with_inertia`."""
    def _with_link(self, name: str, parent: str, pose: Numbers, joint: _JointWords, joint_name: str, limits: tuple[float, float, float, float], mass: float | None, center_of_mass: Numbers, inertia: Numbers | None) -> str:
        """See `with_link`."""
    def _with_mass_scaled(self, factor: float, link: str | None) -> str:
        """See `with_mass_scaled`."""
    def _with_motor(self, joint: str, drive: tuple[float, float], motor: tuple[float, float, float, float, float | None, tuple[float, float, float, float, float] | None, tuple[float, float] | None]) -> str:
        """See `with_motor`."""
    def _with_parameters(self, parameters: Numbers, as_written: bool) -> str:
        """See `with_parameters`."""
    def _with_payload(self, link: str, mass: float, center_of_mass: Numbers, inertia: Numbers | None) -> str:
        """See `with_payload`."""
    def _with_root(self, link: str) -> tuple[str, list[str]]:
        """See `with_root`."""
    def _with_sensors(self, sensors: Sequence[tuple[str, str, str | None, str | None]]) -> str:
        """See `with_sensors`."""
    def _with_subtree_replaced(self, joint: str, robot: Robot, prefix: str) -> tuple[str, list[str]]:
        """See `with_subtree_replaced`."""
    def _with_wrenches(self, row: str, q: Numbers, v: Numbers, x: Numbers, frames: Sequence[str | int], wrenches: Numbers, *, out: NDArray[Any] | tuple[NDArray[Any], ...] | None, threads: int | None) -> Any:
        """The results of `row` for states under wrenches: `inverse_dynamics`, `forward_dynamics`,
        `joint_reactions`, `inverse_dynamics_derivatives` or `forward_dynamics_derivatives`; `x` is a or τ.
        """
    def _without_equality(self, equality: str) -> tuple[str, list[str]]:
        """See `without_equality`."""
    def _without_joint(self, joint: str) -> tuple[str, list[str]]:
        """See `without_joint`."""
    def _xla_handle(self) -> int:
        """The number by which programs of XLA call this robot. It stays in memory from now on."""
    @property
    def actuator_names(self) -> list[str]:
        """The names of the actuators, which `simulate(controls=…)` lets act."""
    @overload
    def bias(self, q: NDArray[_F], v: NDArray[_F], *, out: NDArray[_F] | None = None, threads: int | None = None) -> NDArray[_F]: ...
    @overload
    def bias(self, q: Numbers, v: Numbers, *, out: NDArray[np.float64] | None = None, threads: int | None = None) -> NDArray[np.float64]:
        """C(q, v) v + g(q): everything of the equation of motion but inertia and dissipation.

        Parameters
        ----------
        q : array_like, shape (..., nq)
            Configuration.
        v : array_like, shape (..., nv)
            Velocity [rad/s or m/s].
        out : ndarray, shape (..., nv), optional
            Array that receives the result.
        threads : int, optional
            Threads for a batch; default: `num_threads()`.

        Returns
        -------
        ndarray, shape (..., nv)
            C v + g [N·m or N].

        Raises
        ------
        StateError
            The state is invalid; `BadStatesError` for a batch.
        ShapeError
            An array has the wrong shape.
        DTypeError
            An array is neither float64 nor float32, or both occur.

        Examples
        --------
        >>> robot, q, v = rd.example("two_r"), [0.3, 1.2], [1.0, -2.0]
        >>> bool(np.allclose(robot.bias(q, v), robot.coriolis_matrix(q, v) @ v + robot.gravity(q)))
        True
        """
    @overload
    def center_of_mass(self, q: NDArray[_F], *, out: NDArray[_F] | None = None, threads: int | None = None) -> NDArray[_F]: ...
    @overload
    def center_of_mass(self, q: Numbers, *, out: NDArray[np.float64] | None = None, threads: int | None = None) -> NDArray[np.float64]:
        """The centre of mass, in the world.

        Parameters
        ----------
        q : array_like, shape (..., nq)
            Configuration.
        out : ndarray, shape (..., 3), optional
            Array that receives the result.
        threads : int, optional
            Threads for a batch; default: `num_threads()`.

        Returns
        -------
        ndarray, shape (..., 3)
            Position in the world [m].

        Raises
        ------
        StateError
            The state is invalid; `BadStatesError` for a batch.
        ShapeError
            An array has the wrong shape.
        DTypeError
            An array is neither float64 nor float32, or both occur.

        Examples
        --------
        >>> rd.example("two_r").center_of_mass([0.0, 0.0]).round(12)  # (2 · 0.5 + 1 · 1.5) / 3
        array([0.83333333, 0.        , 0.        ])
        """
    @overload
    def center_of_mass_bias_acceleration(self, q: NDArray[_F], v: NDArray[_F], *, out: NDArray[_F] | None = None, threads: int | None = None) -> NDArray[_F]: ...
    @overload
    def center_of_mass_bias_acceleration(self, q: Numbers, v: Numbers, *, out: NDArray[np.float64] | None = None, threads: int | None = None) -> NDArray[np.float64]:
        """J̇ v of `center_of_mass_jacobian`: the acceleration of the centre of mass without a.

        Parameters
        ----------
        q : array_like, shape (..., nq)
            Configuration.
        v : array_like, shape (..., nv)
            Velocity [rad/s or m/s].
        out : ndarray, shape (..., 3), optional
            Array that receives the result.
        threads : int, optional
            Threads for a batch; default: `num_threads()`.

        Returns
        -------
        ndarray, shape (..., 3)
            Acceleration, along the world's axes [m/s²].

        Raises
        ------
        StateError
            The state is invalid; `BadStatesError` for a batch.
        ShapeError
            An array has the wrong shape.
        DTypeError
            An array is neither float64 nor float32, or both occur.

        Examples
        --------
        >>> rd.example("two_r").center_of_mass_bias_acceleration([0.0, 0.0], [1.2, 0.0]).round(12)
        array([-1.2,  0. ,  0. ])
        """
    @overload
    def center_of_mass_jacobian(self, q: NDArray[_F], *, out: NDArray[_F] | None = None, threads: int | None = None) -> NDArray[_F]: ...
    @overload
    def center_of_mass_jacobian(self, q: Numbers, *, out: NDArray[np.float64] | None = None, threads: int | None = None) -> NDArray[np.float64]:
        """The Jacobian of the centre of mass, along the world's axes.

        Parameters
        ----------
        q : array_like, shape (..., nq)
            Configuration.
        out : ndarray, shape (..., 3, nv), optional
            Array that receives the result.
        threads : int, optional
            Threads for a batch; default: `num_threads()`.

        Returns
        -------
        ndarray, shape (..., 3, nv)
            J, along the world's axes.

        Raises
        ------
        StateError
            The state is invalid; `BadStatesError` for a batch.
        ShapeError
            An array has the wrong shape.
        DTypeError
            An array is neither float64 nor float32, or both occur.

        Examples
        --------
        >>> robot, q, v = rd.example("two_r"), [0.3, 1.2], [1.0, -2.0]
        >>> bool(np.allclose(robot.center_of_mass_jacobian(q) @ v, robot.center_of_mass_velocity(q, v)))
        True
        """
    @overload
    def center_of_mass_velocity(self, q: NDArray[_F], v: NDArray[_F], *, out: NDArray[_F] | None = None, threads: int | None = None) -> NDArray[_F]: ...
    @overload
    def center_of_mass_velocity(self, q: Numbers, v: Numbers, *, out: NDArray[np.float64] | None = None, threads: int | None = None) -> NDArray[np.float64]:
        """The velocity of the centre of mass, along the world's axes.

        Parameters
        ----------
        q : array_like, shape (..., nq)
            Configuration.
        v : array_like, shape (..., nv)
            Velocity [rad/s or m/s].
        out : ndarray, shape (..., 3), optional
            Array that receives the result.
        threads : int, optional
            Threads for a batch; default: `num_threads()`.

        Returns
        -------
        ndarray, shape (..., 3)
            Velocity, along the world's axes [m/s].

        Raises
        ------
        StateError
            The state is invalid; `BadStatesError` for a batch.
        ShapeError
            An array has the wrong shape.
        DTypeError
            An array is neither float64 nor float32, or both occur.

        Examples
        --------
        >>> rd.example("two_r").center_of_mass_velocity([0.0, 0.0], [1.2, 0.0]).round(12)  # upwards
        array([0., 0., 1.])
        """
    @overload
    def center_of_mass_velocity_derivative(self, q: NDArray[_F], v: NDArray[_F], *, out: NDArray[_F] | None = None, threads: int | None = None) -> NDArray[_F]: ...
    @overload
    def center_of_mass_velocity_derivative(self, q: Numbers, v: Numbers, *, out: NDArray[np.float64] | None = None, threads: int | None = None) -> NDArray[np.float64]:
        """∂(center_of_mass_velocity)/∂q.

        Derivatives by q are by displacements q ⊕ δq.

        Parameters
        ----------
        q : array_like, shape (..., nq)
            Configuration.
        v : array_like, shape (..., nv)
            Velocity [rad/s or m/s].
        out : ndarray, shape (..., 3, nv), optional
            Array that receives the result.
        threads : int, optional
            Threads for a batch; default: `num_threads()`.

        Returns
        -------
        ndarray, shape (..., 3, nv)
            Derivative by q, along the world's axes.

        Raises
        ------
        StateError
            The state is invalid; `BadStatesError` for a batch.
        ShapeError
            An array has the wrong shape.
        DTypeError
            An array is neither float64 nor float32, or both occur.

        Examples
        --------
        >>> rd.example("two_r").center_of_mass_velocity_derivative([0.0, 0.0], [1.2, 0.0])[0].round(12)
        array([-1. , -0.2])
        """
    @overload
    def centroidal_momentum(self, q: NDArray[_F], v: NDArray[_F], *, out: NDArray[_F] | None = None, threads: int | None = None) -> NDArray[_F]: ...
    @overload
    def centroidal_momentum(self, q: Numbers, v: Numbers, *, out: NDArray[np.float64] | None = None, threads: int | None = None) -> NDArray[np.float64]:
        """h = A_G v: linear momentum, and angular momentum about the centre of mass, along the world's axes.

        Parameters
        ----------
        q : array_like, shape (..., nq)
            Configuration.
        v : array_like, shape (..., nv)
            Velocity [rad/s or m/s].
        out : ndarray, shape (..., 6), optional
            Array that receives the result.
        threads : int, optional
            Threads for a batch; default: `num_threads()`.

        Returns
        -------
        ndarray, shape (..., 6)
            Linear [kg·m/s], then angular [kg·m²/s], along the world's axes.

        Raises
        ------
        StateError
            The state is invalid; `BadStatesError` for a batch.
        ShapeError
            An array has the wrong shape.
        DTypeError
            An array is neither float64 nor float32, or both occur.

        Examples
        --------
        >>> robot = rd.example("quadruped", floating_base=True)
        >>> v = np.zeros(robot.nv); v[0] = 2.0  # forward along x
        >>> bool(np.isclose(robot.centroidal_momentum(robot.neutral(), v)[0], 2.0 * robot.mass))
        True
        """
    @overload
    def centroidal_momentum_bias_rate(self, q: NDArray[_F], v: NDArray[_F], *, out: NDArray[_F] | None = None, threads: int | None = None) -> NDArray[_F]: ...
    @overload
    def centroidal_momentum_bias_rate(self, q: Numbers, v: Numbers, *, out: NDArray[np.float64] | None = None, threads: int | None = None) -> NDArray[np.float64]:
        """Ȧ_G v: the rate of the centroidal momentum without accelerations.

        Parameters
        ----------
        q : array_like, shape (..., nq)
            Configuration.
        v : array_like, shape (..., nv)
            Velocity [rad/s or m/s].
        out : ndarray, shape (..., 6), optional
            Array that receives the result.
        threads : int, optional
            Threads for a batch; default: `num_threads()`.

        Returns
        -------
        ndarray, shape (..., 6)
            Linear [N], then angular [N·m], along the world's axes.

        Raises
        ------
        StateError
            The state is invalid; `BadStatesError` for a batch.
        ShapeError
            An array has the wrong shape.
        DTypeError
            An array is neither float64 nor float32, or both occur.

        Examples
        --------
        >>> robot = rd.example("panda")
        >>> robot.centroidal_momentum_bias_rate(np.zeros(7), np.zeros(7)) @ np.ones(6)
        np.float64(0.0)
        """
    @overload
    def centroidal_momentum_matrix(self, q: NDArray[_F], *, out: NDArray[_F] | None = None, threads: int | None = None) -> NDArray[_F]: ...
    @overload
    def centroidal_momentum_matrix(self, q: Numbers, *, out: NDArray[np.float64] | None = None, threads: int | None = None) -> NDArray[np.float64]:
        """The matrix A_G of h = A_G(q) v, the momentum about the centre of mass along the world's axes.

        Parameters
        ----------
        q : array_like, shape (..., nq)
            Configuration.
        out : ndarray, shape (..., 6, nv), optional
            Array that receives the result.
        threads : int, optional
            Threads for a batch; default: `num_threads()`.

        Returns
        -------
        ndarray, shape (..., 6, nv)
            A_G, linear rows, then angular rows.

        Raises
        ------
        StateError
            The state is invalid; `BadStatesError` for a batch.
        ShapeError
            An array has the wrong shape.
        DTypeError
            An array is neither float64 nor float32, or both occur.

        Examples
        --------
        >>> robot, q, v = rd.example("panda"), np.zeros(7), np.ones(7)
        >>> bool(np.allclose(robot.centroidal_momentum_matrix(q) @ v, robot.centroidal_momentum(q, v)))
        True
        """
    @overload
    def centroidal_momentum_rate(self, q: NDArray[_F], v: NDArray[_F], a: NDArray[_F], *, out: NDArray[_F] | None = None, threads: int | None = None) -> NDArray[_F]: ...
    @overload
    def centroidal_momentum_rate(self, q: Numbers, v: Numbers, a: Numbers, *, out: NDArray[np.float64] | None = None, threads: int | None = None) -> NDArray[np.float64]:
        """ḣ, the rate of the centroidal momentum: gravity and all forces from outside.

        Parameters
        ----------
        q : array_like, shape (..., nq)
            Configuration.
        v : array_like, shape (..., nv)
            Velocity [rad/s or m/s].
        a : array_like, shape (..., nv)
            Acceleration [rad/s² or m/s²].
        out : ndarray, shape (..., 6), optional
            Array that receives the result.
        threads : int, optional
            Threads for a batch; default: `num_threads()`.

        Returns
        -------
        ndarray, shape (..., 6)
            Linear [N], then angular [N·m], along the world's axes.

        Raises
        ------
        StateError
            The state is invalid; `BadStatesError` for a batch.
        ShapeError
            An array has the wrong shape.
        DTypeError
            An array is neither float64 nor float32, or both occur.

        Examples
        --------
        >>> robot, q, v = rd.example("panda"), np.zeros(7), np.ones(7)
        >>> rate = robot.centroidal_momentum_rate(q, v, np.zeros(7))
        >>> bool(np.allclose(rate, robot.centroidal_momentum_bias_rate(q, v)))
        True
        """
    @overload
    def christoffel_symbols(self, q: NDArray[_F], *, out: NDArray[_F] | None = None, threads: int | None = None) -> NDArray[_F]: ...
    @overload
    def christoffel_symbols(self, q: Numbers, *, out: NDArray[np.float64] | None = None, threads: int | None = None) -> NDArray[np.float64]:
        """Γⁱⱼₖ = ½(∂M_ij/∂qₖ + ∂M_ik/∂qⱼ − ∂M_jk/∂qᵢ), the Christoffel symbols of the first kind.

        C_ij = Σₖ Γⁱⱼₖ vₖ.

        Parameters
        ----------
        q : array_like, shape (..., nq)
            Configuration.
        out : ndarray, shape (..., nv, nv, nv), optional
            Array that receives the result.
        threads : int, optional
            Threads for a batch; default: `num_threads()`.

        Returns
        -------
        ndarray, shape (..., nv, nv, nv)
            Γ with the indices i, j, k.

        Raises
        ------
        StateError
            The state is invalid; `BadStatesError` for a batch.
        ShapeError
            An array has the wrong shape.
        DTypeError
            An array is neither float64 nor float32, or both occur.

        Examples
        --------
        >>> robot, q, v = rd.example("two_r"), [0.3, 1.2], [1.0, -2.0]
        >>> bool(np.allclose(robot.christoffel_symbols(q) @ v, robot.coriolis_matrix(q, v)))
        True
        """
    @property
    def coordinate_names(self) -> list[str]:
        """The names of v's coordinates, for example `shoulder` or `floating_base.vx`."""
    @overload
    def coriolis_matrix(self, q: NDArray[_F], v: NDArray[_F], *, out: NDArray[_F] | None = None, threads: int | None = None) -> NDArray[_F]: ...
    @overload
    def coriolis_matrix(self, q: Numbers, v: Numbers, *, out: NDArray[np.float64] | None = None, threads: int | None = None) -> NDArray[np.float64]:
        """C(q, v) of the Christoffel symbols: Ṁ − 2C is skew-symmetric.

        C v are the centrifugal and Coriolis forces.

        Parameters
        ----------
        q : array_like, shape (..., nq)
            Configuration.
        v : array_like, shape (..., nv)
            Velocity [rad/s or m/s].
        out : ndarray, shape (..., nv, nv), optional
            Array that receives the result.
        threads : int, optional
            Threads for a batch; default: `num_threads()`.

        Returns
        -------
        ndarray, shape (..., nv, nv)
            C(q, v).

        Raises
        ------
        StateError
            The state is invalid; `BadStatesError` for a batch.
        ShapeError
            An array has the wrong shape.
        DTypeError
            An array is neither float64 nor float32, or both occur.

        Examples
        --------
        >>> robot, q, v = rd.example("two_r"), [0.3, 1.2], [1.0, -2.0]
        >>> S = robot.mass_matrix_rate(q, v) - 2 * robot.coriolis_matrix(q, v)
        >>> bool(np.allclose(S, -S.T))
        True
        """
    @overload
    def cotangent_from_coordinates(self, q: NDArray[_F], coordinates: NDArray[_F], *, out: NDArray[_F] | None = None, threads: int | None = None) -> NDArray[_F]: ...
    @overload
    def cotangent_from_coordinates(self, q: Numbers, coordinates: Numbers, *, out: NDArray[np.float64] | None = None, threads: int | None = None) -> NDArray[np.float64]:
        """Converts a gradient by the numbers of q to the gradient by displacements q ⊕ δ. This is right for any
        function, whatever it does with quaternions that are not of length 1.

        Parameters
        ----------
        q : array_like, shape (..., nq)
            Configuration.
        coordinates : array_like, shape (..., nq)
            Gradient by the numbers of q.
        out : ndarray, shape (..., nv), optional
            Array that receives the result.
        threads : int, optional
            Threads for a batch; default: `num_threads()`.

        Returns
        -------
        ndarray, shape (..., nv)
            Gradient by displacements.

        Raises
        ------
        StateError
            The state is invalid; `BadStatesError` for a batch.
        ShapeError
            An array has the wrong shape.
        DTypeError
            An array is neither float64 nor float32, or both occur.

        Examples
        --------
        >>> robot = rd.example("two_r")
        >>> robot.cotangent_from_coordinates([0.3, 1.2], [5.0, 6.0])
        array([5., 6.])
        """
    @overload
    def cotangent_to_coordinates(self, q: NDArray[_F], cotangent: NDArray[_F], *, out: NDArray[_F] | None = None, threads: int | None = None) -> NDArray[_F]: ...
    @overload
    def cotangent_to_coordinates(self, q: Numbers, cotangent: Numbers, *, out: NDArray[np.float64] | None = None, threads: int | None = None) -> NDArray[np.float64]:
        """Converts a gradient by displacements q ⊕ δ to the gradient by the numbers of q. The function must
        depend only on the direction of each quaternion, as those of this package do. Then x̄ = R ū and q̄ = 2
        q ⊗ (w̄, 0)/|q|²; for other coordinates the numbers are the same.

        Parameters
        ----------
        q : array_like, shape (..., nq)
            Configuration.
        cotangent : array_like, shape (..., nv)
            Gradient, one number for each degree of freedom.
        out : ndarray, shape (..., nq), optional
            Array that receives the result.
        threads : int, optional
            Threads for a batch; default: `num_threads()`.

        Returns
        -------
        ndarray, shape (..., nq)
            Gradient by the numbers of q.

        Raises
        ------
        StateError
            The state is invalid; `BadStatesError` for a batch.
        ShapeError
            An array has the wrong shape.
        DTypeError
            An array is neither float64 nor float32, or both occur.

        Examples
        --------
        >>> robot = rd.example("quadruped", floating_base=True)
        >>> cotangent = np.arange(robot.nv) + 1.0
        >>> robot.cotangent_to_coordinates(robot.neutral(), cotangent)[:6]
        array([ 1.,  2.,  3.,  8., 10., 12.])
        """
    @overload
    def difference(self, q0: NDArray[_F], q1: NDArray[_F], *, out: NDArray[_F] | None = None, threads: int | None = None) -> NDArray[_F]: ...
    @overload
    def difference(self, q0: Numbers, q1: Numbers, *, out: NDArray[np.float64] | None = None, threads: int | None = None) -> NDArray[np.float64]:
        """q1 ⊖ q0: the displacement d with q0 ⊕ d = q1, the shortest way.

        Parameters
        ----------
        q0 : array_like, shape (..., nq)
            Configuration at the start.
        q1 : array_like, shape (..., nq)
            Configuration at the end.
        out : ndarray, shape (..., nv), optional
            Array that receives the result.
        threads : int, optional
            Threads for a batch; default: `num_threads()`.

        Returns
        -------
        ndarray, shape (..., nv)
            Displacement d [rad or m].

        Raises
        ------
        StateError
            The state is invalid; `BadStatesError` for a batch.
        ShapeError
            An array has the wrong shape.
        DTypeError
            An array is neither float64 nor float32, or both occur.

        Examples
        --------
        >>> robot = rd.example("quadruped", floating_base=True)
        >>> q0, d = robot.neutral(), np.full(robot.nv, 0.1)
        >>> bool(np.allclose(robot.difference(q0, robot.integrate(q0, d)), d))
        True
        """
    @overload
    def dissipation(self, v: NDArray[_F], *, out: NDArray[_F] | None = None, threads: int | None = None) -> NDArray[_F]: ...
    @overload
    def dissipation(self, v: Numbers, *, out: NDArray[np.float64] | None = None, threads: int | None = None) -> NDArray[np.float64]:
        """b(v) = damping · v + friction · sign v of the joints, which resists the motion: M a + C v + g + b = τ.

        Parameters
        ----------
        v : array_like, shape (..., nv)
            Velocity [rad/s or m/s].
        out : ndarray, shape (..., nv), optional
            Array that receives the result.
        threads : int, optional
            Threads for a batch; default: `num_threads()`.

        Returns
        -------
        ndarray, shape (..., nv)
            b(v) [N·m or N].

        Raises
        ------
        StateError
            The state is invalid; `BadStatesError` for a batch.
        ShapeError
            An array has the wrong shape.
        DTypeError
            An array is neither float64 nor float32, or both occur.

        Examples
        --------
        >>> rd.example("two_r").dissipation([1.0, -2.0]).shape
        (2,)
        """
    @overload
    def dissipation_pullback(self, v: NDArray[_F], cotangent: NDArray[_F], *, out: tuple[NDArray[_F], NDArray[_F]] | None = None, threads: int | None = None) -> DissipationPullback[_F]: ...
    @overload
    def dissipation_pullback(self, v: Numbers, cotangent: Numbers, *, out: tuple[NDArray[np.float64], NDArray[np.float64]] | None = None, threads: int | None = None) -> DissipationPullback[np.float64]:
        """λᵀ ∂b/∂v and λᵀ ∂b/∂p of `dissipation` b(v) for a cotangent λ of b, where p are the `parameters()`.
        For each joint they are λ v by its damping and λ sign v by its friction; the sign is held constant.

        Parameters
        ----------
        v : array_like, shape (..., nv)
            Velocity [rad/s or m/s].
        cotangent : array_like, shape (..., nv)
            Gradient, one number for each degree of freedom.
        out : tuple of ndarray, optional
            Arrays that receive the results.
        threads : int, optional
            Threads for a batch; default: `num_threads()`.

        Returns
        -------
        DissipationPullback
            `by_velocity` (..., nv): λᵀ ∂b/∂v.
            `by_parameters` (..., parameters): λᵀ ∂b/∂p, named by `parameter_names`.

        Raises
        ------
        StateError
            The state is invalid; `BadStatesError` for a batch.
        ShapeError
            An array has the wrong shape.
        DTypeError
            An array is neither float64 nor float32, or both occur.

        Examples
        --------
        >>> robot = rd.example("two_r")
        >>> gradient = robot.dissipation_pullback([1.0, -2.0], [0.0, 5.0])
        >>> gradient.by_parameters[robot.parameter_names.index("elbow.damping")]
        np.float64(-10.0)
        """
    @property
    def fingerprint(self) -> int:
        """A number that identifies a robot. It is equal if every name and every digit of the descriptions are
        equal.
        """
    @overload
    def forward_dynamics(self, q: NDArray[_F], v: NDArray[_F], tau: NDArray[_F], *, out: NDArray[_F] | None = None, threads: int | None = None) -> NDArray[_F]: ...
    @overload
    def forward_dynamics(self, q: Numbers, v: Numbers, tau: Numbers, *, out: NDArray[np.float64] | None = None, threads: int | None = None) -> NDArray[np.float64]:
        """a = M⁻¹(τ − C v − g): the acceleration under generalized forces (articulated bodies).

        Parameters
        ----------
        q : array_like, shape (..., nq)
            Configuration.
        v : array_like, shape (..., nv)
            Velocity [rad/s or m/s].
        tau : array_like, shape (..., nv)
            Torques [N·m or N].
        out : ndarray, shape (..., nv), optional
            Array that receives the result.
        threads : int, optional
            Threads for a batch; default: `num_threads()`.

        Returns
        -------
        ndarray, shape (..., nv)
            Acceleration a [rad/s² or m/s²].

        Raises
        ------
        SingularMassError
            M(q) is singular.
        StateError
            The state is invalid; `BadStatesError` for a batch.
        ShapeError
            An array has the wrong shape.
        DTypeError
            An array is neither float64 nor float32, or both occur.

        Examples
        --------
        >>> robot, q, v, a = rd.example("two_r"), [0.3, 1.2], [1.0, -2.0], [3.0, 4.0]
        >>> robot.forward_dynamics(q, v, robot.inverse_dynamics(q, v, a)).round(9)
        array([3., 4.])
        """
    @overload
    def forward_dynamics_derivatives(self, q: NDArray[_F], v: NDArray[_F], tau: NDArray[_F], *, out: tuple[NDArray[_F], NDArray[_F], NDArray[_F]] | None = None, threads: int | None = None) -> ForwardDynamicsDerivatives[_F]: ...
    @overload
    def forward_dynamics_derivatives(self, q: Numbers, v: Numbers, tau: Numbers, *, out: tuple[NDArray[np.float64], NDArray[np.float64], NDArray[np.float64]] | None = None, threads: int | None = None) -> ForwardDynamicsDerivatives[np.float64]:
        """∂a/∂q, ∂a/∂v and ∂a/∂τ = M⁻¹ of a(q, v, τ).

        Derivatives by q are those of `inverse_dynamics_derivatives`.

        Parameters
        ----------
        q : array_like, shape (..., nq)
            Configuration.
        v : array_like, shape (..., nv)
            Velocity [rad/s or m/s].
        tau : array_like, shape (..., nv)
            Torques [N·m or N].
        out : tuple of ndarray, optional
            Arrays that receive the results.
        threads : int, optional
            Threads for a batch; default: `num_threads()`.

        Returns
        -------
        ForwardDynamicsDerivatives
            `by_position` (..., nv, nv): ∂a/∂q.
            `by_velocity` (..., nv, nv): ∂a/∂v.
            `by_force` (..., nv, nv): ∂a/∂τ.

        Raises
        ------
        SingularMassError
            M(q) is singular.
        StateError
            The state is invalid; `BadStatesError` for a batch.
        ShapeError
            An array has the wrong shape.
        DTypeError
            An array is neither float64 nor float32, or both occur.

        Examples
        --------
        >>> robot, q, v = rd.example("two_r"), [0.3, 1.2], [0.0, 0.0]
        >>> derivatives = robot.forward_dynamics_derivatives(q, v, v)
        >>> bool(np.allclose(derivatives.by_force, robot.inverse_mass_matrix(q)))
        True
        """
    @overload
    def forward_dynamics_hessian(self, q: NDArray[_F], v: NDArray[_F], tau: NDArray[_F], cotangent: NDArray[_F], *, out: NDArray[_F] | None = None, threads: int | None = None) -> NDArray[_F]: ...
    @overload
    def forward_dynamics_hessian(self, q: Numbers, v: Numbers, tau: Numbers, cotangent: Numbers, *, out: NDArray[np.float64] | None = None, threads: int | None = None) -> NDArray[np.float64]:
        """Hessian H of λᵀa(q, v, τ) for multipliers λ (`cotangent`), symmetric, in the order q, v, τ.

        The definition is that of `inverse_dynamics_hessian`.

        Parameters
        ----------
        q : array_like, shape (..., nq)
            Configuration.
        v : array_like, shape (..., nv)
            Velocity [rad/s or m/s].
        tau : array_like, shape (..., nv)
            Torques [N·m or N].
        cotangent : array_like, shape (..., nv)
            Gradient, one number for each degree of freedom.
        out : ndarray, shape (..., 3·nv, 3·nv), optional
            Array that receives the result.
        threads : int, optional
            Threads for a batch; default: `num_threads()`.

        Returns
        -------
        ndarray, shape (..., 3·nv, 3·nv)
            H in the order q, v, τ.

        Raises
        ------
        SingularMassError
            M(q) is singular.
        StateError
            The state is invalid; `BadStatesError` for a batch.
        ShapeError
            An array has the wrong shape.
        DTypeError
            An array is neither float64 nor float32, or both occur.

        Examples
        --------
        >>> robot, q, v, tau = rd.example("two_r"), [0.3, 1.2], [1.0, -2.0], [3.0, 4.0]
        >>> H = robot.forward_dynamics_hessian(q, v, tau, [1.0, 0.0])
        >>> bool(np.array_equal(H, H.T))
        True
        """
    @overload
    def forward_dynamics_hessian_product(self, q: NDArray[_F], v: NDArray[_F], tau: NDArray[_F], cotangent: NDArray[_F], direction: NDArray[_F], *, out: NDArray[_F] | None = None, threads: int | None = None) -> NDArray[_F]: ...
    @overload
    def forward_dynamics_hessian_product(self, q: Numbers, v: Numbers, tau: Numbers, cotangent: Numbers, direction: Numbers, *, out: NDArray[np.float64] | None = None, threads: int | None = None) -> NDArray[np.float64]:
        """Product H α of `forward_dynamics_hessian` and a direction α = (δq, δv, δτ), in O(n) without H.

        Parameters
        ----------
        q : array_like, shape (..., nq)
            Configuration.
        v : array_like, shape (..., nv)
            Velocity [rad/s or m/s].
        tau : array_like, shape (..., nv)
            Torques [N·m or N].
        cotangent : array_like, shape (..., nv)
            Gradient, one number for each degree of freedom.
        direction : array_like, shape (..., 3·nv)
            Direction: a displacement of q, then changes of the next two arguments.
        out : ndarray, shape (..., 3·nv), optional
            Array that receives the result.
        threads : int, optional
            Threads for a batch; default: `num_threads()`.

        Returns
        -------
        ndarray, shape (..., 3·nv)
            H α in the order q, v, τ.

        Raises
        ------
        SingularMassError
            M(q) is singular.
        StateError
            The state is invalid; `BadStatesError` for a batch.
        ShapeError
            An array has the wrong shape.
        DTypeError
            An array is neither float64 nor float32, or both occur.

        Examples
        --------
        >>> robot, q, v, tau = rd.example("two_r"), [0.3, 1.2], [1.0, -2.0], [3.0, 4.0]
        >>> H, along = robot.forward_dynamics_hessian(q, v, tau, [1.0, 0.0]), np.arange(6.0)
        >>> bool(np.allclose(robot.forward_dynamics_hessian_product(q, v, tau, [1.0, 0.0], along), H @ along))
        True
        """
    @overload
    def forward_dynamics_pullback(self, q: NDArray[_F], v: NDArray[_F], tau: NDArray[_F], cotangent: NDArray[_F], *, out: tuple[NDArray[_F], NDArray[_F], NDArray[_F]] | None = None, threads: int | None = None) -> ForwardDynamicsPullback[_F]: ...
    @overload
    def forward_dynamics_pullback(self, q: Numbers, v: Numbers, tau: Numbers, cotangent: Numbers, *, out: tuple[NDArray[np.float64], NDArray[np.float64], NDArray[np.float64]] | None = None, threads: int | None = None) -> ForwardDynamicsPullback[np.float64]:
        """λᵀ ∂a/∂q, λᵀ ∂a/∂v and λᵀ ∂a/∂τ of a(q, v, τ) for a cotangent λ of a. The cost is O(n); neither M nor
        a Jacobian is formed.

        Gradients by q are those of `inverse_dynamics_pullback`.

        Parameters
        ----------
        q : array_like, shape (..., nq)
            Configuration.
        v : array_like, shape (..., nv)
            Velocity [rad/s or m/s].
        tau : array_like, shape (..., nv)
            Torques [N·m or N].
        cotangent : array_like, shape (..., nv)
            Gradient, one number for each degree of freedom.
        out : tuple of ndarray, optional
            Arrays that receive the results.
        threads : int, optional
            Threads for a batch; default: `num_threads()`.

        Returns
        -------
        ForwardDynamicsPullback
            `by_position` (..., nv): λᵀ ∂a/∂q.
            `by_velocity` (..., nv): λᵀ ∂a/∂v.
            `by_force` (..., nv): λᵀ M⁻¹.

        Raises
        ------
        SingularMassError
            M(q) is singular.
        StateError
            The state is invalid; `BadStatesError` for a batch.
        ShapeError
            An array has the wrong shape.
        DTypeError
            An array is neither float64 nor float32, or both occur.

        Examples
        --------
        >>> robot, q, v, tau = rd.example("two_r"), [0.3, 1.2], [1.0, -2.0], [3.0, 4.0]
        >>> gradient = robot.forward_dynamics_pullback(q, v, tau, [1.0, 0.0])
        >>> bool(np.allclose(gradient.by_force, robot.inverse_mass_matrix(q)[0]))
        True
        """
    @overload
    def forward_dynamics_pullback_derivative(self, q: NDArray[_F], v: NDArray[_F], tau: NDArray[_F], cotangent: NDArray[_F], *, out: NDArray[_F] | None = None, threads: int | None = None) -> NDArray[_F]: ...
    @overload
    def forward_dynamics_pullback_derivative(self, q: Numbers, v: Numbers, tau: Numbers, cotangent: Numbers, *, out: NDArray[np.float64] | None = None, threads: int | None = None) -> NDArray[np.float64]:
        """Derivative D of `forward_dynamics_pullback`: row α has the change of its results along the direction
        α, in the order q, v, τ. See `inverse_dynamics_pullback_derivative`.

        Parameters
        ----------
        q : array_like, shape (..., nq)
            Configuration.
        v : array_like, shape (..., nv)
            Velocity [rad/s or m/s].
        tau : array_like, shape (..., nv)
            Torques [N·m or N].
        cotangent : array_like, shape (..., nv)
            Gradient, one number for each degree of freedom.
        out : ndarray, shape (..., 3·nv, 3·nv), optional
            Array that receives the result.
        threads : int, optional
            Threads for a batch; default: `num_threads()`.

        Returns
        -------
        ndarray, shape (..., 3·nv, 3·nv)
            D in the order q, v, τ.

        Raises
        ------
        SingularMassError
            M(q) is singular.
        StateError
            The state is invalid; `BadStatesError` for a batch.
        ShapeError
            An array has the wrong shape.
        DTypeError
            An array is neither float64 nor float32, or both occur.

        Examples
        --------
        >>> robot, q, v, tau = rd.example("two_r"), [0.3, 1.2], [1.0, -2.0], [3.0, 4.0]
        >>> D = robot.forward_dynamics_pullback_derivative(q, v, tau, [1.0, 0.0])
        >>> bool(np.allclose(D, robot.forward_dynamics_hessian(q, v, tau, [1.0, 0.0])))
        True
        """
    @overload
    def forward_dynamics_pullback_with_parameters(self, q: NDArray[_F], v: NDArray[_F], tau: NDArray[_F], cotangent: NDArray[_F], *, out: tuple[NDArray[_F], NDArray[_F], NDArray[_F], NDArray[_F]] | None = None, threads: int | None = None) -> ForwardDynamicsPullbackWithParameters[_F]: ...
    @overload
    def forward_dynamics_pullback_with_parameters(self, q: Numbers, v: Numbers, tau: Numbers, cotangent: Numbers, *, out: tuple[NDArray[np.float64], NDArray[np.float64], NDArray[np.float64], NDArray[np.float64]] | None = None, threads: int | None = None) -> ForwardDynamicsPullbackWithParameters[np.float64]:
        """`forward_dynamics_pullback` with λᵀ ∂a/∂p for the `parameters()` p, too. For the inertial ones it is
        −(M⁻¹λ)ᵀY with the `joint_torque_regressor` Y, which is not formed.

        Parameters
        ----------
        q : array_like, shape (..., nq)
            Configuration.
        v : array_like, shape (..., nv)
            Velocity [rad/s or m/s].
        tau : array_like, shape (..., nv)
            Torques [N·m or N].
        cotangent : array_like, shape (..., nv)
            Gradient, one number for each degree of freedom.
        out : tuple of ndarray, optional
            Arrays that receive the results.
        threads : int, optional
            Threads for a batch; default: `num_threads()`.

        Returns
        -------
        ForwardDynamicsPullbackWithParameters
            `by_position` (..., nv): λᵀ ∂a/∂q.
            `by_velocity` (..., nv): λᵀ ∂a/∂v.
            `by_force` (..., nv): λᵀ M⁻¹.
            `by_parameters` (..., parameters): λᵀ ∂a/∂p, named by `parameter_names`.

        Raises
        ------
        SingularMassError
            M(q) is singular.
        StateError
            The state is invalid; `BadStatesError` for a batch.
        ShapeError
            An array has the wrong shape.
        DTypeError
            An array is neither float64 nor float32, or both occur.

        Examples
        --------
        >>> robot, q, v, tau = rd.example("two_r"), [0.3, 1.2], [1.0, -2.0], [3.0, 4.0]
        >>> gradient = robot.forward_dynamics_pullback_with_parameters(q, v, tau, [1.0, 0.0])
        >>> Y = robot.joint_torque_regressor(q, v, robot.forward_dynamics(q, v, tau))
        >>> bool(np.allclose(gradient.by_parameters[:20], -gradient.by_force @ Y))
        True
        """
    @overload
    def forward_dynamics_second_derivatives(self, q: NDArray[_F], v: NDArray[_F], tau: NDArray[_F], *, out: tuple[NDArray[_F], NDArray[_F], NDArray[_F], NDArray[_F]] | None = None, threads: int | None = None) -> ForwardDynamicsSecondDerivatives[_F]: ...
    @overload
    def forward_dynamics_second_derivatives(self, q: Numbers, v: Numbers, tau: Numbers, *, out: tuple[NDArray[np.float64], NDArray[np.float64], NDArray[np.float64], NDArray[np.float64]] | None = None, threads: int | None = None) -> ForwardDynamicsSecondDerivatives[np.float64]:
        """Second derivatives of a(q, v, τ) as tensors with the component of a first. Those that are not listed
        are zero, and ∂²a/∂q∂τ is ∂(M⁻¹)/∂q.

        Parameters
        ----------
        q : array_like, shape (..., nq)
            Configuration.
        v : array_like, shape (..., nv)
            Velocity [rad/s or m/s].
        tau : array_like, shape (..., nv)
            Torques [N·m or N].
        out : tuple of ndarray, optional
            Arrays that receive the results.
        threads : int, optional
            Threads for a batch; default: `num_threads()`.

        Returns
        -------
        ForwardDynamicsSecondDerivatives
            `position_position` (..., nv, nv, nv): ∂²aᵢ/∂qⱼ∂qₖ.
            `position_velocity` (..., nv, nv, nv): ∂²aᵢ/∂qⱼ∂vₖ.
            `velocity_velocity` (..., nv, nv, nv): ∂²aᵢ/∂vⱼ∂vₖ.
            `position_force` (..., nv, nv, nv): ∂²aᵢ/∂qⱼ∂τₖ.

        Raises
        ------
        SingularMassError
            M(q) is singular.
        StateError
            The state is invalid; `BadStatesError` for a batch.
        ShapeError
            An array has the wrong shape.
        DTypeError
            An array is neither float64 nor float32, or both occur.

        Examples
        --------
        >>> robot, q, v, tau = rd.example("two_r"), [0.3, 1.2], [1.0, -2.0], [3.0, 4.0]
        >>> second = robot.forward_dynamics_second_derivatives(q, v, tau)
        >>> H = robot.forward_dynamics_hessian(q, v, tau, [0.0, 1.0])
        >>> bool(np.allclose(H[:2, :2], second.position_position[1]))
        True
        """
    @overload
    def frame_acceleration(self, q: NDArray[_F], v: NDArray[_F], a: NDArray[_F], frame: str | int, reference_frame: ReferenceFrame = 'local_world_aligned', *, out: NDArray[_F] | None = None, threads: int | None = None) -> NDArray[_F]: ...
    @overload
    def frame_acceleration(self, q: Numbers, v: Numbers, a: Numbers, frame: str | int, reference_frame: ReferenceFrame = 'local_world_aligned', *, out: NDArray[np.float64] | None = None, threads: int | None = None) -> NDArray[np.float64]:
        """A frame's acceleration: the time derivative of the numbers of `frame_velocity` in the same reference
        frame, J a + J̇ v. It does not include gravity.

        In ``"local_world_aligned"`` it is p̈, the classical acceleration of the frame's origin. In
        ``"local"`` it is the spatial acceleration p̈ − ω × ṗ along the frame's axes, and in ``"world"`` that
        at the world's origin. These two equal Pinocchio's ``getFrameAcceleration``. Its
        ``getFrameAcceleration(LOCAL_WORLD_ALIGNED)`` is p̈ − ω × ṗ; its
        ``getFrameClassicalAcceleration(LOCAL_WORLD_ALIGNED)`` equals this function.

        Parameters
        ----------
        q : array_like, shape (..., nq)
            Configuration.
        v : array_like, shape (..., nv)
            Velocity [rad/s or m/s].
        a : array_like, shape (..., nv)
            Acceleration [rad/s² or m/s²].
        frame : str or int
            Name of the frame, or its index in `frame_names`.
        reference_frame : {"local", "world", "local_world_aligned"}
            ``local`` is the frame's axes and its origin, ``world`` the world's axes and the world's origin,
            ``local_world_aligned`` the world's axes and the frame's origin.
        out : ndarray, shape (..., 6), optional
            Array that receives the result.
        threads : int, optional
            Threads for a batch; default: `num_threads()`.

        Returns
        -------
        ndarray, shape (..., 6)
            Linear [m/s²], then angular [rad/s²].

        Raises
        ------
        FrameError
            The frame does not exist.
        ValueError
            `reference_frame` is unknown.
        StateError
            The state is invalid; `BadStatesError` for a batch.
        ShapeError
            An array has the wrong shape.
        DTypeError
            An array is neither float64 nor float32, or both occur.

        Examples
        --------
        >>> robot, zero = rd.example("two_r"), [0.0, 0.0]
        >>> robot.frame_acceleration(zero, [1.0, 0.0], zero, "tip").round(12)[:2]  # −ω² r
        array([-2.,  0.])
        >>> robot.frame_acceleration(zero, zero, [1.0, 0.0], "tip", "local").round(12)
        array([ 0.,  0.,  2.,  0., -1.,  0.])
        >>> robot.frame_acceleration(zero, zero, [1.0, 0.0], "tip", "world").round(12)
        array([ 0.,  0.,  0.,  0., -1.,  0.])
        """
    @overload
    def frame_acceleration_derivatives(self, q: NDArray[_F], v: NDArray[_F], a: NDArray[_F], frame: str | int, reference_frame: ReferenceFrame = 'local_world_aligned', *, out: tuple[NDArray[_F], NDArray[_F]] | None = None, threads: int | None = None) -> FrameAccelerationDerivatives[_F]: ...
    @overload
    def frame_acceleration_derivatives(self, q: Numbers, v: Numbers, a: Numbers, frame: str | int, reference_frame: ReferenceFrame = 'local_world_aligned', *, out: tuple[NDArray[np.float64], NDArray[np.float64]] | None = None, threads: int | None = None) -> FrameAccelerationDerivatives[np.float64]:
        """∂/∂q and ∂/∂v of `frame_acceleration` in the same reference frame; ∂/∂a is `frame_jacobian`.

        Derivatives by q are by displacements q ⊕ δq.

        Parameters
        ----------
        q : array_like, shape (..., nq)
            Configuration.
        v : array_like, shape (..., nv)
            Velocity [rad/s or m/s].
        a : array_like, shape (..., nv)
            Acceleration [rad/s² or m/s²].
        frame : str or int
            Name of the frame, or its index in `frame_names`.
        reference_frame : {"local", "world", "local_world_aligned"}
            ``local`` is the frame's axes and its origin, ``world`` the world's axes and the world's origin,
            ``local_world_aligned`` the world's axes and the frame's origin.
        out : tuple of ndarray, optional
            Arrays that receive the results.
        threads : int, optional
            Threads for a batch; default: `num_threads()`.

        Returns
        -------
        FrameAccelerationDerivatives
            `by_position` (..., 6, nv): derivative by q.
            `by_velocity` (..., 6, nv): derivative by v.

        Raises
        ------
        FrameError
            The frame does not exist.
        ValueError
            `reference_frame` is unknown.
        StateError
            The state is invalid; `BadStatesError` for a batch.
        ShapeError
            An array has the wrong shape.
        DTypeError
            An array is neither float64 nor float32, or both occur.

        Examples
        --------
        >>> robot, zero = rd.example("two_r"), [0.0, 0.0]
        >>> robot.frame_acceleration_derivatives(zero, [1.0, 0.0], zero, "tip").by_velocity[0].round(12)
        array([-4., -2.])
        >>> robot.frame_acceleration_derivatives(zero, zero, [1.0, 0.0], "tip", "local").by_position[0].round(12)
        array([0., 1.])
        """
    @overload
    def frame_bias_acceleration(self, q: NDArray[_F], v: NDArray[_F], frame: str | int, reference_frame: ReferenceFrame = 'local_world_aligned', *, out: NDArray[_F] | None = None, threads: int | None = None) -> NDArray[_F]: ...
    @overload
    def frame_bias_acceleration(self, q: Numbers, v: Numbers, frame: str | int, reference_frame: ReferenceFrame = 'local_world_aligned', *, out: NDArray[np.float64] | None = None, threads: int | None = None) -> NDArray[np.float64]:
        """J̇ v of `frame_jacobian` in the same reference frame: `frame_acceleration` at a = 0.

        Parameters
        ----------
        q : array_like, shape (..., nq)
            Configuration.
        v : array_like, shape (..., nv)
            Velocity [rad/s or m/s].
        frame : str or int
            Name of the frame, or its index in `frame_names`.
        reference_frame : {"local", "world", "local_world_aligned"}
            ``local`` is the frame's axes and its origin, ``world`` the world's axes and the world's origin,
            ``local_world_aligned`` the world's axes and the frame's origin.
        out : ndarray, shape (..., 6), optional
            Array that receives the result.
        threads : int, optional
            Threads for a batch; default: `num_threads()`.

        Returns
        -------
        ndarray, shape (..., 6)
            Linear [m/s²], then angular [rad/s²].

        Raises
        ------
        FrameError
            The frame does not exist.
        ValueError
            `reference_frame` is unknown.
        StateError
            The state is invalid; `BadStatesError` for a batch.
        ShapeError
            An array has the wrong shape.
        DTypeError
            An array is neither float64 nor float32, or both occur.

        Examples
        --------
        >>> robot = rd.example("two_r")
        >>> robot.frame_bias_acceleration([0.0, 0.0], [1.0, 0.0], "tip").round(12)[:2]
        array([-2.,  0.])
        >>> robot.frame_bias_acceleration([0.0, 0.0], [0.0, 0.0], "tip", "local") @ np.ones(6)
        np.float64(0.0)
        """
    @overload
    def frame_jacobian(self, q: NDArray[_F], frame: str | int, reference_frame: ReferenceFrame = 'local_world_aligned', *, out: NDArray[_F] | None = None, threads: int | None = None) -> NDArray[_F]: ...
    @overload
    def frame_jacobian(self, q: Numbers, frame: str | int, reference_frame: ReferenceFrame = 'local_world_aligned', *, out: NDArray[np.float64] | None = None, threads: int | None = None) -> NDArray[np.float64]:
        """A frame's Jacobian J: `frame_velocity` is J v in the same reference frame.

        Pinocchio has the same reference frames by the same names.

        Parameters
        ----------
        q : array_like, shape (..., nq)
            Configuration.
        frame : str or int
            Name of the frame, or its index in `frame_names`.
        reference_frame : {"local", "world", "local_world_aligned"}
            ``local`` is the frame's axes and its origin, ``world`` the world's axes and the world's origin,
            ``local_world_aligned`` the world's axes and the frame's origin.
        out : ndarray, shape (..., 6, nv), optional
            Array that receives the result.
        threads : int, optional
            Threads for a batch; default: `num_threads()`.

        Returns
        -------
        ndarray, shape (..., 6, nv)
            J, linear rows, then angular rows.

        Raises
        ------
        FrameError
            The frame does not exist.
        ValueError
            `reference_frame` is unknown.
        StateError
            The state is invalid; `BadStatesError` for a batch.
        ShapeError
            An array has the wrong shape.
        DTypeError
            An array is neither float64 nor float32, or both occur.

        Examples
        --------
        >>> robot, q = rd.example("two_r"), [0.0, np.pi / 2]
        >>> robot.frame_jacobian(q, "tip")[[0, 2]].round(12) + 0.0  # along x, and up
        array([[-1., -1.],
               [ 1.,  0.]])
        >>> R = robot.frame_pose(q, "tip")[:3, :3]
        >>> own, world = robot.frame_jacobian(q, "tip", "local"), robot.frame_jacobian(q, "tip")
        >>> bool(np.allclose(R @ own[:3], world[:3]))
        True
        >>> robot.frame_jacobian(q, "tip", "world")[4]  # both joints rotate about −y
        array([-1., -1.])
        """
    @overload
    def frame_jacobian_derivative(self, q: NDArray[_F], frame: str | int, reference_frame: ReferenceFrame = 'local_world_aligned', *, out: NDArray[_F] | None = None, threads: int | None = None) -> NDArray[_F]: ...
    @overload
    def frame_jacobian_derivative(self, q: Numbers, frame: str | int, reference_frame: ReferenceFrame = 'local_world_aligned', *, out: NDArray[np.float64] | None = None, threads: int | None = None) -> NDArray[np.float64]:
        """Derivative ∂J/∂q of `frame_jacobian`: at (r, j, k) that of J_rj by q_k, along `integrate(q, δ e_k)`.

        Parameters
        ----------
        q : array_like, shape (..., nq)
            Configuration.
        frame : str or int
            Name of the frame, or its index in `frame_names`.
        reference_frame : {"local", "world", "local_world_aligned"}
            ``local`` is the frame's axes and its origin, ``world`` the world's axes and the world's origin,
            ``local_world_aligned`` the world's axes and the frame's origin.
        out : ndarray, shape (..., 6, nv, nv), optional
            Array that receives the result.
        threads : int, optional
            Threads for a batch; default: `num_threads()`.

        Returns
        -------
        ndarray, shape (..., 6, nv, nv)
            ∂J/∂q.

        Raises
        ------
        FrameError
            The frame does not exist.
        ValueError
            `reference_frame` is unknown.
        StateError
            The state is invalid; `BadStatesError` for a batch.
        ShapeError
            An array has the wrong shape.
        DTypeError
            An array is neither float64 nor float32, or both occur.

        Examples
        --------
        >>> robot, q, v = rd.example("two_r"), [0.3, 1.2], np.array([1.0, -2.0])
        >>> rate = robot.frame_jacobian_derivative(q, "tip") @ v
        >>> bool(np.allclose(rate @ v, robot.frame_acceleration(q, v, [0.0, 0.0], "tip")))
        True
        """
    @property
    def frame_names(self) -> list[str]:
        """The names of all frames: links, and what the file adds to them; an index into this list is a frame,
        too.
        """
    @overload
    def frame_pose(self, q: NDArray[_F], frame: str | int, *, out: NDArray[_F] | None = None, threads: int | None = None) -> NDArray[_F]: ...
    @overload
    def frame_pose(self, q: Numbers, frame: str | int, *, out: NDArray[np.float64] | None = None, threads: int | None = None) -> NDArray[np.float64]:
        """`world_from_frame` of one frame, as a homogeneous matrix [R p; 0 1]: x_world = R x_frame + p.

        Parameters
        ----------
        q : array_like, shape (..., nq)
            Configuration.
        frame : str or int
            Name of the frame, or its index in `frame_names`.
        out : ndarray, shape (..., 4, 4), optional
            Array that receives the result.
        threads : int, optional
            Threads for a batch; default: `num_threads()`.

        Returns
        -------
        ndarray, shape (..., 4, 4)
            `world_from_frame`.

        Raises
        ------
        FrameError
            The frame does not exist.
        StateError
            The state is invalid; `BadStatesError` for a batch.
        ShapeError
            An array has the wrong shape.
        DTypeError
            An array is neither float64 nor float32, or both occur.

        Examples
        --------
        >>> rd.example("two_r").frame_pose([0.0, np.pi / 2], "tip")[:3, 3].round(12)
        array([1., 0., 1.])
        """
    @overload
    def frame_pose_hessian(self, q: NDArray[_F], weights: NDArray[_F], frame: str | int, reference_frame: ReferenceFrame = 'local_world_aligned', *, out: NDArray[_F] | None = None, threads: int | None = None) -> NDArray[_F]: ...
    @overload
    def frame_pose_hessian(self, q: Numbers, weights: Numbers, frame: str | int, reference_frame: ReferenceFrame = 'local_world_aligned', *, out: NDArray[np.float64] | None = None, threads: int | None = None) -> NDArray[np.float64]:
        """Second derivative Σ λᵣ ∂²ξᵣ/∂q² of a frame's pose for multipliers λ (`weights`), symmetric.

        ξ is the displacement of the frame that q ⊕ x causes; its first derivative is the Jacobian. For
        ``local_world_aligned`` its linear part is the displacement of the origin.

        Parameters
        ----------
        q : array_like, shape (..., nq)
            Configuration.
        weights : array_like, shape (..., 6)
            Multipliers of the motion: linear, then angular.
        frame : str or int
            Name of the frame, or its index in `frame_names`.
        reference_frame : {"local", "world", "local_world_aligned"}
            ``local`` is the frame's axes and its origin, ``world`` the world's axes and the world's origin,
            ``local_world_aligned`` the world's axes and the frame's origin.
        out : ndarray, shape (..., nv, nv), optional
            Array that receives the result.
        threads : int, optional
            Threads for a batch; default: `num_threads()`.

        Returns
        -------
        ndarray, shape (..., nv, nv)
            Σ λᵣ ∂²ξᵣ/∂q².

        Raises
        ------
        FrameError
            The frame does not exist.
        ValueError
            `reference_frame` is unknown.
        StateError
            The state is invalid; `BadStatesError` for a batch.
        ShapeError
            An array has the wrong shape.
        DTypeError
            An array is neither float64 nor float32, or both occur.

        Examples
        --------
        >>> robot, q = rd.example("two_r"), [0.3, 1.2]
        >>> H = robot.frame_pose_hessian(q, [1.0, 0, 0, 0, 0, 0], "tip")
        >>> bool(np.allclose(H, robot.frame_jacobian_derivative(q, "tip")[0]))
        True
        """
    @overload
    def frame_poses(self, q: NDArray[_F], frames: Sequence[str | int] | None = None, *, out: NDArray[_F] | None = None, threads: int | None = None) -> NDArray[_F]: ...
    @overload
    def frame_poses(self, q: Numbers, frames: Sequence[str | int] | None = None, *, out: NDArray[np.float64] | None = None, threads: int | None = None) -> NDArray[np.float64]:
        """`world_from_frame` of frames, as homogeneous matrices [R p; 0 1]: x_world = R x_frame + p.

        Parameters
        ----------
        q : array_like, shape (..., nq)
            Configuration.
        frames : sequence of str or int, optional
            Names of frames, or their indices in `frame_names`; default: all frames, in the order of
            `frame_names`.
        out : ndarray, shape (..., frames, 4, 4), optional
            Array that receives the result.
        threads : int, optional
            Threads for a batch; default: `num_threads()`.

        Returns
        -------
        ndarray, shape (..., frames, 4, 4)
            `world_from_frame` of each frame.

        Raises
        ------
        FrameError
            A frame does not exist.
        StateError
            The state is invalid; `BadStatesError` for a batch.
        ShapeError
            An array has the wrong shape.
        DTypeError
            An array is neither float64 nor float32, or both occur.

        Examples
        --------

        >>> robot = rd.example("two_r")
        >>> robot.frame_poses([0.0, np.pi / 2], ["tip"])[0, :3, 3].round(12)  # 1 m along x, then 1 m up
        array([1., 0., 1.])
        """
    @overload
    def frame_velocity(self, q: NDArray[_F], v: NDArray[_F], frame: str | int, reference_frame: ReferenceFrame = 'local_world_aligned', *, out: NDArray[_F] | None = None, threads: int | None = None) -> NDArray[_F]: ...
    @overload
    def frame_velocity(self, q: Numbers, v: Numbers, frame: str | int, reference_frame: ReferenceFrame = 'local_world_aligned', *, out: NDArray[np.float64] | None = None, threads: int | None = None) -> NDArray[np.float64]:
        """A frame's velocity: J v with J of `frame_jacobian` in the same reference frame.

        By `reference_frame`, ``"local"`` is ṗ of the frame's origin p and ω along the frame's axes, and
        ``"local_world_aligned"`` both along the world's axes. In ``"world"`` they are ṗ − ω × p and ω along
        the world's axes.

        Parameters
        ----------
        q : array_like, shape (..., nq)
            Configuration.
        v : array_like, shape (..., nv)
            Velocity [rad/s or m/s].
        frame : str or int
            Name of the frame, or its index in `frame_names`.
        reference_frame : {"local", "world", "local_world_aligned"}
            ``local`` is the frame's axes and its origin, ``world`` the world's axes and the world's origin,
            ``local_world_aligned`` the world's axes and the frame's origin.
        out : ndarray, shape (..., 6), optional
            Array that receives the result.
        threads : int, optional
            Threads for a batch; default: `num_threads()`.

        Returns
        -------
        ndarray, shape (..., 6)
            Linear [m/s], then angular [rad/s].

        Raises
        ------
        FrameError
            The frame does not exist.
        ValueError
            `reference_frame` is unknown.
        StateError
            The state is invalid; `BadStatesError` for a batch.
        ShapeError
            An array has the wrong shape.
        DTypeError
            An array is neither float64 nor float32, or both occur.

        Examples
        --------
        >>> robot, q, v = rd.example("two_r"), [0.0, np.pi / 2], [1.0, 0.5]
        >>> bool(np.allclose(robot.frame_velocity(q, v, "tip"), robot.frame_jacobian(q, "tip") @ v))
        True
        >>> robot.frame_velocity([0.0, 0.0], [1.0, 0.0], "tip", "local").round(12)
        array([ 0.,  0.,  2.,  0., -1.,  0.])
        >>> robot.frame_velocity([0.0, 0.0], [1.0, 0.0], "tip", "world").round(12)
        array([ 0.,  0.,  0.,  0., -1.,  0.])
        """
    @overload
    def frame_velocity_derivative(self, q: NDArray[_F], v: NDArray[_F], frame: str | int, reference_frame: ReferenceFrame = 'local_world_aligned', *, out: NDArray[_F] | None = None, threads: int | None = None) -> NDArray[_F]: ...
    @overload
    def frame_velocity_derivative(self, q: Numbers, v: Numbers, frame: str | int, reference_frame: ReferenceFrame = 'local_world_aligned', *, out: NDArray[np.float64] | None = None, threads: int | None = None) -> NDArray[np.float64]:
        """∂/∂q of `frame_velocity` in the same reference frame; ∂/∂v is `frame_jacobian`.

        Derivatives by q are by displacements q ⊕ δq.

        Parameters
        ----------
        q : array_like, shape (..., nq)
            Configuration.
        v : array_like, shape (..., nv)
            Velocity [rad/s or m/s].
        frame : str or int
            Name of the frame, or its index in `frame_names`.
        reference_frame : {"local", "world", "local_world_aligned"}
            ``local`` is the frame's axes and its origin, ``world`` the world's axes and the world's origin,
            ``local_world_aligned`` the world's axes and the frame's origin.
        out : ndarray, shape (..., 6, nv), optional
            Array that receives the result.
        threads : int, optional
            Threads for a batch; default: `num_threads()`.

        Returns
        -------
        ndarray, shape (..., 6, nv)
            Derivative by q, linear rows, then angular rows.

        Raises
        ------
        FrameError
            The frame does not exist.
        ValueError
            `reference_frame` is unknown.
        StateError
            The state is invalid; `BadStatesError` for a batch.
        ShapeError
            An array has the wrong shape.
        DTypeError
            An array is neither float64 nor float32, or both occur.

        Examples
        --------
        >>> robot = rd.example("two_r")
        >>> robot.frame_velocity_derivative([0.0, 0.0], [1.0, 0.0], "tip")[0].round(12)
        array([-2., -1.])
        >>> robot.frame_velocity_derivative([0.0, 0.0], [1.0, 0.0], "tip", "local")[0].round(12)
        array([0., 1.])
        """
    @overload
    def frame_velocity_hessian(self, q: NDArray[_F], v: NDArray[_F], weights: NDArray[_F], frame: str | int, reference_frame: ReferenceFrame = 'local_world_aligned', *, out: NDArray[_F] | None = None, threads: int | None = None) -> NDArray[_F]: ...
    @overload
    def frame_velocity_hessian(self, q: Numbers, v: Numbers, weights: Numbers, frame: str | int, reference_frame: ReferenceFrame = 'local_world_aligned', *, out: NDArray[np.float64] | None = None, threads: int | None = None) -> NDArray[np.float64]:
        """Hessian of λᵀV for the velocity V(q, v) of `frame_velocity` and multipliers λ (`weights`), symmetric,
        in the order q, v.

        Parameters
        ----------
        q : array_like, shape (..., nq)
            Configuration.
        v : array_like, shape (..., nv)
            Velocity [rad/s or m/s].
        weights : array_like, shape (..., 6)
            Multipliers of the motion: linear, then angular.
        frame : str or int
            Name of the frame, or its index in `frame_names`.
        reference_frame : {"local", "world", "local_world_aligned"}
            ``local`` is the frame's axes and its origin, ``world`` the world's axes and the world's origin,
            ``local_world_aligned`` the world's axes and the frame's origin.
        out : ndarray, shape (..., 2·nv, 2·nv), optional
            Array that receives the result.
        threads : int, optional
            Threads for a batch; default: `num_threads()`.

        Returns
        -------
        ndarray, shape (..., 2·nv, 2·nv)
            H in the order q, v.

        Raises
        ------
        FrameError
            The frame does not exist.
        ValueError
            `reference_frame` is unknown.
        StateError
            The state is invalid; `BadStatesError` for a batch.
        ShapeError
            An array has the wrong shape.
        DTypeError
            An array is neither float64 nor float32, or both occur.

        Examples
        --------
        >>> robot, q, v = rd.example("two_r"), [0.3, 1.2], [1.0, -2.0]
        >>> H = robot.frame_velocity_hessian(q, v, [1.0, 0, 0, 0, 0, 0], "tip")
        >>> bool(np.allclose(H[2:, :2], robot.frame_jacobian_derivative(q, "tip")[0]))
        True
        """
    @overload
    def gravity(self, q: NDArray[_F], *, out: NDArray[_F] | None = None, threads: int | None = None) -> NDArray[_F]: ...
    @overload
    def gravity(self, q: Numbers, *, out: NDArray[np.float64] | None = None, threads: int | None = None) -> NDArray[np.float64]:
        """g(q) = ∂V/∂q: the forces that hold it still, springs of the joints included. `gravity_vector` is the
        field's acceleration.

        Parameters
        ----------
        q : array_like, shape (..., nq)
            Configuration.
        out : ndarray, shape (..., nv), optional
            Array that receives the result.
        threads : int, optional
            Threads for a batch; default: `num_threads()`.

        Returns
        -------
        ndarray, shape (..., nv)
            g(q) [N·m or N].

        Raises
        ------
        StateError
            The state is invalid; `BadStatesError` for a batch.
        ShapeError
            An array has the wrong shape.
        DTypeError
            An array is neither float64 nor float32, or both occur.

        Examples
        --------
        >>> robot = rd.example("two_r")  # two rods of 1 m, 2 kg and 1 kg
        >>> robot.gravity([np.pi / 4, np.pi / 2]).round(4)
        array([10.4051, -3.4684])
        """
    @overload
    def gravity_derivative(self, q: NDArray[_F], *, out: NDArray[_F] | None = None, threads: int | None = None) -> NDArray[_F]: ...
    @overload
    def gravity_derivative(self, q: Numbers, *, out: NDArray[np.float64] | None = None, threads: int | None = None) -> NDArray[np.float64]:
        """∂g/∂q, the Hessian of V.

        Derivatives by q are those of `inverse_dynamics_derivatives`.

        Parameters
        ----------
        q : array_like, shape (..., nq)
            Configuration.
        out : ndarray, shape (..., nv, nv), optional
            Array that receives the result.
        threads : int, optional
            Threads for a batch; default: `num_threads()`.

        Returns
        -------
        ndarray, shape (..., nv, nv)
            Symmetric for joints of one coordinate.

        Raises
        ------
        StateError
            The state is invalid; `BadStatesError` for a batch.
        ShapeError
            An array has the wrong shape.
        DTypeError
            An array is neither float64 nor float32, or both occur.

        Examples
        --------
        >>> rd.example("two_r").gravity_derivative([np.pi / 2, 0.0]).round(3)  # upright
        array([[-24.525,  -4.905],
               [ -4.905,  -4.905]])
        """
    @property
    def gravity_vector(self) -> tuple[float, float, float]:
        """The acceleration of free fall in the world [m/s²]."""
    @property
    def inertial_parameter_names(self) -> list[str]:
        """The names of π's entries.

        >>> rd.example("two_r").inertial_parameter_names[10:12]
        ['link2.m', 'link2.hx']
        """
    @property
    def inertial_parameters(self) -> NDArray[np.float64]:
        """π: mass, first moments m c and six second moments about the link's origin of each link that moves,
        (10·moving links,).

        In the order of `inertial_parameter_names` [kg, kg·m, kg·m²].

        >>> robot = rd.example("two_r")
        >>> bool(np.isclose(robot.inertial_parameters[::10].sum(), robot.mass))
        True
        """
    @overload
    def integrate(self, q: NDArray[_F], d: NDArray[_F], *, out: NDArray[_F] | None = None, threads: int | None = None) -> NDArray[_F]: ...
    @overload
    def integrate(self, q: Numbers, d: Numbers, *, out: NDArray[np.float64] | None = None, threads: int | None = None) -> NDArray[np.float64]:
        """q ⊕ d: the configuration reached by moving along d, a velocity times a time.

        It is q + d for angles and lengths; quaternions turn about d in the body's axes.

        Parameters
        ----------
        q : array_like, shape (..., nq)
            Configuration.
        d : array_like, shape (..., nv)
            Displacement, a velocity times a time [rad or m].
        out : ndarray, shape (..., nq), optional
            Array that receives the result.
        threads : int, optional
            Threads for a batch; default: `num_threads()`.

        Returns
        -------
        ndarray, shape (..., nq)
            Configuration.

        Raises
        ------
        StateError
            The state is invalid; `BadStatesError` for a batch.
        ShapeError
            An array has the wrong shape.
        DTypeError
            An array is neither float64 nor float32, or both occur.

        Examples
        --------
        >>> rd.example("two_r").integrate([0.3, 1.2], [0.1, -0.2]).round(12)
        array([0.4, 1. ])
        """
    @overload
    def interpolate(self, q0: NDArray[_F], q1: NDArray[_F], s: Numbers, *, out: NDArray[_F] | None = None, threads: int | None = None) -> NDArray[_F]: ...
    @overload
    def interpolate(self, q0: Numbers, q1: Numbers, s: Numbers, *, out: NDArray[np.float64] | None = None, threads: int | None = None) -> NDArray[np.float64]:
        """q0 ⊕ s (q1 ⊖ q0): the configuration at s on the shortest way, 0 at q0 and 1 at q1.

        Parameters
        ----------
        q0 : array_like, shape (..., nq)
            Configuration at the start.
        q1 : array_like, shape (..., nq)
            Configuration at the end.
        s : array_like, shape (...)
            Fraction of the way: 0 at `q0`, 1 at `q1`.
        out : ndarray, shape (..., nq), optional
            Array that receives the result.
        threads : int, optional
            Threads for a batch; default: `num_threads()`.

        Returns
        -------
        ndarray, shape (..., nq)
            Configuration.

        Raises
        ------
        StateError
            The state is invalid; `BadStatesError` for a batch.
        ShapeError
            An array has the wrong shape.
        DTypeError
            An array is neither float64 nor float32, or both occur.

        Examples
        --------
        >>> rd.example("two_r").interpolate([0.0, 0.0], [1.0, -2.0], 0.5)
        array([ 0.5, -1. ])
        """
    @overload
    def inverse_dynamics(self, q: NDArray[_F], v: NDArray[_F], a: NDArray[_F], *, out: NDArray[_F] | None = None, threads: int | None = None) -> NDArray[_F]: ...
    @overload
    def inverse_dynamics(self, q: Numbers, v: Numbers, a: Numbers, *, out: NDArray[np.float64] | None = None, threads: int | None = None) -> NDArray[np.float64]:
        """τ = M(q) a + C(q, v) v + g(q): the generalized forces of a motion (recursive Newton–Euler).

        Damping and friction are not in it: see `dissipation`.

        Parameters
        ----------
        q : array_like, shape (..., nq)
            Configuration.
        v : array_like, shape (..., nv)
            Velocity [rad/s or m/s].
        a : array_like, shape (..., nv)
            Acceleration [rad/s² or m/s²].
        out : ndarray, shape (..., nv), optional
            Array that receives the result.
        threads : int, optional
            Threads for a batch; default: `num_threads()`.

        Returns
        -------
        ndarray, shape (..., nv)
            Generalized forces τ [N·m or N].

        Raises
        ------
        StateError
            The state is invalid; `BadStatesError` for a batch.
        ShapeError
            An array has the wrong shape.
        DTypeError
            An array is neither float64 nor float32, or both occur.

        Examples
        --------
        >>> robot, q, v = rd.example("panda"), np.zeros((1000, 7)), np.zeros(7)
        >>> robot.inverse_dynamics(q, v, v).shape
        (1000, 7)
        """
    @overload
    def inverse_dynamics_derivatives(self, q: NDArray[_F], v: NDArray[_F], a: NDArray[_F], *, out: tuple[NDArray[_F], NDArray[_F]] | None = None, threads: int | None = None) -> InverseDynamicsDerivatives[_F]: ...
    @overload
    def inverse_dynamics_derivatives(self, q: Numbers, v: Numbers, a: Numbers, *, out: tuple[NDArray[np.float64], NDArray[np.float64]] | None = None, threads: int | None = None) -> InverseDynamicsDerivatives[np.float64]:
        """∂τ/∂q and ∂τ/∂v of τ(q, v, a); ∂τ/∂a is M.

        Derivatives by q are by displacements q ⊕ δq: the same as by q for joints of one coordinate, in nv
        numbers for quaternions.

        Parameters
        ----------
        q : array_like, shape (..., nq)
            Configuration.
        v : array_like, shape (..., nv)
            Velocity [rad/s or m/s].
        a : array_like, shape (..., nv)
            Acceleration [rad/s² or m/s²].
        out : tuple of ndarray, optional
            Arrays that receive the results.
        threads : int, optional
            Threads for a batch; default: `num_threads()`.

        Returns
        -------
        InverseDynamicsDerivatives
            `by_position` (..., nv, nv): ∂τ/∂q.
            `by_velocity` (..., nv, nv): ∂τ/∂v.

        Raises
        ------
        StateError
            The state is invalid; `BadStatesError` for a batch.
        ShapeError
            An array has the wrong shape.
        DTypeError
            An array is neither float64 nor float32, or both occur.

        Examples
        --------
        >>> robot, q, v = rd.example("two_r"), [0.3, 1.2], [0.0, 0.0]
        >>> derivatives = robot.inverse_dynamics_derivatives(q, v, v)
        >>> bool(np.allclose(derivatives.by_position, robot.gravity_derivative(q)))  # at rest
        True
        """
    @overload
    def inverse_dynamics_hessian(self, q: NDArray[_F], v: NDArray[_F], a: NDArray[_F], cotangent: NDArray[_F], *, out: NDArray[_F] | None = None, threads: int | None = None) -> NDArray[_F]: ...
    @overload
    def inverse_dynamics_hessian(self, q: Numbers, v: Numbers, a: Numbers, cotangent: Numbers, *, out: NDArray[np.float64] | None = None, threads: int | None = None) -> NDArray[np.float64]:
        """Hessian H of λᵀτ(q, v, a) for multipliers λ (`cotangent`), symmetric, in the order q, v, a.

        H_αβ = ∂²/∂s∂t λᵀτ at (q, v, a) ⊕ (sα + tβ), with q ⊕ δ of `integrate`. It is symmetric also for
        joints with quaternions.

        Parameters
        ----------
        q : array_like, shape (..., nq)
            Configuration.
        v : array_like, shape (..., nv)
            Velocity [rad/s or m/s].
        a : array_like, shape (..., nv)
            Acceleration [rad/s² or m/s²].
        cotangent : array_like, shape (..., nv)
            Gradient, one number for each degree of freedom.
        out : ndarray, shape (..., 3·nv, 3·nv), optional
            Array that receives the result.
        threads : int, optional
            Threads for a batch; default: `num_threads()`.

        Returns
        -------
        ndarray, shape (..., 3·nv, 3·nv)
            H in the order q, v, a.

        Raises
        ------
        StateError
            The state is invalid; `BadStatesError` for a batch.
        ShapeError
            An array has the wrong shape.
        DTypeError
            An array is neither float64 nor float32, or both occur.

        Examples
        --------
        >>> robot, q, v, a = rd.example("two_r"), [0.3, 1.2], [1.0, -2.0], [3.0, 4.0]
        >>> H = robot.inverse_dynamics_hessian(q, v, a, [1.0, 0.0])
        >>> second = robot.inverse_dynamics_second_derivatives(q, v, a)
        >>> bool(np.allclose(H[:2, 2:4], second.position_velocity[0]))
        True
        """
    @overload
    def inverse_dynamics_hessian_product(self, q: NDArray[_F], v: NDArray[_F], a: NDArray[_F], cotangent: NDArray[_F], direction: NDArray[_F], *, out: NDArray[_F] | None = None, threads: int | None = None) -> NDArray[_F]: ...
    @overload
    def inverse_dynamics_hessian_product(self, q: Numbers, v: Numbers, a: Numbers, cotangent: Numbers, direction: Numbers, *, out: NDArray[np.float64] | None = None, threads: int | None = None) -> NDArray[np.float64]:
        """Product H α of `inverse_dynamics_hessian` and a direction α = (δq, δv, δa), in O(n) without H.

        Parameters
        ----------
        q : array_like, shape (..., nq)
            Configuration.
        v : array_like, shape (..., nv)
            Velocity [rad/s or m/s].
        a : array_like, shape (..., nv)
            Acceleration [rad/s² or m/s²].
        cotangent : array_like, shape (..., nv)
            Gradient, one number for each degree of freedom.
        direction : array_like, shape (..., 3·nv)
            Direction: a displacement of q, then changes of the next two arguments.
        out : ndarray, shape (..., 3·nv), optional
            Array that receives the result.
        threads : int, optional
            Threads for a batch; default: `num_threads()`.

        Returns
        -------
        ndarray, shape (..., 3·nv)
            H α in the order q, v, a.

        Raises
        ------
        StateError
            The state is invalid; `BadStatesError` for a batch.
        ShapeError
            An array has the wrong shape.
        DTypeError
            An array is neither float64 nor float32, or both occur.

        Examples
        --------
        >>> robot, q, v, a = rd.example("two_r"), [0.3, 1.2], [1.0, -2.0], [3.0, 4.0]
        >>> H, along = robot.inverse_dynamics_hessian(q, v, a, [1.0, 0.0]), np.arange(6.0)
        >>> bool(np.allclose(robot.inverse_dynamics_hessian_product(q, v, a, [1.0, 0.0], along), H @ along))
        True
        """
    @overload
    def inverse_dynamics_pullback(self, q: NDArray[_F], v: NDArray[_F], a: NDArray[_F], cotangent: NDArray[_F], *, out: tuple[NDArray[_F], NDArray[_F], NDArray[_F]] | None = None, threads: int | None = None) -> InverseDynamicsPullback[_F]: ...
    @overload
    def inverse_dynamics_pullback(self, q: Numbers, v: Numbers, a: Numbers, cotangent: Numbers, *, out: tuple[NDArray[np.float64], NDArray[np.float64], NDArray[np.float64]] | None = None, threads: int | None = None) -> InverseDynamicsPullback[np.float64]:
        """λᵀ ∂τ/∂q, λᵀ ∂τ/∂v and λᵀ ∂τ/∂a of τ(q, v, a) for a cotangent λ of τ, as reverse differentiation needs
        them. The cost is O(n); no Jacobian is formed.

        Gradients by q are by displacements q ⊕ δq; `cotangent_to_coordinates` gives them by the numbers of q.

        Parameters
        ----------
        q : array_like, shape (..., nq)
            Configuration.
        v : array_like, shape (..., nv)
            Velocity [rad/s or m/s].
        a : array_like, shape (..., nv)
            Acceleration [rad/s² or m/s²].
        cotangent : array_like, shape (..., nv)
            Gradient, one number for each degree of freedom.
        out : tuple of ndarray, optional
            Arrays that receive the results.
        threads : int, optional
            Threads for a batch; default: `num_threads()`.

        Returns
        -------
        InverseDynamicsPullback
            `by_position` (..., nv): λᵀ ∂τ/∂q.
            `by_velocity` (..., nv): λᵀ ∂τ/∂v.
            `by_acceleration` (..., nv): λᵀ M.

        Raises
        ------
        StateError
            The state is invalid; `BadStatesError` for a batch.
        ShapeError
            An array has the wrong shape.
        DTypeError
            An array is neither float64 nor float32, or both occur.

        Examples
        --------
        >>> robot, q, v, a = rd.example("two_r"), [0.3, 1.2], [1.0, -2.0], [3.0, 4.0]
        >>> gradient = robot.inverse_dynamics_pullback(q, v, a, [1.0, 0.0])  # of the first joint's torque
        >>> bool(np.allclose(gradient.by_position, robot.inverse_dynamics_derivatives(q, v, a).by_position[0]))
        True
        """
    @overload
    def inverse_dynamics_pullback_derivative(self, q: NDArray[_F], v: NDArray[_F], a: NDArray[_F], cotangent: NDArray[_F], *, out: NDArray[_F] | None = None, threads: int | None = None) -> NDArray[_F]: ...
    @overload
    def inverse_dynamics_pullback_derivative(self, q: Numbers, v: Numbers, a: Numbers, cotangent: Numbers, *, out: NDArray[np.float64] | None = None, threads: int | None = None) -> NDArray[np.float64]:
        """Derivative D of `inverse_dynamics_pullback`: row α has the change of its results along the direction
        α, in the order q, v, a. It differs from `inverse_dynamics_hessian` only for pairs of displacements of
        one joint with a quaternion, whose order matters.

        Parameters
        ----------
        q : array_like, shape (..., nq)
            Configuration.
        v : array_like, shape (..., nv)
            Velocity [rad/s or m/s].
        a : array_like, shape (..., nv)
            Acceleration [rad/s² or m/s²].
        cotangent : array_like, shape (..., nv)
            Gradient, one number for each degree of freedom.
        out : ndarray, shape (..., 3·nv, 3·nv), optional
            Array that receives the result.
        threads : int, optional
            Threads for a batch; default: `num_threads()`.

        Returns
        -------
        ndarray, shape (..., 3·nv, 3·nv)
            D in the order q, v, a.

        Raises
        ------
        StateError
            The state is invalid; `BadStatesError` for a batch.
        ShapeError
            An array has the wrong shape.
        DTypeError
            An array is neither float64 nor float32, or both occur.

        Examples
        --------
        >>> robot, q, v, a = rd.example("two_r"), [0.3, 1.2], [1.0, -2.0], [3.0, 4.0]
        >>> D = robot.inverse_dynamics_pullback_derivative(q, v, a, [1.0, 0.0])
        >>> bool(np.allclose(D, robot.inverse_dynamics_hessian(q, v, a, [1.0, 0.0])))
        True
        """
    @overload
    def inverse_dynamics_pullback_with_parameters(self, q: NDArray[_F], v: NDArray[_F], a: NDArray[_F], cotangent: NDArray[_F], *, out: tuple[NDArray[_F], NDArray[_F], NDArray[_F], NDArray[_F]] | None = None, threads: int | None = None) -> InverseDynamicsPullbackWithParameters[_F]: ...
    @overload
    def inverse_dynamics_pullback_with_parameters(self, q: Numbers, v: Numbers, a: Numbers, cotangent: Numbers, *, out: tuple[NDArray[np.float64], NDArray[np.float64], NDArray[np.float64], NDArray[np.float64]] | None = None, threads: int | None = None) -> InverseDynamicsPullbackWithParameters[np.float64]:
        """`inverse_dynamics_pullback` with λᵀ ∂τ/∂p for the `parameters()` p, too. For the inertial ones it is
        λᵀY with the `joint_torque_regressor` Y, which is not formed.

        Damping and friction are not in τ, so their gradients are 0. Those of `dissipation` are λ v and λ sign
        v.

        Parameters
        ----------
        q : array_like, shape (..., nq)
            Configuration.
        v : array_like, shape (..., nv)
            Velocity [rad/s or m/s].
        a : array_like, shape (..., nv)
            Acceleration [rad/s² or m/s²].
        cotangent : array_like, shape (..., nv)
            Gradient, one number for each degree of freedom.
        out : tuple of ndarray, optional
            Arrays that receive the results.
        threads : int, optional
            Threads for a batch; default: `num_threads()`.

        Returns
        -------
        InverseDynamicsPullbackWithParameters
            `by_position` (..., nv): λᵀ ∂τ/∂q.
            `by_velocity` (..., nv): λᵀ ∂τ/∂v.
            `by_acceleration` (..., nv): λᵀ M.
            `by_parameters` (..., parameters): λᵀ ∂τ/∂p, named by `parameter_names`.

        Raises
        ------
        StateError
            The state is invalid; `BadStatesError` for a batch.
        ShapeError
            An array has the wrong shape.
        DTypeError
            An array is neither float64 nor float32, or both occur.

        Examples
        --------
        >>> robot, q, v, a = rd.example("two_r"), [0.3, 1.2], [1.0, -2.0], [3.0, 4.0]
        >>> gradient = robot.inverse_dynamics_pullback_with_parameters(q, v, a, [1.0, 0.0])
        >>> bool(np.allclose(gradient.by_parameters[:20], robot.joint_torque_regressor(q, v, a)[0]))
        True
        """
    @overload
    def inverse_dynamics_second_derivatives(self, q: NDArray[_F], v: NDArray[_F], a: NDArray[_F], *, out: tuple[NDArray[_F], NDArray[_F], NDArray[_F], NDArray[_F]] | None = None, threads: int | None = None) -> InverseDynamicsSecondDerivatives[_F]: ...
    @overload
    def inverse_dynamics_second_derivatives(self, q: Numbers, v: Numbers, a: Numbers, *, out: tuple[NDArray[np.float64], NDArray[np.float64], NDArray[np.float64], NDArray[np.float64]] | None = None, threads: int | None = None) -> InverseDynamicsSecondDerivatives[np.float64]:
        """Second derivatives of τ(q, v, a) as tensors with the component of τ first. Those that are not listed
        are zero, and ∂²τ/∂q∂a is ∂M/∂q.

        Parameters
        ----------
        q : array_like, shape (..., nq)
            Configuration.
        v : array_like, shape (..., nv)
            Velocity [rad/s or m/s].
        a : array_like, shape (..., nv)
            Acceleration [rad/s² or m/s²].
        out : tuple of ndarray, optional
            Arrays that receive the results.
        threads : int, optional
            Threads for a batch; default: `num_threads()`.

        Returns
        -------
        InverseDynamicsSecondDerivatives
            `position_position` (..., nv, nv, nv): ∂²τᵢ/∂qⱼ∂qₖ.
            `position_velocity` (..., nv, nv, nv): ∂²τᵢ/∂qⱼ∂vₖ.
            `velocity_velocity` (..., nv, nv, nv): ∂²τᵢ/∂vⱼ∂vₖ.
            `position_acceleration` (..., nv, nv, nv): ∂²τᵢ/∂qⱼ∂aₖ.

        Raises
        ------
        StateError
            The state is invalid; `BadStatesError` for a batch.
        ShapeError
            An array has the wrong shape.
        DTypeError
            An array is neither float64 nor float32, or both occur.

        Examples
        --------
        >>> robot, q, v, a = rd.example("two_r"), [0.3, 1.2], [1.0, -2.0], [3.0, 4.0]
        >>> second = robot.inverse_dynamics_second_derivatives(q, v, a)
        >>> twice = np.einsum("ijk,j,k", second.velocity_velocity, v, v)  # C v is quadratic in v
        >>> bool(np.allclose(twice, 2 * robot.velocity_product(q, v)))
        True
        """
    @overload
    def inverse_mass_matrix(self, q: NDArray[_F], *, out: NDArray[_F] | None = None, threads: int | None = None) -> NDArray[_F]: ...
    @overload
    def inverse_mass_matrix(self, q: Numbers, *, out: NDArray[np.float64] | None = None, threads: int | None = None) -> NDArray[np.float64]:
        """M(q)⁻¹, the inverse of the mass matrix.

        Parameters
        ----------
        q : array_like, shape (..., nq)
            Configuration.
        out : ndarray, shape (..., nv, nv), optional
            Array that receives the result.
        threads : int, optional
            Threads for a batch; default: `num_threads()`.

        Returns
        -------
        ndarray, shape (..., nv, nv)
            Symmetric.

        Raises
        ------
        SingularMassError
            M(q) is singular.
        StateError
            The state is invalid; `BadStatesError` for a batch.
        ShapeError
            An array has the wrong shape.
        DTypeError
            An array is neither float64 nor float32, or both occur.

        Examples
        --------
        >>> robot, q = rd.example("two_r"), [0.3, 1.2]
        >>> bool(np.allclose(robot.inverse_mass_matrix(q) @ robot.mass_matrix(q), np.eye(2)))
        True
        """
    @overload
    def joint_torque_regressor(self, q: NDArray[_F], v: NDArray[_F], a: NDArray[_F], *, out: NDArray[_F] | None = None, threads: int | None = None) -> NDArray[_F]: ...
    @overload
    def joint_torque_regressor(self, q: Numbers, v: Numbers, a: Numbers, *, out: NDArray[np.float64] | None = None, threads: int | None = None) -> NDArray[np.float64]:
        """Y of τ = Y(q, v, a) π, π being the `inertial_parameters`, ten for each link that moves.

        Parameters
        ----------
        q : array_like, shape (..., nq)
            Configuration.
        v : array_like, shape (..., nv)
            Velocity [rad/s or m/s].
        a : array_like, shape (..., nv)
            Acceleration [rad/s² or m/s²].
        out : ndarray, shape (..., nv, 10·moving links), optional
            Array that receives the result.
        threads : int, optional
            Threads for a batch; default: `num_threads()`.

        Returns
        -------
        ndarray, shape (..., nv, 10·moving links)
            Y, ten columns for each moving link.

        Raises
        ------
        StateError
            The state is invalid; `BadStatesError` for a batch.
        ShapeError
            An array has the wrong shape.
        DTypeError
            An array is neither float64 nor float32, or both occur.

        Examples
        --------
        >>> robot, q, v, a = rd.example("two_r"), [0.3, 1.2], [1.0, -2.0], [3.0, 4.0]
        >>> Y = robot.joint_torque_regressor(q, v, a)
        >>> bool(np.allclose(Y @ robot.inertial_parameters, robot.inverse_dynamics(q, v, a)))
        True
        """
    @overload
    def kinetic_energy(self, q: NDArray[_F], v: NDArray[_F], *, out: NDArray[_F] | None = None, threads: int | None = None) -> Any: ...
    @overload
    def kinetic_energy(self, q: Numbers, v: Numbers, *, out: NDArray[np.float64] | None = None, threads: int | None = None) -> Any:
        """K = ½ vᵀM(q) v, the kinetic energy.

        Parameters
        ----------
        q : array_like, shape (..., nq)
            Configuration.
        v : array_like, shape (..., nv)
            Velocity [rad/s or m/s].
        out : ndarray, shape (...), optional
            Array that receives the result.
        threads : int, optional
            Threads for a batch; default: `num_threads()`.

        Returns
        -------
        float or ndarray, shape (...)
            K [J].

        Raises
        ------
        StateError
            The state is invalid; `BadStatesError` for a batch.
        ShapeError
            An array has the wrong shape.
        DTypeError
            An array is neither float64 nor float32, or both occur.

        Examples
        --------
        >>> robot, q, v = rd.example("two_r"), [0.3, 1.2], np.array([1.0, -2.0])
        >>> bool(np.isclose(robot.kinetic_energy(q, v), 0.5 * v @ robot.mass_matrix(q) @ v))
        True
        """
    @overload
    def kinetic_energy_gradient(self, q: NDArray[_F], v: NDArray[_F], *, out: NDArray[_F] | None = None, threads: int | None = None) -> NDArray[_F]: ...
    @overload
    def kinetic_energy_gradient(self, q: Numbers, v: Numbers, *, out: NDArray[np.float64] | None = None, threads: int | None = None) -> NDArray[np.float64]:
        """∂K/∂q at constant v.

        Derivatives by q are those of `inverse_dynamics_derivatives`.

        Parameters
        ----------
        q : array_like, shape (..., nq)
            Configuration.
        v : array_like, shape (..., nv)
            Velocity [rad/s or m/s].
        out : ndarray, shape (..., nv), optional
            Array that receives the result.
        threads : int, optional
            Threads for a batch; default: `num_threads()`.

        Returns
        -------
        ndarray, shape (..., nv)
            ∂K/∂q [N·m or N].

        Raises
        ------
        StateError
            The state is invalid; `BadStatesError` for a batch.
        ShapeError
            An array has the wrong shape.
        DTypeError
            An array is neither float64 nor float32, or both occur.

        Examples
        --------
        >>> robot, q, v = rd.example("two_r"), [0.3, 1.2], [1.0, -2.0]
        >>> float(robot.kinetic_energy_gradient(q, v)[0].round(12))  # nothing depends on where the first rod points
        0.0
        """
    @overload
    def kinetic_energy_regressor(self, q: NDArray[_F], v: NDArray[_F], *, out: NDArray[_F] | None = None, threads: int | None = None) -> NDArray[_F]: ...
    @overload
    def kinetic_energy_regressor(self, q: Numbers, v: Numbers, *, out: NDArray[np.float64] | None = None, threads: int | None = None) -> NDArray[np.float64]:
        """The row y of K = y(q, v) π.

        Parameters
        ----------
        q : array_like, shape (..., nq)
            Configuration.
        v : array_like, shape (..., nv)
            Velocity [rad/s or m/s].
        out : ndarray, shape (..., 10·moving links), optional
            Array that receives the result.
        threads : int, optional
            Threads for a batch; default: `num_threads()`.

        Returns
        -------
        ndarray, shape (..., 10·moving links)
            y, ten numbers for each moving link.

        Raises
        ------
        StateError
            The state is invalid; `BadStatesError` for a batch.
        ShapeError
            An array has the wrong shape.
        DTypeError
            An array is neither float64 nor float32, or both occur.

        Examples
        --------
        >>> robot, q, v = rd.example("two_r"), [0.3, 1.2], [1.0, -2.0]
        >>> y = robot.kinetic_energy_regressor(q, v)
        >>> bool(np.isclose(y @ robot.inertial_parameters, robot.kinetic_energy(q, v)))
        True
        """
    @property
    def mass(self) -> float:
        """The mass [kg] of the links that `center_of_mass` counts: those that move, or all of a robot whose
        moving links have no mass.
        """
    @overload
    def mass_matrix(self, q: NDArray[_F], *, out: NDArray[_F] | None = None, threads: int | None = None) -> NDArray[_F]: ...
    @overload
    def mass_matrix(self, q: Numbers, *, out: NDArray[np.float64] | None = None, threads: int | None = None) -> NDArray[np.float64]:
        """M(q), the mass matrix: K = ½ vᵀM v.

        Parameters
        ----------
        q : array_like, shape (..., nq)
            Configuration.
        out : ndarray, shape (..., nv, nv), optional
            Array that receives the result.
        threads : int, optional
            Threads for a batch; default: `num_threads()`.

        Returns
        -------
        ndarray, shape (..., nv, nv)
            Symmetric [kg·m², kg·m, kg].

        Raises
        ------
        StateError
            The state is invalid; `BadStatesError` for a batch.
        ShapeError
            An array has the wrong shape.
        DTypeError
            An array is neither float64 nor float32, or both occur.

        Examples
        --------
        >>> robot = rd.example("two_r")
        >>> M = robot.mass_matrix([0.3, 1.2])
        >>> bool(np.all(np.linalg.eigvalsh(M) > 0)), bool(np.allclose(M, M.T))
        (True, True)
        """
    @overload
    def mass_matrix_factor(self, q: NDArray[_F], *, out: NDArray[_F] | None = None, threads: int | None = None) -> NDArray[_F]: ...
    @overload
    def mass_matrix_factor(self, q: Numbers, *, out: NDArray[np.float64] | None = None, threads: int | None = None) -> NDArray[np.float64]:
        """The factor of M(q) = LᵀDL: L below the diagonal (its own diagonal is 1), D on the diagonal, zeros
        above it.

        L is zero where M is zero because neither of two degrees of freedom moves the other. The cost of
        solving therefore grows with nv times the depth of the tree. The product of the diagonal is det M.

        Parameters
        ----------
        q : array_like, shape (..., nq)
            Configuration.
        out : ndarray, shape (..., nv, nv), optional
            Array that receives the result.
        threads : int, optional
            Threads for a batch; default: `num_threads()`.

        Returns
        -------
        ndarray, shape (..., nv, nv)
            L below the diagonal, D on it.

        Raises
        ------
        SingularMassError
            M(q) is singular.
        StateError
            The state is invalid; `BadStatesError` for a batch.
        ShapeError
            An array has the wrong shape.
        DTypeError
            An array is neither float64 nor float32, or both occur.

        Examples
        --------
        >>> factor = rd.example("two_r").mass_matrix_factor([0.3, 1.2])
        >>> l, d = np.tril(factor, -1) + np.eye(2), np.diag(factor.diagonal())
        >>> bool(np.allclose(l.T @ d @ l, rd.example("two_r").mass_matrix([0.3, 1.2])))
        True
        """
    @overload
    def mass_matrix_rate(self, q: NDArray[_F], v: NDArray[_F], *, out: NDArray[_F] | None = None, threads: int | None = None) -> NDArray[_F]: ...
    @overload
    def mass_matrix_rate(self, q: Numbers, v: Numbers, *, out: NDArray[np.float64] | None = None, threads: int | None = None) -> NDArray[np.float64]:
        """Ṁ: the rate of M(q) along a motion.

        Parameters
        ----------
        q : array_like, shape (..., nq)
            Configuration.
        v : array_like, shape (..., nv)
            Velocity [rad/s or m/s].
        out : ndarray, shape (..., nv, nv), optional
            Array that receives the result.
        threads : int, optional
            Threads for a batch; default: `num_threads()`.

        Returns
        -------
        ndarray, shape (..., nv, nv)
            Ṁ [kg·m²/s, kg·m/s, kg/s].

        Raises
        ------
        StateError
            The state is invalid; `BadStatesError` for a batch.
        ShapeError
            An array has the wrong shape.
        DTypeError
            An array is neither float64 nor float32, or both occur.

        Examples
        --------
        >>> robot, q, v = rd.example("two_r"), np.array([0.3, 1.2]), np.array([1.0, -2.0])
        >>> ahead, behind = robot.mass_matrix(q + 1e-6 * v), robot.mass_matrix(q - 1e-6 * v)
        >>> bool(np.allclose(robot.mass_matrix_rate(q, v), (ahead - behind) / 2e-6, atol=1e-8))
        True
        """
    @property
    def massless_joints(self) -> list[str]:
        """Joints that move no inertia in any pose. If there are any, accelerations have no value."""
    @overload
    def momentum(self, q: NDArray[_F], v: NDArray[_F], *, out: NDArray[_F] | None = None, threads: int | None = None) -> NDArray[_F]: ...
    @overload
    def momentum(self, q: Numbers, v: Numbers, *, out: NDArray[np.float64] | None = None, threads: int | None = None) -> NDArray[np.float64]:
        """p = M(q) v, the generalized momentum.

        Parameters
        ----------
        q : array_like, shape (..., nq)
            Configuration.
        v : array_like, shape (..., nv)
            Velocity [rad/s or m/s].
        out : ndarray, shape (..., nv), optional
            Array that receives the result.
        threads : int, optional
            Threads for a batch; default: `num_threads()`.

        Returns
        -------
        ndarray, shape (..., nv)
            p [kg·m²/s or kg·m/s].

        Raises
        ------
        StateError
            The state is invalid; `BadStatesError` for a batch.
        ShapeError
            An array has the wrong shape.
        DTypeError
            An array is neither float64 nor float32, or both occur.

        Examples
        --------
        >>> robot, q, v = rd.example("two_r"), [0.3, 1.2], [1.0, -2.0]
        >>> bool(np.allclose(robot.momentum(q, v), robot.mass_matrix(q) @ v))
        True
        """
    @property
    def name(self) -> str:
        """The robot's name."""
    @property
    def native(self) -> str:
        """The code that computes each function called so far, a line each. It is machine code, made when a
        function is first called, or the function's recursion, with the reason.

        With the environment variable `ROBOT_DYNAMICS_NATIVE=0`, set before the start, the recursions compute
        all functions. Results then differ by rounding.

        >>> robot = rd.example("panda")
        >>> tau = robot.gravity(robot.neutral())
        >>> "gravity, f64, one state" in robot.native or "recursions" in robot.native
        True
        """
    def neutral(self) -> NDArray[np.float64]:
        """The configuration in which every coordinate is 0 and every quaternion the identity.

        Returns
        -------
        ndarray, shape (nq,)
            Configuration.

        Examples
        --------

        >>> rd.example("quadruped", floating_base=True).neutral()[:7]
        array([0., 0., 0., 0., 0., 0., 1.])
        """
    @property
    def nq(self) -> int:
        """How many numbers a configuration q has."""
    @property
    def nv(self) -> int:
        """How many numbers a velocity v has: the degrees of freedom."""
    @property
    def parameter_names(self) -> list[str]:
        """The names of the parameters, for example `upper.m`, `shoulder.damping` or `gravity.z`."""
    def parameters(self) -> NDArray[np.float64]:
        """The parameters of the dynamics; `with_parameters` makes a robot with others.

        For each moving link, with the links fixed to it: m, m c (3) and Ixx, Ixy, Iyy, Ixz, Iyz, Izz about
        its origin [kg, kg·m, kg·m²]. For each joint that is not fixed: armature, damping, friction, stiffness
        and rest, all 0 for a floating base. Then gravity (3) [m/s²].

        Returns
        -------
        ndarray, shape (parameters,)
            The parameters, named by `parameter_names`.

        Examples
        --------

        >>> robot = rd.example("two_r")
        >>> len(robot.parameters()), len(robot.parameter_names)
        (33, 33)
        """
    @overload
    def potential_energy(self, q: NDArray[_F], *, out: NDArray[_F] | None = None, threads: int | None = None) -> Any: ...
    @overload
    def potential_energy(self, q: Numbers, *, out: NDArray[np.float64] | None = None, threads: int | None = None) -> Any:
        """V(q), the potential energy of gravity and of the joints' springs; 0 where all masses are at the
        world's origin.

        Parameters
        ----------
        q : array_like, shape (..., nq)
            Configuration.
        out : ndarray, shape (...), optional
            Array that receives the result.
        threads : int, optional
            Threads for a batch; default: `num_threads()`.

        Returns
        -------
        float or ndarray, shape (...)
            V [J].

        Raises
        ------
        StateError
            The state is invalid; `BadStatesError` for a batch.
        ShapeError
            An array has the wrong shape.
        DTypeError
            An array is neither float64 nor float32, or both occur.

        Examples
        --------
        >>> float(rd.example("two_r").potential_energy([np.pi / 2, 0.0]).round(4))  # upright: 9.81 (2 · 0.5 + 1 · 1.5)
        24.525
        """
    @overload
    def potential_energy_regressor(self, q: NDArray[_F], *, out: NDArray[_F] | None = None, threads: int | None = None) -> NDArray[_F]: ...
    @overload
    def potential_energy_regressor(self, q: Numbers, *, out: NDArray[np.float64] | None = None, threads: int | None = None) -> NDArray[np.float64]:
        """The row y of V = y(q) π, gravity's part of the potential energy.

        Parameters
        ----------
        q : array_like, shape (..., nq)
            Configuration.
        out : ndarray, shape (..., 10·moving links), optional
            Array that receives the result.
        threads : int, optional
            Threads for a batch; default: `num_threads()`.

        Returns
        -------
        ndarray, shape (..., 10·moving links)
            y, ten numbers for each moving link.

        Raises
        ------
        StateError
            The state is invalid; `BadStatesError` for a batch.
        ShapeError
            An array has the wrong shape.
        DTypeError
            An array is neither float64 nor float32, or both occur.

        Examples
        --------
        >>> robot, q = rd.example("two_r"), [0.3, 1.2]
        >>> y = robot.potential_energy_regressor(q)
        >>> bool(np.isclose(y @ robot.inertial_parameters, robot.potential_energy(q)))
        True
        """
    def random_configuration(self, size: int | Sequence[int] | None = None, *, seed: int) -> NDArray[np.float64]:
        """Random configurations within the joint limits.

        Without limits they are from −π to π, or −1 m to 1 m; rotations are uniform. The same seed gives the
        same configurations.

        Parameters
        ----------
        size : int or sequence of int, optional
            Leading dimensions of the result; default: one configuration.
        seed : int
            Seed of the random numbers, not negative.

        Returns
        -------
        ndarray, shape (..., nq)
            Configurations.

        Raises
        ------
        TypeError
            `size` or `seed` is not a whole number.
        OverflowError
            `size` or `seed` is negative.

        Examples
        --------

        >>> robot = rd.example("panda")
        >>> q = robot.random_configuration(1000, seed=1)
        >>> q.shape, bool(np.all((robot.limits.lower <= q) & (q <= robot.limits.upper)))
        ((1000, 7), True)
        """
    @property
    def total_mass(self) -> float:
        """The mass of all links [kg], those fixed to the world included."""
    @overload
    def velocity_product(self, q: NDArray[_F], v: NDArray[_F], *, out: NDArray[_F] | None = None, threads: int | None = None) -> NDArray[_F]: ...
    @overload
    def velocity_product(self, q: Numbers, v: Numbers, *, out: NDArray[np.float64] | None = None, threads: int | None = None) -> NDArray[np.float64]:
        """C(q, v) v: centrifugal and Coriolis forces.

        Parameters
        ----------
        q : array_like, shape (..., nq)
            Configuration.
        v : array_like, shape (..., nv)
            Velocity [rad/s or m/s].
        out : ndarray, shape (..., nv), optional
            Array that receives the result.
        threads : int, optional
            Threads for a batch; default: `num_threads()`.

        Returns
        -------
        ndarray, shape (..., nv)
            C(q, v) v [N·m or N].

        Raises
        ------
        StateError
            The state is invalid; `BadStatesError` for a batch.
        ShapeError
            An array has the wrong shape.
        DTypeError
            An array is neither float64 nor float32, or both occur.

        Examples
        --------
        >>> robot = rd.example("two_r")
        >>> robot.velocity_product([0.3, 1.2], [0.0, 0.0])
        array([0., 0.])
        """

@disjoint_base
class Scene:
    """The scene that `robot_dynamics.Scene` builds."""
    def __new__(cls, name: str, gravity: Numbers) -> Self: ...
    def _add(self, robot: Robot, parent: str, pose: Numbers, joint: _JointWords | None, prefix: str) -> list[str]:
        """See `add`. Returns the notes on what the scene does not take."""
    def _add_mesh(self, name: str, path: _Path, scale: _Three, parent: str, pose: Numbers, joint: _JointWords | None, mass: float | None, density: float | None, center_of_mass: Numbers, inertia: Numbers | None, solid: str, friction: float | None) -> None:
        """See `add_mesh`."""
    def _add_object(self, name: str, shape: str, lengths: Sequence[float], parent: str, pose: Numbers, joint: _JointWords | None, mass: float | None, density: float | None, friction: float | None) -> None:
        """See `add_box` and the like."""
    def _description(self) -> str:
        """The scene as one robot: its description as JSON."""

@disjoint_base
class Simulation:
    """The native half of `robot_dynamics.Simulation`."""
    def __new__(cls, robot: Robot, **options: object) -> Self: ...
    def _apply_wrench(self, frame: str | int, force: _Three, moment: _Three, axes: str) -> None:
        """See `apply_wrench`."""
    def _contacts(self) -> list[tuple[str, str, str | None, str, int | None, _Array, _Array, float, _Array, _Array]]:
        """See `contacts`."""
    def _energy_account(self) -> _Record:
        """See `energy_account`."""
    def _reset(self, q: Numbers | None, v: Numbers | None, pose: str | None) -> None:
        """See `reset`."""
    @property
    def acceleration(self) -> NDArray[np.float64]:
        """The mean acceleration of the last step (nv,) [rad/s² or m/s²]."""
    @property
    def activations(self) -> NDArray[np.float64]:
        """The activations of the actuators, and then the states of controllers and motors."""
    @activations.setter
    def activations(self, value: Numbers) -> None: ...
    @property
    def actuator_forces(self) -> NDArray[np.float64]:
        """The force of each actuator before its gear, the mean over the last step [N·m or N]."""
    @property
    def actuator_torques(self) -> NDArray[np.float64]:
        """The generalised forces of all actuators together, the mean over the last step [N·m or N]."""
    @property
    def applied_torques(self) -> NDArray[np.float64]:
        """The torques that acted in the last step, within the effort limits (nv,) [N·m or N]."""
    @property
    def center_of_pressure(self) -> NDArray[np.float64] | None:
        """The point about which the normal forces of the grounds have no moment (3,) [m]; `None` if nothing
        presses on a ground.
        """
    def clear_wrenches(self) -> None:
        """Removes all wrenches."""
    @property
    def constraint_forces(self) -> dict[str, float]:
        """The multiplier of each row of the equalities by its name, the mean over the last step [N or N·m]."""
    @property
    def control_names(self) -> tuple[str, ...]:
        """The names of the actuators that act, in the order of `controls`."""
    @property
    def controls(self) -> NDArray[np.float64]:
        """The controls of the actuators, held until they are set again: an array, or numbers by name."""
    @controls.setter
    def controls(self, value: Numbers | Mapping[str, float]) -> None: ...
    @property
    def dt(self) -> float:
        """Length of a step [s]."""
    @property
    def joint_reactions(self) -> dict[str, NDArray[np.float64]]:
        """The force [N] and moment [N·m] that each joint transmits to its child, by its name, fixed joints
        included. Each is (6,) along the axes of the child's frame and about its origin, as a force-torque
        sensor there reads. Forces of equalities are not counted.
        """
    @property
    def left_out(self) -> tuple[str, ...]:
        """The features that the robot's file states and this simulation leaves out, each with the reason."""
    @property
    def losses(self) -> dict[str, float] | None:
        """The energy [J] that damping, friction, stops, sliding and impacts took; `None` if the method does not
        separate them.
        """
    @property
    def method(self) -> str:
        """The method by which steps are taken."""
    @property
    def q(self) -> NDArray[np.float64]:
        """The configuration (nq,), a copy."""
    @property
    def reason(self) -> str:
        """Why that method was chosen."""
    def restore(self, snapshot: Snapshot) -> None:
        """Restores a snapshot exactly.

        Parameters
        ----------
        snapshot : Snapshot
            Snapshot of this simulation or of a copy of it.

        Raises
        ------
        ValueError
            The snapshot is of another simulation.
        """
    @property
    def robot(self) -> Robot:
        """The robot."""
    def run_for(self, duration: float) -> None:
        """Steps for a time.

        Parameters
        ----------
        duration : float
            Time [s], rounded to whole steps.

        Raises
        ------
        SimulationError
            `duration` is invalid, or a step fails.
        """
    @property
    def sensors(self) -> dict[str, NDArray[np.float64]]:
        """The values of the robot's sensors by name, at the end of the last step."""
    def set_state(self, q: Numbers, v: Numbers) -> None:
        """Continues from (q, v) at the same time, with the same inputs. The energy account starts again.

        Parameters
        ----------
        q : array_like, shape (nq,)
            Configuration.
        v : array_like, shape (nv,)
            Velocity [rad/s or m/s].

        Raises
        ------
        StateError
            `q` or `v` is invalid.
        ShapeError
            An array has the wrong shape.
        SimulationError
            The state violates the constraints, or the simulation cannot start there.
        """
    def snapshot(self) -> Snapshot:
        """Saves all that changes, for `restore`.

        Returns
        -------
        Snapshot
            State, inputs and energy account.
        """
    def step(self, count: int = 1) -> None:
        """Takes steps; an interrupt ends them between two steps.

        Parameters
        ----------
        count : int
            Number of steps.

        Raises
        ------
        SimulationError
            A step fails; the simulation stays at the state before it.
        """
    @property
    def steps(self) -> int:
        """Steps since the last reset."""
    @property
    def steps_at_effort_limits(self) -> list[int]:
        """The number of steps in which each coordinate's torque was cut off at the effort limit."""
    @property
    def time(self) -> float:
        """The time [s]."""
    @property
    def torques(self) -> NDArray[np.float64]:
        """The torques of the next steps (nv,), held until they are set again [N·m or N]."""
    @torques.setter
    def torques(self, value: Numbers) -> None: ...
    @property
    def v(self) -> NDArray[np.float64]:
        """The velocity (nv,), a copy."""

@disjoint_base
class SimulationBatch:
    """The native half of `robot_dynamics.SimulationBatch`."""
    def __len__(self, /) -> int: ...
    def __new__(cls, robot: Robot, count: int, threads: int | None, variants: Sequence[tuple[Robot, object]], **options: object) -> Self: ...
    def _contact_forces(self, names: Sequence[str]) -> _Array:
        """See `contact_forces`."""
    def _copy(self, number: int) -> Simulation:
        """A copy of one simulation, with its state and inputs."""
    def _reset(self, q: Numbers | None, v: Numbers | None, which: Sequence[int] | None) -> None:
        """See `reset`."""
    def _sensors(self) -> _Array:
        """See `sensors`."""
    def _set_gains(self, stiffness: Numbers, damping: Numbers, limits: Numbers, delays: Sequence[int]) -> None:
        """See `set_position_control`."""
    def _set_state(self, q: Numbers, v: Numbers, which: Sequence[int] | None) -> None:
        """See `set_state`."""
    def _set_wrenches(self, frames: Sequence[str], wrenches: Numbers, axes: str) -> None:
        """See `set_wrenches`."""
    def _step(self, count: int, which: Sequence[int] | None) -> None:
        """See `step`."""
    @property
    def acceleration(self) -> NDArray[np.float64]:
        """The mean accelerations of the last step (count, nv) [rad/s² or m/s²]."""
    @property
    def activations(self) -> NDArray[np.float64]:
        """The activations of the actuators of each simulation, and then the states of controllers and motors
        (count, activations); (activations,) sets those of all.
        """
    @activations.setter
    def activations(self, value: Numbers) -> None: ...
    @property
    def applied_torques(self) -> NDArray[np.float64]:
        """The torques that acted in the last step, within the effort limits (count, nv) [N·m or N]."""
    @property
    def control_names(self) -> tuple[str, ...]:
        """The names of the actuators that act, in the order of `controls`."""
    @property
    def controls(self) -> NDArray[np.float64]:
        """The controls of the actuators that act (count, controls), held until they are set again; (controls,)
        sets those of all.
        """
    @controls.setter
    def controls(self, value: Numbers) -> None: ...
    @property
    def dt(self) -> float:
        """Length of a step [s]."""
    @property
    def q(self) -> NDArray[np.float64]:
        """The configurations (count, nq), a copy."""
    @property
    def robot(self) -> Robot:
        """The robot, of the first simulation if they differ."""
    @property
    def targets(self) -> NDArray[np.float64]:
        """The targets of the position control (count, nv), held until they are set again; (nv,) sets those of
        all [rad or m]. See `set_position_control`.
        """
    @targets.setter
    def targets(self, value: Numbers) -> None: ...
    @property
    def times(self) -> list[float]:
        """The times (count,) [s]."""
    @property
    def torques(self) -> NDArray[np.float64]:
        """The torques of the next steps (count, nv), held until they are set again; (nv,) sets those of all [N·m
        or N].
        """
    @torques.setter
    def torques(self, value: Numbers) -> None: ...
    @property
    def v(self) -> NDArray[np.float64]:
        """The velocities (count, nv), a copy."""

@final
class Snapshot:
    """The state of a simulation with all that changes in it, made by `Simulation.snapshot`."""

@final
class TaskControl:
    """Moves a frame along a reference: τ = Jᵀ(Λ (ẍʳ + kp e + kd (ẋʳ − ẋ)) + μ + p) + (1 − JᵀJ̄ᵀ) τ₀.

    In the null space, which leaves the frame at rest, τ₀ = C v + g + M (kr (qʳ ⊖ q) − kn v). Coordinates
    without a motor (`robot.actuated_dofs`), as those of a floating base, have torque 0. The base recoils, and
    the frame follows in spite of it while nothing else touches the robot. The controller is a function of
    (t, q, v); in `simulate` it runs in the library. Near a singular pose Λ is damped. A call raises
    `ControlError` if a chosen direction depends on the others at every pose. A command beyond the effort
    limits is scaled: the frame keeps its direction, and the null space has the rest of the effort.

    Parameters
    ----------
    robot : Robot
        Robot to control.
    frame : str or int
        Name of the frame, or its index in `frame_names`.
    reference : array_like, tuple of three array_like, or function
        Target of the frame in the world: its origin (3,) with free orientation [m], or its pose (4, 4). With
        its velocity and acceleration along the world's axes it is (xʳ, ẋʳ, ẍʳ), for a pose with six numbers
        each. A function of t [s] returns one of these; it is called once at t = 0 to find which.
    stiffness : float
        kp [1/s²].
    damping : float
        kd [1/s]; kd = 2 √kp is critically damped.
    null_damping : float
        kn, damping in the null space [1/s].
    rows : sequence of str, optional
        Controlled directions among x, y, z, rx, ry, rz along the world's axes, for example ("x", "z") for an
        arm in that plane; default: all directions of the reference.
    posture : array_like, shape (nq,), optional
        Configuration qʳ to which the null space is pulled.
    posture_stiffness : float
        kr [1/s²].
    limits : array_like, shape (nv,), optional
        Largest torques [N·m or N]; default: the effort limits of the robot.

    Raises
    ------
    FrameError
        The frame does not exist.
    ShapeError
        The reference or `posture` has the wrong shape.
    StateError
        `posture` is not a configuration.
    ControlError
        A gain is invalid.
    ValueError
        A row is unknown, given twice, or a turn of a reference without orientation; or a limit is negative.

    Examples
    --------

    >>> robot, q = rd.example("panda"), np.array([0.0, 0.3, 0.0, -1.8, 0.0, 2.0, 0.6])
    >>> goal = robot.frame_pose(q, "panda_link8") @ np.block([[np.eye(3), np.full((3, 1), 0.05)], [0.0, 0.0, 0.0, 1.0]])
    >>> lead = rd.TaskControl(robot, "panda_link8", goal, stiffness=100.0, damping=20.0, null_damping=10.0)
    >>> motion = robot.simulate(q, tau=lead, duration=1.5)
    >>> bool(np.allclose(robot.frame_pose(motion.q[-1], "panda_link8"), goal, atol=1e-3))
    True
    """
    def __call__(self, t: float, q: Numbers, v: Numbers) -> NDArray[np.float64]: ...
    def __new__(cls, robot: Robot, frame: str | int, reference: ControlReference | Callable[[float], ControlReference], *, stiffness: float, damping: float, null_damping: float = 0.0, rows: Sequence[str] | None = None, posture: Numbers | None = None, posture_stiffness: float = 0.0, limits: Numbers | None = None) -> Self: ...

@disjoint_base
class WholeBody:
    """The native half of `robot_dynamics.whole_body.WholeBodyControl`."""
    def __call__(self, t: float, q: Numbers, v: Numbers) -> NDArray[np.float64]: ...
    def __new__(cls, robot: Robot, *, dissipation: bool = False) -> Self: ...
    def _add_contact(self, contact: object) -> int:
        """See `add_contact`."""
    def _add_task(self, objective: object, weight: float, level: int) -> int:
        """See `add_task`."""
    def _hold_contact(self, number: int, is_held: bool) -> None:
        """See `hold_contact`."""
    def _limits(self) -> _Record:
        """See `limits`."""
    def _set_limits(self, limits: _Record) -> None:
        """See `set_limits`; `None` keeps a limit."""
    def _set_objective(self, number: int, objective: object) -> None:
        """See `set_objective`."""
    def _set_weight(self, number: int, weight: float) -> None:
        """See `set_weight`."""
    def _solve(self, q: Numbers, v: Numbers) -> _Record:
        """See `solve`."""
    @property
    def robot(self) -> Robot:
        """The robot."""
