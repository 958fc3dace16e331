"""Functions of one robot on arrays of a CUDA device, which stay there.

    import torch
    import robot_dynamics as rd

    robot = rd.example("panda")
    device = rd.gpu.Device()                       # the first card; this processor if there is no card
    pandas = device.compile(robot, ["forward_dynamics", "rk4_step"], dtype="float32")

    q = torch.zeros(65_536, robot.nq, device=device.name)
    v, tau = torch.zeros_like(q), torch.zeros_like(q)
    a = pandas.forward_dynamics(q, v, tau)         # a tensor of the same device, on the current stream
    end = pandas.rollout(q, v, tau, steps=100, dt=1e-3)

Arrays are PyTorch's tensors, CuPy's arrays, or any with `__cuda_array_interface__` or `__dlpack__`. They are
contiguous, of the compiled dtype and on the device. Nothing is copied, and no call waits for the device: it
runs on the current stream of the arrays' library. Results are arrays of the same library. Tensors with
`requires_grad` have gradients.

`Device("cpu")` computes the same functions on this processor, with arrays of NumPy and tensors on the CPU. It
is the default where there is no card.

States are not checked: results of numbers that are not finite are not finite. On a card those of an angle
beyond 8192 rad (float32) or 1e5 rad (float64) have no meaning; on the processor they are NaN.
"""

from __future__ import annotations

from robot_dynamics.gpu.device import Device
from robot_dynamics.gpu.functions import DeviceFunction, DeviceFunctions, DeviceRollout

__all__ = ["Device", "DeviceFunction", "DeviceFunctions", "DeviceRollout"]
