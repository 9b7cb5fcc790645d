"""Robots, speeds and payloads for which the findings of chapter 9 hold: F07 and the map."""

from collections.abc import Mapping
from itertools import product
from pathlib import Path
from typing import Any

import numpy as np
from numpy.typing import NDArray

from armside.sim.evaluation.check import Check, Table
from armside.sim.laser.job import LearningJob
from armside.sim.robot.effects import Effect

from ..report import Part, Read, Section
from . import bands, figures
from .bands import BANDS, POSES, Result, over_first
from .table import learning_job

N_INDIVIDUALS = 100
MAP_SPEEDS = (20.0, 30.0, 40.0, 50.0, 60.0, 80.0)
MAP_PAYLOADS = (0.0, 40.0, 100.0, 175.0)
MAP_INDIVIDUALS = tuple(range(6))
CUTS = {
    **{pose: {"pose": pose} for pose in POSES},
    "p1, 15 Hz": {"pose": "p1", "cutoff": 15.0},
    "p1, delta 6": {"pose": "p1", "delta": 6},
    "p2, delta 6": {"pose": "p2", "delta": 6},
}
"""Experiments of one point of the map, at its speed."""
PHENOMENA = {
    "a1": "motors, worst (9.5)",
    "b1": "p1, RMS k5/k0",
    "b3": "p2, RMS k5/k1",
    "b5": "p3, RMS k5/k0",
    "c1": "p1, RMS 15/10 Hz",
    "d1": "p1, RMS δ 6/3",
    "d2": "p2, RMS δ 6/3",
}
"""Checks of one point by their ids, in few words."""


def phenomena(results: Mapping[str, Result]) -> list[Check]:
    """The checks of `PHENOMENA` for the experiments of `CUTS`."""
    delta_6 = {pose: results[f"{pose}, delta 6"] for pose in ("p1", "p2")}
    cutoff = bands.cutoff_arm(results["p1"], results["p1, 15 Hz"])
    sides = [*bands.motor_side(results), *bands.arm_side(results)]
    checks = [*sides, *cutoff, *bands.shift_arm(results, delta_6)]
    return [check for check in checks if check.id in PHENOMENA]


def _heading(check: Check) -> str:
    return f"{PHENOMENA[check.id]}: {check.band}"


LITTLE = 0.95
"""Fraction of k = 0 from which on learning counts as no help to the tool."""


def individuals(seed: int) -> Part:
    """F07: the default design on robots with their own stiffness, friction, phases, geometry."""
    robots = range(N_INDIVIDUALS)
    jobs = {
        (pose, i): learning_job(seed, series=False, individual=seed + i, **CUTS[pose])
        for pose, i in product(POSES, robots)
    }

    def draw(read: Read, folder: Path) -> Section:
        results = {key: read(job) for key, job in jobs.items()}
        content = {
            f"{pose}: {what}, k = 5 over k = 0": np.array(
                [over_first(results[pose, i], name).max() for i in robots]
            )
            for what, name in (("arm RMS", "arm_rms"), ("worst motor", "motor_inf"))
            for pose in POSES
        }
        p1, p2, p3, *_ = content.values()
        bands = {
            f"{p}: arm RMS, k = 5 over k = 0": BANDS[id] for p, id in (("p1", "b1"), ("p3", "b5"))
        }
        title = f"The default design on {N_INDIVIDUALS} robots"
        figures.distributions(folder / "F07.png", title, content, bands)
        diverged = sum(bool(result["diverged"]) for result in results.values())
        improved, ordered = (p1 <= 0.5).mean(), ((p1 < p2) & (p2 < p3)).mean()
        helpless = (p3 >= LITTLE).sum()
        half = "fraction of individuals whose tool improves to half or less at p1"
        order = "fraction of individuals with p1 better than p2 and p2 than p3"
        all_of = "experiments that diverge, of all individuals and positions"
        little = f"of {N_INDIVIDUALS}, those whose tool stays at {LITTLE:g} or more of k = 0 at p3"
        percent = [0, 5, 25, 50, 75, 95, 100]
        rows = [[name, *np.percentile(all_, percent).tolist()] for name, all_ in content.items()]
        return Section(
            "F07",
            f"F07: robustness over {N_INDIVIDUALS} robot individuals",
            "Each robot draws its own friction and stiffness (10 %, every gear and hinge), phases "
            "of its gears and drives, and errors of its geometry (0.5 mm, 0.5 mrad): the design "
            "variables of the thesis stay. The controller assumes the nominal robot.",
            ["F07.png"],
            [
                Check("F07a", all_of, "", diverged, high=0.0),
                Check("F07b", half, "improves at p1", improved, low=0.5),
                Check("F07c", order, "p1 best, p3 worst", ordered, low=0.9),
                Check("F07d", little, BANDS["b5"].stated, helpless, low=N_INDIVIDUALS / 2),
            ],
            [Table("Distribution", ["", *(f"{p} %" for p in percent)], rows)],
        )

    return Part(list(jobs.values()), draw)


Jobs = Mapping[tuple[float, float, str], LearningJob]
"""By row of a map, speed [mm/s] and cut."""


def phenomena_map(seed: int) -> Part:
    """Each phenomenon over speed and payload, and over speed and individuals."""

    def jobs(rows: Mapping[float, Mapping[str, Any]]) -> Jobs:
        return {
            (row, speed, name): learning_job(seed, series=False, speed=speed, **cut, **options)
            for (row, options), speed, (name, cut) in product(
                rows.items(), MAP_SPEEDS, CUTS.items()
            )
        }

    by_payload = jobs({payload: {"payload": payload} for payload in MAP_PAYLOADS})
    by_individual = jobs({i: {"individual": seed + i} for i in MAP_INDIVIDUALS})

    def draw(read: Read, folder: Path) -> Section:
        label, title = "payload [kg]", "Where each finding holds: payload and speed"
        names, payloads = _map(read, by_payload, folder / "9-map-payload.png", title, label)
        label, title = "individual", "Where each finding holds: robot and speed"
        _, robots = _map(read, by_individual, folder / "9-map-individual.png", title, label)
        at_40 = robots[:, [MAP_SPEEDS.index(40.0)]]
        fractions = [inside.mean(axis=(0, 1)) for inside in (payloads, robots, at_40)]
        rows = [[n, *row] for n, row in zip(names, np.transpose(fractions).tolist(), strict=True)]
        columns = ["", "payloads x speeds", "robots x speeds", "robots at 40 mm/s"]
        return Section(
            "9-map",
            "Where the findings of chapter 9 hold",
            "Every finding at every speed, with payloads from 0 to 175 kg which the controller "
            "knows, and on robots with friction, stiffness, phases and geometry of their own. "
            "Numbers are the values that are compared with the bands; the colour shows whether "
            "they are inside.",
            ["9-map-payload.png", "9-map-individual.png"],
            tables=[Table("Fraction of the map where a finding holds", columns, rows)],
        )

    return Part([*by_payload.values(), *by_individual.values()], draw)


def _map(
    read: Read, jobs: Jobs, file: Path, title: str, row_label: str
) -> tuple[list[str], NDArray[np.bool_]]:
    """Draw one map; names of the phenomena, and where each holds, (rows, speeds, phenomena)."""
    rows = list(dict.fromkeys(row for row, _, _ in jobs))
    checks = [
        [phenomena({cut: read(jobs[row, speed, cut]) for cut in CUTS}) for speed in MAP_SPEEDS]
        for row in rows
    ]
    names = [_heading(check) for check in checks[0][0]]
    values = np.array([[[check.ours for check in cell] for cell in row] for row in checks])
    holds = np.array([[[check.holds for check in cell] for cell in row] for row in checks])
    ends = [(check.low, check.high) for check in checks[0][0]]
    content = {name: (values[..., i], holds[..., i], ends[i]) for i, name in enumerate(names)}
    ticks = ([f"{value:g}" for value in values] for values in (rows, MAP_SPEEDS))
    labels = {"row_label": row_label, "column_label": "speed [mm/s]"}
    figures.fields(file, title, content, *ticks, **labels)
    return names, holds


def effects(seed: int) -> Part:
    """Each finding with an effect of gears and drives left out, and with all of them."""
    left_out = {"nothing": (), **{e.value: (e,) for e in Effect}, "all of them": tuple(Effect)}
    jobs = {
        (label, name): learning_job(seed, series=False, without=without, **cut)
        for (label, without), (name, cut) in product(left_out.items(), CUTS.items())
    }

    def draw(read: Read, folder: Path) -> Section:
        found = {
            label: phenomena({name: read(jobs[label, name]) for name in CUTS}) for label in left_out
        }
        columns = ["left out", *map(_heading, found["nothing"])]
        rows = [
            [label, *(f"{c.ours:.3f}{'' if c.holds else ' (outside)'}" for c in checks)]
            for label, checks in found.items()
        ]
        return Section(
            "9-effects",
            "Findings without each effect of gears and drives, 40 mm/s",
            "The same robot with one effect left out at a time. It is calibrated with all of them "
            "on: a number that leaves its band without an effect shows the purpose of the effect, "
            "not that another calibration without it would be impossible.",
            tables=[Table("Findings by effect left out", columns, rows)],
        )

    return Part(list(jobs.values()), draw)
