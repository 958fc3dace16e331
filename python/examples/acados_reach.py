"""Control an arm with acados and the library's generated dynamics, also after a blow.

    python python/examples/acados_reach.py [--short] [--figure acados_reach.png]

A Panda moves from rest to rest in 0.4 s with the least ∫ Σ (v/limit)² + (τ/limit)² dt, within the limits of
torque and speed. The SQP method of acados solves this problem, with generated code for forward dynamics and
their Jacobian. IPOPT solves the same problem for comparison. The library simulates the torques with a method
of order nine.

Then a controller with a horizon of 0.4 s does one iteration (SQP_RTI) every 20 ms. It controls a simulated
arm that is struck while it stands at its goal.

Needs acados (0.6) with its Python interface and ACADOS_SOURCE_DIR, CasADi, make and a C compiler.
"""

import argparse
import subprocess
import tempfile
from pathlib import Path
from typing import Any, NamedTuple

import numpy as np
from numpy.typing import NDArray

import robot_dynamics as rd

Array = NDArray[np.float64]

START = np.array([0.0, 0.3, 0.0, -1.8, 0.0, 2.0, 0.6])
GOAL = np.array([0.8, 0.6, -0.2, -1.4, 0.3, 2.2, 0.0])
REST = np.zeros(7)
TIME, PIECES, STEPS = 0.4, 20, 4  # [s], number of pieces, and integrator steps in each
BLOW = np.array([0.0, 3.0, 0.0])  # on the flange [N s]


class Solution(NamedTuple):
    """Solution of a solver: states at the ends of pieces, torques in the pieces, and their cost."""

    x: Array
    tau: Array
    cost: float
    iterations: int


def compiled(robot: rd.Robot, folder: Path) -> Any:
    """Forward dynamics for CasADi. Solvers link to libpanda.a in the same folder."""
    import casadi as ca

    robot.generate("casadi", ["forward_dynamics"], folder, name="panda")
    subprocess.run(["make", "-s", "-C", folder, "panda.so", "libpanda.a"], check=True)
    return ca.external("panda_forward_dynamics", str(folder / "panda.so"))


def problem(robot: rd.Robot, dynamics: Any, folder: Path, name: str) -> Any:
    """Optimal control problem of the arm with its limits, without a cost."""
    import casadi as ca
    from acados_template import AcadosModel, AcadosOcp

    q, v, tau = (ca.MX.sym(symbol, 7) for symbol in ("q", "v", "tau"))
    ocp = AcadosOcp()
    ocp.model = AcadosModel()
    ocp.model.name = name
    ocp.model.x, ocp.model.u = ca.vertcat(q, v), tau
    ocp.model.f_expl_expr = ca.vertcat(v, dynamics(q, v, tau))
    torque, speed = robot.limits.effort, robot.limits.velocity
    ocp.constraints.x0 = np.append(START, REST)
    ocp.constraints.idxbx, ocp.constraints.lbx, ocp.constraints.ubx = np.arange(7, 14), -speed, speed
    ocp.constraints.idxbu, ocp.constraints.lbu, ocp.constraints.ubu = np.arange(7), -torque, torque
    ocp.solver_options.N_horizon, ocp.solver_options.tf = PIECES, TIME
    ocp.solver_options.integrator_type = "ERK"
    ocp.solver_options.sim_method_num_steps = STEPS
    ocp.solver_options.hessian_approx = "GAUSS_NEWTON"
    ocp.code_gen_options.model_external_shared_lib_dir = str(folder)
    ocp.code_gen_options.model_external_shared_lib_name = "panda"
    ocp.code_gen_options.code_export_directory = str(folder / name)
    return ocp


def reach(robot: rd.Robot, dynamics: Any, folder: Path) -> Solution:
    """Motion from rest to rest, by acados."""
    from acados_template import AcadosOcpSolver

    ocp = problem(robot, dynamics, folder, "reach")
    scale = np.append(robot.limits.velocity, robot.limits.effort)
    ocp.cost.cost_type = "LINEAR_LS"
    ocp.cost.Vx, ocp.cost.Vu = np.eye(14, 14, 7), np.eye(14, 7, -7)
    ocp.cost.W, ocp.cost.yref = 2 * np.diag(1 / scale**2), np.zeros(14)
    ocp.constraints.idxbx_e = np.arange(14)
    ocp.constraints.lbx_e = ocp.constraints.ubx_e = np.append(GOAL, REST)
    ocp.solver_options.nlp_solver_type = "SQP"
    ocp.solver_options.tol = 1e-8
    ocp.solver_options.qp_tol = 1e-10
    solver = AcadosOcpSolver(ocp, verbose=False)
    for k in range(PIECES + 1):
        solver.set(k, "x", np.append(START + k / PIECES * (GOAL - START), REST))
    status = solver.solve()
    if status != 0:
        raise RuntimeError(f"acados: status {status}")
    x = np.array([solver.get(k, "x") for k in range(PIECES + 1)])
    tau = np.array([solver.get(k, "u") for k in range(PIECES)])
    return Solution(x, tau, float(solver.get_cost()), int(solver.get_stats("sqp_iter")))


def reach_by_ipopt(robot: rd.Robot, dynamics: Any) -> Solution:
    """The same problem for IPOPT: multiple shooting, Runge–Kutta steps, Gauss–Newton Hessian."""
    import casadi as ca

    torque, speed = robot.limits.effort, robot.limits.velocity
    state, tau = ca.MX.sym("x", 14), ca.MX.sym("tau", 7)
    rate = ca.Function("rate", [state, tau], [ca.vertcat(state[7:], dynamics(state[:7], state[7:], tau))])
    end, h = state, TIME / PIECES / STEPS
    for _ in range(STEPS):
        k1 = rate(end, tau)
        k2 = rate(end + h / 2 * k1, tau)
        k3 = rate(end + h / 2 * k2, tau)
        k4 = rate(end + h * k3, tau)
        end = end + h / 6 * (k1 + 2 * k2 + 2 * k3 + k4)
    piece = ca.Function("piece", [state, tau], [end]).map(PIECES)
    xs, taus = ca.MX.sym("xs", 14, PIECES + 1), ca.MX.sym("taus", 7, PIECES)
    r = ca.vertcat(ca.vec(xs[7:, :-1] / speed), ca.vec(taus / torque))
    gaps = ca.vec(xs[:, 1:] - piece(xs[:, :-1], taus))
    z, f = ca.vertcat(ca.vec(xs), ca.vec(taus)), TIME / PIECES * ca.sumsqr(r)
    jacobian, nothing = ca.jacobian(r, z), ca.MX.sym("p", 0)
    by_loss, by_gaps = ca.MX.sym("lam_f"), ca.MX.sym("lam_g", gaps.numel())
    gauss_newton = 2 * TIME / PIECES * by_loss * ca.triu(jacobian.T @ jacobian)
    hessian = ca.Function("H", [z, nothing, by_loss, by_gaps], [gauss_newton])
    options = {"hess_lag": hessian, "ipopt.tol": 1e-10, "ipopt.print_level": 0, "ipopt.sb": "yes", "print_time": 0}
    solver = ca.nlpsol("solver", "ipopt", {"x": z, "f": f, "g": gaps}, options)
    first, last = np.append(START, REST), np.append(GOAL, REST)
    bound = np.append(np.full(7, np.inf), speed)
    # As in acados the first and last states are given, and the speeds between them are limited.
    lower = np.concatenate([first, np.tile(-bound, PIECES - 1), last, np.tile(-torque, PIECES)])
    upper = np.concatenate([first, np.tile(bound, PIECES - 1), last, np.tile(torque, PIECES)])
    guess = np.append(np.linspace(first, last, PIECES + 1).ravel(), np.zeros(7 * PIECES))
    found = solver(x0=guess, lbx=lower, ubx=upper, lbg=0.0, ubg=0.0)
    stats, values = solver.stats(), np.array(found["x"]).ravel()
    if not stats["success"]:
        raise RuntimeError(f"IPOPT: {stats['return_status']}")
    x, torques = values[: 14 * (PIECES + 1)].reshape(-1, 14), values[14 * (PIECES + 1) :].reshape(-1, 7)
    return Solution(x, torques, float(found["f"]), int(stats["iter_count"]))


def controller(robot: rd.Robot, dynamics: Any, folder: Path) -> Any:
    """Solver of one iteration at a time that steers to rest at the goal."""
    from acados_template import AcadosOcpSolver

    ocp = problem(robot, dynamics, folder, "follow")
    state = np.append(np.full(7, 10.0), np.full(7, 1.0))
    ocp.cost.cost_type, ocp.cost.cost_type_e = "LINEAR_LS", "LINEAR_LS"
    ocp.cost.Vx, ocp.cost.Vu = np.eye(21, 14), np.eye(21, 7, -14)
    ocp.cost.W = np.diag(np.append(state, 1 / robot.limits.effort**2))
    ocp.cost.yref = np.concatenate([GOAL, REST, robot.gravity(GOAL)])
    ocp.cost.Vx_e, ocp.cost.W_e, ocp.cost.yref_e = np.eye(14), np.diag(state), np.append(GOAL, REST)
    ocp.solver_options.nlp_solver_type = "SQP_RTI"
    return AcadosOcpSolver(ocp, verbose=False)


def follow(robot: rd.Robot, solver: Any, duration: float) -> tuple[Array, Array, Array]:
    """Distances from the goal [rad], torques and computing times [s] of each period.

    The blow acts at half the duration.
    """
    period = TIME / PIECES
    q, v = START.copy(), REST.copy()
    for k in range(PIECES + 1):
        solver.set(k, "x", np.append(q, v))
    for k in range(PIECES):
        solver.set(k, "u", robot.gravity(q))
    count = round(duration / period)
    away, torques, times = [], [], []
    for k in range(count):
        if k == count // 2:
            jacobian = robot.frame_jacobian(q, "panda_link8")[:3]
            v = v + np.linalg.solve(robot.mass_matrix(q), jacobian.T @ BLOW)
        tau = solver.solve_for_x0(np.append(q, v), fail_on_nonzero_status=True)
        times.append(float(solver.get_stats("time_tot")))
        motion = robot.simulate(q, v, tau, duration=period, dt=period, integrator="adaptive")
        q, v = motion.q[-1], motion.v[-1]
        away.append(float(np.abs(q - GOAL).max()))
        torques.append(tau)
    return np.array(away), np.array(torques), np.array(times)


def main(arguments: list[str] | None = None) -> dict[str, Any]:
    parser = argparse.ArgumentParser(description=__doc__.splitlines()[0])
    parser.add_argument("--short", action="store_true", help="control for a shorter time")
    parser.add_argument("--figure", default="acados_reach.png")
    options = parser.parse_args(arguments)

    robot = rd.example("panda")
    torque, speed = robot.limits.effort, robot.limits.velocity
    with tempfile.TemporaryDirectory() as name:
        folder = Path(name).resolve()
        dynamics = compiled(robot, folder)
        found = reach(robot, dynamics, folder)
        other = reach_by_ipopt(robot, dynamics)
        away, torques, times = follow(robot, controller(robot, dynamics, folder), 1.6 if options.short else 4.0)

    miss = float(np.abs(found.x[-1] - np.append(GOAL, REST)).max())
    use = float(np.abs(found.x[:, 7:] / speed).max())
    print(f"acados: {found.cost:.8f} s after {found.iterations} iterations, speeds up to {use:.1%} of their limits")
    apart = float(np.abs((found.tau - other.tau) / torque).max())
    print(f"IPOPT:  {other.cost:.8f} s after {other.iterations} iterations, torques apart by {apart:.0e} of theirs")
    motion = robot.simulate(
        START, tau=found.tau, duration=TIME, dt=TIME / PIECES, integrator="adaptive", tolerance=1e-12
    )
    off = float(np.abs(np.hstack([motion.q, motion.v]) - found.x).max())
    print(f"it ends {miss:.0e} from the goal; an arm simulated under its torques stays within {off:.0e} of it")
    half = len(away) // 2
    print(f"controller: {away[half - 1]:.0e} rad from the goal before the blow, {away[half:].max():.2f} rad after it")
    print(f"at the end {away[-1]:.0e} rad; an iteration takes {1e3 * np.median(times):.2f} ms (median)")
    figure(options.figure, found, away, torques / torque, robot)
    agreement = {"costs": (found.cost, other.cost), "apart": apart, "off": off, "miss": miss, "use": use}
    return {**agreement, "away": away, "torques": torques / torque}


def figure(path: str, found: Solution, away: Array, torques: Array, robot: rd.Robot) -> None:
    import matplotlib

    matplotlib.use("Agg")
    from matplotlib import pyplot

    drawing, axes = pyplot.subplots(1, 3, figsize=(13, 4), layout="constrained")
    names = [f"joint {k}" for k in range(1, 8)]
    period = TIME / PIECES
    axes[0].plot(period * np.arange(PIECES + 1), found.x[:, 7:] / robot.limits.velocity, label=names)
    axes[0].set(title="least cost", xlabel="t [s]", ylabel="speed / limit")
    axes[0].legend(fontsize="small")
    times = period * np.arange(1, len(away) + 1)
    axes[1].semilogy(times, away)
    axes[1].set(title="under control, struck at half the time", xlabel="t [s]", ylabel="from the goal [rad]")
    axes[2].plot(times, torques)
    axes[2].set(title="under control", xlabel="t [s]", ylabel="torque / limit")
    for axis in axes:
        axis.grid(alpha=0.3)
    drawing.savefig(path, dpi=120)
    pyplot.close(drawing)
    print(f"figure: {path}")


if __name__ == "__main__":
    main()
