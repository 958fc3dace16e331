"""The dynamics of any robot from its file: M(q) v̇ + C(q, v) v + g(q) + b(v) = τ.

>>> robot = rd.example("panda")  # or rd.load("your_robot.urdf")
>>> q, v, a = robot.neutral(), np.zeros(robot.nv), np.zeros(robot.nv)
>>> robot.inverse_dynamics(q, v, a).shape
(7,)
>>> robot.inverse_dynamics(np.tile(q, (1000, 1)), v, a).shape
(1000, 7)

One name does one state or many: any dimensions before the last are a batch, and what has none of its own goes with all
of it. Arrays are float64 or float32, in and out, never converted silently; lists and integers become float64.

Units are SI. Six numbers are linear first, angular second; quaternions are x y z w; the names of Jacobians, velocities
and wrenches end in the frame that they are written in.
"""

from robot_dynamics._native import num_threads, set_num_threads
from robot_dynamics.errors import (
    BadStatesError,
    DTypeError,
    FrameError,
    LoadError,
    LoadWarning,
    RobotDynamicsError,
    ShapeError,
    SingularMassError,
    StateError,
)
from robot_dynamics.loading import example, load, loads
from robot_dynamics.report import Finding, LoadReport
from robot_dynamics.results import (
    ForwardDynamicsDerivatives,
    FrameAccelerationDerivatives,
    InverseDynamicsDerivatives,
)
from robot_dynamics.robot import Joint, Robot

__all__ = [
    "BadStatesError",
    "DTypeError",
    "Finding",
    "ForwardDynamicsDerivatives",
    "FrameAccelerationDerivatives",
    "FrameError",
    "InverseDynamicsDerivatives",
    "Joint",
    "LoadError",
    "LoadReport",
    "LoadWarning",
    "Robot",
    "RobotDynamicsError",
    "ShapeError",
    "SingularMassError",
    "StateError",
    "example",
    "load",
    "loads",
    "num_threads",
    "set_num_threads",
]
