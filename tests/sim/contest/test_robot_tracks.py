"""Tasks on the large robot: what is given describes the cut, and no more."""

import hashlib

import numpy as np
import pytest

from armside.sim.cell import LARGE_CELL
from armside.sim.contest import robot_tracks
from armside.sim.contest.judge import play
from armside.sim.contest.nominal import cut_of, pass_of
from armside.sim.contest.robot_tracks import (
    DRIFT_RUNS,
    MOST_CORRECTION,
    RANGES,
    TRACKS,
    over_all_runs,
    records,
)
from armside.sim.contest.seal import Round
from armside.sim.laser.experiment import prepare
from armside.sim.laser.tool_measure import Source, ToolPath

SALT = b"s" * 32
SEALED = Round("2026-a", hashlib.sha256(SALT).hexdigest(), SALT)
KNOWN = {"robot", "imu", "shape", "position", "quaternion", "size", "speed", "payload"}


@pytest.fixture(scope="module")
def task():
    return TRACKS["tracker"].draw(Round(), 0)


def test_the_nominal_cut_has_the_reference_and_the_path_that_are_given(task):
    nominal = prepare(cut_of(task.given["nominal"]))
    assert set(task.given["nominal"]) == KNOWN
    assert np.allclose(nominal.loaded.reference, task.given["reference"], rtol=0.0, atol=1e-12)
    assert np.array_equal(nominal.programmed, task.given["path"])


def test_records_are_those_of_the_sensors_of_the_track(task):
    zero = np.zeros_like(task.given["reference"])
    seen, error = task.run(0, zero)
    assert set(seen) == {"error", "correction", "motor_angle", "motor_torque", "tracker"}
    assert np.array_equal(seen["error"], task.given["reference"] - seen["motor_angle"])
    assert 1e-6 < error < 5e-3  # [m]
    run = pass_of(task.given["reference"], seen)
    assert np.isnan(run.recording.truth.tool_position).all()
    again = records(run, imu=False, tracker=True)
    assert np.array_equal(again["tracker"]["position"], seen["tracker"]["position"])


def test_a_run_of_records_is_read_by_the_tools_law(task):
    experiment = prepare(cut_of(task.given["nominal"]))
    seen, _ = task.run(0, np.zeros_like(task.given["reference"]))
    run = pass_of(task.given["reference"], seen)
    output = ToolPath(source=Source.TRACKER).prepare(experiment)(run)
    off = np.linalg.norm((output.reference - output(run))[:, :3], axis=1)
    assert 1e-6 < np.sqrt(np.mean(off**2)) < 5e-3  # [m]


def test_limits_keep_a_correction_within_the_joints(task):
    limits, r = task.limits, task.given["reference"]
    assert (limits.correction <= MOST_CORRECTION).all()
    for sign in (-1.0, 1.0):
        angle = r + sign * limits.correction
        assert (angle >= np.array(LARGE_CELL.limits.lower) - 1e-12).all()
        assert (angle <= np.array(LARGE_CELL.limits.upper) + 1e-12).all()


def test_a_judged_task_is_another_one_within_wider_ranges(task):
    sealed = TRACKS["tracker"].draw(SEALED, 0).given["nominal"]
    assert sealed != task.given["nominal"]
    for public, judged in RANGES.values():
        assert judged[0] <= public[0] <= public[1] <= judged[1]
    low, high = RANGES["speed"][1]
    assert low <= sealed["speed"] <= high


@pytest.mark.parametrize("name", ["motor", "first", "drift", "part"])
def test_individual_and_noise_are_drawn_by_256_bits_of_the_seal(name, monkeypatch):
    """Fewer could be tried out by an entry; and no recording has the noise of the judged run."""
    if name == "part":
        pytest.importorskip("shapely")
    seeds, individuals, made = [], set(), robot_tracks.prepare

    def watched(cut, *, seed, **more):
        seeds.append(seed)
        individuals.add(cut.individual.number)
        return made(cut, seed=seed, **more)

    monkeypatch.setattr(
        robot_tracks, "prepare", lambda cut, seed=0, **more: watched(cut, seed=seed, **more)
    )
    monkeypatch.setattr(robot_tracks, "_recorded", lambda task, seed, cut: seeds.append(seed))
    TRACKS[name].draw(SEALED, 0)
    own = SEALED.key(name, 0, "noise")
    others = [seed for seed in seeds if seed not in (0, own)]
    assert individuals == {SEALED.key(name, 0, "robot")}
    assert own in seeds
    assert len(set(others)) == len(others) == (10 if name == "first" else 0)
    assert all(abs(seed - own) > 2**128 for seed in others)


def test_the_score_of_drift_is_the_rms_over_all_runs():
    assert over_all_runs(np.array([1.0, 2.0]), np.array([2.0, 4.0])) == pytest.approx(0.5)


class Silent:
    """Stands for an entry's process that answers zeros, and then stops."""

    isolation, judged = (), False

    def load(self, source):
        self.calls = 0

    def call(self, name, of, shape, seconds):
        self.calls += 1
        return np.zeros(shape) if self.calls == 1 else None

    def end(self):
        pass


def test_a_robot_that_drifts_goes_on_without_the_entry_that_stopped():
    track = TRACKS["drift"]
    row = play("", track.draw(Round(), 1), track, Silent())
    assert (row["runs"], len(row["curve"])) == (1, DRIFT_RUNS)
    assert row["left"] == pytest.approx(1.0, abs=0.01)
