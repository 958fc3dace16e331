"""Swing up an arm whose motors are too weak to lift it, by gradient descent through a rollout.

    python python/examples/swing_up.py [--short] [--figure swing_up.png]

Two rods of 1 m hang down. Holding them horizontally takes 24.5 N·m at the shoulder, but the motors give only
8 and 4 N·m. The program optimises torques τ = limit · tanh u over 2.4 s from many random starts at once. One
call rolls out all of them. Another computes the gradients of their losses by u, by adjoints in O(n) a step.
Adam updates u.

At the top a linear-quadratic regulator holds the arm within the same limits. It uses the derivatives of one
step.
"""

import argparse
from typing import Any

import numpy as np
from numpy.typing import NDArray

import robot_dynamics as rd

Array = NDArray[np.float64]

STEP, STEPS, HOLD = 0.02, 120, 75  # [s]
LIMIT = np.array([8.0, 4.0])  # [N·m]
HANGING, UPRIGHT = np.array([-np.pi / 2, 0.0]), np.array([np.pi / 2, 0.0])
PRICE = 1e-4
OPTIONS: dict[str, Any] = {"steps": STEPS, "dt": STEP, "integrator": "rk4"}


def loss(robot: Any, u: Array) -> tuple[Array, Array]:
    """Losses of torques limit · tanh u, for u (starts, steps, 2), and their gradients by u.

    The loss is 1 − cos of the final angles from upright, plus a small weight on the final v² and on the
    torques.
    """
    tau = LIMIT * np.tanh(u)
    end = robot.rollout(HANGING, np.zeros(2), tau, **OPTIONS)
    off = end.q - UPRIGHT
    value = (1.0 - np.cos(off)).sum(axis=-1) + 0.05 * (end.v**2).sum(axis=-1) + PRICE * (tau**2).mean(axis=(1, 2))
    back = robot.rollout_pullback(
        HANGING, np.zeros(2), tau, by_position=np.sin(off), by_velocity=0.1 * end.v, **OPTIONS
    )
    assert back.by_force is not None
    gradient = back.by_force + 2.0 * PRICE * tau / tau[0].size
    return value, gradient * LIMIT * (1.0 - np.tanh(u) ** 2)


def descend(robot: rd.Robot, u: Array, rounds: int, rate: float = 0.1) -> tuple[Array, Array]:
    """u after `rounds` steps of Adam, and the losses of each round (rounds, starts)."""
    mean, square, losses = np.zeros_like(u), np.zeros_like(u), []
    for k in range(1, rounds + 1):
        value, gradient = loss(robot, u)
        losses.append(value)
        # The gradient of a chaotic motion can be large: each is clipped to length 1.
        gradient = gradient / np.maximum(np.linalg.norm(gradient, axis=(1, 2), keepdims=True), 1.0)
        mean, square = 0.9 * mean + 0.1 * gradient, 0.99 * square + 0.01 * gradient**2
        eased = rate * (1.0 + np.cos(np.pi * k / rounds)) / 2.0
        u = u - eased * (mean / (1 - 0.9**k)) / (np.sqrt(square / (1 - 0.99**k)) + 1e-8)
    return u, np.array(losses)


def held(robot: rd.Robot, q: Array, v: Array) -> tuple[Array, Array, Array]:
    """Motion at the top under a linear-quadratic regulator: q, v, tau (steps, 2)."""
    gravity = robot.gravity(UPRIGHT)
    linear = robot.linearize_step(UPRIGHT, np.zeros(2), gravity, dt=STEP)
    law = rd.dlqr(linear.by_state, linear.by_force, np.diag([10.0, 10.0, 1.0, 1.0]), 0.1 * np.eye(2))
    states = []
    for _ in range(HOLD):
        off = np.concatenate([np.angle(np.exp(1j * (q - UPRIGHT))), v])
        tau = np.clip(gravity - law.gain @ off, -LIMIT, LIMIT)
        q, v = robot.step(q, v, tau, dt=STEP)
        states.append((q, v, tau))
    found = tuple(np.array(column) for column in zip(*states, strict=True))
    return found[0], found[1], found[2]


def main(arguments: list[str] | None = None) -> dict[str, Any]:
    """Print the results, draw the figure, and return the results."""
    parser = argparse.ArgumentParser(description=__doc__.splitlines()[0])
    parser.add_argument("--short", action="store_true", help="use fewer starts and rounds")
    parser.add_argument("--figure", default="swing_up.png")
    options = parser.parse_args(arguments)
    robot = rd.example("two_r")
    starts, rounds = (8, 150) if options.short else (32, 600)
    random = np.random.default_rng(1)
    # Smooth torques: each is the sum of three sines of random phase and size.
    t = np.arange(STEPS) * STEP
    phase, size, speed = (
        random.uniform(0, 6, (starts, 2, 3)),
        random.normal(0, 0.7, (starts, 2, 3)),
        np.array([2.0, 4.0, 6.0]),
    )
    u = np.einsum("sjk,sjkt->stj", size, np.sin(np.multiply.outer(speed, t) + phase[..., np.newaxis]))

    # Compare the gradient with a difference of losses.
    along = random.normal(size=u.shape)
    _, gradient = loss(robot, u)
    ahead, behind = (loss(robot, u + sign * 1e-6 * along)[0] for sign in (1, -1))
    difference = np.abs((gradient * along).sum(axis=(1, 2)) - (ahead - behind) / 2e-6) / np.abs(gradient * along).sum(
        axis=(1, 2)
    )
    u, losses = descend(robot, u, rounds)
    best = int(loss(robot, u)[0].argmin())
    tau = LIMIT * np.tanh(u[best])
    motion = robot.rollout(HANGING, np.zeros(2), tau, stride=1, **OPTIONS)
    q, v, push = held(robot, motion.q, motion.v)
    miss = np.abs(np.angle(np.exp(1j * (motion.q - UPRIGHT))))
    rest = np.abs(np.angle(np.exp(1j * (q[-1] - UPRIGHT)))).max()
    heavy = robot.gravity([0.0, 0.0])[0]
    print(f"{robot.name}: motors of {LIMIT[0]:g} and {LIMIT[1]:g} N·m; holding the arm horizontally takes {heavy:.1f}")
    print(f"  gradient minus difference of losses: at most {difference.max():.1e} of the terms")
    print(f"  {starts} starts, {rounds} rounds: least loss {losses[0].min():.3f} -> {losses[-1].min():.6f}")
    angles = " and ".join(f"{x:.2f}°" for x in np.rad2deg(miss))
    print(f"  after {STEPS * STEP:g} s: {angles} from upright, |v| {np.abs(motion.v).max():.3f} rad/s")
    print(f"  held for {HOLD * STEP:g} s more: {np.rad2deg(rest):.1e}° from upright")
    positions = np.concatenate([[HANGING], motion.q_trajectory, q])
    draw(options.figure, losses, best, positions, np.concatenate([tau, push]))
    return {"difference": difference.max(), "loss": losses[-1].min(), "miss": miss.max(), "rest": rest}


def draw(path: str, losses: Array, best: int, positions: Array, tau: Array) -> None:
    """Draw the figure."""
    import matplotlib

    matplotlib.use("Agg")
    from matplotlib import colormaps, pyplot

    figure, axes = pyplot.subplots(2, 2, figsize=(10.5, 7.2), layout="constrained")
    axis = axes[0, 0]
    axis.plot(losses, color="0.75", linewidth=0.7)
    axis.plot(losses[:, best], color="tab:blue", linewidth=1.5, label="the best start")
    axis.set(title="losses along the gradient", xlabel="round", ylabel="loss", yscale="log")
    axis.margins(x=0.0)
    axis.legend(fontsize="small")
    axis = axes[0, 1]
    count = STEPS + 1
    for k in [*range(0, count, 5), count - 1]:
        first, second = positions[k, 0], positions[k].sum()
        x, y = np.cumsum([0.0, np.cos(first), np.cos(second)]), np.cumsum([0.0, np.sin(first), np.sin(second)])
        axis.plot(x, y, "-", color=colormaps["viridis_r"](0.1 + 0.9 * k / count), linewidth=1.6, solid_capstyle="round")
    ends = positions[:count]
    tip = [np.cos(ends[:, 0]) + np.cos(ends.sum(axis=1)), np.sin(ends[:, 0]) + np.sin(ends.sum(axis=1))]
    axis.plot(*tip, color="0.5", linewidth=0.6)
    axis.set(title="the arm every 0.1 s, from light to dark", xlabel="x [m]", ylabel="z [m]", aspect="equal")
    t = np.arange(len(positions)) * STEP
    axis = axes[1, 0]
    for joint, name in enumerate(("shoulder", "elbow")):
        axis.plot(t, np.rad2deg(positions[:, joint]), label=name)
    axis.set(title="angles", xlabel="t [s]", ylabel="degrees")
    axis = axes[1, 1]
    for joint in range(2):
        (line,) = axis.step(t[:-1], tau[:, joint], where="post")
        for sign in (-1, 1):
            axis.axhline(sign * LIMIT[joint], color=line.get_color(), linewidth=0.7, linestyle="--")
    axis.set(title="torques and their limits", xlabel="t [s]", ylabel="τ [N·m]")
    for axis in axes[1]:
        axis.axvline(STEPS * STEP, color="0.4", linewidth=0.8, linestyle=":")
        axis.margins(x=0.0)
    axes[1, 0].legend(fontsize="small")
    axes[1, 1].annotate("held from here", (STEPS * STEP, 5.5), (4, 0), textcoords="offset points", fontsize="small")
    figure.savefig(path, dpi=130)
    pyplot.close(figure)
    print(f"figure: {path}")


if __name__ == "__main__":
    main()
