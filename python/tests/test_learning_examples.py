"""The examples that learn succeed from their seeds."""

import importlib.util
from pathlib import Path
from typing import Any

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
    # Hanging scores −π², and leaning −7.5. The swing takes about three of the six seconds and scores about
    # −3.
    assert learned[-1] > -4.0 and learned[-1] > learned[0] + 3.0
