"""The dynamics of any robot from its file: M(q) v̇ + C(q, v) v + g(q) + b(v) = τ.

>>> robot = rd.example("panda")  # or rd.load("your_robot.urdf")
>>> q, v, a = robot.neutral(), np.zeros(robot.nv), np.zeros(robot.nv)
>>> robot.inverse_dynamics(q, v, a).shape
(7,)
>>> robot.inverse_dynamics(np.tile(q, (1000, 1)), v, a).shape
(1000, 7)

The same function computes one state or many: all dimensions before the last are a batch, and arguments
broadcast. Arrays are float64 or float32, for arguments and results, and are never converted silently. Lists
and integers become float64.

Units are SI. Spatial vectors have the linear part first and the angular part second. Quaternions are x y z w.
The names of Jacobians, velocities and wrenches end in the frame of their components.
"""

from __future__ import annotations

from robot_dynamics._native import (
    Admittance,
    BaseParameters,
    ComputedTorque,
    Constraints,
    ControlAllocation,
    Delayed,
    GravityCompensatedPd,
    ImpedanceControl,
    ImplicitGains,
    JointMap,
    MomentumObserver,
    Snapshot,
    TaskControl,
    __version__,
    num_threads,
    set_num_threads,
)
from robot_dynamics import certified, gpu, optimal, whole_body
from robot_dynamics.checks import Audit, Check
from robot_dynamics.constraints import Contact, Coupling, FrameConstraint, NoSlip, PointContact, RollingDisc, Support
from robot_dynamics.control import Dlqr, InverseKinematicsSolution, OperationalSpace, dlqr
from robot_dynamics.conventions import MujocoState, PinocchioState, RobotState
from robot_dynamics.drives import Winding
from robot_dynamics.edits import EditedRobot
from robot_dynamics.errors import (
    BadSimulationsError,
    BadStatesError,
    ColumnError,
    ConstraintError,
    ControlError,
    DescriptionError,
    DeviceError,
    DTypeError,
    FrameError,
    GenerateError,
    IdentificationError,
    InverseKinematicsError,
    LoadError,
    LoadWarning,
    PlanningError,
    QuantityError,
    RobotDynamicsError,
    ShapeError,
    SimulationError,
    SimulationInputError,
    SingularMassError,
    StateError,
)
from robot_dynamics.excitation import Excitation, FourierSeries
from robot_dynamics.files import RobotText, UnsupportedFeature
from robot_dynamics.fluid import FluidForceDerivatives
from robot_dynamics.ground import Ground, HeightField
from robot_dynamics.identification import ConsistentEstimate, IdentificationResult, NonlinearEstimate
from robot_dynamics.loading import example, load, loads, random_robot
from robot_dynamics.motion import EnergyAccount, Event, LinearizedStep, Motion, Rollout, StepStatistics
from robot_dynamics.online_motion import OnlineMotion
from robot_dynamics.payload import Payload, PayloadEstimator
from robot_dynamics.planning import TimedPath
from robot_dynamics.pullbacks import LinearizedSteps, RolloutPullback
from robot_dynamics.report import Finding, LoadReport
from robot_dynamics.results import (
    DissipationPullback,
    ForwardDynamicsDerivatives,
    ForwardDynamicsPullback,
    ForwardDynamicsPullbackWithParameters,
    FrameAccelerationDerivatives,
    InverseDynamicsDerivatives,
    InverseDynamicsPullback,
    InverseDynamicsPullbackWithParameters,
)
from robot_dynamics.robot import EndEffector, Group, Joint, Link, Robot
from robot_dynamics.scene import Scene
from robot_dynamics.sensors import PointForce, Sensor
from robot_dynamics.simulation import ContactPoint, Simulation, SimulationBatch
from robot_dynamics.task_kinematics import KinematicStep, TaskKinematics, TaskSolution, TaskSolutions

__all__ = [
    "__version__",
    "Admittance",
    "Audit",
    "BadSimulationsError",
    "BadStatesError",
    "BaseParameters",
    "Check",
    "ColumnError",
    "ComputedTorque",
    "ConsistentEstimate",
    "ConstraintError",
    "Constraints",
    "Contact",
    "ContactPoint",
    "ControlAllocation",
    "ControlError",
    "Coupling",
    "DTypeError",
    "DescriptionError",
    "DeviceError",
    "DissipationPullback",
    "Delayed",
    "Dlqr",
    "EditedRobot",
    "EndEffector",
    "EnergyAccount",
    "Event",
    "Excitation",
    "Finding",
    "FluidForceDerivatives",
    "ForwardDynamicsDerivatives",
    "ForwardDynamicsPullback",
    "ForwardDynamicsPullbackWithParameters",
    "FrameAccelerationDerivatives",
    "FourierSeries",
    "FrameConstraint",
    "FrameError",
    "GenerateError",
    "GravityCompensatedPd",
    "Ground",
    "Group",
    "HeightField",
    "IdentificationError",
    "IdentificationResult",
    "ImpedanceControl",
    "ImplicitGains",
    "InverseDynamicsDerivatives",
    "InverseDynamicsPullback",
    "InverseDynamicsPullbackWithParameters",
    "InverseKinematicsError",
    "InverseKinematicsSolution",
    "Joint",
    "JointMap",
    "KinematicStep",
    "LinearizedStep",
    "LinearizedSteps",
    "Link",
    "LoadError",
    "LoadReport",
    "LoadWarning",
    "MomentumObserver",
    "Motion",
    "MujocoState",
    "NoSlip",
    "NonlinearEstimate",
    "OnlineMotion",
    "OperationalSpace",
    "Payload",
    "PayloadEstimator",
    "PinocchioState",
    "PlanningError",
    "PointContact",
    "PointForce",
    "QuantityError",
    "Robot",
    "RobotDynamicsError",
    "RobotState",
    "RobotText",
    "RollingDisc",
    "Rollout",
    "RolloutPullback",
    "Scene",
    "Sensor",
    "ShapeError",
    "Simulation",
    "SimulationBatch",
    "SimulationError",
    "SimulationInputError",
    "SingularMassError",
    "Snapshot",
    "StateError",
    "StepStatistics",
    "Support",
    "TaskControl",
    "TaskKinematics",
    "TaskSolution",
    "TaskSolutions",
    "TimedPath",
    "UnsupportedFeature",
    "Winding",
    "certified",
    "dlqr",
    "example",
    "gpu",
    "load",
    "loads",
    "num_threads",
    "optimal",
    "random_robot",
    "set_num_threads",
    "whole_body",
]
