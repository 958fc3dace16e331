"""Golden files: JSON with one state, link or joint per line, and numbers that parse to the same binary64."""

import datetime
import importlib.metadata
import json
import math

import numpy as np

# Another processor's instructions may add in another order.
ROUNDING = 1e-12


def plain(x):
    """Numbers, lists and words only; zeros without sign, infinities as words."""
    if isinstance(x, dict):
        return {key: plain(value) for key, value in x.items()}
    if isinstance(x, (list, tuple, np.ndarray)):
        return [plain(value) for value in x]
    if isinstance(x, (float, np.floating)):
        x = float(x)
        if math.isnan(x):
            raise ValueError("a golden value is not a number")
        if math.isinf(x):
            return "inf" if x > 0 else "-inf"
        return x or 0
    return x.item() if isinstance(x, np.integer) else x


def text(x, lines=2):
    """JSON text; entries of the outer `lines` levels of dictionaries, and lists of dictionaries, have a line
    each."""
    compact = json.dumps(x, separators=(",", ":"), ensure_ascii=False)
    if isinstance(x, dict) and lines > 0:
        rows = (f"{json.dumps(key)}:{text(value, lines - 1)}" for key, value in x.items())
        return "{\n" + ",\n".join(rows) + "\n}"
    if isinstance(x, list) and x and isinstance(x[0], dict):
        return "[\n" + ",\n".join(text(value, 0) for value in x) + "\n]"
    return compact


def mujoco_provenance(script, robot_files):
    """The origin of MuJoCo's numbers: versions, the script in this folder, date, and files of robots."""
    versions = {name: importlib.metadata.version(name) for name in ("mujoco", "numpy")}
    return {
        "tool": "MuJoCo",
        "version": versions["mujoco"],
        "packages": versions,
        "command": f"python3 bench/golden/{script}",
        "date": datetime.date.today().isoformat(),
        "robot_files": f"this project's own: {robot_files}",
    }


def write(path, record):
    """Writes the record."""
    path.write_text(text(plain(record)) + "\n")


def compare(path, record):
    """The difference of the committed file from the record: a line that starts with 'same' for equal ones."""
    if not path.exists():
        return "missing"
    old, new = json.loads(path.read_text()), plain(record)
    for side in (old, new):
        side["provenance"].pop("date", None)
    worst = 0.0
    conditions = [np.linalg.cond(np.array(state["mass_matrix"], dtype=float)) for state in new["states"]]
    for state, condition in zip(range(len(new["states"])), conditions):
        if state >= len(old["states"]):
            break
        # Results that need M⁻¹ lose accuracy by its condition number.
        allowed = max(ROUNDING, 10 * condition * np.finfo(float).eps)
        gap = difference(old["states"][state], new["states"][state], allowed)
        if isinstance(gap, str):
            return f"DIFFERS: state {state}{gap}"
        worst = max(worst, gap)
    if len(old["states"]) != len(new["states"]):
        return f"DIFFERS: {len(old['states'])} states, not {len(new['states'])}"
    gap = difference({**old, "states": []}, {**new, "states": []}, ROUNDING)
    if isinstance(gap, str):
        return f"DIFFERS: {gap}"
    worst = max(worst, gap)
    return "same, every digit" if worst == 0 else f"same within rounding ({worst:.1e} relative)"


def difference(old, new, solved):
    """The largest relative difference, or the place and kind of a mismatch."""
    if isinstance(new, dict):
        if not isinstance(old, dict) or list(old) != list(new):
            return ": other fields"
        worst = 0.0
        for key in new:
            allowed = solved if key.startswith(("forward_dynamics", "inverse_mass")) else None
            gap = difference(old[key], new[key], solved) if allowed is None else numbers(old[key], new[key], allowed)
            if isinstance(gap, str):
                return f".{key}{gap}"
            worst = max(worst, gap)
        return worst
    if isinstance(new, list) and new and not is_numbers(new):
        if not isinstance(old, list) or len(old) != len(new):
            return ": other length"
        worst = 0.0
        for i, (x, y) in enumerate(zip(old, new)):
            gap = difference(x, y, solved)
            if isinstance(gap, str):
                return f"[{i}]{gap}"
            worst = max(worst, gap)
        return worst
    if is_numbers(new) and new != []:
        return numbers(old, new, ROUNDING)
    return 0.0 if old == new else f": {old!r}, now {new!r}"


def is_numbers(x):
    """Whether x is a number, or a list of numbers at any depth."""
    return all(map(is_numbers, x)) if isinstance(x, list) else isinstance(x, (int, float)) and not isinstance(x, bool)


def numbers(old, new, allowed):
    """The difference relative to the largest number of the array."""
    if not is_numbers(old):
        return f": {old!r:.80} is no number"
    old, new = np.array(old, dtype=float), np.array(new, dtype=float)
    if old.shape != new.shape:
        return f": shape {old.shape}, now {new.shape}"
    gap = np.max(np.abs(old - new), initial=0) / max(np.max(np.abs(new), initial=0), np.finfo(float).tiny)
    return gap if gap <= allowed else f": off by {gap:.1e} relative"
