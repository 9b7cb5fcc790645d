"""Over which robots, speeds and payloads the findings of chapter 9 hold: F07 and the map."""

from collections.abc import Callable, Sequence
from dataclasses import replace
from pathlib import Path

import numpy as np

from armside.sim.robot.effects import Effect

from ...jobs.store import Result
from ...learning_job import LearningJob
from ..report import Check, Grid, Part, Section
from . import bands, figures
from .bands import AT
from .sections import Read
from .table import POSES, laser

N_INDIVIDUALS = 100
MAP_SPEEDS = (20.0, 30.0, 40.0, 50.0, 60.0, 80.0)
MAP_PAYLOADS = (0.0, 40.0, 100.0, 175.0)
MAP_INDIVIDUALS = tuple(range(6))
ARM_BANDS = {"p1": (0.20, 0.50), "p3": (0.95, 1.6)}
"""Of the arm's RMS at k = 5 over k = 0, shown beside the distributions."""
_CUTS = {
    "p1": laser(pose="p1"),
    "p2": laser(pose="p2"),
    "p3": laser(pose="p3"),
    "p1, 15 Hz": laser(pose="p1", cutoff=15.0),
    "p1, delta 6": laser(pose="p1", delta=6),
    "p2, delta 6": laser(pose="p2", delta=6),
}
"""What one place on the map takes, beside its speed."""


def individuals(seed: int) -> Part:
    """F07: the default design on robots with their own stiffness, friction, phases, geometry."""
    jobs = {
        (pose, i): LearningJob(laser=laser(pose=pose), seed=seed, individual=seed + i, series=False)
        for pose in POSES
        for i in range(N_INDIVIDUALS)
    }

    def draw(read: Read, folder: Path) -> Section:
        results = {key: read(job) for key, job in jobs.items()}
        arm = {
            pose: np.array([_fall(results[pose, i], "arm_rms") for i in range(N_INDIVIDUALS)])
            for pose in POSES
        }
        worst = {
            pose: np.array(
                [
                    (results[pose, i]["motor_inf"][-1] / results[pose, i]["motor_inf"][0]).max()
                    for i in range(N_INDIVIDUALS)
                ]
            )
            for pose in POSES
        }
        diverged = sum(bool(result["diverged"]) for result in results.values())
        content = {f"{pose}: arm RMS, k = 5 over k = 0": arm[pose] for pose in POSES} | {
            f"{pose}: worst motor, k = 5 over k = 0": worst[pose] for pose in POSES
        }
        figures.distributions(
            folder / "F07.png",
            f"The default design on {N_INDIVIDUALS} robots",
            content,
            {f"{pose}: arm RMS, k = 5 over k = 0": band for pose, band in ARM_BANDS.items()},
        )
        ordered = float(((arm["p1"] < arm["p2"]) & (arm["p2"] < arm["p3"])).mean())
        percentiles = [0, 5, 25, 50, 75, 95, 100]
        return Section(
            id="F07",
            title=f"F07: robustness over {N_INDIVIDUALS} robot individuals",
            caption="Each robot draws its own friction and stiffness (10 %, every gear and hinge), "
            "phases of its gears and drives, and errors of its geometry (0.5 mm, 0.5 mrad): "
            "the design variables of the thesis stay. The controller knows none of this.",
            figures=["F07.png"],
            checks=[
                Check(
                    id="F07a",
                    statement="experiments that diverge, of all individuals and positions",
                    thesis="robots are individuals",
                    ours=float(diverged),
                    high=0.0,
                ),
                Check(
                    id="F07b",
                    statement="share of individuals whose tool improves to half or less at p1",
                    thesis="improves at p1",
                    ours=float((arm["p1"] <= 0.5).mean()),
                    low=0.5,
                ),
                Check(
                    id="F07c",
                    statement="share of individuals with p1 better than p2 and p2 than p3",
                    thesis="p1 best, p3 worst",
                    ours=ordered,
                    low=0.9,
                ),
            ],
            grids=[
                Grid(
                    title="Distribution",
                    columns=["", *(f"{p} %" for p in percentiles)],
                    rows=[
                        [name, *map(float, np.percentile(values, percentiles))]
                        for name, values in content.items()
                    ],
                )
            ],
        )

    return Part(list(jobs.values()), draw)


Phenomenon = tuple[str, Callable[[dict[str, Result]], float], float, float]
"""Name, value, and the band in which it is as in the thesis."""

PHENOMENA: tuple[Phenomenon, ...] = (
    ("motors, worst (9.5)", lambda r: bands.motor_side(r)[0].ours, -np.inf, 0.10),
    ("p1, RMS k5/k0", lambda r: _fall(r["p1"], "arm_rms"), 0.20, 0.50),
    (
        "p2, RMS k5/k1",
        lambda r: float(r["p2"]["arm_rms"][AT] / r["p2"]["arm_rms"][1]),
        0.95,
        np.inf,
    ),
    ("p3, RMS k5/k0", lambda r: _fall(r["p3"], "arm_rms"), 0.95, 1.6),
    ("p1, RMS 15/10 Hz", lambda r: _ratio(r, "p1, 15 Hz", "p1"), 1.05, np.inf),
    ("p1, RMS δ 6/3", lambda r: _ratio(r, "p1, delta 6", "p1"), -np.inf, 0.97),
    ("p2, RMS δ 6/3", lambda r: _ratio(r, "p2, delta 6", "p2"), -np.inf, 0.95),
)


def phenomena_map(seed: int) -> Part:
    """Each phenomenon over speed and payload, and over speed and individuals."""
    by_payload = {
        (payload, speed, name): LearningJob(
            laser=replace(cut, speed=speed), seed=seed, payload=payload, series=False
        )
        for payload in MAP_PAYLOADS
        for speed in MAP_SPEEDS
        for name, cut in _CUTS.items()
    }
    by_individual = {
        (i, speed, name): LearningJob(
            laser=replace(cut, speed=speed), seed=seed, individual=seed + i, series=False
        )
        for i in MAP_INDIVIDUALS
        for speed in MAP_SPEEDS
        for name, cut in _CUTS.items()
    }

    def draw(read: Read, folder: Path) -> Section:
        payloads = _fields(read, by_payload, MAP_PAYLOADS)
        robots = _fields(read, by_individual, MAP_INDIVIDUALS)
        speeds = [f"{speed:g}" for speed in MAP_SPEEDS]
        figures.fields(
            folder / "9-map-payload.png",
            "Where each finding holds: payload and speed",
            payloads,
            [f"{payload:g}" for payload in MAP_PAYLOADS],
            speeds,
            row_label="payload [kg]",
            column_label="speed [mm/s]",
        )
        figures.fields(
            folder / "9-map-individual.png",
            "Where each finding holds: robot and speed",
            robots,
            [f"{i}" for i in MAP_INDIVIDUALS],
            speeds,
            row_label="individual",
            column_label="speed [mm/s]",
        )
        rows = []
        for name in payloads:
            share = [float(found[name][1].mean()) for found in (payloads, robots)]
            at_40 = float(robots[name][1][:, MAP_SPEEDS.index(40.0)].mean())
            rows.append([name, *share, at_40])
        return Section(
            id="9-map",
            title="Where the findings of chapter 9 hold",
            caption="Every finding at every speed, with payloads from 0 to 175 kg which the "
            "controller knows, and on robots with friction, stiffness, phases and geometry of "
            "their own. Numbers are the values that the bands are about; colour says whether they "
            "are inside.",
            figures=["9-map-payload.png", "9-map-individual.png"],
            grids=[
                Grid(
                    title="Share of the map where a finding holds",
                    columns=["", "payloads x speeds", "robots x speeds", "robots at 40 mm/s"],
                    rows=rows,
                )
            ],
        )

    return Part([*by_payload.values(), *by_individual.values()], draw)


def effects(seed: int) -> Part:
    """Each finding with an effect of gears and drives left out, and with all of them."""
    names = tuple(effect.value for effect in Effect)
    left_out = {"nothing": (), **{name: (name,) for name in names}, "all of them": names}
    jobs = {
        (label, name): LearningJob(laser=replace(cut, without=without), seed=seed, series=False)
        for label, without in left_out.items()
        for name, cut in _CUTS.items()
    }

    def draw(read: Read, folder: Path) -> Section:
        rows = []
        for label in left_out:
            results = {name: read(jobs[label, name]) for name in _CUTS}
            values = [(value(results), low, high) for _, value, low, high in PHENOMENA]
            words = [
                f"{v:.3f}" if low <= v <= high else f"{v:.3f} (outside)" for v, low, high in values
            ]
            rows.append([label, *words])
        return Section(
            id="9-effects",
            title="What each effect of gears and drives does to the findings, 40 mm/s",
            caption="The same robot with one effect left out at a time. It is calibrated with all "
            "of them on: what leaves its band without an effect says what the effect is for, "
            "not that another calibration without it would be impossible.",
            grids=[
                Grid(
                    title="Findings by what is left out",
                    columns=["left out", *(f"{n}: {_band(lo, hi)}" for n, _, lo, hi in PHENOMENA)],
                    rows=rows,
                )
            ],
        )

    return Part(list(jobs.values()), draw)


def _fields(
    read: Read, jobs: dict, rows: Sequence[float]
) -> dict[str, tuple[np.ndarray, np.ndarray]]:
    """Value and verdict of each phenomenon, each of shape (rows, speeds)."""
    found = {name: np.empty((len(rows), len(MAP_SPEEDS))) for name, *_ in PHENOMENA}
    for i, row in enumerate(rows):
        for j, speed in enumerate(MAP_SPEEDS):
            results = {name: read(jobs[row, speed, name]) for name in _CUTS}
            for name, value, _, _ in PHENOMENA:
                found[name][i, j] = value(results)
    return {
        f"{name}: {_band(low, high)}": (found[name], (found[name] >= low) & (found[name] <= high))
        for name, _, low, high in PHENOMENA
    }


def _band(low: float, high: float) -> str:
    if np.isinf(low):
        return f"≤ {high:g}"
    return f"≥ {low:g}" if np.isinf(high) else f"{low:g} to {high:g}"


def _fall(result: Result, name: str) -> float:
    return float(result[name][-1] / result[name][0])


def _ratio(results: dict[str, Result], of: str, to: str) -> float:
    return float(results[of]["arm_rms"][AT] / results[to]["arm_rms"][AT])
