"""``python -m robot_dynamics compute``, with interruptions and damaged files."""

import os
import signal
import subprocess
import sys
import time
from pathlib import Path
from typing import Any

import numpy as np
import pyarrow as pa
import pyarrow.parquet as pq
import pytest

import robot_dynamics as rd
from conftest import states
from robot_dynamics.__main__ import main
from robot_dynamics.progress import Progress

PANDA = rd.example("panda")
ROWS, PARTS = 2_000, 6


def recording(path: Path, parts: int = PARTS, rows: int = ROWS, seed: int = 1) -> Path:
    """A file with a number of row groups."""
    s = states(PANDA, parts * rows, seed)
    table = pa.table({name: list(getattr(s, name)) for name in ("q", "v", "a", "tau")})
    table = table.append_column("index", pa.array(np.arange(len(table))))
    pq.write_table(table, path, row_group_size=rows)
    return path


@pytest.fixture(scope="module")
def source(tmp_path_factory: pytest.TempPathFactory) -> Path:
    return recording(tmp_path_factory.mktemp("recording") / "states.parquet")


def run(source: Path, output: Path, *options: str) -> int:
    return main(["compute", str(source), "--robot", "panda", "-o", str(output), *options])


def numbers(path: Path, column: str) -> Any:
    return np.array(pq.read_table(path)[column].to_pylist())


def test_results_are_the_methods_and_the_same_bytes_for_any_workers(source: Path, tmp_path: Path) -> None:
    quantities = ("--quantity", "inverse_dynamics", "frame_pose:panda_link8", "audit", "--keep", "index")
    for workers in ("1", "2", "5"):
        assert run(source, tmp_path / f"{workers}.parquet", "--workers", workers, *quantities) == 0
    s = states(PANDA, PARTS * ROWS)
    first = tmp_path / "1.parquet"
    assert np.array_equal(numbers(first, "inverse_dynamics"), PANDA.inverse_dynamics(s.q, s.v, s.a))
    assert np.array_equal(numbers(first, "frame_pose:panda_link8"), PANDA.frame_pose(s.q, "panda_link8"))
    assert np.array_equal(numbers(first, "index"), np.arange(PARTS * ROWS))
    for workers in ("2", "5"):
        assert first.read_bytes() == (tmp_path / f"{workers}.parquet").read_bytes()
    assert sorted(path.name for path in tmp_path.iterdir()) == ["1.parquet", "2.parquet", "5.parquet"]


def test_a_folder_in_a_folder_out(tmp_path: Path, capsys: pytest.CaptureFixture[str]) -> None:
    data = tmp_path / "data" / "chunk-000"
    data.mkdir(parents=True)
    for k in range(2):
        recording(data / f"episode_{k}.parquet", 2, 50, seed=k + 1)
    assert run(tmp_path / "data", tmp_path / "out", "--quantity", "gravity") == 0
    files = sorted((tmp_path / "out").iterdir())
    assert [path.name for path in files] == [f"part-{k:06}.parquet" for k in range(4)]
    expected = [PANDA.gravity(states(PANDA, 100, k + 1).q) for k in range(2)]
    assert np.array_equal(np.concatenate([numbers(path, "gravity") for path in files]), np.concatenate(expected))
    assert run(tmp_path / "data", tmp_path / "out", "--quantity", "gravity") == 0
    assert "already holds this result, 200 rows" in capsys.readouterr().err
    assert run(tmp_path / "data", tmp_path / "out", "--quantity", "bias") == 1
    assert "exists with other content" in capsys.readouterr().err
    assert run(tmp_path / "data", tmp_path / "data" / "out.parquet") == 1
    assert "would replace the input" in capsys.readouterr().err


def command(source: Path, output: Path, *options: str) -> list[str]:
    given = [str(source), "--robot", "panda", "-o", str(output), *options]
    return [sys.executable, "-P", "-m", "robot_dynamics", "compute", *given]


LONG = ("--quantity", "christoffel_symbols", "forward_dynamics_derivatives", "--workers", "1")


@pytest.mark.skipif(os.name != "posix", reason="signals of POSIX")
@pytest.mark.parametrize("kill", [signal.SIGINT, signal.SIGTERM, signal.SIGKILL], ids=lambda kill: kill.name)
def test_an_interrupted_job_resumes(tmp_path: Path, kill: signal.Signals) -> None:
    source = recording(tmp_path / "states.parquet", 40, 800)
    environment = {**os.environ, "PYTHONPATH": str(Path(rd.__file__).parents[1])}
    output, parts = tmp_path / "out.parquet", tmp_path / "out.parquet.parts"
    with subprocess.Popen(
        command(source, output, *LONG), stderr=subprocess.PIPE, text=True, env=environment
    ) as process:
        ends = time.monotonic() + 60
        while not (parts / "part-000003.parquet").exists():
            assert time.monotonic() < ends and process.poll() is None
            time.sleep(0.001)
        process.send_signal(kill)
        _, errors = process.communicate(timeout=30)
    finished = {path: path.stat().st_mtime_ns for path in parts.glob("part-*.parquet")}
    assert 4 <= len(finished) < 40 and not output.exists()
    if kill != signal.SIGKILL:
        assert process.returncode == 130
        assert f"interrupted: {len(finished)} of 40 parts are finished and kept in {parts}" in errors
        assert not list(parts.glob(".part*"))
    # A damaged part and one of another job are computed again.
    damaged, foreign = sorted(finished)[:2]
    damaged.write_bytes(damaged.read_bytes()[:-100])
    pq.write_table(pa.table({"index": np.arange(800)}), foreign)
    again = subprocess.run(command(source, output, *LONG), capture_output=True, text=True, env=environment, timeout=120)
    assert again.returncode == 0, again.stderr
    assert f"{800 * (len(finished) - 2)} of 32000 rows are already computed" in again.stderr
    assert not parts.exists()
    assert run(source, tmp_path / "whole.parquet", *LONG[:-1], "2") == 0
    assert output.read_bytes() == (tmp_path / "whole.parquet").read_bytes()


def test_another_input_or_quantity_starts_anew(
    tmp_path: Path, capsys: pytest.CaptureFixture[str]
) -> None:
    source = recording(tmp_path / "states.parquet", 3, 20)
    output, parts = tmp_path / "out.parquet", tmp_path / "out.parquet.parts"
    table = pq.read_table(source)
    rows: list[Any] = table["q"].to_pylist()
    rows[45][0] = float("nan")  # in the last part
    pq.write_table(table.set_column(0, "q", pa.array(rows, pa.list_(pa.float64(), 7))), source, row_group_size=20)
    assert run(source, output, "--quantity", "gravity", "--workers", "1") == 1
    said = capsys.readouterr().err
    assert f"{source}, row 45: no `gravity`: q[0]" in said and "--bad-rows null" in said
    assert len(list(parts.glob("part-*"))) == 2 and f"2 of 3 parts are finished and kept in {parts}" in said
    assert run(source, output, "--quantity", "gravity", "--bad-rows", "null") == 0
    assert "already computed" not in capsys.readouterr().err
    found = pq.read_table(output)["gravity"].to_pylist()
    assert [k for k, row in enumerate(found) if row is None] == [45]
    assert run(source, output, "--quantity", "gravity", "--bad-rows", "null") == 0
    assert "already holds this result" in capsys.readouterr().err
    os.utime(source, ns=(1, 1))
    assert run(source, output, "--quantity", "gravity", "--bad-rows", "null") == 0
    assert "already holds this result" not in capsys.readouterr().err


def test_a_damaged_page_is_found_and_computed_again(tmp_path: Path, capsys: pytest.CaptureFixture[str]) -> None:
    from robot_dynamics import parquet
    from robot_dynamics.arrow import Computation

    source, output = recording(tmp_path / "states.parquet", 3, 500), tmp_path / "out.parquet"
    job = parquet.Job.of(Computation(PANDA, ["gravity"], threads=1), source, output)
    job.folder.mkdir()
    for part in job.parts:
        job.write(part)
    kept = job.file(job.parts[1])
    content = bytearray(kept.read_bytes())
    content[2000] ^= 1
    kept.write_bytes(content)
    assert job.is_finished(job.parts[1])  # judging by its footer
    assert run(source, output, "--quantity", "gravity") == 1
    assert "part-000001.parquet: was damaged after it was written" in capsys.readouterr().err and not kept.exists()
    assert run(source, output, "--quantity", "gravity") == 0
    assert np.array_equal(numbers(output, "gravity"), PANDA.gravity(states(PANDA, 1500).q))


def test_two_processes_do_not_share_an_output(tmp_path: Path, capsys: pytest.CaptureFixture[str]) -> None:
    fcntl = pytest.importorskip("fcntl")
    source, output = recording(tmp_path / "states.parquet", 1, 10), tmp_path / "out.parquet"
    folder = tmp_path / "out.parquet.parts"
    folder.mkdir()
    with (folder / ".lock").open("w") as file:
        fcntl.flock(file, fcntl.LOCK_EX)
        assert run(source, output) == 1
        assert folder.exists()  # it belongs to the other process
    assert "another process computes this job" in capsys.readouterr().err
    assert run(source, output) == 0


WRONG = [
    (["nothing.parquet"], "nothing.parquet: no such file"),
    (["text.parquet"], "text.parquet: not a Parquet file"),
    (["empty"], "no file *.parquet in this folder"),
    (
        ["states.parquet", "--quantity", "inverse_dynamic"],
        "no quantity `inverse_dynamic`: did you mean `inverse_dynamics`",
    ),
    (["states.parquet", "--column", "q=position"], "states.parquet: no column `position` for q; there are ['q', 'v', "),
    (["states.parquet", "--column", "q=q[0:3]"], "column `q[0:3]` has 3 numbers a row, robot `panda` needs 7 for q"),
    (["states.parquet", "--column", "q"], "--column q: write q=NAME"),
    (["states.parquet", "--robot", "no.urdf"], "no.urdf"),
    (["states.parquet", "--robot", "two_r"], "column `q` has 7 numbers a row, robot `two_r` needs 2 for q"),
    (["states.parquet", "--quantity", "frame_pose:hand"], "frame_pose:FRAME"),
    (["states.parquet", "--keep", "time"], "no column ['time'] to keep"),
    (["states.parquet", "-o", "no/out.parquet"], "no folder no"),
    (["states.parquet", "-o", "states.parquet"], "would replace the input"),
]


@pytest.mark.parametrize(("arguments", "words"), WRONG, ids=[words for _, words in WRONG])
def test_errors_are_printed_and_no_file_is_left(
    tmp_path: Path,
    monkeypatch: pytest.MonkeyPatch,
    capsys: pytest.CaptureFixture[str],
    arguments: list[str],
    words: str,
) -> None:
    monkeypatch.chdir(tmp_path)
    recording(tmp_path / "states.parquet", 1, 5)
    (tmp_path / "text.parquet").write_text("no Parquet")
    (tmp_path / "empty").mkdir()
    before = sorted(tmp_path.iterdir())
    given = ["compute", arguments[0], "--robot", "panda", "-o", "out.parquet", *arguments[1:]]
    assert main(given) == 1
    assert words in capsys.readouterr().err
    assert sorted(tmp_path.iterdir()) == before


def test_names_with_dots_and_files_that_disagree(tmp_path: Path, capsys: pytest.CaptureFixture[str]) -> None:
    s = states(PANDA, 10)
    for k, dtype in enumerate((np.float64, np.float32)):
        pq.write_table(
            pa.table({"observation.state": list(s.q.astype(dtype)), "observation": [1] * 10}), tmp_path / f"{k}.parquet"
        )
    both = ("--quantity", "bias", "--column", "q=observation.state", "--column", "v=observation.state[0:7]")
    assert run(tmp_path / "0.parquet", tmp_path / "out.parquet", *both, "--keep", "observation.state") == 0
    assert np.array_equal(numbers(tmp_path / "out.parquet", "bias"), PANDA.bias(s.q, s.q))
    column = ("--quantity", "gravity", "--column", "q=observation.state", "--keep", "observation")
    assert run(tmp_path / "0.parquet", tmp_path / "out.parquet", *column) == 0
    assert np.array_equal(numbers(tmp_path / "out.parquet", "gravity"), PANDA.gravity(s.q))
    (tmp_path / "out.parquet").unlink()
    with pytest.MonkeyPatch.context() as patch:
        patch.chdir(tmp_path)
        assert main(["compute", ".", "--robot", "panda", "-o", "../out", *column]) == 1
    said = capsys.readouterr().err
    assert "1.parquet: its results are observation: int64, gravity: fixed_size_list<item: float>[7]" in said


def test_the_list_of_quantities(capsys: pytest.CaptureFixture[str]) -> None:
    assert main(["quantities"]) == 0
    said = capsys.readouterr().out.splitlines()
    assert ["inverse_dynamics", "q", "v", "a"] in [line.split() for line in said] and len(said) > 50


def test_the_bar_is_for_terminals(capsys: pytest.CaptureFixture[str]) -> None:
    Progress(10)(10)
    assert capsys.readouterr().err == ""
    shown = Progress(10, is_shown=True)
    shown(10)
    shown.close()
    assert "100 %  10 of 10 rows" in capsys.readouterr().err
