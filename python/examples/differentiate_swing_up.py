"""Finds the torques that swing a pendulum up and stop it there, by the gradient of a rollout through time.

The motor is too weak to lift the pendulum; 3 s of torques, one for each of 300 steps, are improved together. A loss of the motion is
pulled back through all steps (`Robot.rollout_pullback`), which costs about four rollouts, however many torques there are.
Sixteen starts are tried at once, a batch; the best is shown.

    python examples/differentiate_swing_up.py [--iterations 400] [--plot swing_up.svg]
"""

import argparse
import time

import numpy as np
from numpy.typing import NDArray

import robot_dynamics as rd
from robot_dynamics.gym import PENDULUM

STEPS, STEP, LIMIT = 300, 0.01, 2.0


def losses(robot: rd.Robot, free: NDArray[np.float64]) -> tuple[NDArray[np.float64], NDArray[np.float64]]:
    """How far from standing still upright each motion ends, with a little of its effort, and the gradient by `free` (starts, STEPS).

    The torques are LIMIT tanh(free), within the motor's limit whatever is tried.
    """
    share = np.tanh(free)
    tau = LIMIT * share[..., np.newaxis]
    end = robot.rollout(np.zeros((len(free), 1)), np.zeros(1), tau, steps=STEPS, step=STEP)
    q, v = end.q[:, 0], end.v[:, 0]
    loss = 1.0 + np.cos(q) + 0.1 * v**2 + 1e-4 * (tau**2).mean(axis=(1, 2))
    gradient = robot.rollout_pullback(
        np.zeros((len(free), 1)),
        np.zeros(1),
        tau,
        by_position=-np.sin(end.q),
        by_velocity=0.2 * end.v,
        steps=STEPS,
        step=STEP,
    )
    assert gradient.by_force is not None
    by_tau = gradient.by_force[..., 0] + 2e-4 * tau[..., 0] / STEPS
    return loss, by_tau * LIMIT * (1.0 - share**2)


def swing_up(
    iterations: int, seed: int = 1, starts: int = 16
) -> tuple[NDArray[np.float64], NDArray[np.float64], NDArray[np.float64]]:
    """The best torques (STEPS,), and the least loss before each iteration; and all starts' losses at the end. Adam."""
    robot, random = rd.loads(PENDULUM), np.random.default_rng(seed)
    times = np.arange(STEPS) * STEP
    # Waves of some frequency and phase each: a push at random does not pump.
    rate, phase = random.uniform(1.0, 6.0, (starts, 1)), random.uniform(0.0, 2.0 * np.pi, (starts, 1))
    free = 0.5 * np.sin(rate * times + phase)
    mean, square, least = np.zeros_like(free), np.zeros_like(free), np.zeros(iterations)
    for k in range(iterations):
        loss, gradient = losses(robot, free)
        least[k] = loss.min()
        mean, square = 0.9 * mean + 0.1 * gradient, 0.99 * square + 0.01 * gradient**2
        free -= 0.03 * mean / (1 - 0.9 ** (k + 1)) / (np.sqrt(square / (1 - 0.99 ** (k + 1))) + 1e-8)
    loss, _ = losses(robot, free)
    best: NDArray[np.float64] = LIMIT * np.tanh(free[loss.argmin()])
    return best, least, loss


def main() -> None:
    """Finds them, and says how well."""
    parser = argparse.ArgumentParser(description=__doc__, formatter_class=argparse.RawDescriptionHelpFormatter)
    parser.add_argument("--iterations", type=int, default=400)
    parser.add_argument("--plot", metavar="FILE", help="draws the angle and the torque (matplotlib)")
    options = parser.parse_args()
    begun = time.perf_counter()
    torques, least, loss = swing_up(options.iterations)
    seconds = time.perf_counter() - begun
    robot = rd.loads(PENDULUM)
    motion = robot.rollout([0.0], [0.0], torques[:, np.newaxis], steps=STEPS, step=STEP, stride=1)
    angle = motion.q_trajectory[:, 0]
    away = np.degrees(np.abs(np.remainder(angle[-1], 2.0 * np.pi) - np.pi))
    print(f"loss {least[0]:.3f} -> {loss.min():.2e} in {seconds:.1f} s; {np.sum(loss < 1e-2)} of {len(loss)} starts arrive")
    print(f"it ends {away:.2f} degrees from upright at {motion.v[0]:.3f} rad/s, never with more than {np.abs(torques).max():.2f} N m")
    if options.plot:
        import matplotlib.pyplot as plt

        figure, axes = plt.subplots(2, sharex=True)
        times = (np.arange(STEPS) + 1) * STEP
        axes[0].plot(times, angle)
        axes[0].set_ylabel("angle from hanging [rad]")
        axes[1].plot(times, torques)
        axes[1].set_ylabel("torque [N m]")
        axes[1].set_xlabel("time [s]")
        figure.savefig(options.plot)


if __name__ == "__main__":
    main()
