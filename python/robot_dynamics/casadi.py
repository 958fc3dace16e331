"""CasADi: a robot's functions as external ones, with Jacobians, for optimal control.

The code of `Robot.generate` is compiled by the system's C compiler (``CC``, else cc, gcc or clang). A
function knows its sparsity and its Jacobian: of inverse and forward dynamics by the recursions for slopes.
Hessians CasADi does not get: use Gauss and Newton's, or IPOPT's limited memory. Slopes by q are by its
numbers; of a quaternion the functions depend on the direction alone.

    import casadi as ca
    import robot_dynamics as rd
    from robot_dynamics.casadi import external

    torque = external(rd.example("panda"), "inverse_dynamics")
    q, v, a = (ca.MX.sym(name, 7) for name in "qva")
    effort = ca.sumsqr(torque(q, v, a))
    slope = ca.gradient(effort, q)          # by the generated Jacobian
"""

from __future__ import annotations

import atexit
import os
import re
import shutil
import subprocess
import tempfile
from functools import cache
from os import PathLike
from pathlib import Path
from typing import TYPE_CHECKING, Any

from robot_dynamics.errors import GenerateError
from robot_dynamics.files import refuse_file_read

if TYPE_CHECKING:
    import casadi

    from robot_dynamics.robot import Robot


def external(robot: Robot, function: str, *, folder: str | PathLike[str] | None = None) -> casadi.Function:
    """A function of the robot, one of those of `Robot.generate`: inverse_dynamics, mass_matrix,
    frame_pose:NAME, ...

    Arguments and results are columns, or matrices, of the shapes that the method of that name has for one
    state. `folder` keeps the code and what is compiled of it, and is looked into first, as long functions
    take long to compile; else both are gone with the process. GenerateError where there is no compiler, or no
    such function.
    """
    try:
        import casadi
    except ImportError as error:
        raise ImportError("robot_dynamics.casadi needs CasADi: pip install casadi") from error

    # Functions of one name are one to the loader: the robot's number keeps two robots apart.
    name = f"robot_{robot.fingerprint:016x}"
    source = robot.generate("casadi", [function], name=name)[f"{name}.c"]
    (symbol,) = re.findall(rf"^CASADI_SYMBOL_EXPORT int ({name}_\w+)\(const casadi_real", source, re.MULTILINE)
    place = _scratch() if folder is None else Path(folder)
    for suffix in (".c", ".so"):
        refuse_file_read(robot, place / f"{symbol}{suffix}")
    library = _compiled(source, place / f"{symbol}.c")
    loaded: casadi.Function = casadi.external(symbol, str(library.resolve()))
    return loaded


def _compiled(source: str, path: Path) -> Path:
    """The library of a source, made where it is missing or of another source."""
    library = path.with_suffix(".so")
    if library.exists() and path.exists() and path.read_text(encoding="utf-8") == source:
        return library
    path.parent.mkdir(parents=True, exist_ok=True)
    with tempfile.TemporaryDirectory(dir=path.parent) as own:
        # Whole or not at all, whoever else makes the same.
        code, made = Path(own) / path.name, Path(own) / library.name
        code.write_text(source, encoding="utf-8")
        command: list[Any] = [_compiler(), "-O2", "-fPIC", "-shared", code, "-lm", "-o", made]
        done = subprocess.run(command, capture_output=True, text=True, check=False)
        if done.returncode != 0:
            raise GenerateError(f"{command[0]} does not compile {path.name}: {done.stderr.strip()[:2000]}")
        made.replace(library)
        code.replace(path)
    return library


def _compiler() -> str:
    named = os.environ.get("CC")
    found = next(filter(None, map(shutil.which, [named] if named else ["cc", "gcc", "clang"])), None)
    if found is None:
        raise GenerateError(f"no C compiler: {named or 'cc, gcc, clang'} not found; install one, or name it by CC")
    return found


@cache
def _scratch() -> Path:
    folder = tempfile.mkdtemp(prefix="robot_dynamics_casadi_")
    atexit.register(shutil.rmtree, folder, ignore_errors=True)
    return Path(folder)
