"""Several results of one call, as named tuples."""

from __future__ import annotations

from typing import Any, Generic, NamedTuple, TypeVar

import numpy as np
from numpy.typing import NDArray

_F = TypeVar("_F", np.float64, np.float32)


class InverseDynamicsDerivatives(NamedTuple, Generic[_F]):
    """The slopes of τ(q, v, a); ∂τ/∂a is the mass matrix."""

    by_position: NDArray[_F]
    """∂τ/∂q (..., nv, nv)."""
    by_velocity: NDArray[_F]
    """∂τ/∂v (..., nv, nv)."""


class ForwardDynamicsDerivatives(NamedTuple, Generic[_F]):
    """The slopes of a(q, v, τ)."""

    by_position: NDArray[_F]
    """∂a/∂q (..., nv, nv)."""
    by_velocity: NDArray[_F]
    """∂a/∂v (..., nv, nv)."""
    by_force: NDArray[_F]
    """∂a/∂τ = M⁻¹ (..., nv, nv)."""


class InverseDynamicsPullback(NamedTuple, Generic[_F]):
    """What λᵀτ(q, v, a) changes by."""

    by_position: NDArray[_F]
    """λᵀ ∂τ/∂q (..., nv)."""
    by_velocity: NDArray[_F]
    """λᵀ ∂τ/∂v (..., nv)."""
    by_acceleration: NDArray[_F]
    """λᵀ M (..., nv)."""


class ForwardDynamicsPullback(NamedTuple, Generic[_F]):
    """What λᵀa(q, v, τ) changes by."""

    by_position: NDArray[_F]
    """λᵀ ∂a/∂q (..., nv)."""
    by_velocity: NDArray[_F]
    """λᵀ ∂a/∂v (..., nv)."""
    by_force: NDArray[_F]
    """λᵀ M⁻¹ (..., nv)."""


class InverseDynamicsPullbackWithParameters(NamedTuple, Generic[_F]):
    """What λᵀτ(q, v, a) changes by, for a robot whose parameters change, too."""

    by_position: NDArray[_F]
    """λᵀ ∂τ/∂q (..., nv)."""
    by_velocity: NDArray[_F]
    """λᵀ ∂τ/∂v (..., nv)."""
    by_acceleration: NDArray[_F]
    """λᵀ M (..., nv)."""
    by_parameters: NDArray[_F]
    """By `Robot.parameters()` (..., parameters)."""


class ForwardDynamicsPullbackWithParameters(NamedTuple, Generic[_F]):
    """What λᵀa(q, v, τ) changes by, for a robot whose parameters change, too."""

    by_position: NDArray[_F]
    """λᵀ ∂a/∂q (..., nv)."""
    by_velocity: NDArray[_F]
    """λᵀ ∂a/∂v (..., nv)."""
    by_force: NDArray[_F]
    """λᵀ M⁻¹ (..., nv)."""
    by_parameters: NDArray[_F]
    """By `Robot.parameters()` (..., parameters)."""


class DissipationPullback(NamedTuple, Generic[_F]):
    """What λᵀb(v) changes by."""

    by_velocity: NDArray[_F]
    """λᵀ ∂b/∂v (..., nv)."""
    by_parameters: NDArray[_F]
    """By `Robot.parameters()` (..., parameters)."""


class FrameAccelerationDerivatives(NamedTuple, Generic[_F]):
    """The slopes of a frame's acceleration; by a it is the frame's Jacobian."""

    by_position: NDArray[_F]
    """By q (..., 6, nv)."""
    by_velocity: NDArray[_F]
    """By v (..., 6, nv)."""


BY_ALGORITHM: dict[str, Any] = {
    "inverse_dynamics_derivatives": InverseDynamicsDerivatives,
    "forward_dynamics_derivatives": ForwardDynamicsDerivatives,
    "inverse_dynamics_pullback": InverseDynamicsPullback,
    "forward_dynamics_pullback": ForwardDynamicsPullback,
    "inverse_dynamics_pullback_with_parameters": InverseDynamicsPullbackWithParameters,
    "forward_dynamics_pullback_with_parameters": ForwardDynamicsPullbackWithParameters,
    "dissipation_pullback": DissipationPullback,
    "inverse_dynamics_derivatives_with_wrenches": InverseDynamicsDerivatives,
    "forward_dynamics_derivatives_with_wrenches": ForwardDynamicsDerivatives,
    "frame_acceleration_derivatives_in_frame": FrameAccelerationDerivatives,
    "frame_acceleration_derivatives_world_aligned": FrameAccelerationDerivatives,
}
"""The class of each algorithm with several results."""
