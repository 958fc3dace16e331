"""Arrays of other libraries: their memory, their devices, and new arrays of the same library."""

from __future__ import annotations

import sys
from abc import ABC, abstractmethod
from collections.abc import Iterator
from contextlib import AbstractContextManager, contextmanager, nullcontext
from typing import Any

import numpy as np

from robot_dynamics.errors import DeviceError, DTypeError, ShapeError

Shape = tuple[int, ...]


class ArrayLibrary(ABC):
    """Library of arrays."""

    name: str
    """Name of the library."""

    @abstractmethod
    def dtype(self, array: Any) -> str:
        """Name of the type of the numbers."""

    @abstractmethod
    def device(self, array: Any) -> str:
        """Name of the device, ``"cpu"`` or ``"cuda:0"``."""

    @abstractmethod
    def is_contiguous(self, array: Any) -> bool:
        """Whether the numbers lie side by side, by rows."""

    @abstractmethod
    def address(self, array: Any) -> int:
        """Address of the first number."""

    @abstractmethod
    def empty(self, shape: Shape, dtype: str, device: str) -> Any:
        """New array."""

    @abstractmethod
    def full(self, shape: Shape, value: float, dtype: str, device: str) -> Any:
        """New array with the same number everywhere."""

    def shape(self, array: Any) -> Shape:
        """Lengths of the axes."""
        return tuple(int(length) for length in array.shape)

    def numpy(self, array: Any) -> Any:
        """NumPy's view of an array on the CPU."""
        return array

    def stream(self, device: str) -> int:
        """Handle of the current stream."""
        return 0

    def on_stream(self, device: str, handle: int | None) -> AbstractContextManager[object]:
        """Context in which new arrays belong to this stream."""
        return nullcontext()

    def is_capturing(self) -> bool:
        """Whether commands are recorded in a graph, so that new arrays get their numbers only later."""
        return False

    def copy(self, source: Any, target: Any) -> None:
        """Copy all numbers of an array."""
        target[...] = source


class NumpyArrays(ArrayLibrary):
    """NumPy."""

    name = "numpy"

    def dtype(self, array: Any) -> str:
        return str(array.dtype)

    def device(self, array: Any) -> str:
        return "cpu"

    def is_contiguous(self, array: Any) -> bool:
        return bool(array.flags.c_contiguous)

    def address(self, array: Any) -> int:
        return int(array.ctypes.data)

    def empty(self, shape: Shape, dtype: str, device: str) -> Any:
        return np.empty(shape, dtype)

    def full(self, shape: Shape, value: float, dtype: str, device: str) -> Any:
        return np.full(shape, value, dtype)


class TorchTensors(ArrayLibrary):
    """PyTorch."""

    name = "torch"

    def __init__(self, torch: Any) -> None:
        self.torch = torch

    def dtype(self, array: Any) -> str:
        return str(array.dtype).removeprefix("torch.")

    def device(self, array: Any) -> str:
        kind, index = array.device.type, array.device.index
        return kind if kind == "cpu" else f"{kind}:{index or 0}"

    def is_contiguous(self, array: Any) -> bool:
        return bool(array.is_contiguous())

    def address(self, array: Any) -> int:
        return int(array.data_ptr())

    def empty(self, shape: Shape, dtype: str, device: str) -> Any:
        return self.torch.empty(shape, dtype=getattr(self.torch, dtype), device=device)

    def full(self, shape: Shape, value: float, dtype: str, device: str) -> Any:
        return self.torch.full(shape, value, dtype=getattr(self.torch, dtype), device=device)

    def numpy(self, array: Any) -> Any:
        return array.detach().numpy()

    def stream(self, device: str) -> int:
        return int(self.torch.cuda.current_stream(device).cuda_stream)

    def on_stream(self, device: str, handle: int | None) -> AbstractContextManager[object]:
        if handle is None or device == "cpu":
            return nullcontext()
        stream = self.torch.cuda.ExternalStream(handle, device=device)
        context: AbstractContextManager[object] = self.torch.cuda.stream(stream)
        return context

    def is_capturing(self) -> bool:
        return bool(self.torch.cuda.is_available() and self.torch.cuda.is_current_stream_capturing())

    def copy(self, source: Any, target: Any) -> None:
        target.detach().copy_(source.detach())


class CupyArrays(ArrayLibrary):
    """CuPy."""

    name = "cupy"

    def __init__(self, cupy: Any) -> None:
        self.cupy = cupy

    def dtype(self, array: Any) -> str:
        return str(array.dtype)

    def device(self, array: Any) -> str:
        return f"cuda:{array.device.id}"

    def is_contiguous(self, array: Any) -> bool:
        return bool(array.flags.c_contiguous)

    def address(self, array: Any) -> int:
        return int(array.data.ptr)

    def empty(self, shape: Shape, dtype: str, device: str) -> Any:
        with self._device(device):
            return self.cupy.empty(shape, dtype)

    def full(self, shape: Shape, value: float, dtype: str, device: str) -> Any:
        with self._device(device):
            return self.cupy.full(shape, value, dtype)

    def stream(self, device: str) -> int:
        with self._device(device):
            return int(self.cupy.cuda.get_current_stream().ptr)

    @contextmanager
    def on_stream(self, device: str, handle: int | None) -> Iterator[None]:
        if handle is None:
            yield
            return
        with self._device(device), self.cupy.cuda.ExternalStream(handle):
            yield

    def _device(self, device: str) -> Any:
        return self.cupy.cuda.Device(_ordinal(device))


class InterfaceArrays(ArrayLibrary):
    """Arrays with `__cuda_array_interface__` of any library, which cannot make new ones here."""

    name = "__cuda_array_interface__"

    def dtype(self, array: Any) -> str:
        return str(np.dtype(array.__cuda_array_interface__["typestr"]))

    def device(self, array: Any) -> str:
        return "cuda"

    def is_contiguous(self, array: Any) -> bool:
        described = array.__cuda_array_interface__
        strides, shape = described.get("strides"), described["shape"]
        if strides is None:
            return True
        expected = np.dtype(described["typestr"]).itemsize
        for stride, length in zip(reversed(strides), reversed(shape), strict=True):
            if length > 1 and stride != expected:
                return False
            expected *= length
        return True

    def address(self, array: Any) -> int:
        return int(array.__cuda_array_interface__["data"][0])

    def shape(self, array: Any) -> Shape:
        return tuple(int(length) for length in array.__cuda_array_interface__["shape"])

    def empty(self, shape: Shape, dtype: str, device: str) -> Any:
        raise DeviceError("arrays of this library cannot be created here: pass them as out=")

    def full(self, shape: Shape, value: float, dtype: str, device: str) -> Any:
        raise DeviceError("arrays of this library cannot be created here: pass the step h as an array")


def _ordinal(device: str) -> int:
    return int(device.partition(":")[2] or 0)


def library_of(array: Any, name: str) -> tuple[ArrayLibrary, Any]:
    """Library of an array, and the array or a view of it in that library.

    Parameters
    ----------
    array : object
        Array.
    name : str
        Name of the argument, for errors.

    Returns
    -------
    library : ArrayLibrary
        Library.
    array : object
        The array itself, or a view of the same memory.

    Raises
    ------
    TypeError
        It is not an array.
    """
    if isinstance(array, np.ndarray):
        return NumpyArrays(), array
    # An array of a library exists only if the library is imported.
    torch, cupy = sys.modules.get("torch"), sys.modules.get("cupy")
    if torch is not None and isinstance(array, torch.Tensor):
        return TorchTensors(torch), array
    if cupy is not None and isinstance(array, cupy.ndarray):
        return CupyArrays(cupy), array
    if hasattr(array, "__dlpack__"):
        if torch is not None:
            return TorchTensors(torch), torch.from_dlpack(array)
        if cupy is not None:
            return CupyArrays(cupy), cupy.from_dlpack(array)
    if hasattr(array, "__cuda_array_interface__"):
        return InterfaceArrays(), array
    if hasattr(array, "__dlpack__"):
        return NumpyArrays(), np.from_dlpack(array)
    raise TypeError(
        f"{name} is a {type(array).__name__}: expected a tensor of PyTorch, an array of CuPy or NumPy, or an object with "
        "__cuda_array_interface__ or __dlpack__"
    )


def is_of_jax(array: Any) -> bool:
    """Whether an array is one of JAX, or one that JAX traces.

    Parameters
    ----------
    array : object
        Array.

    Returns
    -------
    bool
        False for all other objects.
    """
    jax = sys.modules.get("jax")
    return jax is not None and isinstance(array, jax.Array)


def check(library: ArrayLibrary, array: Any, name: str, dtype: str, device: str) -> None:
    """Raise an error for an array of another type or device, or one that is not contiguous.

    Parameters
    ----------
    library : ArrayLibrary
        Library of the array.
    array : object
        Array.
    name : str
        Name of the argument.
    dtype : str
        Type of the numbers.
    device : str
        Name of the device.

    Raises
    ------
    DTypeError
        The type differs.
    DeviceError
        The device differs.
    ShapeError
        The array is not contiguous.
    """
    found = library.dtype(array)
    if found != dtype:
        raise DTypeError(f"{name} is {found}, but the functions were compiled for {dtype}: compile them for {found}, or "
                         "convert the array")
    place = library.device(array)
    if place != device and not (place == "cuda" and device.startswith("cuda:")):
        raise DeviceError(f"{name} is on {place}, but the functions were compiled for {device}: copy the array there")
    if not library.is_contiguous(array):
        raise ShapeError(f"{name} is not contiguous: pass a contiguous copy of it")


def stream_handle(stream: Any) -> int:
    """Handle of a stream: a number, or a stream of PyTorch, CuPy or another library.

    Parameters
    ----------
    stream : object
        Stream.

    Returns
    -------
    int
        Its `cudaStream_t`.

    Raises
    ------
    TypeError
        It is not a stream.
    """
    if isinstance(stream, int):
        return stream
    for attribute in ("cuda_stream", "ptr"):
        handle = getattr(stream, attribute, None)
        if isinstance(handle, int):
            return handle
    if hasattr(stream, "__cuda_stream__"):
        return int(stream.__cuda_stream__()[1])
    raise TypeError(f"stream is a {type(stream).__name__}: expected a stream of PyTorch or CuPy, or its handle")
