"""`armside identify-plant`: records, experiments, and what is refused."""

import json

import numpy as np
from scipy.io import savemat

from armside.ilc.models.file import read_model
from armside.ilc.models.system import System
from armside.ilc.models.system_matrix import SystemMatrix

STEP = 0.01
TRUE = System(np.array([0, 0, 0.2, 0.1]), np.array([1.0, -1.5, 0.7]), STEP)
SHORT = "--structures oe --largest-order 2 --largest-delay 3"


def measured(seed, noise=0.05, n=400):
    rng = np.random.default_rng(seed)
    u = rng.standard_normal((n, 1))
    return u, 3.0 + TRUE.simulate(u) + noise * rng.standard_normal(u.shape)


def write(file, u, y, time=True):
    t = STEP * np.arange(len(u))[:, None]
    table = np.hstack([t, u, y] if time else [u, y])
    header = "time,u,y" if time else ""
    np.savetxt(file, table, "%.12g", ",", header=header, comments="")


def test_a_record_gives_a_plant_that_learn_takes_and_intervals_around_the_truth(
    armside, summary_of, tmp_path
):
    write(tmp_path / "a.csv", *measured(0))
    write(tmp_path / "b.csv", *measured(1))
    line = f"identify-plant a.csv --validation b.csv {SHORT} --out found"
    summary = summary_of(f"{line}")
    (row,) = summary["structures"]
    assert row["orders"] == "nb 2, nf 2, nk 2"
    assert row["fit"] > 0.9
    assert row["validation"] > 0.9
    assert summary["warnings"] == []
    held = [c["interval"][0] < t < c["interval"][1] for c, t in
            zip(summary["coefficients"], [0.2, 0.1, -1.5, 0.7], strict=True)]  # fmt: skip
    assert sum(held) >= 3
    omega = np.array([0.05, 0.5, 2.0])
    found = read_model(tmp_path / "found" / "plant.json").response(omega)
    np.testing.assert_allclose(found, TRUE.response(omega), rtol=0.1)
    files = {file.name for file in (tmp_path / "found").iterdir()}
    assert files == {"plant.json", "identification.png", "summary.json"}
    assert armside("learn --plant found/plant.json --iterations 1 --samples 60").status == 0


def test_several_inputs_of_a_mat_file_become_a_state_space(armside, tmp_path):
    plant = SystemMatrix(((TRUE, TRUE * 0.2), (TRUE * -0.1, TRUE)))
    rng = np.random.default_rng(2)
    u = rng.standard_normal((600, 2))
    y = plant.simulate(u) + 0.02 * rng.standard_normal(u.shape)
    savemat(tmp_path / "two.mat", {"u": u, "y": y, "sample_time": STEP})
    line = "identify-plant two.mat --largest-order 6 --from-rest --band-fits 2 --out two"
    status, out, err = armside(line)
    assert (status, err) == (0, "")
    assert max(map(len, out.splitlines())) <= 80
    omega = np.array([0.05, 0.5])
    found = read_model(tmp_path / "two" / "plant.json").response(omega)
    np.testing.assert_allclose(found, plant.response(omega), atol=0.1)


def test_two_inputs_of_one_output_are_identified_and_are_no_plant_to_learn(armside, tmp_path):
    u = np.random.default_rng(3).standard_normal((400, 2))
    y = TRUE.simulate(u[:, :1]) + 0.5 * TRUE.simulate(u[:, 1:])
    write(tmp_path / "a.csv", u, y, time=False)
    line = f"identify-plant a.csv --inputs 2 --sample-time {STEP} --largest-order 3 --band-fits 0"
    status, out, err = armside(f"{line} --from-rest --json --out found")
    assert (status, err) == (0, "")
    assert "learn and design take as many outputs" in " ".join(json.loads(out)["warnings"])
    status, _, err = armside("learn --plant found/plant.json")
    assert status == 2
    assert "as many outputs as inputs are needed, got 1 and 2" in err


def test_an_experiment_measures_the_response_of_its_plant(armside, tmp_path):
    (tmp_path / "plant.json").write_text(
        json.dumps({"sample_time": STEP, "b": [0, 0, 0.2, 0.1], "a": [1, -1.5, 0.7]})
    )
    status, out, err = armside(f"identify-plant --plant plant.json {SHORT} --from-rest --json")
    assert (status, err) == (0, "")
    found = json.loads(out)["frequency_response"]
    omega = 2.0 * np.pi * STEP * np.array(found["frequency"])
    true = np.abs(TRUE.response(omega))
    np.testing.assert_allclose(found["magnitude"][0], true, rtol=1e-3)


def test_records_that_say_nothing_are_refused_in_one_line(bad_input, tmp_path):
    u, y = measured(0, n=100)
    write(tmp_path / "untimed.csv", u, y, time=False)
    write(tmp_path / "still.csv", 0.0 * u, y)
    write(tmp_path / "alone.csv", u, y[:, :0])
    write(tmp_path / "huge.csv", 1e200 * u, y)
    write(tmp_path / "tiny.csv", u, 1e-200 * y)
    write(tmp_path / "short.csv", u[:12], y[:12])
    write(tmp_path / "same.csv", u, u)
    for file, said in (
        ("untimed", "give --sample-time"),
        ("still", "column of u does not vary"),
        ("alone", "at least one of outputs, got 1 in all"),
        ("huge", "u must vary by 1e-100 to 1e+100"),
        ("tiny", "y must vary by 1e-100 to 1e+100"),
        ("short", "need more than 12 samples"),
        ("same", "do not excite"),
    ):
        bad_input(f"identify-plant {file}.csv", said)
