"""The dynamics as differentiable functions of tensors, where PyTorch is installed."""

from typing import Any

import numpy as np
import pytest
from numpy.testing import assert_allclose

import robot_dynamics as rd
from conftest import load, states

torch: Any = pytest.importorskip("torch")

from robot_dynamics.torch import forward_dynamics, inverse_dynamics, rollout, step  # noqa: E402

SOLUTIONS = {"inverse_dynamics": inverse_dynamics, "forward_dynamics": forward_dynamics}


def given(robot: rd.Robot, solution: str, count: int = 3, dtype: Any = None) -> list[Any]:
    """Arguments of the solution, as leaf tensors."""
    s = states(robot, count)
    numbers = (s.q, s.v, s.a if solution == "inverse_dynamics" else s.tau)
    return [torch.tensor(each, dtype=dtype or torch.float64, requires_grad=True) for each in numbers]


@pytest.mark.parametrize("solution", SOLUTIONS)
def test_values_are_the_methods(robot: rd.Robot, solution: str) -> None:
    state = given(robot, solution)
    expected = getattr(robot, solution)(*(each.detach().numpy() for each in state))
    assert np.array_equal(SOLUTIONS[solution](robot, *state).detach().numpy(), expected)


@pytest.mark.parametrize("solution", SOLUTIONS)
@pytest.mark.parametrize("name", ["two_r", "panda", "gripper"])
def test_gradients_are_differences(name: str, solution: str) -> None:
    robot = load(name)
    state = given(robot, solution)
    state[1] = state[1][0].detach().requires_grad_()  # one velocity for all

    def call(*state: Any) -> Any:
        return SOLUTIONS[solution](robot, *state)

    assert torch.autograd.gradcheck(call, state, eps=1e-6, atol=1e-4, rtol=1e-5)


def test_invalid_states_are_nan_alone() -> None:
    robot = load("panda")
    q, v, tau = (x.detach() for x in given(robot, "forward_dynamics"))
    others = [0, 2]
    bad = v.clone()
    bad[1, 2] = torch.nan

    def of(call: Any) -> None:
        """The row of state 1 is NaN, and the others have the same bits as without it."""
        for found, right in zip(call(bad.requires_grad_()), call(v.requires_grad_()), strict=True):
            assert found[1].isnan().all() and right.isfinite().all() and torch.equal(found[others], right[others])

    def end(v: Any, **how: Any) -> Any:
        return rollout(robot, q, v, tau, steps=4, dt=1e-3, **how)

    of(lambda v: [inverse_dynamics(robot, q, v, tau).detach(), forward_dynamics(robot, q, v, tau).detach()])
    of(lambda v: [x.detach() for x in end(v, stride=2)])
    of(lambda v: torch.autograd.grad(forward_dynamics(robot, q, v, tau).sum(), v))
    of(lambda v: torch.autograd.grad(end(v, stride=2).v_trajectory.sum(), v))
    # One state alone, and parameters that are not finite.
    assert forward_dynamics(robot, q[1], bad[1].detach(), tau[1]).isnan().all()
    one = rollout(robot, q[1], bad[1].detach(), tau[1], steps=3)
    assert one.q.isnan().all() and one.q.shape == (7,)
    p = torch.as_tensor(robot.parameters())
    p[3] = torch.nan
    assert end(v.detach(), parameters=p).v.isnan().all()
    assert inverse_dynamics(robot, q, v.detach(), tau, parameters=p).isnan().all()


def test_quaternions_have_gradients_by_their_numbers() -> None:
    robot = load("quadruped")
    q, v, a = given(robot, "inverse_dynamics")

    def call(q: Any) -> Any:
        unit = q[..., 3:7] / q[..., 3:7].norm(dim=-1, keepdim=True)
        return inverse_dynamics(robot, torch.cat([q[..., :3], unit, q[..., 7:]], dim=-1), v.detach(), a.detach())

    assert torch.autograd.gradcheck(call, (q,), eps=1e-6, atol=1e-4, rtol=1e-5)


@pytest.mark.parametrize("solution", SOLUTIONS)
def test_vmap_and_grad_are_a_batch(solution: str) -> None:
    robot = load("panda")
    q, v, x = (each.detach() for each in given(robot, solution, 5))
    call = SOLUTIONS[solution]
    whole = call(robot, q, v[0], x)
    mapped = torch.func.vmap(lambda q, x: call(robot, q, v[0], x))(q, x)
    assert torch.equal(mapped, whole)

    def loss(q: Any, v: Any, x: Any) -> Any:
        return call(robot, q, v, x).square().sum()

    each = torch.func.vmap(torch.func.grad(loss, argnums=(0, 1, 2)), in_dims=(0, None, 0))(q, v[0], x)
    leaves = [q.clone().requires_grad_(), v[0].expand(5, -1).clone().requires_grad_(), x.clone().requires_grad_()]
    loss(*leaves).backward()
    for own, leaf in zip(each, leaves, strict=True):
        assert_allclose(own, leaf.grad, rtol=1e-12, atol=1e-12)


def test_a_loss_is_made_small() -> None:
    robot = load("panda")
    q = torch.tensor(states(robot, 64).q, requires_grad=True)
    rest = torch.zeros(7, dtype=torch.float64)
    optimizer = torch.optim.Adam([q], lr=0.02)
    efforts = []
    for _ in range(100):
        optimizer.zero_grad()
        effort = inverse_dynamics(robot, q, rest, rest).square().sum(dim=-1).mean()
        effort.backward()
        optimizer.step()
        efforts.append(effort.item())
    assert efforts[-1] < 0.1 * efforts[0]


def test_second_derivatives_and_invalid_tensors_raise_errors() -> None:
    robot = load("two_r")
    q, v, a = given(robot, "inverse_dynamics")
    (gradient,) = torch.autograd.grad(inverse_dynamics(robot, q, v, a).sum(), q, create_graph=True)
    with pytest.raises(RuntimeError, match="inverse_dynamics: second derivatives are not available"):
        gradient.sum().backward()
    with pytest.raises(rd.ShapeError, match="two_r"):
        inverse_dynamics(robot, q[:, :1], v, a)
    with pytest.raises(rd.DTypeError):
        inverse_dynamics(robot, q.float(), v, a)
    with pytest.raises(TypeError, match="expected a tensor, found list"):
        inverse_dynamics(robot, [0.0, 0.0], v, a)
    with pytest.raises(TypeError, match="give it tensor.cpu"):
        inverse_dynamics(robot, q.to("meta"), v, a)


def test_float32_stays_float32() -> None:
    robot = load("panda")
    q, v, tau = given(robot, "forward_dynamics", dtype=torch.float32)
    a = forward_dynamics(robot, q, v, tau)
    a.sum().backward()
    assert a.dtype == q.grad.dtype == torch.float32


COURSE: dict[str, Any] = {"steps": 5, "dt": 1e-2, "stride": 2}


@pytest.mark.parametrize("each_step", [False, True])
@pytest.mark.parametrize("name", ["two_r", "gripper"])
def test_rollouts_have_the_gradients_of_differences(name: str, each_step: bool) -> None:
    robot = load(name)
    q, v, _ = given(robot, "inverse_dynamics")
    shape = (3, 5, robot.nv) if each_step else (robot.nv,)  # torques for each step, or one row for all states
    tau = torch.tensor(np.random.default_rng(1).uniform(-1, 1, shape), requires_grad=True)

    def call(*state: Any) -> Any:
        return tuple(rollout(robot, *state, **COURSE))

    numbers = [each.detach().numpy() for each in (q, v, tau)]
    expected = robot.rollout(*numbers, **COURSE, integrator="rk4")
    arrays = (expected.q, expected.v, expected.q_trajectory, expected.v_trajectory)
    for own, array in zip(call(q, v, tau), arrays, strict=True):
        assert np.array_equal(own.detach().numpy(), array)
    assert torch.autograd.gradcheck(call, (q, v, tau), eps=1e-6, atol=1e-4, rtol=1e-5)


def test_a_step_is_a_rollout_of_one() -> None:
    robot = load("panda")
    q, v, tau = given(robot, "forward_dynamics")
    with torch.no_grad():
        ends = step(robot, q[0], v[0], tau, dt=1e-3), rollout(robot, q[:1].expand(3, -1), v[0], tau, steps=1)
    assert torch.equal(ends[0][0], ends[1].q) and torch.equal(ends[0][1], ends[1].v)
    assert torch.autograd.gradcheck(lambda *x: step(robot, *x, dt=1e-2), (q, v, tau), eps=1e-6, atol=1e-4, rtol=1e-5)


def test_a_floating_base_has_gradients_by_the_numbers_of_q_on_the_sphere() -> None:
    robot = load("quadruped")
    q, v, _ = given(robot, "inverse_dynamics", 2)

    def call(q: Any, v: Any) -> Any:
        unit = q[..., 3:7] / q[..., 3:7].norm(dim=-1, keepdim=True)
        end = rollout(robot, torch.cat([q[..., :3], unit, q[..., 7:]], dim=-1), v, steps=3, dt=1e-3)
        return end.q, end.v

    assert torch.autograd.gradcheck(call, (q, v), eps=1e-6, atol=1e-3, rtol=1e-4)


def test_parameters_have_gradients_and_are_found_by_descent() -> None:
    robot = load("two_r")
    names = robot.parameter_names
    values = robot.parameters()
    values[names.index("shoulder.damping")] = 0.8
    q, v, tau = (each.detach() for each in given(robot, "forward_dynamics", 8))
    how: dict[str, Any] = {"steps": 20, "dt": 5e-3, "dissipation": True, "stride": 5}
    seen = rollout(robot, q, v, tau, parameters=torch.tensor(values), **how)
    chosen = torch.tensor([float(name == "shoulder.damping") for name in names], dtype=torch.float64)

    def loss(damping: Any) -> Any:
        parameters = torch.tensor(robot.parameters()) + damping * chosen
        end = rollout(robot, q, v, tau, parameters=parameters, **how)
        return (end.v_trajectory - seen.v_trajectory).square().sum()

    damping = torch.tensor(0.2, dtype=torch.float64, requires_grad=True)
    assert torch.autograd.gradcheck(loss, (damping,), eps=1e-6, atol=1e-6, rtol=1e-5)
    optimizer = torch.optim.LBFGS([damping], max_iter=30, line_search_fn="strong_wolfe")

    def closure() -> Any:
        optimizer.zero_grad()
        value = loss(damping)
        value.backward()
        return value

    optimizer.step(closure)
    assert damping.item() == pytest.approx(0.8, abs=1e-6)


@pytest.mark.parametrize("solution", SOLUTIONS)
@pytest.mark.parametrize("name", ["two_r", "gripper", "quadruped"])
def test_solutions_have_gradients_by_parameters(name: str, solution: str) -> None:
    robot, call = load(name), SOLUTIONS[solution]
    state = [each.detach() for each in given(robot, solution)]
    parameters = torch.tensor(robot.parameters(), requires_grad=True)
    arrays = [each.numpy() for each in state]
    whole = call(robot, *state, parameters=parameters)
    assert_allclose(whole.detach(), getattr(robot, solution)(*arrays), rtol=1e-9, atol=1e-9)
    weights = np.random.default_rng(3).uniform(-1, 1, whole.shape)
    (whole * torch.tensor(weights)).sum().backward()
    of_each = getattr(robot, f"{solution}_pullback_with_parameters")(*arrays, weights).by_parameters
    scale = max(1.0, np.abs(of_each).max())
    assert_allclose(parameters.grad, of_each.sum(axis=0), rtol=0, atol=1e-9 * scale)

    def loss(parameters: Any, q: Any, v: Any, x: Any, weight: Any) -> Any:
        return (call(robot, q, v, x, parameters=parameters) * weight).sum()

    each = torch.func.vmap(torch.func.grad(loss), in_dims=(None, 0, 0, 0, 0))
    mapped = each(parameters.detach(), *state, torch.tensor(weights))
    assert_allclose(mapped, of_each, rtol=0, atol=1e-9 * scale)
    with pytest.raises(ValueError, match="parameters are mapped over"):
        torch.func.vmap(lambda p: call(robot, *state, parameters=p))(parameters.detach().repeat(3, 1))


def test_rollouts_map_and_refuse() -> None:
    robot = load("panda")
    q, v, tau = (each.detach() for each in given(robot, "forward_dynamics", 4))

    def loss(q: Any, v: Any, tau: Any) -> Any:
        return rollout(robot, q, v, tau, steps=4, dt=1e-2).v.square().sum()

    each = torch.func.vmap(torch.func.grad(loss, argnums=(0, 1, 2)), in_dims=(0, None, 0))(q, v[0], tau)
    leaves = [q.clone().requires_grad_(), v[:1].repeat(4, 1).requires_grad_(), tau.clone().requires_grad_()]
    loss(*leaves).backward()
    for own, leaf in zip(each, leaves, strict=True):
        assert_allclose(own, leaf.grad, rtol=1e-10, atol=1e-12)
    first = torch.autograd.grad(loss(*leaves), leaves[0], create_graph=True)[0]
    with pytest.raises(RuntimeError, match="rollout: second derivatives are not available"):
        first.sum().backward()
    many = torch.tensor(robot.parameters()).repeat(4, 1)
    with pytest.raises(ValueError, match="parameters are mapped over"):
        torch.func.vmap(lambda p: rollout(robot, q[0], parameters=p, steps=1).v)(many)
    with pytest.raises(ValueError, match="must have steps = 4"):
        rollout(robot, q, tau=tau[:, None], steps=4)
