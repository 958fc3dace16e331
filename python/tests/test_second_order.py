"""Second derivatives against differences of first derivatives, each other and Pinocchio."""

from typing import Any

import numpy as np
import pytest
from numpy.testing import assert_allclose

import robot_dynamics as rd
from conftest import NAMES, ROBOTS, load, states

THIRD = {"inverse_dynamics": "a", "forward_dynamics": "tau"}


def rates(robot: rd.Robot, gradient: Any, q: Any, v: Any, x: Any, step: float = 1e-5) -> Any:
    """Central differences of a gradient along q ⊕ δ, v and the third argument, a row for each direction."""
    rows = []
    for k in range(3 * robot.nv):
        along = np.zeros(3 * robot.nv)
        along[k] = step
        dq, dv, dx = np.split(along, 3)
        ahead = np.concatenate(gradient(robot.integrate(q, dq), v + dv, x + dx))
        behind = np.concatenate(gradient(robot.integrate(q, -dq), v - dv, x - dx))
        rows.append((ahead - behind) / (2.0 * step))
    return np.array(rows)


@pytest.mark.parametrize("solution", THIRD)
def test_hessians_match_differences_of_pullbacks(robot: rd.Robot, solution: str) -> None:
    s = states(robot, 2)
    q, v, x, weights = s.q[0], s.v[0], getattr(s, THIRD[solution])[0], s.cotangent[0]
    pullback = getattr(robot, f"{solution}_pullback")
    rate = rates(robot, lambda q, v, x: pullback(q, v, x, weights), q, v, x)
    derivative = getattr(robot, f"{solution}_pullback_derivative")(q, v, x, weights)
    hessian = getattr(robot, f"{solution}_hessian")(q, v, x, weights)
    # Truncation and rounding of a difference with this step are about 1e-9 of the largest number; a pullback
    # through M⁻¹ has a relative error of κ(M) ε on top of it.
    condition = np.linalg.cond(robot.mass_matrix(q)) if solution == "forward_dynamics" else 1.0
    scale = max(1.0, np.abs(rate).max()) * max(1.0, 1e-3 * condition)
    assert_allclose(derivative, rate, rtol=0, atol=1e-6 * scale)
    assert_allclose(hessian, (rate + rate.T) / 2.0, rtol=0, atol=1e-6 * scale)
    assert np.array_equal(hessian, hessian.T)


@pytest.mark.parametrize("solution", THIRD)
def test_products_tensors_and_batches_agree_with_hessians(robot: rd.Robot, solution: str) -> None:
    s, count = states(robot, 3), 3
    x, nv = getattr(s, THIRD[solution]), robot.nv
    hessian = getattr(robot, f"{solution}_hessian")(s.q, s.v, x, s.cotangent)
    assert hessian.shape == (count, 3 * nv, 3 * nv)
    along = np.random.default_rng(8).uniform(-1.0, 1.0, (count, 3 * nv))
    product = getattr(robot, f"{solution}_hessian_product")(s.q, s.v, x, s.cotangent, along)
    condition = np.linalg.cond(robot.mass_matrix(s.q)).max() if solution == "forward_dynamics" else 1.0
    atol = 1e-11 * np.abs(hessian).max() * max(1.0, 1e-2 * condition)
    assert_allclose(product, np.einsum("nij,nj->ni", hessian, along), rtol=0, atol=atol)
    second = getattr(robot, f"{solution}_second_derivatives")(s.q, s.v, x)
    blocks = [(0, 0), (0, 1), (1, 1), (0, 2)]
    for tensor, (row, column) in zip(second, blocks, strict=True):
        part = hessian[:, row * nv : (row + 1) * nv, column * nv : (column + 1) * nv]
        assert_allclose(np.einsum("ni,nijk->njk", s.cotangent, tensor), part, rtol=0, atol=atol)
    one = getattr(robot, f"{solution}_hessian")(s.q[1], s.v[1], x[1], s.cotangent[1])
    assert np.array_equal(one, hessian[1])


@pytest.mark.parametrize("name", ["two_r", "panda", "quadruped"])
def test_jacobian_derivatives_are_those_of_pinocchio(name: str) -> None:
    pin = pytest.importorskip("pinocchio")
    path = ROBOTS / f"{name}.urdf"
    base = (pin.JointModelFreeFlyer(),) if NAMES[name] else ()
    model = pin.buildModelFromUrdf(str(path), *base)
    data, robot = model.createData(), rd.load(path, floating_base=NAMES[name])
    frame = robot.frame_names[-1]
    index = model.getFrameId(frame)
    assert robot.nv == model.nv
    order = robot.from_pinocchio(robot.to_pinocchio(robot.neutral()).q, np.arange(float(robot.nv))).v
    assert order is not None
    order = order.astype(int)
    seen: dict[Any, Any] = {"local": pin.LOCAL, "world": pin.WORLD, "local_world_aligned": pin.LOCAL_WORLD_ALIGNED}
    for q in states(robot, 3).q:
        theirs = np.asarray(robot.to_pinocchio(q).q)
        pin.computeJointJacobians(model, data, theirs)
        pin.updateFramePlacements(model, data)
        pin.computeJointKinematicHessians(model, data, theirs)
        for own, frame_of in seen.items():
            # Its array has the right shape, with the numbers in Fortran's order.
            found = np.asarray(pin.getFrameKinematicHessian(model, data, index, frame_of))
            found = found.ravel().reshape(found.shape, order="F")
            expected = found[:, order][:, :, order]
            ours = robot.frame_jacobian_derivative(q, frame, own)
            assert_allclose(ours, expected, rtol=0, atol=1e-12, err_msg=own)


def test_frames_agree_with_their_jacobians(robot: rd.Robot) -> None:
    s, nv, frame = states(robot, 2), robot.nv, robot.frame_names[-1]
    weights = np.random.default_rng(3).uniform(-1.0, 1.0, (2, 6))
    for seen in ("local", "world", "local_world_aligned"):
        derivative = np.einsum("nr,nrjk->njk", weights, robot.frame_jacobian_derivative(s.q, frame, seen))
        symmetric = (derivative + np.swapaxes(derivative, -1, -2)) / 2.0
        assert_allclose(robot.frame_pose_hessian(s.q, weights, frame, seen), symmetric, rtol=0, atol=1e-12)
        hessian = robot.frame_velocity_hessian(s.q, s.v, weights, frame, seen)
        assert_allclose(hessian[:, nv:, :nv], derivative, rtol=0, atol=1e-12)
        assert not hessian[:, nv:, nv:].any() and np.array_equal(hessian, np.swapaxes(hessian, -1, -2))


def test_bad_arguments_are_refused() -> None:
    robot = rd.example("two_r")
    q, v, a, weights = [0.3, 1.2], [1.0, -2.0], [3.0, 4.0], [1.0, 0.0]
    with pytest.raises(rd.ShapeError, match=r"3·nv = 6"):
        robot.inverse_dynamics_hessian_product(q, v, a, weights, np.zeros(4))
    with pytest.raises(rd.StateError, match="direction"):
        robot.inverse_dynamics_hessian_product(q, v, a, weights, np.full(6, np.nan))
    with pytest.raises(rd.BadStatesError) as error:
        robot.inverse_dynamics_hessian(q, [v, [np.inf, 0.0]], a, weights)
    assert list(error.value.indices) == [1] and np.isfinite(error.value.result[0]).all()


def test_linearized_steps_of_a_batch_are_those_of_its_states() -> None:
    # Exact derivatives of an explicit method, and differences of the default method with stops and effort
    # limits.
    exact: dict[str, Any] = {"conservative": True}
    for robot, options in ((load("quadruped"), exact), (load("panda"), {})):
        s = states(robot, 5)
        many = robot.linearize_step(s.q, s.v[0], s.tau, dt=1e-3, **options)
        assert many.by_state.shape == (5, 2 * robot.nv, 2 * robot.nv)
        for k in range(5):
            one = robot.linearize_step(s.q[k], s.v[0], s.tau[k], dt=1e-3, **options)
            assert np.array_equal(many.by_state[k], one.by_state) and np.array_equal(many.by_force[k], one.by_force)
    robot = load("quadruped")
    s = states(robot, 5)
    bad = s.q.copy()
    bad[1, 3:7], bad[3] = 0.0, np.nan
    with pytest.raises(rd.BadStatesError, match="2 of 5 states are bad, the first is state 1") as error:
        robot.linearize_step(bad, s.v, dt=1e-3, conservative=True, threads=2)
    assert list(error.value.indices) == [1, 3]
    by_state, _ = error.value.result
    assert np.isnan(by_state[[1, 3]]).all() and np.isfinite(by_state[[0, 2, 4]]).all()
    with pytest.raises(rd.ShapeError, match="q has shape"):
        robot.linearize_step(s.q[:, :5], s.v, dt=1e-3)
