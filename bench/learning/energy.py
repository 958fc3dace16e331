"""Energy that an NVIDIA device uses, by its counter or by samples of its power."""

import subprocess
import threading
import time
from types import TracebackType
from typing import Self


class EnergyMeter:
    """Measures the energy between entering and leaving [J]; `joules` is `None` if the device does not say."""

    def __init__(self, period: float = 0.05) -> None:
        self.period, self.joules, self.source = period, None, "none"
        self._stop, self._samples, self._handle = threading.Event(), [], None
        try:
            import pynvml

            pynvml.nvmlInit()
            self._nvml, self._handle = pynvml, pynvml.nvmlDeviceGetHandleByIndex(0)
        except Exception:  # without the package or the driver the power comes from nvidia-smi
            self._nvml = None

    def __enter__(self) -> Self:
        self._begin, self._counter = time.perf_counter(), self._count()
        self._stop.clear()
        self._samples = []
        self._thread = threading.Thread(target=self._sample, daemon=True)
        self._thread.start()
        return self

    def __exit__(
        self, kind: type[BaseException] | None, error: BaseException | None, trace: TracebackType | None
    ) -> None:
        self.seconds, counter = time.perf_counter() - self._begin, self._count()
        self._stop.set()
        self._thread.join(timeout=5)
        self.watts = sum(self._samples) / len(self._samples) if self._samples else None
        if counter is not None and self._counter is not None and counter > self._counter:
            self.joules, self.source = (counter - self._counter) / 1e3, "counter"
        elif self.watts is not None:
            self.joules, self.source = self.watts * self.seconds, "power"

    def _count(self) -> int | None:
        """The counter [mJ]."""
        try:
            return int(self._nvml.nvmlDeviceGetTotalEnergyConsumption(self._handle))
        except Exception:
            return None

    def _power(self) -> float:
        """Power [W]."""
        if self._nvml is not None:
            return self._nvml.nvmlDeviceGetPowerUsage(self._handle) / 1e3
        command = ["nvidia-smi", "--query-gpu=power.draw", "--format=csv,noheader,nounits", "-i", "0"]
        return float(subprocess.run(command, capture_output=True, text=True, timeout=5, check=True).stdout)

    def _sample(self) -> None:
        """Samples the power until the end."""
        while not self._stop.is_set():
            try:
                self._samples.append(self._power())
            except Exception:
                return
            self._stop.wait(self.period)
