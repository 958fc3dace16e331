"""The examples of the docstrings are correct."""

import doctest
import importlib
import pkgutil
from pathlib import Path

import numpy as np
import pytest

import robot_dynamics as rd

MODULES = ["robot_dynamics", *(f"robot_dynamics.{found.name}" for found in pkgutil.iter_modules(rd.__path__))]


@pytest.mark.parametrize("name", MODULES)
def test_examples(name: str) -> None:
    if name.endswith("__main__"):
        pytest.skip("the command")
    if name.endswith(".ray"):
        pytest.importorskip("ray")
    if name.endswith(".gym"):
        pytest.importorskip("gymnasium")
    module = importlib.import_module(name)
    failed, _ = doctest.testmod(module, globs={"rd": rd, "np": np}, optionflags=doctest.NORMALIZE_WHITESPACE)
    assert failed == 0


def test_the_readme() -> None:
    readme = Path(__file__).parents[1] / "README.md"
    failed, tried = doctest.testfile(str(readme), module_relative=False, encoding="utf-8")
    assert failed == 0 and tried >= 8


def test_every_public_name_has_a_docstring_and_each_computing_method_an_example() -> None:
    assert rd.__version__.count(".") == 2
    for name in rd.__all__:
        assert getattr(rd, name).__doc__, name
    for name, value in vars(rd._native.Robot).items():
        if name.startswith("_"):
            continue
        assert value.__doc__, name
        if callable(value):
            assert ">>>" in value.__doc__, name
            assert "→" in value.__doc__ or name in ("neutral", "random_configuration"), f"{name}: state the shapes"
