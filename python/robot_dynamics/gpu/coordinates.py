"""Gradients by the nq numbers of a configuration, and along displacements with nv numbers, as tensors.

A function of q depends on the direction of each quaternion only. Its displacement is u = Rᵀẋ for the position
of a floating joint, and w = 2 (q* ⊗ q̇)/|q|² for a quaternion.
"""

from __future__ import annotations

from typing import TYPE_CHECKING, Any

from robot_dynamics.coordinate_ranges import coordinate_ranges

if TYPE_CHECKING:
    from robot_dynamics.robot import Robot


def gradient_by_coordinates(robot: Robot, q: Any, gradient: Any) -> Any:
    """Gradient by the numbers of q, from that along displacements.

    Parameters
    ----------
    robot : Robot
        Robot.
    q : torch.Tensor, shape (..., nq)
        Configuration.
    gradient : torch.Tensor, shape (..., nv)
        Gradient along displacements.

    Returns
    -------
    torch.Tensor, shape (..., nq)
        Gradient by the numbers of q.
    """
    if robot.nq == robot.nv:
        return gradient
    import torch

    parts = []
    for entry in coordinate_ranges(robot):
        own, given = q[..., entry.q], gradient[..., entry.v]
        if not entry.has_quaternion:
            parts.append(given)
            continue
        vector, scalar, turn = own[..., -4:-1], own[..., -1:], given[..., -3:]
        if own.shape[-1] > 4:
            parts.append(_rotated(vector, scalar, given[..., :3]))
        by_vector = scalar * turn + torch.linalg.cross(vector, turn)
        by_scalar = -(vector * turn).sum(dim=-1, keepdim=True)
        squared = own[..., -4:].square().sum(dim=-1, keepdim=True)
        parts.append(2.0 * torch.cat([by_vector, by_scalar], dim=-1) / squared)
    return torch.cat(parts, dim=-1)


def gradient_by_displacement(robot: Robot, q: Any, gradient: Any) -> Any:
    """Gradient along displacements, from that by the numbers of q.

    Parameters
    ----------
    robot : Robot
        Robot.
    q : torch.Tensor, shape (..., nq)
        Configuration, with quaternions of unit length.
    gradient : torch.Tensor, shape (..., nq)
        Gradient by the numbers of q.

    Returns
    -------
    torch.Tensor, shape (..., nv)
        Gradient along displacements.
    """
    if robot.nq == robot.nv:
        return gradient
    import torch

    parts = []
    for entry in coordinate_ranges(robot):
        own, given = q[..., entry.q], gradient[..., entry.q]
        if not entry.has_quaternion:
            parts.append(given)
            continue
        vector, scalar = own[..., -4:-1], own[..., -1:]
        by_vector, by_scalar = given[..., -4:-1], given[..., -1:]
        if own.shape[-1] > 4:
            parts.append(_rotated(-vector, scalar, given[..., :3]))
        parts.append(0.5 * (scalar * by_vector - torch.linalg.cross(vector, by_vector) - by_scalar * vector))
    return torch.cat(parts, dim=-1)


def _rotated(vector: Any, scalar: Any, x: Any) -> Any:
    """R x for the rotation R of a quaternion, with |q| divided out."""
    import torch

    across = torch.linalg.cross(vector, x)
    squared = vector.square().sum(dim=-1, keepdim=True) + scalar.square()
    return x + 2.0 * (scalar * across + torch.linalg.cross(vector, across)) / squared
