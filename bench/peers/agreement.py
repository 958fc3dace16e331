"""Checks that all programs compute the same numbers, before any of them is timed."""

import sys

import numpy as np

# Sums in another order differ by several n eps of the largest number.
ROUNDING = 1e-12
# A rounding of f32 in roundings of f64; a batch of f32 may have as many of its own.
OF_SINGLES = 2.0**29


def results(side, robot, algorithm, robot_file=None):
    """One row per state, in the states' convention."""
    path = robot.folder / "out.bin"
    side.call(robot, algorithm, "write", path, robot_file)
    rows = np.fromfile(path, dtype="<f8").reshape(len(robot.states), -1)
    path.unlink()
    rows = np.array([robot.back(i, side.convention, algorithm, row) for i, row in enumerate(rows)])
    if not np.all(np.isfinite(rows)):
        sys.exit(f"{side.name}: {robot.name}: {algorithm}: not all numbers are finite")
    return rows


def comparable(robot, algorithm, rows):
    """A floating base's C is not unique, so C v and C + C^T = dM/dt are compared."""
    if algorithm != "coriolis_matrix" or not robot.floating:
        return rows
    n = robot.nv
    c = rows.reshape(-1, n, n)
    product = np.einsum("sij,sj->si", c, np.array([state["v"] for state in robot.states]))
    return np.hstack([product, (c + c.transpose(0, 2, 1)).reshape(len(c), -1)])


def check(robot, sides, algorithm, condition):
    """Exits unless every program that has the algorithm agrees with the first; {side: worst relative
    difference}."""
    having = [side for side in sides if algorithm in side.algorithms]
    references, worst = {}, {}
    for side in having[1:]:
        file = side.reference_file if having[0].name == "ours" else None
        if file not in references:
            references[file] = comparable(robot, algorithm, results(having[0], robot, algorithm, file))
        first, found = references[file], comparable(robot, algorithm, results(side, robot, algorithm))
        scale = np.max(np.abs(first), axis=1)
        if found.shape != first.shape:
            sys.exit(f"{side.name}: {robot.name}: {algorithm}: {found.shape[1]} numbers, not {first.shape[1]}")
        gap = np.max(np.abs(found - first), axis=1) / scale
        # Results that need M⁻¹ lose accuracy by its condition number.
        solved = algorithm.startswith("forward_dynamics")
        allowed = np.maximum(ROUNDING, 10 * condition * np.finfo(float).eps if solved else 0 * condition)
        if "_batch_f32" in algorithm:
            allowed = allowed * OF_SINGLES
        state = int(np.argmax(gap / allowed))
        if gap[state] > allowed[state]:
            what = (
                f"{side.name}: {robot.name}: {algorithm}: state {state}: off by {gap[state]:.1e} of the largest number"
            )
            sys.exit(f"{what}, allowed {allowed[state]:.1e}")
        worst[side.name] = float(np.max(gap))
    return worst


def condition_numbers(robot, side):
    """cond M of every state."""
    masses = results(side, robot, "mass_matrix").reshape(-1, robot.nv, robot.nv)
    return np.linalg.cond(masses)
