"""What chapter 9 of the thesis found, as numbers with bands: functions of results alone.

The bands are those of an independent implementation: wide enough for another robot, too narrow for
another story. A result is the dict of arrays that a LearningJob leaves.
"""

from collections.abc import Mapping

import numpy as np

from armside.arrays import Array
from armside.ilc.analysis.criterion import frequency_grid, hertz, heuristic_criterion
from armside.ilc.filters import ALL_PASS, ZeroPhaseButterworth
from armside.ilc.identification.first_order import FirstOrderModel
from armside.ilc.laws import Heuristic
from armside.ilc.measures import norms as measures
from armside.ilc.models.system import System

from ...jobs.store import Result
from ..report import Check

POSES = ("p1", "p2", "p3")
AT = 5  # the iteration at which learning stops
SAMPLE_TIME = 0.004
THESIS_MODEL = System(np.array([0, 0, 0, 0, 0, 0.5083]), np.array([1.0, -0.4884]), SAMPLE_TIME)
"""(9.12)."""

ByPose = Mapping[str, Result]


def motor_side(base: ByPose) -> list[Check]:
    """(a): every motor learns, at every pose. Thesis 9.4.3, Fig 9.9."""
    first = np.array([base[pose]["motor_inf"][0] for pose in POSES])
    last = np.array([base[pose]["motor_inf"][AT] for pose in POSES])
    own = last / first
    normalised = measures.normalise(last, first)
    return [
        Check(
            id="a1",
            statement="largest motor error at k = 5, (9.5), inf-norm, of 18",
            thesis="0.0701 (motor 1, p3)",
            ours=float(normalised.max()),
            high=0.10,
        ),
        Check(
            id="a2",
            statement="smallest motor error at k = 5, (9.5), inf-norm, of 18",
            thesis="0.0102 (motor 5, p2)",
            ours=float(normalised.min()),
            high=0.02,
        ),
        Check(
            id="a3",
            statement="how many of 18 motor errors fall to a tenth of their own k = 0",
            thesis="all decrease",
            ours=float((own <= 0.10).sum()),
            low=14,
        ),
        Check(
            id="a4",
            statement="largest motor error at k = 5 over its own k = 0",
            thesis="all decrease",
            ours=float(own.max()),
            high=0.30,
        ),
    ]


def stability(ten: ByPose) -> list[Check]:
    """(a): nothing happens after the fifth iteration. Thesis 9.4.2, Fig 9.7."""
    norms = {pose: result["motor_two"] for pose, result in ten.items()}
    largest = max(norm[0].max() for norm in norms.values())
    change = max(float(np.abs(norm[AT:] - norm[AT]).max()) for norm in norms.values()) / largest
    return [
        Check(
            id="a5",
            statement="largest change from k = 5 to k = 10, (9.5), 2-norm, all motors and poses",
            thesis="no significant change",
            ours=change,
            high=0.05,
        )
    ]


def arm_side(base: ByPose) -> list[Check]:
    """(b): the arm improves at p1, not at p2 and p3. Thesis 9.4.3, Fig 9.11."""
    rms = {pose: base[pose]["arm_rms"] for pose in POSES}
    maxdev = base["p1"]["arm_maxdev"]
    ratio = {pose: float(rms[pose][AT] / rms[pose][0]) for pose in POSES}
    p2 = rms["p2"]
    return [
        Check(
            id="b1",
            statement="p1: RMS at k = 5 over k = 0",
            thesis="decreasing, good behaviour",
            ours=ratio["p1"],
            low=0.20,
            high=0.50,
        ),
        Check(
            id="b2",
            statement="p1: maximum deviation at k = 5 over k = 0",
            thesis="decreasing",
            ours=float(maxdev[AT] / maxdev[0]),
            high=0.60,
        ),
        Check(
            id="b3",
            statement="p2: RMS at k = 5 over k = 1",
            thesis="increasing trend",
            ours=float(p2[AT] / p2[1]),
            low=0.95,
        ),
        Check(
            id="b4",
            statement="p2: largest RMS after the first update over that at k = 1",
            thesis="increasing trend",
            ours=float(p2[1 : AT + 1].max() / p2[1]),
            low=1.03,
        ),
        Check(
            id="b5",
            statement="p3: RMS at k = 5 over k = 0",
            thesis="as large as or larger than without ILC",
            ours=ratio["p3"],
            low=0.95,
            high=1.6,
        ),
        Check(
            id="b6",
            statement="RMS ratio k = 5 to k = 0: p2 less p1",
            thesis="p1 best",
            ours=ratio["p2"] - ratio["p1"],
            low=0.0,
        ),
        Check(
            id="b7",
            statement="RMS ratio k = 5 to k = 0: p3 less p2",
            thesis="p3 worst",
            ours=ratio["p3"] - ratio["p2"],
            low=0.0,
        ),
    ]


def cutoff_arm(slow: Result, fast: Result) -> list[Check]:
    """(c): a higher cutoff makes the arm worse. p1, 15 Hz over 10 Hz. Thesis Figs 9.16, 9.17."""

    def ratio(name: str) -> float:
        return float(fast[name][AT] / slow[name][AT])

    return [
        Check(
            id="c1",
            statement="p1, 15 Hz over 10 Hz: RMS at k = 5",
            thesis="larger",
            ours=ratio("arm_rms"),
            low=1.05,
        ),
        Check(
            id="c2",
            statement="p1, 15 Hz over 10 Hz: maximum deviation at k = 5",
            thesis="larger",
            ours=ratio("arm_maxdev"),
            low=1.10,
        ),
        Check(
            id="c3",
            statement="p1, 15 Hz over 10 Hz: radius between 5 and 14 Hz, rms at k = 5",
            thesis="oscillatory",
            ours=ratio("ripple"),
            low=1.2,
        ),
    ]


def cutoff_motor(slow: Result, fast: Result) -> list[Check]:
    """(c): a higher cutoff makes most motors better. Thesis Fig 9.14."""
    ratio = fast["motor_two"][AT] / slow["motor_two"][AT]
    return [
        Check(
            id="c4",
            statement="p1, 15 Hz over 10 Hz: 2-norm at k = 5, median motor",
            thesis="better",
            ours=float(np.median(ratio)),
            high=1.0,
        ),
        Check(
            id="c5",
            statement="p1, 15 Hz over 10 Hz: motors whose 2-norm falls below 0.7",
            thesis="some significantly better",
            ours=float((ratio < 0.7).sum()),
            low=2,
        ),
    ]


def shift_arm(delta_3: ByPose, delta_6: ByPose) -> list[Check]:
    """(d): delta 6 is better than 3 on the arm side. Thesis Fig 9.13."""
    return [
        Check(
            id=f"d{i}",
            statement=f"{pose}, delta 6 over delta 3: RMS at k = 5",
            thesis="lower",
            ours=float(delta_6[pose]["arm_rms"][AT] / delta_3[pose]["arm_rms"][AT]),
            high=high,
        )
        for i, (pose, high) in enumerate((("p1", 0.97), ("p2", 0.95)), start=1)
    ]


def fitted_model(model: FirstOrderModel) -> list[Check]:
    """(e): what is identified from the motors that move most. Thesis (9.12)."""
    return [
        Check(
            id="e1",
            statement="T_u of motors 4 and 6 at p1, output error: fit",
            thesis="best overall agreement",
            ours=model.fit,
            low=0.9,
        ),
        Check(
            id="e2",
            statement="its static gain",
            thesis="0.994",
            ours=model.static_gain,
            low=0.97,
            high=1.03,
        ),
        Check(
            id="e3",
            statement="its delay and lag [samples of 4 ms]",
            thesis="5 + 0.95",
            ours=model.total_delay,
            low=5.0,
            high=7.0,
        ),
        Check(id="e4", statement="its pole", thesis="0.488", ours=model.pole, low=0.2, high=0.65),
    ]


def criterion_of(model: System = THESIS_MODEL, gamma: float = 0.9) -> list[Check]:
    """(e): what (9.13) says about (9.12): this is arithmetic, no robot takes part. Fig 9.8."""
    stable = {
        cutoff: [d for d in range(1, 9) if _is_met(model, gamma, d, cutoff)]
        for cutoff in (10.0, 22.5)
    }
    return [
        Check(
            id="e5",
            statement="(9.12): shifts of 1 to 8 that meet the criterion at 10 Hz",
            thesis="all 8",
            ours=float(len(stable[10.0])),
            low=8,
            high=8,
        ),
        Check(
            id="e6",
            statement="(9.12): the smallest shift that meets the criterion at 22.5 Hz",
            thesis="3: delta 1 and 2 do not",
            ours=float(min(stable[22.5], default=0)),
            low=3,
            high=3,
        ),
        Check(
            id="e7",
            statement="(9.12): the shift with the least sup |1 - L T_u| below 10 Hz",
            thesis="6",
            ours=float(best_shift(model, gamma)),
            low=6,
            high=6,
        ),
    ]


def _is_met(model: System, gamma: float, delta: int, cutoff: float) -> bool:
    Q = ZeroPhaseButterworth(cutoff, model.sample_time)
    return heuristic_criterion(model, gamma, delta, Q).is_met


def best_shift(model: System, gamma: float = 0.9, below: float = 10.0) -> int:
    """The shift of 1 to 8 with the smallest sup |1 - L T_u| below a frequency [Hz]."""
    omega = frequency_grid()
    omega = omega[hertz(omega, model.sample_time) <= below]
    return min(
        range(1, 9),
        key=lambda d: heuristic_criterion(model, gamma, d, ALL_PASS, omega).learning.max(),
    )


def predicted_rates(
    model: System, base: ByPose, law: Heuristic, motors: tuple[int, ...]
) -> list[Check]:
    """(a): the first step of learning is what the identified model predicts, 2-norm."""
    worst = 1.0
    for result in base.values():
        e0, e1 = (result["error"][k].astype(np.float64)[:, motors] for k in (0, 1))
        predicted = e0 - model.simulate(law(np.zeros_like(e0), e0))
        off = measures.two_norm(e1) / measures.two_norm(predicted)
        worst = max(worst, float(np.maximum(off, 1.0 / off).max()))
    return [
        Check(
            id="a6",
            statement="2-norm after one update over its prediction by T_u, or the inverse: worst "
            "of the motors it describes",
            thesis="criterion indicates",
            ours=worst,
            high=2.0,
        )
    ]


def nominal_by_position(at_50: ByPose) -> list[Check]:
    """(f): which motors are worst where, without learning. Thesis Fig 9.5."""
    errors = {pose: at_50[pose]["motor_inf"][0] for pose in POSES}
    largest = max(e.max() for e in errors.values())
    fourth = {pose: float(errors[pose][3] / largest) for pose in POSES}
    return [
        Check(
            id="f1",
            statement="motor 3 at p3 over the largest of 18, 50 mm/s",
            thesis="largest",
            ours=float(errors["p3"][2] / largest),
            low=1.0,
        ),
        Check(
            id="f2",
            statement="motor 4 at p1 over the largest of 18",
            thesis="large",
            ours=fourth["p1"],
            low=0.5,
        ),
        Check(
            id="f3",
            statement="motor 4 at p3 over the largest of 18",
            thesis="large",
            ours=fourth["p3"],
            low=0.45,
        ),
        Check(
            id="f4",
            statement="motor 4 at p2 over the smaller of p1 and p3",
            thesis="smaller at p2",
            ours=fourth["p2"] / min(fourth["p1"], fourth["p3"]),
            high=1.0,
        ),
    ]


def nominal_by_velocity(by_speed: Mapping[float, ByPose]) -> list[Check]:
    """(f): errors grow with speed until the robot limits it. Thesis Fig 9.6.

    by_speed: results without learning by speed [mm/s], at least 10, 80 and 100.
    """

    def ratio(fast: float, slow: float) -> Array:
        return np.array(
            [
                by_speed[fast][pose]["motor_inf"][0] / by_speed[slow][pose]["motor_inf"][0]
                for pose in by_speed[fast]
            ]
        )

    return [
        Check(
            id="f5",
            statement="smallest growth of a motor error from 10 to 80 mm/s",
            thesis="increases",
            ours=float(ratio(80.0, 10.0).min()),
            low=1.0,
        ),
        Check(
            id="f6",
            statement="largest change of a motor error from 80 to 100 mm/s, relative",
            thesis="saturates",
            ours=float(np.abs(ratio(100.0, 80.0) - 1.0).max()),
            high=0.03,
        ),
    ]


def repeatability_per_iteration(first: Result, second: Result) -> Array:
    """(9.10) of two identical experiments, the largest motor of each iteration, shape (K,)."""
    gear = first["gear"]
    best = min(float(r["motor_inf"].min()) for r in (first, second))
    outputs = (-r["error"].astype(np.float64) * gear for r in (first, second))  # y = r - e
    y_1, y_2 = outputs
    return np.array(
        [measures.repeatability(a, b, best).max() for a, b in zip(y_1, y_2, strict=True)]
    )


def repeatability(first: Result, second: Result) -> list[Check]:
    """(g): two identical experiments differ by a part of the best error. Thesis (9.10)."""
    values = repeatability_per_iteration(first, second)
    return [
        Check(
            id="g1",
            statement="(9.10) of two identical experiments at p1: median over iterations of the "
            "largest motor",
            thesis="about 0.2",
            ours=float(np.median(values)),
            low=0.10,
            high=0.35,
        )
    ]
