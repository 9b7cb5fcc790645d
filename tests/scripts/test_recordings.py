"""Recordings given to `armside commission`: a corrupt one is named, and left out only by option."""

import shutil
from typing import Any

import numpy as np
import pyarrow as pa
import pyarrow.compute
import pyarrow.parquet as pq
import pytest

from .ran import ran

compute: Any = pyarrow.compute
"""Its functions are made when it is imported."""
LOG = ("reference", "motor_angle", "motor_torque")
DOCUMENTED = ("time", *(f"{name}_{i}" for name in LOG for i in range(1, 7)))
"""Columns of docs/formats.md that a robot's own recording needs, beside those of the tracker."""
TRACKER = ("tracker_x", "tracker_y", "tracker_z")


@pytest.fixture(scope="module")
def good(tmp_path_factory):
    """Folder of a run."""
    folder = tmp_path_factory.mktemp("recorded") / "good"
    ran(folder, "laser --individual 2001 --iterations 0 --speed 80")
    return folder


@pytest.fixture(scope="module")
def table(good):
    return pq.read_table(good / "signals.parquet")


def changed(table, change, *columns):
    """The table with a function of the values of some columns, nulls kept."""
    for name in columns:
        at = table.column_names.index(name)
        table = table.set_column(at, name, change(table[name]))
    return table


def with_value(value):
    """Change of a value in the middle of what a column has."""

    def change(column):
        values = column.to_pylist()
        known = [i for i, x in enumerate(values) if x is not None]
        values[known[len(known) // 2]] = value
        return pa.array(values, pa.float64())

    return change


def torques(factor):
    return lambda column: compute.multiply(column, factor)


TORQUE = [f"motor_torque_{i}" for i in range(1, 7)]
CORRUPT = {
    "nan": (lambda t: changed(t, with_value(np.nan), "motor_torque_2"), "not finite"),
    "null": (lambda t: changed(t, with_value(None), "motor_angle_3"), "not finite"),
    "infinite": (lambda t: changed(t, with_value(np.inf), "reference_1"), "not finite"),
    "units": (lambda t: changed(t, torques(1e3), *TORQUE), "it must be in N m of the motor"),
    "flange": (
        lambda t: changed(t, lambda z: compute.add(z, 0.1), "tracker_z"),
        "another flange",
    ),
    "beam": (lambda t: changed(t, with_value(np.nan), "tracker_y"), "the tracker lost 1 of"),
    "columns": (lambda t: t.drop_columns(["motor_torque_6"]), "lacks the column motor_torque_6"),
    "empty": (lambda t: t.slice(0, 0), "is no recorded cut: it has no rows"),
    "rest": (lambda t: t.filter(compute.less(t["time"], 0.2)), "rest.parquet"),
    "gap": (
        lambda t: t.filter(compute.not_equal(t["time"], t["time"][1000])),
        "log is not at 250 Hz",
    ),
}


@pytest.mark.parametrize("kind", CORRUPT)
def test_a_corrupt_cut_is_named_in_one_line(bad_input, good, table, tmp_path, kind):
    change, said = CORRUPT[kind]
    file = tmp_path / f"{kind}.parquet"
    pq.write_table(change(table), file)
    line = f"commission --recordings {good} {file} --out twin"
    assert f"{kind}.parquet" in bad_input(line, said)


def test_a_truncated_file_and_another_robot_are_named_in_one_line(
    armside, bad_input, good, tmp_path
):
    whole = (good / "signals.parquet").read_bytes()
    (tmp_path / "half.parquet").write_bytes(whole[: len(whole) // 2])
    line = "laser --robot irb1400 --iterations 0 --quiet --out other"
    assert armside(line).status == 0
    for name, said in (("half.parquet", "no recorded cut"), ("other", "another robot")):
        assert name in bad_input(f"commission --recordings {good} {name}", said)


@pytest.mark.usefixtures("one_step_commissioning")
def test_a_corrupt_cut_is_left_out_by_its_name_alone(armside, summary_of, good, table, tmp_path):
    """And what is left is a recording of documented columns: the twin is the same, bit for bit."""
    documented = table.select([*DOCUMENTED, *TRACKER])
    pq.write_table(documented, tmp_path / "mine.parquet")
    shutil.copytree(good, tmp_path / "bad")
    (tmp_path / "bad" / "signals.parquet").write_bytes(b"PAR1")
    assert armside(f"commission --recordings {good} bad").status == 2
    lines = (f"{good} bad --leave-out bad", "mine.parquet")
    twins = [summary_of(f"commission --recordings {line}") for line in lines]
    assert [cut["name"] for cut in twins[0]["cuts"]] == ["good"]
    assert twins[0]["parameters"] == twins[1]["parameters"]
