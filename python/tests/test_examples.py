"""The examples in their short form give the stated results."""

import runpy
from pathlib import Path
from typing import Any

import numpy as np
import pytest


EXAMPLES = Path(__file__).parents[1] / "examples"


def run(name: str, folder: Path) -> Any:
    """Run an example, which must draw its figure; returns its result."""
    figure = folder / f"{name}.png"
    found = runpy.run_path(str(EXAMPLES / f"{name}.py"))["main"](["--short", "--figure", str(figure)])
    assert figure.read_bytes().startswith(b"\x89PNG") and figure.stat().st_size > 20_000
    return found


def test_identify(tmp_path: Path, capsys: pytest.CaptureFixture[str]) -> None:
    found = run("identify", tmp_path)
    # For 43 normal values, 85 % within two deviations is almost certain.
    assert found["inside"] > 0.85
    # For 10500 torques with noise 0.2, the root mean square is 0.2 within a few percent.
    assert found["residual"] == pytest.approx(0.2, rel=0.05)
    np.testing.assert_allclose(found["found"], 0.2, rtol=0.15)
    assert found["file"].max() > 5.0
    assert "43 identifiable combinations of 70 parameters" in capsys.readouterr().out


def test_swing_up(tmp_path: Path) -> None:
    found = run("swing_up", tmp_path)
    assert found["difference"] < 1e-7
    assert found["loss"] < 0.1 and found["rest"] < np.deg2rad(1.0)


def test_optimal_control(tmp_path: Path) -> None:
    found = run("optimal_control", tmp_path)
    # The costs of the last states are soft, with weights of 1000 beside costs of order 1.
    assert found["cart_pole"] < 0.01 and found["acrobot"] < 0.01
    assert found["pick"] < 1e-5 and found["block"] < 0.01
    assert abs(found["jump"] - found["asked"]) < 0.02 and found["landing"] < 0.1
    # The push moves the humanoid; the controller keeps its centre of mass above its feet.
    assert 0.005 < found["stand"].max() < 0.05
