"""JAX: values and gradients against the methods and pullbacks of NumPy, and forward against reverse mode."""

from typing import Any

import numpy as np
import pytest
from numpy.testing import assert_allclose

import robot_dynamics as rd
from conftest import load, states

jax = pytest.importorskip("jax")

import jax.numpy as jnp  # noqa: E402
from jax.test_util import check_grads  # noqa: E402

import robot_dynamics.jax as rdj  # noqa: E402

FREE: dict[str, Any] = {"integrator": "rk4", "conservative": True}
EXPLICIT: Any = {"integrator": "rk4", "without": ["effort-limits"]}
"""Options of the equivalent rollouts in NumPy, without and with `dissipation`."""
# Differences over about 1e-6 have about eight digits of derivatives of the same size.
DIFFERENCES: dict[str, Any] = {"order": 1, "atol": 1e-4, "rtol": 1e-4}

SOLUTIONS = {"inverse_dynamics": rdj.inverse_dynamics, "forward_dynamics": rdj.forward_dynamics}


@pytest.fixture(autouse=True)
def doubles() -> Any:
    """Enable float64 in JAX."""
    with jax.enable_x64(True):
        yield


def given(robot: rd.Robot, solution: str, count: int = 3) -> list[Any]:
    """Arguments of the solution."""
    s = states(robot, count)
    return [jnp.asarray(x) for x in (s.q, s.v, s.a if solution == "inverse_dynamics" else s.tau)]


def sized(robot: rd.Robot, q: Any, expected: Any) -> float:
    """1e-9 of the numbers, times the growth of rounding errors for a large κ(M)."""
    return 1e-9 * float(max(1.0, np.abs(expected).max())) * max(1.0, 1e-4 * float(np.linalg.cond(robot.mass_matrix(q)).max()))


@pytest.mark.parametrize("solution", SOLUTIONS)
def test_values_and_gradients_are_those_of_numpy(robot: rd.Robot, solution: str) -> None:
    state = given(robot, solution)
    arrays = [np.asarray(x) for x in state]
    call = jax.jit(lambda *state: SOLUTIONS[solution](robot, *state))
    assert np.array_equal(call(*state), getattr(robot, solution)(*arrays))
    assert np.array_equal(call(*(x[1] for x in state)), getattr(robot, solution)(*(x[1] for x in arrays)))
    weights = states(robot, 3, seed=9).a
    gradients = jax.jit(jax.grad(lambda *state: (call(*state) * weights).sum(), argnums=(0, 1, 2)))(*state)
    expected = list(getattr(robot, f"{solution}_pullback")(*arrays, weights))
    expected[0] = robot.cotangent_to_coordinates(arrays[0], expected[0])
    for own, numpy in zip(gradients, expected, strict=True):
        assert_allclose(own, numpy, rtol=0, atol=sized(robot, arrays[0], numpy))


@pytest.mark.parametrize("solution", SOLUTIONS)
@pytest.mark.parametrize("name", ["panda", "gripper", "quadruped"])
def test_forward_mode_is_reverse_mode(name: str, solution: str) -> None:
    robot = load(name)
    state = given(robot, solution, 1)
    state = [x[0] for x in state]
    changes = [jnp.asarray(x) for x in np.random.default_rng(2).uniform(-1, 1, (3, robot.nq))]
    changes = [changes[0], *(x[: robot.nv] for x in changes[1:])]

    call = jax.jit(lambda *state: SOLUTIONS[solution](robot, *state))
    _, along = jax.jvp(call, state, changes)
    _, back = jax.vjp(call, *state)
    weights = jnp.arange(1.0, robot.nv + 1)
    expected = sum(float(x @ y) for x, y in zip(back(weights), changes, strict=True))
    scale = float(np.abs(along) @ weights)
    assert abs(float(along @ weights) - expected) < sized(robot, state[0], scale)
    forwards, backwards = jax.jacfwd(call)(*state), jax.jacrev(call)(*state)
    assert_allclose(forwards, backwards, rtol=0, atol=sized(robot, state[0], np.asarray(backwards)))


@pytest.mark.parametrize("name", ["panda", "gripper"])
@pytest.mark.parametrize("solution", SOLUTIONS)
def test_gradients_are_differences(name: str, solution: str) -> None:
    robot = load(name)
    q, v, x = given(robot, solution)
    call = jax.jit(lambda q, v, x: SOLUTIONS[solution](robot, q, v, x))
    check_grads(call, (q, v[0], x), **DIFFERENCES)


@pytest.mark.parametrize("name", ["panda", "gripper"])
def test_masses_and_poses_have_the_gradients_of_differences(name: str) -> None:
    robot = load(name)
    q, last = given(robot, "inverse_dynamics")[0], robot.frame_names[-1]
    assert np.array_equal(rdj.frame_pose(robot, q, last), robot.frame_pose(np.asarray(q), last))
    check_grads(jax.jit(lambda q: (rdj.mass_matrix(robot, q), rdj.frame_pose(robot, q, last))), (q,), **DIFFERENCES)


def test_quaternions_have_gradients_by_their_numbers(quadruped: rd.Robot) -> None:
    q, v, a = given(quadruped, "inverse_dynamics", 2)

    def unit(q: Any) -> Any:
        turn = q[..., 3:7] / jnp.linalg.norm(q[..., 3:7], axis=-1, keepdims=True)
        return jnp.concatenate([q[..., :3], turn, q[..., 7:]], axis=-1)

    def call(q: Any, v: Any) -> Any:
        q = unit(q)
        end = rdj.rollout(quadruped, q, v, steps=3, dt=1e-3, stride=2, **FREE)
        pose = rdj.frame_pose(quadruped, q, quadruped.frame_names[-1])
        # These have equal size, so one tolerance suffices.
        return rdj.inverse_dynamics(quadruped, q, v, a) * 1e-2, rdj.mass_matrix(quadruped, q), pose, end

    check_grads(jax.jit(call), (q, v), **DIFFERENCES)
    end = rdj.rollout(quadruped, q, v, steps=3, dt=1e-3, **FREE)
    assert np.array_equal(end.q, quadruped.rollout(np.asarray(q), np.asarray(v), steps=3, dt=1e-3, **FREE).q)


@pytest.mark.parametrize("solution", SOLUTIONS)
def test_vmap_jit_and_scan_compose(panda: rd.Robot, solution: str) -> None:
    q, v, x = given(panda, solution, 5)
    call = SOLUTIONS[solution]
    whole = call(panda, q, v[0], x)
    mapped = jax.vmap(lambda q, x: call(panda, q, v[0], x), in_axes=(0, 1))(q, x.T)
    assert np.array_equal(mapped, whole)

    def loss(q: Any, v: Any, x: Any) -> Any:
        return (call(panda, q, v, x) ** 2).sum()

    each = jax.vmap(jax.grad(loss, argnums=(0, 1, 2)), in_axes=(0, None, 0))(q, v[0], x)
    together = jax.grad(loss, argnums=(0, 1, 2))(q, jnp.tile(v[0], (5, 1)), x)
    for own, other in zip(each, together, strict=True):
        assert_allclose(own, other, rtol=1e-12, atol=1e-12)

    def over(carry: Any, x: Any) -> Any:
        return carry + loss(*x), None

    total, _ = jax.jit(lambda *state: jax.lax.scan(over, 0.0, state))(q, v, x)
    assert total == pytest.approx(float(loss(q, v, x)), rel=1e-12)
    lanes = jax.vmap(jax.vmap(lambda q: rdj.mass_matrix(panda, q)))(jnp.stack([q, q]))
    assert np.array_equal(lanes[1], panda.mass_matrix(np.asarray(q)))


@pytest.mark.parametrize("torques", ["none", "held", "each"])
def test_rollouts_are_those_of_numpy_with_their_gradients(torques: str) -> None:
    how: dict[str, Any] = {"steps": 6, "dt": 5e-3, "stride": 2, "dissipation": True}
    robot = load("gripper")
    q, v, _ = given(robot, "inverse_dynamics")
    shapes = {"none": None, "held": (robot.nv,), "each": (3, 6, robot.nv)}
    shape = shapes[torques]
    tau = None if shape is None else jnp.asarray(np.random.default_rng(1).uniform(-1, 1, shape))
    state = (q, v) if tau is None else (q, v, tau)

    def call(*state: Any) -> Any:
        return rdj.rollout(robot, *state, **how)

    arrays: Any = [np.asarray(x) for x in state]
    expected = robot.rollout(*arrays, **(how | EXPLICIT))
    found = jax.jit(call)(*state)
    for own, numpy in zip(found, (expected.q, expected.v, expected.q_trajectory, expected.v_trajectory), strict=True):
        assert np.array_equal(own, numpy)
    weights = [np.random.default_rng(3).uniform(-1, 1, x.shape) for x in found]
    names = ("by_position", "by_velocity", "by_position_trajectory", "by_velocity_trajectory")

    def loss(*state: Any) -> Any:
        return sum((x * weight).sum() for x, weight in zip(call(*state), weights, strict=True))

    gradients = jax.jit(jax.grad(loss, argnums=tuple(range(len(state)))))(*state)
    cotangents: dict[str, Any] = dict(zip(names, weights, strict=True))
    pulled: Any = robot.rollout_pullback(*arrays, **cotangents, **how)  # type: ignore[misc]
    for k, (own, numpy) in enumerate(zip(gradients, pulled[:3], strict=False)):
        numpy = numpy.sum(axis=0) if (k, torques) == (2, "held") else numpy
        assert_allclose(own, numpy, rtol=0, atol=sized(robot, arrays[0], numpy))
    # Forward mode is derived independently, from the derivatives of each step.
    changes = tuple(jnp.asarray(np.random.default_rng(4).uniform(-1, 1, x.shape)) for x in state)
    _, along = jax.jvp(loss, state, changes)
    back = sum(float((x * y).sum()) for x, y in zip(gradients, changes, strict=True))
    assert float(along) == pytest.approx(back, rel=1e-9)


@pytest.mark.parametrize("name", ["two_r", "gripper", "quadruped"])
@pytest.mark.parametrize("solution", SOLUTIONS)
def test_solutions_have_gradients_by_parameters(name: str, solution: str) -> None:
    robot = load(name)
    state, p = given(robot, solution), jnp.asarray(robot.parameters())
    arrays, weights = [np.asarray(x) for x in state], states(robot, 3, seed=9).a
    call = jax.jit(lambda p, *state: SOLUTIONS[solution](robot, *state, parameters=p))
    heavier = p.at[:10].multiply(1.5)
    expected = getattr(robot.with_parameters(np.asarray(heavier)), solution)(*arrays)
    # Other parameters use the recursions, the robot uses its machine code.
    assert_allclose(call(heavier, *state), expected, rtol=0, atol=sized(robot, arrays[0], expected))
    pulled = getattr(robot, f"{solution}_pullback_with_parameters")(*arrays, weights)
    of_each = pulled.by_parameters
    gradients = jax.jit(jax.grad(lambda p, *state: (call(p, *state) * weights).sum(), argnums=(0, 2)))(p, *state)
    assert_allclose(gradients[0], of_each.sum(axis=0), rtol=0, atol=sized(robot, arrays[0], of_each))
    assert_allclose(gradients[1], pulled.by_velocity, rtol=0, atol=sized(robot, arrays[0], pulled.by_velocity))
    # Mapped over the states, over the parameters, and over both, with one set for all or one for each.
    each = jax.grad(lambda p, weight, *state: (call(p, *state) * weight).sum())
    mapped = jax.vmap(each, in_axes=(None, 0, 0, 0, 0))(p, weights, *state)
    assert_allclose(mapped, of_each, rtol=0, atol=sized(robot, arrays[0], of_each))
    many = jnp.stack([p, heavier, p])
    both = jax.vmap(call)(many, *state)
    assert np.array_equal(both[1], call(heavier, *state)[1]) and np.array_equal(both[2], call(p, *state)[2])
    assert np.array_equal(call(many, *state), both)
    over = jax.vmap(call, in_axes=(0, None, None, None))(many, *state)
    assert over.shape == (3, 3, robot.nv) and np.array_equal(over[1], call(heavier, *state))
    own = jax.grad(lambda many: (call(many, *state) * weights).sum())(many)
    assert_allclose(own[2], of_each[2], rtol=0, atol=sized(robot, arrays[0], of_each))
    # Forward mode agrees with reverse mode.
    change = jnp.asarray(np.random.default_rng(4).uniform(-1, 1, p.shape))
    _, along = jax.jvp(lambda p: (call(p, *state) * weights).sum(), (p,), (change,))
    assert float(along) == pytest.approx(float(of_each.sum(axis=0) @ np.asarray(change)), rel=1e-9)
    rows = jax.jacfwd(lambda p: call(p, *(x[0] for x in state)))(p)
    assert_allclose(
        rows, jax.jacrev(lambda p: call(p, *(x[0] for x in state)))(p), rtol=0, atol=sized(robot, arrays[0], rows)
    )
    with pytest.raises(Exception, match="parameters of state 1: .* first moment"):
        jax.block_until_ready(call(many.at[1, 0].set(0.0).at[1, 1].set(1.0), *state))
    with pytest.raises(rd.ShapeError, match="parameters has shape"):
        call(p[:-1], *state)


@pytest.mark.parametrize("torques", ["none", "held", "each"])
def test_rollouts_have_gradients_by_parameters(torques: str) -> None:
    how: dict[str, Any] = {"steps": 6, "dt": 5e-3, "stride": 2, "dissipation": True}
    robot = load("two_r")
    values = robot.parameters()
    values[robot.parameter_names.index("shoulder.damping")] = 0.4
    robot, p = robot.with_parameters(values), jnp.asarray(values)
    q, v, _ = given(robot, "inverse_dynamics")
    shape = {"none": None, "held": (3, robot.nv), "each": (3, 6, robot.nv)}[torques]
    tau = None if shape is None else jnp.asarray(np.random.default_rng(1).uniform(-1, 1, shape))

    def call(p: Any, q: Any, v: Any, tau: Any) -> Any:
        return rdj.rollout(robot, q, v, tau, parameters=p, **how)

    arrays: Any = [None if x is None else np.asarray(x) for x in (q, v, tau)]
    expected = robot.rollout(*arrays, **(how | EXPLICIT))
    found = jax.jit(call)(p, q, v, tau)
    # Other parameters use the recursions, the robot uses its machine code.
    assert_allclose(found.v, expected.v, rtol=1e-11, atol=1e-12)
    assert_allclose(found.q_trajectory, expected.q_trajectory, rtol=1e-11, atol=1e-12)
    weights = [np.random.default_rng(3).uniform(-1, 1, x.shape) for x in found]
    names = ("by_position", "by_velocity", "by_position_trajectory", "by_velocity_trajectory")

    def loss(p: Any) -> Any:
        return sum((x * weight).sum() for x, weight in zip(call(p, q, v, tau), weights, strict=True))

    cotangents: dict[str, Any] = dict(zip(names, weights, strict=True))
    pulled: Any = robot.rollout_pullback(*arrays, parameters=True, **cotangents, **how)  # type: ignore[misc]
    of_each = pulled.by_parameters
    assert of_each is not None
    gradient = jax.jit(jax.grad(loss))(p)
    assert_allclose(gradient, of_each.sum(axis=0), rtol=0, atol=sized(robot, arrays[0], of_each))
    change = jnp.asarray(np.random.default_rng(4).uniform(-1, 1, p.shape))
    _, along = jax.jvp(loss, (p,), (change,))
    assert float(along) == pytest.approx(float(gradient @ change), rel=1e-9)
    # A robot for each state, as in domain randomisation: each has its own gradient.
    many = jnp.stack([p, p.at[0].multiply(2.0), p])
    ends = jax.vmap(lambda p, q, v: rdj.rollout(robot, q, v, parameters=p, **how).v)(many, q, v)
    heavy = robot.with_parameters(np.asarray(many[1]))
    assert_allclose(ends[1], heavy.rollout(arrays[0][1:2], arrays[1][1:2], **how, **EXPLICIT).v[0], rtol=1e-11, atol=1e-12)
    own = jax.vmap(jax.grad(lambda p, q, v: rdj.rollout(robot, q, v, parameters=p, **how).v.sum()))(many, q, v)
    pulled = heavy.rollout_pullback(arrays[0][1:2], arrays[1][1:2], by_velocity=np.ones(2), parameters=True, **how)
    assert pulled.by_parameters is not None
    assert_allclose(own[1], pulled.by_parameters[0], rtol=0, atol=sized(robot, arrays[0], own[1]))
    ends = rdj.step(robot, q, v, tau if torques == "held" else None, dt=1e-3, dissipation=True, parameters=many)
    assert ends[0].shape == (3, robot.nq)


def test_a_step_is_a_rollout_of_one(panda: rd.Robot) -> None:
    q, v, tau = given(panda, "forward_dynamics")
    ends = rdj.step(panda, q[0], v[0], tau, dt=1e-3)
    expected = panda.rollout(np.tile(q[0], (3, 1)), np.asarray(v[0]), np.asarray(tau), steps=1, dt=1e-3, **FREE)
    assert np.array_equal(ends[0], expected.q) and np.array_equal(ends[1], expected.v)
    check_grads(jax.jit(lambda *x: rdj.step(panda, *x, dt=1e-2)), (q, v, tau), **DIFFERENCES)


def test_float32_stays_float32(panda: rd.Robot) -> None:
    state = [x.astype(jnp.float32) for x in given(panda, "forward_dynamics")]
    a, gradient = jax.value_and_grad(lambda *x: rdj.forward_dynamics(panda, *x).sum())(*state)
    assert a.dtype == gradient.dtype == jnp.float32
    p = jnp.asarray(panda.parameters(), jnp.float32)
    assert jax.grad(lambda p: rdj.forward_dynamics(panda, *state, parameters=p).sum())(p).dtype == jnp.float32
    expected = panda.forward_dynamics(*(np.asarray(x) for x in state))
    assert np.array_equal(rdj.forward_dynamics(panda, *state), expected)


def test_a_loss_is_made_small(panda: rd.Robot) -> None:
    rest = jnp.zeros(7)

    def effort(q: Any) -> Any:
        return (rdj.inverse_dynamics(panda, q, rest, rest) ** 2).sum(axis=-1).mean()

    descend = jax.jit(jax.value_and_grad(effort))
    q = jnp.asarray(states(panda, 64).q)
    efforts = []
    for _ in range(200):
        value, gradient = descend(q)
        efforts.append(float(value))
        q = q - 0.005 * 64 * gradient / (1.0 + jnp.abs(64 * gradient))
    assert efforts[-1] < 0.3 * efforts[0]


def test_programs_keep_their_robot_and_tell_robots_apart() -> None:
    import gc

    def program() -> Any:
        robot = load("two_r").with_gravity_scaled(0.25)
        return jax.jit(lambda q: rdj.inverse_dynamics(robot, q, jnp.zeros(2), jnp.zeros(2)))

    light, whole = program(), load("two_r")
    gc.collect()
    q = jnp.asarray([0.3, 1.2])
    heavy = jax.jit(lambda q: rdj.inverse_dynamics(whole, q, jnp.zeros(2), jnp.zeros(2)))
    assert_allclose(4.0 * light(q), heavy(q), rtol=1e-14)


def test_invalid_states_are_nan_alone(panda: rd.Robot) -> None:
    q, v, a = given(panda, "inverse_dynamics")
    p = jnp.asarray(panda.parameters())
    bad = v.at[1, 2].set(jnp.nan)
    others = np.array([0, 2])

    def of(call: Any) -> None:
        """The row of state 1 is NaN, and the others have the same bits as without it."""
        for found, right in zip(jax.tree.leaves(call(bad)), jax.tree.leaves(call(v)), strict=True):
            found, right = np.asarray(found), np.asarray(right)
            assert np.isnan(found[1]).all() and np.isfinite(right).all() and np.array_equal(found[others], right[others])

    def loss(v: Any, parameters: Any = None) -> Any:
        return rdj.rollout(panda, q, v, a, steps=3, parameters=parameters).v.sum(axis=-1)

    of(jax.jit(lambda v: rdj.inverse_dynamics(panda, q, v, a)))
    of(jax.jit(lambda v: rdj.forward_dynamics(panda, q, v, a, parameters=p)))
    of(lambda v: rdj.rollout(panda, q, v, a, steps=4, stride=4))
    of(jax.vmap(lambda v: rdj.inverse_dynamics(panda, q[0], v, a[0])))
    of(jax.jit(lambda v: jax.grad(lambda v: rdj.inverse_dynamics(panda, q, v, a).sum())(v)))
    of(jax.jit(lambda v: jax.grad(lambda v: loss(v).sum())(v)))
    of(lambda v: jax.jvp(loss, (v,), (jnp.ones_like(v),))[1])
    assert np.isnan(rdj.mass_matrix(panda, q[0].at[0].set(jnp.inf))).all()  # one state alone
    # Parameters that are not finite, for one state and for all.
    many = jnp.stack([p, p.at[4].set(jnp.nan), p])
    found = rdj.inverse_dynamics(panda, q, v, a, parameters=many)
    right = panda.inverse_dynamics(*map(np.asarray, (q, v, a)))[others]
    assert np.isnan(found[1]).all()
    assert_allclose(found[others], right, rtol=1e-12)
    assert np.isnan(loss(v, many[1])).all()
    dog = load("quadruped")
    start = jnp.asarray(dog.random_configuration(3, seed=1))
    found = rdj.mass_matrix(dog, start.at[2, 3:7].set(0.0))
    assert np.isnan(found[2]).all() and np.isfinite(found[:2]).all()


@pytest.mark.parametrize("solution", SOLUTIONS)
def test_hessians_are_those_of_numpy(panda: rd.Robot, solution: str) -> None:
    q, v, x = (each[0] for each in given(panda, solution, count=1))
    weights = np.linspace(-1.0, 1.0, panda.nv)
    expected = getattr(panda, f"{solution}_hessian")(np.asarray(q), np.asarray(v), np.asarray(x), weights)

    def loss(state: Any) -> Any:
        return SOLUTIONS[solution](panda, *jnp.split(state, 3)) @ weights

    state, size = jnp.concatenate([q, v, x]), np.abs(expected).max()
    for hessian in (jax.hessian(loss), jax.jacrev(jax.jacrev(loss)), jax.jit(jax.hessian(loss))):
        assert_allclose(hessian(state), expected, rtol=0, atol=1e-10 * size)


def test_gradients_of_gradients_match_differences() -> None:
    dog = load("quadruped")
    q, v, a = (each[0] for each in given(dog, "inverse_dynamics", count=1))
    tau = jnp.asarray(states(dog, 1).tau)[0]
    foot = dog.frame_names[-1]
    weights = jnp.asarray(states(dog, 1, seed=4).v)[0]
    for gradient in (
        jax.grad(lambda q: rdj.inverse_dynamics(dog, q, v, a) @ weights),
        jax.grad(lambda q: rdj.forward_dynamics(dog, q, v, tau) @ weights),
        jax.grad(lambda q: weights @ rdj.mass_matrix(dog, q) @ weights),
        jax.grad(lambda q: (rdj.frame_pose(dog, q, foot)[:3] ** 2).sum()),
    ):
        # Along a displacement, so that the quaternions keep their length.
        step = 1e-5
        ahead, behind = (jnp.asarray(dog.integrate(q, sign * step * weights)) for sign in (1.0, -1.0))
        along = (ahead - behind) / (2.0 * step)
        found = jax.jvp(gradient, (q,), (along,))[1]
        expected = (gradient(ahead) - gradient(behind)) / (2.0 * step)
        size = max(1.0, float(jnp.abs(expected).max()))
        assert_allclose(found, expected, rtol=0, atol=1e-5 * size)
        transposed = jax.vjp(gradient, q)[1](jnp.ones(dog.nq))[0] @ along
        assert_allclose(transposed, found.sum(), rtol=1e-7, atol=1e-7 * size)


def test_errors_have_the_messages_of_this_package(panda: rd.Robot) -> None:
    q, v, a = given(panda, "inverse_dynamics")
    with pytest.raises(rd.SimulationError, match="variational-midpoint solves an equation at each step"):
        rdj.step(panda, q, v, dt=1e-3, integrator="variational-midpoint")
    with pytest.raises(rd.ShapeError, match=r"v has shape \(3, 6\), robot `panda` needs \(..., 7\)"):
        rdj.inverse_dynamics(panda, q, v[:, :6], a)
    with pytest.raises(rd.ShapeError, match="do not broadcast"):
        rdj.inverse_dynamics(panda, q, v[:2], a)
    with pytest.raises(rd.DTypeError, match="nothing is converted silently"):
        rdj.inverse_dynamics(panda, q, v.astype(jnp.float32), a)
    with pytest.raises(rd.DTypeError, match="complex128"):
        rdj.mass_matrix(panda, q + 1j)
    with pytest.raises(rd.FrameError, match="no frame 'nose'"):
        rdj.frame_pose(panda, q, "nose")
    with pytest.raises(NotImplementedError, match="second derivatives are not available"):
        jax.hessian(lambda q: rdj.step(panda, q, v[0], dt=1e-3)[1].sum())(q[0])
    p = jnp.asarray(panda.parameters())
    with pytest.raises(NotImplementedError, match="with parameters: second derivatives are not available"):
        jax.hessian(lambda q: rdj.inverse_dynamics(panda, q, v[0], a[0], parameters=p).sum())(q[0])
    with pytest.raises(NotImplementedError, match="second derivatives are not available"):
        jax.grad(lambda q: jax.jvp(lambda q: rdj.mass_matrix(panda, q).sum(), (q,), (q,))[1])(q[0])


def test_long_calls_of_several_threads_are_right(panda: rd.Robot) -> None:
    from concurrent.futures import ThreadPoolExecutor

    s = states(panda, 3000)
    expected = panda.inverse_dynamics(s.q, s.v, s.a)
    with jax.enable_x64(True):
        call = jax.jit(lambda q, v, a: rdj.inverse_dynamics(panda, q, v, a))
        call(s.q, s.v, s.a)

    def run(_: int) -> bool:
        with jax.enable_x64(True):
            return np.array_equal(call(s.q, s.v, s.a), expected)

    with ThreadPoolExecutor(4) as pool:
        assert all(pool.map(run, range(20)))


@pytest.mark.parametrize("torques", ["held", "each"])
def test_rollouts_with_contact_have_the_gradients_of_numpy(quadruped: rd.Robot, torques: str) -> None:
    how: dict[str, Any] = {"steps": 6, "dt": 2e-3, "integrator": "implicit", "stride": 2, "ground": rd.Ground()}
    rng = np.random.default_rng(2)
    q = np.tile(quadruped.neutral(), (2, 1))
    q[:, 2] += [0.3, 0.02]
    v = 0.3 * rng.standard_normal((2, quadruped.nv))
    tau = rng.standard_normal((2, quadruped.nv) if torques == "held" else (2, 6, quadruped.nv))
    arrays = (q, v, tau)
    ends = jax.jit(lambda *state: rdj.rollout(quadruped, *state, **how))(*map(jnp.asarray, arrays))
    expected = quadruped.rollout(*arrays, **how)
    for own, numpy in zip(ends, (expected.q, expected.v, expected.q_trajectory, expected.v_trajectory), strict=True):
        assert np.array_equal(own, numpy)
    weights = [rng.standard_normal(x.shape) for x in ends]

    def loss(*state: Any) -> Any:
        found = rdj.rollout(quadruped, *state, **how)
        return sum((x * weight).sum() for x, weight in zip(found, weights, strict=True))

    gradients = jax.jit(jax.grad(loss, argnums=(0, 1, 2)))(*map(jnp.asarray, arrays))
    by_position = quadruped.cotangent_from_coordinates(expected.q, weights[0])
    by_way = quadruped.cotangent_from_coordinates(expected.q_trajectory, weights[2])
    pulled: Any = quadruped.rollout_pullback(
        *arrays,
        by_position=by_position,
        by_velocity=weights[1],
        by_position_trajectory=by_way,
        by_velocity_trajectory=weights[3],
        **how,
    )
    assert np.array_equal(gradients[0], quadruped.cotangent_to_coordinates(q, pulled.by_position))
    assert np.array_equal(gradients[1], pulled.by_velocity) and np.array_equal(gradients[2], pulled.by_force)
    each = jax.vmap(jax.grad(lambda q, v, tau: rdj.rollout(quadruped, q, v, tau, **how).v.sum(), argnums=2))(*arrays)
    pulled = quadruped.rollout_pullback(*arrays, by_velocity=np.ones((2, quadruped.nv)), **how)
    assert np.array_equal(each, pulled.by_force)


def test_steps_with_contact_are_nan_for_invalid_states(quadruped: rd.Robot) -> None:
    how: dict[str, Any] = {"dt": 2e-3, "integrator": "implicit", "ground": rd.Ground()}
    q = np.tile(quadruped.neutral(), (2, 1))
    q[1, 3] = np.nan
    ends = rdj.step(quadruped, jnp.asarray(q), jnp.zeros((2, quadruped.nv)), **how)
    assert np.isfinite(ends[0][0]).all() and np.isnan(ends[0][1]).all()
    with pytest.raises(rd.DTypeError, match="float64"):
        rdj.step(quadruped, jnp.asarray(q, jnp.float32), jnp.zeros(quadruped.nv, jnp.float32), **how)
    with pytest.raises(ValueError, match="has no contact"):
        rdj.step(quadruped, jnp.asarray(q), jnp.zeros(quadruped.nv), dt=1e-3, ground=rd.Ground())
    with pytest.raises(ValueError, match="takes no parameters"):
        rdj.step(quadruped, jnp.asarray(q), jnp.zeros(quadruped.nv), parameters=jnp.zeros(3), **how)
