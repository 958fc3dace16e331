"""Functions on arrays of a device: on the processor always, on a card where there is one."""

from __future__ import annotations

import ctypes
from pathlib import Path
from typing import Any

import numpy as np
import pytest
from numpy.testing import assert_allclose

import robot_dynamics as rd
from conftest import load, states
from robot_dynamics.gpu import compiler_library

CARDS = compiler_library.card_count()

DEVICES = ["cpu", pytest.param("cuda:0", marks=pytest.mark.skipif(CARDS == 0, reason="no CUDA device"))]

# Roundings of the intermediate values, which exceed the results. The condition number of M multiplies them.
TOLERANCES = {"float64": 1e-9, "float32": 2e-3}


def arrays(device: str, *given: Any) -> list[Any]:
    """Arrays on the device: NumPy's, or those of the library that there is."""
    if device == "cpu":
        return [np.ascontiguousarray(x) for x in given]
    try:
        import torch
    except ImportError:
        cupy = pytest.importorskip("cupy")
        return [cupy.asarray(x) for x in given]
    return [torch.tensor(x, device=device) for x in given]


def host(array: Any) -> Any:
    """The numbers of an array on any device."""
    return array.get() if hasattr(array, "get") else np.asarray(array.cpu() if hasattr(array, "cpu") else array)


@pytest.fixture(params=DEVICES, scope="module")
def device(request: pytest.FixtureRequest) -> rd.gpu.Device:
    """Each device in turn."""
    return rd.gpu.Device(request.param)


@pytest.mark.parametrize("dtype", ["float64", "float32"])
def test_functions_are_those_of_the_robot(robot: rd.Robot, device: rd.gpu.Device, dtype: str) -> None:
    names = ["inverse_dynamics", "forward_dynamics", "mass_matrix", "bias", "kinetic_energy", "forward_dynamics_pullback"]
    compiled = device.compile(robot, names, dtype=dtype)
    s = states(robot, 300)
    q, v, a, tau, weights = (x.astype(dtype) for x in (s.q, s.v, s.a, s.tau, s.cotangent))
    wide = [x.astype(np.float64) for x in (q, v, a, tau, weights)]
    q64 = robot.normalize(wide[0])
    expected = {
        "inverse_dynamics": [robot.inverse_dynamics(q64, wide[1], wide[2])],
        "forward_dynamics": [robot.forward_dynamics(q64, wide[1], wide[3])],
        "mass_matrix": [robot.mass_matrix(q64)],
        "bias": [robot.bias(q64, wide[1])],
        "kinetic_energy": [robot.kinetic_energy(q64, wide[1])],
        "forward_dynamics_pullback": [
            robot.forward_dynamics(q64, wide[1], wide[3]),
            *robot.forward_dynamics_pullback(q64, wide[1], wide[3], wide[4]),
        ],
    }
    own = dict(zip("q v a tau cotangent".split(), arrays(device.name, q, v, a, tau, weights), strict=True))
    for name in names:
        function = compiled[name]
        found = function(*(own[argument] for argument in function.arguments))
        found = list(found) if isinstance(found, tuple) else [found]
        assert len(found) == len(expected[name])
        for result, right in zip(found, expected[name], strict=True):
            assert result.shape == right.shape and str(result.dtype).endswith(dtype)
            assert_allclose(host(result), right, rtol=0, atol=TOLERANCES[dtype] * max(1.0, np.abs(right).max()))


def test_names_and_shapes_are_those_of_the_function(device: rd.gpu.Device) -> None:
    robot = load("two_r")
    compiled = device.compile(robot, ["rk4_step", "kinetic_energy", f"frame_pose:{robot.frame_names[-1]}"], dtype="float64")
    assert compiled.rk4_step.arguments == {"q": (2,), "v": (2,), "tau": (2,), "h": ()}
    assert compiled.rk4_step.results == {"q_next": (2,), "v_next": (2,)}
    assert compiled.kinetic_energy.results == {"kinetic": ()}
    pose = compiled[f"frame_pose:{robot.frame_names[-1]}"]
    assert pose.results == {"rotation": (3, 3), "translation": (3,)}
    (q,) = arrays(device.name, np.zeros((4, 5, 2)))
    found = pose(q)
    assert found.rotation.shape == (4, 5, 3, 3) and found.translation.shape == (4, 5, 3)
    assert_allclose(host(found.translation)[3, 4], robot.frame_pose(np.zeros(2), robot.frame_names[-1])[:3, 3], atol=1e-12)
    with pytest.raises(AttributeError, match="bias"):
        _ = compiled.bias


def test_results_are_written_where_asked_and_repeat_their_bits(device: rd.gpu.Device) -> None:
    robot = load("panda")
    compiled = device.compile(robot, ["forward_dynamics"], dtype="float32")
    s = states(robot, 1000)
    q, v, tau, out = arrays(device.name, *(x.astype(np.float32) for x in (s.q, s.v, s.tau, 0.0 * s.v)))
    first = host(compiled.forward_dynamics(q, v, tau)).copy()
    assert compiled.forward_dynamics(q, v, tau, out=out) is out
    assert np.isfinite(first).all() and np.array_equal(host(out), first)
    # The first rows alone have the same bits.
    assert np.array_equal(host(compiled.forward_dynamics(q[:7], v[:7], tau[:7])), first[:7])


@pytest.mark.parametrize("step", ["semi_implicit_euler_step", "rk4_step"])
@pytest.mark.parametrize("steps", [4, 5])
def test_rollouts_are_those_of_the_robot(robot: rd.Robot, device: rd.gpu.Device, step: str, steps: int) -> None:
    compiled = device.compile(robot, [step], dtype="float64")
    s = states(robot, 9)
    each = np.random.default_rng(3).uniform(-1.0, 1.0, (steps, 9, robot.nv))
    integrator = {"semi_implicit_euler_step": "semi-implicit-euler", "rk4_step": "rk4"}[step]
    how: dict[str, Any] = {"steps": steps, "dt": 2e-4, "integrator": integrator, "stride": 1, "without": ["effort-limits"]}
    for tau, own in ((s.tau, s.tau), (each, each.transpose(1, 0, 2))):
        right = robot.rollout(s.q, s.v, own, **how)
        q, v, torques = arrays(device.name, s.q, s.v, tau)
        end = compiled.rollout(q, v, torques, steps=steps, dt=2e-4)
        assert end.q_trajectory is None
        assert_allclose(host(end.q), right.q, atol=1e-9)
        assert_allclose(host(end.v), right.v, atol=1e-7)
        whole = compiled.rollout(q, v, torques, steps=steps, dt=2e-4, trajectory=True)
        assert np.array_equal(host(whole.q), host(end.q)) and np.array_equal(host(whole.v), host(end.v))
        assert_allclose(host(whole.v_trajectory), right.v_trajectory.transpose(1, 0, 2), atol=1e-7)
        assert np.array_equal(host(q), s.q), "the start is unchanged"
        compiled.rollout(q, v, torques, steps=steps, dt=2e-4, out=(q, v))
        assert np.array_equal(host(q), host(end.q)) and np.array_equal(host(v), host(end.v))


def test_steps_with_contact_pass_their_impulses_on(device: rd.gpu.Device) -> None:
    robot = load("quadruped")
    compiled = device.compile(robot, ["contact_step"], dtype="float64")
    s = states(robot, 5)
    start = np.tile(robot.neutral(), (5, 1))
    start[:, 2] = 0.4 + 0.01 * np.arange(5)
    q, v, tau = arrays(device.name, start, 0.1 * s.v, np.zeros((5, robot.nv)))
    end = compiled.rollout(q, v, tau, steps=60, dt=2e-3, friction=0.7)
    state, impulses = (q, v), 0.0
    for _ in range(60):
        after = compiled.contact_step(*state, tau, 2e-3, 0.7, impulses)
        state, impulses = (after.q_next, after.v_next), after.impulses_next
    assert np.array_equal(host(end.q), host(state[0])) and np.array_equal(host(end.v), host(state[1]))
    assert np.array_equal(host(end.tables["impulses"]), host(impulses))
    assert (np.abs(host(impulses)).sum(axis=1) > 0.0).all(), "the ground pushes each robot"
    with pytest.raises(TypeError, match="needs the argument friction="):
        compiled.rollout(q, v, tau, steps=2)
    with pytest.raises(TypeError, match="has no argument 'slip'"):
        compiled.rollout(q, v, tau, steps=2, friction=0.7, slip=1.0)


def body_on_ground() -> rd.Robot:
    """A free body with two balls that touch the ground."""
    ball = '<collision><origin xyz="{0} 0 0"/><geometry><sphere radius="0.1"/></geometry></collision>'
    return rd.loads(
        '<robot name="body"><link name="body"><inertial><origin xyz="0.02 0.01 0"/><mass value="2"/>'
        '<inertia ixx="0.02" iyy="0.03" izz="0.04" ixy="0" ixz="0" iyz="0"/></inertial>'
        f"{ball.format(-0.2)}{ball.format(0.2)}</link></robot>",
        floating_base=True,
    )


def on_ground(count: int) -> tuple[Any, Any, Any]:
    """States of the body near the ground, which stick and slide, and forces."""
    random = np.random.default_rng(4)
    q = np.tile([0.0, 0.0, 0.1, 0.0, 0.0, 0.0, 1.0], (count, 1))
    q[:, 2] += random.uniform(-1e-3, 1e-3, count)
    return q, random.uniform(-0.2, 0.2, (count, 6)), random.uniform(-1.0, 1.0, (count, 6))


def test_gradients_through_contact_are_differences(device: rd.gpu.Device) -> None:
    robot, step = body_on_ground(), "contact_step_300_sweeps"
    compiled = device.compile(robot, [step, f"{step}_pullback"], dtype="float64")
    q, v, tau = arrays(device.name, *on_ground(20))
    weights = np.random.default_rng(2).uniform(-1.0, 1.0, (20, 12))
    weights[:, :6] = 0.0
    after = compiled[step](q, v, tau, 5e-3, 0.3, 0.0)
    found = compiled[f"{step}_pullback"](q, v, tau, 5e-3, 0.3, after.impulses_next, *arrays(device.name, weights))

    def value(v: Any, tau: Any, friction: float) -> Any:
        return (host(compiled[step](q, v, tau, 5e-3, friction, 0.0).v_next) * weights[:, 6:]).sum(axis=1)

    e = 1e-6
    for k in range(6):
        (shift,) = arrays(device.name, e * np.eye(6)[k] * np.ones((20, 1)))
        by_velocity = (value(v + shift, tau, 0.3) - value(v - shift, tau, 0.3)) / (2 * e)
        by_force = (value(v, tau + shift, 0.3) - value(v, tau - shift, 0.3)) / (2 * e)
        # Errors of differences are 1e-16/1e-6 times the rounding of 300 sweeps.
        assert_allclose(host(found.by_velocity)[:, k], by_velocity, rtol=1e-5, atol=1e-6)
        assert_allclose(host(found.by_force)[:, k], by_force, rtol=1e-5, atol=1e-6)
    by_friction = (value(v, tau, 0.3 + e) - value(v, tau, 0.3 - e)) / (2 * e)
    assert_allclose(host(found.by_friction).ravel(), by_friction, rtol=1e-5, atol=1e-6)
    assert (np.abs(by_friction) > 1e-3).any(), "some bodies slide"
    assert (np.abs(by_friction) < 1e-9).any(), "some bodies stick or are above the ground"


def test_invalid_states_are_not_finite_alone(device: rd.gpu.Device) -> None:
    robot = load("quadruped")
    compiled = device.compile(robot, ["forward_dynamics"], dtype="float64")
    s = states(robot, 5)
    s.v[1, 2] = np.nan
    found = host(compiled.forward_dynamics(*arrays(device.name, s.q, s.v, s.tau)))
    assert not np.isfinite(found[1]).all() and np.isfinite(found[[0, 2, 3, 4]]).all()


def test_angles_beyond_the_sine_are_nan_on_the_processor() -> None:
    compiled = rd.gpu.Device("cpu").compile(load("two_r"), ["gravity"], dtype="float32")
    found = compiled.gravity(np.array([[0.0, 0.0], [9000.0, 0.0], [1.0, 0.0]], np.float32))
    assert np.isnan(found[1]).all() and np.isfinite(found[[0, 2]]).all()


def test_wrong_arrays_are_named(device: rd.gpu.Device) -> None:
    robot = load("two_r")
    compiled = device.compile(robot, ["bias", "rk4_step"], dtype="float64")
    q, v, single, wide = arrays(device.name, np.zeros((4, 2)), np.zeros((4, 2)), np.zeros((4, 2), np.float32), np.zeros((4, 4)))
    with pytest.raises(rd.ShapeError, match=r"v has shape \(4, 4\)"):
        compiled.bias(q, wide)
    with pytest.raises(rd.ShapeError, match=r"v has shape \(3, 2\): its leading axes must be \(4,\)"):
        compiled.bias(q, v[:3])
    with pytest.raises(rd.ShapeError, match="v is not contiguous"):
        compiled.bias(q, wide[:, ::2])
    with pytest.raises(rd.DTypeError, match="v is float32"):
        compiled.bias(q, single)
    with pytest.raises(TypeError, match="bias has 2 arguments"):
        compiled.bias(q)
    with pytest.raises(TypeError, match="v is a list"):
        compiled.bias(q, [[0.0, 0.0]])
    with pytest.raises(rd.RobotDynamicsError, match="overlap"):
        compiled.bias(q, v, out=q)
    with pytest.raises(rd.ShapeError, match="first axis must have steps = 3"):
        compiled.rollout(q, v, arrays(device.name, np.zeros((2, 4, 2)))[0], steps=3, dt=1e-3)
    with pytest.raises(ValueError, match="steps is 0"):
        compiled.rollout(q, v, v.copy() if hasattr(v, "copy") else v.clone(), steps=0)
    with pytest.raises(ValueError, match="dt is"):
        compiled.rollout(q, v, v, steps=1, dt=float("nan"))
    with pytest.raises(TypeError, match="stream"):
        compiled.bias(q, v, stream="main")
    empty = compiled.bias(q[:0], v[:0])
    assert empty.shape == (0, 2)


def test_wrong_devices_and_functions_are_named() -> None:
    robot = load("two_r")
    with pytest.raises(ValueError, match="there is no device 'tpu'"):
        rd.gpu.Device("tpu")
    with pytest.raises(rd.GenerateError, match="flight"):
        rd.gpu.Device("cpu").compile(robot, ["flight"])
    with pytest.raises(rd.DTypeError, match="int32"):
        rd.gpu.Device("cpu").compile(robot, ["bias"], dtype="int32")
    with pytest.raises(rd.DeviceError, match="0 steps are compiled"):
        rd.gpu.Device("cpu").compile(robot, ["bias"]).rollout(*[np.zeros((1, 2), np.float32)] * 3, steps=1)
    assert rd.gpu.Device().name == ("cuda:0" if CARDS else "cpu")
    if not CARDS:
        with pytest.raises(rd.DeviceError, match="no CUDA device"):
            rd.gpu.Device("cuda")


def test_the_compiler_of_the_wheels_is_found(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.delenv("ROBOT_DYNAMICS_NVRTC", raising=False)
    for version in ("12", "13"):
        folder = tmp_path / "nvidia" / f"cu{version}" / "lib"
        folder.mkdir(parents=True)
        for name in (f"libnvrtc.so.{version}", f"libnvrtc.alt.so.{version}", f"libnvrtc-builtins.so.{version}.0"):
            (folder / name).touch()
    monkeypatch.syspath_prepend(str(tmp_path))
    monkeypatch.setattr(compiler_library, "_installed", lambda: [
        (int(file.suffix[1:]), file) for file in sorted(tmp_path.glob("nvidia/*/lib/libnvrtc.so.*"))
    ])
    for driver, expected in ((12080, "12"), (13000, "13"), (0, "13")):
        monkeypatch.setattr(compiler_library, "_driver_version", lambda driver=driver: driver)
        assert str(compiler_library.find()).endswith(f"libnvrtc.so.{expected}")
    monkeypatch.setenv("ROBOT_DYNAMICS_NVRTC", "/elsewhere")
    assert compiler_library.find() is None


class TestGradients:
    """Gradients of tensors, where PyTorch is installed."""

    @pytest.mark.parametrize("name", ["inverse_dynamics", "forward_dynamics", "mass_matrix", "rk4_step"])
    def test_gradients_are_differences(self, robot: rd.Robot, device: rd.gpu.Device, name: str) -> None:
        torch: Any = pytest.importorskip("torch")
        function = device.compile(robot, [name], dtype="float64")[name]
        s = states(robot, 2)
        leaves = [
            torch.tensor(getattr(s, argument), device=device.name, requires_grad=True)
            for argument in function.arguments
            if argument != "h"
        ]

        def call(*given: Any) -> Any:
            q = unit(robot, given[0])
            results = function(q, *given[1:], *([1e-3] if "h" in function.arguments else []))
            return tuple(results) if isinstance(results, tuple) else results

        assert torch.autograd.gradcheck(call, leaves, eps=1e-6, atol=1e-3, rtol=1e-4)

    @pytest.mark.parametrize("each_step", [False, True])
    @pytest.mark.parametrize("name", ["gripper", "quadruped"])
    def test_rollouts_have_the_gradients_of_differences(
        self, device: rd.gpu.Device, name: str, each_step: bool
    ) -> None:
        torch: Any = pytest.importorskip("torch")
        robot = load(name)
        compiled = device.compile(robot, ["semi_implicit_euler_step"], dtype="float64")
        s = states(robot, 2)
        torques = np.random.default_rng(1).uniform(-1, 1, (3, 2, robot.nv)) if each_step else s.tau
        leaves = [torch.tensor(x, device=device.name, requires_grad=True) for x in (s.q, s.v, torques)]

        def call(q: Any, v: Any, tau: Any) -> Any:
            return tuple(compiled.rollout(unit(robot, q), v, tau, steps=3, dt=5e-3, trajectory=True)[:4])

        assert torch.autograd.gradcheck(call, leaves, eps=1e-6, atol=1e-3, rtol=1e-4)

    def test_rollouts_with_contact_have_gradients(self, device: rd.gpu.Device) -> None:
        torch: Any = pytest.importorskip("torch")
        robot = body_on_ground()
        compiled = device.compile(robot, ["contact_step_300_sweeps"], dtype="float64")
        q, v, tau = (torch.tensor(x, device=device.name) for x in on_ground(6))
        v.requires_grad_(True)
        tau.requires_grad_(True)

        def call(v: Any, tau: Any) -> Any:
            end = compiled.rollout(q, v, tau, steps=2, dt=5e-3, friction=0.3)
            assert not end.tables["impulses"].requires_grad
            return end.q[:, :3], end.v

        assert torch.autograd.gradcheck(call, [v, tau], eps=1e-6, atol=1e-5, rtol=1e-4)

    def test_without_recording_nothing_is_kept(self, device: rd.gpu.Device) -> None:
        torch: Any = pytest.importorskip("torch")
        robot = load("two_r")
        compiled = device.compile(robot, ["gravity"], dtype="float64")
        q = torch.zeros(3, 2, dtype=torch.float64, device=device.name, requires_grad=True)
        with torch.no_grad():
            assert not compiled.gravity(q).requires_grad
        assert compiled.gravity(q).requires_grad
        with pytest.raises(TypeError, match="out= has no gradients"):
            compiled.gravity(q, out=torch.zeros_like(q))
        first = torch.autograd.grad(compiled.gravity(q).sum(), q, create_graph=True)[0]
        with pytest.raises(RuntimeError):
            first.sum().backward()


def unit(robot: rd.Robot, q: Any) -> Any:
    """The configuration with quaternions of unit length."""
    if robot.nq == robot.nv:
        return q
    import torch

    return torch.cat([q[..., :3], q[..., 3:7] / q[..., 3:7].norm(dim=-1, keepdim=True), q[..., 7:]], dim=-1)


@pytest.mark.skipif(CARDS == 0, reason="no CUDA device")
def test_the_stream_of_the_caller_runs_the_call() -> None:
    torch: Any = pytest.importorskip("torch")
    compiled = rd.gpu.Device("cuda:0").compile(load("panda"), ["bias"], dtype="float32")
    q = torch.rand(1000, 7, device="cuda:0")
    torch.cuda.synchronize()
    stream = torch.cuda.Stream()
    with torch.cuda.stream(stream):
        inside = compiled.bias(q, q.clone())
    outside = compiled.bias(q, q.clone(), stream=stream)
    stream.synchronize()
    assert torch.equal(inside, outside) and inside.isfinite().all()


def test_a_library_without_a_driver_is_no_card(monkeypatch: pytest.MonkeyPatch) -> None:
    def missing(name: str) -> Any:
        raise OSError(name)

    monkeypatch.setattr(ctypes, "CDLL", missing)
    assert compiler_library.card_count() == 0


class TestJax:
    """Foreign calls of XLA, where JAX is installed."""

    @pytest.fixture(autouse=True)
    def doubles(self) -> Any:
        """Enable float64 in JAX."""
        jax = pytest.importorskip("jax")
        with jax.enable_x64(True):
            yield

    @staticmethod
    def arrays(device: rd.gpu.Device, *given: Any) -> list[Any]:
        import jax

        kind = "cpu" if device.name == "cpu" else "gpu"
        try:
            own = jax.devices(kind)[0]
        except RuntimeError as error:
            pytest.skip(str(error))
        return [jax.device_put(x, own) for x in given]

    def test_functions_are_those_of_the_robot_in_a_program(self, robot: rd.Robot, device: rd.gpu.Device) -> None:
        import jax

        compiled = device.compile(robot, ["forward_dynamics"], dtype="float64")
        s = states(robot, 6)
        q, v, tau, weights = self.arrays(device, s.q, s.v, s.tau, s.cotangent)
        right = robot.forward_dynamics(s.q, s.v, s.tau)
        scale = np.abs(right).max()
        found = jax.jit(compiled.forward_dynamics)(q, v, tau)
        assert_allclose(found, right, rtol=0, atol=1e-9 * scale)
        assert np.array_equal(jax.vmap(compiled.forward_dynamics)(q, v, tau), found)

        def loss(q: Any, v: Any, tau: Any) -> Any:
            return (compiled.forward_dynamics(q, v, tau) * weights).sum()

        by_q, by_v, by_tau = jax.jit(jax.grad(loss, argnums=(0, 1, 2)))(q, v, tau)
        pullback = robot.forward_dynamics_pullback(s.q, s.v, s.tau, s.cotangent)
        expected = robot.cotangent_to_coordinates(s.q, pullback.by_position)
        for own, other in ((by_q, expected), (by_v, pullback.by_velocity), (by_tau, pullback.by_force)):
            assert_allclose(own, other, rtol=0, atol=1e-9 * max(1.0, np.abs(other).max()))

    @pytest.mark.parametrize("name", ["panda", "quadruped"])
    def test_rollouts_have_the_gradients_of_the_library(self, device: rd.gpu.Device, name: str) -> None:
        import jax

        robot = load(name)
        compiled = device.compile(robot, ["rk4_step"], dtype="float64")
        s = states(robot, 3)
        q, v, tau, weights = self.arrays(device, s.q, s.v, s.tau, s.cotangent)

        def loss(v: Any, tau: Any) -> Any:
            end = compiled.rollout(q, v, tau, steps=5, dt=1e-3)
            return (end.v * weights).sum()

        by_v, by_tau = jax.jit(jax.grad(loss, argnums=(0, 1)))(v, tau)
        how: dict[str, Any] = {"steps": 5, "dt": 1e-3, "integrator": "rk4", "without": ["effort-limits"]}
        right = robot.rollout_pullback(s.q, s.v, s.tau, by_velocity=s.cotangent, **how)
        assert right.by_force is not None
        assert_allclose(by_v, right.by_velocity, rtol=0, atol=1e-9)
        assert_allclose(by_tau, right.by_force, rtol=0, atol=1e-9)
        whole = compiled.rollout(q, v, tau, steps=5, dt=1e-3, trajectory=True)
        assert whole.q_trajectory.shape == (5, 3, robot.nq)
        assert np.array_equal(whole.v_trajectory[-1], compiled.rollout(q, v, tau, steps=5, dt=1e-3).v)

    def test_wrong_arrays_are_named(self, device: rd.gpu.Device) -> None:
        compiled = device.compile(load("two_r"), ["bias"], dtype="float64")
        q, single = self.arrays(device, np.zeros((4, 2)), np.zeros((4, 2), np.float32))
        with pytest.raises(rd.DTypeError, match="v is float32"):
            compiled.bias(q, single)
        with pytest.raises(rd.ShapeError, match=r"v has shape \(4, 1\)"):
            compiled.bias(q, q[:, :1])
        with pytest.raises(TypeError, match="never written"):
            compiled.bias(q, q, out=q)
