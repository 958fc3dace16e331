"""The reach of the Panda of `measure_optimal` by crocoddyl: cost, iterations, milliseconds an iteration.

    python3 -m venv VENV && VENV/bin/pip install crocoddyl==3.2.1 "pin<4.1"  # with pin 4.1.0 frame costs crash
    VENV/bin/python bench/peers/crocoddyl_reach.py [NODES…]

The problem: 20 ms steps of semi-implicit Euler; running cost 0.02·½(|x − x₀|² with 1e-2 for q and 1e-1 for v,
|u − g(q₀)|² with 1e-3); terminal cost ½(1e4 |p − p*|² + |x − x₀|² with 1e-2 and 10).
"""

import pathlib
import statistics
import sys
import time

import crocoddyl
import numpy as np
import pinocchio

ROBOT = pathlib.Path(__file__).resolve().parents[2] / "robots" / "panda.urdf"
STEP = 0.02


def weighted(weights):
    return crocoddyl.ActivationModelWeightedQuad(np.asarray(weights))


def problem(nodes, bounded):
    model = pinocchio.buildModelFromUrdf(str(ROBOT))
    # Armature is the motors' inertia, which the URDF states in our extension only; it is zero here.
    state = crocoddyl.StateMultibody(model)
    actuation = crocoddyl.ActuationModelFull(state)
    q0 = np.array([0, 0.3, 0, -1.8, 0, 2.0, 0.6])
    x0 = np.r_[q0, np.zeros(7)]
    hold = pinocchio.rnea(model, model.createData(), q0, np.zeros(7), np.zeros(7))
    hand = model.getFrameId("panda_link8")
    running, terminal = crocoddyl.CostModelSum(state), crocoddyl.CostModelSum(state)
    difference = crocoddyl.ResidualModelState(state, x0, 7)
    running.addCost("x", crocoddyl.CostModelResidual(state, weighted([1e-2] * 7 + [1e-1] * 7), difference), 1.0)
    effort = crocoddyl.ResidualModelControl(state, hold)
    running.addCost("u", crocoddyl.CostModelResidual(state, effort), 1e-3)
    terminal.addCost("x", crocoddyl.CostModelResidual(state, weighted([1e-2] * 7 + [10.0] * 7), difference), 1.0)
    goal = crocoddyl.ResidualModelFrameTranslation(state, hand, np.array([0.35, 0.45, 0.25]), 7)
    terminal.addCost("p", crocoddyl.CostModelResidual(state, goal), 1e4)
    dynamics = crocoddyl.DifferentialActionModelFreeFwdDynamics
    node = crocoddyl.IntegratedActionModelEuler(dynamics(state, actuation, running), STEP)
    last = crocoddyl.IntegratedActionModelEuler(dynamics(state, actuation, terminal), 0.0)
    if bounded:
        limits = np.array([87.0, 87, 87, 87, 12, 12, 12])
        node.u_lb, node.u_ub = -limits, limits
    shooting = crocoddyl.ShootingProblem(x0, [node] * nodes, last)
    # crocoddyl does not keep the model alive.
    return shooting, hold, (model, state, actuation)


def measure(nodes, bounded, repetitions=20):
    shooting, hold, _alive = problem(nodes, bounded)
    shooting.nthreads = 1
    solver = (crocoddyl.SolverBoxFDDP if bounded else crocoddyl.SolverFDDP)(shooting)
    controls = [hold] * nodes
    states = shooting.rollout(controls)
    times = []
    for _ in range(repetitions):
        start = time.perf_counter()
        solver.solve(states, controls, 100, True)
        times.append(time.perf_counter() - start)
    spent = 1e3 * statistics.median(times)
    kind = "bounded" if bounded else "free"
    print(
        f"crocoddyl {crocoddyl.__version__}, {nodes} nodes, {kind}: cost {solver.cost:.6f}, "
        f"{solver.iter} iterations, {spent:.3f} ms, {spent / max(solver.iter, 1):.3f} ms an iteration"
    )


if __name__ == "__main__":
    for count in [int(word) for word in sys.argv[1:]] or [20, 50]:
        measure(count, False)
        measure(count, True)
