"""What the estimate needs: variants of sensor, model and law compared.

Estimation error (3D RMS) of the first run, and the tool's deviation after five updates: medians
over seeds at each pose; structure and gears of linear springs. Learning is refused where no springs
make the model explain the readings; medians are those of the cuts that remain.
"""

from collections.abc import Iterator
from dataclasses import replace
from pathlib import Path
from typing import Any, NamedTuple

import numpy as np

from armside.arrays import Array
from armside.scripts.figures.canvas import COLORS, new_figure, save
from armside.sim.instruments.imu import ImuCfg, TriadCfg
from armside.sim.laser.results import notes
from armside.sim.laser.specification import Cut
from armside.sim.robot.effects import Effect

from ._engine import Check, Claim, Row, Rows, Table, Tally, all_hold, crossed
from ._estimates import (
    COMPARED,
    Case,
    ImuError,
    SpringPrior,
    ToolLawKind,
    ToolPath,
    kinematic_path,
    path_error,
    rigid_path,
    rms,
)
from ._learned import POSES

UPDATES = 5
DEFAULT = "identified (the default)"
KINEMATICS, NO_DYNAMICS = "motor-angle kinematics", "kinematic filter, no dynamics"
AVERAGED = "not identified, 4 runs averaged"
SILENCED = 1e3  # noise of a sensor that is excluded from the estimate, over its own


class Variant(NamedTuple):
    """Unit at the tool, measured output, and runs averaged in each iteration."""

    unit: ImuCfg
    measure: ToolPath = COMPARED
    repeats: int = 1


def variants() -> dict[str, Variant]:
    """Variants by name."""
    unit = ImuCfg()

    def noisy(factor: float) -> Variant:
        a, omega = (_louder(triad, factor) for triad in (unit.accelerometer, unit.gyroscope))
        return Variant(replace(unit, accelerometer=a, gyroscope=omega))

    def commissioned(**options: Any) -> ToolPath:
        return replace(COMPARED, commissioning=replace(COMPARED.commissioning, **options))

    def by_law(kind: ToolLawKind) -> ToolPath:
        return replace(COMPARED, law=replace(COMPARED.law, kind=kind))

    unknown = commissioned(identified=False, law_identified=False)
    no_clock = commissioned(prior=SpringPrior(clock=1e-7))
    deaf = replace(unit, accelerometer=_louder(unit.accelerometer, SILENCED))
    found = {
        DEFAULT: Variant(unit),
        "springs of gears only": Variant(unit, replace(COMPARED, structure=False)),
        "not identified": Variant(unit, unknown),
        AVERAGED: Variant(unit, unknown, repeats=4),
        "law from the wrong stiffness": Variant(unit, commissioned(law_identified=False)),
        "heuristic law": Variant(unit, by_law(ToolLawKind.HEURISTIC)),
        "norm-optimal law": Variant(unit, by_law(ToolLawKind.NORM_OPTIMAL)),
        # Gravity is then unobservable: its check must let everything pass.
        "gyro only": Variant(deaf, commissioned(prior=SpringPrior(mounting=1.0))),
        "accelerometer only": Variant(replace(unit, gyroscope=_louder(unit.gyroscope, SILENCED))),
        "noise / 8": noisy(1 / 8),
        "noise x 4": noisy(4.0),
    }
    for rate in (50.0, 250.0, 500.0):
        found[f"IMU at {rate:g} Hz"] = Variant(replace(unit, rate=rate))
    for limit in (0.0, 0.002, 0.005, 0.010):
        clock = replace(unit, clock_offset=limit)
        found[f"clock within {1e3 * limit:g} ms, not estimated"] = Variant(clock, no_clock)
    return found


def _louder(triad: TriadCfg, factor: float) -> TriadCfg:
    """A noisier triad, with a range that holds its noise."""
    range_ = triad.range * max(1.0, factor)
    return replace(triad, noise_density=factor * triad.noise_density, range=range_)


def run(case: tuple[int, str], tally: Tally) -> Iterator[Row]:
    """All variants on one robot at one pose; NaN where learning is refused or does not apply."""
    seed, pose = case
    tried, baselines = dict[str, tuple[float, float]](), dict[str, float]()
    for name, (unit, measure, repeats) in variants().items():
        cut = Cut(pose=pose, without=tuple(Effect), imu=unit)
        learning = Case(cut=cut, seed=seed)
        try:
            output, learned = learning.from_tool(UPDATES, measure, repeats=repeats)
            iterations = list(learned)
        except ImuError:
            tried[name] = np.nan, np.nan
            tally.add(())
            continue
        tally.add(notes(learning.experiment(), iterations))
        first, deviation = iterations[0].run, rms(iterations)
        tried[name] = path_error(output(first), first), deviation[-1] / deviation[0]
        if name == DEFAULT:
            baselines[KINEMATICS] = path_error(rigid_path(first), first)
            baselines[NO_DYNAMICS] = path_error(kinematic_path(output, unit, first), first)
    for name in (KINEMATICS, NO_DYNAMICS):
        yield cells(name, pose, baselines.get(name, np.nan), np.nan)
    for name, found in tried.items():
        yield cells(name, pose, *found)


def cells(name: str, pose: str, error: float, ratio: float) -> Row:
    """error: of the first run's path [m]. ratio: tool after `UPDATES` over that before."""
    return {"variant": name, "pose": pose, "error": error, "ratio": ratio}


def shown(rows: Rows) -> Iterator[Row]:
    for name, own in rows.by("variant").items():
        errors, ratios = medians(own)
        refused = int(np.isnan(own["error"]).sum())
        error = {f"{p}: error 3D [µm]": float(1e6 * e) for p, e in zip(POSES, errors, strict=True)}
        ratio = {f"{p}: k = 5 over k = 0": float(r) for p, r in zip(POSES, ratios, strict=True)}
        yield {"": name} | error | ratio | {"refused": f"{refused} of {len(own)}"}


def medians(rows: Rows) -> tuple[Array, Array]:
    """Error and ratio of one variant at the poses, (3,) each."""
    at = rows.by("pose").values()
    errors, ratios = (np.array([_median(own[name]) for own in at]) for name in ("error", "ratio"))
    return errors, ratios


def _median(values: Array) -> float:
    known = values[~np.isnan(values)]
    return float(np.median(known)) if len(known) else np.nan


def checks(rows: Rows) -> Iterator[Check]:
    by_name = rows.by("variant")
    errors, ratios = medians(by_name[DEFAULT])
    larger = "negative control: without dynamics errors are more than twice as large"
    yield all_hold(larger, medians(by_name[NO_DYNAMICS])[0] > 2.0 * errors)
    more = "negative control: without identification averaging runs leaves twice as much"
    yield all_hold(more, medians(by_name[AVERAGED])[1] > 2.0 * ratios)


def draw(file: Path, table: Table) -> None:
    """Error of the estimate by what it uses, largest first: a bar per variant and pose.

    Variants of the law or of averaging, whose estimate is that of an earlier row, are left out.
    """
    n = 1 + len(POSES)
    of_estimate = {tuple(row[1:n]): row for row in reversed(table.rows)}
    rows = sorted(of_estimate.values(), key=lambda row: -np.nanmean(row[1:n]))
    figure = new_figure(8.0, 0.34 * len(rows) + 0.9)
    axes = figure.subplots()
    figure.subplots_adjust(left=0.32, right=0.985, bottom=0.09, top=0.94)
    place = np.arange(len(rows))[::-1]
    for i, pose in enumerate(POSES):
        errors = [row[1 + i] for row in rows]
        axes.barh(place + 0.26 * (1 - i), errors, 0.24, color=COLORS[i], label=pose)
    axes.set_yticks(place, [str(row[0]) for row in rows])
    axes.set_xlabel("error of the tool's path, 3D RMS [µm]")
    axes.set_title("Error of the estimate by sensors and quality of the IMU", loc="left")
    axes.set_axisbelow(True)
    axes.grid(True, axis="x", color="#DDDDDD", lw=0.6)
    axes.set_ylim(-0.6, len(rows) - 0.4)
    axes.legend(frameon=False, fontsize=8, title="pose")
    save(figure, file)


CLAIM = Claim(
    title="What the estimate needs: error of the tool's path, and what learning leaves",
    seeds=10,
    cases=crossed(POSES),
    run=run,
    checks=checks,
    shown=shown,
    counted="learned cuts",
    figure=draw,
)
