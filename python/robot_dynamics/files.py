"""Writing a robot to a file, and generating code for it."""

from __future__ import annotations

from collections.abc import Sequence
from os import PathLike
from pathlib import Path
from typing import TYPE_CHECKING, Literal, NamedTuple

from robot_dynamics import _native, defaults

if TYPE_CHECKING:
    from robot_dynamics.robot import Robot


class UnsupportedFeature(NamedTuple):
    """Feature of a robot that a file format cannot express, or expresses in another way."""

    place: str
    """Place in the robot, for example ``joint "elbow"``."""
    message: str
    """Description of the difference."""
    physics: bool
    """Whether the robot moves differently without the feature."""


class RobotText(NamedTuple):
    """Text of a robot's file."""

    text: str
    """Content of the file."""
    left_out: tuple[UnsupportedFeature, ...]
    """Features that the text lacks."""


def refuse_file_read(robot: Robot, path: Path) -> None:
    """Raise ValueError if the robot was read from the file at this path."""
    if (file := robot._file_read_at(path)) is not None:
        raise ValueError(f"{path} is {file}, which the robot was read from; choose another name")


def to_text(
    robot: Robot, format: Literal["urdf", "mjcf"] = "urdf", *, folder: str | PathLike[str] | None = None
) -> RobotText:
    """Text of the robot's file in a format.

    Parameters
    ----------
    format : {"urdf", "mjcf"}
        Format of the text.
    folder : path, optional
        Folder of the file, to which paths of meshes are relative.

    Returns
    -------
    RobotText
        Text that `loads` reads, and the features that it lacks.

    Raises
    ------
    DescriptionError
        The format would describe another robot.

    Examples
    --------
    >>> robot = rd.example("panda")
    >>> written = robot.to_text("mjcf")
    >>> [found.message for found in written.left_out if found.physics]
    []
    >>> back, q = rd.loads(written.text), np.full(7, 0.3)
    >>> bool(np.allclose(back.mass_matrix(q), robot.mass_matrix(q), rtol=0, atol=1e-14))
    True
    """
    text, left_out = robot._to_text(format, folder)
    return RobotText(text, tuple(UnsupportedFeature(*found) for found in left_out))


def write(robot: Robot, path: str | PathLike[str]) -> tuple[UnsupportedFeature, ...]:
    """Write the robot's file, as a whole or not at all.

    Parameters
    ----------
    path : path
        File that ends in ``.urdf``, or in ``.xml`` or ``.mjcf`` for MJCF.

    Returns
    -------
    tuple of UnsupportedFeature
        Features that the file lacks.

    Raises
    ------
    DescriptionError
        The format would describe another robot.
    ValueError
        The ending is unknown, or the robot was read from the file, by any path or link. This includes
        included files and meshes.
    OSError
        The file cannot be written.

    Examples
    --------
    >>> import tempfile, pathlib
    >>> path = pathlib.Path(tempfile.mkdtemp()) / "arm.xml"
    >>> left_out = rd.example("two_r").write(path)
    >>> rd.load(path).nv
    2
    """
    file = Path(path)
    formats: dict[str, Literal["urdf", "mjcf"]] = {".urdf": "urdf", ".xml": "mjcf", ".mjcf": "mjcf"}
    if file.suffix.lower() not in formats:
        raise ValueError(f"{file} must end in .urdf, or in .xml or .mjcf for MJCF")
    text, left_out = robot.to_text(formats[file.suffix.lower()], folder=file.parent)
    refuse_file_read(robot, file)
    _native._write_text(file, text)
    return left_out


def generate(
    robot: Robot,
    target: Literal["rust", "c", "casadi", "wgsl", "cuda"],
    functions: Sequence[str] = defaults.GENERATED_FUNCTIONS,
    folder: str | PathLike[str] | None = None,
    *,
    single: bool = False,
    fused: bool = False,
    platform_sine: bool = False,
    lanes: bool = False,
    name: str | None = None,
    states: int = defaults.GENERATED_STATES,
) -> dict[str, str]:
    """Generate straight-line code without allocation for this robot alone.

    The files contain a test that compares the code with this library. With `folder` all of them are
    written, or none.

    Parameters
    ----------
    target : {"rust", "c", "casadi", "wgsl", "cuda"}
        Language of the code.
    functions : sequence of str
        Functions as in ``dynamics generate``: inverse_dynamics, mass_matrix, gravity, ...,
        frame_pose:NAME.
    folder : path, optional
        Folder to write the files to.
    single : bool
        Whether to compute in single precision.
    fused : bool
        Whether to use fused multiply-add.
    platform_sine : bool
        Whether to use the platform's sine and cosine.
    lanes : bool
        Whether Rust code also has functions for many states in vector registers.
    name : str, optional
        Name for files and functions; default: that of the robot.
    states : int
        Number of random states in the test.

    Returns
    -------
    dict of str to str
        Content of each file, by its name.

    Raises
    ------
    GenerateError
        A function does not exist, or its code cannot be generated or written.
    ValueError
        The target does not exist, or the robot was read from one of the files.

    Examples
    --------
    >>> files = rd.example("two_r").generate("c", ["gravity"])
    >>> sorted(files)
    ['Makefile', 'REPORT.md', 'test_two_r.c', 'two_r.c', 'two_r.h']
    """
    return dict(
        robot._generate(
            target,
            list(functions),
            folder,
            single=single,
            fused=fused,
            platform_sine=platform_sine,
            lanes=lanes,
            name=name,
            states=states,
        )
    )
