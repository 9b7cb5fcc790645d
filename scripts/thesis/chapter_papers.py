"""Sections of the report on papers with measurements of others: docs/papers.md.

Bands and individuals are stated in `paper_bands`; a section takes medians over those of judgement.
"""

from collections.abc import Callable, Mapping, Sequence
from functools import partial
from pathlib import Path
from typing import Any

import numpy as np
from matplotlib.colors import TABLEAU_COLORS

from armside.arrays import Array
from armside.ilc.bench_study import ERRORS, ESTIMATES, LAWS, BenchEstimation, BenchLearning
from armside.sim.evaluation.check import Check, Table
from armside.sim.laser.strokes import StrokesJob
from armside.sim.papers.tool_estimates import ESTIMATES as TOOL_ESTIMATES
from armside.sim.papers.tool_estimates import ToolEstimates
from armside.sim.papers.two_stage import TwoStageJob
from armside.sim.papers.unseen import TESTED, TRAINED, UnseenEdge, UnseenSpeed

from ..figures.canvas import logarithmic, panels
from ..jobs.store import Result
from .paper_bands import BANDS, JUDGEMENT
from .report import Entry, Part, Read, Section

PRINTED = {"reference": (0.026, 0.059), "torque M": (0.058, 0.128), "torque L": (0.012, 0.038)}
"""T1: RMS of run 10 [mrad] with the right model and with that which is wrong by 15 %."""
CLEAR = 1.2
"""Torque M over reference alone, from which on their order is no noise of the floor."""
LEAST_STEP = 0.1
"""Of the error without learning, which a step must take off to be shared in. ESTIMATE"""
SHOWN = "k + 15 %, Jl - 15 %"
"""Wrong model that is drawn."""
PRINTED_T3 = {"torsion": 0.327, "dkf": 0.116, "dkf acc": 0.116, "kkf": 0.105, "kkf acc": 0.181}
"""T3, chirp [mrad]; DKF 20 % off: 0.199."""


def bench(read: Read, folder: Path) -> Section:
    """T1's bench: ten runs of each law with a right and six wrong models."""
    found = {
        (error, law): np.array([read(BenchLearning(seed, error))[law] for seed in JUDGEMENT])
        for error in ERRORS
        for law in LAWS
    }
    median = {key: np.median(runs, axis=0) for key, runs in found.items()}
    first = median["right", "reference"][0]
    last = {key: runs[-1, 0] for key, runs in median.items()}
    wrong = [error for error in ERRORS if error != "right"]
    ordered = [e for e in wrong if last[e, "torque M"] > last[e, "reference"] > last[e, "torque L"]]
    load = max(last[e, "torque L"] / median[e, "torque L"][0, 0] for e in wrong)
    clear = [e for e in ordered if last[e, "torque M"] > CLEAR * last[e, "reference"]]
    agree = (
        f"it holds for {len(ordered)} of them, clear of the floor of a third of a count for "
        f"{', '.join(clear) or 'none'}; the error of the paper is not printed"
    )
    checks = [
        *_checks({"bench-first": first[0], "bench-first-peak": first[1]}),
        *_checks({"bench-ten": max(last["right", law] for law in LAWS)}),
        BANDS["bench-wrong"].check("bench-wrong", len(wrong) - len(ordered), agree),
        *_checks({"bench-wrong-load": load}),
    ]
    rows = [
        [error, *(round(float(v), 3) for v in median[error, "reference"][0])]
        + [round(float(last[error, law]), 3) for law in LAWS]
        for error in ERRORS
    ]
    rows += [
        [f"paper, {name}", *first, *(p[i] for p in PRINTED.values())]
        for i, (name, first) in enumerate(
            {"right": (0.354, 0.91), "15 % wrong": (0.257, 1.07)}.items()
        )
    ]
    head = ["model", "first RMS", "first peak", *(f"run 10, {law}" for law in LAWS)]
    with panels(folder / "papers-bench.png", (8.0, 3.2), 1, 2, sharey=True) as axes:
        for axis, error in zip(axes, ("right", SHOWN), strict=True):
            for law, color in zip(LAWS, TABLEAU_COLORS, strict=False):
                axis.plot(range(1, 11), median[error, law][:, 0], ".-", color=color, label=law)
            axis.set(title=f"model: {error}", xlabel="run", ylabel="load error, RMS [mrad]")
            logarithmic(axis)
        axes[0].legend()
    caption = "Load error of the one-axis bench, RMS over 0.3 to 4.2 s, medians of ten individuals."
    table = Table("Load error [mrad]", head, rows)
    return _section("papers-bench", "T1, bench: two-stage learning", caption, checks, table)


def estimators(read: Read, folder: Path) -> Section:
    """T3: load angle by two Kalman filters on the bench."""
    runs = [read(BenchEstimation(seed)) for seed in JUDGEMENT]
    found = {name: np.array([float(run[name]) for run in runs]) for name in ESTIMATES}
    off = np.maximum(found["dkf k - 20 %"], found["dkf k + 20 %"]) / found["dkf"]
    kkf = np.median(found["kkf"] / found["kkf acc"])
    checks = _checks({"T3-dkf": np.median(off), "T3-kkf": kkf})
    rows = [
        [name, PRINTED_T3.get(name, 0.199), *(round(float(f(found[name])), 3) for f in SPREAD)]
        for name in ESTIMATES
    ]
    _by_individual(found, folder / "papers-estimators.png", "load angle, RMS error [mrad]")
    caption = (
        "Error of the load angle on a chirp in open loop against the load encoder. R is not "
        "adapted: the window of the paper is not printed."
    )
    table = Table("RMS [mrad]", ["estimate", "paper", "median", "least", "most"], rows)
    return _section("papers-estimators", "T3: estimators on the bench", caption, checks, table)


M16IB = "m16ib_like.toml"
T1 = {
    "T1-acceleration-motor": ("motor", "acceleration_rms"),
    "T1-acceleration-load": ("estimate", "acceleration_rms"),
    "T1-tcp": ("estimate", "tcp_rms"),
    "T1-rest": ("motor", "rest_acceleration_rms"),
    "T1-peak": ("estimate", "tcp_peak"),
    "T1-peak-motor": ("motor", "tcp_peak"),
}
"""Measured output and field of each check: median of the last run over the first."""
MEASURES = ("motor", "estimate", "tracker")
SHOWN_FIELDS = (
    *("tcp_rms", "tcp_rms_less_rest", "tcp_peak", "acceleration_rms"),
    *("moving_acceleration_rms", "rest_acceleration_rms", "contour_acceleration_rms"),
)


TWO_STAGE = {
    "T1-two-stage-motor": ("motor", "acceleration_rms"),
    "T1-two-stage-load": ("load", "acceleration_rms"),
    "T1-two-stage-tcp": ("load", "tcp_rms"),
    "T1-two-stage-peak": ("load", "tcp_peak"),
    "T1-two-stage-rest": ("motor", "rest_acceleration_rms"),
}


def square(robot: str, suffix: str, read: Read, folder: Path) -> Section:
    """T1: square of four strokes on one robot, by motors, estimate and tracker."""
    runs = {m: [read(StrokesJob(robot, m, seed)) for seed in JUDGEMENT] for m in MEASURES}
    by_motors, by_estimate = (_over_first(runs[m], "tcp_rms")[:, -1] for m in ("motor", "estimate"))
    order = _checks({"T1-tcp-order": np.sum(~(by_estimate < by_motors))}, suffix)
    speed = float(np.median([run["reached_speed"] for run in runs["motor"]]))
    caption = (
        f"Square of 100 mm, four strokes from rest to rest, 12.5 m/s^2, {speed:.2f} m/s reached; "
        f"medians of {len(JUDGEMENT)} individuals."
    )
    title = f"T1: square on the {'large robot' if suffix else 'M16iB-like arm'}"
    checks = [*_judged(T1, runs, suffix), *order]
    return _learning(f"papers-square{suffix}", title, caption, checks, runs, folder)


def two_stage(read: Read, folder: Path) -> Section:
    """T1's own law on the M16iB-like arm: reference and torque ILC, load or motor side."""
    runs = {
        side: [read(TwoStageJob(M16IB, side, seed)) for seed in JUDGEMENT]
        for side in ("load", "motor")
    }
    caption = (
        "The law of the paper, reference and torque, gains and adaptation as printed; load angles "
        "by the estimator of T2. Medians of ten individuals."
    )
    title, checks = "T1: two-stage law on the M16iB-like arm", _judged(TWO_STAGE, runs)
    return _learning("papers-two-stage", title, caption, checks, runs, folder)


def _over_first(runs: Sequence[Result], field: str) -> Array:
    """(individuals, runs), a measure over that of the first run; infinite once a robot is stopped:
    its estimate was refused, or it ran into a limit."""
    found = np.array([run[field] for run in runs])
    return np.nan_to_num(found / found[:, :1], nan=np.inf)


def _judged(
    what: Mapping[str, tuple[str, str]], runs: Mapping[str, Sequence[Result]], suffix: str = ""
) -> list[Check]:
    last = {id: np.median(_over_first(runs[of], field)[:, -1]) for id, (of, field) in what.items()}
    return _checks(last, suffix)


def _learning(
    id: str,
    title: str,
    caption: str,
    checks: Sequence[Check],
    runs: Mapping[str, Sequence[Result]],
    folder: Path,
) -> Section:
    """Section of runs that were learned from several outputs, each by all individuals."""
    for name, of in runs.items():
        if stopped := int(np.isinf(_over_first(of, "tcp_rms")[:, -1]).sum()):
            caption += f" Stopped before the last run by {name}, counted as the worst: {stopped}."
    rows = []
    for field in SHOWN_FIELDS:
        first = float(np.median([run[field][0] for run in next(iter(runs.values()))]))
        last = (float(np.median(_over_first(of, field)[:, -1])) for of in runs.values())
        scale = 1e3 if "tcp" in field else 1.0
        rows.append([field, scale * first, *(round(ratio, 3) for ratio in last)])
    with panels(folder / f"{id}.png", (9.0, 3.2), 1, 3) as axes:
        titles = ("acceleration_rms", "tcp_rms", "tcp_rms_less_rest")
        for axis, field in zip(axes, titles, strict=True):
            for (name, of), color in zip(runs.items(), TABLEAU_COLORS, strict=False):
                axis.plot(np.median(_over_first(of, field), axis=0), ".-", color=color, label=name)
            axis.set(title=field, xlabel="k", ylabel="over k = 0", ylim=0)
        axes[0].legend()
    head = ["measure", "first [mm, m/s^2]", *(f"last / first, {name}" for name in runs)]
    return _section(id, title, caption, checks, Table("Motion errors", head, rows))


PRINTED_T2 = {
    "motor": 0.737,
    "smoother": 0.306,
    "online": 0.409,
    "smoother doubled": 0.390,
    "online doubled": 0.498,
}
"""T2: RMS [mm] of the position."""
SHOWN_T2 = (*TOOL_ESTIMATES, *(f"{name} doubled" for name in TOOL_ESTIMATES[1:]))


def tool(read: Read, folder: Path) -> Section:
    """T2: tool position by their estimator and by ours, on the strokes of T1."""
    runs, drawn = (
        [read(ToolEstimates(M16IB, seed, geometry)) for seed in JUDGEMENT]
        for geometry in (False, True)
    )
    found = {name: np.array([run[name] for run in runs]) for name in SHOWN_T2}
    known = {name: np.nan_to_num(errors, nan=np.inf) for name, errors in found.items()}

    def over(name: str, base: str = "motor") -> float:
        """At the stop, median of the ratios, infinite where an estimate was refused."""
        return float(np.median(known[name][:, 0] / known[base][:, 0]))

    ours = {"smoother": over("smoother"), "online": over("online")}
    ours |= {"doubled": over("smoother doubled")}
    ours |= {"doubled-loss": over("smoother doubled", "smoother")}
    uncalibrated = {
        name: round(1e3 * float(np.median([run[name][0] for run in drawn])), 3) for name in drawn[0]
    }
    rows = [
        [name, PRINTED_T2.get(name), round(over(name), 3), uncalibrated.get(name)]
        + [round(float(v), 3) for v in 1e3 * np.median(known[name], axis=0)]
        for name in SHOWN_T2
    ]
    with panels(folder / "papers-tool.png", (6.0, 3.2)) as (axis,):
        for name, color in zip(SHOWN_T2, TABLEAU_COLORS, strict=False):
            axis.plot(JUDGEMENT, 1e3 * known[name][:, 0], ".-", color=color, label=name)
        axis.set(xlabel="individual", ylabel="tool position, RMS error [mm]")
        logarithmic(axis)
        axis.legend(loc="upper left", bbox_to_anchor=(1, 1))
    refused = int(np.isinf(known["ours"][:, 0]).sum())
    caption = (
        "Error of the tool's position at the third stop of the square on the M16iB-like arm, "
        "static part in; geometry as designed. Theirs has the arm's exact nominal stiffness, where "
        "the two-stage law of T1 knows it to +-30 %; ours identifies its springs from the same "
        f"run. Refused by ours: {refused} of {len(runs)}."
    )
    head = ["estimate", "paper", "over motor angles", "stop, geometry as drawn", "stop"]
    table = Table("RMS [mm], medians", [*head, "whole record", "whole, less rest"], rows)
    checks = _checks({f"T2-{name}": value for name, value in ours.items()})
    return _section("papers-tool", "T2: tool from an accelerometer", caption, checks, table)


def edge(read: Read, folder: Path) -> Section:
    """L1: first run on an edge that no twin was commissioned on, with 210 kg."""
    runs = [read(UnseenEdge(seed)) for seed in JUDGEMENT]
    names = {"L1": "position", "L1-peak": "peak", "L1-acceleration": "acceleration"}
    left = {
        id: np.array([float(run[name][1] / run[name][0]) for run in runs])
        for id, name in names.items()
    }
    rows = []
    for id, name in names.items():
        first = float(np.median([run[name][0] for run in runs]))
        each = (round(float(f(left[id])), 3) for f in SPREAD)
        rows.append([name, *each, first if name == "acceleration" else 1e3 * first])
    _by_individual(left, folder / "papers-edge.png", "unseen edge over uncorrected")
    limits = int(max(run["limits"].max() for run in runs))
    caption = (
        f"Strokes of 0.1 m with 210 kg on the large robot, {float(runs[0]['speed']):.2f} m/s "
        f"reached; signed error along the path, less its mean over the record. "
        f"Limits reached in a run: {limits} at most."
    )
    head = ["error along the path", "median", "least", "most", "uncorrected [mm, m/s^2]"]
    checks = _checks({id: np.median(ratios) for id, ratios in left.items()})
    title = "L1: an edge that was not trained"
    return _section("papers-edge", title, caption, checks, Table("Left", head, rows))


def speeds(read: Read, folder: Path) -> Section:
    """N1: first run of a line at speeds that no twin was commissioned on."""
    runs = [read(UnseenSpeed(seed)) for seed in JUDGEMENT]
    share = np.array([step_share(run) for run in runs])
    rows = [
        [f"{speed:g} m/s", *(round(float(f(share[:, i])), 3) for f in SPREAD)]
        + [1e3 * float(np.median([run[n][i] for run in runs])) for n in ("basic", "twin", "step")]
        for i, speed in enumerate(TESTED)
    ]
    found = {f"{speed:g} m/s": share[:, i] for i, speed in enumerate(TESTED)}
    _by_individual(found, folder / "papers-speeds.png", "share of one learning step")
    trained = ", ".join(f"{speed:g}" for speed in TRAINED)
    caption = (
        f"A line of 80 cm in x on the large robot; the twin is of its runs at {trained} m/s. The "
        "step is one update by our estimate. Tool position while it moves; negative is worse than "
        "without, and a step that takes off less than a tenth is no step to share in."
    )
    head = ["speed", "median", "least", "most", "without [mm]", "twin [mm]", "one step [mm]"]
    checks = _checks({"N1": np.median(share)})
    title = "N1: speeds that were not trained"
    return _section("papers-speeds", title, caption, checks, Table("Share", head, rows))


def step_share(run: Result) -> Array:
    """By speed, what the twin takes off over what one learning step does, negative where it adds.

    None, 0, where that step takes off less than `LEAST_STEP`, or adds.
    """
    gained, step = run["basic"] - run["twin"], run["basic"] - run["step"]
    clear = step > LEAST_STEP * run["basic"]
    return np.where(clear, gained / np.where(clear, step, 1.0), np.minimum(gained, 0.0))


def _by_individual(found: Mapping[str, Array], file: Path, label: str) -> None:
    with panels(file, (6.0, 3.2)) as (axis,):
        for (name, values), color in zip(found.items(), TABLEAU_COLORS, strict=False):
            axis.plot(JUDGEMENT, values, ".-", color=color, label=name)
        axis.set(xlabel="individual", ylabel=label)
        if all(np.nanmin(values, initial=0.0) >= 0.0 for values in found.values()):
            axis.set_ylim(bottom=0.0)
        axis.legend(loc="upper left", bbox_to_anchor=(1, 1))


SPREAD: Sequence[Callable[[Array], float]] = (np.median, np.min, np.max)


def _checks(ours: Mapping[str, Any], suffix: str = "") -> list[Check]:
    """Numbers by the id of their band."""
    return [BANDS[id].check(f"{id}{suffix}", value) for id, value in ours.items()]


def _section(id: str, title: str, caption: str, checks: Sequence[Check], table: Table) -> Section:
    return Section(id, title, caption, [f"{id}.png"], checks, [table], source="paper")


PARTS = {
    "papers-bench": Part([BenchLearning(s, e) for s in JUDGEMENT for e in ERRORS], bench),
    "papers-estimators": Part([BenchEstimation(s) for s in JUDGEMENT], estimators),
    **{
        f"papers-square{suffix}": Part(
            [StrokesJob(robot, m, s) for m in MEASURES for s in JUDGEMENT],
            partial(square, robot, suffix),
        )
        for robot, suffix in ((M16IB, ""), ("large", "-large"))
    },
    "papers-two-stage": Part(
        [TwoStageJob(M16IB, side, s) for side in ("load", "motor") for s in JUDGEMENT], two_stage
    ),
    "papers-tool": Part(
        [ToolEstimates(M16IB, s, geometry) for s in JUDGEMENT for geometry in (False, True)], tool
    ),
    "papers-edge": Part([UnseenEdge(s) for s in JUDGEMENT], edge),
    "papers-speeds": Part([UnseenSpeed(s) for s in JUDGEMENT], speeds),
}
ENTRIES = [Entry(id, lambda _, part=part: part) for id, part in PARTS.items()]
"""Sections in the order of the report."""
