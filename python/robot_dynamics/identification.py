"""Identification of inertial parameters from recorded motion: τ = Y(q, v, a) π.

Torques depend on linear combinations β of π only. Joints add damping, friction, armature and offsets.
"""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from dataclasses import dataclass, field
from typing import TYPE_CHECKING, Any, NamedTuple, TypeAlias

import numpy as np
from numpy.typing import NDArray

from robot_dynamics._native import BaseParameters
from robot_dynamics.numbers import Numbers

if TYPE_CHECKING:
    from robot_dynamics.robot import Robot

Array: TypeAlias = NDArray[np.float64]


@dataclass(frozen=True)
class IdentificationResult:
    """Result of an identification."""

    values: Array
    """Identified combinations β."""
    standard_deviations: Array
    """Standard deviations of β, from the residual."""
    residual: float
    """Root mean square of (τ − W β)/σ with the stated noise σ; without it, of τ − W β [N·m or N]."""
    condition: float
    """Condition number of the columns scaled to unit length.

    Far above 100, the motion excites the parameters too little.
    """
    base: BaseParameters = field(repr=False)
    """Combinations that β stands for."""
    covariance: Array = field(repr=False)
    """Covariance of β."""
    residuals: Array = field(repr=False)
    """Root mean square of τ − W β of each coordinate (nv,) [N·m or N]; NaN if it is not measured."""
    weakest: tuple[tuple[str, float], ...] = field(repr=False)
    """Direction that the data determine worst: names of combinations and their parts."""


@dataclass(frozen=True)
class ConsistentEstimate:
    """Parameters that belong to bodies, near nominal ones."""

    parameters: Array
    """Inertial parameters π, then the joint terms."""
    names: tuple[str, ...] = field(repr=False)
    """Names of the parameters."""
    standard_deviations: Array = field(repr=False)
    """Standard deviations of the parameters due to the noise."""
    covariance: Array = field(repr=False)
    """Covariance of the parameters due to the noise."""
    residual: float
    """Root mean square of (τ − W x)/σ with the stated noise σ; without it, of τ − W x [N·m or N]."""
    residuals: Array
    """Root mean square of τ − W x of each coordinate (nv,) [N·m or N]; NaN if it is not measured."""
    divergences: Array = field(repr=False)
    """Entropic divergence of each moving link from its nominal parameters."""
    effective_parameters: float
    """Number of parameters that the data determine."""
    robot: Robot = field(repr=False)
    """Robot with these parameters."""


class LinkConsistency(NamedTuple):
    """Physical consistency of the inertial parameters of a link."""

    link: str
    """Name of the link."""
    mass: float
    """Mass [kg]."""
    smallest: float
    """Smallest eigenvalue of the pseudo-inertia, which is positive for a rigid body."""
    largest: float
    """Largest eigenvalue of the pseudo-inertia."""
    is_consistent: bool
    """Whether a rigid body with these parameters exists, up to rounding."""


@dataclass(frozen=True)
class NonlinearEstimate:
    """Consistent parameters with Stribeck velocities and the direction of gravity."""

    linear: ConsistentEstimate
    """Linear parameters; its robot has the identified gravity."""
    stribeck_velocities: Array
    """Stribeck velocities of the joints of one degree of freedom [rad/s or m/s]."""
    gravity: Array
    """Acceleration of gravity in the world (3,) [m/s²]."""
    standard_deviations: Array = field(repr=False)
    """Standard deviations of ln of the Stribeck velocities, then of two angles of gravity [rad]."""
    steps: int
    """Number of outer steps."""


def base_parameters(
    robot: Robot, *, states: int = 200, seed: int = 1, terms: Sequence[str] = ()
) -> BaseParameters:
    """Find the combinations β of the inertial parameters π that torques depend on, from random states.

    Parameters
    ----------
    states : int
        Number of random states.
    seed : int
        Seed of the random states.
    terms : sequence of str
        Joint terms that are identified as well; see `identify`.

    Returns
    -------
    BaseParameters
        Combinations β.

    Raises
    ------
    IdentificationError
        A joint term is unknown.

    Examples
    --------
    >>> len(rd.example("two_r").base_parameters())
    6
    """
    base: BaseParameters = robot._base_parameters(states, seed, list(terms))
    return base


def _setup(
    dissipation: bool,
    terms: Sequence[str],
    noise: Numbers | None,
    wrenches: Mapping[str, Numbers] | None,
) -> tuple[bool, list[str], Numbers | None, list[tuple[str, Numbers]]]:
    return dissipation, list(terms), noise, list((wrenches or {}).items())


def identify(
    robot: Robot,
    q: Numbers,
    v: Numbers,
    a: Numbers,
    tau: Numbers,
    base: BaseParameters | None = None,
    *,
    dissipation: bool = True,
    terms: Sequence[str] = (),
    noise: Numbers | None = None,
    wrenches: Mapping[str, Numbers] | None = None,
) -> IdentificationResult:
    """Identify β from recorded motion by weighted least squares.

    Parameters
    ----------
    q : array_like, shape (n, nq)
        Recorded configurations.
    v : array_like, shape (n, nv)
        Recorded velocities [rad/s or m/s].
    a : array_like, shape (n, nv)
        Recorded accelerations [rad/s² or m/s²].
    tau : array_like, shape (n, nv)
        Recorded torques [N·m or N].
    base : BaseParameters, optional
        Combinations to identify; default: those that this motion excites.
    dissipation : bool
        Whether `tau` contains the joints' damping and friction as described, like the torques of
        `simulate`. The torques of `inverse_dynamics` do not.
    terms : sequence of str
        Joint terms that are identified as well: "damping", "friction", "armature" and "offset" of all joints
        of one degree of freedom, or of one joint, for example "elbow.friction". The others are taken from
        the robot.
    noise : array_like, shape (nv,), optional
        Standard deviation of each torque [N·m or N]; infinite for a coordinate without a sensor.
    wrenches : mapping of str to array_like, shape (n, 6), optional
        Recorded external forces [N] and moments [N·m] on frames, at their origins and along their axes.

    Returns
    -------
    IdentificationResult
        β with its standard deviations.

    Raises
    ------
    IdentificationError
        The motion has too few or invalid samples, `base` belongs to another robot, or a term is unknown.
    ShapeError
        An array has the wrong shape.

    Examples
    --------
    >>> robot, random = rd.example("two_r"), np.random.default_rng(1)
    >>> q, v, a = random.uniform(-1, 1, (3, 100, 2))
    >>> found = robot.identify(q, v, a, robot.inverse_dynamics(q, v, a))
    >>> bool(np.allclose(found.values, found.base.values(robot.inertial_parameters)))
    True
    """
    found = robot._identify((q, v, a, tau), _setup(dissipation, terms, noise, wrenches), base)
    return IdentificationResult(**found | {"weakest": tuple(found["weakest"])})


def identify_consistent(
    robot: Robot,
    q: Numbers,
    v: Numbers,
    a: Numbers,
    tau: Numbers,
    *,
    regularization: float = 1.0,
    dissipation: bool = True,
    terms: Sequence[str] = (),
    noise: Numbers | None = None,
    wrenches: Mapping[str, Numbers] | None = None,
    hold: Sequence[str] = (),
    nominal: Numbers | None = None,
    joint_nominals: Mapping[str, float] | None = None,
    offset_deviation: float = 1.0,
    least_radius: float = 0.0,
) -> ConsistentEstimate:
    """Identify parameters of possible bodies, near nominal ones.

    It minimises ½ |(W x − τ)/σ|² + γ Σ D(x ‖ x₀), with the entropic divergence D of each link.
    Damping, friction and armature stay positive.

    Parameters
    ----------
    q : array_like, shape (n, nq)
        Recorded configurations.
    v : array_like, shape (n, nv)
        Recorded velocities [rad/s or m/s].
    a : array_like, shape (n, nv)
        Recorded accelerations [rad/s² or m/s²].
    tau : array_like, shape (n, nv)
        Recorded torques [N·m or N].
    regularization : float
        Weight γ of the divergence. Recorded data fit no model exactly; with a small weight, hidden
        combinations then move far from their nominal values.
    dissipation : bool
        As of `identify`.
    terms : sequence of str
        As of `identify`.
    noise : array_like, shape (nv,), optional
        As of `identify`.
    wrenches : mapping of str to array_like, shape (n, 6), optional
        As of `identify`.
    hold : sequence of str
        Names of links that keep their nominal parameters.
    nominal : array_like, shape (10 · moving links + terms,), optional
        Nominal parameters x₀; default: those of the robot.
    joint_nominals : mapping of str to float, optional
        Nominal values of joint terms, for example {"friction": 0.5}; needed where the robot has 0.
    offset_deviation : float
        Plausible distance of offsets from their nominal values [N·m or N].
    least_radius : float
        Least radius of gyration of nominal bodies [m], for thin rods and points.

    Returns
    -------
    ConsistentEstimate
        Parameters with standard deviations, and the robot that has them.

    Raises
    ------
    IdentificationError
        A sample or an option is invalid, or a nominal body is flat.
    ShapeError
        An array has the wrong shape.

    Examples
    --------
    >>> robot, random = rd.example("panda"), np.random.default_rng(1)
    >>> q, v, a = random.uniform(-1, 1, (3, 100, 7))
    >>> tau = 1.1 * robot.inverse_dynamics(q, v, a) + random.normal(0.0, 0.1, (100, 7))
    >>> found = robot.identify_consistent(q, v, a, tau, noise=np.full(7, 0.1), dissipation=False)
    >>> all(link.is_consistent for link in robot.physical_consistency(found.parameters))
    True
    >>> bool(1.0 < found.robot.mass / robot.mass < 1.2)
    True
    """
    found: dict[str, Any] = robot._identify_consistent(
        (q, v, a, tau),
        _setup(dissipation, terms, noise, wrenches),
        (regularization, offset_deviation, least_radius),
        (list(hold), nominal, list((joint_nominals or {}).items())),
    )
    return _estimate(robot, found)


def _estimate(robot: Robot, found: dict[str, Any]) -> ConsistentEstimate:
    own = {"robot": robot._edited(found["robot"]), "names": tuple(found["names"])}
    return ConsistentEstimate(**found | own)


def identify_nonlinear(
    robot: Robot,
    q: Numbers,
    v: Numbers,
    a: Numbers,
    tau: Numbers,
    *,
    stribeck_velocities: Numbers | None = None,
    gravity_direction: bool = False,
    max_steps: int = 30,
    regularization: float = 1.0,
    dissipation: bool = True,
    terms: Sequence[str] = (),
    noise: Numbers | None = None,
    wrenches: Mapping[str, Numbers] | None = None,
    hold: Sequence[str] = (),
    nominal: Numbers | None = None,
    joint_nominals: Mapping[str, float] | None = None,
    offset_deviation: float = 1.0,
    least_radius: float = 0.0,
) -> NonlinearEstimate:
    """Identify Stribeck friction or the direction of gravity together with consistent parameters.

    Stribeck friction is F sign v + ΔF sign v exp(−(v/v_s)²) + b v, the terms "friction", "stribeck" and
    "damping". The velocities v_s start from the given ones. An outer Gauss–Newton search solves
    `identify_consistent` at every step.

    Parameters
    ----------
    q : array_like, shape (n, nq)
        Recorded configurations.
    v : array_like, shape (n, nv)
        Recorded velocities [rad/s or m/s].
    a : array_like, shape (n, nv)
        Recorded accelerations [rad/s² or m/s²].
    tau : array_like, shape (n, nv)
        Recorded torques [N·m or N].
    stribeck_velocities : array_like, shape (nv,), optional
        Start of the Stribeck velocities v_s [rad/s or m/s]; default: no Stribeck friction.
    gravity_direction : bool
        Whether the direction of gravity is identified, for a base mounted at an unknown tilt.
    max_steps : int
        Most outer steps.
    regularization : float
        As of `identify_consistent`.
    dissipation : bool
        As of `identify`.
    terms : sequence of str
        As of `identify`; the Stribeck terms are added.
    noise : array_like, shape (nv,), optional
        As of `identify`.
    wrenches : mapping of str to array_like, shape (n, 6), optional
        As of `identify`.
    hold : sequence of str
        As of `identify_consistent`.
    nominal : array_like, shape (10 · moving links + terms,), optional
        As of `identify_consistent`.
    joint_nominals : mapping of str to float, optional
        As of `identify_consistent`, also for "stribeck".
    offset_deviation : float
        As of `identify_consistent`.
    least_radius : float
        As of `identify_consistent`.

    Returns
    -------
    NonlinearEstimate
        All parameters.

    Raises
    ------
    IdentificationError
        A sample or an option is invalid, or nothing is nonlinear.
    ShapeError
        An array has the wrong shape.

    Examples
    --------
    >>> robot, random = rd.example("panda"), np.random.default_rng(1)
    >>> q, v, a = random.uniform(-1, 1, (3, 100, 7))
    >>> tau = robot.inverse_dynamics(q, v, a) + np.sign(v) * (0.5 + 0.8 * np.exp(-(v / 0.3) ** 2))
    >>> start = {"friction": 1.0, "stribeck": 1.0}
    >>> found = robot.identify_nonlinear(q, v, a, tau, stribeck_velocities=np.full(7, 0.2), terms=("friction",),
    ...                                  noise=np.full(7, 0.01), joint_nominals=start)
    >>> bool(np.allclose(found.stribeck_velocities, 0.3, rtol=1e-3))
    True
    """
    found: dict[str, Any] = robot._identify_nonlinear(
        (q, v, a, tau),
        _setup(dissipation, terms, noise, wrenches),
        (regularization, offset_deviation, least_radius),
        (list(hold), nominal, list((joint_nominals or {}).items())),
        (stribeck_velocities, gravity_direction, max_steps),
    )
    return NonlinearEstimate(**found | {"linear": _estimate(robot, found["linear"])})


def physical_consistency(robot: Robot, parameters: Numbers) -> tuple[LinkConsistency, ...]:
    """Check for each moving link whether a rigid body with its inertial parameters exists.

    Parameters
    ----------
    parameters : array_like, shape (10 · moving links,)
        Inertial parameters π, in the order of `inertial_parameters`.

    Returns
    -------
    tuple of LinkConsistency
        One for each moving link.

    Raises
    ------
    IdentificationError
        A parameter is not finite.
    ShapeError
        `parameters` has the wrong length.

    Examples
    --------
    >>> robot = rd.example("panda")
    >>> all(link.is_consistent for link in robot.physical_consistency(robot.inertial_parameters))
    True
    """
    return tuple(LinkConsistency(*link) for link in robot._physical_consistency(parameters))
