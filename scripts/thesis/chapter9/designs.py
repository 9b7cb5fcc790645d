"""Beyond chapter 9: design variables for each motor (F08), friction feedforward (F09)."""

from collections.abc import Mapping
from dataclasses import replace
from pathlib import Path
from typing import Any

import numpy as np

from armside.arrays import Array
from armside.ilc.analysis.proposal import Proposal, design_for
from armside.ilc.identification.first_order_lag import FirstOrderModel
from armside.sim.evaluation.check import Check, Table

from ...jobs.store import Job
from ..report import Part, Read, Section
from . import figures
from .bands import AT, POSES, SPEEDS, Result, identify, over
from .table import STUDIES, learning_job

CUTOFFS = (6.0, 8.0, 10.0, 12.0, 15.0)
"""[Hz], offered to each motor; the highest one with a fast enough design is taken."""
FED_FORWARD = 0.8
"""Fraction of the Coulomb friction; all of it would overcompensate robots with less."""


def per_motor(seed: int) -> Part:
    """F08: gain, shift and cutoff of each motor from its own identified model, at p1."""
    base = STUDIES["operating point"].jobs(seed)
    data = STUDIES["identification"].jobs(seed)

    def designed(read: Read) -> tuple[list[FirstOrderModel], list[Proposal], dict[str, Job]]:
        results = {v: read(data["p1", v]) for v in SPEEDS}
        models = [identify(results, (motor,)) for motor in range(6)]
        designs = [design_for(m.system, CUTOFFS, fit=m.fit) for m in models]
        tuned: dict[str, Any] = {"gamma": tuple(round(d.gamma, 3) for d in designs)}
        tuned |= {name: tuple(getattr(d, name) for d in designs) for name in ("delta", "cutoff")}
        return models, designs, {p: learning_job(seed, pose=p, **tuned) for p in POSES}

    def draw(read: Read, folder: Path) -> Section:
        models, designs, jobs = designed(read)
        own, shared = ({p: read(j) for p, j in by_pose.items()} for by_pose in (jobs, base))
        largest = max(result["motor_inf"][0].max() for result in shared.values())
        at_p1 = {"shared": shared["p1"], "per motor": own["p1"]}
        curves = {name: result["motor_inf"] / largest for name, result in at_p1.items()}
        title = "One design for all motors, and one for each: p1"
        figures.by_motor(folder / "F08.png", title, curves)
        every = _ratios(own, shared, AT)
        chosen = [
            [f"motor {i + 1}", d.gamma, d.delta, d.cutoff, m.fit, d.contraction]
            for i, (d, m) in enumerate(zip(designs, models, strict=True))
        ]
        rows = [[pose, *_row(own[pose], shared[pose], AT)] for pose in POSES]
        columns = ["", "γ", "δ", "cutoff [Hz]", "fit of the model", "contraction"]
        title = "Per-motor design over shared design at k = 5"
        both = ["", *figures.MOTORS, "arm RMS"]
        says, smaller = "larger reduction possible", (every < 1.0).sum()
        what = "motor errors at k = 5, per-motor over shared design"
        return Section(
            "F08",
            "F08: design variables for each motor",
            "Gain, shift and cutoff of each motor are chosen from the model identified for it and "
            "used at all positions. The thesis names this as the way to lower errors of the "
            "motors; its effect on the tool is in the table.",
            ["F08.png"],
            [
                Check("F08a", f"{what}: median of 18", says, float(np.median(every)), high=1.0),
                Check("F08b", "the same, how many of 18 are smaller", says, smaller, low=10),
            ],
            [Table("Designs", columns, chosen), Table(title, both, rows)],
        )

    first = [*base.values(), *data.values()]
    return Part(first, draw, lambda read: [*designed(read)[2].values()])


def friction_feedforward(seed: int) -> Part:
    """F09: ILC reduces the low frequencies, feedforward the friction at reversals."""
    plain = STUDIES["operating point"].jobs(seed)
    options = {"friction_feedforward": FED_FORWARD}
    helped = {p: replace(job, cut=replace(job.cut, **options)) for p, job in plain.items()}

    def draw(read: Read, folder: Path) -> Section:
        without, with_it = ({p: read(j) for p, j in jobs.items()} for jobs in (plain, helped))
        cases = {f"{pose}, ILC alone": without[pose] for pose in POSES}
        cases |= {f"{pose}, with feedforward": with_it[pose] for pose in POSES}
        tool = {name: 1e6 * run["arm_rms"] for name, run in cases.items()}
        motors = {name: 1e3 * run["motor_inf"].mean(axis=1) for name, run in cases.items()}
        content = {"Tool, RMS [µm]": tool, "Motors, mean of six, ∞-norm [motor mrad]": motors}
        title = "Learning with and without friction feedforward"
        look: dict[str, Any] = {"columns": 2, "wide": True, "log": True, "paired": True}
        figures.panels(folder / "F09.png", title, content, share_y=False, **look)
        first, last = (float(np.median(_ratios(with_it, without, k))) for k in (0, AT))
        what = "motor errors {}, with over without: median of 18"
        rows = [[p, k, *_row(with_it[p], without[p], k)] for p in POSES for k in (0, AT)]
        return Section(
            "F09",
            "F09: ILC together with friction feedforward",
            f"The controller adds {100 * FED_FORWARD:.0f} % of the nominal Coulomb friction, with "
            "the sign of the reference speed, to its torque. The thesis asks how ILC, which a "
            "low-pass keeps from high frequencies, could be combined with something that reaches "
            "the friction at reversals.",
            ["F09.png"],
            [
                Check("F09a", what.format("without learning"), "", first, high=0.9),
                Check("F09b", what.format("at k = 5"), "", last, high=1.0),
            ],
            [Table("With over without feedforward", ["", "k", *figures.MOTORS, "arm RMS"], rows)],
        )

    return Part([*plain.values(), *helped.values()], draw)


def _ratios(ours: Mapping[str, Result], other: Mapping[str, Result], k: int) -> Array:
    """Motor errors of one over another design, (3, 6) by pose and motor."""
    return np.array([over(ours[pose], other[pose], "motor_inf", k) for pose in POSES])


def _row(ours: Result, other: Result, k: int) -> list[float]:
    """The same of six motors at one pose, and of the RMS of the arm."""
    return [*over(ours, other, "motor_inf", k).tolist(), float(over(ours, other, k=k))]
