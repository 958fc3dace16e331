"""Differences between the environments of `robot_dynamics.gym`: parameters, delays and pushes."""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray

from robot_dynamics.ground import AnyGround
from robot_dynamics.robot import Robot
from robot_dynamics.simulation import SimulationBatch

Range = tuple[float, float]
"""Smallest and largest value."""

ONE = (1.0, 1.0)
"""Range of factors that change nothing."""


@dataclass(frozen=True)
class Randomization:
    """Ranges of parameters that differ between environments.

    Friction and masses belong to an environment: `variants` robots and grounds are made, and environment k
    has variant k modulo their number. The values are spread evenly over the ranges. All other values are
    drawn at the start of each episode, uniformly.
    """

    friction: Range | None = None
    """Friction coefficients μ of the ground; default: those of the ground."""
    mass: Range = ONE
    """Factors of the mass and inertia of `link`."""
    link: str | None = None
    """Link of which the mass differs; default: all links."""
    variants: int = 16
    """Number of robots and grounds, if friction or masses differ."""
    strength: Range = ONE
    """Factors of the motors' torques."""
    stiffness: Range = ONE
    """Factors of the stiffness of position control."""
    damping: Range = ONE
    """Factors of the damping of position control."""
    delay: tuple[int, int] = (0, 0)
    """Smallest and largest number of simulation steps after which new targets of position control act; at
    most one control step."""


@dataclass(frozen=True)
class Pushes:
    """Wrenches on a link at random times, in random directions."""

    link: str
    """Name of the link."""
    force: float = 0.0
    """Largest force along each axis of the world [N]."""
    moment: float = 0.0
    """Largest moment about each axis of the world [N·m]."""
    interval: Range = (4.0, 8.0)
    """Shortest and longest time between the starts of two pushes [s]."""
    duration: float = 0.2
    """Length of a push [s], rounded to control steps."""


def variants(robot: Robot, ground: AnyGround | None, randomization: Randomization) -> list[tuple[Robot, AnyGround | None]]:
    """Robots and grounds of the variants.

    Parameters
    ----------
    robot : Robot
        Robot.
    ground : Ground, HeightField or "file", optional
        Ground of all variants.
    randomization : Randomization
        Ranges.

    Returns
    -------
    list of (Robot, Ground or HeightField or "file" or None)
        Variants; empty if neither friction nor masses differ.

    Raises
    ------
    ValueError
        Friction shall differ without a ground.
    """
    count = randomization.variants
    if count < 1:
        raise ValueError(f"variants is {count}; it must be at least 1")
    if randomization.friction is None and randomization.mass == ONE:
        return []
    grounds, robots = [ground] * count, [robot] * count
    at = (np.arange(count) + 0.5) / count
    if randomization.friction is not None:
        if ground is None or isinstance(ground, str):
            raise ValueError("friction can differ between environments only with a Ground or a HeightField")
        least, most = randomization.friction
        grounds = [ground._replace(friction=float(least + (most - least) * x)) for x in at]
    if randomization.mass != ONE:
        least, most = randomization.mass
        # In another order than friction, by the golden ratio.
        order = np.argsort((np.arange(count) * 0.6180339887498949) % 1.0)
        robots = [robot.with_mass_scaled(float(least + (most - least) * at[k]), randomization.link) for k in order]
    return list(zip(robots, grounds, strict=True))


class EpisodeFactors:
    """Values that each environment draws at the start of an episode.

    Parameters
    ----------
    count : int
        Number of environments.
    randomization : Randomization, optional
        Ranges; default: all factors are 1.
    most_delay : int
        Largest delay [simulation steps].

    Raises
    ------
    ValueError
        The delay is longer.
    """

    def __init__(self, count: int, randomization: Randomization | None, most_delay: int) -> None:
        self._ranges = Randomization() if randomization is None else randomization
        self.strength, self.stiffness, self.damping = np.ones((3, count, 1))
        self.delay = np.zeros(count, np.int64)
        least, most = self._ranges.delay
        if not 0 <= least <= most <= most_delay:
            raise ValueError(
                f"delay is {self._ranges.delay}; it must be a range within 0 and {most_delay}, the steps of a control step"
                " under position control"
            )
        self._differs = (self._ranges.strength, self._ranges.stiffness, self._ranges.damping) != (ONE, ONE, ONE) or most > 0
        self._is_new = True

    def draw(self, mask: NDArray[np.bool_], random: np.random.Generator) -> bool:
        """Draw the values of episodes that start.

        Parameters
        ----------
        mask : ndarray of bool, shape (count,)
            Environments whose episode starts.
        random : numpy.random.Generator
            Random numbers.

        Returns
        -------
        bool
            Whether a value may have changed.
        """
        is_new, self._is_new = self._is_new, False
        if not self._differs:
            return is_new
        count = int(mask.sum())
        for factors, ends in (
            (self.strength, self._ranges.strength),
            (self.stiffness, self._ranges.stiffness),
            (self.damping, self._ranges.damping),
        ):
            factors[mask, 0] = random.uniform(*ends, count)
        least, most = self._ranges.delay
        self.delay[mask] = random.integers(least, most + 1, count)
        return True


class PushSchedule:
    """Times and wrenches of the pushes of all environments.

    Parameters
    ----------
    pushes : Pushes
        Ranges.
    count : int
        Number of environments.
    period : float
        Length of a control step [s].
    """

    def __init__(self, pushes: Pushes, count: int, period: float) -> None:
        self._pushes, self._period = pushes, period
        self._most = np.array([pushes.force] * 3 + [pushes.moment] * 3)
        self._length = max(1, round(pushes.duration / period))
        self._until = np.zeros(count, np.int64)
        self._left = np.zeros(count, np.int64)
        self.wrenches = np.zeros((count, 6))
        """Force [N] and moment [N·m] on the link in the next control step (count, 6)."""

    def restart(self, mask: NDArray[np.bool_], random: np.random.Generator) -> None:
        """Begin episodes without a push.

        Parameters
        ----------
        mask : ndarray of bool, shape (count,)
            Environments whose episode starts.
        random : numpy.random.Generator
            Random numbers.
        """
        self._left[mask], self.wrenches[mask] = 0, 0.0
        self._until[mask] = self._waits(int(mask.sum()), random)

    def advance(self, simulations: SimulationBatch, random: np.random.Generator) -> None:
        """Set the wrenches of the next control step.

        Parameters
        ----------
        simulations : SimulationBatch
            Simulations of the environments.
        random : numpy.random.Generator
            Random numbers.
        """
        self._until -= 1
        self._left -= 1
        begins = self._until <= 0
        count = int(begins.sum())
        if count > 0:
            self.wrenches[begins] = random.uniform(-1.0, 1.0, (count, 6)) * self._most
            self._left[begins] = self._length
            self._until[begins] = self._waits(count, random)
        self.wrenches[self._left <= 0] = 0.0
        simulations.set_wrenches({self._pushes.link: self.wrenches})

    def _waits(self, count: int, random: np.random.Generator) -> NDArray[np.int64]:
        waits: NDArray[np.int64] = np.maximum(1, np.rint(random.uniform(*self._pushes.interval, count) / self._period)).astype(np.int64)
        return waits


__all__ = ["EpisodeFactors", "PushSchedule", "Pushes", "Randomization", "variants"]
