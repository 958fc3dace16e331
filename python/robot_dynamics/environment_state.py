"""All numbers of environments that change, as bytes, to continue elsewhere with the same bits."""

from __future__ import annotations

import pickle
import sys
from typing import TYPE_CHECKING, Any, NamedTuple

import numpy as np
from numpy.typing import NDArray

from robot_dynamics.errors import BadSimulationsError
from robot_dynamics.randomization import EpisodeFactors, PushSchedule

if TYPE_CHECKING:
    from robot_dynamics.simulation import SimulationBatch

FORMAT = 1
"""Number of the format of checkpoints."""

_PLAIN = (type(None), bool, int, float, str, bytes, np.ndarray, np.generic, np.random.Generator, EpisodeFactors, PushSchedule)
"""Types of attributes that a checkpoint has. Others, such as the robot, are made by the constructor."""


class _Tensor(NamedTuple):
    """Numbers of a tensor of PyTorch."""

    numbers: NDArray[Any]


class _TorchRandom(NamedTuple):
    """State of a generator of PyTorch."""

    state: NDArray[np.uint8]


class _Other:
    """Stands for a value that a checkpoint does not have."""


def save(owner: Any, tables: dict[str, Any] | None = None) -> bytes:
    """Checkpoint of an object.

    Parameters
    ----------
    owner : object
        Environments. Attributes that are numbers, arrays, tensors, texts, generators of random numbers, or
        lists and dictionaries of these are kept.
    tables : dict, optional
        Other values to keep.

    Returns
    -------
    bytes
        Checkpoint.
    """
    found = {name: _plain(value) for name, value in vars(owner).items()}
    kept = {name: value for name, value in found.items() if not isinstance(value, _Other)}
    return pickle.dumps({"format": FORMAT, "of": _identity(owner), "attributes": kept, "tables": tables or {}})


def load(owner: Any, checkpoint: bytes) -> dict[str, Any]:
    """Set the attributes that `save` kept.

    Parameters
    ----------
    owner : object
        Environments that were made like those of the checkpoint.
    checkpoint : bytes
        Checkpoint. It is a pickle, which can run code: load only checkpoints of your own.

    Returns
    -------
    dict
        The other values.

    Raises
    ------
    ValueError
        The checkpoint is of environments that were made differently, or of another format.
    """
    saved = pickle.loads(checkpoint)
    if not isinstance(saved, dict) or saved.get("format") != FORMAT:
        raise ValueError(f"this is not a checkpoint of format {FORMAT}")
    if saved["of"] != _identity(owner):
        raise ValueError(f"the checkpoint is of {saved['of']}, not of {_identity(owner)}")
    for name, value in saved["attributes"].items():
        if isinstance(value, _TorchRandom):
            getattr(owner, name).set_state(sys.modules["torch"].from_numpy(value.state))
        else:
            setattr(owner, name, _revived(value, getattr(owner, "device", None)))
    tables: dict[str, Any] = saved["tables"]
    return tables


def restart(simulations: SimulationBatch, may_fail: NDArray[np.bool_]) -> dict[str, NDArray[np.float64]]:
    """Start the steppers of simulations anew from their states, and return these.

    Parameters
    ----------
    simulations : SimulationBatch
        Simulations.
    may_fail : ndarray of bool, shape (simulations,)
        Simulations that may have an invalid state, because they restart before their next step.

    Returns
    -------
    dict of str to ndarray
        States and inputs.
    """
    tables: dict[str, NDArray[np.float64]] = {name: getattr(simulations, name) for name in ("q", "v", *_INPUTS)}
    _set_states(simulations, tables, may_fail)
    return tables


def resume(simulations: SimulationBatch, tables: dict[str, NDArray[np.float64]], may_fail: NDArray[np.bool_]) -> None:
    """Set states and inputs that `restart` returned.

    Parameters
    ----------
    simulations : SimulationBatch
        Simulations.
    tables : dict of str to ndarray
        States and inputs.
    may_fail : ndarray of bool, shape (simulations,)
        Simulations that may have an invalid state.
    """
    _set_states(simulations, tables, may_fail)
    for name in _INPUTS:
        setattr(simulations, name, tables[name])


_INPUTS = ("torques", "controls", "targets", "activations")
"""Inputs that simulations hold, and the states of their actuators."""


def _set_states(simulations: SimulationBatch, tables: dict[str, NDArray[np.float64]], may_fail: NDArray[np.bool_]) -> None:
    try:
        simulations.set_state(tables["q"], tables["v"])
    except BadSimulationsError as error:
        if not may_fail[list(error.errors)].all():
            raise


def _identity(owner: Any) -> str:
    robot = owner.robot
    return f"{owner.num_envs} environments {type(owner).__qualname__} of robot `{robot.name}` (nq = {robot.nq}, nv = {robot.nv})"


def _plain(value: Any) -> Any:
    """The value as a checkpoint has it."""
    torch = sys.modules.get("torch")
    if torch is not None and isinstance(value, torch.Tensor):
        return _Tensor(value.detach().cpu().numpy())
    if torch is not None and isinstance(value, torch.Generator):
        return _TorchRandom(value.get_state().numpy())
    if isinstance(value, _PLAIN):
        return value
    if type(value) not in (list, tuple, dict):
        return _Other()
    parts = [_plain(part) for part in (value.values() if isinstance(value, dict) else value)]
    if any(isinstance(part, (_Other, _TorchRandom)) for part in parts):
        return _Other()
    return dict(zip(value, parts, strict=True)) if isinstance(value, dict) else type(value)(parts)


def _revived(value: Any, device: Any) -> Any:
    """The value as the environments have it."""
    if isinstance(value, _Tensor):
        return sys.modules["torch"].as_tensor(value.numbers, device=device)
    if isinstance(value, dict):
        return {name: _revived(part, device) for name, part in value.items()}
    if type(value) in (list, tuple):
        return type(value)(_revived(part, device) for part in value)
    return value


__all__ = ["FORMAT", "load", "restart", "resume", "save"]
