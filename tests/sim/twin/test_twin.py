"""A twin on disk, the corrections that it makes, and recordings that it refuses."""

import json
import os
from dataclasses import fields, replace

import numpy as np
import pytest

from armside.sim.cell import LARGE_ROBOT_POSES
from armside.sim.laser import Cut, prepare
from armside.sim.laser.experiment import true_tool_error
from armside.sim.motion.contour import slot, square
from armside.sim.twin.commission import MOST, checked_against, plan
from armside.sim.twin.correction import learn_in_twin
from armside.sim.twin.first_cut import Refreshed, refreshed
from armside.sim.twin.recordings import ImplausibleError, MeasuredCut, measured
from armside.sim.twin.tool_sensor import TRACKER
from armside.sim.twin.twin import FORMAT, Twin, TwinError, stored_twin

HEAVY = 90.0
"""[kg], 50 more than in the robot's file."""
ELSEWHERE = Cut(pose=replace(LARGE_ROBOT_POSES["p2"], position=(1.7, -0.2, 1.5)), speed=0.05)


@pytest.fixture(scope="module")
def corrected(twin):
    return twin.correction(ELSEWHERE)


def test_the_first_run_of_an_unseen_cut_is_right(twin, corrected, cut_by):
    experiment, plain = cut_by(ELSEWHERE, seed=9)
    _, first = cut_by(ELSEWHERE, 9, corrected.correction)
    before, after = (true_tool_error(experiment.motion, run).rms for run in (plain, first))
    assert corrected.trusted
    assert after < 0.1 * before
    assert corrected.prediction.inside < 0.03 * corrected.prediction.uncorrected
    assert corrected.prediction.uncorrected == pytest.approx(before, rel=0.1)


CURVES = {"square": square(0.012, 0.0018), "slot": slot(0.020, 0.006)}


@pytest.mark.parametrize("curve", CURVES.values(), ids=CURVES)
def test_corners_are_learned_inside_a_twin(twin, curve):
    """A law that takes gears for stiff and friction for a repeating load leaves 20 um there."""
    cut = replace(ELSEWHERE, contour=curve, speed=0.04)
    design, experiment = twin.design, prepare(replace(cut, friction_spread=0.0))
    _, rms = learn_in_twin(design, twin.individual, experiment)
    assert rms.min() < min(8e-6, 0.03 * rms[0])


def test_feedback_of_one_run_finds_the_friction_that_has_drifted(twin, corrected, cut_by):
    drifted = replace(ELSEWHERE, friction_drift=0.1)
    _, run = cut_by(drifted, 9, corrected.correction)
    after = refreshed(twin, [measured(run)])
    assert after.twin.friction[:3] == pytest.approx(1.1, rel=0.03)  # the axes that cut
    assert after.advice is None
    worn = refreshed(twin, [measured(cut_by(replace(ELSEWHERE, friction_drift=0.6), 9)[1])])
    assert worn.advice is not None
    assert "friction of axis" in worn.advice


def test_a_heavier_tool_that_is_known_is_not_taken_for_friction(twin, cut_by):
    run = measured(cut_by(replace(ELSEWHERE, payload=HEAVY), 9)[1])
    known, unknown = refreshed(twin, [run], HEAVY), refreshed(twin, [run])
    assert known.twin.friction == pytest.approx(1.0, abs=0.05)
    assert known.growth.max() < 2.5
    assert np.abs(unknown.twin.friction - 1.0).max() > 0.5
    assert unknown.advice is not None


@pytest.mark.parametrize(
    ("factor", "said"), [(0.7, "axis 2 is 0.70 times"), (1.4, "axis 2 is 1.40 times"), (0.8, "")]
)
def test_friction_that_rose_or_fell_by_more_than_three_tenths_is_reported(twin, factor, said):
    friction = np.array([1.0, factor, 1.0, 1.1, 0.9, 1.0])
    advice = Refreshed(twin=replace(twin, friction=friction), growth=np.ones(6)).advice
    assert said in advice if said else advice is None


def test_a_saved_twin_is_the_same_twin(twin, tmp_path, corrected):
    twin.save(tmp_path)
    again = Twin.load(tmp_path)
    for name in ("theta", "covariance", "friction", "held_out"):
        assert np.array_equal(getattr(again, name), getattr(twin, name), equal_nan=True)
    assert np.array_equal(again.correction(ELSEWHERE).correction, corrected.correction)


@pytest.mark.parametrize(
    ("change", "said"),
    [
        (lambda c: c | {"format": 99}, "is a twin of format 99"),
        (lambda c: c | {"robot": "irb1400"}, "has changed since"),
        (lambda c: c | {"robot": "mine"}, "which is not known"),
        (lambda c: c | {"digest": "0" * 16}, "has changed since"),
        (lambda c: c | {"parameters": {"a": 1.0}}, "by another version"),
        (lambda c: c | {"friction": [None] * 6}, "damaged twin"),
        (lambda c: c | {"robot": ["large"]}, "which is not known"),
        (lambda c: c | {"payload": "heavy"}, "damaged twin"),
        (lambda c: c | {"payload": -1.0}, "payload must be"),
        (lambda c: c | {"friction": [1.0, 2.0]}, "must be 6 positive values"),
        (lambda c: c | {"friction": [1.0, -2.0, 1, 1, 1, 1]}, "must be 6 positive values"),
        (lambda c: c | {"parameters": c["parameters"] | {"mass 3": 1e308}}, "mass 3 is that of no"),
        (lambda c: c | {"cuts": 3}, "damaged twin"),
        (lambda c: c | {"sensor": "camera"}, "its sensor is 'camera', not one of tracker, imu"),
        (lambda c: c | {"sensor": ["imu"]}, "its sensor is"),
        (lambda c: c | {"held_out": [0.0] * len(c["cuts"])}, "held_out must be .* residuals > 0 m"),
        (lambda c: c | {"held_out": [-1e-6] * len(c["cuts"])}, "held_out must be .* got .-1e-06"),
        (lambda c: c | {"held_out": [1e-5]}, "held_out must be 2 residuals"),
        (lambda c: c | {"held_out": [1e-5, True]}, "held_out must be real .*bool|truth value"),
        (lambda c: {"format": FORMAT}, "damaged twin"),
        (lambda c: [], "is a twin of format None"),
    ],
)
def test_a_twin_that_does_not_fit_is_refused(twin, tmp_path, change, said):
    twin.save(tmp_path)
    file = tmp_path / "twin.json"
    file.write_text(json.dumps(change(json.loads(file.read_text()))))
    with pytest.raises(TwinError, match=said):
        Twin.load(tmp_path)


@pytest.mark.parametrize(
    "covariance",
    [
        lambda c: c[:-1],
        lambda c: -c,
        np.zeros_like,
        lambda c: 1e-12 * c,
        lambda c: c > 0.0,
        lambda c: c + np.triu(c, 1) + 1e-3 * np.eye(len(c), k=1),
        lambda c: np.full_like(c, np.nan),
        lambda c: np.array([{"a": 1}], dtype=object),
        lambda c: c.astype(str),
    ],
)
def test_a_twin_with_a_damaged_covariance_is_refused(twin, tmp_path, covariance):
    twin.save(tmp_path)
    np.save(tmp_path / "covariance.npy", covariance(twin.covariance), allow_pickle=True)
    with pytest.raises(TwinError):
        Twin.load(tmp_path)


@pytest.mark.parametrize("name", ["twin.json", "covariance.npy"])
@pytest.mark.parametrize("content", [b"", b"[" * 100_000, bytes(1000), b"\x93NUMPY\x01\x00"])
def test_a_twin_with_a_damaged_file_is_refused(twin, tmp_path, name, content):
    twin.save(tmp_path)
    (tmp_path / name).write_bytes(content)
    with pytest.raises(TwinError):
        Twin.load(tmp_path)


def test_a_twin_of_a_pipe_is_refused_at_once(twin, tmp_path):
    twin.save(tmp_path)
    for name in ("covariance.npy", "twin.json"):
        (tmp_path / name).unlink()
        os.mkfifo(tmp_path / name)
        for load in (Twin.load, stored_twin):
            with pytest.raises(TwinError):
                load(tmp_path)


def test_a_folder_without_a_twin_is_refused(tmp_path):
    with pytest.raises(TwinError, match=r"holds no twin\.json"):
        Twin.load(tmp_path)


def test_a_twin_corrects_its_own_robot_only(twin):
    with pytest.raises(TwinError, match="the cut is for another"):
        twin.correction(Cut(robot="irb1400"))


@pytest.mark.parametrize(
    ("change", "said"),
    [
        (lambda c: {"motor_torque": c.motor_torque * 240.0}, "in N m of the motor"),
        (lambda c: {"motor_torque": c.motor_torque * np.nan}, "not finite"),
        (lambda c: {"motor_angle": np.rad2deg(c.motor_angle)}, "rad from its reference"),
        (lambda c: {"tool": None}, "has no samples of a laser tracker"),
        (lambda c: {"tool": c.tool * np.nan}, "not finite"),
        (lambda c: {"tool": c.tool * 1e3}, "from where the motor angles put it"),
        (lambda c: {"tool": c.tool[:, [1, 0, 2]]}, "from where the motor angles put it"),
        (lambda c: {"rest": c.rest + np.array([0.0, 0.0, 0.1])}, "another flange"),
    ],
)
def test_a_recording_that_cannot_be_is_named(twin, passes, change, said):
    cut = measured(passes[0], "cut-7")
    bad = replace(cut, **change(cut))
    with pytest.raises(ImplausibleError, match=f"cut-7.*{said}"):
        checked_against(twin.design, bad, TRACKER)
    checked_against(twin.design, cut, TRACKER)


def test_a_measured_cut_holds_no_ground_truth(passes):
    """Destroyed truth changes no bit of what identification reads."""
    run = passes[0]
    truth = run.recording.truth
    names = {field.name for field in fields(truth)} - {"time", "gear_error"}
    lost = {name: np.full_like(getattr(truth, name), np.nan) for name in names}
    blind = replace(run, recording=replace(run.recording, truth=replace(truth, **lost)))
    cuts = [measured(one) for one in (run, blind)]
    for field in fields(MeasuredCut):
        values = [getattr(cut, field.name) for cut in cuts]
        assert values[0] is values[1] or np.array_equal(*values), field.name


def test_a_shorter_plan_begins_a_longer_one():
    assert plan(4) == plan(MOST)[:4]
    for count in (0, MOST + 1):
        with pytest.raises(ValueError, match="cuts must be from 1 to"):
            plan(count)
