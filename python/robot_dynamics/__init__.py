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

from robot_dynamics._native import (
    BaseParameters,
    Constraints,
    GravityCompensatedPd,
    JointMap,
    __version__,
    num_threads,
    set_num_threads,
)
from robot_dynamics.checks import Audit, Check
from robot_dynamics.constraints import Closure, Contact, Coupling, NoSlip, PointContact, RollingDisc
from robot_dynamics.control import Dlqr, InverseKinematicsSolution, OperationalSpace, dlqr
from robot_dynamics.errors import (
    BadStatesError,
    ColumnError,
    ConstraintError,
    ControlError,
    DescriptionError,
    DTypeError,
    FrameError,
    IdentificationError,
    InverseKinematicsError,
    LoadError,
    LoadWarning,
    PlanningError,
    QuantityError,
    RobotDynamicsError,
    ShapeError,
    SimulationError,
    SingularMassError,
    StateError,
)
from robot_dynamics.identification import Identified
from robot_dynamics.loading import example, load, loads
from robot_dynamics.motion import EnergyLedger, Event, LinearizedStep, Motion, Rollout
from robot_dynamics.planning import TimedPath
from robot_dynamics.pullbacks import RolloutPullback
from robot_dynamics.report import Finding, LoadReport
from robot_dynamics.results import (
    ForwardDynamicsDerivatives,
    ForwardDynamicsPullback,
    FrameAccelerationDerivatives,
    InverseDynamicsDerivatives,
    InverseDynamicsPullback,
)
from robot_dynamics.robot import Joint, Robot

__all__ = [
    "__version__",
    "Audit",
    "BadStatesError",
    "BaseParameters",
    "Check",
    "Closure",
    "ColumnError",
    "ConstraintError",
    "Constraints",
    "Contact",
    "ControlError",
    "Coupling",
    "DTypeError",
    "DescriptionError",
    "Dlqr",
    "EnergyLedger",
    "Event",
    "Finding",
    "ForwardDynamicsDerivatives",
    "ForwardDynamicsPullback",
    "FrameAccelerationDerivatives",
    "FrameError",
    "GravityCompensatedPd",
    "IdentificationError",
    "Identified",
    "InverseDynamicsDerivatives",
    "InverseDynamicsPullback",
    "InverseKinematicsError",
    "InverseKinematicsSolution",
    "Joint",
    "JointMap",
    "LinearizedStep",
    "LoadError",
    "LoadReport",
    "LoadWarning",
    "Motion",
    "NoSlip",
    "OperationalSpace",
    "PlanningError",
    "PointContact",
    "QuantityError",
    "Robot",
    "RobotDynamicsError",
    "RollingDisc",
    "Rollout",
    "RolloutPullback",
    "ShapeError",
    "SimulationError",
    "SingularMassError",
    "StateError",
    "TimedPath",
    "dlqr",
    "example",
    "load",
    "loads",
    "num_threads",
    "set_num_threads",
]
