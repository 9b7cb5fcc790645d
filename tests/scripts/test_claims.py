"""Claims of estimation fail where one seed alone leaves its bar, and only there.

What a claim measures is replaced by numbers that hold. Then one number of the last seed is moved to
just inside and just outside of each bar, which is stated here a second time.
"""

from contextlib import nullcontext
from types import SimpleNamespace

import pytest

from armside.scripts.verifications import (
    controls,
    estimation,
)
from armside.scripts.verifications.claims import CLAIMS

from .verdicts import CLOSE, failing, fails_by_itself

FULL_INSTANCES = {
    "kinematics": 10, "laser": 20, "ablations": 3, "env": 1000, "tuning": 100,
    "tuning-iterations": 100, "sweep": 10, "sweep-memory": 10_000, "chapter9": 5, "imu": 20,
    "estimation": 10, "estimation-controls": 10, "imu-causes": 5, "imu-large": 10, "imu-rest": 10,
    "laser-irb1400": 20, "laser-irb1400-design": 20,
}  # fmt: skip


def test_full_instances_have_the_documented_number_of_seeds():
    found = {name: claim.n_seeds for name, claim in CLAIMS.items() if name in FULL_INSTANCES}
    assert found == FULL_INSTANCES


HOLDING = dict.fromkeys(estimation.COLUMNS, 100.0) | {
    "forward_kinematics": 1000.0,
    "estimate": 100.0,
    "start": 2000.0,
    "default_start": 2000.0,
    "hard_start": 2000.0,
    "fast_start": 2000.0,
    "faster_start": 2000.0,
    "motor_5": 500.0,
    "default_motor_5": 500.0,
    "fast_motor": 500.0,
    "faster_motor": 500.0,
}


BARS = [
    ("estimate", "forward_kinematics", 1 / 5, "error of the estimate over that of motor-angle"),
    ("estimate_5", "start", 0.15, "springs, estimate after five"),
    ("estimate_10", "start", 0.10, "springs, estimate after ten"),
    ("tracker_5", "start", 0.10, "springs, tracker after five"),
    ("default_5", "default_start", 0.15, "all gear effects, estimate after five"),
    ("default_10", "default_start", 0.15, "all gear effects, estimate after ten"),
    ("fast_estimate", "fast_start", 0.15, "81 mm/s, estimate"),
    ("faster_estimate", "faster_start", 0.15, "100 mm/s, estimate"),
    ("hard_10", "hard_start", 0.12, "hard case after ten"),
]


def estimated(diverged=False, **changed):
    """Two rows that hold, the second changed."""
    return [(0, "p1", HOLDING, False), (0, "p2", HOLDING | changed, diverged)]


def test_the_claim_of_estimation_holds_and_says_so():
    checks = estimation.verdicts(estimated())
    assert len(checks) == len(BARS) + 2
    assert all(check.holds for check in checks)


@pytest.mark.parametrize(("one", "other", "bar", "words"), BARS)
def test_a_ratio_of_estimation_is_bounded_by_its_bar(one, other, bar, words):
    inside, outside = (
        [
            check.statement
            for check in estimation.verdicts(
                # far above the motor side's, which has a statement of its own
                estimated(**{one: bar * HOLDING[other] * factor, **MOTORS})
            )
            if not check.holds
        ]
        for factor in (1 - CLOSE, 1 + CLOSE)
    )
    assert inside == []
    fails_by_itself(outside, words)


MOTORS = dict.fromkeys(("motor_5", "default_motor_5", "fast_motor", "faster_motor"), 1e4)


@pytest.mark.parametrize(
    ("estimate", "motor"),
    [
        ("estimate_5", "motor_5"),
        ("default_5", "default_motor_5"),
        ("fast_estimate", "fast_motor"),
        ("faster_estimate", "faster_motor"),
    ],
)
def test_the_estimate_must_beat_the_motor_side_everywhere(estimate, motor):
    for factor, holds in ((1 + CLOSE, True), (1 - CLOSE, False)):
        checks = estimation.verdicts(estimated(**{motor: HOLDING[estimate] * factor}))
        found = [check.statement for check in checks if not check.holds]
        assert found == ([] if holds else ["estimate below motor side in every case"])


def test_a_hard_case_may_leave_thirty_micrometres():
    small = {"hard_start": 100.0}
    for length, holds in ((29.9, True), (30.1, False)):
        checks = estimation.verdicts(estimated(hard_10=length, **small))
        assert all(check.holds for check in checks) is holds


def test_one_case_that_diverges_is_enough():
    found = [c.statement for c in estimation.verdicts(estimated(diverged=True)) if not c.holds]
    assert found == ["no case diverges"]


@pytest.fixture
def measured_controls(monkeypatch):
    """Runs the claim on given errors by variant; all others are those of the default."""

    def run(by_name):
        default = controls.Found(error=10e-6, ratio=0.1)
        other = controls.Found(error=50e-6, ratio=0.3)

        def tried(case):
            names = (controls._KINEMATICS, controls._NO_DYNAMICS, *controls.variants())
            found = dict.fromkeys(names, other) | {controls._DEFAULT: default}
            return found | (by_name if case[1] == "p2" else {})

        workers = SimpleNamespace(map=lambda _, cases: [tried(case) for case in cases])
        monkeypatch.setattr(controls, "Workers", lambda: nullcontext(workers))
        return failing(controls.controls(range(2)))

    return run


@pytest.mark.parametrize(
    ("name", "field", "bar", "words"),
    [
        (controls._NO_DYNAMICS, "error", 20e-6, "without dynamics"),
        ("not identified, 4 runs averaged", "ratio", 0.2, "without identification"),
    ],
)
def test_a_negative_control_fails_where_it_is_not_worse(measured_controls, name, field, bar, words):
    base = controls.Found(error=50e-6, ratio=0.3)
    assert measured_controls({name: base._replace(**{field: bar * (1 + CLOSE)})}) == []
    fails_by_itself(measured_controls({name: base._replace(**{field: bar * (1 - CLOSE)})}), words)
