"""The trot and the reach of `measure_optimal` by crocoddyl: cost, iterations, milliseconds an iteration.

    VENV/bin/python bench/peers/crocoddyl_contacts.py [THREADS…]   # VENV as for crocoddyl_reach.py

The trot has the phases and weights of crocoddyl's own example of a quadrupedal gait, with 17 nodes a swing.
The last node has the cost of the state alone. Both start at rest in all nodes and without torques.
"""

import pathlib
import statistics
import sys
import time

import crocoddyl
import numpy as np
import pinocchio

ROBOTS = pathlib.Path(__file__).resolve().parents[2] / "robots"
WORLD = pinocchio.LOCAL_WORLD_ALIGNED
GAINS = np.array([0.0, 50.0])


class Standing:
    """A robot with a floating base that stands on its feet, at height 0."""

    def __init__(self, file, joints, feet, step):
        self.model = pinocchio.buildModelFromUrdf(str(ROBOTS / file), pinocchio.JointModelFreeFlyer())
        self.data = self.model.createData()
        q = pinocchio.neutral(self.model)
        q[7:] = np.resize(joints, self.model.nq - 7)
        self.feet = [self.model.getFrameId(name) for name in feet]
        pinocchio.framesForwardKinematics(self.model, self.data, q)
        q[2] -= self.data.oMf[self.feet[0]].translation[2]
        pinocchio.framesForwardKinematics(self.model, self.data, q)
        self.places = [self.data.oMf[foot].translation.copy() for foot in self.feet]
        self.q0, self.x0 = q, np.r_[q, np.zeros(self.model.nv)]
        self.state = crocoddyl.StateMultibody(self.model)
        self.actuation = crocoddyl.ActuationModelFloatingBase(self.state)
        self.step = step
        self.kept = []

    def track(self, costs, frame, target, weight, nu):
        residual = crocoddyl.ResidualModelFrameTranslation(self.state, frame, np.asarray(target), nu)
        costs.addCost(f"track {frame}", crocoddyl.CostModelResidual(self.state, residual), weight)

    def state_cost(self, costs, weight, parts, nu):
        joints = self.model.nv - 6
        place, rotation, joint, base_speed, speed = parts
        w = np.array([place] * 3 + [rotation] * 3 + [joint] * joints + [base_speed] * 6 + [speed] * joints)
        activation = crocoddyl.ActivationModelWeightedQuad(w**2)
        residual = crocoddyl.ResidualModelState(self.state, self.x0, nu)
        costs.addCost("x", crocoddyl.CostModelResidual(self.state, activation, residual), weight)

    def effort(self, costs, weight):
        residual = crocoddyl.ResidualModelControl(self.state, self.actuation.nu)
        costs.addCost("u", crocoddyl.CostModelResidual(self.state, residual), weight)

    def bounds(self, costs, weight):
        free = np.full(6, np.inf)
        high = np.r_[free, self.model.upperPositionLimit[7:], free, self.model.upperVelocityLimit[6:]]
        low = -np.r_[free, -self.model.lowerPositionLimit[7:], free, self.model.upperVelocityLimit[6:]]
        activation = crocoddyl.ActivationModelQuadraticBarrier(crocoddyl.ActivationBounds(low, high))
        residual = crocoddyl.ResidualModelState(self.state, self.actuation.nu)
        costs.addCost("bounds", crocoddyl.CostModelResidual(self.state, activation, residual), weight)

    def held(self, feet, flat, costs, step=None):
        contacts = crocoddyl.ContactModelMultiple(self.state, self.actuation.nu)
        for foot in feet:
            frame, place = self.feet[foot], self.places[foot]
            if flat:
                pose = pinocchio.SE3(np.eye(3), place)
                one = crocoddyl.ContactModel6D(self.state, frame, pose, WORLD, self.actuation.nu, GAINS)
            else:
                one = crocoddyl.ContactModel3D(self.state, frame, place, WORLD, self.actuation.nu, GAINS)
            contacts.addContact(f"contact {frame}", one)
        dynamics = crocoddyl.DifferentialActionModelContactFwdDynamics(
            self.state, self.actuation, contacts, costs, 0.0, True
        )
        return crocoddyl.IntegratedActionModelEuler(dynamics, self.step if step is None else step)

    def costs(self):
        return crocoddyl.CostModelSum(self.state, self.actuation.nu)

    def phase(self, feet, com=None, swings=()):
        costs, nu = self.costs(), self.actuation.nu
        if com is not None:
            residual = crocoddyl.ResidualModelCoMPosition(self.state, np.asarray(com), nu)
            costs.addCost("com", crocoddyl.CostModelResidual(self.state, residual), 1e6)
        cone = crocoddyl.FrictionCone(np.eye(3), 0.7, 4, False)
        for foot in feet:
            residual = crocoddyl.ResidualModelContactFrictionCone(self.state, self.feet[foot], cone, nu, True)
            barrier = crocoddyl.ActivationModelQuadraticBarrier(crocoddyl.ActivationBounds(cone.lb, cone.ub))
            costs.addCost(f"cone {foot}", crocoddyl.CostModelResidual(self.state, barrier, residual), 1e1)
        for frame, target in swings:
            self.track(costs, frame, target, 1e6, nu)
        self.state_cost(costs, 1e1, [0, 500, 0.01, 10, 1], nu)
        self.effort(costs, 1e-1)
        self.bounds(costs, 1e3)
        return self.held(feet, False, costs)

    def impact(self, feet, targets):
        impulses = crocoddyl.ImpulseModelMultiple(self.state)
        costs = crocoddyl.CostModelSum(self.state, 0)
        for foot, (frame, target) in zip(feet, targets, strict=True):
            impulses.addImpulse(f"impact {foot}", crocoddyl.ImpulseModel3D(self.state, self.feet[foot], WORLD))
            self.track(costs, frame, target, 1e7, 0)
        self.state_cost(costs, 1e1, [1, 1, 10, 10, 10], 0)
        return crocoddyl.ActionModelImpulseFwdDynamics(self.state, impulses, costs)


def trot():
    names = ["front_left_foot", "front_right_foot", "hind_left_foot", "hind_right_foot"]
    robot = Standing("quadruped.urdf", [0.0, 0.7, -1.4], names, 0.01)
    swing_nodes, height = 17, 0.1
    com = np.mean(robot.places, axis=0)
    com[2] = pinocchio.centerOfMass(robot.model, robot.data, robot.q0)[2]
    nodes = []
    for swing, support, length in [([1, 2], [0, 3], 0.075), ([0, 3], [1, 2], 0.15)]:
        nodes += [robot.phase([0, 1, 2, 3])] * 2
        half = swing_nodes / 2
        for k in range(swing_nodes):
            forward = length * (k + 1) / swing_nodes
            up = height * k / half if k < half else height * (1 - (k - half) / half)
            targets = [(robot.feet[f], robot.places[f] + [forward, 0, up]) for f in swing]
            nodes.append(robot.phase(support, com + [0.5 * forward, 0, 0], targets))
        nodes.append(robot.impact(swing, targets))
        com = com + [0.5 * length, 0, 0]
        for foot in swing:
            robot.places[foot] = robot.places[foot] + [length, 0, 0]
    costs = robot.costs()
    robot.state_cost(costs, 1e1, [0, 500, 0.01, 10, 1], robot.actuation.nu)
    last = robot.held([0, 1, 2, 3], False, costs, 0.0)
    return crocoddyl.ShootingProblem(robot.x0, nodes, last), robot


def humanoid():
    robot = Standing("humanoid.urdf", [0.0], ["left_foot", "right_foot"], 0.02)
    hand, nu = robot.model.getFrameId("right_hand"), robot.actuation.nu
    target = robot.data.oMf[hand].translation + [0.3, 0.1, 0.4]
    running, terminal = robot.costs(), robot.costs()
    robot.track(running, hand, target, 1e2, nu)
    robot.state_cost(running, 1.0, [0, 10, 0.3, 3, 0.3], nu)
    robot.effort(running, 1e-3)
    robot.track(terminal, hand, target, 1e4, nu)
    robot.state_cost(terminal, 1.0, [0, 10, 0.3, 3, 1], nu)
    node, last = robot.held([0, 1], True, running), robot.held([0, 1], True, terminal, 0.0)
    return crocoddyl.ShootingProblem(robot.x0, [node] * 40, last), robot


def measure(name, make, threads, repetitions=3):
    shooting, robot = make()
    shooting.nthreads = threads
    solver = crocoddyl.SolverFDDP(shooting)
    states = [robot.x0] * (shooting.T + 1)
    controls = [np.zeros(node.nu) for node in shooting.runningModels]
    log = crocoddyl.CallbackLogger()
    solver.setCallbacks([log])
    solver.solve(states, controls, 100, False)
    costs = list(log.costs)
    solver.setCallbacks([])
    times = []
    for _ in range(repetitions):
        start = time.perf_counter()
        solver.solve(states, controls, 100, False)
        times.append(time.perf_counter() - start)
    spent = 1e3 * statistics.median(times)
    print(
        f"crocoddyl {crocoddyl.__version__}, {name}, {threads} threads: cost {solver.cost:.6f}, "
        f"{solver.iter} iterations, {spent:.3f} ms, {spent / max(solver.iter, 1):.3f} ms an iteration"
    )
    if threads == 1:
        print("  costs:", " ".join(f"{cost:.5g}" for cost in costs))


if __name__ == "__main__":
    for count in [int(word) for word in sys.argv[1:]] or [1, 2]:
        measure("trot", trot, count)
        measure("humanoid", humanoid, count)
