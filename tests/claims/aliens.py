"""Robots that were not drawn from our physics, by twin, estimate, forecast and guard.

Each seed is one of twelve individuals, with each effect of `armside.sim.robot.alien` alone, with
all, and with none; a twin of ten cuts, first runs of `N_TWIN` unseen tasks by it, and learning of
`N_LEARNED` of them from the estimate. Nothing was chosen on an alien but that it runs
(`DEVELOPMENT`). A recording that commissioning refuses, a twin that is not trusted, an estimate
that is refused, and notes of IMU or tool are flags.

Bands, written down before the first judged run: nothing ends above k = 0 without a flag; with each
effect alone the median by the twin is at most 0.10 and by the estimate 0.12; intervals of twin and
forecast hold 70 % or are half as wide again as without the effect.
"""

from collections.abc import Iterator
from dataclasses import replace
from functools import cache

import numpy as np

from armside.sim.estimation.imu_health import ImuError
from armside.sim.laser.experiment import prepare
from armside.sim.laser.forecast import Left, forecast
from armside.sim.laser.loop import iterate, measure_of
from armside.sim.laser.results import notes
from armside.sim.laser.specification import Cut
from armside.sim.notes import Cause, Tally
from armside.sim.robot.alien import ALIEN
from armside.sim.robot.spread import EVERY, Alien, Drawn
from armside.sim.twin.commission import MOST, ImplausibleError, commission

from ._engine import Check, Claim, Row, Rows, all_hold, crossed
from ._tasks import tasks
from ._twins import commissioning_cuts, first_runs, left_alone

DEVELOPMENT, JUDGED = (8000,), tuple(range(8001, 8013))
JUDGED_SEED, N_TWIN, N_LEARNED, UPDATES = 20261208, 6, 3, 5
NONE = "none"
EFFECTS = (NONE, *ALIEN, EVERY)
TWIN, ESTIMATE, COVERAGE, WIDER = 0.10, 0.12, 0.70, 1.5
FLAGS = {Cause.IMU, Cause.TOOL, Cause.GUARD}


def chosen(count: int) -> list[Cut]:
    """Tasks that no setting was chosen on, the same for all robots."""
    return [cut for _, cut in tasks(N_TWIN, JUDGED_SEED)][:count]


def robot(number: int, effect: str) -> Drawn:
    return Drawn(number) if effect == NONE else Alien(number, effect=effect)


@cache
def _forecast(task: int) -> Left:
    return forecast(chosen(N_TWIN)[task], measures=("estimate",)).of("estimate", UPDATES)


def run(case: tuple[int, str], tally: Tally) -> Iterator[Row]:
    seed, effect = case
    number = JUDGED[seed % len(JUDGED)]
    yield {
        **{"effect": effect, "robot": number},
        **by_twin(robot(number, effect), tally),
        **by_estimate(robot(number, effect), tally),
    }


def by_twin(who: Drawn, tally: Tally) -> Row:
    """First runs by a twin: left (n,) over k = 0, inside its interval (n,), whether it was flagged,
    and the width of the interval over the first error (n,)."""
    cuts = chosen(N_TWIN)
    try:
        twin = commission(commissioning_cuts(who, MOST)).twin
    except ImplausibleError:
        nothing = np.ones(len(cuts))
        return twin_cells(nothing, nothing > 0.0, nothing > 0.0, nothing)
    errors, corrections, _ = first_runs(twin, who, cuts, tally)
    ahead = [each.prediction for each in corrections]
    low, high, first = np.array([(p.low, p.high, p.uncorrected) for p in ahead]).T
    left = errors / [left_alone(cut, who, tally) for cut in cuts]
    refused = np.array([not each.trusted for each in corrections])
    inside = ((low <= errors) & (errors <= high)) | refused
    return twin_cells(left, inside, refused, (high - low) / first)


def twin_cells(left: np.ndarray, inside: np.ndarray, flagged: np.ndarray, width: np.ndarray) -> Row:
    return {
        **{"twin: median left": float(np.median(left)), "twin: worst": float(left.max())},
        **{"twin: inside": float(inside.mean()), "twin: flagged": int(flagged.sum())},
        **{"_left": left, "_inside": inside, "_flagged": flagged, "_width": width},
    }


def by_estimate(who: Drawn, tally: Tally) -> Row:
    """The same of five updates from the estimate; one that is refused leaves the first run."""
    left, inside, flagged = list[float](), list[bool](), list[bool]()
    for task, cut in enumerate(chosen(N_LEARNED)):
        measure = measure_of("estimate")
        made = prepare(replace(cut, individual=who, imu=measure.imu), seed=who.number)
        try:
            runs = list(iterate(made, measure.prepare(made), UPDATES))
        except ImuError:
            left, inside, flagged = [*left, 1.0], [*inside, True], [*flagged, True]
            continue
        found = notes(made, runs)
        tally.add(found)
        left.append(runs[-1].tool_true.rms / runs[0].tool_true.rms)
        ahead = _forecast(task)
        inside.append(ahead.low <= left[-1] <= ahead.high)
        flagged.append(any(note.cause in FLAGS for note in found))
    return estimate_cells(np.array(left), np.array(inside), np.array(flagged))


def estimate_cells(left: np.ndarray, inside: np.ndarray, flagged: np.ndarray) -> Row:
    return {
        **{"estimate: median left": float(np.median(left)), "estimate: worst": float(left.max())},
        **{"forecast: inside": float(inside.mean()), "estimate: flagged": int(flagged.sum())},
        **{"_learned": left, "_foreseen": inside, "_noted": flagged},
    }


def checks(rows: Rows) -> Iterator[Check]:
    left, flagged = (np.concatenate([rows.joined(a), rows.joined(b)]) for a, b in (
        ("_left", "_learned"), ("_flagged", "_noted"),
    ))  # fmt: skip
    quiet = (left <= 1.0) | flagged.astype(bool)
    yield all_hold("nothing ends above k = 0 without a flag", quiet)
    each = rows.by("effect")
    usual = float(np.median(each[NONE].joined("_width"))) if NONE in each else np.inf
    for effect, own in each.items():
        if effect not in (NONE, EVERY):
            twin, learned = (float(np.median(own.joined(k))) for k in ("_left", "_learned"))
            yield Check("", f"{effect}: median left by the twin", "", twin, high=TWIN)
            yield Check("", f"{effect}: median left by the estimate", "", learned, high=ESTIMATE)
        if effect != NONE:
            wide = float(np.median(own.joined("_width"))) >= WIDER * usual
            inside = float(own.joined("_inside").mean())
            what = f"{effect}: in the twin's interval, or that is wider"
            yield Check("", what, "", 1.0 if wide else inside, low=COVERAGE)
            foreseen = float(own.joined("_foreseen").mean())
            yield Check("", f"{effect}: in the forecast interval", "", foreseen, low=COVERAGE)


CLAIM = Claim(
    title="Robots outside our physics: left of k = 0, and flags",
    seeds=len(JUDGED),
    cases=crossed(EFFECTS),
    run=run,
    checks=checks,
)
