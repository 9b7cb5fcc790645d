"""`armside export` and `armside robot model`: files, tables and refusals."""

import json
import subprocess
from pathlib import Path

import pytest


@pytest.mark.parametrize(
    ("language", "files"),
    [
        ("c", {"irb1400_jacobian.c", "irb1400_jacobian.h"}),
        ("matlab", {"irb1400_jacobian.m"}),
        ("fortran", {"irb1400_jacobian.f90"}),
        ("python", {"irb1400_jacobian.py"}),
        ("latex", {"irb1400_jacobian.tex"}),
        ("urdf", {"irb1400.urdf"}),
    ],
)
def test_each_language_has_its_files(armside, tmp_path, language, files):
    status, out, err = armside(f"export --to {language} --out here")
    assert (status, err) == (0, "")
    assert {file.name for file in (tmp_path / "here").iterdir()} == files | {"summary.json"}
    assert all(name in out for name in files)


@pytest.mark.parametrize("what", ["measurement", "measurement-jacobian", "jacobian-rate"])
def test_exported_c_compiles(armside, tmp_path, what, require_program):
    cc = require_program("cc")
    assert armside(f"export --robot irb1400-imu --what {what} --to c --out here").status == 0
    (source,) = (tmp_path / "here").glob("*.c")
    flags = ["-std=c99", "-Wall", "-Wno-unused-variable", "-Werror", "-fsyntax-only"]
    subprocess.run([cc, *flags, source], check=True)


def test_exported_matlab_runs_as_a_function_on_a_column(armside, tmp_path, require_program):
    octave = require_program("octave-cli")
    assert armside("export --what pose --to matlab --out here").status == 0
    command = f"cd '{tmp_path / 'here'}'; printf('%.12g ', irb1400_pose(zeros(6, 1)))"
    done = subprocess.run(
        [octave, "--no-gui", "--quiet", "--eval", command],
        capture_output=True,
        text=True,
        check=True,
    )
    by_column = [float(x) for x in done.stdout.split()]
    assert by_column == pytest.approx([0, 0, -1, 0, 0, 1, 0, 0, 1, 0, 0, 0, 0.955, 0, 1.195, 1])


def test_summary_counts_the_operations(armside):
    status, out, _ = armside("export --robot large --what acceleration --json --out here")
    found = json.loads(out)
    assert status == 0
    assert found["operations"] > 100
    assert found["config"]["robot"] == "large"


def test_model_prints_table_zero_pose_reach_and_singularities(armside):
    status, out, _ = armside("robot model")
    assert status == 0
    for text in ("-phi_2 + phi_3", "phi_2 - pi/2", "0.955", "0.130 to 1.330 m", "sin(theta_5)"):
        assert text in out


def test_model_as_latex_is_a_table_and_a_matrix(armside):
    _, out, _ = armside("robot model --robot large --latex")
    assert r"$\phi_{2} - \frac{\pi}{2}$" in out
    assert "1.662" in out
    assert out.count(r"\begin") == out.count(r"\end") == 2


def test_model_draws_its_frames(armside, tmp_path):
    status, _, _ = armside("robot model --robot irb1400-imu --plot --out here --quiet")
    assert status == 0
    picture: Path = tmp_path / "here" / "frames.png"
    assert picture.read_bytes().startswith(b"\x89PNG")
    assert json.loads((tmp_path / "here" / "summary.json").read_text())["reach"][1] == (
        pytest.approx(1.33, abs=0.01)
    )
