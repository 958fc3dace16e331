"""Every function that simulates a robot has the same defaults, and the same motion as `Simulation`."""

import importlib
import inspect
from collections.abc import Callable
from typing import Any

import numpy as np
import pytest
from numpy.testing import assert_allclose
from numpy.typing import NDArray

import robot_dynamics as rd
from robot_dynamics import defaults
from robot_dynamics.sampling import Mppi
from conftest import ROBOTS, load

Array = NDArray[np.float64]

STEPS, STEP = 20, 2e-3

STATED = {"conservative": False, "without": (), "dissipation": True, "stops": True}
"""Defaults of the options for effects, for functions that have them."""


def found(path: str) -> Any:
    """A function of the package by its path; skips the test if a dependency is missing."""
    module, *names = path.split(".")
    value: Any = rd if module == "rd" else pytest.importorskip(f"robot_dynamics.{module}", exc_type=ImportError)
    for name in names:
        value = getattr(value, name)
    return value


CHOOSES = ["rd.Simulation", "rd.Robot.simulate", "rd.Robot.rollout", "rd.Robot.step", "rd.Robot.linearize_step"]
CHOOSES += ["sampling.Mppi", "gym.RobotEnv"]
DIFFERENTIATES = ["rd.Robot.rollout_pullback", "rd.Robot.step_pullback"]
DIFFERENTIATES += [f"{module}.{name}" for module in ("jax", "torch") for name in ("rollout", "step")]


@pytest.mark.parametrize("path", CHOOSES + DIFFERENTIATES)
def test_defaults_are_one_rule(path: str) -> None:
    parameters = inspect.signature(found(path)).parameters
    assert {"conservative", "without", "integrator"} <= parameters.keys()
    for name in STATED.keys() & parameters.keys():
        assert parameters[name].default == STATED[name], name
    # The exception: gradients require an explicit method.
    assert parameters["integrator"].default == ("rk4" if path in DIFFERENTIATES else None)


SHARED: dict[str, dict[str, object]] = {
    "rd.Robot.inverse_kinematics": {
        "position_tolerance": defaults.POSITION_TOLERANCE,
        "angle_tolerance": defaults.ANGLE_TOLERANCE,
        "max_iterations": defaults.MAX_ITERATIONS,
        "max_restarts": defaults.MAX_RESTARTS,
        "seed": defaults.SEED,
    },
    "rd.Robot.supported_inverse_dynamics": {"force_weight": defaults.FORCE_WEIGHT},
    "rd.random_robot": {"joints": defaults.RANDOM_JOINTS},
    "rd.Robot.audit": {"states": defaults.AUDIT_STATES, "seed": defaults.AUDIT_SEED},
    "rd.Robot.generate": {"functions": defaults.GENERATED_FUNCTIONS, "states": defaults.GENERATED_STATES},
}
"""Defaults that the Rust library defines, by function."""


@pytest.mark.parametrize("path", SHARED)
def test_defaults_are_those_of_rust(path: str) -> None:
    parameters = inspect.signature(found(path)).parameters
    assert {name: parameters[name].default for name in SHARED[path]} == SHARED[path]


@pytest.mark.parametrize("path", [path for path in CHOOSES + DIFFERENTIATES if path not in ("gym.RobotEnv", "sampling.Mppi")])
def test_steps_have_the_length_of_rust(path: str) -> None:
    default = inspect.signature(found(path)).parameters["dt"].default
    assert default in (defaults.DT, inspect.Parameter.empty)


def test_no_other_default_switches_something_off() -> None:
    for module in ("", ".gym", ".jax", ".sampling", ".torch", ".identification", ".motion", ".pullbacks", ".simulation"):
        for value in vars(importlib.import_module(f"robot_dynamics{module}")).values():
            functions = [value, *vars(value).values()] if inspect.isclass(value) else [value]
            for function in functions:
                if inspect.isfunction(function) and function.__module__.startswith("robot_dynamics"):
                    default = inspect.signature(function).parameters.get("dissipation")
                    assert default is None or default.default in (True, default.empty), function.__qualname__


def damped() -> rd.Robot:
    """Two links with damping, dry friction, a spring and little torque."""
    description = load("two_r").describe()
    for joint, friction in zip(description["joints"], (0.3, 0.0, 0.0), strict=True):
        if joint["kind"] != "Fixed":
            joint["passive"] |= {"damping": 0.7, "friction": friction, "stiffness": 2.0}
            joint["limits"]["effort"] = 5.0
    return rd.Robot.from_description(description)


START: tuple[Array, Array, Array] = np.array([0.3, 1.2]), np.array([1.0, -2.0]), np.array([9.0, 1.0])


def by_simulation(robot: rd.Robot, how: dict[str, Any], steps: int = STEPS) -> Array:
    """q and v after all steps of a `Simulation`."""
    sim = rd.Simulation(robot, dt=STEP, **how)
    sim.reset(*START[:2])
    sim.torques = START[2]
    sim.step(steps)
    return np.concatenate([sim.q, sim.v])


def by_simulate(robot: rd.Robot, how: dict[str, Any]) -> Array:
    motion = robot.simulate(*START, duration=STEPS * STEP, dt=STEP, **how)
    return np.concatenate([motion.q[-1], motion.v[-1]])


def by_rollout(robot: rd.Robot, how: dict[str, Any]) -> Array:
    end = robot.rollout(*START, steps=STEPS, dt=STEP, **how)
    return np.concatenate([end.q, end.v])


def by_step(robot: rd.Robot, how: dict[str, Any]) -> Array:
    return np.concatenate(robot.step(*START, dt=STEP, **how))


def by_jax(robot: rd.Robot, how: dict[str, Any]) -> Array:
    jax = pytest.importorskip("jax")
    from robot_dynamics import jax as rdj

    with jax.enable_x64(True):
        end = rdj.rollout(robot, *map(jax.numpy.asarray, START), steps=STEPS, dt=STEP, **how)
        return np.concatenate([np.asarray(end.q), np.asarray(end.v)])


def by_torch(robot: rd.Robot, how: dict[str, Any]) -> Array:
    torch = pytest.importorskip("torch")
    from robot_dynamics import torch as rdt

    end = rdt.rollout(robot, *map(torch.as_tensor, START), steps=STEPS, dt=STEP, **how)
    return np.concatenate([end.q.numpy(), end.v.numpy()])


def by_mppi(robot: rd.Robot, how: dict[str, Any]) -> Array:
    """The motion of a plan, whose torques have separate limits."""
    control = Mppi(
        robot, lambda q, v, tau: q.sum(axis=(1, 2)), horizon=STEPS, dt=STEP, samples=1, noise=1.0, temperature=1.0, seed=1, **how
    )
    q, v, _ = control.motion(*START[:2], np.tile(np.clip(START[2], -5.0, 5.0), (STEPS, 1)))
    return np.concatenate([q[-1], v[-1]])


def by_gym(robot: rd.Robot, how: dict[str, Any]) -> Array:
    gym = pytest.importorskip("robot_dynamics.gym", exc_type=ImportError)

    class Task(gym.RobotEnv):  # type: ignore[misc,name-defined]
        def start(self, mask: Any) -> None:
            self.q[mask], self.v[mask] = START[:2]

        def observe(self) -> Array:
            return np.concatenate([self.q, self.v], axis=1)

        def reward(self, actions: Array) -> Array:
            return np.zeros(self.num_envs)

    envs = Task(3, robot, observations=4, dt=STEP, substeps=STEPS, **how)
    envs.reset(seed=1)
    envs.step(np.tile(np.clip(START[2] / 5.0, -1.0, 1.0), (3, 1)))
    state: Array = envs.observe()[1]
    return state


ROUTES: list[Callable[[rd.Robot, dict[str, Any]], Array]] = [by_simulate, by_rollout, by_step, by_mppi, by_gym, by_jax, by_torch]


@pytest.mark.parametrize("how", [{}, {"conservative": True}, {"without": ["dissipation"]}], ids=["all", "conservative", "undamped"])
@pytest.mark.parametrize("route", ROUTES)
def test_each_route_moves_as_a_simulation(route: Callable[[rd.Robot, dict[str, Any]], Array], how: dict[str, Any]) -> None:
    robot = damped()
    if route in (by_jax, by_torch):
        how = how | {"integrator": "rk4"}
    if route is by_gym and "conservative" in how:
        pytest.skip("the shares of the effort limits are cut off before")
    if route is by_mppi and "conservative" in how:
        pytest.skip("a plan has limits of its own")
    expected = by_simulation(robot, how, steps=1 if route is by_step else STEPS)
    # Steps of a batch round in another order: 20 steps with numbers of size 10.
    assert_allclose(route(robot, how), expected, rtol=0, atol=1e-12)


def test_gradients_are_those_of_the_same_motion() -> None:
    robot = damped()
    q, v, tau = START
    how: dict[str, Any] = {"steps": STEPS, "dt": STEP}
    found = robot.rollout_pullback(q, v, tau, by_velocity=[1.0, -0.5], **how)
    # The first torque is clipped to its limit.
    assert found.by_force is not None and found.by_force[0] == 0.0 != found.by_force[1]

    def loss(k: int, x: float) -> float:
        changed = np.concatenate(START)
        changed[k] += x
        end = robot.rollout(*np.split(changed, 3), integrator="rk4", **how)
        return float(end.v @ [1.0, -0.5])

    d = 1e-5
    gradient = np.concatenate([found.by_position, found.by_velocity, found.by_force])
    # Truncation is d² times a third derivative, rounding 1e-16/d.
    assert_allclose(gradient, [(loss(k, d) - loss(k, -d)) / (2 * d) for k in range(6)], rtol=1e-6, atol=1e-8)


def test_effects_without_gradients_are_named() -> None:
    arm = rd.load(ROBOTS / "arm.xml")
    q, v = arm.neutral(), np.zeros(arm.nv)
    how: dict[str, Any] = {"steps": 2, "dt": STEP, "by_velocity": np.ones(arm.nv)}
    with pytest.raises(ValueError, match=r"gradients of actuators of robot `.*` are not known; without=\[\"actuators\"\]"):
        arm.rollout_pullback(q, v, **how)
    assert np.isfinite(arm.rollout_pullback(q, v, without=["actuators"], **how).by_velocity).all()
    with pytest.raises(ValueError, match="`adaptive` steps are not known; give an explicit integrator"):
        damped().rollout_pullback(*START[:2], steps=1, integrator="adaptive")
