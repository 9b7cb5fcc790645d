"""`armside robot new`, `build`, `show` and `check` of robot files."""

import json
import tomllib
from pathlib import Path

import mujoco
import numpy as np
import pytest
from PIL import Image

from armside import assets
from armside.scripts.cli import main
from armside.sim.cell import CELLS
from armside.sim.evaluation.robot_examination import Examination
from armside.sim.evaluation.usual_ranges import USUAL
from armside.sim.robot.model import load_model
from armside.sim.robot_file.find import find_cell
from armside.sim.robot_file.hardware import DRIVES, EFFECTS, GEARS
from armside.sim.robot_file.reading import TABLES

from .ran import ran

SCARA = assets.LARGE_ROBOT_XML.with_name("scara.toml")


def test_from_an_empty_folder_to_a_model_of_plain_mujoco(tmp_path, capsys):
    new, built = tmp_path / "new", tmp_path / "built"
    ran(new, "robot new")
    file = str(new / "robot.toml")
    ran(built, "robot build", file)
    mj = mujoco.MjModel.from_xml_path(str(built / "robot.xml"))
    assert mj.njnt == 12
    assert mj.ngeom > 6
    capsys.readouterr()
    assert main(["robot", "check", str(built / "robot.toml"), "--json"]) == 0
    assert json.loads(capsys.readouterr().out)["estimates"] == []
    assert main(["robot", "check", file, "--json"]) == 0
    estimates = json.loads(capsys.readouterr().out)["estimates"]
    said = {one["field"]: one for one in estimates}
    assert said["drives: gear_ratio"]["values"] == [100.0] * 6
    assert said["hardware: mass"]["rule"].startswith("ESTIMATE")


def test_a_drive_that_cannot_move_its_rotor_fails_and_its_cut_is_not_done(tmp_path, capsys):
    """Rotors of 0.9 kg m^2: 2250 kg m^2 behind a gear of 50, beside a peak torque of 100 N m."""
    file, out = tmp_path / "heavy.toml", tmp_path / "cut"
    text = SCARA.read_text(encoding="utf-8")
    file.write_text(text.replace("[drives]\n", "[drives]\nrotor_inertia = 0.9\n"), "utf-8")
    assert main(["robot", "check", str(file), "--quiet"]) == 1
    assert "verdicts fail: peak torque over inertia, axis 3" in capsys.readouterr().err
    words = ["laser", "--robot", str(file), "--iterations", "0", "--quiet", "--out", str(out)]
    assert main(words) == 1
    assert "every drive was at its torque limit" in capsys.readouterr().err
    assert json.loads((out / "summary.json").read_text("utf-8"))["status"] == "saturated"


@pytest.mark.parametrize("name", [*CELLS, "kr16_like", "panda_like", "ur5e_like"])
def test_the_shipped_six_and_seven_axis_arms_are_usual(name):
    cell = find_cell(name if name in CELLS else str(SCARA.with_name(f"{name}.toml")))
    examined = Examination(load_model(cell.xml), cell)
    assert [one.usual.quantity for one in examined.usual if not one.inside] == []
    low, high = USUAL["lowest_mode"].range(examined.horizontal_reach)
    assert low < examined.locked_modes[0] < high


def test_check_prints_the_usual_range_beside_each_number(capsys):
    assert main(["robot", "check", str(SCARA), "--json"]) == 0
    usual = {one["quantity"]: one for one in json.loads(capsys.readouterr().out)["usual"]}
    assert usual["reach"]["values"] == [pytest.approx(0.6, abs=0.01)]  # of the class of 600 mm
    assert usual["gear ratio"]["values"] == [50.0, 50.0, 15.0]
    assert not usual["gear ratio"]["inside"]
    assert main(["robot", "check", str(SCARA)]) == 0
    assert "unusual" in capsys.readouterr().out


def test_check_lists_what_is_estimated_and_slides_in_millimetres(capsys):
    assert main(["robot", "check", str(SCARA)]) == 0
    shown = capsys.readouterr().out
    assert "gears: stiffness" in shown
    rows = [line.split("│") for line in shown.splitlines() if "│" in line]
    slide = next(row for row in rows if row[1].strip() == "3" and row[5].strip() == "mm")
    assert [float(word) for word in slide[2:5]] == [0.0, 200.0, 1100.0]


@pytest.mark.usefixtures("graphics")
def test_a_picture_of_the_robot_goes_with_its_data(tmp_path):
    ran(tmp_path / "shown", "robot show", SCARA)
    with Image.open(tmp_path / "shown" / "robot.png") as image:
        shades = np.asarray(image.convert("L"))
    assert np.median(shades) == 255  # of the background
    assert 0.02 < (shades < 200).mean() < 0.5  # of the robot


@pytest.mark.parametrize(("name", "axes"), [("panda_like", 7), ("two_link", 2)])
def test_a_cut_leaves_a_replay_with_a_line_for_each_axis(name, axes, tmp_path):
    from rerun.chunk import RrdReader

    file, out = str(SCARA.with_name(f"{name}.toml")), tmp_path / "cut"
    ran(out, f"laser --robot {file} --iterations 0")
    chunks = list(RrdReader(out / "replay.rrd").stream().to_chunks())
    (lines,) = [c for c in chunks if c.entity_path == "/motor_error" and c.is_static]
    batch = lines.to_record_batch()
    (names,) = [n for n in batch.schema.names if n.endswith("names")]
    assert batch.column(names).to_pylist() == [[f"axis {i + 1}" for i in range(axes)]]
    learned = {c.entity_path for c in chunks if c.entity_path.startswith("/learning/motor")}
    assert len(learned) == axes


def test_a_wrong_robot_file_is_one_line_with_file_field_and_what_is_allowed(tmp_path, capsys):
    file = tmp_path / "arm.toml"
    text = SCARA.read_text(encoding="utf-8")
    file.write_text(text.replace("gear_ratio = [50,", "gear_ratio = [-50,"), encoding="utf-8")
    for words in (["robot", "check", str(file)], ["laser", "--robot", str(file)]):
        assert main(words) == 2
        said = "arm.toml: drives: gear_ratio must be a finite number > 0, got -50; "
        said += "a motor that turns against its axis has 50 here, -1 in coupling"
        assert capsys.readouterr().err.strip() == f"armside: {said}"


def test_the_docs_describe_every_key_and_show_the_shipped_file():
    page = (Path(__file__).parents[2] / "docs" / "robots.md").read_text(encoding="utf-8")
    for name, key in {**DRIVES, **GEARS, **EFFECTS}.items():
        row = next(line for line in page.splitlines() if line.startswith(f"| `{name}` |"))
        assert f"| {key.unit} | {key.meaning} | {key.default or 'from the stiffness'} |" in row
    shown = page.split("```toml\n")[1].split("```")[0]
    shipped = SCARA.with_name("kr16_like.toml").read_text(encoding="utf-8")
    assert tomllib.loads(shown) == tomllib.loads(shipped)
    for table in TABLES:
        assert f"[{table}]" in page
