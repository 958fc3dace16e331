"""What is written of a robot: its file, in either format, and code for it alone."""

from __future__ import annotations

from collections.abc import Sequence
from os import PathLike
from pathlib import Path
from typing import TYPE_CHECKING, Literal, NamedTuple

from robot_dynamics import _native

if TYPE_CHECKING:
    from robot_dynamics.robot import Robot


class LeftOut(NamedTuple):
    """Something of a robot that the format has no words for, or says in another way."""

    place: str
    """For example ``joint "elbow"``."""
    message: str
    physics: bool
    """Whether the robot moves differently without it."""


class RobotText(NamedTuple):
    """The text of a robot's file."""

    text: str
    left_out: tuple[LeftOut, ...]
    """What is not in it."""


def refuse_file_read(robot: Robot, path: Path) -> None:
    """ValueError where a file to be written is one that the robot was read from."""
    if (file := robot._file_read_at(path)) is not None:
        raise ValueError(f"{path} is {file}, which the robot was read from; choose another name")


def to_text(
    robot: Robot, format: Literal["urdf", "mjcf"] = "urdf", *, folder: str | PathLike[str] | None = None
) -> RobotText:
    """The robot's file as text; `folder` is where it will lie, for paths of meshes. `loads` reads it.

    DescriptionError where the format would make another robot of it.

    >>> robot = rd.example("panda")
    >>> written = robot.to_text("mjcf")
    >>> [found.message for found in written.left_out if found.physics]
    []
    >>> back, q = rd.loads(written.text), np.full(7, 0.3)
    >>> bool(np.allclose(back.mass_matrix(q), robot.mass_matrix(q), rtol=0, atol=1e-14))
    True
    """
    text, left_out = robot._to_text(format, folder)
    return RobotText(text, tuple(LeftOut(*found) for found in left_out))


def write(robot: Robot, path: str | PathLike[str]) -> tuple[LeftOut, ...]:
    """Writes the robot's file, ``.urdf``, or ``.xml`` and ``.mjcf`` for MJCF; gives what is not in it.

    The file is there as a whole or not at all. ValueError where it is one that the robot was read from,
    by whatever path or link: its own, an included one, a mesh.

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
    functions: Sequence[str] = ("inverse_dynamics", "forward_dynamics", "mass_matrix"),
    folder: str | PathLike[str] | None = None,
    *,
    single: bool = False,
    fused: bool = False,
    platform_sine: bool = False,
    lanes: bool = False,
    name: str | None = None,
    states: int = 5,
) -> dict[str, str]:
    """A program for this robot alone, straight-line code without allocation: its files by name, with a
    test that holds it to this library's values; written into `folder`, too, where one is given: all of
    them or none, and over none that the robot was read from.

    `functions` are those of ``dynamics generate``: inverse_dynamics, mass_matrix, gravity, ...,
    frame_pose:NAME. In `single` precision, with multiply-adds `fused`, with the platform's sine; Rust
    also over the processor's vector `lanes`, many states at once. Files and functions are called after
    `name`, the robot's where not given; the test compares random `states`.

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
