"""States in columns, quantities in columns."""

import pickle
from typing import Any

import numpy as np
import polars as pl
import pyarrow as pa
import pytest
from hypothesis import given, settings
from hypothesis import strategies as st
from numpy.typing import NDArray

import robot_dynamics as rd
from conftest import states
from robot_dynamics import arrow
from robot_dynamics.columns import array_of, column_of

PANDA = rd.example("panda")
NONE = np.zeros(0, np.intp)


def table(robot: rd.Robot, count: int, dtype: Any = np.float64) -> Any:
    s = states(robot, count)
    return pa.table({name: column_of(getattr(s, name).astype(dtype), NONE) for name in ("q", "v", "a", "tau")})


def numbers(column: Any) -> NDArray[Any]:
    """A column of nested lists as an array, through Python lists."""
    return np.array(column.to_pylist())


def test_every_quantity_is_what_its_method_gives(quadruped: rd.Robot) -> None:
    s = states(quadruped, 5)
    frame = quadruped.frame_names[-1]
    random = np.random.default_rng(2)
    state: dict[str, Any] = {name: getattr(s, name) for name in ("q", "v", "a", "tau", "cotangent", "coordinates")}
    state |= {"d": s.v, "q0": s.q, "q1": s.q[::-1].copy(), "s": random.uniform(0.0, 1.0, 5)}
    state |= {"direction": np.hstack([s.v, s.a, s.cotangent]), "weights": random.uniform(-1.0, 1.0, (5, 6))}
    given_table = pa.table({name: column_of(array, NONE) for name, array in state.items()})
    names = [name.replace("FRAME", frame) for name in arrow.quantity_names()]
    assert len(names) > 50
    for name in names:
        found = arrow.compute(quadruped, given_table, name)
        if name.startswith("audit"):
            continue
        reads = list(arrow.Computation(quadruped, [name]).reads)
        method_name, *given = name.split(":")
        arguments = dict(zip(("frame", "reference_frame"), given, strict=False))
        expected = getattr(quadruped, method_name)(*(state[each] for each in reads), **arguments)
        for column, array in zip(found.columns, expected if isinstance(expected, tuple) else [expected], strict=True):
            assert np.array_equal(numbers(column), array), name


@pytest.mark.parametrize("dtype", [np.float64, np.float32])
def test_memory_is_arrows_own(dtype: Any) -> None:
    batch = table(PANDA, 100, dtype).to_batches()[0]
    for part in (batch, batch.slice(17, 50)):
        array = array_of(part, "q", "q", 7, slice(None), "panda")
        values = part.column(0).values
        begins = values.buffers()[1].address + part.column(0).offset * 7 * array.itemsize
        assert array.ctypes.data == begins and array.dtype == dtype and array.shape == (len(part), 7)
        some = array_of(part, "q", "q", 4, slice(2, 6), "panda")  # a slice of each list, by strides
        assert some.ctypes.data == begins + 2 * array.itemsize and np.array_equal(some, array[:, 2:6])
    # The same for variable-size lists whose numbers are adjacent in memory.
    lists = pa.RecordBatch.from_pydict({"q": batch.column(0).cast(pa.list_(pa.from_numpy_dtype(dtype)))}).slice(3, 9)
    array = array_of(lists, "q", "q", 7, slice(None), "panda")
    assert array.ctypes.data == lists.column(0).values.buffers()[1].address + 3 * 7 * array.itemsize
    # Result columns share the memory of the computed arrays.
    mass = PANDA.mass_matrix(array)
    assert column_of(mass, NONE).values.values.buffers()[1].address == mass.ctypes.data


@settings(max_examples=40, deadline=None)
@given(st.lists(st.integers(0, 40), max_size=5), st.integers(0, 20))
def test_results_do_not_depend_on_how_a_table_is_cut(sizes: list[int], offset: int) -> None:
    whole = table(PANDA, offset + sum(sizes)).slice(offset)
    starts = np.cumsum([0, *sizes])
    chunks = [whole.slice(start, size) for start, size in zip(starts, sizes, strict=False)]
    cut = pa.concat_tables(chunks) if chunks else whole
    expected = arrow.compute(PANDA, whole.combine_chunks(), "inverse_dynamics", "potential_energy", "audit")
    found = arrow.compute(PANDA, cut, "inverse_dynamics", "potential_energy", "audit")
    assert found.combine_chunks().equals(expected.combine_chunks()) and found.num_rows == sum(sizes)
    streamed = arrow.stream(PANDA, cut.to_reader(max_chunksize=7), "inverse_dynamics", "potential_energy", "audit")
    assert streamed.read_all().combine_chunks().equals(expected.combine_chunks())


def test_tables_of_polars_are_read_and_written() -> None:
    s = states(PANDA, 50)
    frame = pl.DataFrame({"q": s.q, "v": s.v, "a": s.a, "name": [f"state {k}" for k in range(50)]})
    assert frame.schema["q"] == pl.Array(pl.Float64, 7)
    found = pl.DataFrame(arrow.compute(PANDA, frame, "inverse_dynamics", keep=["name"]))
    assert np.array_equal(found["inverse_dynamics"].to_numpy(), PANDA.inverse_dynamics(s.q, s.v, s.a))
    assert found["name"].to_list() == frame["name"].to_list()
    lists = frame.with_columns(pl.col("q").arr.to_list())
    assert lists.schema["q"] == pl.List(pl.Float64)
    both = pl.concat([lists[:20], lists[20:]], rechunk=False)
    assert pl.DataFrame(arrow.compute(PANDA, both, "inverse_dynamics", keep=["name"])).equals(found)
    # The stream of Polars, batch by batch.
    assert pl.DataFrame(arrow.stream(PANDA, both, "inverse_dynamics", keep=["name"])).equals(found)


def test_tables_of_duckdb_are_read() -> None:
    duckdb = pytest.importorskip("duckdb")
    given_table = table(PANDA, 50)
    connection = duckdb.connect()
    connection.register("states", given_table)
    some = connection.sql("select q, v from states")
    assert arrow.compute(PANDA, some, "bias").equals(arrow.compute(PANDA, given_table, "bias"))


def test_a_recording_has_its_own_names_and_more_numbers() -> None:
    s = states(PANDA, 30)
    state = np.hstack([s.q, s.v, np.ones((30, 1))]).astype(np.float32)  # the last number is a gripper
    recording = pa.table({"observation.state": list(state), "observation.effort": list(s.tau.astype(np.float32))})
    columns = {"q": "observation.state[:7]", "v": "observation.state[7:14]", "tau": "observation.effort"}
    found = arrow.compute(PANDA, recording, "forward_dynamics", columns=columns)
    q, v, tau = state[:, :7], state[:, 7:14], s.tau.astype(np.float32)
    assert found.schema.field(0).type == pa.list_(pa.float32(), 7)
    assert np.array_equal(numbers(found["forward_dynamics"]).astype(np.float32), PANDA.forward_dynamics(q, v, tau))
    found = arrow.compute(PANDA, recording, "forward_dynamics", columns=columns, dtype="float64")
    expected = PANDA.forward_dynamics(*(x.astype(np.float64) for x in (q, v, tau)))
    assert np.array_equal(numbers(found["forward_dynamics"]), expected)


def test_tensors_of_fixed_shape_are_read() -> None:
    s = states(PANDA, 10)
    recording = pa.table({"q": pa.FixedShapeTensorArray.from_numpy_ndarray(s.q)})
    assert np.array_equal(numbers(arrow.compute(PANDA, recording, "gravity")["gravity"]), PANDA.gravity(s.q))


def test_one_dof_is_a_column_of_numbers() -> None:
    text = rd.Robot.from_description(rd.example("two_r").describe()).lock(rd.example("two_r").joint_names[1])
    q = np.linspace(-1.0, 1.0, 9)
    found = arrow.compute(text, pa.table({"q": q}), "gravity", "potential_energy")
    assert np.array_equal(numbers(found["gravity"]), text.gravity(q[:, np.newaxis]))
    assert np.array_equal(found["potential_energy"].to_numpy(), text.potential_energy(q[:, np.newaxis]))


def test_bad_rows_are_named_and_lose_nothing() -> None:
    s = states(PANDA, 20)
    s.q[3, 4] = np.nan
    s.v[8, 0] = np.inf
    cut = pa.table({"q": list(s.q), "v": list(s.v)})
    cut = pa.concat_tables([cut[:6], cut[6:]])
    with pytest.raises(
        rd.BadStatesError, match=r"2 of 20 rows have no `bias`, the first is row 3: q\[4\].*NaN"
    ) as error:
        arrow.compute(PANDA, cut, "bias", "gravity")
    assert error.value.indices.tolist() == [3, 8]
    for result in (error.value.result, arrow.compute(PANDA, cut, "bias", "gravity", bad_states="null")):
        assert [k for k, row in enumerate(result["bias"].to_pylist()) if row is None] == [3, 8]
        assert [k for k, row in enumerate(result["gravity"].to_pylist()) if row is None] == [3]
        good = np.delete(np.arange(20), [3, 8])
        assert np.array_equal(numbers(result["bias"].take(pa.array(good))), PANDA.bias(s.q[good], s.v[good]))
    with pytest.raises(rd.BadStatesError, match="1 of 6 rows has no `bias`"):
        list(arrow.stream(PANDA, cut, "bias"))


@pytest.mark.parametrize("kind", [pa.list_(pa.float64(), 7), pa.list_(pa.float64()), pa.large_list(pa.float64())])
def test_nulls_are_rows_without_result(kind: Any) -> None:
    s = states(PANDA, 6)
    rows: list[Any] = s.q.tolist()
    rows[1], rows[4][2] = None, None
    given_table = pa.table({"q": pa.array(rows, kind)})
    result = arrow.compute(PANDA, given_table, "gravity", "potential_energy", bad_states="null")
    expected = PANDA.gravity(s.q)
    for k, row in enumerate(result["gravity"].to_pylist()):
        assert row is None if k in (1, 4) else np.array_equal(row, expected[k])
    assert result["potential_energy"].null_count == 2
    with pytest.raises(rd.BadStatesError, match="2 of 6 rows have no `gravity`, the first is row 1"):
        arrow.compute(PANDA, given_table, "gravity")
    nothing = pa.table({"q": pa.nulls(3, kind)})
    assert arrow.compute(PANDA, nothing, "gravity", bad_states="null")["gravity"].null_count == 3


def test_an_empty_table_has_the_columns() -> None:
    whole = arrow.compute(PANDA, table(PANDA, 4), "mass_matrix", "audit")
    for empty in (
        table(PANDA, 4)[:0],
        table(PANDA, 4).schema.empty_table(),
        table(PANDA, 4)
        .schema.empty_table()
        .cast(pa.schema([(name, pa.list_(pa.float64())) for name in ("q", "v", "a", "tau")])),
    ):
        found = arrow.compute(PANDA, empty, "mass_matrix", "audit")
        assert found.schema == whole.schema and found.num_rows == 0


def test_the_audit_sees_a_wrong_torque_and_a_wrong_mass() -> None:
    s = states(PANDA, 40)
    tau = PANDA.inverse_dynamics(s.q, s.v, s.a)
    tau[7, 2] += 0.5
    recording = pa.table({"q": list(s.q), "v": list(s.v), "a": list(s.a), "tau": list(tau)})
    found = arrow.compute(PANDA, recording, "audit")
    residual = numbers(found["audit.torque_residual"])
    expected = np.zeros((40, 7))
    expected[7, 2] = 0.5
    np.testing.assert_allclose(residual, expected, atol=1e-12)
    np.testing.assert_allclose(numbers(found["audit.power"]), (s.v * tau).sum(axis=1), atol=1e-12)
    heavier = PANDA.with_payload("panda_link8", 1.0)
    residual = numbers(arrow.compute(heavier, recording, "audit")["audit.torque_residual"])
    np.testing.assert_allclose(residual, tau - heavier.inverse_dynamics(s.q, s.v, s.a), atol=1e-12)
    assert not numbers(found["audit.dissipated_power"]).any()


def test_the_audit_counts_dissipation_where_asked() -> None:
    robot = rd.loads(
        '<robot name="damped"><link name="w"/><link name="l"><inertial><mass value="1"/><origin xyz="1 0 0"/>'
        '<inertia ixx="1" iyy="1" izz="1" ixy="0" ixz="0" iyz="0"/></inertial></link>'
        '<joint name="j" type="continuous"><parent link="w"/><child link="l"/><axis xyz="0 1 0"/>'
        '<dynamics damping="0.3"/></joint></robot>'
    )
    motion = robot.simulate([0.0], duration=2.0, dt=1e-3, dissipation=True)
    a = robot.forward_dynamics(motion.q, motion.v, motion.tau - robot.dissipation(motion.v))
    columns: dict[str, Any] = {"q": motion.q[:, 0], "v": motion.v[:, 0], "a": a[:, 0], "tau": motion.tau[:, 0]}
    recording = pa.table(columns | {"timestamp": motion.times, "episode_index": np.zeros(len(a), np.int64)})
    keep = ["timestamp", "episode_index"]
    accounts = arrow.energy_accounts(arrow.compute(robot, recording, "audit:dissipation", keep=keep))
    assert accounts["imbalance"][0].as_py() < 1e-5 * accounts["energy_moved"][0].as_py()
    assert accounts["dissipated"][0].as_py() == pytest.approx(motion.energy_account.dissipated, rel=1e-5)
    assert accounts["torque_residual"][0].as_py()[0] < 1e-12
    without = arrow.energy_accounts(arrow.compute(robot, recording, "audit", keep=keep))
    assert without["imbalance"][0].as_py() > 0.99 * motion.energy_account.dissipated


def test_energy_accounts_keep_episodes_apart() -> None:
    robot, parts = rd.example("two_r"), []
    for episode in (5, 2):
        motion = robot.simulate([0.1 * episode, 0.2], tau=[1.0, 0.1], duration=0.5, dt=1e-3)
        a = robot.forward_dynamics(motion.q, motion.v, motion.tau)
        columns: dict[str, Any] = {"q": list(motion.q), "v": list(motion.v), "a": list(a), "tau": list(motion.tau)}
        parts.append(pa.table(columns | {"t": motion.times, "episode": [f"run {episode}"] * len(a)}))
    audited = arrow.compute(robot, pa.concat_tables(parts), "audit", keep=["t", "episode"])
    accounts = arrow.energy_accounts(audited, time="t", episode="episode")
    assert accounts["episode"].to_pylist() == ["run 2", "run 5"] and accounts["rows"].to_pylist() == [501, 501]
    for account in accounts.to_pylist():
        assert account["imbalance"] < 1e-5 * account["energy_moved"] and account["duration"] == pytest.approx(0.5)
    # Interleaved episodes give the same accounts. Rows in the wrong order raise an error.
    turns = audited.take(pa.array(np.arange(1002).reshape(2, 501).T.reshape(-1)))
    assert arrow.energy_accounts(turns, time="t", episode="episode").equals(accounts)
    with pytest.raises(rd.ColumnError, match="does not increase"):
        arrow.energy_accounts(audited.take(pa.array([3, 2, 1])), time="t", episode="episode")


WRONG: list[tuple[dict[str, Any], list[str], dict[str, Any], type[Exception], str]] = [
    ({"p": [[0.0] * 7]}, ["gravity"], {}, rd.ColumnError, r"no column `q` for q; there are \['p'\]"),
    (
        {"q": [[0.0] * 6]},
        ["gravity"],
        {},
        rd.ColumnError,
        r"column `q` has 6 numbers a row, robot `panda` needs 7 for q",
    ),
    ({"q": [[0.0] * 8]}, ["gravity"], {"columns": {"q": "q[2:]"}}, rd.ColumnError, r"`q\[2:\]` has 6 numbers"),
    (
        {"q": [[0.0] * 7, [0.0]]},
        ["gravity"],
        {},
        rd.ColumnError,
        "lists of 7 numbers and of others, the first in row 1",
    ),
    ({"q": [[0] * 7]}, ["gravity"], {}, rd.ColumnError, "numbers of type int64"),
    ({"q": ["zero"]}, ["gravity"], {}, rd.ColumnError, "type string"),
    ({"q": [[0.0] * 7]}, ["gravty"], {}, rd.QuantityError, "no quantity `gravty`: did you mean `gravity`"),
    ({"q": [[0.0] * 7]}, ["frame_pose"], {}, rd.FrameError, "write frame_pose:FRAME with a frame of robot `panda`"),
    ({"q": [[0.0] * 7]}, ["gravity:panda_link8"], {}, rd.QuantityError, "gravity has no frame"),
    ({"q": [[0.0] * 7]}, ["gravity"], {"keep": ["time"]}, rd.ColumnError, r"no column \['time'\] to keep"),
    ({"q": [[0.0] * 7]}, ["gravity"], {"columns": {"v": "w"}}, rd.ColumnError, r"names \['v'\]"),
    ({"q": [[0.0] * 7]}, [], {}, ValueError, "no quantity"),
    ({"q": [[0.0] * 7]}, ["gravity"], {"bad_states": "skip"}, ValueError, "'raise' or 'null'"),
]


@pytest.mark.parametrize(("columns", "quantities", "options", "error", "words"), WRONG)
def test_errors_name_the_column_or_quantity(columns: Any, quantities: Any, options: Any, error: type[Exception], words: str) -> None:
    with pytest.raises(error, match=words):
        arrow.compute(PANDA, pa.table(columns), *quantities, **options)


def test_mixed_types_are_refused_as_everywhere() -> None:
    s = states(PANDA, 3)
    mixed = pa.table({"q": list(s.q), "v": list(s.v.astype(np.float32))})
    with pytest.raises(rd.DTypeError):
        arrow.compute(PANDA, mixed, "bias")
    assert arrow.compute(PANDA, mixed, "bias", dtype="float64").num_rows == 3


def test_a_computation_can_be_pickled() -> None:
    computation = arrow.Computation(PANDA, ["audit", "frame_pose:panda_link8"], keep=["q"])
    given_table = table(PANDA, 9)
    assert pickle.loads(pickle.dumps(computation))(given_table).equals(computation(given_table))
