"""A claim fails where one row alone leaves its bar, and only there.

What a claim measures is replaced by rows that hold. Then one number of the last of them is moved to
just inside and just outside of each bar, which is stated here a second time.
"""

from typing import Any, NamedTuple

import numpy as np
import pytest

from armside.sim.cell import IRB1400_CELL
from armside.sim.laser.design import default_design
from armside.sim.notes import Cause, Tally

from .. import evidence
from ..scripts.verdicts import CLOSE, fails_by_itself
from . import aliens, estimation, estimation_controls, kinematics, laser_irb1400, robots
from ._engine import Rows
from ._learned import POSES
from .imu import axes, by_axis
from .long_way import TASKS

FULL_INSTANCES = {
    "kinematics": 10, "laser": 20, "ablations": 3, "env": 1000, "tuning": 100, "tuning-tasks": 100,
    "tuning-growth": 5,
    "tuning-iterations": 100, "sweep": 10, "sweep-memory": 10_000, "chapter9": 5, "imu": 20,
    "estimation": 10, "estimation-controls": 10, "estimation-gears": 10, "imu-causes": 5,
    "imu-large": 10, "imu-rest": 10, "laser-irb1400": 20, "laser-irb1400-design": 20,
    "laser-irb1400-poses": 20, "estimation-irb1400": 10, "estimation-arms": 2, "long-way": 10,
    "fast-motion": 10, "first-cut": 6, "first-cut-imu": 6, "forecast": 30, "forecast-twin": 3,
    "imu-twin": 2, "aliens": 3, "aliens-known": 2, "robots": 5, "robots-design": 3,
    "knob-free": 100, "basis-functions": 2, "urdf": 5, "programs": 10, "contest": 10,
    "contest-robot": 12, "scan-image": 20, "scan-twin": 10, "scan-twin-development": 6,
    "scan-learning": 10,
}  # fmt: skip


def test_full_instances_have_the_documented_number_of_seeds():
    found = {name: evidence.claim(name).seeds for name in evidence.names("claims")}
    assert found == FULL_INSTANCES


def failed(name: str, rows) -> list[str]:
    return [check.statement for check in evidence.claim(name).checks(Rows(rows)) if not check.holds]


def vector(name: str, values=(0.2, 0.3, 0.1), unit=" [m/s^2]") -> dict[str, float]:
    return by_axis(name, np.broadcast_to(values, 3), unit)


ESTIMATED = dict.fromkeys(estimation.LENGTHS, 100.0) | {
    **dict.fromkeys(("default_start", "hard_start", "fast_start", "faster_start"), 2000.0),
    **dict.fromkeys(("motor_5", "default_motor_5", "fast_motor", "faster_motor"), 500.0),
    **{"forward_kinematics": 1000.0, "start": 2000.0, "diverged": False},
}
ON_AN_ARM = {"start": 1000.0, "motor": 300.0, "learned": 100.0, "diverged": False}
LEARNED = {f"worst {norm} {pose}": 0.09 for norm in ("2-norm", "inf-norm") for pose in POSES}
ARM = {f"arm {pose}, k = {k} [um]": um for pose in POSES for k, um in ((0, 1.0), (5, 0.4))}
OURS = default_design(IRB1400_CELL)
DESIGNED = {"gamma": OURS.gamma[0], "delta": OURS.delta[0], "cutoff [Hz]": OURS.cutoff[0]}
ALONG = {"k = 0": 100.0, "estimate k = 5": 10.0, "tracker k = 5": 5.0, "NEES": 3.0}
IMU = {
    **{"clock error [ms]": 0.1, "rectangle / slow circle": 4.0, "tool to D-H [mm]": 1.0},
    **{"omega RMS [rad/s]": 0.02, "loop [um]": 0.5},
    **{"x, y largest in rectangle": 1.0, "as thesis: x, y largest in rectangle": 1.0},
    **{"idle arm [1e-4 rad]": 1.0, "idle wrist [1e-4 rad]": 0.5},
    **{"idle arm, no feedforward [1e-4 rad]": 3.0, "idle wrist, no feedforward [1e-4 rad]": 2.5},
    **vector("a RMS", (0.05, 0.06, 0.03)),
    **vector("a window"),
    **vector("as thesis: a window", (0.4, 0.5, 0.2)),
}
SMALL = {
    **{"clock error [ms]": 0.1, "omega RMS [rad/s]": 0.001},
    **{"mapped, then filtered: omega RMS": 0.001},
    **vector("a RMS", 0.001),
    **vector("mapped, then filtered: a RMS", 0.001, ""),
}
FREQUENCY = np.arange(0.0, 50.0, 0.5)


def spectrum(line: float) -> np.ndarray:
    return np.exp(-((FREQUENCY - 15.0) ** 2)) + line * np.exp(-((FREQUENCY - 27.0) ** 2))


AT_REST = {
    **vector("off RMS", 0.01),
    **vector("on RMS", 0.1),
    **vector("on 99.7 %", 0.3),
    **{"_frequency": FREQUENCY, "_spectrum": spectrum(0.5)},
}
RESUMED = {"on_disk": 28, "known": 28, "computed": 8, "equal": True, "_whole": 36}
KNOB_FREE = {
    **{"runs to 10 %, motors together": 4.0, "worst motor (9.5)": 4.0},
    **{"largest of any run": 0.9, "_worst": 0.9},
}
CORRECTED = {
    **{f"_left_{n}": np.full(30, 0.05) for n in (10, 4, 2)},
    **{f"_inside_{n}": np.arange(30) < 27 for n in (10, 4, 2)},
    **{"_drift": np.full(30, 0.05), "_feedback": np.full(30, 0.05)},
    **{"_flagged": np.arange(30) < 15, "_beyond": np.where(np.arange(30) < 15, 0.5, 0.1)},
}
BY_IMU = {"_left": np.full(30, 0.05), "_inside": np.arange(30) < 27}
FORESEEN = {
    **{"measure": "motor", "refused": False, "corrected": True, "task": "slot", "_number": 0},
    **{"_worse": [0.0, 0.0], "_said": [0.0, 0.0], "_inside": [True, True]},
}
MISSED = FORESEEN | {"_inside": [False, False]}
_FAST = {"measure": "estimate", "task": "slot, fast", "_said": [0.1, 0.0]}
BY_ESTIMATE = [
    *[FORESEEN | _FAST | {"refused": True}] * 2,
    *[MISSED | _FAST] * 2,
    *[FORESEEN | _FAST] * 6,
    *[FORESEEN | _FAST | {"_number": 1, "_said": [0.0, 0.0]}] * 10,
]
"""Fast tasks: two estimates are refused, and of the others two miss."""
OUTSIDE = {
    **{"_left": np.full(6, 0.05), "_refused": np.zeros(6, bool), "_inside": np.ones(6, bool)},
    **{"_unlearned": np.zeros(3, bool)},
    **{"_learned": np.full(3, 0.05), "_noted": np.zeros(3, bool), "_foreseen": np.ones(3, bool)},
    **{"effect": "hysteresis"},
}

SCANNED = {
    **{"_across, calibrated": np.full(5, 2.0), "_across, not": np.full(5, 4.0)},
    **{"size, calibrated": 5.0, "place, calibrated": 5.0, "noise, calibrated": 1.0},
}

BASES: dict[str, list[dict[str, Any]]] = {
    "estimation": [ESTIMATED] * 2,
    "estimation-irb1400": [ON_AN_ARM | {"robot": "irb1400"}] * 6,
    "estimation-arms": [ON_AN_ARM | {"robot": name} for name in ("scara", "two_link")],
    "kinematics": [dict.fromkeys(("pose", "inverse", "missing", "derivative"), 0.0)] * 4,
    "laser-irb1400": [LEARNED | ARM | dict.fromkeys(laser_irb1400.BY_THESIS, 0.095)] * 2,
    "laser-irb1400-design": [DESIGNED] * 3,
    "laser-irb1400-poses": [{"heuristic": 0.2, "worst": 0.05, "alone": 0.01}] * 3,
    "robots": [
        {"robot": "SCARA"} | dict.fromkeys((*robots.MOTOR.values(), *robots.TRACKER.values()), 0.1)
    ] * 2,
    "env": [
        {"outside of the space": 0, "smallest reward": -1.0, "largest reward": 1.0}
    ] * 3,
    "imu": [IMU] * 10,
    "imu-large": [SMALL] * 2,
    "imu-rest": [AT_REST] * 2,
    "fast-motion": [ALONG | {"before k = 5": 20.0, "_refused": ""}] * 3,
    "long-way": [ALONG | {"contour": task, "_silent": False} for _ in range(3) for task in TASKS],
    "sweep": [RESUMED] * 2,
    "sweep-memory": [
        {"the sweep [MiB]": 100.0, "its largest worker [MiB]": 50.0, "_done": 20, "_asked": 20}
    ] * 10,
    "knob-free": [KNOB_FREE] * 3,
    "first-cut": [CORRECTED],
    "first-cut-imu": [BY_IMU],
    "forecast": [MISSED] * 2 + [FORESEEN] * 18 + BY_ESTIMATE,
    "forecast-twin": [MISSED | {"inside": False}] * 2 + [FORESEEN | {"inside": True}] * 18,
    "aliens": [OUTSIDE | {"effect": "none"}, OUTSIDE],
    "aliens-known": [OUTSIDE],
    "scan-image": [SCANNED] * 2,
}  # fmt: skip


class Bar(NamedTuple):
    """Changes of the last rows that a claim just stands, and just does not."""

    claim: str
    inside: dict[str, Any]
    outside: dict[str, Any]
    words: str
    rows: int = 1


def bar(name: str, key: str, inside: Any, outside: Any, words: str, rows: int = 1) -> Bar:
    return Bar(name, {key: inside}, {key: outside}, words, rows)


def upper(name: str, key: str, value: float, words: str) -> Bar:
    return bar(name, key, value * (1 - CLOSE), value * (1 + CLOSE), words)


FAR = dict.fromkeys(("motor_5", "default_motor_5", "fast_motor", "faster_motor"), 1e4)
RATIOS = [
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
BEATEN = ["motor_5", "default_motor_5", "fast_motor", "faster_motor"]
LEFT_10 = np.full(30, 0.05)


def left(median: float, worst: float = 0.1) -> np.ndarray:
    return np.append(np.full(29, median), worst)


def inside(n: int) -> np.ndarray:
    return np.arange(30) < n


BARS = [
    *(
        Bar(
            "estimation",
            *({one: ratio * ESTIMATED[other] * f, **FAR} for f in (1 - CLOSE, 1 + CLOSE)),
            words,
        )
        for one, other, ratio, words in RATIOS
    ),
    *(
        bar("estimation", motor, 100.0 * (1 + CLOSE), 100.0 * (1 - CLOSE), "below motor side")
        for motor in BEATEN
    ),
    Bar("estimation", {"hard_10": 29.9, "hard_start": 100.0},
        {"hard_10": 30.1, "hard_start": 100.0}, "hard case"),
    bar("estimation", "diverged", False, True, "no case diverges"),
    bar("estimation-irb1400", "learned", 199.9, 200.1, "at most 0.2 of k = 0 (worst 0.200"),
    bar("estimation-irb1400", "motor", 101.0, 99.0, "irb1400: estimate below motor side"),
    bar("estimation-irb1400", "diverged", False, True, "no case diverges"),
    bar("estimation-arms", "motor", 101.0, 99.0, "two_link: estimate below motor side"),
    bar("estimation-arms", "diverged", False, True, "no case diverges"),
    upper("kinematics", "pose", 1e-13, "generated poses"),
    upper("kinematics", "inverse", 1e-11, "every branch has its pose"),
    bar("kinematics", "missing", 0, 1, "one branch is always"),
    upper("kinematics", "derivative", 1e-8, "Jacobians are derivatives"),
    bar("laser-irb1400", "worst 2-norm p2", 0.0999, 0.1001, "2-norm ends at 0.1"),
    bar("laser-irb1400", "worst inf-norm p2", 0.0999, 0.1001, "inf-norm ends at 0.1"),
    bar("laser-irb1400", "arm p2, k = 5 [um]", 0.4999, 0.5001, "half or less"),
    *(
        bar("laser-irb1400", key, 0.0901, 0.0899, "with the design of the thesis")
        for key in laser_irb1400.BY_THESIS
    ),
    bar("laser-irb1400-design", "gamma", OURS.gamma[0] - 0.0499, OURS.gamma[0] - 0.0501, "every"),
    bar("laser-irb1400-design", "delta", OURS.delta[0], OURS.delta[0] + 1, "the median shift", 2),
    bar("laser-irb1400-design", "cutoff [Hz]", OURS.cutoff[0], 1.0, "highest cutoff", 2),
    Bar("laser-irb1400-poses", {"worst": 0.1}, {"worst": 0.101, "alone": 0.06},
        "1 of 3 do not, median 0.050, worst 0.101"),
    *(
        bar("robots", key, 0.1, 0.101, words)
        for key, words in ((robots.MOTOR["p2"], "every motor"), (robots.TRACKER["p2"], "the tool"))
    ),
    bar("env", "outside of the space", 0, 1, "every observation lies"),
    bar("env", "smallest reward", -5.0, -5.01, "every reward lies"),
    bar("env", "largest reward", 5.0, 5.01, "every reward lies"),
    bar("imu", "clock error [ms]", 0.999, 1.001, "no error above 1 ms", 10),
    bar("imu", "clock error [ms]", -0.999, -1.001, "no error above 1 ms", 10),
    # nine errors of 0.1 ms and one of e: standard deviation 0.3 |e - 0.1|
    bar("imu", "clock error [ms]", 0.99, -0.95, "standard deviation"),
    bar("imu", "a window y [m/s^2]", 0.799, 0.801, "inside 0.8"),
    bar("imu", "a window z [m/s^2]", 0.199, 0.201, "smallest in z"),
    bar("imu", "a RMS z [m/s^2]", 0.0499, 0.0501, "smallest in z"),
    bar("imu", "omega RMS [rad/s]", 0.0249, 0.0251, "0.025 rad/s"),
    bar("imu", "tool to D-H [mm]", 0.201, 0.199, "0.2 to 2 mm"),
    bar("imu", "tool to D-H [mm]", 1.999, 2.001, "0.2 to 2 mm"),
    bar("imu", "loop [um]", 0.999, 1.001, "less than 1 um"),
    bar("imu", "rectangle / slow circle", 3.001, 2.999, "at least three times"),
    bar("imu", "idle arm [1e-4 rad]", 1.999, 2.001, "with feedforward"),
    *(
        Bar(
            "imu",
            *({f"idle {m}, no feedforward [1e-4 rad]": v for m in ("arm", "wrist")} for v in ends),
            "without feedforw",
        )
        for ends in ((2.001, 1.999), (9.99, 10.01))
    ),
    # In x the smallest value would also be below that of z, so z goes with it.
    *(
        Bar("imu", *(vector("as thesis: a window", v) for v in ends), "processed as in the thesis")
        for ends in (
            ((0.151, 0.5, 0.1), (0.149, 0.5, 0.1)),
            ((0.4, 0.799, 0.1), (0.4, 0.801, 0.1)),
            ((0.4, 0.5, 0.349), (0.4, 0.5, 0.351)),
        )
    ),
    Bar("imu", {}, vector("as thesis: a window", (0.4, 0.3, 0.31)), "smaller in z than in y"),
    bar("imu", "x, y largest in rectangle", 1.0, 0.0, "largest in x and y within"),
    upper("imu-large", "a RMS y [m/s^2]", 0.15, "0.15 m/s^2"),
    upper("imu-large", "mapped, then filtered: a RMS y", 0.15, "0.15 m/s^2"),
    upper("imu-large", "omega RMS [rad/s]", 0.01, "0.01 rad/s"),
    upper("imu-large", "mapped, then filtered: omega RMS", 0.01, "0.01 rad/s"),
    upper("imu-large", "clock error [ms]", -1.0, "1 ms"),
    bar("imu-rest", "off RMS y [m/s^2]", 0.0091, 0.0089, "motors off"),
    bar("imu-rest", "off RMS x [m/s^2]", 0.0139, 0.0141, "motors off"),
    bar("imu-rest", "on RMS z [m/s^2]", 0.0301, 0.0299, "three times"),
    bar("imu-rest", "on 99.7 % y [m/s^2]", 0.151, 0.149, "99.7 %"),
    bar("imu-rest", "on 99.7 % z [m/s^2]", 0.449, 0.451, "99.7 %"),
    bar("imu-rest", "_spectrum", spectrum(0.201), spectrum(0.199), "the averaged spectrum", 2),
    bar("long-way", "estimate k = 5", 24.9, 26.0, "estimate after five updates over k = 0"),
    bar("long-way", "estimate k = 5", 14.9, 16.0, "the same: median", 15),
    bar("long-way", "tracker k = 5", 9.9, 11.0, "tracker after five updates over k = 0"),
    bar("long-way", "NEES", 23.9, 24.1, "NEES of the tool, mean of the worst contour"),
    bar("fast-motion", "estimate k = 5", 49.0, 51.0, "path error after five updates over k = 0"),
    bar("fast-motion", "estimate k = 5", 19.0, 21.0, "the same: median", 2),
    bar("fast-motion", "_refused", "", "unexplained", "none is refused that the tracker learns"),
    bar("long-way", "_silent", False, True, "never done while the truth has grown (1 of 15 are)"),
    Bar("sweep", {}, {"on_disk": 27, "known": 28}, "no result on disk is lost"),
    bar("sweep", "computed", 8, 9, "the rest is computed once"),
    bar("sweep", "equal", True, False, "equals that of an undisturbed"),
    bar("sweep", "_whole", 36, 35, "holds all 36 configurations"),
    bar("sweep-memory", "the sweep [MiB]", 109.9, 110.1, "memory after all"),
    bar("sweep-memory", "its largest worker [MiB]", 54.9, 55.1, "memory after all"),
    bar("sweep-memory", "_done", 20, 19, "all 20 configurations"),
    bar("knob-free", "runs to 10 %, motors together", 5.0, 6.0, "motors together: runs to 10% of k"
        " = 0, median", 3),
    bar("knob-free", "worst motor (9.5)", 10.0, np.inf, "worst motor, (9.5): runs to 10%"),
    bar("knob-free", "largest of any run", 1.0, 1.001, "motors together: no run worse"),
    bar("knob-free", "_worst", 1.0, 1.001, "worst motor, (9.5): no run worse"),
    bar("first-cut", "_left_10", left(0.059), left(0.061), "ten cuts: median left"),
    bar("first-cut", "_left_10", left(0.05, 0.149), left(0.05, 0.151), "ten cuts: worst left"),
    bar("first-cut", "_left_4", left(0.079), left(0.081), "four cuts: median left"),
    bar("first-cut", "_left_2", left(0.05, 1.0), left(0.05, 1.1), "no first cut is worse"),
    bar("first-cut", "_drift", left(0.099), left(0.101), "friction +10 %"),
    bar("first-cut", "_feedback", left(0.059), left(0.061), "with feedback"),
    *(
        bar("first-cut", f"_inside_{n}", inside(good), inside(bad), f"{n} cuts: errors inside")
        for n in (10, 4, 2)
        for good, bad in ((26, 25), (28, 29))
    ),
    bar("first-cut", "_flagged", inside(14), inside(13), "flagged of tasks that end above 0.3"),
    bar("first-cut", "_flagged", inside(16), inside(17), "flagged of tasks that end below 0.15"),
    bar("first-cut-imu", "_left", left(0.099, 0.249), left(0.101, 0.249), "median left"),
    bar("first-cut-imu", "_left", left(0.05, 0.249), left(0.05, 0.251), "worst left"),
    *(
        bar("first-cut-imu", "_inside", inside(good), inside(bad), "inside the interval")
        for good, bad in ((26, 25), (28, 29))
    ),
    *(
        bar("forecast", "_inside", [True, True], out, f"estimate, fast, k = {k}: inside", 2)
        for k, out in ((5, [False, True]), (20, [True, False]))
    ),
    Bar("forecast", {"_worse": [1.0, 0.0], "_said": [0.901, 0.0]},
        {"_worse": [1.0, 0.0], "_said": [0.899, 0.0]}, "k = 5: share that ends worse", 10),
    bar("forecast", "refused", False, True, "estimate, fast: refused"),
    bar("forecast-twin", "inside", True, False, "inside the interval of 90 %", 2),
    bar("aliens", "_left", np.full(6, 0.0999), np.full(6, 0.1001), "median left by the twin"),
    bar("aliens", "_learned", np.full(3, 0.1199), np.full(3, 0.1201), "left by the estimate"),
    bar("aliens", "_left", *(np.append(np.full(5, 0.05), w) for w in (1.0, 1.01)), "nothing ends"),
    bar("aliens-known", "_left", np.full(6, 0.0999), np.full(6, 0.1001), "median left"),
    bar("aliens-known", "_left", *(np.append(np.full(5, 0.05), w) for w in (1.0, 1.01)), "nothing"),
    Bar("aliens-known", *({"_left": LEFT_10, "_inside": inside(n), "_refused": ~inside(20)}
        for n in (14, 13)), "in the twin's interval, of 20 of 30"),
    # of thirty the last ten are refused, and do not count as inside
    *(
        Bar("aliens", *({**ends, key: inside(n), refused: ~inside(20)} for n in (14, 13)), words)
        for ends, key, refused, words in (
            ({"_left": LEFT_10}, "_inside", "_refused", "in the twin's interval, of 20 of 30"),
            ({}, "_foreseen", "_unlearned", "in the forecast interval, of 20 of 30"),
        )
    ),
    # Of ten contours four or five are above, of which five are the last row's.
    bar("scan-image", "_across, calibrated", np.full(5, 3.99), np.full(5, 4.01), "10 Hz, all"),
    bar("scan-image", "_across, calibrated", [2.0] * 4 + [5.99], [2.0] * 4 + [6.01], "same, worst"),
    bar("scan-image", "_across, not", np.full(5, 2.01), np.full(5, 1.99), "over uncalibrated", 2),
    upper("scan-image", "size, calibrated", 10.0, "a diameter"),
    upper("scan-image", "place, calibrated", 10.0, "place of a contour"),
    upper("scan-image", "noise, calibrated", 2.0, "stated over"),
    bar("scan-image", "noise, calibrated", 0.501, 0.499, "stated over"),
]  # fmt: skip


def changed(one: Bar, change: dict[str, Any]) -> list[dict[str, Any]]:
    base = BASES[one.claim]
    first = len(base) - one.rows
    return [row | (change if i >= first else {}) for i, row in enumerate(base)]


@pytest.fixture(autouse=True)
def without_files(monkeypatch):
    """Robot files are judged by `test_one_robot_at_one_pose_keeps_every_statement`."""
    monkeypatch.setattr(robots, "described", lambda name: iter(()))


@pytest.mark.parametrize("name", BASES)
def test_a_claim_holds_for_rows_that_hold(name):
    assert failed(name, BASES[name]) == []


@pytest.mark.parametrize("one", BARS, ids=lambda b: f"{b.claim}: {b.words}")
def test_a_row_beyond_its_bar_fails_that_statement_alone(one):
    assert failed(one.claim, changed(one, one.inside)) == []
    fails_by_itself(failed(one.claim, changed(one, one.outside)), one.words)


def test_kinematics_draws_a_thousand_configurations_for_each_seed_and_robot(monkeypatch):
    drawn = []
    monkeypatch.setattr(kinematics, "errors", lambda robot, phi: drawn.append((robot, phi)) or {})
    rows = [row for case in kinematics.CLAIM.cases((5, 6)) for row in kinematics.run(case, Tally())]
    assert [(row["seed"], row["robot"]) for row in rows] == [
        (seed, robot.name) for seed in (5, 6) for robot, _ in drawn[:2]
    ]
    assert {phi.shape for _, phi in drawn} == {(1000, 6)}
    assert np.unique([phi[:, 0] for _, phi in drawn]).size == 2 * 1000


def test_most_seeds_have_the_smallest_error_in_z_and_nine_of_ten_the_largest_in_the_rectangle():
    above_x = Bar("imu", {}, vector("as thesis: a window", (0.2, 0.5, 0.3)), "", 4)
    words = "smaller in z than in y always"
    assert failed("imu", changed(above_x, above_x.outside)) == []
    fails_by_itself(failed("imu", changed(above_x._replace(rows=5), above_x.outside)), words)
    elsewhere = {"as thesis: x, y largest in rectangle": 0.0}
    one = Bar("imu", {}, elsewhere, "")
    assert failed("imu", changed(one, elsewhere)) == []
    found = failed("imu", changed(one._replace(rows=2), elsewhere))
    fails_by_itself(found, "largest in x and y within the rectangle")


CAUSES = {
    **{"as chosen": 0.1, "sensor delays left in": 0.2, "central differences": 0.09},
    **{"mapped, then filtered": 0.09, "both": 0.06, "rigid robot, both": 0.01},
}


@pytest.mark.parametrize(
    ("cause", "inside", "outside", "words"),
    [
        ("sensor delays left in", 0.101, 0.099, "delays of the sensors"),
        ("mapped, then filtered", 0.099, 0.101, "filtering the predicted motion"),
        ("central differences", 0.099, 0.101, "central differences"),
        ("rigid robot, both", 0.0199, 0.0201, "less than a third"),
    ],
)
def test_a_cause_of_the_error_raises_or_lowers_it(cause, inside, outside, words):
    def found(value):
        return failed("imu-causes", [
            {"cause": name, "acceleration_rms": np.array([a, 0.0, 0.0])}
            for _ in range(2)
            for name, a in (CAUSES | {cause: value}).items()
        ])  # fmt: skip

    assert found(inside) == []
    fails_by_itself(found(outside), words)


@pytest.mark.parametrize(
    ("left_out", "cells", "inside", "outside", "words"),
    [
        ("ripple", "worst", 0.0999, 0.1001, "motors learn whatever"),
        ("gear-error", "p3, k = 5", 301.0, 299.0, "left with more at p3"),
        ("nothing", "p3, k = 5", 401.0, 399.0, "with all effects p3 does not get better"),
        ("all four", "p3, k = 5", 399.0, 401.0, "with all effects p3 does not get better"),
    ],
)
def test_ablations_are_bounded(left_out, cells, inside, outside, words):
    module = evidence.module("claims", "ablations")
    key = module.WORST if cells == "worst" else cells

    def rows(value):
        for seed, name in module.CLAIM.cases(range(2)):
            # p1: 400 -> 300; p3: 400 -> 450, without any effect -> 350
            row = {"p1, k = 0": 400.0, "p1, k = 5": 300.0, "p3, k = 0": 400.0}
            row |= {"p3, k = 5": 350.0 if name == "all four" else 450.0, module.WORST: 0.05}
            yield row | {"left out": name} | ({key: value} if (seed, name) == (1, left_out) else {})

    assert failed("ablations", rows(inside)) == []
    fails_by_itself(failed("ablations", rows(outside)), words)


@pytest.mark.parametrize(
    ("name", "field", "value", "words"),
    [
        (estimation_controls.NO_DYNAMICS, "error", 20e-6, "without dynamics"),
        (estimation_controls.AVERAGED, "ratio", 0.2, "without identification"),
    ],
)
def test_a_negative_control_fails_where_it_is_not_worse(name, field, value, words):
    names = (estimation_controls.KINEMATICS, estimation_controls.NO_DYNAMICS)

    def found(changed):
        rows = []
        for _, pose in estimation_controls.CLAIM.cases(range(2)):
            for variant in (*names, *estimation_controls.variants()):
                default = variant == estimation_controls.DEFAULT
                error, ratio = (10e-6, 0.1) if default else (50e-6, 0.3)
                row = dict(estimation_controls.cells(variant, pose, error, ratio))
                rows.append(row | ({field: changed} if (variant, pose) == (name, "p2") else {}))
        return failed("estimation-controls", rows)

    assert found(value * (1 + CLOSE)) == []
    fails_by_itself(found(value * (1 - CLOSE)), words)


@pytest.mark.parametrize("name", ["best fixed design by search", "learned policy"])
def test_a_better_design_is_better_by_three_standard_errors(name):
    thesis = np.exp(0.2 * np.random.default_rng(0).standard_normal(50))
    noise = np.random.default_rng(1).standard_normal(50)
    noise = (noise - noise.mean()) / noise.std(ddof=1) * np.sqrt(50)  # standard error: 1

    def found(gain):
        """log(thesis) - log(name) has mean `gain` and standard error 1, in parts of 1e-3."""
        ratios = {"thesis design": thesis}
        ratios |= dict.fromkeys(("best fixed design by search", "learned policy"), 0.5 * thesis)
        ratios[name] = thesis / np.exp(1e-3 * (gain + noise))
        rows = ({"baseline": b, "ratio": r} for b, of in ratios.items() for r in of)
        return failed("tuning", rows)

    assert found(3.01) == []
    fails_by_itself(found(2.99), f"the {name} leaves less")


def test_a_searched_design_is_made_for_its_budget():
    def found(tenth):
        falling = np.array([1.0, 0.9, 0.8, 0.7, 0.6, 0.5, 0.5, 0.5, 0.5, 0.5, tenth])
        row = {"baseline": "best fixed design by search", "diverged": False, "rms": falling}
        return failed("tuning-iterations", [row] * 3)

    assert found(0.501) == []
    fails_by_itself(found(0.499), "after ten iterations it leaves more")


def test_the_design_that_grew_fails_the_claim_that_replaced_it_and_the_thesis_does_not():
    from ._episodes import THESIS
    from .tuning import GREW, grown

    assert failed("tuning-growth", [grown("thesis", THESIS, Tally())]) == []
    bad = failed("tuning-growth", [grown("before", GREW, Tally())])
    assert len(bad) == 2


@pytest.mark.parametrize(
    ("change", "words"),
    [
        ({}, ""),
        ({"differ": 0.0}, "tasks differ"),
        ({"known": False}, "a contextual policy"),
        ({"ahead": False}, "three by the model reach"),
        ({"tool": 0.0}, "learning from the estimate"),
        ({"criterion": 1.01}, "no design with a criterion"),
    ],
)
def test_tasks_differ_and_the_model_knows_by_how_much(change, words):
    """One or the other of two unlike designs is best, by turns, as a feature of the task says."""
    found = failed("tuning-tasks", rows_of_tasks(**change))
    if words:
        assert any(words in verdict for verdict in found)
    else:
        assert found == []


def rows_of_tasks(differ=0.3, known=True, ahead=True, tool=-3.0, criterion=0.5):
    from .tuning_tasks import POOL

    rows = []
    for seed in range(40):
        logs = np.zeros(POOL + 2)
        logs[9:11], logs[POOL:] = -0.1, -0.35
        logs[9 + seed % 2] -= differ
        seen = np.stack((logs, logs, np.full(POOL + 2, criterion)), axis=1)
        row = {"seed": seed, "features": np.array([seed % 2 if known else 0.0])}
        own = np.arange(POOL)
        rows.append({**row, "kind": "development", "designs": own, "logs": logs[:POOL]})
        by_model = logs[:POOL] if ahead else np.arange(POOL)
        sealed = {"logs": seen, "ahead": by_model, "random": np.array([0.0, 0.0, criterion])}
        rows.append(row | {"kind": "sealed"} | sealed)
        rows.append({"kind": "ppo", "seed": seed, "logs": np.zeros((3, 3))})
    return [*rows, {"kind": "tool", "seed": 0, "logs": tool}]


@pytest.mark.parametrize(("bad", "holds"), [(1, True), (2, False)])
def test_four_of_five_seeds_must_hold_in_chapter_9(bad, holds):
    from armside.sim.evaluation.check import Check

    rows = [
        {"seed": seed, "checks": [Check("a1", "s", "t", 1.0 if seed < bad else 0.0, high=0.5)]}
        for seed in range(5)
    ]
    assert (failed("chapter9", rows) == []) is holds


def test_axes_of_a_vector_are_columns_of_their_own():
    assert axes("a RMS") == list(vector("a RMS"))


def test_the_flags_of_aliens_are_those_of_a_user_without_a_tracker():
    assert {Cause.IMU, Cause.GUARD} == aliens.FLAGS
