"""Devices that compile functions of robots."""

from __future__ import annotations

from collections.abc import Callable, Sequence
from typing import TYPE_CHECKING, Any

from robot_dynamics._native import CpuFunctions, CudaDevice
from robot_dynamics.errors import DeviceError
from robot_dynamics.gpu import compiler_library
from robot_dynamics.gpu.functions import DeviceFunctions

if TYPE_CHECKING:
    from robot_dynamics.robot import Robot


class Device:
    """Device that computes functions of robots: a CUDA device, or this processor.

    Compiled code is kept in files of the user's cache folder (``XDG_CACHE_HOME`` or ``~/.cache``, then
    ``robot-dynamics/kernels``). ``ROBOT_DYNAMICS_KERNEL_CACHE`` names another folder; ``0`` disables the
    files.

    Parameters
    ----------
    name : str, optional
        ``"cuda"`` or ``"cuda:0"`` for a card, ``"cpu"`` for the processor; default: the first card, or the
        processor if the system has none.

    Raises
    ------
    DeviceError
        The card, its driver or the run-time compiler NVRTC is missing.
    ValueError
        The name is invalid.

    Examples
    --------
    >>> rd.gpu.Device("cpu").name
    'cpu'
    """

    def __init__(self, name: str | None = None) -> None:
        if name is None:
            name = "cuda:0" if compiler_library.card_count() > 0 else "cpu"
        kind, colon, number = name.partition(":")
        if kind not in ("cuda", "cpu") or (colon and not number.isdecimal()) or (kind == "cpu" and colon):
            raise ValueError(f"there is no device {name!r}: name 'cuda', 'cuda:0' or another number, or 'cpu'")
        ordinal = int(number or 0)
        self._cuda = CudaDevice(ordinal, compiler_library.find()) if kind == "cuda" else None
        self._name = f"cuda:{ordinal}" if kind == "cuda" else "cpu"

    @property
    def name(self) -> str:
        """Name as PyTorch and JAX write it, ``"cuda:0"`` or ``"cpu"``."""
        return self._name

    @property
    def description(self) -> str:
        """Name of the card; ``"cpu"`` for the processor."""
        return self._name if self._cuda is None else self._cuda.name

    def __repr__(self) -> str:
        return f"Device({self._name!r})"

    def compile(self, robot: Robot, functions: Sequence[str], *, dtype: Any = "float32") -> DeviceFunctions:
        """Compile functions of a robot for this device.

        The names are those of ``dynamics generate``: `inverse_dynamics`, `forward_dynamics`, `mass_matrix`,
        `inverse_mass_matrix`, `bias`, `gravity`, energies, momenta, `frame_pose:NAME`, the steps
        `semi_implicit_euler_step` and `rk4_step`, and others. `NAME_derivatives` and `NAME_pullback` are
        derivatives of a function.

        Parameters
        ----------
        robot : Robot
            Robot.
        functions : sequence of str
            Names of functions.
        dtype : dtype
            Type of all arrays, float32 or float64.

        Returns
        -------
        DeviceFunctions
            The compiled functions. Pullbacks that gradients need are compiled when they are first needed.

        Raises
        ------
        GenerateError
            A function does not exist, or its code cannot be generated for this robot.
        DeviceError
            The device's compiler failed.
        DTypeError
            The type is not supported.

        Examples
        --------
        >>> robot = rd.example("two_r")
        >>> arms = rd.gpu.Device("cpu").compile(robot, ["gravity"], dtype="float64")
        >>> arms.gravity(np.zeros((3, 2))).shape
        (3, 2)
        """
        if isinstance(functions, str):
            raise TypeError(f"functions is the text {functions!r}: pass a list of names")
        return DeviceFunctions(self._name, self._compiler(robot), robot, tuple(functions), dtype)

    def _compiler(self, robot: Robot) -> Callable[[list[str], bool], Any]:
        """Function that compiles names, in float32 or float64."""
        cuda = self._cuda
        if cuda is None:
            return lambda names, single: CpuFunctions(robot, names, single)
        return lambda names, single: cuda._compile(robot, names, single)


__all__ = ["Device", "DeviceError"]
