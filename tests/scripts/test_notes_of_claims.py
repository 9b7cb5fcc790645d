"""Claims count the limits that changed the runs behind their rows, whatever made these."""

from contextlib import nullcontext
from types import SimpleNamespace

import numpy as np
import pytest

from armside.arrays import Array
from armside.scripts.verifications import (
    chapter9,
    controls,
    env,
    estimation,
    first_cut,
    first_cut_imu,
    imu_large,
    imu_twin,
    irb1400,
    tuning,
)
from armside.sim.laser import Cut
from armside.sim.laser.job import LearningJob
from armside.sim.notes import Cause, Note, Tally
from armside.sim.robot.spread import Drawn
from armside.sim.tuning.evaluation import run_episode
from armside.sim.tuning.rules import Rules

from . import test_claims, test_claims_of_the_imu

HIT = Note(cause=Cause.SATURATION, text="drives saturate: torque limit of axis 2")


def tally(*hit):
    """Notes of runs, of which those of True hit a limit."""
    said = Tally()
    for each in hit:
        said.add([HIT] if each else [])
    return said


def here(_, *work):
    """Workers that hand out what a seed is told to give."""
    return lambda: nullcontext(SimpleNamespace(map=lambda function, cases: list(*work)))


def by_estimation(monkeypatch):
    rows = [((0, "p1", test_claims.HOLDING, False), tally(True, False))]
    monkeypatch.setattr(estimation, "Workers", here(None, rows))
    return estimation.estimation([0]), "1 of 2 learned cuts"


def by_controls(monkeypatch):
    names = (controls._KINEMATICS, controls._NO_DYNAMICS, *controls.variants())
    found = dict.fromkeys(names, controls.Found(1e-5, 0.1))
    found[controls._DEFAULT] = controls.Found(1e-5, 0.1, [HIT])
    monkeypatch.setattr(controls, "Workers", here(None, [found] * 3))
    return controls.controls([0]), f"3 of {3 * len(controls.variants())} learned cuts"


def by_chapter_9(monkeypatch):
    monkeypatch.setattr(chapter9, "checks", lambda results: [])
    jobs = {job for study in chapter9.EXPERIMENTS.values() for job in study.jobs(0).values()}
    found = [({}, [HIT] if i == 0 else []) for i in range(len(jobs))]
    monkeypatch.setattr(chapter9, "Workers", here(None, found))
    return chapter9.chapter9([0]), f"1 of {len(jobs)} experiments"


def by_env(monkeypatch):
    def row(kind, seeds, said):
        said.include(tally(True, False, False))
        return (100, 0, 1.0, 2.0, -1.0, 1.0, 0)

    monkeypatch.setattr(env, "_row", row)
    return env.env(range(60)), "2 of 6 runs"  # in batches of 50


def by_tuning(monkeypatch):
    episode = SimpleNamespace(ratio=0.5, rms_true=[1.0, 0.5], diverged=False, notes=([HIT], []))
    names = ("thesis design", "best fixed design by search", "learned policy")
    monkeypatch.setattr(tuning, "searched", lambda: tuning.THESIS)
    monkeypatch.setattr(tuning, "identified", lambda: tuning.THESIS)
    monkeypatch.setattr(tuning, "_episodes", lambda *_: {name: [episode] * 2 for name in names})
    return tuning.tuning(range(2)), "6 of 12 runs"


def by_first_cut(monkeypatch):
    n = first_cut.N_TASKS
    each, inside = np.full(n, 0.1), np.ones(n, dtype=bool)
    left: dict[int, Array] = dict.fromkeys(first_cut.COUNTS, each)
    held = dict.fromkeys(first_cut.COUNTS, inside)
    found = first_cut.Found(
        1, 0, left, held, each, each, each, inside, 1.0, 1.0, tally(True, False)
    )
    monkeypatch.setattr(first_cut, "Workers", here(None, [found] * 2))
    return first_cut.first_cut([0, 1]), "2 of 4 runs"


def by_first_cut_imu(monkeypatch):
    n = first_cut.N_TASKS
    inside = np.ones(n, dtype=bool)
    found = first_cut_imu.Found(1, 0, np.full(n, 0.1), inside, 1.0, tally(True, False))
    monkeypatch.setattr(first_cut_imu, "Workers", here(None, [found] * 2))
    return first_cut_imu.first_cut_imu([0, 1]), "2 of 4 runs"


def by_imu_twin(monkeypatch):
    twin = SimpleNamespace(design=SimpleNamespace(nominal=None, model=None))
    monkeypatch.setattr(imu_twin, "commissioned", lambda robot: twin)
    monkeypatch.setattr(
        imu_twin, "Drawn", lambda _: SimpleNamespace(of=lambda _: SimpleNamespace(hidden=()))
    )
    monkeypatch.setattr(imu_twin, "tasks", lambda n, seed: [(None, None)] * 2)
    monkeypatch.setattr(imu_twin, "uncorrected", lambda cut, robot, said: said.add([HIT]))
    left = {name: np.full(2, 0.1) for name in (*imu_twin.BLOCKS, imu_twin.EVERYTHING)}
    monkeypatch.setattr(imu_twin, "lacking", lambda twin, true, runs: left)
    return imu_twin.imu_twin([0]), "2 of 2 runs"


def made_up(monkeypatch, module):
    """Runs of the IMU that all saturate."""
    result = test_claims_of_the_imu.imu_run()
    monkeypatch.setattr(module, "prepare", lambda _: [None, None])
    monkeypatch.setattr(module, "run_one", lambda *_: result)
    monkeypatch.setattr(module, "reprocessed", lambda result, _: result)
    monkeypatch.setattr(module, "notes", lambda runs: [HIT for run in runs if run is result])


def by_imu(monkeypatch):
    made_up(monkeypatch, irb1400)
    return irb1400.imu([0, 1]), "10 of 10 runs"  # simultaneous, and twice two in sequence


def by_imu_large(monkeypatch):
    made_up(monkeypatch, imu_large)
    return imu_large.imu_large([0, 1]), "2 of 2 runs"


def by_causes(monkeypatch):
    made_up(monkeypatch, irb1400)
    result = test_claims_of_the_imu.imu_run()
    names = ("as chosen", "sensor delays left in", "central differences", "mapped, then filtered")

    def causes(experiment, seed, each):
        each(result)
        return [(name, result.measures) for name in (*names, "both", "rigid robot, both")]

    monkeypatch.setattr(irb1400, "causes", causes)
    monkeypatch.setattr(irb1400, "notes", lambda runs: [HIT])
    return irb1400.imu_causes([0, 1]), "2 of 2 runs"


def by_rest(monkeypatch):
    base = {"off_rms": np.full(3, 0.01), "on_rms": np.full(3, 0.1), "on_level": np.full(3, 0.3)}
    rested = test_claims_of_the_imu.rested(base, 0, "", None)
    monkeypatch.setattr(irb1400, "run_rest", lambda *_: rested)
    monkeypatch.setattr(irb1400, "saturation", lambda recording: [HIT])
    return irb1400.rest([0, 1]), "2 of 2 runs"


CLAIMS = {
    "estimation": by_estimation,
    "estimation-controls": by_controls,
    "chapter9": by_chapter_9,
    "env": by_env,
    "tuning": by_tuning,
    "first-cut": by_first_cut,
    "first-cut-imu": by_first_cut_imu,
    "imu-twin": by_imu_twin,
    "imu": by_imu,
    "imu-causes": by_causes,
    "imu-large": by_imu_large,
    "imu-rest": by_rest,
}


@pytest.mark.parametrize("claim", CLAIMS)
def test_a_claim_counts_the_limits_of_its_runs(claim, monkeypatch):
    table, counted = CLAIMS[claim](monkeypatch)
    assert [note.text for note in table.notes] == [f"{HIT.text} (in {counted})"]


def test_each_run_of_a_task_is_counted_with_its_notes():
    """A corner lowers the speed of the task, in the run of a robot and of one without noise."""
    said = Tally()
    imu_twin.uncorrected(Cut(pose="p2", speed=0.1), Drawn(1001), said)
    first_cut.left_alone(Cut(pose="p2", speed=0.1), Drawn(1001), said)
    (note,) = said.notes("runs")
    assert note.cause is Cause.SPEED
    assert note.text.endswith("(in 2 of 2 runs)")


def test_a_job_has_the_notes_of_its_cut():
    arrays, notes = LearningJob(cut=Cut(speed=0.1), iterations=0).noted()
    assert [note.cause for note in notes] == [Cause.SPEED]
    assert arrays["reached_speed"] < 0.1


def test_an_episode_has_the_notes_of_each_of_its_runs():
    episode = run_episode(Rules(iterations=1), 0, lambda observed: np.zeros(3))
    assert len(episode.notes) == 2
