"""The examples that learn succeed from their seeds."""

import ctypes
import importlib.util
import shutil
import subprocess
import sys
from collections.abc import Callable
from pathlib import Path
from typing import Any

import numpy as np
import pytest

from robot_dynamics.gym import SwingUp
from robot_dynamics.policy_code import policy_code


def example(name: str) -> Any:
    """A script of the folder as a module."""
    path = Path(__file__).parents[1] / "examples" / f"{name}.py"
    spec = importlib.util.spec_from_file_location(name, path)
    assert spec is not None and spec.loader is not None
    module = importlib.util.module_from_spec(spec)
    # Dataclasses look for their module by name.
    sys.modules[name] = module
    spec.loader.exec_module(module)
    return module


def test_an_evolution_strategy_swings_up() -> None:
    _, learned = example("learn_swing_up").learn(40, seed=4)
    # Hanging scores −π², and leaning −7.5. The swing takes about three of the six seconds and scores about
    # −3.
    assert learned[-1] > -4.0 and learned[-1] > learned[0] + 3.0


def run_code(code: Path, observations: Any, actions: int) -> Any:
    """Actions of a policy in C for each observation."""
    compiler = shutil.which("cc") or shutil.which("gcc") or shutil.which("clang")
    if compiler is None:
        pytest.skip("it needs a C compiler")
    library, found = code.with_suffix(".so"), []
    subprocess.run([compiler, "-O1", "-Wall", "-Werror", "-shared", "-fPIC", code, "-o", library, "-lm"], check=True)
    policy = ctypes.CDLL(str(library)).policy
    for one in observations:
        out = (ctypes.c_float * actions)()
        policy((ctypes.c_float * len(one))(*one), out)
        found.append(list(out))
    return np.array(found)


@pytest.mark.parametrize("activation", ["elu", "relu", "tanh"])
def test_a_policy_in_c_is_the_network(activation: str, tmp_path: Path) -> None:
    random = np.random.default_rng(2)
    widths = [5, 7, 4, 3]
    layers = [(random.standard_normal((b, a)), random.standard_normal(b)) for a, b in zip(widths, widths[1:], strict=False)]
    mean, deviation = random.standard_normal(5), random.uniform(0.5, 2.0, 5)
    (tmp_path / "policy.c").write_text(policy_code(layers, activation=activation, mean=mean, deviation=deviation, limit=2.0))
    seen = random.standard_normal((20, 5))
    actions = run_code(tmp_path / "policy.c", seen, 3)
    x = (seen - mean) / deviation
    functions: dict[str, Callable[[Any], Any]] = {"elu": lambda x: np.where(x > 0, x, np.expm1(np.minimum(x, 0))), "relu": lambda x: np.maximum(x, 0), "tanh": np.tanh}
    for k, (w, b) in enumerate(layers):
        x = x @ w.T + b
        x = functions[activation](x) if k + 1 < len(layers) else np.clip(x, -2.0, 2.0)
    # Numbers of 32 bits, and sums of up to seven products of order one.
    np.testing.assert_allclose(actions, x, rtol=1e-4, atol=1e-5)
    assert (np.abs(x) == 2.0).any() and (np.abs(x) < 2.0).any()


def test_bad_policies_are_named() -> None:
    with pytest.raises(ValueError, match="activation is 'sine'"):
        policy_code([([[1.0]], [0.0])], activation="sine")
    with pytest.raises(ValueError, match="layer 1 has weights"):
        policy_code([([[1.0], [2.0]], [0.0, 0.0]), ([[1.0]], [0.0])])
    with pytest.raises(ValueError, match="not finite"):
        policy_code([([[np.nan]], [0.0])])


def test_policy_optimization_swings_up(tmp_path: Path) -> None:
    torch = pytest.importorskip("torch")
    script = example("learn_to_walk")
    torch.set_num_threads(1)
    task = SwingUp(128, dt=0.01, substeps=5, horizon=120, threads=1)
    agent, curve = script.learn(task, script.Settings(hidden=(32, 32), steps=30), 60, seed=3)
    # Random actions score about −6 a step. The swing takes about three of the six seconds and scores about
    # −3.
    assert curve[0]["reward"] < -5.0 and max(row["reward"] for row in curve[-10:]) > -3.5
    script.save(agent, curve, tmp_path)
    saved = script.Agent(3, 1, script.Settings(hidden=(32, 32)))
    saved.load_state_dict(torch.load(tmp_path / "policy.pt"))
    seen = np.random.default_rng(1).uniform(-1.0, 1.0, (50, 3)).astype(np.float32)
    with torch.no_grad():
        actions = saved(torch.from_numpy(seen)).numpy()
    # Sums of 32 products of order one, in 32 bits.
    np.testing.assert_allclose(run_code(tmp_path / "policy.c", seen, 1), actions, rtol=1e-4, atol=1e-4)
    if importlib.util.find_spec("onnx") is not None:
        from onnx.reference import ReferenceEvaluator

        (computed,) = ReferenceEvaluator(str(tmp_path / "policy.onnx")).run(None, {"observation": seen})
        np.testing.assert_allclose(computed, actions, rtol=1e-4, atol=1e-4)
    assert len((tmp_path / "curve.csv").read_text().splitlines()) == 61
