"""`armside identify`: the springs of an arm from one cut with an IMU at the tool."""

from dataclasses import dataclass, replace
from typing import Any

from armside.sim.laser.experiment import prepare
from armside.sim.records.run_folder import RunFolder
from armside.sim.records.summary import dumps, summary

from ..cutting.options import LaserCfg
from ..cutting.specification import cut
from ..shell.console import Report
from ..shell.errors import checking_input
from ..shell.options import Common, options


@options
@dataclass(frozen=True, kw_only=True)
class IdentifyCfg(LaserCfg):
    """The cut to identify from; options of learning are not used."""

    uncoupled: bool = False
    """Springs of the gears alone: no elasticity of the structure."""


def identify(*, cfg: IdentifyCfg = IdentifyCfg(), common: Common = Common()) -> None:
    """Identify joint stiffness, damping and clock offset from one cut; score against the truth.

    Writes summary.json, whose folder `armside laser --identification` takes.
    """
    from armside.sim.instruments.imu import ImuCfg
    from armside.sim.laser.identification import identified
    from armside.sim.laser.tool_path import ToolPath

    report = Report(common)
    with checking_input():
        experiment = prepare(replace(cut(cfg), imu=ImuCfg()), seed=common.seed)
        arm = ToolPath(stiffness_error=cfg.stiffness_error * 1e-2).assumed(experiment)
    with report.progress("identifying", total=1) as step:
        found = identified(experiment, arm, coupled=not cfg.uncoupled)
        step()
    outcome = summary("identify", cfg, common, **found)
    with RunFolder("identify", seed=common.seed, out=common.out) as folder:
        (folder / "summary.json").write_text(dumps(outcome), encoding="utf-8")
    _print(report, outcome)
    report.line(f"Results in {folder.path}")
    report.summary(outcome)


def _print(report: Report, outcome: dict[str, Any]) -> None:
    truth = outcome["truth"]
    report.table(
        "What one cut tells: logarithms relative to what was believed, clock in s",
        ["parameter", "value", "standard deviation", "told by the data"],
        [
            [p["name"], p["value"], p["standard_deviation"], p["told_by_data"]]
            for p in outcome["parameters"]
        ],
    )
    report.table(
        "Stiffness over that of the true gear (structure in series makes it effective, < 1)",
        ["axis", "believed", "identified"],
        [
            [i + 1, believed, identified]
            for i, (believed, identified) in enumerate(
                zip(truth["believed_over_true"], truth["identified_over_true"], strict=True)
            )
        ],
    )
    report.table(
        "Lowest modes with the motors held [Hz]",
        ["true", "identified", "believed"],
        [
            list(row)
            for row in zip(
                truth["locked_modes"],
                truth["identified_modes"],
                truth["believed_modes"],
                strict=True,
            )
        ],
    )
    offset = outcome["springs"]["clock_offset"]
    report.line(f"Clock offset {1e3 * offset:.2f} ms, true {1e3 * truth['clock_offset']:.2f} ms")
    verdict = "white" if outcome["whiteness"]["is_white"] else "not white"
    rms = ", ".join(f"{value:.2f}" for value in outcome["whiteness"]["rms"])
    report.line(f"Innovations are {verdict}; rms by channel {rms}")
    said = outcome["consistency"]
    low, high = said["nis_expected"]
    report.line(
        f"NIS {said['nis']:.2f}, {low:.2f} to {high:.2f} if the filter is right about innovations; "
        f"NEES of the tool's position {said['nees']:.1f}, 3 if it is right about the tool"
    )
