"""The library of NVRTC, NVIDIA's run-time compiler, in NVIDIA's Python packages."""

from __future__ import annotations

import ctypes
import importlib.util
import os
import re
import sys
from pathlib import Path


def find() -> str | None:
    """Path of the newest NVRTC that the driver supports.

    `None` if there is none in Python's packages, or if ``ROBOT_DYNAMICS_NVRTC`` names one: then the native
    half searches.

    Returns
    -------
    str or None
        Path of the library.
    """
    if os.environ.get("ROBOT_DYNAMICS_NVRTC"):
        return None
    most = _driver_version() // 1000
    found = [(major, path) for major, path in _installed() if most == 0 or major <= most]
    return str(max(found)[1]) if found else None


def _installed() -> list[tuple[int, Path]]:
    """Major versions and paths of the libraries in NVIDIA's packages."""
    spec = importlib.util.find_spec("nvidia")
    folders = [Path(folder) for folder in (spec.submodule_search_locations or [])] if spec else []
    if sys.platform == "win32":
        pattern, name = "*/bin/**/nvrtc64_*.dll", re.compile(r"nvrtc64_(\d+)\d_0\.dll")
    else:
        pattern, name = "*/lib/libnvrtc.so.*", re.compile(r"libnvrtc\.so\.(\d+)")
    files = [file for folder in folders for file in folder.glob(pattern)]
    matches = [(name.fullmatch(file.name), file) for file in files]
    return [(int(match.group(1)), file) for match, file in matches if match]


def _driver() -> ctypes.CDLL | None:
    """The driver's library, initialised."""
    try:
        driver = ctypes.CDLL("nvcuda.dll" if sys.platform == "win32" else "libcuda.so.1")
    except OSError:
        return None
    return driver if driver.cuInit(0) == 0 else None


def _driver_version() -> int:
    """Version of CUDA that the driver supports, 13000 for 13.0; 0 without a driver."""
    driver, version = _driver(), ctypes.c_int(0)
    if driver is None or driver.cuDriverGetVersion(ctypes.byref(version)) != 0:
        return 0
    return version.value


def card_count() -> int:
    """Number of CUDA devices.

    Returns
    -------
    int
        0 without a driver.
    """
    driver, count = _driver(), ctypes.c_int(0)
    if driver is None or driver.cuDeviceGetCount(ctypes.byref(count)) != 0:
        return 0
    return count.value
