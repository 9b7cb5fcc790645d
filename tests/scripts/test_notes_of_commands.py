"""A limit that changed what was asked is a line on the screen and an entry of the summary."""

import json
import sys
from pathlib import Path
from types import ModuleType

import numpy as np
import pytest
from tests.calibration import experiments, search
from tests.claims import ablations, laser
from tests.claims import laser_irb1400 as irb1400_laser
from tests.claims._learned import Learned
from tests.claims.claims import Claim

from armside.scripts.commands import verify
from armside.scripts.commands.commission import named
from armside.sim.evaluation.check import Check, Table
from armside.sim.notes import Cause, Note
from armside.sim.robot.effects import Effect
from armside.sim.tuning.evaluation import Network

HIT = Note(cause=Cause.SATURATION, text="drives saturate: torque limit of axis 2")
LINE = "Note: drives saturate: torque limit of axis 2 (in"


def in_summary(out, count):
    (note,) = json.loads(out)["notes"]
    assert note["cause"] == "saturation"
    assert note["text"] == f"{HIT.text} (in {count})"


def test_verify_shows_the_notes_of_its_table(armside, monkeypatch):
    table = Table("A claim", ["seed"], [[0]], [], [HIT])
    monkeypatch.setattr(verify, "CLAIMS", {"small": Claim(1, lambda: lambda seeds: table)})
    assert f"Note: {HIT.line}" in armside("verify small").out
    assert json.loads(armside("verify small --json").out)["notes"][0]["text"] == HIT.text


@pytest.mark.parametrize(
    ("module", "claim", "runs"),
    [
        (laser, laser.laser, 6),
        (ablations, ablations.ablations, 24),
        (irb1400_laser, irb1400_laser.laser, 8),
    ],
)
def test_claims_of_learning_count_their_limits(monkeypatch, module, claim, runs):
    motor, arm = np.linspace(np.ones(6), np.full(6, 0.05), 6), np.linspace(1.0, 0.4, 6)

    def learned(cut, seed, design=None):
        names = ("motor_inf", "motor_two", "arm_rms", "arm_maxdev")
        run = Learned(zip(names, (motor, motor, arm, arm), strict=True))
        run.notes = [HIT] if (seed, cut.pose) == (1, "p1") else []
        return run

    monkeypatch.setattr(module, "learned", learned)
    (note,) = claim([0, 1]).notes
    hit = {6: 1, 24: 6, 8: 2}[runs]  # of the cuts at p1 with seed 1
    assert note.text == f"{HIT.text} (in {hit} of {runs} runs)"


def test_calibrate_counts_the_limits_of_its_experiments(armside, monkeypatch):
    def part(model, effects, note):
        note([HIT])
        note([])
        yield Check("a1", "worst motor", "0.1", 0.05, high=0.1)

    monkeypatch.setattr(search, "CHECKS", (part,))
    assert f"{LINE} 1 of 2 experiments)" in armside("calibrate --generations 0").out
    in_summary(armside("calibrate --generations 0 --json").out, "1 of 2 experiments")
    assert [note.text for note in search.evaluate(search.START).notes] == [
        f"{HIT.text} (in 1 of 2 experiments)"
    ]


def test_experiments_of_calibration_pass_their_notes_on(monkeypatch):
    model, said = search.load_model(search.assets.LARGE_ROBOT_XML), []
    effects = frozenset(Effect)
    experiments.learned(model, effects, "p1", speed=0.1, iterations=0, note=said.extend)
    assert [note.cause for note in said] == [Cause.SPEED]
    given = []
    monkeypatch.setattr(experiments, "learned", lambda *_, note, **__: given.append(note))
    monkeypatch.setattr(experiments.bands, "nominal_by_position", lambda _: [])
    monkeypatch.setattr(experiments.bands, "growth", lambda *_: [])
    monkeypatch.setattr(experiments.bands, "fitted_model", lambda _: [])
    for part in (experiments.nominal_checks, experiments.model_checks):
        assert list(part(model, effects, said.extend)) == []
    assert len(given) == 9 + len(experiments.bands.SPEEDS)
    assert set(given) == {said.extend}


def test_train_counts_the_limits_of_its_runs(armside, monkeypatch):
    """Without Stable-Baselines3: the first step of the real env."""
    ppo = ModuleType("armside.scripts.studies.ppo")

    def learn(env, steps, *, start, seed, discount, done):
        env.reset(seed=seed, options={"speed": 0.1})
        env.step(np.tile(start, (env.num_envs, 1)).astype(np.float32))
        return Network(weights=(np.zeros((50, 3)),), biases=(start,)), []

    ppo.learn = learn  # pyright: ignore[reportAttributeAccessIssue]
    monkeypatch.setitem(sys.modules, "armside.scripts.studies.ppo", ppo)
    status, out, err = armside("train --robots 2 --steps 1 --json --out a")
    assert (err, status) == ("", 0)
    (note,) = json.loads(out)["notes"]
    assert note["cause"] == "speed"
    assert "the speed is lowered from 100 to 80.62 mm/s" in note["text"]
    assert "(in 4 of 4 runs)" in note["text"]


class TestCommission:
    def test_recordings_of_one_name_are_told_apart(self):
        given = [Path("a/run"), Path("b/run"), Path("c/mine.csv")]
        assert named(given) == {"a/run": given[0], "b/run": given[1], "mine.csv": given[2]}
        with pytest.raises(ValueError, match="the recording a/run is given twice"):
            named([given[0], given[0]])

    def test_one_of_two_recordings_of_a_name_is_left_out(self, armside):
        line = "commission --recordings a/run b/run --leave-out"
        assert "no cut 'run' to leave out. Cuts: a/run, b/run" in armside(f"{line} run").err
        assert "a/run is no recorded cut" in armside(f"{line} b/run").err
