"""Default values of options, which the Rust library defines for all front ends."""

from typing import Final

from robot_dynamics import _native

_VALUES = _native._defaults()

DT: Final[float] = _VALUES["dt"]
"""Step of a simulation [s]."""

POSITION_TOLERANCE: Final[float] = _VALUES["position_tolerance"]
"""Largest distance from the target of inverse kinematics [m]."""

ANGLE_TOLERANCE: Final[float] = _VALUES["angle_tolerance"]
"""Largest rotation angle to the target of inverse kinematics [rad]."""

MAX_ITERATIONS: Final[int] = _VALUES["max_iterations"]
"""Largest number of iterations of each search of inverse kinematics."""

MAX_RESTARTS: Final[int] = _VALUES["max_restarts"]
"""Largest number of random restarts of inverse kinematics."""

SEED: Final[int] = _VALUES["seed"]
"""Seed of the random configurations of inverse kinematics."""

FORCE_WEIGHT: Final[float] = _VALUES["force_weight"]
"""Weight of support forces beside torques [m²]."""

RANDOM_JOINTS: Final[int] = _VALUES["random_joints"]
"""Number of joints of a random robot."""

AUDIT_STATES: Final[int] = _VALUES["audit_states"]
"""Number of random states of an audit."""

AUDIT_SEED: Final[int] = _VALUES["audit_seed"]
"""Seed of the random states of an audit."""

OPTIMAL_MAX_ITERATIONS: Final[int] = _VALUES["optimal_max_iterations"]
"""Largest number of iterations of a solver of optimal control."""

OPTIMAL_GRADIENT_TOLERANCE: Final[float] = _VALUES["optimal_gradient_tolerance"]
"""Largest derivative of the Lagrangian by a control at a solution."""

OPTIMAL_DEFECT_TOLERANCE: Final[float] = _VALUES["optimal_defect_tolerance"]
"""Largest entry of a defect of the dynamics at a solution."""

OPTIMAL_DECREASE_TOLERANCE: Final[float] = _VALUES["optimal_decrease_tolerance"]
"""Predicted relative decrease of the cost below which a solver ends."""

OPTIMAL_CONSTRAINT_TOLERANCE: Final[float] = _VALUES["optimal_constraint_tolerance"]
"""Largest violation of a constraint at a solution."""

GENERATED_FUNCTIONS: Final[tuple[str, ...]] = tuple(_VALUES["generated_functions"])
"""Functions of generated code."""

GENERATED_STATES: Final[int] = _VALUES["generated_states"]
"""Number of random states in which generated code is compared with the library."""
