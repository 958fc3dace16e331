#!/usr/bin/env python3
"""Draws the rewards of trainings by `learn_to_walk.py`, and the motion that the last one recorded.

    python bench/learning/plot_walk.py FILE.png LABEL=FOLDER …
"""

import csv
import sys
from pathlib import Path

import matplotlib

matplotlib.use("agg")
import matplotlib.pyplot as plt
import numpy as np

import robot_dynamics as rd

LEGS = [f"{end}_{side}" for end in ("front", "hind") for side in ("left", "right")]
COLORS = ["#1f6f8b", "#c8553d", "#5c8a3a", "#7a5195"]


def rewards(axes: plt.Axes, named: dict[str, Path]) -> None:
    """Mean rewards of a step over the time of the training."""
    for color, (label, folder) in zip(COLORS, named.items(), strict=False):
        with (folder / "curve.csv").open() as file:
            rows = list(csv.DictReader(file))
        seconds = [float(row["seconds"]) for row in rows]
        values = [float(row["reward"]) for row in rows]
        axes.plot(seconds, values, color=color, label=f"{label}, {float(rows[-1]['steps']) / 1e6:.1f} million steps")
    axes.set(xlabel="time of training [s]", ylabel="reward of a control step", ylim=(0, 0.05))
    axes.legend(frameon=False, loc="lower right")


def strides(axes: plt.Axes, motion: dict[str, np.ndarray]) -> None:
    """The robot from the side, every 0.06 s over a stride, one picture beside the other."""
    robot = rd.example("quadruped", floating_base=True)
    chains = [[f"{leg}_{part}" for part in ("hip", "thigh", "shank", "foot")] for leg in LEGS]
    index = {name: k for k, name in enumerate(robot.frame_names)}
    first = len(motion["t"]) // 2
    for number, row in enumerate(range(first, first + 25, 3)):
        poses = robot.frame_poses(motion["q"][row])
        place = np.array([pose[:3, 3] for pose in poses])
        place[:, 0] += 0.75 * number - motion["q"][row][0]
        for k, chain in enumerate(chains):
            points = place[[index[name] for name in chain]]
            axes.plot(points[:, 0], points[:, 2], "-", lw=1.5, color=COLORS[k], alpha=0.9)
        hips = place[[index[chain[0]] for chain in chains]]
        axes.plot([hips[0, 0], hips[2, 0]], [hips[0, 2], hips[2, 2]], lw=4, color="#444444", alpha=0.5)
    axes.axhline(0.0, color="black", lw=1)
    axes.set(xticks=[], ylabel="z [m]", aspect="equal", title="a stride from the side, a picture every 0.06 s")


def contacts(axes: plt.Axes, motion: dict[str, np.ndarray]) -> None:
    """The feet on the ground over time."""
    first = len(motion["t"]) // 2
    part = slice(first, first + 100)
    for k, leg in enumerate(LEGS):
        on = motion["contact"][part, k].astype(float)
        axes.fill_between(motion["t"][part], k + 0.1, k + 0.1 + 0.8 * on, step="post", color=COLORS[k], lw=0)
    axes.set(yticks=np.arange(4) + 0.5, yticklabels=[leg.replace("_", " ") for leg in LEGS], xlabel="time [s]", title="feet on the ground")


def main() -> None:
    """Draws the picture."""
    if len(sys.argv) < 3:
        raise SystemExit(__doc__)
    named = {label: Path(folder) for label, _, folder in (word.partition("=") for word in sys.argv[2:])}
    motion = dict(np.load(list(named.values())[-1] / "rollout.npz"))
    figure = plt.figure(figsize=(9, 5.6), layout="constrained")
    grid = figure.add_gridspec(3, 1, height_ratios=[1.5, 0.7, 1])
    rewards(figure.add_subplot(grid[0]), named)
    strides(figure.add_subplot(grid[1]), motion)
    contacts(figure.add_subplot(grid[2]), motion)
    figure.savefig(sys.argv[1], dpi=100)


if __name__ == "__main__":
    main()
