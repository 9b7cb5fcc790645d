"""`armside identify`: the springs of an arm from one cut with an IMU at the tool."""

from dataclasses import dataclass
from typing import Any

from armside.sim.laser.experiment import prepare
from armside.sim.records.summary import summary

from ..cutting.options import ContourCfg
from ..cutting.specification import cut_with_imu
from ..shell.console import Report, run_folder
from ..shell.errors import checking_input
from ..shell.options import Common, options


@options
@dataclass(frozen=True, kw_only=True)
class IdentifyCfg(ContourCfg):
    """The cut to identify from, and the springs that are assumed."""

    uncoupled: bool = False
    """Springs of the gears alone: no elasticity of the structure."""


def identify(*, cfg: IdentifyCfg = IdentifyCfg(), common: Common = Common()) -> None:
    """Identify joint stiffness, damping and clock offset from one cut; score against the truth.

    Writes summary.json, whose folder `armside laser --identification` takes.
    """
    from armside.sim.laser.identification import identified
    from armside.sim.laser.tool_measure import ToolPath

    report = Report(common)
    with checking_input():
        experiment = prepare(cut_with_imu(cfg), seed=common.seed)
        measure = ToolPath(stiffness_error=cfg.stiffness_error * 1e-2, structure=not cfg.uncoupled)
        arm = measure.assumed(experiment)
    (found,) = report.each("identifying", lambda known: identified(experiment, known), [arm])
    outcome = summary("identify", cfg, common, **found)
    with run_folder(outcome, common) as folder:
        pass
    report.notes(found["notes"])
    _print(report, outcome)
    report.results(outcome, folder.path)


def _print(report: Report, outcome: dict[str, Any]) -> None:
    truth, found = outcome["truth"], outcome["parameters"]
    report.table(
        "What one cut identifies: logarithms relative to the assumed arm, clock in s",
        ["parameter", "value", "standard deviation", "from the data"],
        [[p[k] for k in ("name", "value", "standard_deviation", "identified")] for p in found],
    )
    assumed, identified = truth["assumed_over_true"], truth["identified_over_true"]
    report.table(
        "Stiffness of each gear, relative to the true one",
        ["axis", "assumed", "identified"],
        list(zip(range(1, 1 + len(assumed)), assumed, identified, strict=True)),
    )
    keys = "locked_modes", "identified_as", "identified_modes", "assumed_modes"
    report.table(
        "Lowest modes with the motors held [Hz]; a dash: none is identified within 10 %",
        ["true", "identified as", "all identified", "all assumed"],
        list(zip(*(truth[key] for key in keys), strict=True)),
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
        f"NEES of the tool's position {said['nees']:.1f}, {said['nees_expected']:g} if standard "
        f"deviations are right about the tool; {said['nees_of_filter']:.1f} by the filter alone"
    )
    sd, error = (1e6 * said[key] for key in ("tool_standard_deviation", "tool_error"))
    report.line(f"Tool: standard deviation {sd:.1f} um, error {error:.1f} um (RMS, 3D)")
    if outcome["not_identified"]:
        names = ", ".join(outcome["not_identified"])
        report.line(f"Not identified by this cut, kept as assumed: {names}")
