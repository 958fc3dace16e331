"""Optimal control of six robots: swing-ups, a pick, a push, a jump, and a stand under pushes.

    python python/examples/optimal_control.py [--short] [--figure optimal_control.png]

- A cart-pole and a two-link arm without a motor at its shoulder (an acrobot) swing up.
- A Panda moves its hand to an object and back up, within the effort limits of its joints.
- A block is pushed to a goal. The push is found through the derivatives of friction.
- A quadruped jumps: its feet are contacts that the simulator finds, and no phases are stated.
- A humanoid stands under pushes. A model predictive controller plans through the simulator's contacts.
"""

import argparse
from collections.abc import Sequence
from typing import Any

import numpy as np
from numpy.typing import NDArray

import robot_dynamics as rd
from robot_dynamics import optimal as oc

Array = NDArray[np.float64]

CART_POLE = """
<mujoco model="cart-pole"><worldbody>
  <body name="cart"><joint name="slide" type="slide" axis="1 0 0"/><geom type="box" size="0.2 0.1 0.1" mass="1"/>
    <body name="pole"><joint name="hinge" axis="0 1 0"/><geom type="capsule" fromto="0 0 0 0 0 -1" size="0.03" mass="0.3"/>
    </body></body></worldbody></mujoco>
"""

BLOCK = """
<mujoco model="block"><worldbody><geom name="table" type="plane" size="5 5 1" friction="0.3"/>
  <body name="block" pos="0 0 0.1"><freejoint/><geom type="box" size="0.1 0.1 0.1" mass="1" friction="0.3"/></body>
</worldbody></mujoco>
"""


def cart_pole(nodes: int) -> tuple[oc.Solution, float]:
    """Swing-up of a pole on a cart by a force of at most 15 N."""
    robot, dt = rd.loads(CART_POLE), 3.0 / nodes
    problem = oc.Problem(oc.SmoothStep(robot, dt=dt, actuation=[[1.0], [0.0]]), np.zeros(4), nodes=nodes)
    upright = ([0.0, np.pi], [0.0, 0.0])
    problem.set_running_cost(
        oc.LeastSquares(oc.ControlResidual(), 1e-2 * dt), oc.LeastSquares(oc.StateResidual(upright), 0.1 * dt)
    )
    problem.set_terminal_cost(oc.LeastSquares(oc.StateResidual(upright), 1e3))
    problem.set_control_bounds(-15.0, 15.0)
    return problem.solve(max_iterations=500), dt


def acrobot(nodes: int) -> tuple[oc.Solution, float]:
    """Swing-up of two rods by the motor between them, with at most 20 N·m."""
    robot, dt = rd.example("two_r"), 5.0 / nodes
    hanging, upright = np.array([-np.pi / 2, 0.0]), np.array([np.pi / 2, 0.0])
    step = oc.SmoothStep(robot, dt=dt, actuation=[[0.0], [1.0]])
    problem = oc.Problem(step, (hanging, np.zeros(2)), nodes=nodes)
    problem.set_running_cost(oc.LeastSquares(oc.ControlResidual(), 1e-3 * dt))
    problem.set_terminal_cost(oc.LeastSquares(oc.StateResidual((upright, np.zeros(2))), 1e3))
    problem.set_control_bounds(-20.0, 20.0)
    t = np.linspace(0.0, 5.0, nodes)[:, np.newaxis]
    return problem.solve(controls=5.0 * np.sin(4.0 * t), max_iterations=1000), dt


def pick(nodes: int) -> tuple[oc.Solution, float, rd.Robot, Array]:
    """A Panda's hand goes down to an object within the first half, and comes back up."""
    robot, dt = rd.example("panda"), 2.0 / nodes
    q = np.array([0.0, 0.3, 0.0, -1.8, 0.0, 2.0, 0.6])
    home = robot.frame_pose(q, "panda_link8")
    down = home[:3, 3] + [0.1, 0.25, -0.35]
    problem = oc.Problem(oc.SmoothStep(robot, dt=dt), (q, np.zeros(7)), nodes=nodes)
    problem.set_running_cost(
        oc.LeastSquares(oc.ControlResidual(robot.gravity(q)), 1e-3 * dt),
        oc.LeastSquares(oc.StateResidual((q, np.zeros(7))), [0.0] * 7 + [0.1 * dt] * 7),
        oc.LeastSquares(oc.FrameRotationResidual("panda_link8", home[:3, :3]), 10.0 * dt),
    )
    grasp = nodes // 2
    problem.add_constraint(oc.FrameTranslationResidual("panda_link8", down), 0.0, 0.0, nodes=grasp)
    problem.add_constraint(oc.FrameVelocityResidual("panda_link8"), 0.0, 0.0, nodes=grasp)
    problem.add_terminal_constraint(oc.StateResidual((q, np.zeros(7))), 0.0, 0.0)
    problem.set_effort_limits()
    return problem.solve(max_iterations=200), dt, robot, down


def push_block(nodes: int) -> tuple[oc.Solution, float, Array]:
    """A block is pushed by 0.3 m along a table with friction, and comes to rest there."""
    dt = 0.4 / nodes
    simulation = rd.Simulation(rd.loads(BLOCK), dt=dt, integrator="implicit", ground="file")
    goal = simulation.q + [0.3, 0.0, 0.0, 0.0, 0.0, 0.0, 0.0]
    push = np.eye(6)[:, :1]
    problem = oc.Problem(oc.SimulationStep(simulation, actuation=push), (simulation.q, np.zeros(6)), nodes=nodes)
    problem.set_running_cost(oc.LeastSquares(oc.ControlResidual(), 1e-2 * dt))
    weights = [1e3] + [0.0] * 5 + [10.0] + [0.0] * 5
    problem.set_terminal_cost(oc.LeastSquares(oc.StateResidual((goal, np.zeros(6))), weights))
    # The start must move the block: a block that sticks has no slope.
    return problem.solve(controls=np.full((nodes, 1), 6.0)), dt, goal


FEET = ("front_left_foot", "front_right_foot", "hind_left_foot", "hind_right_foot")


def jump(nodes: int) -> tuple[oc.Solution, float, rd.Robot, float]:
    """A quadruped pushes off, flies, and lands where it stood; feet hold in the first and the last third."""
    robot, dt, height = rd.example("quadruped", floating_base=True), 0.9 / nodes, 0.2
    q = robot.neutral()
    for joint in robot.joints:
        if joint.name.endswith(("hip_pitch", "knee")):
            q[joint.q] = 0.7 if joint.name.endswith("hip_pitch") else -1.4
    q[2] -= robot.frame_pose(q, FEET[0])[2, 3]
    rest, places = (q, np.zeros(robot.nv)), {foot: robot.frame_pose(q, foot)[:3, 3] for foot in FEET}
    feet = robot.constraints({foot: rd.PointContact(foot, place) for foot, place in places.items()})
    push = oc.HeldContactStep(robot, feet, dt=dt, damping=20.0, actuation="motors")
    flight = oc.SmoothStep(robot, dt=dt, dissipation=False, actuation="motors")
    third = nodes // 3
    problem = oc.Problem(push, rest, nodes=nodes)
    in_air, lands = range(third, 2 * third), 2 * third
    problem.set_dynamics(flight, nodes=in_air)
    problem.set_dynamics(oc.ImpactStep(robot, feet), nodes=lands)
    # Torques that hold the robot still: the rows of the base give the forces of the feet.
    rows, gravity = robot.constraint_rows(feet, q).matrix, robot.gravity(q)
    forces = np.linalg.lstsq(rows[:, :6].T, gravity[:6], rcond=None)[0]
    holding = (gravity - rows.T @ forces)[6:]
    weights = np.concatenate([np.zeros(6), np.full(robot.nv - 6, 0.1), np.full(robot.nv, 0.01)])
    posture = oc.LeastSquares(oc.StateResidual(rest), weights * dt)
    friction = [oc.LeastSquares(oc.FrictionPyramidResidual(push, foot, 0.7), 0.1 * dt, lower=0.0) for foot in FEET]
    effort = oc.LeastSquares(oc.ControlResidual(), 1e-3 * dt)
    for phase in (range(0, third), range(lands + 1, nodes)):
        problem.set_running_cost(effort, posture, *friction, nodes=phase)
    problem.set_running_cost(effort, posture, nodes=in_air)
    apex = robot.center_of_mass(q) + [0.0, 0.0, height]
    middle = third + third // 2
    problem.set_running_cost(effort, oc.LeastSquares(oc.CenterOfMassResidual(apex), 1e4), nodes=middle)
    landing = [oc.LeastSquares(oc.FrameTranslationResidual(foot, place), 1e5) for foot, place in places.items()]
    problem.set_running_cost(*landing, nodes=lands)
    problem.set_terminal_cost(oc.LeastSquares(oc.StateResidual(rest), 100.0))
    problem.set_effort_limits(nodes=range(0, lands))
    problem.set_effort_limits(nodes=range(lands + 1, nodes))
    still = [np.zeros(0) if k == lands else np.zeros(12) if k in in_air else holding for k in range(nodes)]
    states = [np.concatenate(rest)] * (nodes + 1)
    return problem.solve(states=states, controls=still, max_iterations=300), dt, robot, height


def stand(periods: int) -> tuple[Array, Array, oc.MpcTimes, float]:
    """A humanoid is pushed; a model predictive controller keeps it on its feet.

    Returns the heights of the pelvis and the forces of the push by period, the times of the controller, and
    the length of a period.
    """
    robot, dt, substeps = rd.example("humanoid", floating_base=True), 0.02, 10
    q = robot.neutral()
    # Bent joints are away from their stops.
    bent = {"hip_pitch": -0.25, "knee": 0.5, "ankle_pitch": -0.25, "elbow": -0.5}
    for joint in robot.joints:
        for name, angle in bent.items():
            if joint.name.endswith(name):
                q[joint.q] = angle
    q[2] = standing_height(robot, q)
    motors = np.flatnonzero(robot.actuated_dofs)
    planned = rd.Simulation(robot, dt=dt, integrator="implicit", ground=rd.Ground())
    step = oc.SimulationStep(planned, actuation="motors")
    problem = oc.Problem(step, (q, np.zeros(robot.nv)), nodes=15)
    posture = np.concatenate([[0.0, 0.0, 100.0, 100.0, 100.0, 100.0], np.full(robot.nv - 6, 10.0)])
    rest = oc.LeastSquares(oc.StateResidual((q, np.zeros(robot.nv))), np.concatenate([posture, np.full(robot.nv, 0.1)]))
    balance = oc.LeastSquares(oc.CenterOfMassResidual(robot.center_of_mass(q)), 1e3)
    problem.set_running_cost(rest, balance, oc.LeastSquares(oc.ControlResidual(), 1e-5))
    problem.set_terminal_cost(rest, balance)
    problem.set_effort_limits()
    holding = robot.gravity(q)[motors]
    mpc = oc.Mpc(problem, problem.solve(controls=[holding] * problem.nodes, max_iterations=20), iterations=1)
    simulation = rd.Simulation(robot, dt=dt / substeps, integrator="implicit", ground=rd.Ground())
    simulation.reset(q)
    heights, pushes = [], []
    for period in range(periods):
        force = 60.0 if 10 <= period < 20 else 0.0
        simulation.clear_wrenches()
        if force:
            simulation.apply_wrench("thorax", force=(0.0, force, 0.0))
        torques = np.zeros(robot.nv)
        torques[motors] = mpc.step((simulation.q, simulation.v))
        simulation.torques = torques
        for _ in range(substeps):
            simulation.step()
        heights.append(simulation.q[2])
        pushes.append(force)
    return np.array(heights), np.array(pushes), mpc.times, dt


def standing_height(robot: rd.Robot, q: Array) -> float:
    """Height of the base at which the lowest corner of a sole touches the ground."""
    simulation = rd.Simulation(robot, dt=1e-3, integrator="implicit", ground=rd.Ground())
    low, high = 0.0, 2.0
    for _ in range(40):
        middle = (low + high) / 2
        simulation.reset(np.concatenate([q[:2], [middle], q[3:]]))
        simulation.step()
        touches = any(contact.gap < 0.0 for contact in simulation.contacts)
        low, high = (middle, high) if touches else (low, middle)
    return high
