"""The Python code and the commands `python -m robot_dynamics` of the guide print the shown output."""

import contextlib
import doctest
import io
import os
import re
import shlex
import shutil
import subprocess
import sys
from pathlib import Path
from typing import NamedTuple

import pytest

ROOT = Path(__file__).parents[2]
PAGES = [*sorted((ROOT / "guide" / "pages").glob("*.md")), ROOT / "README.md"]
OPTIONAL = ("casadi", "gymnasium", "jax", "polars", "pyarrow", "ray", "torch")


class Block(NamedTuple):
    """A block of code, and the output that follows it."""

    language: str
    code: str
    line: int
    shown: str | None


def blocks(page: str) -> list[Block]:
    """The blocks of a page; output belongs to the block above it."""
    found: list[Block] = []
    end = 0
    for match in re.finditer(r"^```(\w*)[^\n]*\n(.*?)^```$", page, re.MULTILINE | re.DOTALL):
        language, text = match.groups()
        if language == "text" and found and page[end : match.start()].strip() == "":
            found[-1] = found[-1]._replace(shown=text)
        else:
            found.append(Block(language, text, page.count("\n", 0, match.start()) + 2, None))
        end = match.end()
    return found


def same(shown: str, printed: str) -> bool:
    """Whether the printed text matches the shown one; `...` stands for anything."""
    return doctest.OutputChecker().check_output(shown, printed, doctest.ELLIPSIS)


@pytest.mark.parametrize("page", PAGES, ids=lambda page: page.stem)
def test_page(page: Path, tmp_path: Path) -> None:
    text = page.read_text(encoding="utf-8")
    for module in OPTIONAL:
        if re.search(rf"^(import|from) {module}\b|, {module}\b.* as rd$", text, re.MULTILINE):
            pytest.importorskip(module)
    shutil.copytree(ROOT / "robots", tmp_path / "robots")
    # A separate process, because some pages change settings of JAX or start Ray.
    environment = {**os.environ, "RAY_USAGE_STATS_ENABLED": "0", "RAY_ENABLE_UV_RUN_RUNTIME_ENV": "0"}
    command = [sys.executable, "-P", __file__, str(page)]
    ran = subprocess.run(command, cwd=tmp_path, env=environment, capture_output=True, text=True, timeout=300, check=False)
    assert ran.returncode == 0, ran.stderr


def run(page: Path) -> None:
    """Run the code of a page block by block and compare its output."""
    names: dict[str, object] = {"__name__": "__main__"}
    for block in blocks(page.read_text(encoding="utf-8")):
        where = f"{page.name}, line {block.line}"
        if block.language == "python":
            assert block.shown or "assert " in block.code, f"{where}: nothing here can fail"
            printed = io.StringIO()
            with contextlib.redirect_stdout(printed):
                # The position in the page, for tracebacks.
                exec(compile("\n" * (block.line - 1) + block.code, str(page), "exec"), names)
            assert same(block.shown or "", printed.getvalue()), f"{where} printed\n{printed.getvalue()}"
        elif block.language == "sh" and "python -m robot_dynamics" in block.code:
            output = commands(block.code)
            assert block.shown is None or same(block.shown, output), f"{where} printed\n{output}"


def commands(block: str) -> str:
    """Output of the commands of the package."""
    output = ""
    for line in block.replace("\\\n", " ").splitlines():
        words = shlex.split(line, comments=True)
        if words[:3] != ["python", "-m", "robot_dynamics"]:
            continue
        ran = subprocess.run(
            [sys.executable, "-P", *words[1:]], capture_output=True, text=True, check=False
        )
        assert ran.returncode == 0, f"{line}: {ran.stderr}"
        output += ran.stdout
    return output


def test_pages_are_found() -> None:
    assert len(PAGES) > 10
    assert sum(block.language == "python" for page in PAGES for block in blocks(page.read_text("utf-8"))) > 20


if __name__ == "__main__":
    run(Path(sys.argv[1]))
