"""Bands of thesis chapter 9: its findings as numbers, from the results of experiments alone.

The bands are those of an independent implementation of the same study: wide enough for another
robot, too narrow for other behaviour. `calibrate` holds them against the nominal robot without
noise, `reproduce 9` and `verify` against individuals with all noise.

A result is a mapping of arrays, iterations 0 .. K first: motor_inf, motor_two (K + 1, 6) [rad of
the motor shaft]; arm_rms, arm_maxdev, ripple (K + 1,) [m]; error, correction (K + 1, N, 6) [rad];
gear (6,); motion_end, the sample at which the reference comes to rest.
"""

from collections.abc import Mapping
from typing import Any

import numpy as np
from numpy.typing import ArrayLike, NDArray

from armside.arrays import Array
from armside.ilc.analysis.criterion import frequency_grid, hertz, heuristic_criterion
from armside.ilc.filters import ALL_PASS, ZeroPhaseButterworth
from armside.ilc.identification import first_order_lag as learning_data
from armside.ilc.identification.first_order_lag import (
    FirstOrderModel,
    LearningRecord,
    fit_first_order,
)
from armside.ilc.laws import Heuristic
from armside.ilc.measures import norms as measures
from armside.ilc.models.system import System
from armside.sim.evaluation.check import Check

from ..report import Band

Result = Mapping[str, NDArray[Any]]
ByPose = Mapping[str, Result]

POSES = ("p1", "p2", "p3")
AT = 5  # the iteration at which learning stops
SAMPLE_TIME = 0.004
MOST_MOVED = (3, 5)
"""Motors 4 and 6, counted from 0: they move most, so a linear model describes them."""
SPEEDS = (30.0, 40.0, 60.0)
"""[mm/s], of the identification."""
THESIS_DELAY = 5
"""[samples], of (9.12)."""
THESIS_MODEL = System(
    np.append(np.zeros(THESIS_DELAY), 0.5083), np.array([1.0, -0.4884]), SAMPLE_TIME
)
"""(9.12)."""
THESIS_REPEATABILITY = 0.2
"""Of (9.10), about: what an identical experiment changes is no significant change."""


SLOW_MOTORS = (
    "motors 3 and 5 answer later than those that T_u describes, and gain by any further sample; in "
    "units of (9.5), those of the figure, their errors differ by 0.06 and 0.02"
)

# fmt: off
BANDS: Mapping[str, Band] = {
    "a1": Band("largest motor error at k = 5, (9.5), inf-norm, of 18", "0.0701 (motor 1, p3)",
               high=0.10),
    "a2": Band("smallest motor error at k = 5, (9.5), inf-norm, of 18", "0.0102 (motor 5, p2)",
               high=0.02),
    "a3": Band("how many of 18 motor errors are smaller at k = 5 than at k = 0", "all decrease",
               low=18),
    "a4": Band("largest motor error at k = 5 over its own k = 0", "all decrease", high=0.30),
    "a5": Band("largest change of a motor error from k = 5 to k = 10 over the largest at k = 5, "
               "2-norm, worst pose", "no significant change", high=THESIS_REPEATABILITY),
    "a6": Band("2-norm after one update over its prediction by T_u, or the inverse: worst of the "
               "motors it describes", "criterion indicates", high=2.0),
    "b1": Band("p1: RMS at k = 5 over k = 0", "decreasing, good behaviour", 0.20, 0.50),
    "b2": Band("p1: maximum deviation at k = 5 over k = 0", "decreasing", high=0.60),
    "b3": Band("p2: RMS at k = 5 over k = 1", "increasing trend", low=1.0),
    "b4": Band("p2: largest RMS after the first update over that at k = 1", "increasing trend",
               low=1.03),
    "b5": Band("p3: RMS at k = 5 over k = 0", "as large as or larger than without ILC", 1.0, 1.6),
    "b6": Band("RMS ratio k = 5 to k = 0: p2 less p1", "p1 best", low=0.0),
    "b7": Band("RMS ratio k = 5 to k = 0: p3 less p2", "p3 worst", low=0.0),
    "c1": Band("p1, 15 Hz over 10 Hz: RMS at k = 5", "larger", low=1.05),
    "c2": Band("p1, 15 Hz over 10 Hz: maximum deviation at k = 5", "larger", low=1.10),
    "c3": Band("p1, 15 Hz over 10 Hz: radius between 5 and 14 Hz, rms at k = 5", "oscillatory",
               low=1.2),
    "c4": Band("p1, 15 Hz over 10 Hz: motors of six whose inf-norm at k = 5 is larger",
               "better with a higher cutoff", high=0),
    "c5": Band("p1, 15 Hz over 10 Hz: motors whose inf-norm at k = 5 falls below 0.7",
               "some significantly better", low=2),
    "c6": Band("motor 4 at k = 5: 22.5 Hz over 5 Hz", "better with a higher cutoff", high=1.0),
    "c7": Band("p1, 15 Hz over 10 Hz: 2-norm at k = 5, median motor", "", high=1.0),
    "d1": Band("p1, delta 6 over delta 3: RMS at k = 5", "lower", high=0.97),
    "d2": Band("p2, delta 6 over delta 3: RMS at k = 5", "lower", high=0.95),
    "d3": Band("p1, motor errors at k = 5 for shifts of 1 to 8: largest over smallest, worst motor",
               "differences rather small", high=2.0),
    "e1": Band("T_u of motors 4 and 6 at p1, output error: fit", "best overall agreement", low=0.9),
    "e2": Band("its static gain", "0.994", 0.97, 1.03),
    "e3": Band("its delay and lag [samples of 4 ms]", "5 + 0.95", 5.0, 7.0),
    "e4": Band("pole of the model with the delay of (9.12)", "0.488", 0.2, 0.65),
    "e5": Band("(9.12): shifts of 1 to 8 that meet the criterion at 10 Hz", "all 8", 8, 8),
    "e6": Band("(9.12): the smallest shift that meets the criterion at 22.5 Hz",
               "3: delta 1 and 2 do not", 3, 3),
    "e7": Band("(9.12): the shift with the least sup |1 - L T_u| below 10 Hz", "6", 6, 6),
    "f1": Band("motor 3 at p3 over the largest of 18, 50 mm/s", "largest", low=1.0),
    "f2": Band("motor 4 at p1 over the largest of 18", "large", low=0.5),
    "f3": Band("motor 4 at p3 over the largest of 18", "large", low=0.45),
    "f4": Band("motor 4 at p2 over the smaller of p1 and p3", "smaller at p2", high=1.0),
    "f5": Band("smallest growth of a motor error from 10 to 80 mm/s", "increases", low=1.0),
    "f6": Band("largest change of a motor error from 80 to 100 mm/s, relative", "saturates",
               high=0.03),
    "g1": Band("(9.10) of two identical experiments at p1: median over iterations of the largest "
               "motor", "about 0.2", 0.10, 0.35),
}
"""By id: (a) motor side, (b) arm side, (c) cutoff, (d) shift, (e) model, (f) without learning, (g)
repeatability."""
# fmt: on


def compare(**ours: ArrayLike) -> list[Check]:
    """Numbers by the id of their band."""
    return [BANDS[id].check(id, value) for id, value in ours.items()]


def over_first(result: Result, name: str = "arm_rms") -> Array:
    """A measure at k = 5 over that at k = 0."""
    return result[name][AT] / result[name][0]


def over(one: Result, other: Result, name: str = "arm_rms", k: int = AT) -> Array:
    """A measure of one experiment over that of another, at one iteration."""
    return one[name][k] / other[name][k]


def motor_side(base: ByPose) -> list[Check]:
    """(a): every motor learns, at every pose. Thesis 9.4.3, Fig 9.9."""
    first, last = (np.array([base[pose]["motor_inf"][k] for pose in POSES]) for k in (0, AT))
    own, normalised = last / first, measures.normalise(last, first)
    return compare(a1=normalised.max(), a2=normalised.min(), a3=(own < 1.0).sum(), a4=own.max())


def stability(ten: ByPose) -> list[Check]:
    """(a): no significant change after the fifth iteration. Thesis 9.4.2, Fig 9.7."""
    first = max(result["motor_two"][0].max() for result in ten.values())
    found = []
    for pose, result in ten.items():
        norm = result["motor_two"]
        change = np.abs(norm[AT:] - norm[AT]).max(axis=0)
        which = f"motor {change.argmax() + 1} at {pose} is still learning at k = 5"
        reason = f"{which}; in units of (9.5) its error changes by {change.max() / first:.2f}"
        found.append((change.max() / norm[AT].max(), reason))
    return [BANDS["a5"].check("a5", *max(found))]


def predicted_rates(
    model: System, base: ByPose, law: Heuristic, motors: tuple[int, ...]
) -> list[Check]:
    """(a): the identified model predicts the first step of learning, 2-norm."""
    worst = 1.0
    for result in base.values():
        e0, e1 = (result["error"][k].astype(np.float64)[:, motors] for k in (0, 1))
        predicted = e0 - model.simulate(law(np.zeros_like(e0), e0))
        off = measures.two_norm(e1) / measures.two_norm(predicted)
        worst = max(worst, float(np.maximum(off, 1.0 / off).max()))
    return compare(a6=worst)


def arm_side(base: ByPose) -> list[Check]:
    """(b): the arm improves at p1, not at p2 and p3. Thesis 9.4.3, Fig 9.11."""
    p1, p2, p3 = (over_first(base[pose]) for pose in POSES)
    rms = base["p2"]["arm_rms"]
    b2, b3 = over_first(base["p1"], "arm_maxdev"), rms[AT] / rms[1]
    b4 = rms[1 : AT + 1].max() / rms[1]
    return compare(b1=p1, b2=b2, b3=b3, b4=b4, b5=p3, b6=p2 - p1, b7=p3 - p2)


def cutoff_arm(slow: Result, fast: Result) -> list[Check]:
    """(c): a higher cutoff makes the arm worse. p1, 15 Hz over 10 Hz. Thesis Figs 9.16, 9.17."""
    c1, c2, c3 = (over(fast, slow, name) for name in ("arm_rms", "arm_maxdev", "ripple"))
    return compare(c1=c1, c2=c2, c3=c3)


def cutoff_motor(slow: Result, fast: Result) -> list[Check]:
    """(c): a higher cutoff makes some motors much better. Thesis Fig 9.14; the 2-norm is ours."""
    ratio = over(fast, slow, "motor_inf")
    return compare(c5=(ratio < 0.7).sum(), c7=np.median(over(fast, slow, "motor_two")))


def cutoff_worse(slow: Result, fast: Result) -> list[Check]:
    """(c): a higher cutoff makes no motor worse. Thesis Fig 9.14."""
    worse = over(fast, slow, "motor_inf") > 1.0
    better = int((over(fast, slow, "motor_two") < 1.0).sum())
    which = ", ".join(str(i + 1) for i in np.flatnonzero(worse))
    reason = f"motors {which} are worse; in the 2-norm, that of the criterion, {better} are better"
    return [BANDS["c4"].check("c4", worse.sum(), reason)]


def shift_arm(delta_3: ByPose, delta_6: ByPose) -> list[Check]:
    """(d): delta 6 is better than 3 on the arm side. Thesis Fig 9.13."""
    d1, d2 = (over(delta_6[pose], delta_3[pose]) for pose in ("p1", "p2"))
    return compare(d1=d1, d2=d2)


def shift_motor(by_delta: Mapping[Any, Result]) -> list[Check]:
    """(d): the shift matters little on the motor side. p1. Thesis Fig 9.12."""
    error = np.array([result["motor_inf"][AT] for result in by_delta.values()])
    worst = (error.max(axis=0) / error.min(axis=0)).max()
    return [BANDS["d3"].check("d3", worst, SLOW_MOTORS)]


def learning_signals(
    results: Mapping[float, Result], motors: tuple[int, ...]
) -> tuple[Array, Array]:
    """(u, y) of some motors, (N, motors), from learning at several velocities. Thesis (9.11)."""
    return learning_data.learning_data(_records(results), motors)


def identify(
    results: Mapping[float, Result], motors: tuple[int, ...] = MOST_MOVED
) -> FirstOrderModel:
    """One T_u for these motors from learning at several velocities."""
    return learning_data.identify(_records(results), SAMPLE_TIME, motors)


def _records(results: Mapping[float, Result]) -> list[LearningRecord]:
    return [
        LearningRecord(r["correction"][AT], r["error"][0], r["error"][AT], int(r["motion_end"]))
        for r in results.values()
    ]


def fitted_model(results: Mapping[float, Result]) -> list[Check]:
    """(e): the model identified from the motors that move most. Thesis (9.12).

    Delay and lag make up for each other: three delays fit alike. Poles are compared at one of them.
    """
    model, data = identify(results), learning_signals(results, MOST_MOVED)
    same_delay = fit_first_order(*data, SAMPLE_TIME, delays=(THESIS_DELAY,))
    return compare(e1=model.fit, e2=model.static_gain, e3=model.total_delay, e4=same_delay.pole)


def criterion_of(model: System = THESIS_MODEL, gamma: float = 0.9) -> list[Check]:
    """(e): criterion (9.13) of model (9.12): arithmetic, no robot takes part. Fig 9.8."""

    def stable(cutoff: float) -> list[int]:
        Q = ZeroPhaseButterworth(cutoff, model.sample_time)
        return [d for d in range(1, 9) if heuristic_criterion(model, gamma, d, Q).is_met]

    at_10, at_22 = stable(10.0), stable(22.5)
    return compare(e5=len(at_10), e6=min(at_22, default=0), e7=best_shift(model, gamma))


def best_shift(model: System, gamma: float = 0.9, below: float = 10.0) -> int:
    """The shift of 1 to 8 with the smallest sup |1 - L T_u| below a frequency [Hz]."""
    omega = frequency_grid()
    omega = omega[hertz(omega, model.sample_time) <= below]
    return min(
        range(1, 9),
        key=lambda d: heuristic_criterion(model, gamma, d, ALL_PASS, omega).learning.max(),
    )


def nominal_by_position(at_50: ByPose) -> list[Check]:
    """(f): motor errors without learning by position. Thesis Fig 9.5."""
    errors = np.array([at_50[pose]["motor_inf"][0] for pose in POSES])
    p1, p2, p3 = errors[:, 3] / errors.max()
    return compare(f1=errors[2, 2] / errors.max(), f2=p1, f3=p3, f4=p2 / min(p1, p3))


def growth(at_10: ByPose, at_80: ByPose) -> list[Check]:
    """(f): motor errors without learning grow with speed. Thesis Fig 9.6."""
    ratio = [over(at_80[pose], at_10[pose], "motor_inf", 0) for pose in at_10]
    return compare(f5=np.min(ratio))


def saturation(at_80: ByPose, at_100: ByPose) -> list[Check]:
    """(f): they no longer grow where the planner limits the speed. Thesis Fig 9.6."""
    ratio = np.array([over(at_100[pose], at_80[pose], "motor_inf", 0) for pose in at_80])
    return compare(f6=np.abs(ratio - 1.0).max())


def repeatability_per_iteration(first: Result, second: Result) -> Array:
    """(9.10) of two identical experiments, the largest motor of each iteration, shape (K,)."""
    gear = first["gear"]
    best = min(float(r["motor_inf"].min()) for r in (first, second))
    y_1, y_2 = (-r["error"].astype(np.float64) * gear for r in (first, second))  # y = r - e
    return np.array(
        [measures.repeatability(a, b, best).max() for a, b in zip(y_1, y_2, strict=True)]
    )


def repeatability(first: Result, second: Result) -> list[Check]:
    """(g): two identical experiments differ by a part of the best error. Thesis (9.10)."""
    return compare(g1=np.median(repeatability_per_iteration(first, second)))
