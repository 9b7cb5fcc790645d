"""Robots that were not drawn from our physics, by twin, estimate, forecast and guard.

Each effect of `armside.sim.robot.alien` alone, all, and none, on three individuals each, which take
turns of twelve: all of them with all would be ten hours of a core. Of each, a twin of ten cuts,
first runs of `N_TWIN` unseen tasks by it, and learning of `N_LEARNED` of them from the estimate.
Nothing was chosen on an alien but that it runs (`DEVELOPMENT`). Flags are what a user without a
tracker has: a recording that commissioning refuses, a twin that is not trusted, an estimate that is
refused, notes of the IMU, and of the guard of what is learned from.

Bands, written down before the first judged run: nothing ends above k = 0 without a flag; with each
effect alone the median by the twin is at most 0.10 and by the estimate 0.12, what is refused
counted as left alone; with each effect and with all the intervals of twin and forecast hold 70 % of
what is not refused, however wide they are.

`aliens-known`: what it buys that a twin identifies a servo of its own and hysteresis of gears, and
that held-out residuals of no robot of the type widen its interval, by the same bands on other
robots. That was made on 8000 with five effects and on 8036 with a servo of its own, on the tasks of
seed 88, after the first two robots of each effect had been judged.
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

from ._engine import Check, Claim, Row, Rows, all_hold, at_least, at_most, crossed
from ._tasks import tasks
from ._twins import commissioning_cuts, first_runs, left_alone

DEVELOPMENT, JUDGED = (8000,), tuple(range(8001, 8013))
JUDGED_SEED, N_TWIN, N_LEARNED, UPDATES = 20261208, 6, 3, 5
NONE = "none"
EFFECTS = (NONE, *ALIEN, EVERY)
OF_EACH = 3
"""Individuals with each effect."""
OTHERS, OF_OTHERS = (*range(8013, 8019), *range(8025, 8029)), 2
"""Of 8019 and 8020 a servo without a factor of the rigid torque, and with the steps of one, left
0.12 and 0.59, and of 8021 all effects 0.57; both came after, from 8000 and 8036."""
KNOWN = ("hysteresis", "hose", "soft-floor", "own-servo", EVERY)
"""Effects by which a twin or its interval failed, and individuals with each."""
TWIN, ESTIMATE, COVERAGE = 0.10, 0.12, 0.70
FLAGS = {Cause.IMU, Cause.GUARD}
"""Not `Cause.TOOL`: that is the tracker's own error, which a user may not have."""


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
    number = JUDGED[(OF_EACH * EFFECTS.index(effect) + seed) % len(JUDGED)]
    yield {
        **{"effect": effect, "robot": number},
        **by_twin(robot(number, effect), tally),
        **by_estimate(robot(number, effect), tally),
    }


def by_twin(who: Drawn, tally: Tally) -> Row:
    """First runs by a twin: left (n,) over k = 0, inside its interval (n,), and whether it was
    refused."""
    cuts = chosen(N_TWIN)
    try:
        twin = commission(commissioning_cuts(who, MOST)).twin
    except ImplausibleError:
        nothing = np.ones(len(cuts))
        return twin_cells(nothing, nothing < 0.0, nothing > 0.0)
    errors, corrections, _ = first_runs(twin, who, cuts, tally)
    ahead = [each.prediction for each in corrections]
    low, high = np.array([(p.low, p.high) for p in ahead]).T
    left = errors / [left_alone(cut, who, tally) for cut in cuts]
    refused = np.array([not each.trusted for each in corrections])
    return twin_cells(left, (low <= errors) & (errors <= high), refused)


def twin_cells(left: np.ndarray, inside: np.ndarray, refused: np.ndarray) -> Row:
    return {
        **{"twin: median left": float(np.median(left)), "twin: worst": float(left.max())},
        **{"twin: inside": int(inside[~refused].sum()), "twin: refused": int(refused.sum())},
        **{"_left": left, "_inside": inside, "_refused": refused},
    }


def by_estimate(who: Drawn, tally: Tally) -> Row:
    """The same of five updates from the estimate; one that is refused leaves the first run."""
    left, inside, flagged, refused = list[float](), list[bool](), list[bool](), list[bool]()
    for task, cut in enumerate(chosen(N_LEARNED)):
        measure = measure_of("estimate")
        made = prepare(replace(cut, individual=who, imu=measure.imu), seed=who.number)
        try:
            runs = list(iterate(made, measure.prepare(made), UPDATES))
        except ImuError:
            left, inside = [*left, 1.0], [*inside, False]
            flagged, refused = [*flagged, True], [*refused, True]
            continue
        found = notes(made, runs)
        tally.add(found)
        left.append(runs[-1].tool_true.rms / runs[0].tool_true.rms)
        ahead = _forecast(task)
        inside.append(ahead.low <= left[-1] <= ahead.high)
        flagged.append(any(note.cause in FLAGS for note in found))
        refused.append(False)
    return estimate_cells(*(np.array(each) for each in (left, inside, flagged, refused)))


def estimate_cells(
    left: np.ndarray, inside: np.ndarray, flagged: np.ndarray, refused: np.ndarray
) -> Row:
    return {
        **{"estimate: median left": float(np.median(left)), "estimate: worst": float(left.max())},
        **{
            "forecast: inside": int(inside[~refused].sum()),
            "estimate: flagged": int(flagged.sum()),
        },
        **{"estimate: refused": int(refused.sum()), "_unlearned": refused},
        **{"_learned": left, "_foreseen": inside, "_noted": flagged},
    }


def checks(rows: Rows) -> Iterator[Check]:
    left, flagged = (np.concatenate([rows.joined(a), rows.joined(b)]) for a, b in (
        ("_left", "_learned"), ("_refused", "_noted"),
    ))  # fmt: skip
    quiet = (left <= 1.0) | flagged.astype(bool)
    yield all_hold("nothing ends above k = 0 without a flag", quiet)
    for effect, own in rows.by("effect").items():
        if effect not in (NONE, EVERY):
            twin, learned = (float(np.median(own.joined(k))) for k in ("_left", "_learned"))
            yield at_most(f"{effect}: median left by the twin", twin, TWIN)
            yield at_most(f"{effect}: median left by the estimate", learned, ESTIMATE)
        if effect != NONE:
            yield from _covered(f"{effect}: in the twin's interval", own, "_inside", "_refused")
            what = f"{effect}: in the forecast interval"
            yield from _covered(what, own, "_foreseen", "_unlearned")


def _covered(what: str, rows: Rows, inside: str, refused: str) -> Iterator[Check]:
    """Of what was not refused; with nothing left there is no statement."""
    used = ~rows.joined(refused)
    if used.any():
        of = f"{what}, of {used.sum()} of {len(used)} not refused"
        yield at_least(of, float(rows.joined(inside)[used].mean()), COVERAGE)


def run_known(case: tuple[int, str], tally: Tally) -> Iterator[Row]:
    seed, effect = case
    number = OTHERS[(OF_OTHERS * KNOWN.index(effect) + seed) % len(OTHERS)]
    yield {"effect": effect, "robot": number, **by_twin(robot(number, effect), tally)}


def checks_known(rows: Rows) -> Iterator[Check]:
    quiet = (rows.joined("_left") <= 1.0) | rows.joined("_refused")
    yield all_hold("nothing ends above k = 0 without a flag", quiet)
    for effect, own in rows.by("effect").items():
        if effect != EVERY:
            left = float(np.median(own.joined("_left")))
            yield at_most(f"{effect}: median left by the twin", left, TWIN)
        yield from _covered(f"{effect}: in the twin's interval", own, "_inside", "_refused")


CLAIM_KNOWN = Claim(
    title="Other such robots, of which a twin knows a servo of its own and hysteresis",
    seeds=OF_OTHERS,
    cases=crossed(KNOWN),
    run=run_known,
    checks=checks_known,
)
CLAIM = Claim(
    title="Robots outside our physics: left of k = 0, and flags",
    seeds=OF_EACH,
    cases=crossed(EFFECTS),
    run=run,
    checks=checks,
)
