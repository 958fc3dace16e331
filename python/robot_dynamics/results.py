"""Results of methods with several arrays, as named tuples."""

from __future__ import annotations

from typing import Any, Generic, NamedTuple, TypeVar

import numpy as np
from numpy.typing import NDArray

_F = TypeVar("_F", np.float64, np.float32)


class InverseDynamicsDerivatives(NamedTuple, Generic[_F]):
    """Derivatives of τ(q, v, a); ∂τ/∂a is the mass matrix."""

    by_position: NDArray[_F]
    """∂τ/∂q (..., nv, nv)."""
    by_velocity: NDArray[_F]
    """∂τ/∂v (..., nv, nv)."""


class ForwardDynamicsDerivatives(NamedTuple, Generic[_F]):
    """Derivatives of a(q, v, τ)."""

    by_position: NDArray[_F]
    """∂a/∂q (..., nv, nv)."""
    by_velocity: NDArray[_F]
    """∂a/∂v (..., nv, nv)."""
    by_force: NDArray[_F]
    """∂a/∂τ = M⁻¹ (..., nv, nv)."""


class InverseDynamicsPullback(NamedTuple, Generic[_F]):
    """Gradient of λᵀτ(q, v, a)."""

    by_position: NDArray[_F]
    """λᵀ ∂τ/∂q (..., nv)."""
    by_velocity: NDArray[_F]
    """λᵀ ∂τ/∂v (..., nv)."""
    by_acceleration: NDArray[_F]
    """λᵀ M (..., nv)."""


class ForwardDynamicsPullback(NamedTuple, Generic[_F]):
    """Gradient of λᵀa(q, v, τ)."""

    by_position: NDArray[_F]
    """λᵀ ∂a/∂q (..., nv)."""
    by_velocity: NDArray[_F]
    """λᵀ ∂a/∂v (..., nv)."""
    by_force: NDArray[_F]
    """λᵀ M⁻¹ (..., nv)."""


class InverseDynamicsPullbackWithParameters(NamedTuple, Generic[_F]):
    """Gradient of λᵀτ(q, v, a), also by the robot's parameters."""

    by_position: NDArray[_F]
    """λᵀ ∂τ/∂q (..., nv)."""
    by_velocity: NDArray[_F]
    """λᵀ ∂τ/∂v (..., nv)."""
    by_acceleration: NDArray[_F]
    """λᵀ M (..., nv)."""
    by_parameters: NDArray[_F]
    """Gradient by `Robot.parameters()` (..., parameters)."""


class ForwardDynamicsPullbackWithParameters(NamedTuple, Generic[_F]):
    """Gradient of λᵀa(q, v, τ), also by the robot's parameters."""

    by_position: NDArray[_F]
    """λᵀ ∂a/∂q (..., nv)."""
    by_velocity: NDArray[_F]
    """λᵀ ∂a/∂v (..., nv)."""
    by_force: NDArray[_F]
    """λᵀ M⁻¹ (..., nv)."""
    by_parameters: NDArray[_F]
    """Gradient by `Robot.parameters()` (..., parameters)."""


class DissipationPullback(NamedTuple, Generic[_F]):
    """Gradient of λᵀb(v), with b the forces of damping and friction."""

    by_velocity: NDArray[_F]
    """λᵀ ∂b/∂v (..., nv)."""
    by_parameters: NDArray[_F]
    """Gradient by `Robot.parameters()` (..., parameters)."""


class FrameAccelerationDerivatives(NamedTuple, Generic[_F]):
    """Derivatives of a frame's acceleration; the derivative by a is the frame's Jacobian."""

    by_position: NDArray[_F]
    """Derivative by q (..., 6, nv)."""
    by_velocity: NDArray[_F]
    """Derivative by v (..., 6, nv)."""


class InverseDynamicsSecondDerivatives(NamedTuple, Generic[_F]):
    """Second derivatives of τ(q, v, a), with the component i of τ first."""

    position_position: NDArray[_F]
    """∂²τᵢ/∂qⱼ∂qₖ (..., nv, nv, nv)."""
    position_velocity: NDArray[_F]
    """∂²τᵢ/∂qⱼ∂vₖ (..., nv, nv, nv)."""
    velocity_velocity: NDArray[_F]
    """∂²τᵢ/∂vⱼ∂vₖ (..., nv, nv, nv)."""
    position_acceleration: NDArray[_F]
    """∂²τᵢ/∂qⱼ∂aₖ = ∂M_ik/∂qⱼ (..., nv, nv, nv)."""


class ForwardDynamicsSecondDerivatives(NamedTuple, Generic[_F]):
    """Second derivatives of a(q, v, τ), with the component i of a first."""

    position_position: NDArray[_F]
    """∂²aᵢ/∂qⱼ∂qₖ (..., nv, nv, nv)."""
    position_velocity: NDArray[_F]
    """∂²aᵢ/∂qⱼ∂vₖ (..., nv, nv, nv)."""
    velocity_velocity: NDArray[_F]
    """∂²aᵢ/∂vⱼ∂vₖ (..., nv, nv, nv)."""
    position_force: NDArray[_F]
    """∂²aᵢ/∂qⱼ∂τₖ = ∂(M⁻¹)ᵢₖ/∂qⱼ (..., nv, nv, nv)."""


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
    "inverse_dynamics_second_derivatives": InverseDynamicsSecondDerivatives,
    "forward_dynamics_second_derivatives": ForwardDynamicsSecondDerivatives,
    "frame_acceleration_derivatives": FrameAccelerationDerivatives,
}
"""Result class of each method with several results."""
