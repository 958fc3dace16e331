"""The view of the public names in `help`, signatures and error messages."""

import builtins
import importlib
import inspect
import pickle
from collections.abc import Iterator
from functools import cached_property
from typing import Any

import pytest

import robot_dynamics as rd

LONGEST = 750
"""The limit of a signature as `inspect.signature` prints it [characters]; that of `Robot.simulate` is the
longest."""

LONGEST_TYPE = 90
"""The limit of the type of one argument or result [characters]: an alias is shown by its name."""

MODULES = ("arrow", "casadi", "certified", "gym", "jax", "optimal", "parquet", "ray", "sampling", "torch", "whole_body")


def callables() -> Iterator[tuple[str, Any]]:
    """The public functions, and the public methods of public classes, by qualified name."""
    for name in rd.__all__:
        value = getattr(rd, name)
        if inspect.isclass(value):
            yield from methods(name, value)
        elif callable(value):
            yield name, value


def methods(name: str, cls: type) -> Iterator[tuple[str, Any]]:
    """The public methods of a class, inherited ones included."""
    for member in dir(cls):
        value = inspect.getattr_static(cls, member)
        is_method = inspect.isroutine(value) and not isinstance(value, cached_property)
        if not member.startswith("_") and (is_method or isinstance(value, classmethod | staticmethod)):
            yield f"{name}.{member}", getattr(cls, member)


def of_modules() -> Iterator[tuple[str, Any]]:
    """The public functions and classes of modules whose dependency is installed."""
    for name in MODULES:
        try:
            module = importlib.import_module(f"robot_dynamics.{name}")
        except ImportError:
            continue
        for member, value in vars(module).items():
            if not member.startswith("_") and getattr(value, "__module__", "") == module.__name__ and callable(value):
                yield f"{name}.{member}", value
                if inspect.isclass(value):
                    yield from methods(f"{name}.{member}", value)


def signature(value: Any) -> inspect.Signature | None:
    """The signature, if there is one: C functions and type aliases may lack it."""
    try:
        return inspect.signature(value)
    except (TypeError, ValueError):
        return None


def test_signatures_are_short() -> None:
    seen = 0
    for name, value in [*callables(), *of_modules()]:
        found = signature(value)
        if found is None or not getattr(value, "__module__", "").startswith("robot_dynamics"):
            continue
        seen += 1
        assert len(str(found)) <= LONGEST, f"{name}{found}"
        kinds = [parameter.annotation for parameter in found.parameters.values()] + [found.return_annotation]
        for kind in kinds:
            shown = inspect.formatannotation(kind)
            assert len(shown) <= LONGEST_TYPE and "_native" not in shown, f"{name}: {shown}"
    assert seen > 100


def test_methods_are_named_after_public_classes() -> None:
    public = set(rd.__all__)
    for name, value in callables():
        owner = getattr(value, "__qualname__", name).rpartition(".")[0]
        assert not owner or owner in public or hasattr(builtins, owner), f"{name} is called {value.__qualname__}"


@pytest.mark.parametrize("name", sorted(name for name, _ in methods("Robot", rd.Robot)))
def test_a_wrong_argument_names_the_public_class(name: str) -> None:
    method = getattr(rd.example("two_r"), name.removeprefix("Robot."))
    with pytest.raises(TypeError) as caught:
        method(no_such_argument=1)
    assert str(caught.value).startswith(f"{name}()"), str(caught.value)


def test_a_method_survives_a_pickle() -> None:
    assert pickle.loads(pickle.dumps(rd.Robot.simulate)) is rd.Robot.simulate
    robot = rd.example("two_r")
    assert pickle.loads(pickle.dumps(robot.inverse_kinematics)).__self__ == robot
