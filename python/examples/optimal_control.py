"""Optimal control of six robots: swing-ups, a pick, a push, a jump, and a stand under pushes.

    python python/examples/optimal_control.py [--short] [--figure optimal_control.png]

- A cart-pole and a two-link arm without a motor at its shoulder (an acrobot) swing up.
- A Panda moves its hand to an object and back up, within the effort limits of its joints.
- A block is pushed to a goal. The push is found through the derivatives of friction.
- A quadruped jumps: its feet are contacts that the simulator finds, and no phases are stated.
- A humanoid stands under pushes. A model predictive controller plans through the simulator's contacts.
"""

import argparse
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
    push = oc.HeldContactStep(robot, feet, dt=dt, damping=20.0, stiffness=100.0, actuation="motors")
    flight = oc.SmoothStep(robot, dt=dt, dissipation=False, actuation="motors")
    third = nodes // 3
    problem = oc.Problem(push, rest, nodes=nodes)
    in_air, lands = range(third, 2 * third), 2 * third
    problem.set_dynamics(flight, nodes=in_air)
    problem.set_dynamics(oc.ImpactStep(robot, feet), nodes=lands)
    holding = holding_torques(robot, q, feet)
    weights = np.concatenate([np.zeros(6), np.full(robot.nv - 6, 1.0), np.zeros(6), np.full(robot.nv - 6, 0.3)])
    posture = oc.LeastSquares(oc.StateResidual(rest), weights * dt)
    friction = [oc.LeastSquares(oc.FrictionPyramidResidual(push, foot, 0.7), 0.1 * dt, lower=0.0) for foot in FEET]
    effort = oc.LeastSquares(oc.ControlResidual(), 1e-3 * dt)
    for phase in (range(0, third), range(lands + 1, nodes)):
        problem.set_running_cost(effort, posture, *friction, nodes=phase)
    problem.set_running_cost(effort, posture, nodes=in_air)
    apex = robot.center_of_mass(q) + [0.0, 0.0, height]
    middle = third + third // 2
    problem.set_running_cost(effort, posture, oc.LeastSquares(oc.CenterOfMassResidual(apex), 1e5), nodes=middle)
    landing = [oc.LeastSquares(oc.FrameTranslationResidual(foot, place), 1e5) for foot, place in places.items()]
    problem.set_running_cost(posture, *landing, nodes=lands)
    problem.set_terminal_cost(oc.LeastSquares(oc.StateResidual(rest), 100.0))
    problem.set_effort_limits(nodes=range(0, lands))
    problem.set_effort_limits(nodes=range(lands + 1, nodes))
    still = [np.zeros(0) if k == lands else np.zeros(12) if k in in_air else holding for k in range(nodes)]
    states = [np.concatenate(rest)] * (nodes + 1)
    return problem.solve(states=states, controls=still, max_iterations=300), dt, robot, height


def stand(periods: int) -> tuple[Array, Array, oc.MpcTimes, float]:
    """A humanoid is pushed; a model predictive controller keeps it on its feet.

    The plan holds the feet. The simulation finds the contacts of their soles with the ground. Returns the
    positions of the centre of mass and the force of the push by period, the times of the controller, and the
    length of a period.
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
    soles = {foot: rd.Contact(foot, robot.frame_pose(q, foot)) for foot in ("left_foot", "right_foot")}
    feet = robot.constraints(soles)
    step = oc.HeldContactStep(robot, feet, dt=dt, damping=20.0, actuation="motors")
    problem = oc.Problem(step, (q, np.zeros(robot.nv)), nodes=20)
    holding = holding_torques(robot, q, feet)
    # Weights of the displacements of the base and the joints, and of their rates.
    weights = np.concatenate([[0.0, 0.0, 0.0, 10.0, 10.0, 10.0], np.full(robot.nv - 6, 1.0), np.full(robot.nv, 0.1)])
    rest = oc.LeastSquares(oc.StateResidual((q, np.zeros(robot.nv))), weights)
    balance = oc.LeastSquares(oc.CenterOfMassResidual(robot.center_of_mass(q)), 1e3)
    problem.set_running_cost(rest, balance, oc.LeastSquares(oc.ControlResidual(holding), 1e-4))
    problem.set_terminal_cost(rest, balance)
    problem.set_effort_limits()
    start = problem.solve(states=[np.concatenate([q, np.zeros(robot.nv)])] * 21, controls=[holding] * 20)
    mpc = oc.Mpc(problem, start, iterations=1)
    simulation = rd.Simulation(robot, dt=dt / substeps, integrator="implicit", ground=rd.Ground())
    simulation.reset(q)
    motors = np.flatnonzero(robot.actuated_dofs)
    positions, pushes = [], []
    for period in range(periods):
        force = 80.0 if 10 <= period < 20 else 0.0
        simulation.clear_wrenches()
        if force:
            simulation.apply_wrench("thorax", force=(force, 0.0, 0.0))
        torques = np.zeros(robot.nv)
        torques[motors] = mpc.step((simulation.q, simulation.v))
        simulation.torques = torques
        for _ in range(substeps):
            simulation.step()
        positions.append(robot.center_of_mass(simulation.q))
        pushes.append(force)
    return np.array(positions), np.array(pushes), mpc.times, dt


def holding_torques(robot: rd.Robot, q: Array, contacts: rd.Constraints) -> Array:
    """Torques of the motors that hold the robot still on contacts; the base gives the contacts' forces."""
    rows, gravity = robot.constraint_rows(contacts, q).matrix, robot.gravity(q)
    forces = np.linalg.lstsq(rows[:, :6].T, gravity[:6], rcond=None)[0]
    torques: Array = (gravity - rows.T @ forces)[6:]
    return torques


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


def main(arguments: list[str] | None = None) -> dict[str, Any]:
    """Print the results, draw the figure, and return the results."""
    parser = argparse.ArgumentParser(description=__doc__.splitlines()[0])
    parser.add_argument("--short", action="store_true", help="use fewer nodes and periods")
    parser.add_argument("--figure", default="optimal_control.png")
    options = parser.parse_args(arguments)
    short = options.short
    cart = cart_pole(60 if short else 100)
    swing = acrobot(100 if short else 150)
    picked = pick(30 if short else 50)
    pushed = push_block(20 if short else 40)
    jumped = jump(45 if short else 90)
    stood = stand(30 if short else 75)
    for name, solution in [
        ("cart-pole", cart[0]),
        ("acrobot", swing[0]),
        ("pick", picked[0]),
        ("block", pushed[0]),
        ("jump", jumped[0]),
    ]:
        print(f"{name}: {solution.termination} after {len(solution.log)} iterations, cost {solution.cost:.4g}")
    times = stood[2]
    print(f"humanoid: {times.periods} periods of {stood[3]:g} s, each planned in {1e3 * times.median:.0f} ms (median)")
    draw(options.figure, cart, swing, picked, pushed, jumped, stood)
    robot, down = picked[2], picked[3]
    grasp = robot.frame_pose(picked[0].q[len(picked[0].q) // 2], "panda_link8")[:3, 3]
    jumper = jumped[2]
    heights = np.array([jumper.center_of_mass(q)[2] for q in jumped[0].q])
    return {
        "cart_pole": np.abs(cart[0].q[-1] - [0.0, np.pi]).max(),
        "acrobot": np.abs(swing[0].q[-1] - [np.pi / 2, 0.0]).max(),
        "pick": np.linalg.norm(grasp - down),
        "block": abs(pushed[0].q[-1, 0] - pushed[2][0]),
        "jump": heights.max() - heights[0],
        "asked": jumped[3],
        "landing": np.abs(jumped[0].states[-1] - jumped[0].states[0]).max(),
        "stand": np.linalg.norm(stood[0] - stood[0][0], axis=1),
    }


def draw(
    path: str,
    cart: tuple[oc.Solution, float],
    swing: tuple[oc.Solution, float],
    picked: tuple[oc.Solution, float, rd.Robot, Array],
    pushed: tuple[oc.Solution, float, Array],
    jumped: tuple[oc.Solution, float, rd.Robot, float],
    stood: tuple[Array, Array, oc.MpcTimes, float],
) -> None:
    """Draw the figure."""
    import matplotlib

    matplotlib.use("Agg")
    from matplotlib import colormaps, pyplot

    figure, axes = pyplot.subplots(2, 3, figsize=(13.5, 7.6), layout="constrained")

    def colors(count: int) -> Any:
        return colormaps["viridis_r"](np.linspace(0.1, 1.0, count))

    axis = axes[0, 0]
    q = cart[0].q[:: max(1, len(cart[0].q) // 25)]
    for (x, angle), color in zip(q, colors(len(q)), strict=True):
        axis.plot([x, x - np.sin(angle)], [0.0, -np.cos(angle)], color=color, linewidth=1.6)
    axis.plot(q[:, 0], np.zeros(len(q)), "s", color="0.4", markersize=4)
    axis.set(title="cart-pole, from light to dark", xlabel="x [m]", ylabel="z [m]", aspect="equal")

    axis = axes[0, 1]
    q = swing[0].q[:: max(1, len(swing[0].q) // 30)]
    for (first, second), color in zip(q, colors(len(q)), strict=True):
        angles = np.array([first, first + second])
        joints = np.cumsum([[0.0, 0.0], *np.stack([np.cos(angles), np.sin(angles)], axis=1)], axis=0)
        axis.plot(*joints.T, color=color, linewidth=1.4)
    axis.set(title="acrobot: a motor at the elbow alone", xlabel="x [m]", ylabel="z [m]", aspect="equal")

    axis = axes[0, 2]
    solution, dt, robot, down = picked
    hand = np.array([robot.frame_pose(one, "panda_link8")[:3, 3] for one in solution.q])
    t = dt * np.arange(len(hand))
    for column, name in enumerate("xyz"):
        (line,) = axis.plot(t, hand[:, column], label=name)
        axis.plot(t[len(t) // 2], down[column], "o", color=line.get_color())
    axis.set(title="Panda: the hand meets the object", xlabel="t [s]", ylabel="position [m]")
    axis.legend(fontsize="small", loc="center right", bbox_to_anchor=(1.0, 0.67))

    axis = axes[1, 0]
    solution, dt, goal = pushed
    t = dt * np.arange(len(solution.q))
    axis.plot(t, solution.q[:, 0], label="position [m]")
    axis.axhline(goal[0], color="0.6", linewidth=0.8, linestyle="--", label="goal")
    axis.set(title="block: pushed against friction", xlabel="t [s]", ylabel="x [m]")
    other = axis.twinx()
    other.step(t[:-1], np.asarray(solution.controls)[:, 0], where="post", color="tab:orange", label="push [N]")
    other.set_ylabel("push [N]")
    handles, labels = axis.get_legend_handles_labels()
    more_handles, more_labels = other.get_legend_handles_labels()
    axis.legend(handles + more_handles, labels + more_labels, fontsize="small", loc="center left")

    axis = axes[1, 1]
    solution, dt, robot, height = jumped
    t = dt * np.arange(len(solution.q))
    center = np.array([robot.center_of_mass(one)[2] for one in solution.q])
    foot = np.array([robot.frame_pose(one, FEET[0])[2, 3] for one in solution.q])
    axis.plot(t, center, label="centre of mass")
    axis.plot(t, foot, label="a foot")
    axis.axhline(center[0] + height, color="0.6", linewidth=0.8, linestyle="--", label="asked height")
    axis.axvspan(t[len(t) // 3], t[2 * (len(t) // 3)], color="0.93", label="flight")
    axis.set(title="quadruped: a jump", xlabel="t [s]", ylabel="height [m]")
    axis.legend(fontsize="small", loc="center left", bbox_to_anchor=(0.0, 0.45))

    axis = axes[1, 2]
    center, push, _, dt = stood
    t = dt * (1 + np.arange(len(center)))
    axis.plot(t, 1e3 * (center[:, 0] - center[0, 0]), label="centre of mass, forward")
    axis.plot(t, 1e3 * (center[:, 2] - center[0, 2]), label="up")
    axis.axvspan(t[push > 0.0][0] - dt, t[push > 0.0][-1], color="0.93", label=f"push of {push.max():g} N")
    axis.set(title="humanoid: pushed, under MPC", xlabel="t [s]", ylabel="displacement [mm]")
    axis.legend(fontsize="small", loc="upper right")
    figure.savefig(path, dpi=110)
    pyplot.close(figure)
    print(f"figure: {path}")


if __name__ == "__main__":
    main()
