"""Robot individuals on the command line: by number or file, apart from the seed, and kept."""

import json

import numpy as np
import pyarrow as pa
import pytest

from armside import assets
from armside.scripts.cli import main
from armside.scripts.cutting.comparison import CompareCfg, cases_of
from armside.scripts.cutting.options import LaserCfg
from armside.scripts.cutting.specification import cut
from armside.scripts.jobs.dataset import schema
from armside.scripts.jobs.grid import parse
from armside.scripts.jobs.resolved import identity, resolved
from armside.sim.laser.experiment import prepare
from armside.sim.laser.identification import arm_of
from armside.sim.records import read_run
from armside.sim.robot.individual_file import PARAMETERS, read_individual
from armside.sim.robot.model import load_model
from armside.sim.robot.spread import Drawn

from .ran import ran

DESIGN = load_model(assets.LARGE_ROBOT_XML)
NUMBER = next(n for n in range(1, 100) if len(Drawn(n).of(DESIGN).hidden) == 2)
QUICK = "laser --iterations 0 --radius 3 --speed 60"


@pytest.fixture(scope="module")
def folder(tmp_path_factory):
    out = tmp_path_factory.mktemp("runs") / "one"
    ran(out, f"{QUICK} --individual {NUMBER} --friction-drift 5 --temperature 40 --seed 3")
    return out


def measures(folder):
    return json.loads((folder / "summary.json").read_text())["iterations"]


def test_a_run_keeps_the_parameters_of_its_individual(folder):
    run = read_run(folder)
    config = run.summary["config"]
    assert (config["individual"], config["seed"]) == (NUMBER, 3)
    assert (config["friction_drift"], config["temperature"]) == (5, 40)
    assert config["friction_spread"] is None
    kept = read_individual(folder / "individual.toml")
    drawn = prepare(cut(LaserCfg(individual=NUMBER))).individual
    for name in PARAMETERS:
        assert np.array_equal(getattr(kept, name), getattr(drawn, name)), name
    assert kept.hidden == drawn.hidden
    assert len(kept.hidden) == 2


def test_the_kept_file_makes_the_same_run_to_the_last_bit(folder, tmp_path):
    file = folder / "individual.toml"
    line = f"{QUICK} --individual {file} --friction-drift 5 --temperature 40 --seed 3"
    again = ran(tmp_path / "again", line)
    assert again["iterations"] == measures(folder)
    assert again["config"]["individual"] == str(file)


def test_a_run_without_an_individual_keeps_one_too(tmp_path):
    first, file = ran(tmp_path / "first", QUICK), tmp_path / "first" / "individual.toml"
    again = ran(tmp_path / "again", QUICK, "--individual", file)
    assert first["iterations"] == again["iterations"]
    assert np.ptp(read_individual(file).friction) > 0.0


def test_a_run_with_hidden_hinges_is_replayed_and_measured_from_its_folder(folder, tmp_path):
    run = read_run(folder)
    qpos = run.signals.runs[0].recording.truth.qpos
    assert qpos.shape[1] == run.robot.nq == DESIGN.mj.nq + 2
    assert main(["replay", str(folder), "--save", str(tmp_path / "again.rrd"), "--quiet"]) == 0
    (row,) = ran(tmp_path / "out", "measure", folder / "signals.parquet")["iterations"]
    assert row["arm_rms"] == pytest.approx(measures(folder)[0]["arm_rms"], rel=1e-9)


def test_identify_judges_by_the_springs_and_hinges_of_the_individual():
    """It cuts by the options of laser; the payload is counted once."""
    known, own = (prepare(cut(LaserCfg(individual=i, payload=60.0))) for i in (None, NUMBER))
    design, individual = arm_of(known), arm_of(own)
    expected = np.diag(design.stiffness) * own.individual.gear_stiffness
    assert np.diag(individual.stiffness) == pytest.approx(expected)
    assert individual.n_free == design.n_free + 2
    assert individual.mj.body("tool").mass[0] == design.mj.body("tool").mass[0] == 60.0


def test_compare_cuts_with_the_individual_of_its_options():
    options = {"poses": ("p1",), "speeds": (40.0,), "without": ("ripple",)}
    cfg = CompareCfg(individual=NUMBER, friction_drift=-5.0, temperature=40.0, **options)
    (case,) = cases_of(cfg, 0)
    assert (case.cut.individual, case.cut.friction_drift) == (Drawn(NUMBER), -0.05)
    assert case.cut.temperature == 40.0


def test_the_seed_sets_noise_and_instruments_alone():
    made = [prepare(cut(LaserCfg(individual=NUMBER)), seed=seed) for seed in (0, 1)]
    biases = [e.loaded.model.mj.actuator_biasprm for e in made]
    assert np.array_equal(*biases)
    assert not np.array_equal(*(e.plant.rng.standard_normal(3) for e in made))


# Sweeps


def test_individuals_are_an_axis_of_a_sweep(folder):
    file = folder / "individual.toml"
    assert [p.options["individual"] for p in parse(["individual=2:4"], 0)] == [2, 3]
    points = list(parse([f"individual=2,{file}", "friction-drift=0,10"], 0))
    assert len({point.key for point in points}) == len(points) == 4
    rows = [point.failed(RuntimeError("not run")) for point in points]
    columns = pa.Table.from_pylist(rows, schema=schema())
    assert columns["individual"].to_pylist() == ["2", "2", str(file), str(file)]


def test_the_key_of_a_file_is_its_content(folder, tmp_path):
    file, copy, other = folder / "individual.toml", tmp_path / "b.toml", tmp_path / "c.toml"
    copy.write_bytes(file.read_bytes())
    other.write_text("")
    same, as_well, differs = (identity(LaserCfg(individual=f)) for f in (file, copy, other))
    assert same == as_well
    assert same != differs


def test_resolved_options_say_the_temperature_of_the_model_and_no_spread_of_an_individual():
    plain, own, cold = LaserCfg(), LaserCfg(individual=0), LaserCfg(robot="irb1400")
    assert resolved(plain)["temperature"] == 33.0
    assert resolved(LaserCfg(temperature=33.0)) == resolved(plain)
    assert resolved(LaserCfg(without=("load-friction",)))["temperature"] is None
    assert resolved(cold)["temperature"] is None
    assert (resolved(plain)["friction_spread"], resolved(own)["friction_spread"]) == (2.0, None)


# Bad input


@pytest.mark.parametrize(
    ("text", "robot", "said"),
    [
        ("lost_motion = [1, 1, 1, 1, 1, 2]", "irb1400", "lost_motion does not apply to a robot"),
        ("structure_damping = [1, 1]", "large", "structure_damping must be one factor or 6"),
        ("springs = 3", "large", "the file has the unknown key 'springs'"),
    ],
)
def test_a_file_that_does_not_fit_its_robot_is_refused(text, robot, said, tmp_path, bad_input):
    (tmp_path / "mine.toml").write_text(text)
    bad_input(f"laser --individual mine.toml --robot {robot}", said)
