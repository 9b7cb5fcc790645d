"""Every band of chapter 9 has its ends where the thesis and the study say, and judges by them.

The ends are stated here a second time. Each is fed with a value just inside and just outside.
"""

from dataclasses import replace
from itertools import product
from types import SimpleNamespace

import numpy as np
import pytest
from tests.calibration.search import MARGIN, MARGINS, outside
from tests.claims import chapter9

from armside.scripts.thesis.chapter9 import bands
from armside.scripts.thesis.entries import select
from armside.scripts.thesis.report import Asked

from .verdicts import assert_band

POSES = ("p1", "p2", "p3")
CHAPTER_9 = {  # k = 5, 40 mm/s unless the statement says otherwise
    "a1": (None, 0.10), "a2": (None, 0.02), "a3": (18, None), "a4": (None, 0.30),
    "a5": (None, 0.2), "a6": (None, 2.0),
    "b1": (0.20, 0.50), "b2": (None, 0.60), "b3": (1.0, None), "b4": (1.03, None),
    "b5": (1.0, 1.6), "b6": (0.0, None), "b7": (0.0, None),
    "c1": (1.05, None), "c2": (1.10, None), "c3": (1.2, None), "c4": (None, 0), "c5": (2, None),
    "c6": (None, 1.0), "c7": (None, 1.0),
    "d1": (None, 0.97), "d2": (None, 0.95), "d3": (None, 2.0),
    "e1": (0.9, None), "e2": (0.97, 1.03), "e3": (5.0, 7.0), "e4": (0.2, 0.65),
    "e5": (8, 8), "e6": (3, 3), "e7": (6, 6),
    "f1": (1.0, None), "f2": (0.5, None), "f3": (0.45, None), "f4": (None, 1.0), "f5": (1.0, None),
    "f6": (None, 0.03),
    "g1": (0.10, 0.35),
}  # fmt: skip


# Chapter 9


def test_every_band_of_chapter_9_is_stated_here():
    assert set(bands.BANDS) == set(CHAPTER_9)


@pytest.mark.parametrize("id", CHAPTER_9)
def test_a_number_of_chapter_9_is_judged_by_its_band(id):
    (check,) = bands.compare(**{id: 1.0})
    assert check.id == id
    assert_band(check, *CHAPTER_9[id])


@pytest.fixture(scope="module")
def results():
    """Random results by pose, so that no two numbers agree by chance."""
    rng = np.random.default_rng(0)

    def one():
        return {
            "motor_inf": rng.uniform(0.1, 1.0, (7, 6)),
            "motor_two": rng.uniform(0.1, 1.0, (7, 6)),
            "arm_rms": rng.uniform(0.1, 1.0, 7),
            "arm_maxdev": rng.uniform(0.1, 1.0, 7),
            "ripple": rng.uniform(0.1, 1.0, 7),
            "error": rng.uniform(-1.0, 1.0, (7, 50, 6)),
            "gear": np.array([220, 242.73, 242.73, 145, 180, 100]),
        }

    return [{pose: one() for pose in POSES} for _ in range(2)]


def ours(checks):
    return {check.id: check.ours for check in checks}


def test_numbers_of_the_motor_side_are_those_of_their_statements(results):
    base, other = results
    first = np.array([base[pose]["motor_inf"][0] for pose in POSES])
    last = np.array([base[pose]["motor_inf"][5] for pose in POSES])
    two = [base[pose]["motor_two"] for pose in POSES]
    moved = max(np.abs(each[6] - each[5]).max() / each[5].max() for each in two)
    slow, fast = base["p1"], other["p1"]
    ratio, of_two = (fast[name][5] / slow[name][5] for name in ("motor_inf", "motor_two"))
    cutoff = [*bands.cutoff_worse(slow, fast), *bands.cutoff_motor(slow, fast)]
    found = ours([*bands.motor_side(base), *bands.stability(base), *cutoff])
    assert found == pytest.approx(
        {
            "a1": last.max() / first.max(),
            "a2": last.min() / first.max(),
            "a3": np.sum(last < first),
            "a4": (last / first).max(),
            "a5": moved,
            "c4": np.sum(ratio > 1.0),
            "c5": np.sum(ratio < 0.7),
            "c7": np.median(of_two),
        }
    )


@pytest.mark.parametrize(("factor", "counted"), [(0.999, 18), (1.001, 17)])
def test_a_motor_counts_as_learned_below_its_own_first_error(factor, counted):
    base = {pose: {"motor_inf": np.full((6, 6), 0.5)} for pose in POSES}
    for result in base.values():
        result["motor_inf"][5] = 0.04
    base["p2"]["motor_inf"][5, 3] = factor * 0.5
    assert ours(bands.motor_side(base))["a3"] == counted


@pytest.mark.parametrize(("factor", "counted"), [(0.699, 1), (0.701, 0)])
def test_a_motor_counts_as_better_below_seven_tenths(factor, counted):
    slow = dict.fromkeys(("motor_inf", "motor_two"), np.ones((6, 6)))
    fast = slow | {"motor_inf": np.where(np.arange(6) == 2, factor, np.ones((6, 6)))}
    assert ours(bands.cutoff_motor(slow, fast))["c5"] == counted


def test_motors_that_are_worse_at_15_hz_are_counted_and_named():
    slow = dict.fromkeys(("motor_inf", "motor_two"), np.ones((6, 6)))
    fast = slow | {"motor_inf": np.tile([1.3, 1.1, 1.01, 0.6, 1.3, 0.6], (6, 1))}
    (check,) = bands.cutoff_worse(slow, fast)
    assert (check.ours, check.verdict) == (4.0, "FAILS")
    assert "motors 1, 2, 3, 5 are worse" in check.reason


def test_numbers_of_the_arm_side_are_those_of_their_statements(results):
    base, other = results
    rms = {pose: base[pose]["arm_rms"] for pose in POSES}
    p1, p2, p3 = (rms[pose][5] / rms[pose][0] for pose in POSES)
    slow, fast = base["p1"], other["p1"]
    shifted = bands.shift_arm(base, other)
    found = ours([*bands.arm_side(base), *bands.cutoff_arm(slow, fast), *shifted])
    assert found == pytest.approx(
        {
            "b1": p1,
            "b2": base["p1"]["arm_maxdev"][5] / base["p1"]["arm_maxdev"][0],
            "b3": rms["p2"][5] / rms["p2"][1],
            "b4": rms["p2"][1:6].max() / rms["p2"][1],
            "b5": p3,
            "b6": p2 - p1,
            "b7": p3 - p2,
            "c1": fast["arm_rms"][5] / slow["arm_rms"][5],
            "c2": fast["arm_maxdev"][5] / slow["arm_maxdev"][5],
            "c3": fast["ripple"][5] / slow["ripple"][5],
            "d1": other["p1"]["arm_rms"][5] / base["p1"]["arm_rms"][5],
            "d2": other["p2"]["arm_rms"][5] / base["p2"]["arm_rms"][5],
        }
    )


def test_shifts_are_compared_motor_by_motor(results):
    base, other = (each["p1"] for each in results)
    ratio = base["motor_inf"][5] / other["motor_inf"][5]
    (check,) = bands.shift_motor({1: base, 2: other})
    assert check.ours == pytest.approx(np.maximum(ratio, 1.0 / ratio).max())
    assert "motors 3 and 5" in check.reason


def test_numbers_without_learning_compare_one_speed_with_another(results):
    slow, fast = results
    first = {p: (slow[p]["motor_inf"][0], fast[p]["motor_inf"][0]) for p in POSES}
    errors = np.array([first[pose][0] for pose in POSES])
    ratio = np.array([b / a for a, b in first.values()])
    grown = [*bands.growth(slow, fast), *bands.saturation(slow, fast)]
    found = ours([*bands.nominal_by_position(slow), *grown])
    assert found == pytest.approx(
        {
            "f1": errors[2, 2] / errors.max(),
            "f2": errors[0, 3] / errors.max(),
            "f3": errors[2, 3] / errors.max(),
            "f4": errors[1, 3] / min(errors[0, 3], errors[2, 3]),
            "f5": ratio.min(),
            "f6": np.abs(ratio - 1.0).max(),
        }
    )


def test_repeatability_is_the_difference_of_two_experiments_over_their_best_error(results):
    one, two = results[0]["p1"], results[1]["p1"]
    best = min(one["motor_inf"].min(), two["motor_inf"].min())
    apart = np.abs(one["error"] - two["error"]).max(axis=1) * one["gear"]
    (check,) = bands.repeatability(one, two)
    assert check.ours == pytest.approx(np.median(apart.max(axis=1) / best))


def test_the_prediction_of_the_first_update_is_that_of_the_model_not_the_outcome():
    """e1 = f e0 - G u: a model of twice the gain is off by what follows from it."""
    rng, model = np.random.default_rng(1), bands.THESIS_MODEL
    e0 = rng.standard_normal((80, 6)) * np.hanning(80)[:, None]

    def law(u, e):
        return u + 0.5 * e

    e1 = e0 - model.simulate(law(np.zeros_like(e0), e0))
    for factor in (1.0, 3.0):
        base = {"p1": {"error": np.array([e0, factor * e1])}}
        (check,) = bands.predicted_rates(model, base, law, (3, 5))  # pyright: ignore[reportArgumentType]
        assert check.ours == pytest.approx(factor)
        base["p1"]["error"][1] /= factor**2
        (check,) = bands.predicted_rates(model, base, law, (3, 5))  # pyright: ignore[reportArgumentType]
        assert check.ours == pytest.approx(factor)


def test_the_claim_of_chapter_9_compares_the_experiments_of_its_statements(monkeypatch):
    """Each result is marked with its own experiment; what a check receives is what it states."""
    seen = {}
    marked = {
        "operating point": {p: ("40 mm/s", p) for p in POSES},
        "position": {p: ("50 mm/s", p) for p in POSES},
        "identification": {(p, v): ("learned", p, v) for p, v in product(POSES, bands.SPEEDS)},
        "shift, arm": {(p, d): ("shift", p, d) for p, d in product(POSES, (3, 6))},
        "cutoff": {("p1", c): ("cutoff", c) for c in (10.0, 15.0)},
        "velocity": {(v, p): ("speed", v, p) for v, p in product((10.0, 80.0, 100.0), POSES)},
        "repeatability": {("p1", r): ("repetition", r) for r in (0, 1)},
    }
    names = (
        *("motor_side", "predicted_rates", "arm_side", "cutoff_arm", "cutoff_motor"),
        *("shift_arm", "fitted_model", "criterion_of", "nominal_by_position", "growth"),
        *("saturation", "repeatability"),
    )
    for name in names:
        monkeypatch.setattr(bands, name, lambda *given, name=name: seen.update({name: given}) or [])
    monkeypatch.setattr(bands, "identify", lambda data: SimpleNamespace(system=data))
    assert chapter9.bands_of(marked) == []
    at = {v: {p: ("speed", v, p) for p in POSES} for v in (10.0, 80.0, 100.0)}
    assert seen["motor_side"] == seen["arm_side"] == (marked["operating point"],)
    assert seen["growth"] == (at[10.0], at[80.0])
    assert seen["saturation"] == (at[80.0], at[100.0])
    assert seen["cutoff_arm"] == seen["cutoff_motor"] == (("cutoff", 10.0), ("cutoff", 15.0))
    delta = {d: {p: ("shift", p, d) for p in ("p1", "p2")} for d in (3, 6)}
    assert seen["shift_arm"] == (delta[3], delta[6])
    assert seen["repeatability"] == (("repetition", 0), ("repetition", 1))
    assert seen["nominal_by_position"] == (marked["position"],)
    model, at_40, _, motors = seen["predicted_rates"]
    assert model == {v: ("learned", "p1", v) for v in bands.SPEEDS}
    assert at_40 == {p: ("learned", p, 40.0) for p in ("p1", "p2")}
    assert motors == (3, 5)


def test_sections_of_a_report_name_jobs_of_the_seed_that_is_given():
    """The numbers on a page belong to the seed of its command."""
    for entry in select(["5", "8", "9", "F07", "9-map", "9-effects"]):
        jobs = entry.make(Asked(31)).jobs
        assert {getattr(job, "seed", 31) for job in jobs} <= {31}, entry.id
        assert all(job.cost > 0.0 for job in jobs), entry.id
        others = entry.make(Asked(32)).jobs
        assert not set(jobs) & set(others), entry.id


@pytest.mark.parametrize("id", CHAPTER_9)
def test_calibration_aims_inside_the_bands_that_are_judged(id):
    """A target counts as missed within its margin of an end: 5 %, or what the list says."""
    (check,) = bands.compare(**{id: 1.0})
    margin = MARGINS.get(id, MARGIN)
    for end, sign in ((check.low, 1.0), (check.high, -1.0)):
        if end is None or end == 0.0:
            continue
        at_end = outside(replace(check, ours=end))
        largest = max(0.05, *(abs(e) for e in (check.low, check.high) if e is not None))
        assert at_end == pytest.approx(margin * abs(end) / largest)
        beyond = outside(replace(check, ours=end - sign * 0.5 * abs(end)))
        assert beyond == pytest.approx((0.5 + margin) * abs(end) / largest)
    assert (MARGIN, MARGINS) == (0.05, {"a3": 0.0, "c5": 0.0, "e2": 0.0, "f1": 0.0})
