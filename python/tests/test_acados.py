"""Generated functions in acados, if it is installed: its solver agrees with IPOPT."""

from pathlib import Path

import numpy as np
import pytest

from test_examples import run

pytest.importorskip("casadi")
pytest.importorskip("acados_template")


# acados warns about its own code, and about new versions of CasADi.
@pytest.mark.filterwarnings("ignore")
def test_an_arm_reaches_and_stays(tmp_path: Path) -> None:
    found = run("acados_reach", tmp_path)
    assert found["costs"][0] == pytest.approx(found["costs"][1], rel=1e-6)
    assert found["miss"] < 1e-8 and found["apart"] < 1e-4 and found["off"] < 1e-4
    # At every time some joint is at its speed limit.
    assert found["use"] == pytest.approx(1.0, abs=1e-4)
    half = len(found["away"]) // 2
    before, after = found["away"][half - 1], found["away"][half:]
    assert before < 0.1 and after.max() > 0.02 and after[-1] < 0.5 * after.max()
    assert np.abs(found["torques"]).max() <= 1.0 + 1e-6
