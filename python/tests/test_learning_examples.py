"""The examples that learn: they do, from their seeds."""

import importlib.util
from pathlib import Path
from typing import Any

import numpy as np
import pytest

pytest.importorskip("gymnasium")


def example(name: str) -> Any:
    """A script of the folder as a module."""
    path = Path(__file__).parents[1] / "examples" / f"{name}.py"
    spec = importlib.util.spec_from_file_location(name, path)
    assert spec is not None and spec.loader is not None
    module = importlib.util.module_from_spec(spec)
    spec.loader.exec_module(module)
    return module


def test_an_evolution_strategy_swings_up() -> None:
    _, learned = example("learn_swing_up").learn(40, seed=4)
    # Hanging is worth −π², leaning −7.5; the swing itself, of some three seconds, costs about −3 over these six.
    assert learned[-1] > -4.0 and learned[-1] > learned[0] + 3.0


def test_the_gradient_of_a_rollout_swings_up() -> None:
    torques, least, loss = example("differentiate_swing_up").swing_up(120, starts=4)
    assert np.abs(torques).max() <= 2.0
    # Hanging costs 2, standing upright at rest 0.
    assert least[0] > 0.5 and loss.min() < 0.02 and (np.diff(least[::20]) < 0).all()
