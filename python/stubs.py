"""Write `robot_dynamics/_native.pyi` from the compiled module: signatures, types and docstrings.

    python stubs.py           writes the file
    python stubs.py --check   fails if the file is not current

The module itself lists the arguments of a method. The types follow from the names of arguments and from the
shapes in the docstrings.
"""

import inspect
import sys
import textwrap
from collections.abc import Iterator
from pathlib import Path
from typing import Any

from robot_dynamics import _native, results

STUB = Path(__file__).parent / "robot_dynamics" / "_native.pyi"

HEAD = '''\
"""The native half of `robot_dynamics`; use that package. Written by `stubs.py`."""

from collections.abc import Callable, Mapping, Sequence
from typing import Any, Self, TypeVar, final, overload

import numpy as np
from numpy.typing import NDArray
from typing_extensions import disjoint_base

from robot_dynamics.numbers import ControlReference, Numbers, ReferenceFrame
from robot_dynamics.results import {classes}

_F = TypeVar("_F", np.float64, np.float32)
'''

# Types of arguments by name; all others are arrays of numbers.
ARGUMENTS = {
    "frame": "str | int",
    "frames": "Sequence[str | int] | None",
    "reference_frame": "ReferenceFrame",
    "threads": "int | None",
    "seed": "int",
    "size": "int | Sequence[int] | None",
    "name": "str",
    "kind": "str",
    "source": "str",
    "path": "Any",
    "text": "str",
    "keeps_lines": "bool",
    "floating_base": "bool",
    "strict": "bool",
    "repair_inertia": "bool",
    "value": "object",
    "full": "Robot",
    "reduced": "Robot",
    "robot": "Robot",
    "fields": "Sequence[tuple[str, str, list[str], list[float], list[str]]]",
    "reference": "Numbers | None",
    "state": "Sequence[Numbers]",
    "t": "float",
    "gravity_at": "str",
    "limits": "Numbers | None",
    "rounds": "int",
    "joints": "int",
    "null_damping": "float",
    "rows": "Sequence[str] | None",
    "posture": "Numbers | None",
    "posture_stiffness": "float",
    "dissipation": "bool",
    "count": "int",
    "duration": "float",
    "snapshot": "Snapshot",
    "number": "int",
    "options": "Any",
}

# Types of arguments that differ for some classes.
OF_CLASS = {
    ("ComputedTorque", "reference"): "ControlReference | Callable[[float], ControlReference]",
    ("TaskControl", "reference"): "ControlReference | Callable[[float], ControlReference]",
    ("TaskControl", "stiffness"): "float",
    ("TaskControl", "damping"): "float",
}

# Results that are not arrays of the arguments' type.
RETURNS = {
    "_state": "str",
    "_report_text": "str",
    "_warning_groups": "list[str]",
    "_left_out": "list[str]",
    "_disabled_collisions": "list[tuple[str, str]]",
    "_copy": "Simulation",
    "_joints": "list[Any]",
    "_links": "list[tuple[str, int, int | None, float, list[float], list[list[float]]]]",
    "neutral": "NDArray[np.float64]",
    "random_configuration": "NDArray[np.float64]",
    "example_text": "str",
    "num_threads": "int",
    "set_num_threads": "None",
    "quantities": "list[tuple[str, list[str], int]]",
    "dlqr": "dict[str, Any]",
    "_nanoseconds": "float",
    "values": "NDArray[np.float64]",
    "nearest_parameters": "NDArray[np.float64]",
    "parameters": "NDArray[np.float64]",
    "_xla_handle": "int",
    "_defaults": "dict[str, Any]",
    "_xla_handlers": "dict[str, Any]",
    "_random_robot": "str",
    "_write_text": "None",
    "_visible": "str",
    "_html": "str",
    "expand_configuration": "NDArray[np.float64]",
    "expand_velocity": "NDArray[np.float64]",
    "restrict_configuration": "NDArray[np.float64]",
    "restrict_velocity": "NDArray[np.float64]",
    "clear_wrenches": "None",
    "set_state": "None",
    "step": "None",
    "run_for": "None",
    "snapshot": "Snapshot",
    "restore": "None",
}

# Properties of classes that this script does not create. Those of a robot are inspected.
PROPERTIES = {
    "row_names": "list[str]",
    "names": "list[str]",
    "invisible": "list[str]",
    "combinations": "NDArray[np.float64]",
    "q_indices": "list[int]",
    "v_indices": "list[int]",
    "locked_joints": "list[str]",
}


ARRAY = "NDArray[np.float64]"

# Properties of simulations that are not arrays.
OF_SIMULATION = {
    "robot": "Robot",
    "dt": "float",
    "method": "str",
    "reason": "str",
    "left_out": "tuple[str, ...]",
    "time": "float",
    "steps": "int",
    "steps_at_effort_limits": "list[int]",
    "control_names": "tuple[str, ...]",
    "center_of_pressure": "NDArray[np.float64] | None",
    "constraint_forces": "dict[str, float]",
    "joint_reactions": "dict[str, NDArray[np.float64]]",
    "sensors": "dict[str, NDArray[np.float64]]",
    "losses": "Any",
    "times": "list[float]",
}

# Base classes of classes of the Python package.
BASES = ("Robot", "Simulation", "SimulationBatch")

# Writable attributes with their types.
SETTERS = {
    ("Simulation", "controls"): "Numbers | Mapping[str, float]",
    ("Simulation", "torques"): "Numbers",
    ("SimulationBatch", "controls"): "Numbers",
    ("SimulationBatch", "torques"): "Numbers",
}


def main() -> int:
    text = stub()
    if "--check" in sys.argv[1:]:
        is_current = STUB.exists() and STUB.read_text(encoding="utf-8") == text
        print(f"{STUB.name}: {'ok' if is_current else 'not current: run `python stubs.py`'}")
        return 0 if is_current else 1
    STUB.write_text(text, encoding="utf-8")
    return 0


def stub() -> str:
    classes = sorted({cls.__name__ for cls in results.BY_ALGORITHM.values()})
    parts = [HEAD.format(classes=", ".join(classes))]
    parts.append(f"\n__all__ = {sorted(_native.__all__)}\n\n__version__: str\n")
    parts += [f"\n{''.join(function(name))}" for name, value in sorted(vars(_native).items()) if is_routine(value)]
    for name, value in sorted(vars(_native).items()):
        if isinstance(value, type):
            parts.append("\n" + "".join(of_class(name, value)))
    return "".join(parts)


def is_routine(value: object) -> bool:
    return inspect.isbuiltin(value)


def of_class(name: str, cls: type) -> Iterator[str]:
    yield f"@{'disjoint_base' if name in BASES else 'final'}\nclass {name}:\n"
    yield quoted(cls.__doc__, 1)
    for member, value in sorted(vars(cls).items()):
        if inspect.isgetsetdescriptor(value):
            is_simulation = name.startswith("Simulation")
            kind = OF_SIMULATION.get(member, ARRAY) if is_simulation else property_type(member)
            yield f"    @property\n    def {member}(self) -> {kind}:\n{quoted(value.__doc__, 2)}"
            if (name, member) in SETTERS:
                yield f"    @{member}.setter\n    def {member}(self, value: {SETTERS[name, member]}) -> None: ...\n"
        elif member == "__new__":
            yield f"    def __new__(cls, {arguments(cls, 0)}) -> Self: ...\n"
        elif member in ("__eq__", "__ne__"):
            yield f"    def {member}(self, value: object, /) -> bool: ...\n"
        elif member in ("__hash__", "__len__"):
            yield f"    def {member}(self, /) -> int: ...\n"
        elif member == "__call__":
            # Python does not report its arguments. It is a controller τ(t, q, v).
            yield "    def __call__(self, t: float, q: Numbers, v: Numbers) -> NDArray[np.float64]: ...\n"
        elif inspect.ismethoddescriptor(value) and not member.startswith("__"):
            yield "".join(method(member, value))


def property_type(name: str) -> str:
    if name in PROPERTIES:
        return PROPERTIES[name]
    robot = _native.Robot("text", _native.example_text("two_r"))
    value = getattr(robot, name)
    if isinstance(value, list):
        return "list[str]"
    if isinstance(value, tuple):
        return f"tuple[{', '.join(type(entry).__name__ for entry in value)}]"
    return "NDArray[np.float64]" if hasattr(value, "dtype") else type(value).__name__


def function(name: str) -> Iterator[str]:
    value = getattr(_native, name)
    yield f"def {name}({arguments(value, 0)}) -> {RETURNS[name]}:\n{quoted(value.__doc__, 1)}"


def method(name: str, value: object) -> Iterator[str]:
    if name.startswith("_") and name not in RETURNS:
        # The Python package states their types.
        yield f"    def {name}({arguments(value, 0, 'Any')}) -> Any:\n{quoted(value.__doc__, 2)}"
        return
    if name in RETURNS:
        given = arguments(value, 0)
        yield f"    def {name}({given}) -> {RETURNS[name]}:\n{quoted(value.__doc__, 2)}"
        return
    for number in ("_F", "np.float64"):
        given = arguments(value, 0, number)
        result = returned(name, value.__doc__ or "", number)
        yield f"    @overload\n    def {name}({given}) -> {result}:{' ...' if number == '_F' else ''}\n"
        if number != "_F":
            yield quoted(value.__doc__, 2)


def arguments(value: Any, skip: int, number: str | None = None) -> str:
    parameters = list(inspect.signature(value).parameters.values())[skip:]
    written, has_star = [], False
    for k, parameter in enumerate(parameters):
        if parameter.name == "self":
            written.append("self")
            continue
        if parameter.kind is parameter.VAR_KEYWORD:
            written.append(f"**{parameter.name}: Any")
            continue
        if parameter.kind is parameter.KEYWORD_ONLY and not has_star:
            written.append("*")
            has_star = True
        default = "" if parameter.default is parameter.empty else f" = {parameter.default!r}"
        written.append(f"{parameter.name}: {argument(parameter.name, number, value)}{default}")
        if parameter.kind is parameter.POSITIONAL_ONLY and (
            k + 1 == len(parameters) or parameters[k + 1].kind is not parameter.POSITIONAL_ONLY
        ):
            written.append("/")
    return ", ".join(written)


def argument(name: str, number: str | None, value: Any) -> str:
    if number == "Any":
        return "Any"
    if name == "out":
        array = f"NDArray[{number}]"
        several = results.BY_ALGORITHM.get(value.__name__)
        return f"tuple[{', '.join([array] * len(several._fields))}] | None" if several else f"{array} | None"
    if (value.__name__, name) in OF_CLASS:
        return OF_CLASS[value.__name__, name]
    if name in ARGUMENTS:
        return ARGUMENTS[name]
    return "NDArray[_F]" if number == "_F" and name != "s" else "Numbers"


def returned(name: str, doc: str, number: str) -> str:
    if name in results.BY_ALGORITHM:
        return f"{results.BY_ALGORITHM[name].__name__}[{number}]"
    # A scalar result is a number for one state and an array for many.
    return "Any" if "\nfloat or ndarray, shape (...)\n" in doc else f"NDArray[{number}]"


def quoted(doc: str | None, depth: int) -> str:
    indent = "    " * depth
    if not doc:
        return f"{indent}...\n"
    lines = f'"""{doc.rstrip()}'.splitlines()
    lines = [*lines, '"""'] if len(lines) > 1 else [lines[0] + '"""']
    return textwrap.indent("\n".join(lines), indent).replace("\\", "\\\\") + "\n"


if __name__ == "__main__":
    sys.exit(main())
