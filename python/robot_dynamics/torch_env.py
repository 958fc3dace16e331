"""Environments with tensors of PyTorch in and out; see `robot_dynamics.gym.RobotEnv.torch`."""

from __future__ import annotations

from typing import TYPE_CHECKING, Any, TypeAlias

import numpy as np

if TYPE_CHECKING:
    from robot_dynamics.robot_env import RobotEnv

Tensor: TypeAlias = Any
"""Tensor of PyTorch, which is not imported before it is used."""


class TorchEnv:
    """Environments whose observations, actions and rewards are tensors.

    Observations and rewards have 32 bits. On the CPU they share the memory of the environments' results, and
    actions are read without a copy.

    Parameters
    ----------
    envs : RobotEnv
        Environments.
    device : str or torch.device
        Device of the tensors.

    Attributes
    ----------
    observations : int
        Number of entries of an observation.
    actions : int
        Number of entries of an action.

    Examples
    --------
    >>> import torch
    >>> from robot_dynamics.gym import SwingUp
    >>> envs = SwingUp(4).torch()
    >>> observations = envs.reset(seed=1)
    >>> observations, rewards, terminated, truncated = envs.step(torch.zeros(4, 1))
    >>> observations.shape, rewards.dtype
    (torch.Size([4, 3]), torch.float32)
    """

    def __init__(self, envs: RobotEnv, device: Any = "cpu") -> None:
        import torch

        self.envs, self.device = envs, torch.device(device)
        self.num_envs: int = envs.num_envs
        self.observations, self.actions = envs.sizes

    def _tensor(self, array: Any) -> Tensor:
        import torch

        tensor: Tensor = torch.from_numpy(array).to(self.device)
        return tensor

    def reset(self, seed: int | None = None) -> Tensor:
        """Start an episode in every environment.

        Parameters
        ----------
        seed : int, optional
            Seed of all random numbers.

        Returns
        -------
        Tensor, shape (num_envs, observations)
            Observations.
        """
        return self._tensor(self.envs.reset(seed=seed)[0])

    def step(self, actions: Tensor) -> tuple[Tensor, Tensor, Tensor, Tensor]:
        """Take one control step in every environment; see `RobotEnv.step`.

        Parameters
        ----------
        actions : Tensor, shape (num_envs, actions)
            Actions.

        Returns
        -------
        observations : Tensor, shape (num_envs, observations)
            Observations.
        rewards : Tensor, shape (num_envs,)
            Rewards.
        terminated : Tensor of bool, shape (num_envs,)
            Whether an episode ended with failure.
        truncated : Tensor of bool, shape (num_envs,)
            Whether an episode ended without failure.
        """
        seen, rewards, terminated, truncated, _ = self.envs.step(actions.detach().cpu().numpy())
        return self._tensor(seen), self._tensor(rewards.astype(np.float32)), self._tensor(terminated), self._tensor(truncated)


__all__ = ["TorchEnv"]
