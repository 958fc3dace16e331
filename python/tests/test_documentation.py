"""The examples of the docstrings are correct."""

import ast
import doctest
import importlib
import inspect
import pkgutil
import re
import sys
from collections.abc import Iterator
from pathlib import Path
from typing import Any

import numpy as np
import pytest
from test_interface import callables, of_modules, signature

import robot_dynamics as rd
from robot_dynamics.results import BY_ALGORITHM

MODULES = ["robot_dynamics", *(f"robot_dynamics.{found.name}" for found in pkgutil.iter_modules(rd.__path__))]


@pytest.mark.parametrize("name", MODULES)
def test_examples(name: str) -> None:
    if name.endswith("__main__"):
        pytest.skip("the command")
    if name.endswith((".ray", ".ray_environments")):
        pytest.importorskip("ray")
    if name.endswith(".gym"):
        pytest.importorskip("gymnasium")
    if name.endswith(".torch_env"):
        pytest.importorskip("torch")
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
            assert "ndarray, shape" in value.__doc__ or name in BY_ALGORITHM, f"{name}: state the shapes"


NEVER_FAIL = {
    "Robot.audit",
    "Robot.base_parameters",
    "Robot.normalize",
    "arrow.Computation.bad_rows_error",
    "parquet.Job.file",
    "parquet.Job.is_finished",
    "parquet.by_threads",
    *(f"gym.{env}.{name}" for env in ("RobotEnv", "SwingUp", "Reach") for name in ("controls", "reward", "start", "targets", "torques")),
}
"""Functions with arguments that raise no error of their own."""

MADE_BY_METHODS = {"Constraints"}
"""Classes of the native half that users do not construct."""


def documented() -> Iterator[tuple[str, Any]]:
    """The public functions, methods, and classes written in Rust that users construct, by qualified name."""
    for name, value in [*callables(), *of_modules()]:
        if not inspect.isclass(value) and is_of_package(value) and not is_override(value):
            yield name, value
    for name in rd.__all__:
        value = getattr(rd, name)
        is_native = inspect.isclass(value) and value.__module__ == "robot_dynamics._native"
        if is_native and value.__text_signature__ and name not in MADE_BY_METHODS:
            yield name, value


def is_of_package(value: Any) -> bool:
    """Whether a function or method was written for this package."""
    owner = getattr(value, "__objclass__", value)
    return (getattr(owner, "__module__", None) or "").startswith("robot_dynamics") and signature(value) is not None


def is_override(value: Any) -> bool:
    """Whether a base class of this package states the sections of a method."""
    owner, _, member = value.__qualname__.rpartition(".")
    cls = getattr(sys.modules.get(getattr(value, "__module__", None) or ""), owner, None)
    bases = cls.__mro__[1:] if inspect.isclass(cls) else ()
    return any(member in vars(base) for base in bases if base.__module__.startswith("robot_dynamics"))


def sections(doc: str) -> dict[str, str]:
    """The text of each section of a docstring, by its heading."""
    parts = re.split(r"^(\w[\w ]*)\n-+\n", inspect.cleandoc(doc), flags=re.MULTILINE)
    return dict(zip(parts[1::2], parts[2::2], strict=True))


def documented_parameters(section: str) -> list[str]:
    """The names of a section Parameters, in its order."""
    lines = [line.split(" : ")[0] for line in section.splitlines() if line and not line.startswith(" ")]
    return [name.lstrip("*") for line in lines for name in line.split(", ")]


def functions_without_result() -> set[str]:
    """The functions written in Rust that return nothing, by qualified name."""
    tree = ast.parse((Path(rd._native.__file__).parent / "_native.pyi").read_text(encoding="utf-8"))
    owned = [("", tree.body), *((f"{node.name}.", node.body) for node in tree.body if isinstance(node, ast.ClassDef))]
    functions = [(f"{owner}{node.name}", node) for owner, body in owned for node in body if isinstance(node, ast.FunctionDef)]
    return {name for name, node in functions if isinstance(node.returns, ast.Constant) and node.returns.value is None}


RETURN_NOTHING = functions_without_result()


def returns_something(name: str, value: Any, found: inspect.Signature) -> bool:
    if inspect.isclass(value):
        return False
    if inspect.isfunction(value) or inspect.ismethod(value):
        return found.return_annotation not in (None, "None")
    return value.__qualname__ not in RETURN_NOTHING


def test_functions_of_both_languages_are_documented() -> None:
    names = [name for name, _ in documented()]
    assert {"Robot.simulate", "Robot.mass_matrix", "JointMap", "Simulation.step", "set_num_threads"} <= set(names)
    assert len(names) > 150


@pytest.mark.parametrize(("name", "value"), [pytest.param(*each, id=each[0]) for each in documented()])
def test_docstring_has_the_sections_of_its_signature(name: str, value: Any) -> None:
    found = signature(value)
    assert found is not None
    own = sections(value.__doc__ or "")
    parameters = [parameter for parameter in found.parameters if parameter not in ("self", "robot", "cls")]
    assert [each for each in documented_parameters(own.get("Parameters", "")) if each != "robot"] == parameters
    assert ("Returns" in own or "Yields" in own) == returns_something(name, value, found)
    assert not parameters or "Raises" in own or name in NEVER_FAIL, "state the errors"
