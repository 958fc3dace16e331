"""Find the cheapest motion of an arm to a point, with CasADi and IPOPT.

    python python/examples/reach.py [--short] [--figure reach.png]

A Panda moves its flange to a point, from rest to rest in one second. Inverse kinematics gives the final
configuration. The cost is ∫ Σ (τ/limit)² + (a/150)² dt, with piecewise constant accelerations a. The torques
τ(q, v, a) and the joints stay within their limits. IPOPT solves the problem with a Gauss–Newton Hessian.
`robot_dynamics.casadi` generates, compiles and loads the torques with their Jacobian.

A polynomial of degree five in time is the baseline. A simulated arm then tracks the solution with computed
torques, in small steps.

Needs CasADi (pip install casadi) and a C compiler.
"""

import argparse
from typing import Any

import numpy as np
from numpy.typing import NDArray

import robot_dynamics as rd
from robot_dynamics.casadi import external

Array = NDArray[np.float64]

TIME = 1.0  # [s]
START = np.array([0.0, 0.3, 0.0, -1.8, 0.0, 2.0, 0.6])
GOAL = np.array([0.35, 0.45, 0.25])  # [m]
FLANGE = "panda_link8"
PRICE = 1.0 / 150.0  # weight of accelerations [s²/rad]


def least_effort(robot: rd.Robot, goal: Array, pieces: int) -> tuple[Array, float, int]:
    """Accelerations (pieces, 7) with the least cost, the cost, and the number of iterations."""
    import casadi as ca

    torque = external(robot, "inverse_dynamics")
    limits, n, h = robot.limits, robot.nv, TIME / pieces
    x = ca.MX.sym("a", n * pieces)
    q, v, efforts, places = ca.DM(START), ca.DM.zeros(n), [], []
    for a in ca.vertsplit(x, n):
        # At the middle of the piece.
        tau = torque(q + h / 2 * v + h**2 / 8 * a, v + h / 2 * a, a)
        efforts.append(tau / limits.effort)
        q, v = q + h * v + h**2 / 2 * a, v + h * a
        places.append(q)
    r = ca.vertcat(*efforts, PRICE * x)
    at_end = ca.vertcat(v, q - goal)
    limited = ca.vertcat(*efforts, *places, at_end)
    jacobian, nothing = ca.jacobian(r, x), ca.MX.sym("p", 0)
    by_loss, by_limited = ca.MX.sym("lam_f"), ca.MX.sym("lam_g", limited.numel())
    hessian = ca.Function("H", [x, nothing, by_loss, by_limited], [2 * h * by_loss * ca.triu(jacobian.T @ jacobian)])
    options = {"hess_lag": hessian, "ipopt.print_level": 0, "ipopt.sb": "yes", "print_time": 0}
    solver = ca.nlpsol("solver", "ipopt", {"x": x, "f": h * ca.sumsqr(r), "g": limited}, options)
    ends = np.zeros(at_end.numel())
    lower = np.concatenate([-np.ones(n * pieces), np.tile(limits.lower, pieces), ends])
    upper = np.concatenate([np.ones(n * pieces), np.tile(limits.upper, pieces), ends])
    found: Any = solver(x0=0.0, lbg=lower, ubg=upper)
    stats = solver.stats()
    if not stats["success"]:
        raise RuntimeError(f"IPOPT: {stats['return_status']}")
    return np.array(found["x"]).reshape(pieces, n), float(found["f"]), int(stats["iter_count"])


def motion_of(accelerations: Array, t: float) -> tuple[Array, Array, Array]:
    """q, v and a at a time, for accelerations held over equal pieces."""
    pieces = len(accelerations)
    h = TIME / pieces
    last = min(int(t / h), pieces - 1)
    q, v = START.copy(), np.zeros_like(START)
    for a in accelerations[:last]:
        q, v = q + h * v + h**2 / 2 * a, v + h * a
    a, rest = accelerations[last], min(t, TIME) - last * h
    if t >= TIME:
        return q + rest * v + rest**2 / 2 * a, v + rest * a, np.zeros_like(a)
    return q + rest * v + rest**2 / 2 * a, v + rest * a, a


def quintic(goal: Array, times: Array) -> tuple[Array, Array, Array]:
    """q, v, a (times, 7) of the polynomial of degree five in time."""
    s, d = times[:, np.newaxis] / TIME, goal - START
    q = START + d * (10 * s**3 - 15 * s**4 + 6 * s**5)
    v = d * (30 * s**2 - 60 * s**3 + 30 * s**4) / TIME
    return q, v, d * (60 * s - 180 * s**2 + 120 * s**3) / TIME**2


def main(arguments: list[str] | None = None) -> dict[str, Any]:
    parser = argparse.ArgumentParser(description=__doc__.splitlines()[0])
    parser.add_argument("--short", action="store_true", help="use fewer pieces")
    parser.add_argument("--figure", default="reach.png")
    options = parser.parse_args(arguments)

    robot = rd.example("panda")
    limit = robot.limits.effort
    goal = robot.inverse_kinematics(FLANGE, GOAL, START).q
    accelerations, cost, iterations = least_effort(robot, goal, 10 if options.short else 20)
    times = (np.arange(1000) + 0.5) * TIME / 1000
    q, v, a = (np.array(each) for each in zip(*(motion_of(accelerations, t) for t in times), strict=True))
    tau = robot.inverse_dynamics(q, v, a)
    plain = quintic(goal, times)
    held = robot.inverse_dynamics(*plain)
    costs = [
        float((((force / limit) ** 2).sum(axis=1) + PRICE**2 * (rate**2).sum(axis=1)).mean() * TIME)
        for force, rate in ((tau, a), (held, plain[2]))
    ]
    print(f"least cost {cost:.4f} s after {iterations} iterations; {costs[0]:.4f} s on 1000 points instead of the middles of the pieces")
    print(f"the polynomial costs {costs[1]:.4f} s; largest torque {100 * np.abs(tau / limit).max():.0f} % of its limit")

    follow = rd.ComputedTorque(robot, lambda t: motion_of(accelerations, t), np.full(7, 400.0), np.full(7, 40.0))
    motion = robot.simulate(START, tau=follow, duration=TIME, dt=1e-3)
    miss = float(np.linalg.norm(robot.frame_pose(motion.q[-1], FLANGE)[:3, 3] - GOAL))
    speed = float(np.abs(motion.v[-1]).max())
    print(f"the simulated arm ends {1e3 * miss:.2f} mm from the goal, its fastest joint at {speed:.1e} rad/s")
    figure(options.figure, times, tau / limit, held / limit)
    return {"cost": cost, "costs": costs, "miss": miss, "speed": speed, "use": np.abs(tau / limit).max()}


def figure(path: str, times: Array, found: Array, plain: Array) -> None:
    import matplotlib

    matplotlib.use("Agg")
    from matplotlib import pyplot

    drawing, axes = pyplot.subplots(1, 2, figsize=(10, 4), sharey=True, layout="constrained")
    for axis, torques, title in zip(axes, (found, plain), ("least cost", "polynomial in time"), strict=True):
        axis.plot(times, torques, label=[f"joint {k}" for k in range(1, 8)])
        axis.set(title=title, xlabel="t [s]")
        axis.grid(alpha=0.3)
    axes[0].set_ylabel("torque / limit")
    axes[1].legend(fontsize="small", loc="center left", bbox_to_anchor=(1.0, 0.5))
    drawing.savefig(path, dpi=120)
    pyplot.close(drawing)
    print(f"figure: {path}")


if __name__ == "__main__":
    main()
