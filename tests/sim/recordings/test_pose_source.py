"""Published sets and tables of poses, read and judged."""

import os
from pathlib import Path

import numpy as np
import pytest

from armside.kinematics import CATALOGUE
from armside.kinematics.calibration import CalibrationCfg, JointErrors, calibrate
from armside.sim.recordings import read_poses

REDUCED = Path(__file__).parents[3] / "docs/examples/ur10_tmac"
SETS = Path(os.environ.get("ARMSIDE_MEASUREMENTS") or "no folder")
MM = 1e-3
whole_sets = pytest.mark.skipif(
    not SETS.is_dir(), reason="ARMSIDE_MEASUREMENTS names no folder with the published sets"
)


def test_the_reduced_set_of_the_ur10_is_read_with_its_units():
    data = read_poses(REDUCED).measurements
    assert data.phi.shape == (397, 6)
    assert np.abs(data.phi).max() < 2 * np.pi + 0.01
    assert 0.5 < np.linalg.norm(np.ptp(data.points[:, 0], axis=0)) < 4.0  # within an arm's reach
    first = MM * np.array([383.97123, -3240.7562, 201.72621])
    np.testing.assert_allclose(data.points[0, 0], first, rtol=0, atol=1e-12)


def test_the_reduced_set_is_calibrated():
    """Bounds of the whole set with a quarter more for a seventh of its poses."""
    done = calibrate(CATALOGUE["ur10"], read_poses(REDUCED).measurements, seed=0)
    assert done.errors("geometry").mean <= 1.25 * 0.46 * MM
    assert done.errors("full").mean <= 1.25 * 0.12 * MM
    assert done.errors("full").p95 <= 1.25 * 0.25 * MM
    assert done.identifiable.all.rank == 27


@whole_sets
def test_the_second_half_of_series_c_is_predicted():
    data = read_poses(SETS / "ur10_tmac/measurements_random_poses.csv").measurements
    done = calibrate(CATALOGUE["ur10"], data, CalibrationCfg(in_order=True))
    assert done.errors("geometry").mean <= 0.46 * MM
    assert done.errors("full").mean <= 0.12 * MM
    assert done.errors("full").p95 <= 0.25 * MM


@whole_sets
def test_fifty_poses_are_enough_for_a_quarter_of_a_millimetre():
    data = read_poses(SETS / "ur10_tmac/measurements_random_poses.csv").measurements
    cfg = CalibrationCfg(poses=50, joint_errors=JointErrors(40, True))
    means = [calibrate(CATALOGUE["ur10"], data, cfg, seed=s).errors("full").mean for s in range(5)]
    assert np.median(means) <= 0.25 * MM


@whole_sets
def test_the_irb120_is_calibrated_and_drifted_rows_are_listed():
    source = read_poses(SETS / "irb120_faro")
    assert len(source.measurements) == 1000 - 18
    assert "18 rows left out" in source.notes[0]
    done = calibrate(CATALOGUE["irb120"], source.measurements, seed=0)
    assert done.errors("full").mean <= 0.40 * MM
    assert done.identifiable.all.rank == 33


@pytest.fixture
def irb120(tmp_path):
    rng = np.random.default_rng(0)
    np.savetxt(tmp_path / "measured_joints.txt", rng.uniform(-90, 90, (20, 6)))
    for name in ("SMR", "base"):
        for i in (1, 2, 3):
            np.savetxt(tmp_path / f"measured_{name}_{i}.txt", np.tile(rng.normal(size=3), (20, 1)))
    return tmp_path


def test_rows_with_a_moved_base_are_left_out_and_named(irb120):
    base = np.loadtxt(file := irb120 / "measured_base_2.txt")
    base[[4, 9]] += 1.0
    np.savetxt(file, base)
    source = read_poses(irb120)
    assert source.notes[0].endswith("0.3 mm: 5, 10")
    assert list(source.measurements.row[:5]) == [1, 2, 3, 4, 6]


def test_damaged_files_are_named(irb120, tmp_path):
    (irb120 / "measured_SMR_3.txt").write_text("1 2 3\n1 2\n")
    with pytest.raises(ValueError, match=r"measured_SMR_3\.txt"):
        read_poses(irb120)
    (irb120 / "measured_SMR_3.txt").unlink()
    with pytest.raises(ValueError, match=r"measured_SMR_3\.txt is missing"):
        read_poses(irb120)
    lines = (REDUCED / "measurements_random_poses.csv").read_text().splitlines()
    (file := tmp_path / "ur10.csv").write_text("\n".join([*lines[:5], lines[5][:80]]))
    with pytest.raises(ValueError, match="row 5 has"):
        read_poses(file)
    file.write_text("\n".join([*lines[:3], lines[3].replace(";0,", ";x,")]))
    with pytest.raises(ValueError, match="is not a number"):
        read_poses(file)
    with pytest.raises(ValueError, match="does not exist"):
        read_poses(tmp_path / "nothing.csv")
    (tmp_path / "empty").mkdir()
    with pytest.raises(ValueError, match="no folder of a known form"):
        read_poses(tmp_path / "empty")


def test_a_table_of_any_arm_is_read(tmp_path):
    head = "motor_angle_1,motor_angle_2,target_1_x,target_1_y,target_1_z,target_2_x,target_2_y,"
    head += "target_2_z,tool_qw,tool_qx,tool_qy,tool_qz"
    rows = ["0.1,0.2,1,2,3,4,5,6,1,0,0,0", "0.3,0.4,1,2,3,,,,0,1,0,0"]
    (file := tmp_path / "poses.csv").write_text("\n".join([head, *rows]))
    data = read_poses(file).measurements
    assert data.phi.tolist() == [[0.1, 0.2], [0.3, 0.4]]
    assert np.isnan(data.points[1, 1]).all()
    np.testing.assert_allclose(data.rotation[1], np.diag([1, -1, -1]))
    (file := tmp_path / "other.csv").write_text("time,x\n0,1\n")
    with pytest.raises(ValueError, match="it needs columns motor_angle_1"):
        read_poses(file)


@pytest.mark.parametrize("name", ["poses.csv", "series.mat"])
def test_a_pipe_is_refused_at_once(tmp_path, name):
    os.mkfifo(tmp_path / name)
    with pytest.raises(ValueError, match="is no regular file"):
        read_poses(tmp_path / name)
    os.mkfifo(tmp_path / "measurements_a.csv")
    with pytest.raises(ValueError, match="is no regular file"):
        read_poses(tmp_path)


@pytest.mark.parametrize("separator", [";", "\t", ","])
def test_a_table_of_poses_is_read_with_the_separators_and_commas_of_a_spreadsheet(
    separator, tmp_path
):
    names = [f"motor_angle_{i}" for i in range(1, 7)] + [f"target_1_{a}" for a in "xyz"]
    values = np.random.default_rng(0).normal(size=(8, 9))
    rows = [separator.join(map(repr, row)) for row in values.tolist()]
    text = "\n".join([separator.join(names), *rows])
    (tmp_path / "poses.csv").write_text(text if separator == "," else text.replace(".", ","))
    found = read_poses(tmp_path / "poses.csv").measurements
    np.testing.assert_array_equal(found.phi, values[:, :6])
    np.testing.assert_array_equal(found.points[:, 0], values[:, 6:])
