"""Every key of a robot file made wrong, one at a time: refused in one line, before building."""

import copy
import json
import math
import tomllib
from pathlib import Path

import pytest

from armside.kinematics import robot_file
from armside.sim.robot_file import cell_tables, reading
from armside.sim.robot_file.build import Built
from armside.sim.robot_file.find import read_cell
from armside.sim.robot_file.hardware import DRIVES, EFFECTS, GEARS, NEEDED

FILE = Path(__file__).with_name("every_key.toml")
DATA = tomllib.loads(FILE.read_text(encoding="utf-8"))
SIGNED = {
    *("offset", "coupling", "home", "theta", "d", "a", "alpha", "lower", "coefficients", "upper"),
    *("centre", "direction", "point", "position", "quaternion", "gear_error_phase", "delta"),
}
"""Keys that take negative numbers: geometry, angles, phases and a shift in samples."""
MAY_BE_ZERO = SIGNED | {"link"} | {
    name for keys in (DRIVES, GEARS, EFFECTS) for name, key in keys.items() if not key.strict
}  # fmt: skip
REQUIRED = {
    *{"link", "position", "coefficients", "gamma", "delta", "cutoff"},
    *{"structure name", "structure link", "structure direction", "structure stiffness"},
    *{"coupled lower", "coupled upper", *(f"effects {size}" for size in NEEDED.values())},
}
"""Keys that a file, or the table that is there, needs; with the table where names repeat."""
WRONG = {
    **{"NaN": math.nan, "infinite": math.inf, "1e300": 1e300, "truth": True},
    **{"text": "a b\n", "table": {"a": 1}, "list": [], "list of tables": [{"b": 1}]},
}
MAY_BE_EMPTY = {"body", "structure", "coupled", "simultaneous"}


def keys_of(data, path=()):
    """Path of each key, those of tables and of rows of tables included."""
    for key, value in data.items():
        yield (*path, key)
        for place, row in rows_of(value):
            yield from keys_of(row, (*path, key, *place))


def rows_of(value):
    """Tables within a value, with the index that each is found at."""
    if isinstance(value, dict):
        return [((), value)]
    rows = value if isinstance(value, list) else []
    return [((i,), row) for i, row in enumerate(rows) if isinstance(row, dict)]


KEYS = {".".join(map(str, path)): path for path in keys_of(DATA)}


@pytest.fixture
def refusal(tmp_path, monkeypatch):
    """Message that a file with one key changed is refused with; None where it is read."""
    (tmp_path / "moves.toml").touch()
    (tmp_path / "arm.xml").touch()
    monkeypatch.setattr(cell_tables, "build", lambda *_, **__: Built("", ()))
    monkeypatch.setattr(cell_tables, "cached", lambda *_: tmp_path / "arm.xml")

    def refused(path, *value):
        data = copy.deepcopy(DATA)
        table = data
        for key in path[:-1]:
            table = table[key]
        table[path[-1]] = value[0] if value else None
        if not value:
            del table[path[-1]]
        file = tmp_path / "robot.toml"
        file.write_text("\n".join(f"{key} = {toml(one)}" for key, one in data.items()))
        try:
            read_cell(file)
        except ValueError as error:
            return str(error)
        return None

    return refused


def toml(value):
    """A value as inline TOML."""
    match value:
        case dict():
            return f"{{{', '.join(f'{key} = {toml(one)}' for key, one in value.items())}}}"
        case list():
            return f"[{', '.join(map(toml, value))}]"
        case _:
            return json.dumps(value).replace("NaN", "nan").replace("Infinity", "inf")


def begun_with(value, number):
    """Numbers of which the first, or the first of the first row, is another."""
    if isinstance(value, list):
        return [begun_with(value[0], number), *value[1:]]
    return number


def value_at(path):
    value = DATA
    for key in path:
        value = value[key]
    return value


def has_numbers(value):
    while isinstance(value, list) and value:
        value = value[0]
    return isinstance(value, int | float) and not isinstance(value, bool)


def assert_names(said, key):
    assert said is not None
    assert "\n" not in said
    assert said.startswith("robot.toml: ")
    assert key in said.split(", got")[0]


def test_the_file_has_every_key_and_is_read(refusal):
    there = {path[-1] for path in KEYS.values()}
    two_forms = {"frequency", "damping_ratio", "rotation", "model", "urdf"}
    known = (robot_file.KEYS, reading.TABLES, DRIVES, GEARS, EFFECTS, robot_file._LINK)
    for names in (*known, robot_file._LIMITS, robot_file._COUPLED, robot_file.OF_CELL):
        assert set(names) - two_forms <= there
    assert set(reading._HINGE) | set(reading._BODY) | {"time_step", "rigid"} <= there | two_forms
    assert refusal(("name",), "as it is") is None


@pytest.mark.parametrize("name", KEYS)
def test_values_of_another_kind_are_refused(name, refusal):
    path = KEYS[name]
    own = [begun_with(value_at(path), WRONG[kind]) for kind in ("NaN", "infinite", "1e300")]
    as_numbers = own if has_numbers(value_at(path)) else []
    for kind, value in (*WRONG.items(), *(("in place", one) for one in as_numbers)):
        fits = isinstance(value, bool) and path[-1] == "rigid"
        if fits or (kind == "list" and path[-1] in MAY_BE_EMPTY):
            continue
        assert_names(refusal(path, value), path[-1])


@pytest.mark.parametrize("name", [n for n, path in KEYS.items() if has_numbers(value_at(path))])
def test_signs_are_refused_where_a_quantity_has_none(name, refusal):
    path = KEYS[name]
    for number, allowed in ((-1, SIGNED), (0, MAY_BE_ZERO)):
        said = refusal(path, begun_with(value_at(path), number))
        if path[-1] not in allowed:
            assert_names(said, path[-1])


@pytest.mark.parametrize("name", KEYS)
def test_what_is_missing_is_named_or_has_a_default(name, refusal):
    path = KEYS[name]
    if name == "pose.p1":
        path = ("pose",)  # one of any name, or none
    said, table = refusal(path), [key for key in path[:-1] if isinstance(key, str)]
    if {path[-1], f"{table[-1] if table else ''} {path[-1]}"} & REQUIRED:
        assert_names(said, path[-1])
    else:
        assert said is None
