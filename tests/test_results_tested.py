"""Every public result has a test of its unit, sign and size, or counts among those without."""

import json
import re
import xml.etree.ElementTree as ET
from collections import defaultdict

import numpy as np
import pyarrow.parquet as pq
import pytest

from .results_listed import (
    SMALL,
    TABLE,
    command_of,
    fields,
    listed,
    matches,
    names_of_tests,
    unlisted,
    words_of_the_code,
)

UNTESTED = 39
"""Results without such a test; lower it with each test that is written."""
OF = {"input", "text", "count", "truth"}
"""What needs no unit."""
ONLY_THEN = {
    "laser": ("limits_hit.", "notes.", "started_from.", "predicted.", "twin.", "forecast."),
    "cut": ("limits_hit.", "notes.", "started_from.", "predicted.", "twin.", "forecast.", "scan."),
    "measure": ("notes.",),
    "export": ("notes.",),
    "learn": ("notes.", "eigenloci.", "laws.arm", "laws.predicted", "k"),
    "identify-plant": ("notes",),
    "calibrate-arm": ("notes.", "outliers."),
    "imu": ("limits_hit.", "recordings.", "repeatability."),
}
"""Beginnings of what the small runs of a command do not have."""


def entries():
    return [(of, field, e) for of, section in TABLE.items() for field, e in section.items()]


def named(entry):
    names = entry.get("test", [])
    return [names] if isinstance(names, str) else names


def test_each_result_has_a_test_that_exists_or_a_reason():
    names = names_of_tests()
    for of, field, entry in entries():
        where, untested = f"{of}: {field}", entry.get("tested") == "no"
        assert set(entry) <= {"unit", "of", "test", "tested", "why"}, where
        assert ("unit" in entry) != ("of" in entry), where
        assert entry.get("of", "text") in OF, where
        assert untested == ("why" in entry), where
        assert untested or "of" in entry or named(entry), where
        for name in named(entry):
            assert names.get(name) == 1, f"{where}: {name} is in {names.get(name, 0)} files"


def test_results_without_a_test_become_fewer():
    found = [f"{of}: {field}" for of, field, e in entries() if e.get("tested") == "no"]
    assert len(found) == UNTESTED, "lower UNTESTED with them; it never rises"


@pytest.fixture(scope="module")
def summaries(small_runs):
    """Fields of all summaries of small runs by command."""
    found = defaultdict(set)
    for name in SMALL:
        summary = json.loads((small_runs / name / "summary.json").read_text(encoding="utf-8"))
        found[command_of(summary)] |= fields(summary)
    return found


def test_each_field_of_the_small_runs_is_in_the_table(summaries):
    assert [line for of in summaries for line in unlisted(of, summaries[of])] == []


def test_each_field_in_the_table_is_in_a_run_or_in_the_code(summaries):
    """In a run of a command that has small ones, else by its words in the packages."""
    words, gone = words_of_the_code(), []
    for section, of_section in TABLE.items():
        if section.startswith("file "):
            continue
        commands = [of for of in section.split(", ") if of in summaries]
        for field in of_section:
            later = [field.startswith(ONLY_THEN.get(of, ())) for of in commands]
            seen = any(fields_match(summaries[of], field) for of in commands)
            by_word = all(
                word in words or any(word.endswith(end) for end in ("_true", "_normalised"))
                for word in re.findall(r"\w{2,}", re.sub(r"\[\w+\]|\*", " ", field))
            )
            if not (by_word if all(later) else seen):
                gone.append(f"{section}: {field}")
    assert gone == []


def fields_match(found, field):
    return any(matches(path, field) for path in found)


# Files and messages


def columns(file):
    """Unit of each column of a Parquet file."""
    return {one.name: one.metadata[b"unit"].decode() for one in pq.read_schema(file)}


@pytest.mark.parametrize(
    ("of", "file"),
    [
        ("signals.parquet", "laser/signals.parquet"),
        ("signals.parquet", "cut/signals.parquet"),
        ("signals.parquet", "rest/signals.parquet"),
        ("signals.parquet", "imu/signals.parquet"),
        ("imu.parquet", "imu/imu.parquet"),
        ("joint-path", "path.parquet"),
        ("tool-path", "tool.parquet"),
    ],
)
def test_columns_are_those_of_the_table_with_its_units(small_runs, of, file):
    found, known = columns(small_runs / file), listed(f"file {of}")
    assert unlisted(of=f"file {of}", found=set(found)) == []
    for field, entry in known.items():
        assert {unit for name, unit in found.items() if matches(name, field)} == {entry["unit"]}, (
            field
        )


def test_an_exported_csv_has_the_columns_and_units_of_the_table(small_runs):
    lines = (small_runs / "joint-correction.csv").read_text().splitlines()
    (units,) = [line for line in lines if line.startswith("# armside units ")]
    for name, unit in json.loads(units.removeprefix("# armside units ")).items():
        assert [
            entry["unit"]
            for field, entry in listed("file joint-correction").items()
            if matches(name, field)
        ] == [unit]


def test_corrections_and_references_of_learning_have_the_columns_of_the_table(small_runs):
    files = [*(small_runs / "learn").glob("*.csv")]
    heads = {name for file in files for name in file.read_text().splitlines()[0].split(",")}
    assert len(files) == 3
    assert_same("file learn", heads)


def assert_same(of, found):
    """The table has these fields of a message, and no other."""
    assert unlisted(of, found) == []
    assert [field for field in listed(of) if not fields_match(found, field)] == []


@pytest.fixture
def state():
    from armside.sim.controller import Phase, State

    values = {"joints": np.ones(7), "planned": np.ones(7), "position": np.ones(3)}
    times = {"number": 1, "time": 1004, "missed": 0, "resting": True, "phase": Phase.GUIDED}
    turn = np.array([1.0, 0.0, 0.0, 0.0])
    return State(**values, **times, quaternion=turn, programmed=(np.ones(3), turn))


def test_messages_of_rsi_have_the_elements_of_the_table(state):
    from armside.sim.controller import Answer
    from armside.sim.controller.rsi import RsiWire

    sent = RsiWire().encode_answer(Answer(values=np.ones(6), additive=True), state.time)
    found = set()
    for root in map(ET.fromstring, (RsiWire().encode_state(state), sent)):
        found |= {f"{root.tag}.{name}" for name in root.attrib}
        for element in root:
            names = [f".{name}" for name in element.attrib] or [""]
            found |= {f"{root.tag}.{element.tag}{name}" for name in names}
    assert_same("file rsi", found)


def test_messages_of_egm_have_the_fields_of_the_table(state):
    from armside.sim.controller import Answer
    from armside.sim.controller.egm import EgmWire

    wire = EgmWire()
    sent = wire.encode_answer(Answer(values=np.ones(7), additive=False), state.time)
    robot, sensor = wire._robot, wire._sensor
    found = set()

    def visit(message, path):
        for field, value in message.ListFields():
            at = f"{path}.{field.name}" if path else field.name
            visit(value, at) if hasattr(value, "ListFields") else found.add(at)

    visit(robot.FromString(wire.encode_state(state)), "")
    visit(sensor.FromString(sent), "")
    assert_same("file egm", found)


@pytest.mark.parametrize("language", ["rapid", "krl", "urscript"])
def test_programs_have_the_words_of_the_table(language):
    """Each word that begins a line with numbers, or declares what has them."""
    from armside.sim.controller.programs import new_program

    from .sim.controller.programs.test_tool_path import motion

    text = new_program(motion(), language, 0.002, rapid=0.2).text.content
    lines = [re.sub(r"^\s*(CONST )?", "", line) for line in text.splitlines()]
    made = [line for line in lines if re.search(r"\d", line) and line[:1] not in "!;#"]
    found = {re.match(r"[\w$.]+", line)[0] for line in made}
    assert_same(f"file {language}", found)
