"""Beyond chapter 9: design variables for each motor (F08), friction feedforward (F09)."""

from dataclasses import replace
from pathlib import Path

import numpy as np

from armside.ilc.analysis.proposal import Proposal, design_for
from armside.ilc.identification.first_order import FirstOrderModel

from ...jobs.store import Job, Result
from ...learning_job import LearningJob
from ..report import Check, Grid, Part, Section
from . import figures
from .bands import AT
from .sections import SPEEDS, Read, identify
from .table import POSES, STUDIES, laser

CUTOFFS = (6.0, 8.0, 10.0, 12.0, 15.0)
"""[Hz], offered to each motor; the highest one with a fast enough design is taken."""
FED_FORWARD = 0.8
"""Share of the Coulomb friction; all of it would overcompensate robots with less."""


def per_motor(seed: int) -> Part:
    """F08: gain, shift and cutoff of each motor from its own identified model, at p1."""
    base = STUDIES["operating point"].jobs(seed)
    data = STUDIES["identification"].jobs(seed)

    def designed(
        read: Read,
    ) -> tuple[list[FirstOrderModel], list[Proposal], dict[str, LearningJob]]:
        results = {v: read(data["p1", v]) for v in SPEEDS}
        models = [identify(results, (motor,)) for motor in range(6)]
        designs = [design_for(model.system, CUTOFFS, fit=model.fit) for model in models]
        tuned = laser(
            gamma=tuple(round(design.gamma, 3) for design in designs),
            delta=tuple(design.delta for design in designs),
            cutoff=tuple(design.cutoff for design in designs),
        )
        jobs = {pose: LearningJob(laser=replace(tuned, pose=pose), seed=seed) for pose in POSES}
        return models, designs, jobs

    def draw(read: Read, folder: Path) -> Section:
        models, designs, own_jobs = designed(read)
        with_own = {pose: read(job) for pose, job in own_jobs.items()}
        shared = {pose: read(job) for pose, job in base.items()}
        largest = max(result["motor_inf"][0].max() for result in shared.values())
        figures.by_motor(
            folder / "F08.png",
            "One design for all motors, and one for each: p1",
            {
                "shared": shared["p1"]["motor_inf"] / largest,
                "per motor": with_own["p1"]["motor_inf"] / largest,
            },
        )
        ratio = {
            pose: with_own[pose]["motor_inf"][AT] / shared[pose]["motor_inf"][AT] for pose in POSES
        }
        every = np.array(list(ratio.values()))
        return Section(
            id="F08",
            title="F08: design variables for each motor",
            caption="Gain, shift and cutoff of each motor are chosen from the model identified for "
            "it and used at all positions. The thesis names this as the way to lower errors "
            "of the motors; what the tool makes of it is in the table.",
            figures=["F08.png"],
            checks=[
                Check(
                    id="F08a",
                    statement="motor errors at k = 5, per-motor over shared design: median of 18",
                    thesis="larger reduction possible",
                    ours=float(np.median(every)),
                    high=1.0,
                ),
                Check(
                    id="F08b",
                    statement="the same, how many of 18 are smaller",
                    thesis="larger reduction possible",
                    ours=float((every < 1.0).sum()),
                    low=10,
                ),
            ],
            grids=[
                Grid(
                    title="Designs",
                    columns=["", "γ", "δ", "cutoff [Hz]", "fit of the model", "contraction"],
                    rows=[
                        [f"motor {i + 1}", d.gamma, d.delta, d.cutoff, m.fit, d.contraction]
                        for i, (d, m) in enumerate(zip(designs, models, strict=True))
                    ],
                ),
                Grid(
                    title="Per-motor design over shared design at k = 5",
                    columns=["", *figures.MOTORS, "arm RMS"],
                    rows=[
                        [pose, *map(float, ratio[pose]), _arm(with_own[pose], shared[pose])]
                        for pose in POSES
                    ],
                ),
            ],
        )

    return Part(
        [*base.values(), *data.values()], draw, lambda read: list(designed(read)[2].values())
    )


def friction_feedforward(seed: int) -> Part:
    """F09: ILC takes the low frequencies, feedforward the friction at reversals."""
    plain = STUDIES["operating point"].jobs(seed)
    helped = {pose: replace(job, friction_feedforward=FED_FORWARD) for pose, job in plain.items()}
    jobs: list[Job] = [*plain.values(), *helped.values()]

    def draw(read: Read, folder: Path) -> Section:
        without = {pose: read(job) for pose, job in plain.items()}
        with_it = {pose: read(job) for pose, job in helped.items()}
        cases = {f"{pose}, ILC alone": without[pose] for pose in POSES} | {
            f"{pose}, with feedforward": with_it[pose] for pose in POSES
        }
        first = {
            pose: with_it[pose]["motor_inf"][0] / without[pose]["motor_inf"][0] for pose in POSES
        }
        last = {
            pose: with_it[pose]["motor_inf"][AT] / without[pose]["motor_inf"][AT] for pose in POSES
        }
        figures.panels(
            folder / "F09.png",
            "Learning with and without friction feedforward",
            {
                "Tool, RMS [µm]": {name: 1e6 * run["arm_rms"] for name, run in cases.items()},
                "Motors, mean of six, ∞-norm [motor mrad]": {
                    name: 1e3 * run["motor_inf"].mean(axis=1) for name, run in cases.items()
                },
            },
            columns=2,
            wide=True,
            log=True,
        )
        return Section(
            id="F09",
            title="F09: ILC together with friction feedforward",
            caption=f"The controller adds {100 * FED_FORWARD:.0f} % of the nominal Coulomb "
            "friction, with the sign of the reference speed, to its torque. The thesis asks how "
            "ILC, which a low-pass keeps from high frequencies, could be combined with something "
            "that reaches the friction at reversals.",
            figures=["F09.png"],
            checks=[
                Check(
                    id="F09a",
                    statement="motor errors without learning, with over without: median of 18",
                    thesis="proposed",
                    ours=float(np.median(list(first.values()))),
                    high=0.9,
                ),
                Check(
                    id="F09b",
                    statement="motor errors at k = 5, with over without: median of 18",
                    thesis="proposed",
                    ours=float(np.median(list(last.values()))),
                    high=1.0,
                ),
            ],
            grids=[
                Grid(
                    title="With over without feedforward",
                    columns=["", "k", *figures.MOTORS, "arm RMS"],
                    rows=[
                        [pose, k, *map(float, ratio[pose]), _arm(with_it[pose], without[pose], k)]
                        for pose in POSES
                        for k, ratio in ((0, first), (AT, last))
                    ],
                )
            ],
        )

    return Part(jobs, draw)


def _arm(ours: Result, other: Result, k: int = AT) -> float:
    return float(ours["arm_rms"][k] / other["arm_rms"][k])
