"""The claims of `armside verify first-cut`: unseen tasks cut right at the first run, by a twin.

Each seed is one of the judged individuals: `first_cut_tasks`. "Left" is the true tool RMS of the
first run with the twin's correction over that without any.
"""

import time
from collections.abc import Iterable, Sequence
from dataclasses import dataclass, field, replace

import numpy as np

from armside.arrays import Array
from armside.sim.cut.notes import motion_notes
from armside.sim.evaluation.check import Check, Table, all_hold
from armside.sim.instruments.imu import ImuCfg
from armside.sim.laser.experiment import prepare, true_tool_error
from armside.sim.laser.results import pass_notes
from armside.sim.laser.specification import Cut
from armside.sim.notes import Tally
from armside.sim.robot.spread import Drawn
from armside.sim.twin.commission import commission
from armside.sim.twin.correction import Corrected
from armside.sim.twin.drift import refreshed
from armside.sim.twin.measured import MeasuredCut, measured
from armside.sim.twin.plan import plan, recorded
from armside.sim.twin.twin import Twin

from ..jobs.workers import Workers
from .first_cut_tasks import GUARD_SEED, JUDGED, JUDGED_SEED, tasks, tasks_beyond

COUNTS = (10, 4, 2)
"""Cuts that a twin is commissioned from."""
N_TASKS, N_DRIFT, N_BEYOND, N_FEEDBACK = 30, 10, 30, 2
DRIFT = 0.10
BAD, GOOD = 0.30, 0.15
"""Left: a task that should have been flagged, and one that should not."""
COLUMNS = (
    *("individual", "hidden hinges"),
    *(f"{n} cuts: {what}" for n in COUNTS for what in ("median left", "worst left")),
    "worse than without",
    *(f"{n} cuts: inside the interval" for n in COUNTS),
    *("drift: median left", "with feedback"),
    *("bad ones flagged", "good ones flagged", "commissioning [s]", "correction [s]"),
)


@dataclass(frozen=True, eq=False)
class Found:
    """Results of one individual."""

    number: int
    hinges: int
    left: dict[int, Array]
    """(30,) by the count of cuts."""
    inside: dict[int, np.ndarray]
    """(n,) bool by the count of cuts: the error was in the predicted interval, of the n tasks that
    were corrected."""
    drift: Array
    feedback: Array
    """(10,), friction +10 %, without and with feedback."""
    beyond: Array
    flagged: np.ndarray
    """(n,) left beyond the commissioned range, and whether the twin was not trusted there."""
    seconds: float
    correction_seconds: float
    said: Tally = field(default_factory=Tally)
    """Notes of the runs of its tasks."""


def first_cut(seeds: Iterable[int]) -> Table:
    """Six individuals, three with hidden hinges; thirty unseen tasks each."""
    numbers = [JUDGED[seed % len(JUDGED)] for seed in seeds]
    with Workers() as workers:
        found = workers.map(individual, numbers)
    rows, said = [_row(one) for one in found], together(one.said for one in found)
    return Table("First cuts by a twin", COLUMNS, rows, verdicts(found), said.notes("runs"))


def together(tallies: Iterable[Tally]) -> Tally:
    """Notes of all individuals."""
    said = Tally()
    for tally in tallies:
        said.include(tally)
    return said


def individual(
    number: int,
    *,
    counts: Sequence[int] = COUNTS,
    n_tasks: int = N_TASKS,
    n_drift: int = N_DRIFT,
    n_beyond: int = N_BEYOND,
) -> Found:
    """Commission twins of one individual from several counts of cuts, and judge them."""
    robot, said = Drawn(number), Tally()
    cuts = commissioning_cuts(robot, max(counts))
    chosen = [cut for _, cut in tasks(n_tasks, JUDGED_SEED + number)]
    plain = [left_alone(cut, robot, said) for cut in chosen]
    started, twins = time.perf_counter(), dict[int, Twin]()
    seconds = 0.0
    for count in counts:
        twins[count] = commission(cuts[:count]).twin
        seconds = seconds or time.perf_counter() - started
    left, inside, took = dict[int, Array](), dict[int, np.ndarray](), list[float]()
    for count, twin in twins.items():
        errors, corrections, each = first_runs(twin, robot, chosen, said)
        took.extend(each)
        left[count], inside[count] = errors / plain, in_its_interval(errors, corrections)
    best = twins[max(counts)]
    drifted = [replace(cut, friction_drift=DRIFT) for cut in chosen[:n_drift]]
    without, feedback = _after_drift(best, robot, drifted, said)
    outside = tasks_beyond(n_beyond, GUARD_SEED + number)
    beyond, flagged = _beyond(best, robot, outside, said)
    hinges = len(robot.of(best.design.nominal or best.design.model).hidden)
    return Found(
        *(number, hinges, left, inside, without, feedback, beyond, flagged),
        *(seconds, float(np.median(took)), said),
    )


def first_runs(
    twin: Twin, robot: Drawn, cuts: Sequence[Cut], said: Tally
) -> tuple[Array, list[Corrected], list[float]]:
    """True tool RMS (n,) [m] of first runs, their corrections, and the seconds these took.

    Notes of the runs are counted, as by `left_alone`.
    """
    errors, corrections, seconds = list[float](), list[Corrected](), list[float]()
    for cut in cuts:
        began = time.perf_counter()
        corrections.append(twin.correction(cut))
        seconds.append(time.perf_counter() - began)
        errors.append(_error(cut, robot, corrections[-1].correction, said))
    return np.array(errors), corrections, seconds


def in_its_interval(errors: Array, corrections: Sequence[Corrected]) -> np.ndarray:
    """(m,) bool: errors (n,) [m] of first runs were in the interval, of the m that were corrected.

    Of the others no interval is printed.
    """
    ends = [(c.prediction.low, c.prediction.high) for c in corrections]
    low, high = np.reshape(ends, (-1, 2)).T
    inside = (low <= errors) & (errors <= high)
    return inside[[c.trusted for c in corrections]]


def commissioning_cuts(robot: Drawn, count: int, imu: ImuCfg | None = None) -> list[MeasuredCut]:
    """Recorded cuts of the plan, by an individual that may carry an IMU."""
    return [
        recorded(replace(cut, individual=robot, imu=imu), f"cut-{i + 1}", i)
        for i, cut in enumerate(plan(count))
    ]


def _error(cut: Cut, robot: Drawn, correction: Array | None, said: Tally) -> float:
    """True tool RMS [m] of a run, whose notes are counted."""
    experiment = prepare(replace(cut, individual=robot), seed=JUDGED_SEED)
    zero = np.zeros_like(experiment.loaded.reference)
    run = experiment.plant.run(zero if correction is None else correction)
    said.add(
        (*motion_notes(experiment.motion, experiment.cut.limits), *pass_notes(experiment, run))
    )
    return true_tool_error(experiment.motion, run).rms


def left_alone(cut: Cut, robot: Drawn, said: Tally) -> float:
    """True tool RMS [m] of a run without correction."""
    return _error(cut, robot, None, said)


def _after_drift(twin: Twin, robot: Drawn, cuts: Sequence[Cut], said: Tally) -> tuple[Array, Array]:
    """Left of cuts after friction has changed: by the old twin, and after feedback of two runs."""
    plain = np.array([left_alone(cut, robot, said) for cut in cuts])
    corrections = [twin.correction(cut).correction for cut in cuts]
    without = [_error(cut, robot, u, said) for cut, u in zip(cuts, corrections, strict=True)]
    production: list[MeasuredCut] = []
    for i in range(min(N_FEEDBACK, len(cuts))):
        experiment = prepare(replace(cuts[i], individual=robot), seed=JUDGED_SEED + i)
        production.append(measured(experiment.plant.run(corrections[i])))
    after = refreshed(twin, production).twin if production else twin
    again = [_error(cut, robot, after.correction(cut).correction, said) for cut in cuts]
    return np.array(without) / plain, np.array(again) / plain


def _beyond(twin: Twin, robot: Drawn, cuts: Sequence[Cut], said: Tally) -> tuple[Array, np.ndarray]:
    left, flagged = [], []
    for cut in cuts:
        corrected = twin.correction(cut)
        error = _error(cut, robot, corrected.learned, said)
        left.append(error / left_alone(cut, robot, said))
        flagged.append(not corrected.trusted)
    return np.array(left), np.array(flagged, dtype=bool)


def _row(found: Found) -> tuple[object, ...]:
    pairs = [(np.median(left), left.max()) for left in found.left.values()]
    bad, good = _bad(found), _good(found)
    return (
        found.number,
        found.hinges,
        *(float(value) for pair in pairs for value in pair),
        sum(int((left > 1.0).sum()) for left in found.left.values()),
        *(float(inside.mean()) for inside in found.inside.values()),
        float(np.median(found.drift)),
        float(np.median(found.feedback)),
        f"{int(found.flagged[bad].sum())} of {int(bad.sum())}",
        f"{int(found.flagged[good].sum())} of {int(good.sum())}",
        found.seconds,
        found.correction_seconds,
    )


def _bad(found: Found) -> np.ndarray:
    return ~(found.beyond <= BAD)  # NaN too


def _good(found: Found) -> np.ndarray:
    return found.beyond <= GOOD


def verdicts(found: Sequence[Found]) -> list[Check]:
    """Verdicts on all individuals together."""
    every = {n: np.concatenate([one.left[n] for one in found]) for n in COUNTS}
    better = np.concatenate([*every.values()]) <= 1.0
    inside = {n: np.concatenate([one.inside[n] for one in found]) for n in COUNTS}
    drift, feedback = (np.concatenate([getattr(one, x) for one in found]) for x in _DRIFTS)
    flagged = np.concatenate([one.flagged for one in found])
    bad, good = (np.concatenate([of(one) for one in found]) for of in (_bad, _good))
    return [
        Check("", "ten cuts: median left", "", float(np.median(every[10])), high=0.06),
        Check("", "ten cuts: worst left", "", float(every[10].max()), high=0.15),
        Check("", "four cuts: median left", "", float(np.median(every[4])), high=0.08),
        all_hold("no first cut is worse than without correction", better),
        Check("", "friction +10 %: median left", "", float(np.median(drift)), high=0.10),
        Check("", "with feedback of two cuts", "", float(np.median(feedback)), high=0.06),
        *(in_the_interval(f"{n} cuts: ", each) for n, each in inside.items()),
        Check("", f"flagged of tasks that end above {BAD:g}", "", _part(flagged, bad), low=0.9),
        Check("", f"flagged of tasks that end below {GOOD:g}", "", _part(flagged, good), high=0.1),
    ]


def in_the_interval(which: str, inside: np.ndarray) -> Check:
    """Verdict on errors (n,) bool, inside the predicted interval."""
    what, coverage = f"{which}errors inside the interval of 90 %", float(inside.mean())
    return Check("", what, "", coverage, low=0.85, high=0.95)


_DRIFTS = ("drift", "feedback")


def _part(flagged: np.ndarray, of: np.ndarray) -> float:
    return float(flagged[of].mean()) if of.any() else float("nan")
