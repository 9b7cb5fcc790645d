"""Claims about motor-side learning at random poses: where they fail, and one cut."""

from types import SimpleNamespace

import numpy as np
import pytest

from armside.scripts.verifications import irb1400_poses
from armside.scripts.verifications.learned import Learned
from armside.sim.notes import Tally

from .verdicts import failing


def with_worst(monkeypatch, worst, alone=0.01):
    """Cuts of seeds 0 .. whose third motor ends at these fractions of the largest at k = 0, twice
    as high by the heuristic law."""
    monkeypatch.setattr(irb1400_poses, "random_cut", lambda _, seed: SimpleNamespace(speed=0.03))

    def learned(_cut, seed, times=2.0):
        norms = np.full((6, 6), 0.02)
        norms[0, 0], norms[-1, 2] = 2.0, 2.0 * worst[seed] * times
        return Learned(motor_inf=norms, arm_rms=np.array([2e-4, 1e-4]))

    monkeypatch.setattr(irb1400_poses, "learned", learned)
    on_nominal = lambda cut, seed: (learned(cut, seed, 1.0), alone)  # noqa: E731
    monkeypatch.setattr(irb1400_poses, "on_nominal", on_nominal)
    return irb1400_poses.poses(range(len(worst)))


def test_claims_hold_at_the_bar(monkeypatch):
    table = with_worst(monkeypatch, [0.05, 0.1])
    assert failing(table) == []
    arm = [pytest.approx(um) for um in (200.0, 100.0, 100.0)]
    assert table.rows[1] == (1, 30.0, 0.2, 0.01, 0.1, 3, 0.01, *arm)


def test_one_motor_above_the_bar_fails_and_is_counted(monkeypatch):
    (failed,) = failing(with_worst(monkeypatch, [0.05, 0.05, 0.101], alone=0.06))
    assert "1 of 3 do not, median 0.050, worst 0.101" in failed


def test_a_motor_that_is_not_learned_fails_all_but_the_comparison(monkeypatch):
    assert len(failing(with_worst(monkeypatch, [0.05, 1.01]))) == 3


def test_motors_of_a_random_cut_are_learned_where_one_hardly_moves():
    row = irb1400_poses._row(irb1400_poses.random_cut("irb1400", 104), 104, Tally())
    speed, heuristic, first, last = row[1:5]
    assert 12.0 <= speed <= 77.0
    assert last <= irb1400_poses.LEARNED < min(first, heuristic)
