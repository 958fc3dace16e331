"""Robots with motors and gears, and with elastic joints."""

from __future__ import annotations

from dataclasses import dataclass
from math import inf
from typing import TYPE_CHECKING

from robot_dynamics.edits import EditedRobot, noted

if TYPE_CHECKING:
    from robot_dynamics.robot import Robot


@dataclass(frozen=True)
class Winding:
    """Temperature T of a motor's winding above the ambient one: C Ṫ = R i² − T/R_th.

    The resistance of the winding changes with its temperature by the factor 1 + α (T + ambient − reference).
    """

    resistance: float
    """R_th, thermal resistance to the surroundings [K/W]."""
    capacity: float
    """C, thermal capacity [J/K]."""
    coefficient: float = 0.0
    """α [1/K]; 0.0039 for copper."""
    reference: float = 20.0
    """Temperature at which the motor's resistance is known [°C]."""
    ambient: float = 20.0
    """Ambient temperature [°C]."""


def with_motor(
    robot: Robot,
    joint: str,
    *,
    gear: float,
    rotor_inertia: float,
    resistance: float,
    constant: float,
    voltage_limit: float = inf,
    current_limit: float = inf,
    time_constant: float | None = None,
    winding: Winding | None = None,
    derating: tuple[float, float] | None = None,
) -> Robot:
    """Robot with an electric motor that drives a joint through a gear.

    The inertia of the rotor at the joint, n² J, is added to the joint's armature, so that all dynamics
    include it. The actuator `JOINT_motor` takes the torque that is requested at the motor's shaft as its
    control. The torque is K i with i = (V − K n q̇)/R, within the limits of current and voltage, which give
    the torque-speed curve. From a data sheet with the stall torque τ₀ and the speed without load ω₀ at V:
    K = V/ω₀ and R = K V/τ₀.

    Parameters
    ----------
    joint : str
        Name of a revolute, continuous or prismatic joint.
    gear : float
        n, turns of the shaft for one of the joint [1, or rad/m for a prismatic joint].
    rotor_inertia : float
        J, moment of inertia of the rotor [kg·m²].
    resistance : float
        R [Ω].
    constant : float
        K [N·m/A or V·s/rad].
    voltage_limit : float
        Largest voltage [V].
    current_limit : float
        Largest current [A].
    time_constant : float, optional
        Inductance over resistance [s]; default: the current follows the voltage at once.
    winding : Winding, optional
        Thermal model of the winding.
    derating : tuple of float, optional
        Temperatures at which the current limit begins to fall, and at which it is 0 [°C]. It needs `winding`
        and `current_limit`.

    Returns
    -------
    Robot
        The robot with the motor.

    Raises
    ------
    DescriptionError
        The joint does not exist or follows another one, a name is taken, or a number is invalid.

    Examples
    --------
    >>> robot = rd.example("two_r").with_motor("shoulder", gear=100.0, rotor_inertia=2e-5, resistance=1.6, constant=0.08)
    >>> bool(np.isclose(robot.mass_matrix([0, 0])[0, 0] - rd.example("two_r").mass_matrix([0, 0])[0, 0], 0.2))
    True
    """
    thermal = None
    if winding is not None:
        thermal = (winding.resistance, winding.capacity, winding.coefficient, winding.reference, winding.ambient)
    motor = (resistance, constant, voltage_limit, current_limit, time_constant, thermal, derating)
    return robot._edited(robot._with_motor(joint, (gear, rotor_inertia), motor))


def with_elastic_joint(
    robot: Robot, joint: str, stiffness: float, damping: float = 0.0, *, backlash: float = 0.0
) -> EditedRobot:
    """Robot with a spring between the motor and the link of a joint, for example of a harmonic drive.

    The joint becomes the motor's side, with its armature, limits, friction and actuators. A new joint
    `JOINT_elastic` without a motor turns the link relative to it; the angle of the link is the sum of both.
    With a backlash, the spring acts outside of a dead band. (Spong 1987)

    Parameters
    ----------
    joint : str
        Name of a revolute, continuous or prismatic joint with armature: see `with_motor`.
    stiffness : float
        Stiffness at the joint [N·m/rad or N/m].
    damping : float
        Damping at the joint [N·m·s/rad or N·s/m].
    backlash : float
        Width of the dead band [rad or m].

    Returns
    -------
    EditedRobot
        The robot, and notes on joints that follow the motor of this one.

    Raises
    ------
    DescriptionError
        The joint does not exist, follows another one or has no armature, a name is taken, or a number is
        invalid.

    Examples
    --------
    >>> motor = dict(gear=100.0, rotor_inertia=2e-5, resistance=1.6, constant=0.08)
    >>> soft = rd.example("two_r").with_motor("shoulder", **motor).with_elastic_joint("shoulder", 1e4, 5.0).robot
    >>> soft.joint_names
    ('shoulder', 'shoulder_elastic', 'elbow')
    """
    return noted(robot, robot._with_elastic_joint(joint, stiffness, damping, backlash))
