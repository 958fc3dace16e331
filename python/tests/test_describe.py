"""docs/describe.md lists every key of `Robot.describe()` with its type."""

import re
import warnings
from pathlib import Path
from typing import Any

import pytest

import robot_dynamics as rd

ROOT = Path(__file__).parents[2]

Section = dict[str, str]
"""The type of each key of an object."""


def sections() -> dict[str, Section]:
    """The tables of the page, by the names of their objects."""
    page = (ROOT / "docs" / "describe.md").read_text(encoding="utf-8")
    found = {}
    for title, body in re.findall(r"^## `(\w+)`$(.*?)(?=^## |\Z)", page, re.MULTILINE | re.DOTALL):
        found[title] = dict(re.findall(r"^\| `([\w.]+)` \| (.+?) \| .+ \|$", body, re.MULTILINE))
        assert found[title], title
    return found


def is_of(kind: str, value: Any) -> bool:
    """Whether a value that is not an object of the page has a type."""
    word = kind.split(",")[0]
    if value is None:
        return "null" in kind
    if word.startswith("reals"):
        count = int(re.findall(r"\d+", word)[0])
        return isinstance(value, list) and len(value) == count and all(isinstance(x, (int, float)) for x in value)
    if word.startswith("list of "):
        inner = word.removeprefix("list of ").split(" or ")[0]
        return isinstance(value, list) and all(is_of(inner, x) for x in value)
    kinds: dict[str, tuple[type, ...]] = {
        "text": (str,),
        "number": (int, float),
        "integer": (int,),
        "boolean": (bool,),
        "list": (list,),
        "bound": (int, float),
    }
    first = word.split()[0]
    return isinstance(value, kinds[first]) or (first == "bound" and value in ("inf", "-inf"))


def check(value: Any, section: str, page: dict[str, Section], place: str, seen: set[str]) -> None:
    """Compare an object with its table."""
    table = page[section]
    has_cases = any("." in key for key in table) or section == "sensor_object"
    if isinstance(value, str) and has_cases:
        return
    assert isinstance(value, dict), f"{place} is {value!r}"
    items = dict(value)
    if has_cases and section != "sensor_object":
        assert len(value) == 1, f"{place} has the keys {list(value)}"
        items = {f"{case}.{key}": inner for case, fields in value.items() for key, inner in fields.items()}
    undocumented = set(items) - set(table)
    assert not undocumented, f"{place}: docs/describe.md lacks {sorted(undocumented)} of `{section}`"
    if not has_cases:
        missing = {key for key in set(table) - set(items) if "optional" not in table[key]}
        assert not missing, f"{place} lacks {sorted(missing)}, which docs/describe.md has"
    for key, item in items.items():
        kind, at = table[key], f"{place}.{key}"
        seen.add(f"{section}.{key}")
        objects = re.findall(r"`(\w+)`", kind)
        if objects and isinstance(item, list):
            for one in item:
                check(one, objects[0], page, at, seen)
        elif objects and item is not None:
            check(item, objects[0], page, at, seen)
        else:
            assert is_of(kind, item), f"{at} = {item!r} is not {kind}"


def robots() -> list[rd.Robot]:
    """Robots of files of all kinds, and random ones."""
    folders = ["robots/*.urdf", "robots/*.xml", "testdata/mjcf/*.xml", "testdata/mjcf/*/*.xml"]
    paths = [path for pattern in folders for path in sorted(ROOT.glob(pattern))]
    loaded = []
    with warnings.catch_warnings():
        warnings.simplefilter("ignore")
        for path in paths:
            try:
                loaded.append(rd.load(path))
            except rd.LoadError:
                continue
        srdf = """<robot name="two_r"><group name="arm"><chain base_link="base" tip_link="fore"/></group>
            <group name="tool"><link name="tip"/></group>
            <group_state name="bent" group="arm"><joint name="elbow" value="0.5"/></group_state>
            <end_effector name="hand" group="tool" parent_link="fore" parent_group="arm"/></robot>"""
        loaded.append(rd.loads(rd.example("two_r").to_text().text, srdf=srdf))
        field = """<mujoco><asset><hfield name="h" nrow="2" ncol="2" size="1 1 1 1" elevation="0 1 2 3"/></asset>
            <worldbody><geom type="hfield" hfield="h"/></worldbody></mujoco>"""
        loaded.append(rd.loads(field))
        motor: dict[str, Any] = {"gear": 50.0, "rotor_inertia": 1e-5, "resistance": 1.6, "constant": 0.08}
        hot = rd.Winding(4.0, 20.0)
        loaded.append(rd.example("two_r").with_motor("elbow", **motor, current_limit=6.0, winding=hot, derating=(80, 120)))
    return [*loaded, *(rd.random_robot(seed) for seed in range(20))]


def test_page_lists_every_key_of_every_robot() -> None:
    page, seen = sections(), set[str]()
    loaded = robots()
    assert len(loaded) > 50
    for robot in loaded:
        check(robot.describe(), "robot", page, robot.name, seen)
    listed = {f"{section}.{key}" for section, table in page.items() for key in table}
    assert listed - seen == set(), "no robot of the tests has these keys"


@pytest.mark.parametrize("name", sorted({"robot", *sections()}))
def test_every_table_is_used(name: str) -> None:
    page = sections()
    used = {"robot", *(word for table in page.values() for kind in table.values() for word in re.findall(r"`(\w+)`", kind))}
    assert name in used, f"no key has the type `{name}`"
    assert used <= set(page)
