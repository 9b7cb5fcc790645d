"""Unseen tasks cut right at the first run, by a twin: six individuals, three with hidden hinges.

Each seed is one of the judged individuals, with thirty tasks: `_tasks`. "Left" is the true tool RMS
of the first run with the twin's correction over that without any. `first-cut-imu`: twins that no
tracker has seen, commissioned from ten cuts by IMU and motors, and six other individuals.
"""

import time
from collections.abc import Iterator, Mapping, Sequence
from dataclasses import replace

import numpy as np

from armside.sim.instruments.imu import ImuCfg
from armside.sim.laser.experiment import prepare
from armside.sim.laser.specification import Cut
from armside.sim.robot.spread import Drawn
from armside.sim.twin.commission import MOST, commission
from armside.sim.twin.first_cut import refreshed
from armside.sim.twin.recordings import MeasuredCut, measured
from armside.sim.twin.twin import Twin

from ._engine import Check, Claim, Row, Rows, Tally, all_hold
from ._tasks import GUARD_SEED, JUDGED, JUDGED_BY_IMU, JUDGED_SEED, tasks, tasks_beyond
from ._twins import (
    commissioning_cuts,
    first_runs,
    hidden_hinges,
    in_its_interval,
    in_the_interval,
    left_alone,
    tool_rms,
)

COUNTS = (10, 4, 2)
"""Cuts that a twin is commissioned from."""
N_TASKS, N_DRIFT, N_BEYOND, N_FEEDBACK = 30, 10, 30, 2
DRIFT = 0.10
BAD, GOOD = 0.30, 0.15
"""Left: a task that should have been flagged, and one that should not."""


def run(seed: int, tally: Tally) -> Iterator[Row]:
    yield cells(individual(JUDGED[seed % len(JUDGED)], tally))


def individual(number: int, tally: Tally) -> Row:
    """Commission twins of one individual from several counts of cuts, and judge them.

    `left_N` (n,) and `inside_N` (those corrected,) by the count of cuts; `drift` and `feedback`
    (N_DRIFT,), friction +10 %, without and with feedback; `beyond` (N_BEYOND,) left beyond the
    commissioned range, and whether the twin was `flagged` there.
    """
    robot = Drawn(number)
    cuts = commissioning_cuts(robot, max(COUNTS))
    chosen = [cut for _, cut in tasks(N_TASKS, JUDGED_SEED + number)]
    plain = [left_alone(cut, robot, tally) for cut in chosen]
    started, twins, seconds = time.perf_counter(), dict[int, Twin](), 0.0
    for count in COUNTS:
        twins[count] = commission(cuts[:count]).twin
        seconds = seconds or time.perf_counter() - started
    found, took = dict[str, object](), list[float]()
    for count, twin in twins.items():
        errors, corrections, each = first_runs(twin, robot, chosen, tally)
        took.extend(each)
        found[f"left_{count}"] = errors / plain
        found[f"inside_{count}"] = in_its_interval(errors, corrections)
    best = twins[max(COUNTS)]
    drifted = [replace(cut, friction_drift=DRIFT) for cut in chosen[:N_DRIFT]]
    outside = tasks_beyond(N_BEYOND, GUARD_SEED + number)
    return {
        **{"number": number, "hinges": hidden_hinges(best, robot)},
        **found,
        **_after_drift(best, robot, drifted, tally),
        **_beyond(best, robot, outside, tally),
        **{"seconds": seconds, "correction_seconds": float(np.median(took))},
    }


def _after_drift(twin: Twin, robot: Drawn, cuts: Sequence[Cut], tally: Tally) -> Row:
    """Left of cuts after friction has changed: by the old twin, and after feedback of two runs."""
    plain = np.array([left_alone(cut, robot, tally) for cut in cuts])
    corrections = [twin.correction(cut).correction for cut in cuts]
    without = [tool_rms(cut, robot, u, tally) for cut, u in zip(cuts, corrections, strict=True)]
    production: list[MeasuredCut] = []
    for i in range(min(N_FEEDBACK, len(cuts))):
        experiment = prepare(replace(cuts[i], individual=robot), seed=JUDGED_SEED + i)
        production.append(measured(experiment.plant.run(corrections[i])))
    after = refreshed(twin, production).twin if production else twin
    again = [tool_rms(cut, robot, after.correction(cut).correction, tally) for cut in cuts]
    return {"drift": np.array(without) / plain, "feedback": np.array(again) / plain}


def _beyond(twin: Twin, robot: Drawn, cuts: Sequence[Cut], tally: Tally) -> Row:
    left, flagged = [], []
    for cut in cuts:
        corrected = twin.correction(cut)
        error = tool_rms(cut, robot, corrected.learned, tally)
        left.append(error / left_alone(cut, robot, tally))
        flagged.append(not corrected.trusted)
    return {"beyond": np.array(left), "flagged": np.array(flagged, dtype=bool)}


def cells(found: Row) -> Row:
    """The row of one individual, with its arrays for the checks."""
    left = {n: found[f"left_{n}"] for n in COUNTS}
    flagged, beyond = found["flagged"], found["beyond"]
    bad, good = _bad(beyond), _good(beyond)
    of_counts = {
        f"{n} cuts: {what} left": float(of(each))
        for n, each in left.items()
        for what, of in (("median", np.median), ("worst", np.max))
    }
    return {
        **{"individual": found["number"], "hidden hinges": found["hinges"]},
        **of_counts,
        "worse than without": sum(int((each > 1.0).sum()) for each in left.values()),
        **{f"{n} cuts: inside the interval": float(found[f"inside_{n}"].mean()) for n in COUNTS},
        "drift: median left": float(np.median(found["drift"])),
        "with feedback": float(np.median(found["feedback"])),
        "bad ones flagged": f"{int(flagged[bad].sum())} of {int(bad.sum())}",
        "good ones flagged": f"{int(flagged[good].sum())} of {int(good.sum())}",
        "commissioning [s]": found["seconds"],
        "correction [s]": found["correction_seconds"],
        **{f"_{key}": value for key, value in found.items() if isinstance(value, np.ndarray)},
    }


def _bad(beyond: np.ndarray) -> np.ndarray:
    return ~(beyond <= BAD)  # NaN too


def _good(beyond: np.ndarray) -> np.ndarray:
    return beyond <= GOOD


def checks(rows: Rows) -> Iterator[Check]:
    left: Mapping[int, np.ndarray] = {n: rows.joined(f"_left_{n}") for n in COUNTS}
    flagged, beyond = rows.joined("_flagged"), rows.joined("_beyond")
    medians = {n: float(np.median(each)) for n, each in left.items()}
    drift, feedback = (float(np.median(rows.joined(name))) for name in ("_drift", "_feedback"))
    yield Check("", "ten cuts: median left", "", medians[10], high=0.06)
    yield Check("", "ten cuts: worst left", "", float(left[10].max()), high=0.15)
    yield Check("", "four cuts: median left", "", medians[4], high=0.08)
    better = np.concatenate([*left.values()]) <= 1.0
    yield all_hold("no first cut is worse than without correction", better)
    yield Check("", "friction +10 %: median left", "", drift, high=0.10)
    yield Check("", "with feedback of two cuts", "", feedback, high=0.06)
    for n in COUNTS:
        yield in_the_interval(f"{n} cuts: ", rows.joined(f"_inside_{n}"))
    bad, good = _fraction(flagged, _bad(beyond)), _fraction(flagged, _good(beyond))
    yield Check("", f"flagged of tasks that end above {BAD:g}", "", bad, low=0.9)
    yield Check("", f"flagged of tasks that end below {GOOD:g}", "", good, high=0.1)


def _fraction(flagged: np.ndarray, of: np.ndarray) -> float:
    return float(flagged[of].mean()) if of.any() else float("nan")


CLAIM = Claim(title="First cuts by a twin", seeds=6, run=run, checks=checks)


def run_by_imu(seed: int, tally: Tally) -> Iterator[Row]:
    number = JUDGED_BY_IMU[seed % len(JUDGED_BY_IMU)]
    robot, chosen = Drawn(number), [cut for _, cut in tasks(N_TASKS, JUDGED_SEED + number)]
    cuts = commissioning_cuts(robot, MOST, ImuCfg())
    started = time.perf_counter()
    twin = commission(cuts, measure="imu").twin
    seconds = time.perf_counter() - started
    errors, corrections, _ = first_runs(twin, robot, chosen, tally)
    left = errors / [left_alone(cut, robot, tally) for cut in chosen]
    inside = in_its_interval(errors, corrections)
    yield cells_by_imu(number, hidden_hinges(twin, robot), left, inside, seconds)


def cells_by_imu(
    number: int, hinges: int, left: np.ndarray, inside: np.ndarray, seconds: float
) -> Row:
    """left: (n_tasks,). inside: (m,) bool, of the tasks that were corrected."""
    return {
        **{"individual": number, "hidden hinges": hinges},
        **{"median left": float(np.median(left)), "worst left": float(left.max())},
        "worse than without": int((left > 1.0).sum()),
        "inside the interval": float(inside.mean()),
        "commissioning [s]": seconds,
        **{"_left": left, "_inside": inside},
    }


def checks_by_imu(rows: Rows) -> Iterator[Check]:
    left = rows.joined("_left")
    yield Check("", "median left", "", float(np.median(left)), high=0.10)
    yield Check("", "worst left", "", float(left.max()), high=0.25)
    yield all_hold("no first cut is worse than without correction", left <= 1.0)
    yield in_the_interval("", rows.joined("_inside"))


CLAIM_IMU = Claim(
    title="First cuts by a twin, commissioned by IMU and motors",
    seeds=6,
    run=run_by_imu,
    checks=checks_by_imu,
)
