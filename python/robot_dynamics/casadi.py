"""CasADi: a robot's functions as external functions with Jacobians, for optimal control.

The system's C compiler (``CC``, or else cc, gcc or clang) compiles the code of `Robot.generate`. A function
declares its sparsity and its Jacobian. The Jacobians of inverse and forward dynamics use the recursions for
derivatives. Hessians are not available: use Gauss–Newton, or limited memory in IPOPT. Derivatives by q are by
its nq numbers; the functions depend on the direction of a quaternion only.

    import casadi as ca
    import robot_dynamics as rd
    from robot_dynamics.casadi import external

    torque = external(rd.example("panda"), "inverse_dynamics")
    q, v, a = (ca.MX.sym(name, 7) for name in "qva")
    effort = ca.sumsqr(torque(q, v, a))
    gradient = ca.gradient(effort, q)       # by the generated Jacobian
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
from typing import TYPE_CHECKING

from robot_dynamics.errors import GenerateError
from robot_dynamics.files import refuse_file_read

if TYPE_CHECKING:
    import casadi

    from robot_dynamics.robot import Robot


def external(robot: Robot, function: str, *, folder: str | PathLike[str] | None = None) -> casadi.Function:
    """Compile a function of the robot as an external function of CasADi.

    Arguments and results are columns or matrices, with the shapes of the `Robot` method for one state.

    Parameters
    ----------
    robot : Robot
        Robot of the function.
    function : str
        Function of `Robot.generate`: inverse_dynamics, mass_matrix, frame_pose:NAME, ...
    folder : path, optional
        Folder that keeps the code and the compiled library. A later call with the same function uses them,
        which saves a long compilation. Default: a temporary folder of the process.

    Returns
    -------
    casadi.Function
        The function with its Jacobian.

    Raises
    ------
    GenerateError
        The compiler is missing or fails, or the function does not exist.
    ImportError
        CasADi is missing.
    ValueError
        The robot was read from one of the files.
    """
    try:
        import casadi
    except ImportError as error:
        raise ImportError("robot_dynamics.casadi needs CasADi: pip install casadi") from error

    # The loader identifies functions by name: the fingerprint keeps two robots apart.
    name = f"robot_{robot.fingerprint:016x}"
    source = robot.generate("casadi", [function], name=name)[f"{name}.c"]
    (symbol,) = re.findall(rf"^CASADI_SYMBOL_EXPORT int ({name}_\w+)\(const casadi_real", source, re.MULTILINE)
    place = _temporary_folder() if folder is None else Path(folder)
    for suffix in (".c", ".so"):
        refuse_file_read(robot, place / f"{symbol}{suffix}")
    library = _compile(source, place / f"{symbol}.c")
    loaded: casadi.Function = casadi.external(symbol, str(library.resolve()))
    return loaded


def _compile(source: str, path: Path) -> Path:
    """Compiled library of a source; compiled again unless it exists with the same source."""
    library = path.with_suffix(".so")
    if library.exists() and path.exists() and path.read_text(encoding="utf-8") == source:
        return library
    path.parent.mkdir(parents=True, exist_ok=True)
    with tempfile.TemporaryDirectory(dir=path.parent) as own:
        # Renaming keeps other processes from seeing a part of a file.
        code, made = Path(own) / path.name, Path(own) / library.name
        code.write_text(source, encoding="utf-8")
        command: list[str | Path] = [_compiler(), "-O2", "-fPIC", "-shared", code, "-lm", "-o", made]
        done = subprocess.run(command, capture_output=True, text=True, check=False)
        if done.returncode != 0:
            raise GenerateError(f"{command[0]} does not compile {path.name}: {done.stderr.strip()[:2000]}")
        made.replace(library)
        code.replace(path)
    return library


def _compiler() -> str:
    """Command of the C compiler."""
    named = os.environ.get("CC")
    found = next(filter(None, map(shutil.which, [named] if named else ["cc", "gcc", "clang"])), None)
    if found is None:
        raise GenerateError(f"no C compiler: {named or 'cc, gcc, clang'} not found; install one, or name it by CC")
    return found


@cache
def _temporary_folder() -> Path:
    """Temporary folder of the process."""
    folder = tempfile.mkdtemp(prefix="robot_dynamics_casadi_")
    atexit.register(shutil.rmtree, folder, ignore_errors=True)
    return Path(folder)
