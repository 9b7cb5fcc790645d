"""Every statement of `armside verify` fails where one seed alone leaves its bar, and only there.

What a claim measures is replaced by numbers that hold. Then one number of the last seed is moved to
just inside and just outside of each bar, which is stated here a second time.
"""

from collections import Counter
from contextlib import nullcontext
from types import SimpleNamespace

import numpy as np
import pytest

from armside.scripts.verifications import (
    ablations,
    controls,
    env,
    estimation,
    imu_large,
    irb1400,
    irb1400_laser,
    kinematics,
    laser,
    sweep,
    tuning,
)
from armside.scripts.verifications.claims import CLAIMS
from armside.sim.laser.design import THESIS
from armside.sim.robot.effects import Effect

CLOSE = 1e-3
"""Relative distance of a fed value from its bar."""


def failing(table):
    return [v.statement for v in table.verdicts if not v.holds]


def fails_by_itself(found, words):
    """One statement fails, the one with these words."""
    assert len(found) == 1, found
    assert words in found[0], found


FULL_INSTANCES = {
    "kinematics": 10, "laser": 20, "ablations": 3, "env": 1000, "tuning": 100,
    "tuning-iterations": 100, "sweep": 10, "sweep-memory": 10_000, "chapter9": 5, "imu": 20,
    "estimation": 10, "estimation-controls": 10, "imu-causes": 5, "imu-large": 10, "imu-rest": 10,
    "laser-irb1400": 20, "laser-irb1400-design": 20,
}  # fmt: skip


def test_full_instances_have_the_documented_number_of_seeds():
    found = {name: claim.n_seeds for name, claim in CLAIMS.items() if name in FULL_INSTANCES}
    assert found == FULL_INSTANCES


# Estimation

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


# Controls of estimation


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


# IMU


def imu_run(**changed):
    measures = {
        "clock_offset_error": 1e-4,
        "acceleration_rms": np.array([0.05, 0.06, 0.03]),
        "acceleration_window_max": np.array([0.2, 0.3, 0.1]),
        "angular_velocity_rms": np.array([0.01, 0.02, 0.01]),
        "tool_distance": 1e-3,
        "loop_error": 5e-7,
        "idle_peaks": np.array([np.nan, 1e-4, 5e-5]),
    }
    own = {name: value for name, value in changed.items() if name in measures}
    rest = {"fast_over_slow": 4.0, "largest_in_rectangle": np.array([True, True, False])}
    rest |= {name: value for name, value in changed.items() if name in rest}
    return SimpleNamespace(measures=SimpleNamespace(**(measures | own)), **rest)


@pytest.fixture
def imu_claim(monkeypatch):
    """Runs the claim `imu`; changes concern the last of ten seeds.

    run: of the simultaneous motion. thesis: the same, processed as in the thesis. aided, unaided:
    of the sequential motion.
    """

    def table(run=(), thesis=(), aided=(), unaided=(), n=1, every=()):
        run, thesis, aided, unaided = map(dict, (run, thesis, aided, unaided))
        last = range(10 - n, 10)
        usual = {"acceleration_window_max": np.array([0.4, 0.5, 0.2])} | dict(every)

        def run_one(experiment, planned, seed):
            at = seed in last
            if experiment is irb1400.BASE:
                result = imu_run(**(run if at else {}))
                result.again = imu_run(**(usual | (thesis if at else {})))
                return result
            if experiment is irb1400.SEQUENTIAL:
                return imu_run(**(aided if at else {}))
            return imu_run(**({"idle_peaks": np.array([3e-4])} | (unaided if at else {})))

        monkeypatch.setattr(irb1400, "prepare", lambda each: [None, None])
        monkeypatch.setattr(irb1400, "run_one", run_one)
        monkeypatch.setattr(irb1400, "reprocessed", lambda result, _: result.again)
        return failing(irb1400.imu(range(10)))

    return table


def test_the_claim_of_the_imu_holds(imu_claim):
    assert imu_claim() == []


def vector(index, value, base=(0.2, 0.3, 0.1)):
    v = np.array(base, dtype=float)
    v[index] = value
    return v


@pytest.mark.parametrize(
    ("which", "name", "inside", "outside", "words"),
    [
        ("run", "clock_offset_error", 0.999e-3, 1.001e-3, "no error above 1 ms"),
        ("run", "acceleration_window_max", vector(1, 0.799), vector(1, 0.801), "inside 0.8"),
        ("run", "acceleration_window_max", vector(2, 0.199), vector(2, 0.201), "smallest in z"),
        (
            *("run", "acceleration_rms"),
            *(vector(2, z, (0.05, 0.06, 0.03)) for z in (0.0499, 0.0501)),
            "smallest in z",
        ),
        ("run", "angular_velocity_rms", vector(1, 0.0249), vector(1, 0.0251), "0.025 rad/s"),
        ("run", "tool_distance", 0.201e-3, 0.199e-3, "0.2 to 2 mm"),
        ("run", "tool_distance", 1.999e-3, 2.001e-3, "0.2 to 2 mm"),
        ("run", "loop_error", 0.999e-6, 1.001e-6, "less than 1 um"),
        ("aided", "loop_error", 0.999e-6, 1.001e-6, "less than 1 um"),
        ("unaided", "loop_error", 0.999e-6, 1.001e-6, "less than 1 um"),
        ("run", "fast_over_slow", 3.001, 2.999, "at least three times"),
        ("aided", "idle_peaks", np.array([1.999e-4]), np.array([2.001e-4]), "with feedforward"),
        ("unaided", "idle_peaks", np.array([2.001e-4]), np.array([1.999e-4]), "without feedforw"),
        ("unaided", "idle_peaks", np.array([9.99e-4]), np.array([10.01e-4]), "without feedforw"),
    ],
)
def test_a_statement_about_the_imu_is_bounded(imu_claim, which, name, inside, outside, words):
    if name == "angular_velocity_rms":
        inside, outside = (v * [0.01, 1.0, 0.01] for v in (inside, outside))
    assert imu_claim(**{which: {name: inside}}) == []
    fails_by_itself(imu_claim(**{which: {name: outside}}), words)


@pytest.mark.parametrize(
    ("index", "inside", "outside"), [(0, 0.151, 0.149), (1, 0.799, 0.801), (2, 0.349, 0.351)]
)
def test_processing_of_the_thesis_is_bounded_by_axis(imu_claim, index, inside, outside):
    """In x the smallest value would also be below that of z, so z goes with it."""
    base = (0.4, 0.5, 0.1)
    name = "acceleration_window_max"
    assert imu_claim(thesis={name: vector(index, inside, base)}) == []
    found = imu_claim(thesis={name: vector(index, outside, base)})
    fails_by_itself(found, "processed as in the thesis it reaches")


def test_clock_errors_count_whatever_their_sign(imu_claim):
    assert imu_claim(run={"clock_offset_error": -0.999e-3}, n=10) == []
    found = imu_claim(run={"clock_offset_error": -1.001e-3}, n=10)
    fails_by_itself(found, "no error above 1 ms")


def test_clock_errors_have_a_standard_deviation(imu_claim):
    # nine errors of 0.1 ms and one of e: standard deviation 0.3 |e - 0.1|
    for error, holds in ((0.99e-3, True), (-0.95e-3, False)):
        found = imu_claim(run={"clock_offset_error": error})
        assert (found == []) is holds
    fails_by_itself(imu_claim(run={"clock_offset_error": -0.95e-3}), "standard deviation")


def test_z_must_be_smaller_than_y_always_and_smallest_in_most(imu_claim):
    name = "acceleration_window_max"
    above_x = {name: np.array([0.2, 0.5, 0.3])}
    assert imu_claim(thesis=above_x, n=4) == []
    fails_by_itself(imu_claim(thesis=above_x, n=5), "smaller in z than in y always")
    above_y = {name: np.array([0.4, 0.3, 0.31])}
    fails_by_itself(imu_claim(thesis=above_y), "smaller in z than in y always")


def test_the_largest_error_lies_in_the_rectangle(imu_claim):
    elsewhere = {"largest_in_rectangle": np.array([True, False, True])}
    words = "largest in x and y within the rectangle"
    fails_by_itself(imu_claim(run=elsewhere), words)
    assert imu_claim(thesis=elsewhere, n=1) == []
    fails_by_itself(imu_claim(thesis=elsewhere, n=2), words)


@pytest.mark.parametrize(
    ("name", "inside", "outside", "words"),
    [
        ("sensor delays left in", 0.101, 0.099, "delays of the sensors"),
        ("mapped, then filtered", 0.099, 0.101, "filtering the predicted motion"),
        ("central differences", 0.099, 0.101, "central differences"),
        ("rigid robot, both", 0.0199, 0.0201, "less than a third"),
    ],
)
def test_a_cause_of_the_error_raises_or_lowers_it(monkeypatch, name, inside, outside, words):
    base = {
        "as chosen": 0.1,
        "processed as in the thesis": 0.2,
        "sensor delays left in": 0.2,
        "central differences": 0.09,
        "mapped, then filtered": 0.09,
        "both": 0.06,
        "gravity by the mean at rest": 0.1,
        "rigid robot": 0.1,
        "rigid robot, both": 0.01,
    }

    def table(value):
        monkeypatch.setattr(
            irb1400,
            "causes",
            lambda *_: [
                (
                    cause,
                    SimpleNamespace(
                        acceleration_rms=np.array([a, 0.0, 0.0]),
                        acceleration_window_max=np.array([a, a, a]),
                        angular_velocity_rms=np.array([a, a, a]),
                    ),
                )
                for cause, a in (base | {name: value}).items()
            ],
        )
        return failing(irb1400.imu_causes(range(2)))

    assert table(inside) == []
    fails_by_itself(table(outside), words)


@pytest.mark.parametrize(
    ("name", "inside", "outside", "words"),
    [
        ("off_rms", vector(1, 0.0091, (0.01,) * 3), vector(1, 0.0089, (0.01,) * 3), "motors off"),
        ("off_rms", vector(0, 0.0139, (0.01,) * 3), vector(0, 0.0141, (0.01,) * 3), "motors off"),
        ("on_rms", vector(2, 0.0301, (0.1,) * 3), vector(2, 0.0299, (0.1,) * 3), "three times"),
        ("on_level", vector(1, 0.151, (0.3,) * 3), vector(1, 0.149, (0.3,) * 3), "99.7 %"),
        ("on_level", vector(2, 0.449, (0.3,) * 3), vector(2, 0.451, (0.3,) * 3), "99.7 %"),
        ("on_level", vector(0, 0.05, (0.3,) * 3), None, ""),
    ],
)
def test_the_noise_of_a_robot_at_rest_is_bounded(monkeypatch, name, inside, outside, words):
    def table(value):
        base = {"off_rms": np.full(3, 0.01), "on_rms": np.full(3, 0.1)}
        base["on_level"] = np.full(3, 0.3)
        monkeypatch.setattr(irb1400, "run_rest", lambda _, seed: rested(base, seed, name, value))
        return failing(irb1400.rest(range(2)))

    assert table(inside) == []
    if outside is not None:
        fails_by_itself(table(outside), words)


def rested(base, seed, name, value, line=0.5):
    changed = base | ({name: value} if seed == 1 else {})
    f = np.arange(0.0, 50.0, 0.5)
    spectrum = np.exp(-((f - 15.0) ** 2)) + line * np.exp(-((f - 27.0) ** 2))
    return SimpleNamespace(
        rest=SimpleNamespace(frequency=f, on_spectrum=np.tile(spectrum[:, None], 3), **changed)
    )


def test_the_line_near_27_hz_has_a_fifth_of_the_highest(monkeypatch):
    base = {"off_rms": np.full(3, 0.01), "on_rms": np.full(3, 0.1), "on_level": np.full(3, 0.3)}
    for line, holds in ((0.201, True), (0.199, False)):
        monkeypatch.setattr(
            irb1400,
            "run_rest",
            lambda _, seed, line=line: rested(base, seed, "on_level", base["on_level"], line),
        )
        assert (failing(irb1400.rest(range(2))) == []) is holds


@pytest.mark.parametrize(
    ("name", "bar", "processed", "words"),
    [
        ("acceleration_rms", 0.15, False, "0.15 m/s^2"),
        ("acceleration_rms", 0.15, True, "0.15 m/s^2"),
        ("angular_velocity_rms", 0.01, False, "0.01 rad/s"),
        ("angular_velocity_rms", 0.01, True, "0.01 rad/s"),
        ("clock_offset_error", -1e-3, False, "1 ms"),
    ],
)
def test_the_imu_of_the_large_robot_is_bounded(monkeypatch, name, bar, processed, words):
    """As it comes and mapped before it is filtered."""
    small = np.full(3, 0.001)
    base = {"acceleration_rms": small, "angular_velocity_rms": small}

    def table(value):
        value = value if name == "clock_offset_error" else vector(1, value, small)

        def measured(mapped, seed):
            changed = {name: value} if mapped is processed and seed == 1 else {}
            return imu_run(**(base | changed))

        def run_one(_, __, seed):
            result = measured(False, seed)
            result.again = measured(True, seed)
            return result

        monkeypatch.setattr(imu_large, "prepare", lambda _: [None])
        monkeypatch.setattr(imu_large, "run_one", run_one)
        monkeypatch.setattr(imu_large, "reprocessed", lambda result, _: result.again)
        return failing(imu_large.imu_large(range(2)))

    assert table(bar * (1 - CLOSE)) == []
    fails_by_itself(table(bar * (1 + CLOSE)), words)


# Learning


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
            return run | {"motor_two": worse, "motor_inf": worse} | own
        assert cut.robot == "irb1400"
        return run | (changed if seed == 1 and cut.pose == "p2" else {})

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
        return {"arm_rms": rms, "arm_maxdev": rms, "motor_inf": motor, "motor_two": motor}

    monkeypatch.setattr(laser, "learned", learned)
    fails_by_itself(failing(laser.laser([5, 6])), "b1:")
    assert set(asked) == {(pose, seed) for pose in ("p1", "p2", "p3") for seed in (5, 6)}
    assert failing(laser.laser([5, 7])) == []
    assert laser.SHOWN == ("a1", "a3", "a4", "b1", "b6", "b7")


def test_a_learned_cut_is_that_of_its_seed_and_design(monkeypatch):
    from armside.scripts.verifications import learned as room

    asked = []
    monkeypatch.setattr(room, "run", lambda cut, **given: asked.append(given) or {"iterations": []})
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
        def row(seed, name):
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


# Kinematics, env, tuning, sweep


@pytest.mark.parametrize(
    ("column", "bar", "words"),
    [
        (0, 1e-13, "generated poses"),
        (1, 1e-11, "every branch has its pose"),
        (2, 0.5, "one branch is always"),
        (3, 1e-8, "Jacobians are derivatives"),
    ],
)
def test_kinematics_are_bounded(monkeypatch, column, bar, words):
    drawn = []

    def run(value):
        def row(robot, rng):
            drawn.append((robot.name, rng.uniform()))
            cells = [0.0, 0.0, 0, 0.0]
            if len(drawn) % 4 == 0:  # the last seed's last robot
                cells[column] = value
            return tuple(cells)

        monkeypatch.setattr(kinematics, "_row", row)
        return failing(kinematics.kinematics(range(2)))

    assert run(0 if column == 2 else bar * (1 - CLOSE)) == []
    fails_by_itself(run(1 if column == 2 else bar * (1 + CLOSE)), words)
    assert len(set(drawn[:4])) == 4  # each seed and robot draws its own
    assert kinematics.CONFIGURATIONS == 1000


@pytest.mark.parametrize(
    ("column", "inside", "outside", "words"),
    [
        (1, 0, 1, "every observation lies"),
        (4, -5.0, -5.01, "every reward lies"),
        (5, 5.0, 5.01, "every reward lies"),
    ],
)
def test_spaces_of_the_env_are_bounded(monkeypatch, column, inside, outside, words):
    def run(value):
        def row(_, seeds):
            cells = [100, 0, 1.0, 2.0, -1.0, 1.0, 0]
            if seeds[-1] == 119:
                cells[column] = value
            return tuple(cells)

        monkeypatch.setattr(env, "_row", row)
        return failing(env.env(range(120)))

    assert run(inside) == []
    fails_by_itself(run(outside), words)


@pytest.mark.parametrize("name", ["best fixed design by search", "learned policy"])
def test_a_better_design_is_better_by_three_standard_errors(monkeypatch, name):
    rng = np.random.default_rng(0)
    thesis = np.exp(0.2 * rng.standard_normal(50))
    noise = rng.standard_normal(50)
    noise = (noise - noise.mean()) / noise.std(ddof=1) / np.sqrt(1 / 50)  # standard error: 1

    def run(gain):
        """log(thesis) - log(name) has mean `gain` and standard error 1, in parts of 1e-3."""
        ratios = {
            "thesis design": thesis,
            "best fixed design by search": 0.5 * thesis,
            "designs from identified models": thesis,
            "learned policy": 0.5 * thesis,
        }
        ratios[name] = thesis / np.exp(1e-3 * (gain + noise))
        episodes = {
            which: [SimpleNamespace(ratio=r, rms_true=[1.0, r], diverged=False) for r in all_]
            for which, all_ in ratios.items()
        }
        monkeypatch.setattr(tuning, "searched", lambda: THESIS)
        monkeypatch.setattr(tuning, "identified", lambda: THESIS)
        monkeypatch.setattr(tuning, "_episodes", lambda seeds, baselines: episodes)
        return failing(tuning.tuning(range(50)))

    assert run(3.01) == []
    fails_by_itself(run(2.99), f"the {name} leaves less")


def test_sealed_episodes_are_counted_from_the_seeds(monkeypatch):
    asked = []
    monkeypatch.setattr(
        tuning,
        "evaluate",
        lambda rules, seeds, policy, threads: asked.append((rules.sealed, seeds)) or [],
    )
    from armside.sim.tuning.rules import Rules

    tuning._episodes([3, 5], {"a": (Rules(sealed=True), None)})
    assert asked == [(True, [tuning.TEST_SEEDS[3], tuning.TEST_SEEDS[5]])]


def test_a_searched_design_is_made_for_its_budget(monkeypatch):
    def run(tenth):
        falling = np.array([1.0, 0.9, 0.8, 0.7, 0.6, 0.5, 0.5, 0.5, 0.5, 0.5, tenth])
        long = [SimpleNamespace(rms_true=falling, diverged=False) for _ in range(3)]
        policy = [SimpleNamespace(rms_true=falling[:6], diverged=False, designs=[THESIS] * 5)] * 3
        episodes = {
            "thesis design": long,
            "best fixed design by search": long,
            "learned policy": policy,
        }
        monkeypatch.setattr(tuning, "_episodes", lambda seeds, baselines: episodes)
        return failing(tuning.iterations(range(3)))

    assert run(0.501) == []
    fails_by_itself(run(0.499), "after ten iterations it leaves more")


@pytest.mark.parametrize(
    ("taken_over", "computed", "equal", "words"),
    [
        (4, 8, True, ""),
        (3, 9, True, "no result on disk is lost"),
        (4, 9, True, "the rest is computed once"),
        (4, 8, False, "equals that of an undisturbed"),
    ],
)
def test_a_killed_sweep_is_resumed_without_loss(monkeypatch, taken_over, computed, equal, words):
    n = len(sweep.parse(sweep.AXES, 0))
    assert n == 36

    class Whole:
        def __init__(self, same):
            self.same = same

        def __len__(self):
            return n

        def equals(self, _):
            return self.same

    def dataset(folder):
        last = str(folder).endswith("1")
        return SimpleNamespace(last=last, read=lambda: Whole(equal or not last))

    def run_grid(grid, data, workers):
        known, done = (taken_over, computed) if data.last else (4, 8)
        return Counter({sweep.KNOWN: known, sweep.KNOWN_FAILED: 24, "done": done})

    process = SimpleNamespace(wait=lambda *_: None)
    monkeypatch.setattr(sweep, "_begun", lambda _: process)
    monkeypatch.setattr(sweep, "_kill", lambda *_: 28)
    monkeypatch.setattr(sweep, "dataset", dataset)
    monkeypatch.setattr(sweep, "run_grid", run_grid)
    monkeypatch.setattr(sweep, "Workers", lambda: nullcontext(None))
    found = failing(sweep.sweep(range(2)))
    if not words:
        assert found == []
    else:
        fails_by_itself(found, words)


@pytest.mark.parametrize(("growth", "holds"), [(1.099, True), (1.101, False)])
def test_memory_of_a_sweep_stays_within_a_tenth(monkeypatch, growth, holds):
    resident = iter([100.0, *[100.0] * 8, 100.0 * growth])
    monkeypatch.setattr(sweep, "_descendants", lambda _: [])
    monkeypatch.setattr(sweep, "_resident", lambda _: next(resident))
    monkeypatch.setattr(sweep, "Workers", lambda: nullcontext(None))

    def run_grid(grid, data, workers, step):
        for _ in range(20):
            step()
        return {"done": 20}

    monkeypatch.setattr(sweep, "run_grid", run_grid)
    assert (failing(sweep.memory(range(20))) == []) is holds
