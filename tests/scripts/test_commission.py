"""`armside commission` and `armside laser --twin`: from recorded cuts to a right first run."""

import json
import subprocess
import sys

import numpy as np
import pytest

INDIVIDUAL = "2001"


@pytest.fixture(scope="module")
def twin(tmp_path_factory):
    """Folder of a twin that was commissioned from one cut, and its summary."""
    folder = tmp_path_factory.mktemp("commission") / "twin"
    line = f"commission --individual {INDIVIDUAL} --cuts 1 --json --out {folder}"
    command = [sys.executable, "-m", "armside", *line.split()]
    done = subprocess.run(command, capture_output=True, text=True, check=False)
    assert (done.returncode, done.stderr) == (0, "")
    return folder, json.loads(done.stdout)


def test_commissioning_leaves_a_twin_with_its_pictures(twin):
    folder, summary = twin
    names = {"summary.json", "twin.json", "covariance.npy", "friction.png", "residuals.png"}
    assert {file.name for file in folder.iterdir()} == names
    assert summary["cuts"][0]["held_out"] is None  # the only cut cannot be left out
    assert summary["cuts"][0]["within"] < 50e-6
    assert "friction_constant 1" not in summary["not_identified"]
    assert "gear_error 6 1 1" in summary["not_identified"]  # the tool lies on axis 6


def test_a_first_cut_by_a_twin_is_predicted_and_right(armside, twin, tmp_path):
    folder, _ = twin
    line = f"laser --twin {folder} --individual {INDIVIDUAL} --iterations 0 --json"
    status, out, _ = armside(f"{line} --out {tmp_path / 'run'}")
    assert status == 0
    found = json.loads(out)
    predicted = found["predicted"]
    assert predicted["trusted"]
    low, high = predicted["interval"]
    assert low < predicted["arm_rms"] < high
    assert found["iterations"][0]["arm_rms_true"] < 0.3 * predicted["uncorrected"]
    assert found["twin"]["friction"] == pytest.approx([1.0] * 6, abs=0.15)


def test_a_run_can_be_commissioned_from_in_place_of_a_cut(armside, twin, tmp_path):
    """Its truth is not needed: the same table without those columns does as well."""
    import pyarrow.parquet as pq

    status, _, _ = armside(f"laser --individual {INDIVIDUAL} --iterations 0 --out {tmp_path / 'r'}")
    assert status == 0
    table = pq.read_table(tmp_path / "r" / "signals.parquet")
    blind = table.drop_columns([name for name in table.column_names if name.startswith("true_")])
    pq.write_table(blind, tmp_path / "blind.parquet")
    found = [
        json.loads(armside(f"commission --recordings {source} --json --out {tmp_path / name}").out)
        for source, name in ((tmp_path / "r", "a"), (tmp_path / "blind.parquet", "b"))
    ]
    assert found[0]["parameters"] == found[1]["parameters"]


@pytest.mark.parametrize(
    ("line", "said"),
    [
        ("commission --cuts 0", "cuts must be from 1 to 10, got 0"),
        ("commission --cuts 11", "cuts must be from 1 to 10, got 11"),
        ("commission --payload 1e308", "payload must be at most 10000 kg, got 1e+308"),
        ("commission --leave-out cut-9", "no cut 'cut-9' to leave out. Cuts: cut-1"),
        ("commission --cuts 1 --leave-out cut-1", "every cut is left out"),
        ("commission --recordings nowhere --individual 3", "leave out --individual"),
        ("commission --recordings nowhere", "nowhere is no recorded cut"),
        ("laser --twin nowhere", "nowhere holds no twin.json"),
    ],
)
def test_bad_input_is_one_line(armside, tmp_path, monkeypatch, line, said):
    monkeypatch.chdir(tmp_path)
    status, out, err = armside(line)
    assert (status, out) == (2, "")
    assert said in err
    assert err.count("\n") == 1
    assert not list(tmp_path.iterdir())


def test_a_twin_does_not_cut_for_another_robot(armside, twin):
    status, _, err = armside(f"laser --robot irb1400 --twin {twin[0]}")
    assert status == 2
    assert "the twin is of the robot large" in err


def test_a_failure_of_the_identification_is_not_bad_input(armside, monkeypatch):
    """Only a recording that cannot be of the robot is."""
    from armside.sim.twin import commission
    from armside.sim.twin.plausible import ImplausibleError

    def singular(*_args, **_kwargs):
        raise np.linalg.LinAlgError("Singular matrix")

    monkeypatch.setattr(commission, "identify", singular)
    status, _, err = armside("commission --cuts 1")
    assert (status, err.count("\n")) == (1, 1)
    assert "failed with LinAlgError" in err

    def another_robot(*_args, **_kwargs):
        raise ImplausibleError("cut-1: another robot")

    monkeypatch.setattr(commission, "identify", another_robot)
    assert armside("commission --cuts 1") == (2, "", "armside: cut-1: another robot\n")


def test_a_failure_of_learning_in_a_twin_is_not_bad_input(armside, twin, monkeypatch):
    from armside.sim.twin import twin as module

    def singular(*_args, **_kwargs):
        raise np.linalg.LinAlgError("Singular matrix")

    monkeypatch.setattr(module, "correct", singular)
    status, _, err = armside(f"laser --iterations 0 --twin {twin[0]}")
    assert (status, err.count("\n")) == (1, 1)
    assert "failed with LinAlgError" in err
    said = f"laser --robot irb1400 --twin {twin[0]}"
    assert armside(said).status == 2
