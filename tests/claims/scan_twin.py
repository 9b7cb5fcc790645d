"""First cuts by a twin that a scan of one coupon has made, with and without an IMU.

Ten individuals with geometry errors, twelve tasks each: `_tasks`. "Left" is the true tool RMS of
the first run with the twin's correction over that without any. `scan-twin-development` gives the
factors of the predicted interval from six individuals of development, on which all settings were
chosen: the table of contours, the number of cuts by IMU, and the priors of sheet and kerf.
"""

import time
from collections.abc import Iterator, Mapping
from dataclasses import replace
from typing import NamedTuple

import numpy as np
from scipy.stats import norm
from scipy.stats import t as student_t

from armside.sim.robot.spread import Drawn
from armside.sim.scan.virtual_reading import CALIBRATED, CHEAP, ScanErrors
from armside.sim.twin.prediction import factors

from ._coupons import twin_of
from ._engine import Check, Claim, Row, Rows, Tally, all_hold, crossed
from ._tasks import DEVELOPMENT, DEVELOPMENT_SEED, JUDGED_BY_SCAN, JUDGED_SEED, tasks
from ._twins import first_runs, hidden_hinges, in_its_interval, in_the_interval, left_alone

N_TASKS, N_IMU = 12, 6
"""Tasks of each individual, and cuts of the plan that an IMU sees beside the coupon's eight."""
IMU_ALONE = 10
"""Cuts by IMU alone, as of `first-cut-imu`."""
KERF = replace(CALIBRATED, direction=30e-6, drift=20e-6)
"""The width of a kerf differs by 30 um between the two directions, and drifts by 20 um."""


class Setting(NamedTuple):
    """Of a twin."""

    n_imu: int
    scan: ScanErrors | None
    median: float
    worst: float
    """Asked of what is left."""


SETTINGS: Mapping[str, Setting] = {
    "IMU + coupon": Setting(N_IMU, CALIBRATED, 0.025, 0.15),
    "coupon alone": Setting(0, CALIBRATED, 0.05, 0.25),
    "IMU + coupon, kerf differs and drifts": Setting(N_IMU, KERF, 0.04, 0.20),
    "IMU + coupon, cheap scanner": Setting(N_IMU, CHEAP, np.inf, np.inf),
    "IMU alone": Setting(IMU_ALONE, None, np.inf, np.inf),
}
BOTH, BY_SCAN = "IMU + coupon", "coupon alone"
CHEAP_ONE, ALONE = "IMU + coupon, cheap scanner", "IMU alone"


def run(case: tuple[int, str], tally: Tally) -> Iterator[Row]:
    seed, name = case
    number = JUDGED_BY_SCAN[seed % len(JUDGED_BY_SCAN)]
    yield judged(number, name, JUDGED_SEED, tally)


def judged(number: int, name: str, seed: int, tally: Tally) -> Row:
    """First runs of one individual by a twin of that setting."""
    robot, setting = Drawn(number), SETTINGS[name]
    chosen = [cut for _, cut in tasks(N_TASKS, seed + number)]
    started = time.process_time()
    twin = twin_of(robot, setting.n_imu, setting.scan, seed)
    seconds = time.process_time() - started
    errors, corrections, _ = first_runs(twin, robot, chosen, tally)
    left = errors / [left_alone(cut, robot, tally) for cut in chosen]
    r = np.array([c.prediction.expected for c in corrections]) / factors(twin.evidence)[1]
    return {
        **{"individual": number, "hidden hinges": hidden_hinges(twin, robot), "twin by": name},
        **{"median left": float(np.median(left)), "worst left": float(left.max())},
        "not corrected": sum(not c.trusted for c in corrections),
        "inside the interval": float(in_its_interval(errors, corrections).mean()),
        "commissioning [CPU s]": seconds,
        **{"_left": left, "_inside": in_its_interval(errors, corrections)},
        "_ratio": np.log(errors / r)[[c.trusted for c in corrections]],
    }


def checks(rows: Rows) -> Iterator[Check]:
    each = rows.by("twin by")
    for name, setting in SETTINGS.items():
        of = each[name]
        left = of.joined("_left")
        if np.isfinite(setting.median):
            yield Check("", f"{name}: median left", "", float(np.median(left)), high=setting.median)
            yield Check("", f"{name}: worst left", "", float(left.max()), high=setting.worst)
            yield in_the_interval(f"{name}: ", of.joined("_inside"))
    yield all_hold(f"{BOTH}: none refused", each[BOTH]["not corrected"] == 0)
    for what, of in (("median", np.median), ("worst", np.max)):
        cheap, alone = (float(of(each[n].joined("_left"))) for n in (CHEAP_ONE, ALONE))
        words = f"{what} left by the cheap scanner over IMU alone"
        yield Check("", words, "", cheap / alone, high=1.0)
    longest = each[BOTH]["commissioning [CPU s]"].sum() / each[ALONE]["commissioning [CPU s]"].sum()
    yield Check("", "CPU time with coupon over that without", "", float(longest), high=1.5)


CLAIM = Claim(
    title="First cuts by a twin from a scanned coupon",
    seeds=len(JUDGED_BY_SCAN),
    cases=crossed(SETTINGS),
    run=run,
    checks=checks,
)


def run_of_development(case: tuple[int, str], tally: Tally) -> Iterator[Row]:
    seed, name = case
    yield judged(DEVELOPMENT[seed % len(DEVELOPMENT)], name, DEVELOPMENT_SEED, tally)


def fitted(rows: Rows) -> Iterator[Check]:
    """Lower end, middle and upper end over r: of a normal prediction for another individual, with
    Student's t for the part between individuals."""
    for name, of in rows.by("twin by").items():
        each = [row["_ratio"] for row in of if len(row["_ratio"])]
        means, n = np.array([ratio.mean() for ratio in each]), len(each)
        between = means.std(ddof=1) * student_t.ppf(0.95, n - 1) * np.sqrt(1.0 + 1.0 / n)
        within = np.sqrt(np.mean([ratio.var() for ratio in each])) * norm.ppf(0.95)
        for what, side in (("low", -1.0), ("expected", 0.0), ("high", 1.0)):
            value = float(np.exp(means.mean() + side * np.hypot(within, between)))
            yield Check("", f"{name}: {what} over r", "", value, low=0.0)


CLAIM_DEVELOPMENT = Claim(
    title="Predicted errors of twins from a scanned coupon, on individuals of development",
    seeds=6,
    cases=crossed((BOTH, BY_SCAN)),
    run=run_of_development,
    checks=fitted,
)
