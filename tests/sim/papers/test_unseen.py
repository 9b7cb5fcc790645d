"""Motions of L1 and N1: what is trained is not what is tested, and errors along a path."""

from dataclasses import replace
from types import SimpleNamespace

import numpy as np
import pytest

from armside.sim.laser.experiment import prepare
from armside.sim.papers.unseen import (
    EDGES,
    PAYLOAD,
    TESTED,
    TRAINED,
    UNSEEN,
    along,
    edge,
    line,
)
from armside.sim.twin.commission import commission
from armside.sim.twin.recordings import ImplausibleError, measured


def test_an_edge_across_the_face_and_the_tested_speeds_are_not_among_the_trained():
    directions = [np.subtract(*ends[::-1]) / np.linalg.norm(np.subtract(*ends)) for ends in EDGES]
    tested = np.subtract(*UNSEEN[::-1]) / np.linalg.norm(np.subtract(*UNSEEN))
    assert max(abs(tested @ each) for each in directions) < 0.8
    assert not set(TRAINED) & set(TESTED)
    assert min(TRAINED) < min(TESTED)
    assert max(TESTED) < max(TRAINED)


def test_strokes_of_an_edge_are_a_tenth_of_a_metre_and_a_line_eight():
    assert prepare(line(0, 0.5)).motion.cuts[0].turn.length == pytest.approx(0.8)
    motion = prepare(edge(0, EDGES[0])).motion
    assert [cut.turn.length for cut in motion.cuts] == pytest.approx([0.1] * 3)


def test_an_error_across_the_path_does_not_count_and_one_along_it_does_with_its_sign():
    experiment = prepare(line(0, 0.5))
    run = experiment.plant.run(np.zeros_like(experiment.loaded.reference))

    def shifted(by):
        truth = run.recording.truth
        moved = replace(truth, tool_position=truth.tool_position + np.outer(truth.time, by))
        seen = SimpleNamespace(recording=SimpleNamespace(truth=moved))
        return along(experiment, seen)[0]

    plain = shifted([0.0, 0.0, 0.0])
    assert abs(plain.mean()) < 1e-12
    np.testing.assert_allclose(shifted([0.0, 1.0, -2.0]), plain, atol=1e-9)
    growth = shifted([1e-3, 0.0, 0.0]) - plain
    np.testing.assert_allclose(np.diff(growth), 1e-6, rtol=1e-6)  # 1 mm/s, every millisecond


def test_the_acceleration_along_the_path_is_that_of_the_tool():
    experiment = prepare(line(0, 0.5))
    run = experiment.plant.run(np.zeros_like(experiment.loaded.reference))
    position, acceleration = along(experiment, run)
    h, box = 1e-3, np.ones(40) / 40  # 25 Hz and below: noise of torque is above
    second = np.diff(position, n=2) / h**2
    smooth = (np.convolve(each, box, mode="valid") for each in (second, acceleration[1:-1]))
    by_position, by_unit = smooth
    assert np.std(by_position - by_unit) < 0.25 * np.std(by_position)


def test_a_heavy_tool_that_bends_far_is_commissioned_only_unchecked(monkeypatch):
    class IdentifiedError(Exception):
        pass

    def identify(*_, **__):
        raise IdentifiedError

    monkeypatch.setattr("armside.sim.twin.commission.identify", identify)
    experiment = prepare(edge(0, EDGES[0]))
    plain = np.zeros_like(experiment.loaded.reference)
    cut = measured(experiment.plant.run(plain), "heavy")
    with pytest.raises(ImplausibleError, match=r"heavy: the tool is up to .* mm from where"):
        commission([cut], payload=PAYLOAD)
    with pytest.raises(IdentifiedError):
        commission([cut], payload=PAYLOAD, checked=False)
    still = np.zeros_like(cut.reference) + cut.reference[0]
    for changed, said in (
        ({"motor_torque": cut.motor_torque * np.nan}, "motor_torque holds values that are not fin"),
        ({"tool": cut.tool * np.nan}, "tool holds values that are not finite"),
        ({"reference": still}, "the reference never moves"),
        ({"motor_torque": 200.0 * cut.motor_torque}, "it must be in N m of the motor"),
    ):
        with pytest.raises(ImplausibleError, match=said):
            commission([replace(cut, **changed)], payload=PAYLOAD, checked=False)
