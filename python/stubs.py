"""Write `robot_dynamics/_native.pyi` from the compiled module: signatures, types and docstrings.

    python stubs.py           writes the file
    python stubs.py --check   fails if the file is not current

The module itself lists the arguments of a method. The types follow from the names of arguments and from the
tables below; those without an entry are arrays of numbers.
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
from os import PathLike
from pathlib import Path
from typing import Any, Self, TypeAlias, TypeVar, final, overload

import numpy as np
from numpy.typing import NDArray
from typing_extensions import disjoint_base

from robot_dynamics.numbers import ControlReference, Numbers, ReferenceFrame
from robot_dynamics.results import {classes}

_F = TypeVar("_F", np.float64, np.float32)

_Array: TypeAlias = NDArray[np.float64]
_Path: TypeAlias = str | PathLike[str]
_Three: TypeAlias = Sequence[float]
# Kind, axis, second axis and pitch of a joint.
_JointWords: TypeAlias = tuple[str, _Three, _Three, float]
# The fields of a class of the Python half, which states their types.
_Record: TypeAlias = dict[str, Any]
# States and controls by node.
_Rows: TypeAlias = tuple[Sequence[object] | None, Sequence[object] | None]
# Arrays of numpy, or addresses of a device and counts of numbers.
_Memory: TypeAlias = Sequence[object]
# Names and shapes of tables.
_Tables: TypeAlias = list[tuple[str, list[int]]]
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
    "srdf": "str | None",
    "path": "_Path",
    "folder": "_Path | None",
    "text": "str",
    "keeps_lines": "bool",
    "floating_base": "bool",
    "strict": "bool",
    "repair_inertia": "bool",
    "package_path": "Sequence[str] | None",
    "assets": "Sequence[tuple[str, bytes]] | None",
    "confined": "bool",
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
    "constraints": "Constraints",
    "actuated": "Sequence[bool] | None",
    "stabilization": "float | None",
    "restitution": "float",
    "tolerance": "float",
    "force_weight": "float",
    "base": "BaseParameters | None",
    "arrays": "tuple[Numbers, Numbers, Numbers, Numbers]",
    "setup": "tuple[bool, list[str], Numbers | None, list[tuple[str, Numbers]]]",
    "noise": "Numbers",
    "forgetting": "float",
    "prior": "tuple[Numbers, Numbers] | None",
    "convention": "str",
    "back": "bool",
    "names": "Sequence[str]",
    "states": "int",
    "single": "bool",
    "fused": "bool",
    "platform_sine": "bool",
    "lanes": "bool",
    "functions": "Sequence[str]",
    "position_tolerance": "float",
    "angle_tolerance": "float",
    "max_iterations": "int",
    "max_restarts": "int",
    "controls": "dict[str, float] | None",
    "each_step": "bool",
    "steps": "int",
    "stride": "int",
    "spacing": "int",
    "time": "float",
    "actuator_forces": "Numbers | None",
    "joint_limit_forces": "Numbers | None",
    "tendon_limit_forces": "Numbers | None",
    "sample_period": "float | str | None",
    "events": "Sequence[tuple[str, Callable[[float, _Array, _Array], float], int, bool]]",
    "stop_at_limits": "bool",
    "supports": "Sequence[tuple[str, _Three, _Three, float]]",
    "torque": "Numbers | None",
    "velocity": "Numbers | None",
    "lower": "Numbers | None",
    "upper": "Numbers | None",
    "intervals": "int | None",
    "speeds": "tuple[float, float]",
    "period": "float",
    "both_ends": "bool",
    "samples": "int",
    "format": "str",
    "factor": "float",
    "as_written": "bool",
    "link": "str",
    "mass": "float",
    "inertia": "Numbers | None",
    "sensors": "Sequence[tuple[str, str, str | None, str | None]]",
    "row": "str",
    "which": "Sequence[int] | None",
    "variants": "Sequence[tuple[Robot, object]]",
    "delays": "Sequence[int]",
    "pose": "str | None",
    "axes": "str",
    "force": "_Three",
    "moment": "_Three",
    "start": "Numbers | None",
    "trajectory": "tuple[Numbers, Numbers] | None",
    "parent": "str",
    "prefix": "str",
    "shape": "str",
    "lengths": "Sequence[float]",
    "dynamics": "object",
    "initial_state": "object",
    "nodes": "int",
    "first": "int",
    "end": "int",
    "terms": "Sequence[object]",
    "residual": "object",
    "options": "_Record",
    "constraint_tolerance": "float",
    "callback": "Callable[[tuple[Any, ...]], object] | None",
    "problem": "OptimalProblem",
    "iterations": "int",
    "time_budget": "float | None",
    "contact": "object",
    "objective": "object",
    "weight": "float",
    "level": "int",
    "is_held": "bool",
    "objectives": "Sequence[tuple[object, ...]]",
    "law": "tuple[float, int, float, float]",
    "search": "tuple[float, float, int, int, int]",
    "task": "int",
    "position_gain": "float",
    "least_distance": "float",
    "range": "float",
    "gain": "float",
    "dt": "float",
    "starts": "Sequence[Numbers]",
    "ordinal": "int",
    "compiler": "_Path | None",
    "inputs": "_Memory",
    "outputs": "_Memory",
    "held": "_Memory",
    "stream": "int",
    "columns": "bool",
    "cells": "int",
    "max_boxes": "int",
    "payload": "tuple[str | int, tuple[float, float], list[tuple[float, float]], float] | None",
    "robots": (
        "tuple[Sequence[tuple[str | None, tuple[float, float]]], tuple[float, float], "
        "Sequence[tuple[float, float]] | None]"
    ),
    "search_limits": "tuple[float, int]",
}

# Types of arguments that differ for some methods, and for the constructors of some classes.
OF_CALL = {
    ("_certify_digits", "a"): "Numbers | None",
    ("_certify_digits", "tau"): "Numbers | None",
    ("_certify_digits", "v"): "Numbers | None",
    ("_certify_torques", "motion"): "PolynomialMotion",
    ("_add_constraint", "lower"): "object",
    ("_add_constraint", "upper"): "object",
    ("_add_terminal_constraint", "lower"): "object",
    ("_add_terminal_constraint", "upper"): "object",
    ("_next_controls", "state"): "object",
    ("_set_limits", "limits"): "_Record",
    ("_set_control_bounds", "lower"): "object",
    ("_time_optimal", "limits"): "_Record",
    ("_trajectory_text", "names"): "tuple[Sequence[str], Sequence[str]]",
    ("_trajectory_text", "states"): "Sequence[Numbers]",
    ("_set_control_bounds", "upper"): "object",
    ("JerkLimitedMotion", "velocity"): "Numbers | None",
    ("_put_state", "a"): "Numbers | None",
    ("_put_state", "v"): "Numbers | None",
    ("_put_target", "a"): "Numbers | None",
    ("_put_target", "v"): "Numbers | None",
    ("_follow_target", "a"): "Numbers | None",
    ("_follow_target", "v"): "Numbers | None",
    ("OptimalMpc", "rows"): "_Rows",
    ("_sample", "rows"): "_Rows",
    ("_solve", "rows"): "_Rows",
    ("_add", "joint"): "_JointWords | None",
    ("_find", "start"): "Numbers",
    ("_next_step", "v"): "Numbers | None",
    ("_set_damping", "damping"): "float",
    ("_set_limits", "acceleration"): "Numbers | None",
    ("_add", "pose"): "Numbers",
    ("_add_mesh", "density"): "float | None",
    ("_add_mesh", "friction"): "float | None",
    ("_add_mesh", "joint"): "_JointWords | None",
    ("_add_mesh", "mass"): "float | None",
    ("_add_mesh", "pose"): "Numbers",
    ("_add_mesh", "scale"): "_Three",
    ("_add_mesh", "solid"): "str",
    ("_add_object", "density"): "float | None",
    ("_add_object", "friction"): "float | None",
    ("_add_object", "joint"): "_JointWords | None",
    ("_add_object", "mass"): "float | None",
    ("_add_object", "pose"): "Numbers",
    ("_with_attached", "joint"): "_JointWords | None",
    ("_with_attached", "pose"): "Numbers",
    ("_with_fluid", "density"): "float",
    ("_with_fluid", "viscosity"): "float",
    ("_with_fluid", "wind"): "_Three",
    ("_with_frame", "pose"): "Numbers",
    ("_with_link", "joint"): "_JointWords",
    ("_with_link", "joint_name"): "str",
    ("_with_link", "limits"): "tuple[float, float, float, float]",
    ("_with_link", "mass"): "float | None",
    ("_with_link", "pose"): "Numbers",
    ("_with_mass_scaled", "link"): "str | None",
    ("_with_subtree_replaced", "joint"): "str",
    ("_without_equality", "equality"): "str",
    ("_without_joint", "joint"): "str",
    ("ComputedTorque", "reference"): "ControlReference | Callable[[float], ControlReference]",
    ("Admittance", "inertia"): "Numbers",
    ("GravityCompensatedPd", "implicit_period"): "float | None",
    ("ImpedanceControl", "inertia"): "Numbers | None",
    ("ImpedanceControl", "limits"): "Numbers | None",
    ("ImpedanceControl", "reference"): "ControlReference | Callable[[float], ControlReference]",
    ("ImpedanceControl", "sensor"): "str | int | None",
    ("ImpedanceControl", "wrench"): "Numbers | Callable[[float], Numbers] | None",
    ("Delayed", "delay"): "float",
    ("Delayed", "law"): "Callable[[float, NDArray[np.float64], NDArray[np.float64]], Numbers]",
    ("_with_elastic_joint", "backlash"): "float",
    ("_with_elastic_joint", "damping"): "float",
    ("_with_elastic_joint", "joint"): "str",
    ("_with_elastic_joint", "stiffness"): "float",
    ("_with_motor", "drive"): "tuple[float, float]",
    ("_with_motor", "joint"): "str",
    ("_with_motor", "motor"): "tuple[float, float, float, float, float | None, tuple[float, float, float, float, float] | None, tuple[float, float] | None]",
    ("ImplicitGains", "law"): "Callable[[float, NDArray[np.float64], NDArray[np.float64]], Numbers]",
    ("ImplicitGains", "period"): "float",
    ("MomentumObserver", "thresholds"): "Numbers | None",
    ("step", "reference"): "ControlReference",
    ("TaskControl", "limits"): "Numbers | None",
    ("TaskControl", "reference"): "ControlReference | Callable[[float], ControlReference]",
    ("TaskControl", "stiffness"): "float",
    ("TaskControl", "damping"): "float",
    ("_constrained_forward_dynamics", "tau"): "Numbers | None",
    ("_constrained_forward_dynamics_derivatives", "tau"): "Numbers | None",
    ("_constrained_forward_dynamics_pullback", "acceleration"): "Numbers | None",
    ("_constrained_forward_dynamics_pullback", "multipliers"): "Numbers | None",
    ("_constrained_forward_dynamics_pullback", "tau"): "Numbers | None",
    ("_constrained_inverse_dynamics_pullback", "multipliers"): "Numbers | None",
    ("_constrained_inverse_dynamics_pullback", "tau"): "Numbers | None",
    ("_contact_impulse_pullback", "impulse"): "Numbers | None",
    ("_constraint_rows", "v"): "Numbers | None",
    ("_base_parameters", "terms"): "Sequence[str]",
    ("_design_excitation", "terms"): "Sequence[str]",
    ("_design_excitation", "limits"): "tuple[Numbers | None, Numbers | None, Numbers | None, Numbers | None]",
    ("_design_excitation", "design"): "tuple[float, int, bool, int | None, str, int, int]",
    ("_design_excitation", "noise"): "Numbers | None",
    ("_identify_consistent", "weights"): "tuple[float, float, float]",
    ("_identify_consistent", "nominal"): "tuple[list[str], Numbers | None, list[tuple[str, float]]]",
    ("_identify_nonlinear", "weights"): "tuple[float, float, float]",
    ("_identify_nonlinear", "nominal"): "tuple[list[str], Numbers | None, list[tuple[str, float]]]",
    ("_identify_nonlinear", "search"): "tuple[Numbers | None, bool, int]",
    ("PayloadFilter", "offsets"): "Numbers | None",
    ("_convert", "given"): "Sequence[NDArray[Any] | None]",
    ("_generate", "name"): "str | None",
    ("_generate", "target"): "str",
    ("_linearize_step", "tau"): "Numbers | None",
    ("_lock", "joints"): "Sequence[tuple[str, Sequence[float] | None]]",
    ("_operational_space", "rows"): "Sequence[str]",
    ("_operational_space", "v"): "Numbers | None",
    ("_project", "v"): "Numbers | None",
    ("_rollout", "tau"): "Numbers | None",
    ("_rollout", "states"): "Sequence[_Memory]",
    ("_rollout_pullback", "parameters"): "bool",
    ("_rollout_pullback", "tau"): "Numbers | None",
    ("_sensor_values", "wrenches"): "Sequence[tuple[str | int, _Three, _Three, _Three, _Three]]",
    ("_simulate", "tau"): "Numbers | Callable[[float, _Array, _Array], Numbers] | Delayed | None",
    ("_simulate", "v"): "Numbers | None",
    ("_step", "tau"): "Numbers | None",
    ("_supported_inverse_dynamics", "constraints"): "Constraints | None",
    ("_with_actuated_joints", "joints"): "Sequence[str]",
    ("_with_wrenches", "frames"): "Sequence[str | int]",
    ("_with_wrenches", "out"): "NDArray[Any] | tuple[NDArray[Any], ...] | None",
    ("_set_gains", "limits"): "Numbers",
    ("_set_wrenches", "frames"): "Sequence[str]",
    ("_reset", "q"): "Numbers | None",
    ("_reset", "v"): "Numbers | None",
}

# Results that are not arrays of the arguments' type.
RETURNS = {
    "_compile": "CudaFunctions",
    "_with_elastic_joint": "tuple[str, list[str]]",
    "_with_motor": "str",
    "_state_row": "NDArray[np.float64]",
    "motor_loads": "NDArray[np.float64]",
    "controls": "tuple[NDArray[np.float64], float]",
    "reset": "None",
    "update": "NDArray[np.float64]",
    "_state": "str",
    "_description": "str",
    "_add": "list[str]",
    "_add_contact": "int",
    "_add_task": "int",
    "_hold_contact": "None",
    "_limits": "_Record",
    "_set_limits": "None",
    "_put_state": "None",
    "_put_target": "None",
    "_follow_target": "None",
    "_remaining": "float",
    "_take_step": "bool",
    "_set_objective": "None",
    "_set_weight": "None",
    "_add_mesh": "None",
    "_set_damping": "None",
    "_avoid_collisions": "None",
    "_next_step": "_Record",
    "_find": "_Record",
    "_find_many": "list[tuple[bool, _Record]]",
    "_add_object": "None",
    "_report_text": "str",
    "_warning_groups": "list[str]",
    "_left_out": "list[str]",
    "_disabled_collisions": "list[tuple[str, str]]",
    "_copy": "Simulation",
    "_joints": (
        "list[tuple[tuple[str, int, str], tuple[str, str, int | None], tuple[int, int], tuple[int, int], "
        "tuple[str, float, float] | None, list[float], list[float]]]"
    ),
    "_actuated_dofs": "list[bool]",
    "_audit": "list[tuple[str, str, float, str, float, bool, str]]",
    "_base_parameters": "BaseParameters",
    "_box": "_Array",
    "_certify_digits": "list[tuple[str, _Array, _Array, _Array, float, float]]",
    "_certify_mass_matrix": "_Record",
    "_certify_reach": "ReachableSet",
    "_certify_torques": "_Record",
    "_coefficients": "_Array",
    "_constrained_forward_dynamics": "_Record",
    "_constrained_forward_dynamics_derivatives": "_Record",
    "_constrained_forward_dynamics_pullback": "_Record",
    "_constrained_inverse_dynamics": "_Record",
    "_constrained_inverse_dynamics_derivatives": "_Record",
    "_constrained_inverse_dynamics_pullback": "_Record",
    "_constraint_projections": "tuple[_Array, _Array]",
    "_constraint_rows": "_Record",
    "_contact_impulse": "_Record",
    "_contact_impulse_derivatives": "_Record",
    "_contact_impulse_pullback": "_Record",
    "_convert": "list[_Array | None]",
    "_differentiable_row": "tuple[str, bool]",
    "_durations": "_Array",
    "_effort_limits": "_Array",
    "_farthest": "tuple[float, float, _Array]",
    "_file_read_at": "Path | None",
    "_fluid_force_derivatives": "tuple[_Array, _Array]",
    "_fluid_forces": "_Array",
    "_generate": "list[tuple[str, str]]",
    "_identify": "_Record",
    "_identify_consistent": "_Record",
    "_identify_nonlinear": "_Record",
    "_design_excitation": "_Record",
    "_payload": "_Record",
    "_push": "None",
    "_inverse_kinematics": "_Record",
    "_linearize_step": "tuple[_Array, _Array]",
    "_lock": "str",
    "_lock_massless": "tuple[str, list[str]]",
    "_operational_space": "_Record",
    "_physical_consistency": "list[tuple[str, float, float, float, bool]]",
    "_poses": "list[tuple[str, list[float], list[float]]]",
    "_project": "tuple[_Array, _Array]",
    "_result_shapes": "list[list[int]]",
    "_rollout": "list[NDArray[Any]]",
    "_rollout_pullback": (
        "tuple[tuple[NDArray[Any], NDArray[Any], NDArray[Any] | None, NDArray[Any] | None], "
        "tuple[int, int, int, str | None] | None]"
    ),
    "_sensor_values": "_Array",
    "_sensors": "list[tuple[str, str, int]]",
    "_simulate": "_Record",
    "_supported_inverse_dynamics": "_Record",
    "_suspicions": "list[str]",
    "_time_optimal": "_Record",
    "_trajectory_text": "str",
    "_to_text": "tuple[str, list[tuple[str, str, bool]]]",
    "_with_actuated_joints": "str",
    "_with_attached": "tuple[str, list[str]]",
    "_with_fluid": "str",
    "_with_frame": "str",
    "_with_inertia": "str",
    "_with_link": "str",
    "_with_mass_scaled": "str",
    "_with_root": "tuple[str, list[str]]",
    "_with_subtree_replaced": "tuple[str, list[str]]",
    "_without_equality": "tuple[str, list[str]]",
    "_without_joint": "tuple[str, list[str]]",
    "_with_gravity_scaled": "str",
    "_with_parameters": "str",
    "_with_payload": "str",
    "_with_sensors": "str",
    # Several arrays are a named tuple.
    "_with_wrenches": "Any",
    "_apply_wrench": "None",
    "_contact_forces": "_Array",
    "_set_gains": "None",
    "_set_wrenches": "None",
    "_contacts": (
        "list[tuple[str, str, str | None, str, int | None, _Array, _Array, float, _Array, _Array]]"
    ),
    "_energy_account": "_Record",
    "_reset": "None",
    "_set_state": "None",
    # The method of a robot; that of a batch returns nothing.
    "_step": "tuple[_Array, _Array]",
    "_links": "list[tuple[str, int, int | None, float, list[float], list[list[float]]]]",
    "_add_constraint": "None",
    "_add_terminal_constraint": "None",
    "_next_controls": "_Array",
    "_plan": "_Record",
    "_set_control_bounds": "None",
    "_set_dynamics": "None",
    "_set_effort_limits": "None",
    "_set_initial_state": "None",
    "_set_running_cost": "None",
    "_set_terminal_cost": "None",
    "_sample": "_Record",
    "_sizes": "tuple[int, int]",
    "_solve": "_Record",
    "_times": "tuple[int, float, float, float, int]",
    "neutral": "NDArray[np.float64]",
    "random_configuration": "NDArray[np.float64]",
    "example_text": "str",
    "num_threads": "int",
    "set_num_threads": "None",
    "quantities": "list[tuple[str, list[str], int]]",
    "dlqr": "_Record",
    "_nanoseconds": "float",
    "values": "NDArray[np.float64]",
    "nearest_parameters": "NDArray[np.float64]",
    "parameters": "NDArray[np.float64]",
    "_xla_handle": "int",
    "_defaults": "_Record",
    "_xla_handlers": "dict[str, object]",
    "_device_signature": "tuple[_Tables, _Tables]",
    "_contact_links": "list[str]",
    "_compute": "None",
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
# Results of methods whose name another class has, too.
RETURNS_OF = {
    ("PolynomialMotion", "_state"): "list[_Array]",
    ("CudaFunctions", "_rollout"): "None",
    ("Admittance", "step"): "tuple[NDArray[np.float64], NDArray[np.float64], NDArray[np.float64]]",
    ("SimulationBatch", "_sensors"): "_Array",
    ("SimulationBatch", "_step"): "None",
}

PROPERTIES = {
    "name": "str",
    "collision": "int | None",
    "displacement": "NDArray[np.float64]",
    "external_torque": "NDArray[np.float64]",
    "robot": "Robot",
    "nodes": "int",
    "controls": "list[int]",
    "row_names": "list[str]",
    "names": "list[str]",
    "invisible": "list[str]",
    "hidden": "list[str]",
    "parameters": "NDArray[np.float64]",
    "covariance": "NDArray[np.float64]",
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
    "losses": "dict[str, float] | None",
    "times": "list[float]",
}

# Base classes of classes of the Python package.
BASES = (
    "Robot",
    "Scene",
    "Simulation",
    "SimulationBatch",
    "WholeBody",
    "KinematicTasks",
    "JerkLimitedMotion",
    "PayloadFilter",
)

# Writable attributes with their types.
SETTERS = {
    ("Simulation", "activations"): "Numbers",
    ("Simulation", "controls"): "Numbers | Mapping[str, float]",
    ("Simulation", "torques"): "Numbers",
    ("SimulationBatch", "activations"): "Numbers",
    ("SimulationBatch", "controls"): "Numbers",
    ("SimulationBatch", "targets"): "Numbers",
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
            yield "".join(method(name, member, value))


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


def method(owner: str, name: str, value: object) -> Iterator[str]:
    if name in RETURNS:
        result = RETURNS_OF.get((owner, name)) or RETURNS[name]
        yield f"    def {name}({arguments(value, 0)}) -> {result}:\n{quoted(value.__doc__, 2)}"
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
            written.append(f"**{parameter.name}: object")
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
    if (value.__name__, name) in OF_CALL:
        return OF_CALL[value.__name__, name]
    if name == "out":
        array = f"NDArray[{number}]"
        several = results.BY_ALGORITHM.get(value.__name__)
        return f"tuple[{', '.join([array] * len(several._fields))}] | None" if several else f"{array} | None"
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
