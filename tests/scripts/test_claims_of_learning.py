"""Claims of learning fail where one seed alone leaves its bar: see `test_claims`."""

from types import SimpleNamespace

import numpy as np
import pytest

from armside.scripts.verifications import (
    ablations,
    irb1400_laser,
    laser,
)
from armside.scripts.verifications.learned import Learned
from armside.sim.laser.design import THESIS
from armside.sim.robot.effects import Effect

from .verdicts import failing, fails_by_itself


def learned_on_irb1400(monkeypatch, changed):
    """Two seeds of `verify laser-irb1400`; the second changed at p2."""

    def learned(cut, seed, design=None):
        run = {
            "motor_two": np.array([np.full(6, 1.0), np.full(6, 0.09)]),
            "motor_inf": np.array([np.full(6, 1.0), np.full(6, 0.09)]),
            "arm_rms": np.array([1.0, 0.4]),
        }
        if design is THESIS:
            worse = np.array([np.full(6, 1.0), np.full(6, 0.095)])
            own = changed.get("thesis", {}) if seed == 1 else {}
            return Learned(run | {"motor_two": worse, "motor_inf": worse} | own)
        assert cut.robot == "irb1400"
        return Learned(run | (changed if seed == 1 and cut.pose == "p2" else {}))

    monkeypatch.setattr(irb1400_laser, "learned", learned)
    return failing(irb1400_laser.laser(range(2)))


@pytest.mark.parametrize(
    ("name", "inside", "outside", "words"),
    [
        ("motor_two", 0.0999, 0.1001, "2-norm ends at 0.1"),
        ("motor_inf", 0.0999, 0.1001, "inf-norm ends at 0.1"),
        ("arm_rms", 0.4999, 0.5001, "half or less"),
    ],
)
def test_learning_on_the_irb1400_is_bounded(monkeypatch, name, inside, outside, words):
    def run(last):
        if name == "arm_rms":
            return learned_on_irb1400(monkeypatch, {name: np.array([1.0, last])})
        one_motor = np.array([np.full(6, 1.0), [0.01, 0.02, last, 0.01, 0.01, 0.01]])
        return learned_on_irb1400(monkeypatch, {name: one_motor})

    assert run(inside) == []
    fails_by_itself(run(outside), words)


@pytest.mark.parametrize("norm", ["motor_two", "motor_inf"])
def test_the_design_of_the_thesis_ends_higher_in_either_norm(monkeypatch, norm):
    for last, holds in ((0.0901, True), (0.0899, False)):
        better = {norm: np.array([np.full(6, 1.0), np.full(6, last)])}
        found = learned_on_irb1400(monkeypatch, {"thesis": better})
        assert (found == []) is holds
        if not holds:
            fails_by_itself(found, "with the design of the thesis")


def test_designs_of_the_irb1400_are_those_of_its_data(monkeypatch):
    ours = irb1400_laser.DEFAULT_DESIGN["irb1400"]
    base = {"gamma": ours.gamma[0], "delta": ours.delta[0], "cutoff": ours.cutoff[0]}

    def run(**changed):
        def asked(_, seed):
            proposal = base | (changed if seed in changed.get("seeds", (2,)) else {})
            model = SimpleNamespace(delay=3, pole=0.5, static_gain=1.0, fit=0.9)
            proposal = {name: proposal[name] for name in base}
            return SimpleNamespace(
                model=model, proposal=SimpleNamespace(contraction=0.5, **proposal)
            )

        monkeypatch.setattr(irb1400_laser, "design_from_data", asked)
        return failing(irb1400_laser.design(range(3)))

    assert run() == []
    assert run(gamma=base["gamma"] - 0.0499) == []
    fails_by_itself(run(gamma=base["gamma"] - 0.0501), "every gain")
    assert run(delta=base["delta"] + 1) == []  # the median stays
    fails_by_itself(run(delta=base["delta"] + 1, seeds=(1, 2)), "the median shift")
    fails_by_itself(run(cutoff=1.0, seeds=(1, 2)), "highest cutoff")


def test_motor_side_learning_is_judged_for_every_seed_and_pose(monkeypatch):
    asked = []

    def learned(cut, seed, design=None):
        asked.append((cut.pose, seed))
        fall = {"p1": 0.4, "p2": 0.6, "p3": 0.8}[cut.pose]
        bad = seed == 6 and cut.pose == "p1"
        rms = np.linspace(1.0, 0.55 if bad else fall, 6)
        motor = np.linspace(np.ones(6), np.full(6, 0.05), 6)
        names = ("arm_rms", "arm_maxdev", "motor_inf", "motor_two")
        return Learned(zip(names, (rms, rms, motor, motor), strict=True))

    monkeypatch.setattr(laser, "learned", learned)
    fails_by_itself(failing(laser.laser([5, 6])), "b1:")
    assert set(asked) == {(pose, seed) for pose in ("p1", "p2", "p3") for seed in (5, 6)}
    assert failing(laser.laser([5, 7])) == []
    assert laser.SHOWN == ("a1", "a3", "a4", "b1", "b6", "b7")


def test_a_learned_cut_is_that_of_its_seed_and_design(monkeypatch):
    from armside.scripts.verifications import learned as room

    asked, made = [], {"iterations": [], "notes": []}
    monkeypatch.setattr(room, "run", lambda cut, **given: asked.append(given) or made)
    design = THESIS
    room.learned(laser.Cut(), 9, design)
    ((given),) = asked
    assert given["seed"] == 9
    assert given["measure"].design is design


@pytest.mark.parametrize(
    ("left_out", "column", "inside", "outside", "words"),
    [
        ("ripple", 6, 0.0999, 0.1001, "motors learn whatever"),
        ("gear-error", 5, 301.0, 299.0, "left with more at p3"),
        ("nothing", 5, 401.0, 399.0, "with all effects p3 does not get better"),
        ("all four", 5, 399.0, 401.0, "with all effects p3 does not get better"),
    ],
)
def test_ablations_are_bounded(monkeypatch, left_out, column, inside, outside, words):
    def run(value):
        def row(seed, name, said):
            # p1: 400 -> 300; p3: 400 -> 450, without any effect -> 350
            cells = [seed, name, 400.0, 300.0, 400.0, 350.0 if name == "all four" else 450.0, 0.05]
            if seed == 1 and name == left_out:
                cells[column] = value
            return tuple(cells)

        monkeypatch.setattr(ablations, "_row", row)
        return failing(ablations.ablations(range(2)))

    assert run(inside) == []
    fails_by_itself(run(outside), words)


def test_ablations_leave_out_each_effect_and_all():
    assert set(ablations.LEFT_OUT.values()) == {(), *((e,) for e in Effect), tuple(Effect)}
