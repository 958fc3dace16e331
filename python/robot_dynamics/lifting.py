"""Task to grip a box and to lift it; use it as `robot_dynamics.gym.Lift`."""

from __future__ import annotations

from typing import Any

import numpy as np
from numpy.typing import NDArray

from robot_dynamics.loading import example
from robot_dynamics.robot_env import RobotEnv

LOST = 0.1
"""Distance below its start at which the box counts as lost [m]."""


class Lift(RobotEnv):
    """Task to grip a box with two fingers and to hold it at a height.

    The robot is ``rd.example("gripper_and_box")``. Its three actions are the controls of the file's
    actuators: the height of the palm and the positions of both fingers.

    The observation has these entries: positions (times 10) and velocities of the three joints, position of
    the box relative to the palm (times 10), velocity of the box. The last ones are the height that is missing
    (times
    10) and the contacts of both fingers with something.

    The reward of a step is exp(−|height that is missing|/5 cm), plus 0.1 for each finger with contact. It is
    reduced by 0.01 times the squared change of the actions. An episode fails if the box falls from the table.

    Parameters
    ----------
    num_envs : int
        Number of environments.
    offset : float
        Largest distance of the box from the middle of the gripper along x and y at the start [m].
    heights : tuple of float
        Range of the wanted heights above the table [m].
    **options
        Options of `RobotEnv`. Defaults: steps of 2 ms, 10 in a control step, episodes of 200 control steps,
        and the integrator ``mujoco``.
    """

    def __init__(
        self, num_envs: int = 1, *, offset: float = 0.01, heights: tuple[float, float] = (0.1, 0.2), **options: Any
    ) -> None:
        robot = example("gripper_and_box")
        defaults: dict[str, Any] = {"dt": 2e-3, "substeps": 10, "horizon": 200, "integrator": "mujoco"}
        super().__init__(num_envs, robot, observations=15, **(defaults | options))
        joints = {joint.name: joint for joint in robot.joints}
        self._box, self._fingers = joints["box"], ["left_finger", "right_finger"]
        self._hand = [joints[name].q.start for name in ("lift", *self._fingers)]
        self._hand_v = [joints[name].v.start for name in ("lift", *self._fingers)]
        self._rest = self.q[0].copy()
        self.offset, self.heights = offset, heights
        self.wanted = np.zeros(num_envs)
        """Wanted heights of the box above its start [m] (num_envs,)."""
        self.has_contact = np.zeros((num_envs, 2), bool)
        """Contacts of the left and the right finger (num_envs, 2)."""

    @property
    def missing(self) -> NDArray[np.float64]:
        """Wanted height minus the height of the box [m] (num_envs,)."""
        at = self._box.q.start + 2
        missing: NDArray[np.float64] = self._rest[at] + self.wanted - self.q[:, at]
        return missing

    def start(self, mask: NDArray[np.bool_]) -> None:
        """Start with an open gripper above the box."""
        count = int(mask.sum())
        q = np.tile(self._rest, (count, 1))
        at = self._box.q.start
        q[:, at : at + 2] += self.np_random.uniform(-self.offset, self.offset, (count, 2))
        self.q[mask], self.v[mask] = q, 0.0
        self.wanted[mask] = self.np_random.uniform(*self.heights, count)
        self.has_contact[mask] = False

    def measure(self) -> None:
        """Contacts of the fingers."""
        forces = self.simulations.contact_forces(self._fingers)
        self.has_contact = (forces**2).sum(axis=2) > 0.0

    def fail(self) -> NDArray[np.bool_]:
        """Whether the box has fallen from the table."""
        at = self._box.q.start + 2
        failed: NDArray[np.bool_] = self.q[:, at] < self._rest[at] - LOST
        return failed

    def observe(self) -> NDArray[np.float64]:
        """Hand, box relative to the palm, missing height, and contacts."""
        at, turn = self._box.q.start, self._box.v.start
        palm = self.robot.frame_pose(self.q, "palm")[:, :3, 3]
        hand, speed = self.q[:, self._hand], self.v[:, self._hand_v]
        box = self.q[:, at : at + 3] - palm
        return np.concatenate(
            [10.0 * hand, speed, 10.0 * box, self.v[:, turn : turn + 3], 10.0 * self.missing[:, np.newaxis], self.has_contact],
            axis=1,
        )

    def reward(self, actions: NDArray[np.float64]) -> NDArray[np.float64]:
        """Nearness to the height, contacts, and small changes of the actions."""
        changes = ((self.last_actions - self.earlier_actions) ** 2).sum(axis=1)
        rewards: NDArray[np.float64] = np.exp(-np.abs(self.missing) / 0.05) + 0.1 * self.has_contact.sum(axis=1) - 0.01 * changes
        return rewards


__all__ = ["Lift"]
