"""Every algorithm on one state and on many, against identities of mechanics."""

import inspect
from typing import Any

import numpy as np
import pytest
from numpy.testing import assert_allclose

import robot_dynamics as rd
from conftest import states
from robot_dynamics import _native
from robot_dynamics.quantities import REFERENCE_FRAMES

ARRAYS = ("q", "v", "a", "tau", "cotangent", "coordinates")


def rows() -> list[tuple[str, list[str]]]:
    """Every computing method: its name and its arguments, in each reference frame."""
    found = []
    for name, value in vars(_native.Robot).items():
        if inspect.ismethoddescriptor(value) and not name.startswith("_"):
            arguments = list(inspect.signature(value).parameters)
            if "out" in arguments:
                own = [each for each in arguments if each not in ("self", "out", "threads", "reference_frame")]
                references: list[list[str]] = [[]]
                if "reference_frame" in arguments:
                    references = [[each] for each in REFERENCE_FRAMES]
                found += [(name, own + reference) for reference in references]
    return found


ROWS = rows()
COMPUTED = [(name, names) for name, names in ROWS if set(names) <= {*ARRAYS, "frame", "frames", *REFERENCE_FRAMES}]


def arguments(robot: rd.Robot, names: list[str], pick: Any = slice(None), dtype: Any = np.float64) -> list[Any]:
    """The arguments of a method: states, and the last frame."""
    own = states(robot)
    last: dict[str, Any] = {"frame": robot.frame_names[-1], "frames": robot.frame_names[-2:]}
    last |= {reference: reference for reference in REFERENCE_FRAMES}
    return [last[name] if name in last else getattr(own, name)[pick].astype(dtype) for name in names]


def parts(result: Any) -> list[Any]:
    """The arrays of a result, one or several."""
    return list(result) if isinstance(result, tuple) else [result]


def test_every_row_of_the_table_is_a_method_with_its_arguments() -> None:
    for name, read, results in _native.quantities():
        method, expected = name, [*read, "frames"] if name == "frame_poses" else read
        if name.startswith("frame_jacobian_"):
            method, expected = "frame_jacobian", [*read, name.removeprefix("frame_jacobian_")]
        assert (method, expected) in ROWS, f"rows of crates/python/src/rows: `{method}` reads {expected}"
        assert (results > 1) == (name in rd.results.BY_ALGORITHM)


def test_an_unknown_reference_frame_names_the_valid_ones(panda: rd.Robot) -> None:
    with pytest.raises(ValueError, match="reference_frame must be 'local', 'world' or 'local_world_aligned'"):
        panda.frame_jacobian(panda.neutral(), "panda_link8", "body")  # type: ignore[call-overload]


@pytest.mark.parametrize(("name", "names"), COMPUTED)
def test_many_states_are_each_one(robot: rd.Robot, name: str, names: list[str]) -> None:
    method = getattr(robot, name)
    many = parts(method(*arguments(robot, names)))
    for k in (0, 5, 36):
        for batch, one in zip(many, parts(method(*arguments(robot, names, k))), strict=True):
            # The sums run in another order: κ(M) times rounding.
            assert_allclose(batch[k], one, rtol=1e-9, atol=1e-9 * max(1.0, np.abs(one).max(initial=0.0)))


@pytest.mark.parametrize(("name", "names"), COMPUTED)
def test_a_batch_is_its_states_bit_for_bit_however_it_is_cut(panda: rd.Robot, name: str, names: list[str]) -> None:
    method = getattr(panda, name)
    whole = parts(method(*arguments(panda, names), threads=1))
    for pieces in ([slice(0, 1), slice(1, 37)], [slice(0, 20), slice(20, 37)]):
        cut = [parts(method(*arguments(panda, names, piece), threads=1)) for piece in pieces]
        for k, together in enumerate(whole):
            assert np.array_equal(np.concatenate([piece[k] for piece in cut]), together)
    for threads in (2, 3):
        for k, result in enumerate(parts(method(*arguments(panda, names), threads=threads))):
            assert np.array_equal(result, whole[k])


@pytest.mark.parametrize(("name", "names"), COMPUTED)
def test_float32_in_is_float32_out_and_the_same_numbers(panda: rd.Robot, name: str, names: list[str]) -> None:
    method = getattr(panda, name)
    for pick in (3, slice(None)):
        exact = parts(method(*arguments(panda, names, pick)))
        for result, double in zip(parts(method(*arguments(panda, names, pick, np.float32))), exact, strict=True):
            assert result.dtype == np.float32
            assert_allclose(result, double, rtol=0, atol=3e-4 * max(1.0, np.abs(double).max()))


@pytest.mark.parametrize(("name", "names"), COMPUTED)
def test_out_is_written_and_returned(robot: rd.Robot, name: str, names: list[str]) -> None:
    method = getattr(robot, name)
    for pick in (3, slice(None)):
        given = arguments(robot, names, pick)
        expected = parts(method(*given))
        room = tuple(np.full_like(result, np.nan) for result in expected)
        out = room if len(room) > 1 else room[0]
        assert method(*given, out=out) is out
        for written, result in zip(room, expected, strict=True):
            assert np.array_equal(written, result)


def test_inverse_dynamics_is_the_equation_of_motion(robot: rd.Robot) -> None:
    s = states(robot)
    mass, coriolis, gravity = robot.mass_matrix(s.q), robot.coriolis_matrix(s.q, s.v), robot.gravity(s.q)
    tau = np.einsum("nij,nj->ni", mass, s.a) + np.einsum("nij,nj->ni", coriolis, s.v) + gravity
    assert_allclose(robot.inverse_dynamics(s.q, s.v, s.a), tau, rtol=0, atol=1e-10 * np.abs(tau).max())


def test_forward_dynamics_undoes_inverse_dynamics(robot: rd.Robot) -> None:
    s = states(robot)
    tau = robot.inverse_dynamics(s.q, s.v, s.a)
    condition = np.linalg.cond(robot.mass_matrix(s.q)).max()
    bound = 1e-15 * condition * (1.0 + np.abs(tau).max())
    assert_allclose(robot.forward_dynamics(s.q, s.v, tau), s.a, rtol=0, atol=bound)


def test_mass_matrix_is_the_product_of_its_factor(robot: rd.Robot) -> None:
    s = states(robot)
    mass, factor = robot.mass_matrix(s.q), robot.mass_matrix_factor(s.q)
    lower = np.tril(factor, -1) + np.eye(robot.nv)
    product = np.einsum("nki,nk,nkj->nij", lower, np.diagonal(factor, axis1=-2, axis2=-1), lower)
    assert_allclose(product, mass, rtol=0, atol=1e-14 * np.abs(mass).max())
    assert not np.triu(factor, 1).any()


def test_coriolis_is_half_the_rate_of_mass(robot: rd.Robot) -> None:
    s = states(robot)
    skew = robot.mass_matrix_rate(s.q, s.v) - 2.0 * robot.coriolis_matrix(s.q, s.v)
    assert_allclose(skew, -np.swapaxes(skew, -1, -2), rtol=0, atol=1e-10)


def test_power_is_the_rate_of_energy(robot: rd.Robot) -> None:
    s, h = states(robot), 1e-6
    accelerations = robot.forward_dynamics(s.q, s.v, s.tau)

    def energy(t: float) -> Any:
        # The state after t, to second order. The velocity rotates with the body, which a does not include.
        q = robot.integrate(s.q, s.v * t + 0.5 * t * t * accelerations)
        v = s.v + t * accelerations
        return robot.kinetic_energy(q, v) + robot.potential_energy(q)

    power = np.einsum("ni,ni->n", s.tau, s.v)
    scale = np.abs(s.tau).max() * np.abs(s.v).max() * robot.nv
    assert_allclose((energy(h) - energy(-h)) / (2 * h), power, rtol=0, atol=1e-5 * scale)


def test_derivatives_are_differences(robot: rd.Robot) -> None:
    s, h = states(robot, 3), 1e-6
    derivatives = robot.inverse_dynamics_derivatives(s.q, s.v, s.a)
    for j in range(robot.nv):
        step = np.zeros(robot.nv)
        step[j] = h
        ahead = robot.inverse_dynamics(robot.integrate(s.q, step), s.v, s.a)
        behind = robot.inverse_dynamics(robot.integrate(s.q, -step), s.v, s.a)
        scale = np.abs(derivatives.by_position).max()
        assert_allclose(derivatives.by_position[..., j], (ahead - behind) / (2 * h), rtol=0, atol=1e-6 * scale)


def test_pullbacks_are_the_derivatives_transposed(robot: rd.Robot) -> None:
    s = states(robot)

    def pulled(slope: Any) -> Any:
        return np.einsum("ni,nij->nj", s.cotangent, slope)

    derivatives = robot.inverse_dynamics_derivatives(s.q, s.v, s.a)
    expected = pulled(derivatives.by_position), pulled(derivatives.by_velocity), pulled(robot.mass_matrix(s.q))
    for pullback, product in zip(robot.inverse_dynamics_pullback(s.q, s.v, s.a, s.cotangent), expected, strict=True):
        assert_allclose(pullback, product, rtol=0, atol=1e-12 * (1.0 + np.abs(product).max()))
    by_force = robot.forward_dynamics_derivatives(s.q, s.v, s.tau)
    condition = np.linalg.cond(robot.mass_matrix(s.q)).max()
    result = robot.forward_dynamics_pullback(s.q, s.v, s.tau, s.cotangent)
    for pullback, slope in zip(result, by_force, strict=True):
        product = pulled(slope)
        assert_allclose(pullback, product, rtol=0, atol=1e-15 * condition * (1.0 + np.abs(product).max()))


def test_gradients_by_the_numbers_of_q_are_differences(robot: rd.Robot) -> None:
    s, h = states(robot, 3), 1e-6
    here = robot.cotangent_to_coordinates(s.q, robot.gravity(s.q))  # the gradient of V
    assert_allclose(robot.cotangent_from_coordinates(s.q, here), robot.gravity(s.q), rtol=0, atol=1e-10)
    for j in range(robot.nq):
        step = np.zeros(robot.nq)
        step[j] = h
        ahead = robot.potential_energy(robot.normalize(s.q + step))
        behind = robot.potential_energy(robot.normalize(s.q - step))
        scale = 1.0 + np.abs(here).max()
        assert_allclose(here[:, j], (ahead - behind) / (2 * h), rtol=0, atol=1e-6 * scale)


def test_jacobians_move_frames(robot: rd.Robot) -> None:
    s = states(robot)
    for frame in (0, robot.frame_names[-1]):
        jacobian = robot.frame_jacobian(s.q, frame)
        moved = np.einsum("nij,nj->ni", jacobian, s.v)
        assert_allclose(robot.frame_velocity(s.q, s.v, frame), moved, rtol=0, atol=1e-11)
    poses = robot.frame_poses(s.q)
    assert_allclose(poses[:, -1], robot.frame_pose(s.q, robot.frame_names[-1]), rtol=0, atol=1e-13)
    assert_allclose(poses[..., 3, :], np.broadcast_to([0.0, 0.0, 0.0, 1.0], poses.shape[:2] + (4,)))


def test_wrenches_act_through_the_jacobian(robot: rd.Robot) -> None:
    s = states(robot)
    frames = robot.frame_names[0], robot.frame_names[-1]
    random = np.random.default_rng(9)
    pushes = {frame: random.uniform(-1, 1, (37, 6)) for frame in frames}
    pushes[frames[0]] = pushes[frames[0]][0]  # one row for all states
    through = sum(
        np.einsum("nij,ni->nj", robot.frame_jacobian(s.q, frame, "local"), np.broadcast_to(push, (37, 6)))
        for frame, push in pushes.items()
    )
    tau = robot.inverse_dynamics_with_wrenches(s.q, s.v, s.a, dict(pushes))
    assert_allclose(tau, robot.inverse_dynamics(s.q, s.v, s.a) - through, rtol=0, atol=1e-10 * np.abs(tau).max())
    condition = np.linalg.cond(robot.mass_matrix(s.q)).max()
    back = robot.forward_dynamics_with_wrenches(s.q, s.v, tau, dict(pushes))
    assert_allclose(back, s.a, rtol=0, atol=1e-15 * condition * (1.0 + np.abs(tau).max()))
    one = robot.inverse_dynamics_with_wrenches(s.q[3], s.v[3], s.a[3], {frames[1]: pushes[frames[1]][3]})
    assert one.shape == (robot.nv,)
    nothing = robot.inverse_dynamics_with_wrenches(s.q[3], s.v[3], s.a[3], {})
    assert np.array_equal(nothing, robot.inverse_dynamics(s.q[3], s.v[3], s.a[3]))
    with pytest.raises(rd.ShapeError, match="force then moment"):
        robot.inverse_dynamics_with_wrenches(s.q, s.v, s.a, {frames[1]: np.zeros(5)})


def test_steps_along_the_space_and_back(robot: rd.Robot) -> None:
    s = states(robot)
    there = robot.integrate(s.q, s.v)
    assert_allclose(robot.difference(s.q, there), s.v, rtol=0, atol=1e-12)
    half = robot.interpolate(s.q, there, 0.5)
    assert_allclose(robot.difference(s.q, half), 0.5 * s.v, rtol=0, atol=1e-12)
