"""Find the reliable episodes of a data set by an energy balance of each, on a Ray cluster.

    python python/examples/energy_audit_on_ray.py [--short] [--figure energy_audit.png] [--folder RECORDINGS]

The data set has the layout of LeRobot: Parquet files of episodes with float32 lists `observation.state`, ...,
a `timestamp` and an `episode_index`. This program generates it with a moving Panda, so the faults are known.
Four episodes have one fault each:

- a payload that the robot's file lacks,
- a torque sensor that reads 15 % too much,
- an encoder that is off by 2 degrees,
- a clock that is 5 % slow.

The audit does not use this knowledge. It computes the quantity `audit` of every row on Ray, and then the
energy account of every episode: E − E₀ = work of the motors.
"""

import argparse
import logging
import tempfile
from pathlib import Path
from typing import Any

import numpy as np
import pyarrow as pa
import pyarrow.parquet as pq

import robot_dynamics as rd
from robot_dynamics import arrow
from robot_dynamics.columns import column_of

RATE, SECONDS = 200.0, 6.0  # [Hz], [s]
WRONG = {5: "0.8 kg payload", 11: "torque sensor 4 reads 15 % more", 16: "encoder 2 off by 2°", 20: "clock 5 % slow"}
MIDDLE = np.array([0.0, -0.3, 0.0, -1.8, 0.0, 1.9, 0.0])
COLUMNS = {
    "q": "observation.state[0:7]",  # the eighth is the gripper
    "v": "observation.velocity",
    "a": "observation.acceleration",
    "tau": "observation.effort",
}


def episode(robot: rd.Robot, number: int) -> Any:
    """One recorded episode: smooth motion of all joints that starts and ends at rest."""
    random = np.random.default_rng(number)
    t = np.arange(0.0, SECONDS, 1.0 / RATE)
    # s(t) = 64 x³(1 − x)³ rises from 0 to 1 and falls to 0, with zero speed at both ends.
    x = t / SECONDS
    s = 64.0 * x**3 * (1 - x) ** 3
    rate = 64.0 * 3.0 * (x * (1 - x)) ** 2 * (1 - 2 * x) / SECONDS
    slope = 64.0 * (6 * x * (1 - x) * (1 - 2 * x) ** 2 - 6 * (x * (1 - x)) ** 2) / SECONDS**2
    reach = random.uniform(0.4, 0.9, 7) * random.choice([-1.0, 1.0], 7)
    turns = random.uniform(1.0, 3.0, 7)
    q = MIDDLE + reach * np.sin(np.multiply.outer(s, turns))
    v = reach * turns * np.cos(np.multiply.outer(s, turns)) * rate[:, np.newaxis]
    a = (
        reach
        * turns
        * (
            np.cos(np.multiply.outer(s, turns)) * slope[:, np.newaxis]
            - turns * np.sin(np.multiply.outer(s, turns)) * rate[:, np.newaxis] ** 2
        )
    )
    real = robot.with_payload("panda_link8", 0.8, [0.0, 0.0, 0.1]) if number == 5 else robot
    tau = real.inverse_dynamics(q, v, a) + random.normal(0.0, 0.05, q.shape)
    if number == 11:
        tau[:, 3] *= 1.15
    if number == 16:
        q = q + np.deg2rad([0, 2, 0, 0, 0, 0, 0])
    state = np.hstack([q, random.uniform(0.0, 0.04, (len(t), 1))])
    lists = zip(("state", "velocity", "acceleration", "effort"), (state, v, a, tau), strict=True)
    none = np.zeros(0, np.intp)
    columns = {f"observation.{name}": column_of(array.astype(np.float32), none) for name, array in lists}
    clock = t * 0.95 if number == 20 else t
    return pa.table(
        {
            **columns,
            "timestamp": clock.astype(np.float32),
            "frame_index": np.arange(len(t)),
            "episode_index": np.full(len(t), number),
        }
    )


def write(folder: Path, robot: rd.Robot, episodes: int) -> None:
    """Write the data set, one file for each episode."""
    target = folder / "data" / "chunk-000"
    target.mkdir(parents=True, exist_ok=True)
    for number in range(episodes):
        pq.write_table(episode(robot, number), target / f"episode_{number:06}.parquet")


def audited(folder: Path, robot: rd.Robot, workers: int) -> Any:
    """The audit of every row, on Ray; starts a local cluster if Ray is not running."""
    import ray

    from robot_dynamics.ray import compute

    is_ours = not ray.is_initialized()
    if is_ours:
        ray.init(num_cpus=workers + 1, include_dashboard=False, log_to_driver=False, logging_level=logging.ERROR)
    try:
        ray.data.DataContext.get_current().enable_progress_bars = False
        recordings = ray.data.read_parquet(str(folder / "data"))
        keep = ["episode_index", "timestamp"]
        # The recording is float32, the computation float64.
        rows = compute(recordings, robot, "audit", columns=COLUMNS, keep=keep, dtype="float64", workers=workers)
        return pa.concat_tables(ray.get(rows.to_arrow_refs()))
    finally:
        if is_ours:
            ray.shutdown()


def main(arguments: list[str] | None = None) -> dict[str, Any]:
    """Print the energy accounts, draw the figure, and return the suspicious episodes."""
    parser = argparse.ArgumentParser(description=__doc__.splitlines()[0])
    parser.add_argument("--short", action="store_true", help="audit eight episodes only")
    parser.add_argument("--figure", default="energy_audit.png")
    parser.add_argument("--folder", help="folder for the recordings; default: a temporary one")
    parser.add_argument("--workers", type=int, default=2)
    options = parser.parse_args(arguments)
    robot = rd.example("panda")
    with tempfile.TemporaryDirectory() as temporary:
        folder = Path(options.folder or temporary)
        write(folder, robot, 8 if options.short else 24)
        rows = audited(folder, robot, options.workers)
    rows = rows.sort_by([("episode_index", "ascending"), ("timestamp", "ascending")])
    accounts = arrow.energy_accounts(rows).to_pylist()

    # The median over the episodes is noise. Five times the median is suspicious.
    residuals = np.array([account["torque_residual"] for account in accounts])
    shares = np.array([account["imbalance"] / account["energy_moved"] for account in accounts])
    worst = residuals / np.median(residuals, axis=0)
    is_suspicious = (worst.max(axis=1) > 5.0) | (shares > 5.0 * np.median(shares))
    print(f"{robot.name}: {rows.num_rows} rows of {len(accounts)} episodes")
    print("  episode  moved [J]   work [J]  imbalance [J]  of moved   worst joint: residual [N·m]")
    for account, share, relative, bad in zip(accounts, shares, worst, is_suspicious, strict=True):
        joint = int(relative.argmax())
        text = f"  {account['episode_index']:7}{account['energy_moved']:11.2f}{account['work']:11.3f}{account['imbalance']:15.4f}"
        text += f"{100 * share:9.2f} %{joint + 1:14}: {account['torque_residual'][joint]:.3f}"
        print(text + (f"   <- {WRONG.get(account['episode_index'], 'no fault')}" if bad else ""))
    suspicious = [account["episode_index"] for account, bad in zip(accounts, is_suspicious, strict=True) if bad]
    print(f"suspicious: {suspicious}; faulty: {[number for number in WRONG if number < len(accounts)]}")
    draw(options.figure, rows, accounts, residuals, shares, is_suspicious)
    return {"suspicious": suspicious, "shares": shares, "rows": rows.num_rows}


def draw(path: str, rows: Any, accounts: Any, residuals: Any, shares: Any, is_suspicious: Any) -> None:
    """Draw the figure."""
    import matplotlib

    matplotlib.use("Agg")
    from matplotlib import pyplot
    from matplotlib.colors import LogNorm

    numbers = np.array([account["episode_index"] for account in accounts])
    figure, axes = pyplot.subplots(2, 2, figsize=(11.0, 6.8), layout="constrained")
    axis = axes[0, 0]
    axis.bar(numbers, 100.0 * shares, color=np.where(is_suspicious, "tab:red", "0.6"))
    axis.set(title="imbalance of the energy account", xlabel="episode", ylabel="% of the energy moved", yscale="log")
    axis.yaxis.set_major_formatter("{x:g}")
    axis = axes[0, 1]
    edges = [*(numbers - 0.5), numbers[-1] + 0.5]
    drawn = axis.pcolormesh(edges, np.arange(0.5, 8.0), residuals.T, norm=LogNorm(0.03, 3.0), cmap="magma_r")
    axis.set(title="torque residual, root mean square", xlabel="episode", ylabel="joint", yticks=range(1, 8))
    figure.colorbar(drawn, ax=axis, label="N·m", format="%g")
    shown = [int(numbers[is_suspicious][0]) if is_suspicious.any() else int(numbers[0]), int(numbers[-1])]
    if 20 in numbers:
        shown = [5, 20]
    for axis, number in zip(axes[1], shown, strict=True):
        own = rows.filter(pa.compute.equal(rows["episode_index"], number))
        t = own["timestamp"].to_numpy().astype(float)
        energy = own["audit.kinetic_energy"].to_numpy() + own["audit.potential_energy"].to_numpy()
        power = own["audit.power"].to_numpy()
        work = np.concatenate([[0.0], np.cumsum(np.diff(t) * (power[1:] + power[:-1]) / 2.0)])
        axis.plot(t, energy - energy[0], color="0.7", linewidth=3.0, label="E − E₀ from the robot's file")
        axis.plot(t, work, color="tab:blue", linewidth=1.2, label="work of the motors, as measured")
        axis.plot(t, energy - energy[0] - work, color="tab:red", linewidth=1.0, label="their difference")
        axis.set(title=f"episode {number}: {WRONG.get(number, 'no fault')}", xlabel="t [s]", ylabel="J")
        axis.margins(x=0.0)
    axes[1, 1].legend(fontsize="small", loc="center", bbox_to_anchor=(0.5, 0.72))
    figure.savefig(path, dpi=130)
    pyplot.close(figure)
    print(f"figure: {path}")


if __name__ == "__main__":
    main()
