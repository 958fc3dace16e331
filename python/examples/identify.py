"""Identify an arm's unknown payload from recorded motion.

    python python/examples/identify.py [--short] [--figure identify.png]

A Panda with an unknown tool moves every joint periodically with three harmonics. The noise of its encoders is
2e-5 rad, that of its torque sensors 0.2 N·m. As usual, velocities and accelerations are the exact derivatives
of harmonics fitted to the angles, q(t) = c + Σ aₖ sin kωt + bₖ cos kωt.

From τ = Y(q, v, a) π the program identifies the combinations β of inertial parameters that torques depend on.
It then validates them on another motion.
"""

import argparse
from typing import Any

import numpy as np
from numpy.typing import NDArray

import robot_dynamics as rd

Array = NDArray[np.float64]

PERIOD, HARMONICS = 10.0, 3  # [s]
ENCODER, SENSOR = 2e-5, 0.2  # [rad], [N·m]
MIDDLE = np.array([0.0, 0.0, 0.0, -1.6, 0.0, 1.9, 0.0])


def waves(t: Array) -> tuple[Array, Array, Array]:
    """The columns 1, sin kωt, cos kωt and their two derivatives by t, each (samples, 1 + 2 harmonics)."""
    k = 2.0 * np.pi / PERIOD * np.arange(1, HARMONICS + 1)
    angle, one = np.multiply.outer(t, k), np.ones((len(t), 1))
    s, c = np.sin(angle), np.cos(angle)
    return np.hstack([one, s, c]), np.hstack([0.0 * one, k * c, -k * s]), np.hstack([0.0 * one, -k * k * s, -k * k * c])


def record(robot: rd.Robot, t: Array, seed: int) -> tuple[Array, Array]:
    """A motion as measured by its sensors: q (samples, 7) and tau (samples, 7)."""
    random = np.random.default_rng(seed)
    amplitudes = random.uniform(-0.5, 0.5, (1 + 2 * HARMONICS, robot.nv)) / np.array([[1.0, 1, 2, 3, 1, 2, 3]]).T
    amplitudes[0] = MIDDLE
    q, v, a = (columns @ amplitudes for columns in waves(t))
    tau = robot.inverse_dynamics(q, v, a) + robot.dissipation(v)
    return q + random.normal(0.0, ENCODER, q.shape), tau + random.normal(0.0, SENSOR, tau.shape)


def smoothed(t: Array, q: Array) -> tuple[Array, Array, Array]:
    """q, v, a of the harmonics fitted to recorded angles."""
    columns = waves(t)
    amplitudes = np.linalg.lstsq(columns[0], q, rcond=None)[0]
    fitted, v, a = (each @ amplitudes for each in columns)
    return fitted, v, a


def rms(residual: Array) -> Array:
    """Root mean square of each joint."""
    mean: Array = np.sqrt((residual**2).mean(axis=0))
    return mean


def main(arguments: list[str] | None = None) -> dict[str, Any]:
    """Print the results, draw the figure, and return the results."""
    parser = argparse.ArgumentParser(description=__doc__.splitlines()[0])
    parser.add_argument("--short", action="store_true", help="use a quarter of the samples")
    parser.add_argument("--figure", default="identify.png")
    options = parser.parse_args(arguments)

    file = rd.example("panda")
    real = file.with_payload("panda_link8", 1.3, [0.03, 0.0, 0.08], np.diag([4e-3, 4e-3, 2e-3]))
    t = np.linspace(0.0, PERIOD, 500 if options.short else 2000, endpoint=False)
    recordings = [record(real, t, seed) for seed in (1, 2, 3)]
    q, v, a = (np.concatenate(parts) for parts in zip(*(smoothed(t, q) for q, _ in recordings), strict=True))
    tau = np.concatenate([tau for _, tau in recordings])
    base = file.base_parameters()
    found = file.identify(q, v, a, tau, base, dissipation=True)
    parameters = base.nearest_parameters(found.values, file.inertial_parameters)

    # Another motion, for validation.
    q, measured = record(real, t, seed=9)
    q, v, a = smoothed(t, q)
    lost = file.dissipation(v)
    by_file = file.inverse_dynamics(q, v, a) + lost
    by_found = file.joint_torque_regressor(q, v, a) @ parameters + lost
    off = {"file": rms(measured - by_file), "found": rms(measured - by_found)}

    true = base.values(real.inertial_parameters)
    errors = (found.values - true) / found.standard_deviations
    inside = float((np.abs(errors) < 2.0).mean())
    counts = f"{len(base)} identifiable combinations of {len(file.inertial_parameters)} parameters"
    print(f"{file.name}: {counts}, from {len(tau)} rows")
    print(f"  condition {found.condition:.0f}, residual {found.residual:.3f} N·m, noise of the sensors {SENSOR} N·m")
    print(f"  {100 * inside:.0f} % of β within two standard deviations of the real robot's")
    print("another motion: root mean square of measured minus predicted torque [N·m]")
    print("  joint          1      2      3      4      5      6      7")
    print("  by its file" + "".join(f"{x:7.2f}" for x in off["file"]))
    print("  as found   " + "".join(f"{x:7.2f}" for x in off["found"]))
    draw(options.figure, t, measured, by_file, by_found, off, found, true)
    return {"inside": inside, "residual": found.residual, "rows": len(tau), **off}


def draw(
    path: str, t: Array, measured: Array, by_file: Array, by_found: Array, off: Any, found: Any, true: Array
) -> None:
    """Draw the figure."""
    import matplotlib

    matplotlib.use("Agg")
    from matplotlib import pyplot

    figure, axes = pyplot.subplots(2, 2, figsize=(10.5, 6.4), layout="constrained")
    for axis, joint in zip(axes[0], (1, 3), strict=True):
        axis.plot(t, measured[:, joint], color="0.75", linewidth=2.5, label="measured")
        axis.plot(t, by_file[:, joint], color="tab:orange", linewidth=1.2, label="by its file")
        axis.plot(t, by_found[:, joint], color="tab:blue", linewidth=1.0, label="as identified")
        axis.set(title=f"joint {joint + 1}, validation motion", xlabel="t [s]", ylabel="τ [N·m]")
        axis.margins(x=0.0)
    axes[0, 0].legend(fontsize="small", ncols=3, loc="upper right")
    low, high = axes[0, 0].get_ylim()
    axes[0, 0].set_ylim(low, high + 0.2 * (high - low))
    joints = np.arange(1, 8)
    axis = axes[1, 0]
    axis.bar(joints - 0.2, off["file"], 0.4, color="tab:orange", label="by its file")
    axis.bar(joints + 0.2, off["found"], 0.4, color="tab:blue", label="as identified")
    axis.axhline(SENSOR, color="0.3", linewidth=1.0, linestyle="--", label="noise of the sensors")
    axis.set(
        title="error of the prediction",
        xlabel="joint",
        ylabel="root mean square [N·m]",
        yscale="log",
        xticks=joints,
        ylim=(0.1, 10.0),
    )
    axis.yaxis.set_major_formatter("{x:g}")
    axis.legend(fontsize="small")
    axis = axes[1, 1]
    order = np.argsort(found.standard_deviations)
    error, width = (found.values - true)[order], found.standard_deviations[order]
    numbers = np.arange(1, len(order) + 1)
    axis.errorbar(
        numbers, error / width, 2.0 * np.ones(len(order)), fmt="o", markersize=3.0, linewidth=0.8, color="tab:blue"
    )
    axis.axhline(0.0, color="0.3", linewidth=1.0)
    axis.set(
        title="identified minus real parameters, ± 2 σ",
        xlabel="combination of inertial parameters",
        ylabel="in their σ",
    )
    figure.savefig(path, dpi=130)
    pyplot.close(figure)
    print(f"figure: {path}")


if __name__ == "__main__":
    main()
