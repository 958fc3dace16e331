"""Accepted and rejected arrays, and the messages of the errors."""

from typing import Any

import numpy as np
import pytest
from hypothesis import given, settings
from hypothesis import strategies as st
from hypothesis.extra import numpy as hnp

import robot_dynamics as rd
from conftest import states

PANDA = rd.example("panda")


@settings(max_examples=150, deadline=None)
@given(hnp.mutually_broadcastable_shapes(num_shapes=3, max_dims=3, max_side=4), st.sampled_from([np.float32, np.float64]))
def test_leading_dimensions_broadcast_as_in_numpy(shapes: Any, dtype: Any) -> None:
    random = np.random.default_rng(7)
    q, v, a = (random.uniform(-1, 1, (*shape, 7)).astype(dtype) for shape in shapes.input_shapes)
    tau = PANDA.inverse_dynamics(q, v, a)
    assert tau.shape == (*shapes.result_shape, 7) and tau.dtype == dtype
    wide = [np.broadcast_to(x, tau.shape) for x in (q, v, a)]
    assert np.array_equal(tau, PANDA.inverse_dynamics(*(np.ascontiguousarray(x) for x in wide)))
    assert np.array_equal(tau, PANDA.inverse_dynamics(*wide))  # strides of 0


@settings(max_examples=100, deadline=None)
@given(hnp.array_shapes(max_dims=4, max_side=8), hnp.array_shapes(max_dims=4, max_side=8))
def test_any_wrong_shape_is_refused_with_both_shapes(first: tuple[int, ...], second: tuple[int, ...]) -> None:
    q, v = np.zeros(first), np.zeros(second)
    try:
        expected = (*np.broadcast_shapes(first[:-1], second[:-1]), 7)
        is_right = first[-1] == second[-1] == 7
    except ValueError:
        is_right = False
    if is_right:
        assert PANDA.bias(q, v).shape == expected
        return
    with pytest.raises(rd.ShapeError) as error:
        PANDA.bias(q, v)
    shown = [str(shape) for shape, width in ((first, first[-1]), (second, second[-1])) if width != 7]
    assert any(text in str(error.value) for text in shown or [str(first)])
    assert not shown or "(7,)" in str(error.value)


@settings(max_examples=60, deadline=None)
@given(st.data())
def test_views_of_any_strides_and_offsets_are_read(data: st.DataObject) -> None:
    random = np.random.default_rng(3)
    base = random.uniform(-1, 1, (12, 3, 15))
    rows = data.draw(hnp.basic_indices((12,), min_dims=1, allow_newaxis=False, allow_ellipsis=False))
    q = base[rows][..., 1, ::2][..., :7]
    q.flags.writeable = False
    assert np.array_equal(PANDA.gravity(q), PANDA.gravity(np.ascontiguousarray(q)))
    backward = base[:, 0, 6::-1]
    assert np.array_equal(PANDA.gravity(backward), PANDA.gravity(backward.copy()))


def test_lists_and_integers_are_float64() -> None:
    expected = PANDA.gravity(np.array([0.0, 1.0, 0.0, 0.0, 0.0, 0.0, 0.0]))
    for q in ([0, 1, 0, 0, 0, 0, 0], (0.0, 1, 0, 0, 0, 0, 0), np.arange(7) == 1):
        if isinstance(q, np.ndarray):
            q = q.astype(np.int32)
        result = PANDA.gravity(q)
        assert result.dtype == np.float64 and np.array_equal(result, expected)


def test_the_other_byte_order_and_unaligned_memory_are_read() -> None:
    q = states(PANDA, 5).q
    swapped = q.astype(q.dtype.newbyteorder())
    memory = np.zeros(q.nbytes + 1, np.uint8)[1:].view()
    unaligned = np.frombuffer(memory.data, dtype=np.float64).reshape(q.shape)
    unaligned[...] = q
    assert not unaligned.flags.aligned
    for other in (swapped, unaligned, q[1:4][::-1][::-1]):
        expected = PANDA.gravity(q if len(other) == 5 else q[1:4])
        assert np.array_equal(PANDA.gravity(other), expected)


class Wrapped:
    """Object that holds an array."""

    def __init__(self, array: Any) -> None:
        self.array = array


class WithArray(Wrapped):
    """Object with the interface of a pandas column."""

    def __array__(self, dtype: Any = None, copy: bool | None = None) -> Any:
        return self.array


class WithDLPack(Wrapped):
    """Object with the interface of tensors of torch and arrays of jax."""

    def __dlpack__(self, **options: Any) -> Any:
        return self.array.__dlpack__(**options)

    def __dlpack_device__(self) -> Any:
        return self.array.__dlpack_device__()


@pytest.mark.parametrize("kind", [WithArray, WithDLPack])
def test_objects_with_array_interfaces_are_arrays(kind: type[WithArray | WithDLPack]) -> None:
    q = states(PANDA, 5).q
    for dtype in (np.float64, np.float32):
        own = q.astype(dtype)
        result = PANDA.gravity(kind(own))
        assert result.dtype == dtype and np.array_equal(result, PANDA.gravity(own))


@pytest.mark.parametrize("dtype", [np.float16, np.longdouble, np.complex128, np.bool_, object, "U3", "M8[s]"])
def test_any_other_type_is_refused(dtype: Any) -> None:
    with pytest.raises(rd.DTypeError, match="float64 and float32 are computed with"):
        PANDA.gravity(np.zeros(7).astype(dtype) if dtype != "M8[s]" else np.zeros(7, dtype))


def test_types_are_not_mixed_silently() -> None:
    q = np.zeros(7)
    with pytest.raises(rd.DTypeError, match="q is float64 and v is float32"):
        PANDA.bias(q, q.astype(np.float32))
    with pytest.raises(rd.DTypeError, match="out has dtype float32"):
        PANDA.gravity(q, out=np.zeros(7, np.float32))
    assert PANDA.interpolate(q.astype("f4"), q.astype("f4"), 0.5).dtype == np.float32


def test_objects_without_numbers_raise_errors() -> None:
    for nonsense in ("abc", None, object(), {"q": 1}, [[0.0] * 7, [0.0] * 6]):
        with pytest.raises((rd.DTypeError, rd.ShapeError)):
            PANDA.gravity(nonsense)  # type: ignore[call-overload]


def test_no_states_are_no_states() -> None:
    assert PANDA.mass_matrix(np.zeros((0, 7))).shape == (0, 7, 7)
    assert PANDA.kinetic_energy(np.zeros((3, 0, 7)), np.zeros(7)).shape == (3, 0)


def test_out_of_any_layout_is_written() -> None:
    q = states(PANDA, 6).q
    expected = PANDA.mass_matrix(q)
    layouts = [np.zeros((6, 7, 7), order="F"), np.zeros((6, 14, 7))[:, ::2], np.zeros((6, 7, 7), ">f8")]
    for out in layouts:
        assert PANDA.mass_matrix(q, out=out) is out
        assert np.array_equal(out, expected)


@pytest.mark.parametrize("count", [None, 1, 9])
def test_out_may_lie_over_what_is_read(count: int | None) -> None:
    shape = (7,) if count is None else (count, 7)
    q, v = np.random.default_rng(1).uniform(-1, 1, (2, *shape))
    expected = PANDA.integrate(q, v)
    assert np.array_equal(PANDA.integrate(q, v, out=q), expected) and np.array_equal(q, expected)
    table = np.zeros((3, *shape))
    table[:2] = [expected, v]
    shifted = table.reshape(-1)[3 : 3 + v.size].reshape(shape)  # overlaps both
    again = PANDA.integrate(table[0], table[1])
    assert np.array_equal(PANDA.integrate(table[0], table[1], out=shifted), again)


def test_out_that_cannot_be_written_is_refused() -> None:
    q, out = np.zeros(7), np.zeros(7)
    out.flags.writeable = False
    with pytest.raises(ValueError, match="read-only"):
        PANDA.gravity(q, out=out)
    with pytest.raises(rd.ShapeError, match=r"out has shape \(6,\), the result \(7,\)"):
        PANDA.gravity(q, out=np.zeros(6))
    with pytest.raises(TypeError, match="numpy array"):
        PANDA.gravity(q, out=[0.0] * 7)  # type: ignore[call-overload]
    with pytest.raises(TypeError, match="tuple of 2 arrays"):
        PANDA.inverse_dynamics_derivatives(q, q, q, out=np.zeros((7, 7)))  # type: ignore[call-overload]
    one = np.zeros((7, 7))
    derivatives = PANDA.inverse_dynamics_derivatives(q, q, q)
    with pytest.raises(ValueError, match="overlaps itself"):
        PANDA.inverse_dynamics_derivatives(q, q, q, out=(one, one))
    assert derivatives.by_position.shape == (7, 7)


@pytest.mark.parametrize("threads", [0, -1, 5000, 1.5, "two"])
def test_threads_are_a_number(threads: Any) -> None:
    with pytest.raises((ValueError, TypeError), match="threads"):
        PANDA.gravity(np.zeros((2, 7)), threads=threads)


def test_one_bad_number_is_named() -> None:
    q = np.zeros(7)
    for k, bad in ((2, np.nan), (6, np.inf)):
        wrong = q.copy()
        wrong[k] = bad
        with pytest.raises(rd.StateError, match=rf"v\[{k}\] \(coordinate `panda_joint{k + 1}`\)"):
            PANDA.bias(q, wrong)
    with pytest.raises(rd.StateError, match="too large"):
        PANDA.bias(q, np.full(7, 1e200))


def test_bad_states_are_named_and_the_others_are_valid() -> None:
    s = states(PANDA, 1000)
    q, bad = s.q.copy(), [17, 500, 999]
    q[bad, 3] = [np.nan, np.inf, -np.inf]
    for name in ("gravity", "mass_matrix", "potential_energy", "christoffel_symbols", "frame_poses"):
        method = getattr(PANDA, name)
        for threads in (1, 2):
            with pytest.raises(rd.BadStatesError, match=r"3 of 1000 .*state 17: q\[3\]") as error:
                method(q, threads=threads)
            assert error.value.indices.tolist() == bad
            good = np.delete(np.arange(1000), bad)
            assert np.array_equal(error.value.result[good], method(s.q)[good])
            assert np.isnan(error.value.result[bad]).reshape(3, -1).any(axis=1).all()
    out = np.zeros((10, 100, 7))
    with pytest.raises(rd.BadStatesError, match=r"first is state \(0, 17\)") as error:
        PANDA.gravity(q.reshape(10, 100, 7), out=out)
    assert error.value.result is out and np.array_equal(out[1], PANDA.gravity(s.q)[100:200])


def test_quaternions_have_unit_length(quadruped: rd.Robot) -> None:
    q = quadruped.neutral()
    q[3:7] = [0.0, 0.0, 0.0, 1.1]
    with pytest.raises(rd.StateError, match="quaternion"):
        quadruped.gravity(q)
    batch = np.stack([quadruped.neutral(), q])
    with pytest.raises(rd.BadStatesError, match="quaternion") as error:
        quadruped.gravity(batch)
    assert error.value.indices.tolist() == [1] and np.isnan(error.value.result[1]).all()
    with pytest.raises(rd.ShapeError, match="a floating base seven"):
        quadruped.gravity(np.zeros(quadruped.nv))


def test_frames_by_name_and_index() -> None:
    q = states(PANDA, 1).q[0]
    for index, name in enumerate(PANDA.frame_names):
        assert np.array_equal(PANDA.frame_pose(q, index), PANDA.frame_pose(q, name))
        assert np.array_equal(PANDA.frame_poses(q)[index], PANDA.frame_pose(q, name)) or np.allclose(
            PANDA.frame_poses(q)[index], PANDA.frame_pose(q, name), rtol=0, atol=1e-14
        )
    with pytest.raises(rd.FrameError, match="did you mean `panda_link3`"):
        PANDA.frame_pose(q, "link3")
    with pytest.raises(IndexError, match="has 9 from 0 on"):
        PANDA.frame_pose(q, 9)
    with pytest.raises(TypeError, match="name or its index"):
        PANDA.frame_pose(q, 1.5)  # type: ignore[call-overload]
