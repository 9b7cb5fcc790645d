"""`armside reproduce real`: sections from the sets in a folder; a report shows its own alone."""

import json
import os
from pathlib import Path

import pytest

from armside.scripts.commands import reproduce
from armside.scripts.commands.reproduce import JointCfg, ReportOptions
from armside.scripts.shell.errors import InputError
from armside.scripts.thesis.pages import count
from armside.scripts.thesis.report import ReportFolder, Section

SETS = os.environ.get("ARMSIDE_MEASUREMENTS")


def parts(ids, data):
    return reproduce._parts(ids, JointCfg(), ReportOptions(data=data))


def test_sets_that_are_there_are_taken_and_others_are_named(tmp_path):
    for name in ("aubo_i5", "irb6640_logs"):
        (tmp_path / name).mkdir()
    assert list(parts(["real"], tmp_path)) == ["real-imu", "real-gears", "real-paths"]
    assert list(parts(["real-paths"], tmp_path)) == ["real-paths"]
    with pytest.raises(ValueError, match=r"has no folder ur10_tmac\. Sets: aubo_i5, irb120_faro"):
        parts(["real-ur10"], tmp_path)


@pytest.mark.parametrize(
    ("line", "said"),
    [
        ("real", "need --data FOLDER"),
        ("real-imu 8.3", "need --data FOLDER"),
        ("real --data nowhere", "nowhere is no folder"),
        ("real --data .", "has no folder"),
    ],
)
def test_bad_input_is_one_line(bad_input, line, said):
    bad_input(f"reproduce {line} --out report", said)


@pytest.mark.skipif(not SETS, reason="ARMSIDE_MEASUREMENTS names no folder")
def test_sections_hold_and_are_drawn(armside, tmp_path):
    line = f"reproduce real-imu real-paths --data {SETS} --out report --json"
    status, out, err = armside(line)
    assert (status, err) == (0, "")
    sections = json.loads(out)["sections"]
    assert [one["id"] for one in sections] == ["real-imu", "real-paths"]
    assert all(check["holds"] for one in sections for check in one["checks"])
    report = Path(tmp_path / "report")
    assert {file.name for file in (report / "figures").iterdir()} == {
        "real-imu.png",
        "real-paths.png",
    }
    text = (report / "report.md").read_text()
    assert "--data FOLDER" in text
    assert "comparisons hold" in text
    assert count([]) == "0 of 0 comparisons hold"


@pytest.mark.parametrize("name", ["../secret.txt", "/etc/hostname", "sub/figure.png"])
def test_a_section_cannot_name_a_file_outside_of_the_figures(tmp_path, name):
    report = ReportFolder(tmp_path / "report")
    report.begin({})
    report.keep(Section("one", "One", "A caption.", figures=("figure.png",)))
    report.keep(Section("two", "Two", "A caption.", figures=(name,)))
    assert report.sections(["one"])[0].figures == ["figure.png"]
    with pytest.raises(InputError, match=r"two\.json is not a section.* folder of figures"):
        report.sections(["one", "two"])
