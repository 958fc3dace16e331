"""The Python environment of the reference values: pinned packages in a virtual environment."""

import hashlib
import importlib.metadata
import os
import subprocess
import sys
from pathlib import Path

HERE = Path(__file__).resolve().parent
ROOT = HERE.parent.parent
REQUIREMENTS = HERE / "requirements.txt"


def pinned(requirements=REQUIREMENTS):
    """{package: version} as in the file and in files that it includes by `-r FILE`."""
    lines = [line.split("#")[0].strip() for line in requirements.read_text().splitlines()]
    found = dict(line.split("==") for line in lines if line and not line.startswith("-r"))
    for line in lines:
        if line.startswith("-r"):
            found |= pinned(requirements.parent / line.removeprefix("-r").strip())
    return found


def is_complete(requirements=REQUIREMENTS):
    """Whether this interpreter has every package in its pinned version."""
    try:
        return all(importlib.metadata.version(name) == version for name, version in pinned(requirements).items())
    except importlib.metadata.PackageNotFoundError:
        return False


def enter(requirements=REQUIREMENTS):
    """Returns in an interpreter that has the pinned packages; restarts the script in one if needed."""
    if is_complete(requirements):
        return
    digest = hashlib.sha256(repr(sorted(pinned(requirements).items())).encode()).hexdigest()[:12]
    home = ROOT / "target" / f"golden-venv-{digest}"
    python = home / "bin" / "python"
    if Path(sys.prefix).resolve() == home.resolve():
        sys.exit(f"{home} lacks packages that {requirements} names: delete the folder and start again")
    if not python.exists():
        print(f"making {home} with the packages of {requirements.relative_to(ROOT)}", file=sys.stderr)
        subprocess.run([sys.executable, "-m", "venv", str(home)], check=True)
        subprocess.run(
            [str(python), "-m", "pip", "install", "--quiet", "--disable-pip-version-check", "-r", str(requirements)],
            check=True,
        )
    os.execv(python, [str(python), *sys.argv])


def robots_folder():
    """The folder `robots` of the installed package example-robot-data."""
    for file in importlib.metadata.files("example-robot-data"):
        parts = file.parts
        if file.suffix == ".urdf" and "robots" in parts:
            depth = len(parts) - parts.index("robots") - 1
            return Path(file.locate()).resolve().parents[depth - 1]
    raise FileNotFoundError("example-robot-data is installed without robot files")
