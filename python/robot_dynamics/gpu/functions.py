"""Compiled functions of one robot on one device."""

from __future__ import annotations

from collections import namedtuple
from collections.abc import Callable, Sequence
from math import prod
from typing import TYPE_CHECKING, Any, NamedTuple

import numpy as np

from robot_dynamics import defaults
from robot_dynamics._native import CpuFunctions, _device_signature
from robot_dynamics.errors import DeviceError, DTypeError, ShapeError
from robot_dynamics.gpu.arrays import ArrayLibrary, InterfaceArrays, Shape, check, is_of_jax, library_of, stream_handle

if TYPE_CHECKING:
    from robot_dynamics.robot import Robot

Memory = list[tuple[int, int]]
"""Addresses of tables, and their counts of numbers."""


class DeviceRollout(NamedTuple):
    """Motions of many states on a device."""

    q: Any
    """Final configurations (..., nq)."""
    v: Any
    """Final velocities (..., nv) [rad/s or m/s]."""
    q_trajectory: Any
    """Configurations after each step (steps, ..., nq); `None` unless requested."""
    v_trajectory: Any
    """Velocities after each step (steps, ..., nv) [rad/s or m/s]; `None` unless requested."""
    tables: dict[str, Any]
    """Final values of the other tables of the state by name, such as ``impulses`` of a step with contact."""


class Arguments(NamedTuple):
    """Arrays of a call after its checks."""

    library: ArrayLibrary
    """Library that makes the results."""
    arrays: list[Any]
    """Arguments in the order of the function."""
    lead: Shape
    """Axes of the batch."""
    stream: int
    """Handle of the stream."""
    given_stream: int | None
    """Handle of the stream, if the caller gave one."""


class DeviceFunctions:
    """Functions of one robot, compiled for one device: `Device.compile` makes them.

    Each function is an attribute with its name, `functions.forward_dynamics(q, v, tau)`, and an item,
    ``functions["frame_pose:hand"]``.
    """

    def __init__(
        self, device: str, compiler: Callable[[list[str], bool], Any], robot: Robot, names: tuple[str, ...], dtype: Any
    ) -> None:
        found = str(dtype).removeprefix("torch.") if not isinstance(dtype, type) else np.dtype(dtype).name
        if found not in ("float32", "float64"):
            raise DTypeError(f"dtype {dtype} is not supported: use float32 or float64")
        self._device, self._robot, self._dtype, self._names = device, robot, found, names
        self._compiler = compiler
        compiled = compiler(list(names), found == "float32")
        self._compiled = dict.fromkeys(names, compiled)
        self._functions: dict[str, DeviceFunction] = {}
        self._constants: dict[tuple[str, Shape, float, int | None], Any] = {}

    @property
    def device(self) -> str:
        """Name of the device."""
        return self._device

    @property
    def dtype(self) -> str:
        """Type of all arrays, ``"float32"`` or ``"float64"``."""
        return self._dtype

    @property
    def robot(self) -> Robot:
        """The robot."""
        return self._robot

    @property
    def names(self) -> tuple[str, ...]:
        """Names of the compiled functions."""
        return self._names

    def __getitem__(self, name: str) -> DeviceFunction:
        if name not in self._compiled:
            raise DeviceError(f"{name!r} is not among the compiled functions {', '.join(self._names)}: pass it to "
                              "Device.compile")
        return self._function(name)

    def __getattr__(self, name: str) -> DeviceFunction:
        if name.startswith("_"):
            raise AttributeError(name)
        try:
            return self[name]
        except DeviceError as error:
            raise AttributeError(str(error)) from None

    def __dir__(self) -> list[str]:
        return [*super().__dir__(), *self._names]

    def __repr__(self) -> str:
        return f"DeviceFunctions({self._robot.name!r}, {self._device!r}, {self._dtype!r}: {', '.join(self._names)})"

    def rollout(
        self,
        q: Any,
        v: Any,
        tau: Any,
        *,
        steps: int,
        dt: float = defaults.DT,
        step: str | None = None,
        trajectory: bool = False,
        out: tuple[Any, Any] | None = None,
        stream: Any = None,
        **tables: Any,
    ) -> DeviceRollout:
        """Simulate states on the device. All steps run there, without a wait between them.

        Damping and friction of the joints act; limits and contact do not, unless the step has them. Gradients
        keep the states of all steps.

        Parameters
        ----------
        q : array, shape (..., nq)
            Initial configurations.
        v : array, shape (..., nv)
            Initial velocities [rad/s or m/s].
        tau : array, shape (..., nv) or (steps, ..., nv)
            Torques [N·m or N], held over all steps, or those of each step.
        steps : int
            Number of steps.
        dt : float
            Step size [s].
        step : str, optional
            Compiled step, such as ``"rk4_step"``; default: the only compiled one.
        trajectory : bool
            Whether to return the states after each step.
        out : tuple of two arrays, optional
            Arrays for the final states; `q` and `v` themselves simulate in place.
        stream : object, optional
            Stream, or its handle; default: the current stream of the arrays' library.
        **tables : array or float
            The other arguments of the step by name: ``friction`` of a step with contact, and its
            ``impulses``, 0 by default.

        Returns
        -------
        DeviceRollout
            Final states, and the trajectories.

        Raises
        ------
        DeviceError
            No step, or more than one, was compiled; an array is on another device.
        ShapeError
            An array has the wrong shape.
        DTypeError
            An array has another type.
        ValueError
            `steps` or `dt` is not positive.
        """
        from robot_dynamics.gpu import rollouts

        if any(is_of_jax(array) for array in (q, v, tau)):
            from robot_dynamics.gpu import xla

            if out is not None or stream is not None:
                raise TypeError("arrays of JAX are never written, and XLA chooses the stream: call without out= and stream=")
            return xla.rollout(self._step(step), (q, v, tau), steps, dt, trajectory, tables)
        return rollouts.rollout(self, self._step(step), (q, v, tau), steps, dt, trajectory, out, stream, tables)

    def _step(self, name: str | None) -> DeviceFunction:
        steps = [own for own in self._names if own.endswith(("_step", "_sweeps"))]
        if name is None and len(steps) == 1:
            return self[steps[0]]
        if name is None:
            raise DeviceError(f"{len(steps)} steps are compiled, not one: compile a step such as 'rk4_step', or name one "
                              "with step=")
        return self[name]

    def _function(self, name: str) -> DeviceFunction:
        """A function, which is compiled if it is not yet."""
        if name not in self._compiled:
            self._compiled[name] = self._compiler([name], self._dtype == "float32")
        if name not in self._functions:
            self._functions[name] = DeviceFunction(self, name, self._compiled[name])
        return self._functions[name]

    def _constant(self, library: ArrayLibrary, shape: Shape, value: float, given_stream: int | None) -> Any:
        """Array with the same number for each state, kept for the next call on the same stream."""
        if given_stream is not None:
            with library.on_stream(self._device, given_stream):
                return library.full(shape, value, self._dtype, self._device)
        key = (library.name, shape, value, library.stream(self._device) if self._device != "cpu" else None)
        if key in self._constants:
            return self._constants[key]
        constant = library.full(shape, value, self._dtype, self._device)
        if not library.is_capturing():
            if len(self._constants) >= 8:
                self._constants.clear()
            self._constants[key] = constant
        return constant


class DeviceFunction:
    """A compiled function of one robot on one device."""

    def __init__(self, functions: DeviceFunctions, name: str, compiled: Any) -> None:
        self._functions, self._name, self._compiled = functions, name, compiled
        reads, writes = _device_signature(functions._robot, name)
        self._reads = {own: tuple(shape) for own, shape in reads}
        self._writes = {own: tuple(shape) for own, shape in writes}
        title = "".join(word.title() for word in name.partition(":")[0].split("_"))
        self._result = namedtuple(title, list(self._writes))  # type: ignore[misc]

    @property
    def name(self) -> str:
        """Name of the function."""
        return self._name

    @property
    def arguments(self) -> dict[str, Shape]:
        """Names of the arguments, and their shapes for one state."""
        return dict(self._reads)

    @property
    def results(self) -> dict[str, Shape]:
        """Names of the results, and their shapes for one state."""
        return dict(self._writes)

    def __repr__(self) -> str:
        def shapes(tables: dict[str, Shape]) -> str:
            return ", ".join(f"{name} {shape}" for name, shape in tables.items())

        return f"{self._name}: {shapes(self._reads)} -> {shapes(self._writes)}"

    def __call__(self, *arguments: Any, out: Any = None, stream: Any = None) -> Any:
        """Compute the function for all states.

        Parameters
        ----------
        *arguments : array
            Arguments in the order of `arguments`. All have the same leading axes, those of the batch. A
            number stands for the same number in all places.
        out : array or tuple of arrays, optional
            Arrays for the results, in the order of `results`. They may not overlap other arrays.
        stream : object, optional
            Stream, or its handle; default: the current stream of the arrays' library.

        Returns
        -------
        array or tuple of arrays
            Results; several are a named tuple.

        Raises
        ------
        DeviceError
            An array is on another device.
        ShapeError
            An array has the wrong shape or is not contiguous.
        DTypeError
            An array has another type.
        TypeError
            The number of arguments is wrong, or an argument is not an array.
        """
        if any(is_of_jax(array) for array in arguments):
            from robot_dynamics.gpu import xla

            if out is not None or stream is not None:
                raise TypeError("arrays of JAX are never written, and XLA chooses the stream: call without out= and stream=")
            return self._named(xla.call(self, arguments))
        given = self._given(arguments, stream)
        if given.library.name == "torch" and any(getattr(x, "requires_grad", False) for x in given.arrays):
            from robot_dynamics.gpu import autograd

            if autograd.is_recording():
                if out is not None:
                    raise TypeError("out= has no gradients: detach the arguments, or call without out=")
                return self._named(autograd.call(self, given))
        return self._named(self._run(given, out))

    def _given(self, arguments: Sequence[Any], stream: Any) -> Arguments:
        """The arguments, after all checks."""
        if len(arguments) != len(self._reads):
            raise TypeError(f"{self._name} has {len(self._reads)} arguments ({', '.join(self._reads)}), got "
                            f"{len(arguments)}")
        seen = [
            (name, None, float(array)) if isinstance(array, (int, float)) else (name, *library_of(array, name))
            for name, array in zip(self._reads, arguments, strict=True)
        ]
        own = self._functions
        library: ArrayLibrary | None = None
        lead: Shape | None = None
        for name, of, array in seen:
            if of is None:
                continue
            if library is not None and of.name != library.name:
                raise TypeError(f"{name} is an array of {of.name}, but others are of {library.name}: pass arrays of one library")
            library = library or of
            check(of, array, name, own._dtype, own._device)
            lead = self._lead(name, of.shape(array), lead)
        if library is None or lead is None:
            raise TypeError(f"{self._name}: no argument is an array")
        handle = None if stream is None else stream_handle(stream)
        arrays = [
            own._constant(library, lead + self._reads[name], array, handle) if of is None else array
            for name, of, array in seen
        ]
        return Arguments(library, arrays, lead, self._stream(library, arrays, handle), handle)

    def _lead(self, name: str, shape: Shape, lead: Shape | None) -> Shape:
        """The axes of the batch, which are those of the arguments before."""
        axes = self._reads[name]
        before = len(shape) - len(axes)
        if before < 0 or shape[before:] != axes:
            raise ShapeError(f"{name} has shape {shape}, but {self._name} of robot `{self._functions._robot.name}` needs (..., "
                             f"{', '.join(map(str, axes))})")
        if lead is not None and shape[:before] != lead:
            raise ShapeError(f"{name} has shape {shape}: its leading axes must be {lead}, those of the other arguments; arrays on "
                             "a device do not broadcast")
        return shape[:before]

    def _stream(self, library: ArrayLibrary, arrays: Sequence[Any], given: int | None) -> int:
        if given is not None or self._functions._device == "cpu":
            return given or 0
        if isinstance(library, InterfaceArrays):
            return int(arrays[0].__cuda_array_interface__.get("stream") or 0)
        return library.stream(self._functions._device)

    def _run(self, given: Arguments, out: Any = None) -> list[Any]:
        """Compute the results into new arrays, or into those given."""
        library, own = given.library, self._functions
        if out is None:
            with library.on_stream(own._device, given.given_stream):
                results = [library.empty(given.lead + shape, own._dtype, own._device) for shape in self._writes.values()]
        else:
            results = self._outputs(library, out, given.lead)
        self._launch(given, given.arrays, results)
        return results

    def _outputs(self, library: ArrayLibrary, out: Any, lead: Shape) -> list[Any]:
        """The arrays for results, after all checks."""
        results = list(out) if isinstance(out, (tuple, list)) else [out]
        if len(results) != len(self._writes):
            raise TypeError(f"{self._name} has {len(self._writes)} results ({', '.join(self._writes)}), out has {len(results)}")
        for (name, shape), array in zip(self._writes.items(), results, strict=True):
            of, _ = library_of(array, f"out: {name}")
            if of.name != library.name:
                raise TypeError(f"out: {name} is an array of {of.name}, but the arguments are of {library.name}")
            check(of, array, f"out: {name}", self._functions._dtype, self._functions._device)
            if of.shape(array) != lead + shape:
                raise ShapeError(f"out: {name} has shape {of.shape(array)}, expected {lead + shape}")
        return results

    def _launch(self, given: Arguments, inputs: Sequence[Any], outputs: Sequence[Any]) -> None:
        """Compute the function on arrays that were checked."""
        states = prod(given.lead)
        if isinstance(self._compiled, CpuFunctions):
            numpy = given.library.numpy
            self._compiled._compute(self._name, [numpy(x) for x in inputs], [numpy(x) for x in outputs])
            return
        reads = self._memory(given.library, inputs, list(self._reads.values()), states)
        writes = self._memory(given.library, outputs, list(self._writes.values()), states)
        self._compiled._compute(self._name, reads, writes, given.stream, False)

    @staticmethod
    def _memory(library: ArrayLibrary, arrays: Sequence[Any], shapes: Sequence[Shape], states: int) -> Memory:
        return [(library.address(array), states * prod(shape)) for array, shape in zip(arrays, shapes, strict=True)]

    def _named(self, results: Sequence[Any]) -> Any:
        return results[0] if len(results) == 1 else self._result(*results)
