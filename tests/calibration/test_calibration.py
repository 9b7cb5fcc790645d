"""Calibration: what a trim sets, in a model and in the text of its file."""

from dataclasses import replace

import numpy as np
import pytest

from armside import assets
from armside.sim.evaluation.check import Check
from armside.sim.notes import Cause, Note
from armside.sim.robot.effects import Effect, available
from armside.sim.robot.model import load_model

from . import __main__ as command
from . import experiments, search
from .experiments import learning_checks
from .parameters import compiled, differing, numbers, rewrite
from .search import START, mutate, outside

HIT = Note(cause=Cause.SATURATION, text="drives saturate: torque limit of axis 2")


def test_a_file_gets_the_numbers_of_a_trim():
    trim = replace(START, gear_soft=0.2, lost_motion=0.5, friction=(1.0, 1.1, 1.2, 1.3, 1.4, 1.5))
    mj, found = compiled(assets.LARGE_ROBOT_XML, trim), numbers(trim)
    for name, spring in found.springs.items():
        assert [*mj.joint(name).stiffness, *mj.joint(name).damping] == pytest.approx(spring)
    axes = [mj.actuator(f"axis_{i}").id for i in range(1, 7)]
    assert mj.actuator_gainprm[axes][:, [4, 6]] == pytest.approx(found.controllers)
    assert mj.actuator_dynprm[axes][:, [5, 6]] == pytest.approx(found.bristles)
    for name, values in found.numerics.items():
        assert mj.numeric(name).data == pytest.approx(values)


def test_rewriting_twice_changes_nothing():
    text = rewrite(assets.LARGE_ROBOT_XML.read_text(), START)
    assert rewrite(text, START) == text


def test_a_file_without_the_named_element_is_refused():
    text = assets.LARGE_ROBOT_XML.read_text().replace('"gear_temperature"', '"oven"')
    with pytest.raises(ValueError, match="gear_temperature"):
        rewrite(text, START)


def test_servo_gains_are_those_of_a_second_order_system():
    found = numbers(START)
    inertia = 220.0**2 * 5.0e-3 + 700.0
    w0 = 2 * np.pi * START.servo_frequency[0]
    assert found.controllers[0] * 220.0**2 == pytest.approx(
        [inertia * w0**2, 2 * START.servo_damping * inertia * w0]
    )


def test_a_trim_that_makes_no_sense_is_refused():
    with pytest.raises(ValueError, match="servo_damping"):
        replace(START, servo_damping=float("nan"))


def test_mutation_is_the_same_for_the_same_seed_and_keeps_three_digits():
    one, two = (mutate(START, np.random.default_rng(5)) for _ in range(2))
    assert one == two != START
    for value in (one.servo_damping, *one.servo_frequency, *one.friction):
        assert value == pytest.approx(float(f"{value:.3g}"), rel=1e-12)


def test_quantities_that_a_file_has_otherwise_are_named(tmp_path):
    file = tmp_path / "robot.xml"
    file.write_text(rewrite(assets.LARGE_ROBOT_XML.read_text(), START))
    assert differing(file, START) == []
    assert differing(file, replace(START, temperature=40.0)) == ["gear_temperature"]
    assert differing(file, replace(START, servo_damping=1.0)) == ["controllers"]


def test_the_distance_from_a_band_is_relative_and_keeps_a_margin():
    assert outside(Check("x", "", "", 1.0, low=0.5, high=2.0)) == 0.0
    assert outside(Check("c5", "no margin", "", 3.0, high=2.0)) == pytest.approx(0.5)
    assert outside(Check("x", "", "", 1.0, low=1.0)) == pytest.approx(0.05)
    assert Check("x", "", "", 1.0, low=1.0).holds


def test_the_committed_robot_meets_its_learning_targets():
    """All targets: python -m tests.calibration --generations 0."""
    model = load_model(assets.LARGE_ROBOT_XML)
    missed = [check for check in learning_checks(model, available(model)) if not check.holds]
    assert not missed


def test_calibration_counts_the_limits_of_its_experiments(monkeypatch, capsys):
    def part(model, effects, note):
        note([HIT])
        note([])
        yield Check("a1", "worst motor", "0.1", 0.05, high=0.1)

    monkeypatch.setattr(search, "CHECKS", (part,))
    assert command.main(["--generations", "0"]) == 0
    printed = capsys.readouterr().out
    assert f"Note: {HIT.text} (in 1 of 2 experiments)" in printed
    assert "holds: a1: worst motor: 0.05 (≤ 0.1)" in printed
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


def test_a_missed_target_or_bad_input_ends_with_its_status(monkeypatch, capsys):
    def part(model, effects, note):
        yield Check("a1", "worst motor", "0.1", 0.2, high=0.1)

    monkeypatch.setattr(search, "CHECKS", (part,))
    assert command.main(["--generations", "0"]) == 1
    assert "FAILS: a1" in capsys.readouterr().out
    for words in (["--generations", "-1"], ["--file", "nope.xml"]):
        with pytest.raises(SystemExit) as ended:
            command.main(words)
        assert ended.value.code == 2
