"""`armside identify`: the arm's springs from one cut, its motor angles and an IMU, and how sure."""

from dataclasses import dataclass
from typing import TYPE_CHECKING, Any

import numpy as np

from armside.sim.cell import CELLS
from armside.sim.laser.experiment import Experiment, prepare
from armside.sim.records.run_folder import RunFolder
from armside.sim.records.summary import dumps, summary
from armside.sim.robot.effects import Effect
from armside.sim.robot.model import RobotModel, load_model

from ..laser_task import added_payload, believed_arm
from ..laser_task import robot as known_robot
from ..shell.console import Report
from ..shell.errors import checking_input
from ..shell.options import Common, options
from .laser import LaserCfg, task

if TYPE_CHECKING:
    from armside.sim.estimation.arm_estimator import ArmEstimator
    from armside.sim.estimation.arm_identification import Run
    from armside.sim.laser.plant import Pass


@options
@dataclass(frozen=True, kw_only=True)
class IdentifyCfg(LaserCfg):
    """Which cut to identify from; what belongs to learning is not used."""

    uncoupled: bool = False
    """Keep to the springs of the gears: no elasticity of the structure."""


def identify(*, cfg: IdentifyCfg = IdentifyCfg(), common: Common = Common()) -> None:
    """Identify joint stiffness, damping and clock offset from one cut; score against the truth.

    Writes summary.json, whose folder `armside laser --identification` takes.
    """
    report = Report(common)
    with checking_input():
        experiment, robot = _prepared(cfg, common.seed)
    with report.progress("identifying", total=1) as step:
        found = run(cfg, experiment, robot, common.seed)
        step()
    outcome = summary("identify", cfg, common, **found)
    with RunFolder("identify", seed=common.seed, out=common.out) as folder:
        (folder / "summary.json").write_text(dumps(outcome), encoding="utf-8")
    _print(report, outcome)
    report.line(f"Results in {folder.path}")
    report.summary(outcome)


def _prepared(cfg: LaserCfg, seed: int) -> tuple[Experiment, RobotModel]:
    from armside.sim.instruments.imu import ImuCfg

    cell = CELLS[cfg.robot]
    robot = known_robot(cfg)
    believed_arm(cfg, seed)
    experiment = prepare(
        cell,
        robot,
        task(cfg),
        seed=seed,
        friction_spread=cfg.friction_spread * 1e-2,
        without=[Effect(name) for name in cfg.without],
        imu=ImuCfg(),
    )
    return experiment, robot


def run(cfg: IdentifyCfg, experiment: Experiment, robot: RobotModel, seed: int) -> dict[str, Any]:
    """Cut once, identify, and compare with what nobody on the shop floor can know."""
    from armside.sim.estimation.arm_estimator import estimator
    from armside.sim.estimation.arm_identification import identify as identified_from
    from armside.sim.estimation.arm_identification import prepared
    from armside.sim.estimation.arm_springs import SpringPrior
    from armside.sim.estimation.frozen_arm import frozen
    from armside.sim.estimation.imu_health import mended
    from armside.sim.estimation.nominal import NominalCfg, nominal_arm
    from armside.sim.instruments.imu import ImuCfg

    source = cfg.model or CELLS[cfg.robot].xml
    arm = believed_arm(cfg, seed)
    made = experiment.plant.run(np.zeros_like(experiment.loaded.reference))
    log, unit = made.recording, experiment.plant.imu
    assert made.imu is not None
    assert unit is not None
    measured = prepared(arm, log.time, log.motor_angle, mended(made.imu, ImuCfg()))
    prior = SpringPrior(coupling=0.0) if cfg.uncoupled else SpringPrior()
    rest = log.motor_angle[0]
    found = identified_from(arm, measured, rest, ImuCfg(), prior=prior)

    true_arm = nominal_arm(
        load_model(source), NominalCfg(structure=True, payload=added_payload(cfg))
    )
    gear = np.diag(true_arm.stiffness)
    modes = frozen(true_arm, rest).locked_modes()[:4]
    sd = found.fit.standard_deviation
    return {
        "springs": {
            "stiffness": found.springs.stiffness,
            "damping": found.springs.damping,
            "clock_offset": found.springs.clock_offset,
            "distrust": found.springs.distrust,
            "mounting": found.springs.mounting,
        },
        "parameters": [
            {
                "name": name,
                "value": value,
                "standard_deviation": deviation,
                "told_by_data": told,
            }
            for name, value, deviation, told in zip(
                found.names, found.fit.theta, sd, found.fit.information, strict=True
            )
        ],
        "costs": found.fit.costs,
        "whiteness": {
            "rms": found.whiteness.rms,
            "p_value": found.whiteness.p_value,
            "is_white": found.whiteness.is_white,
        },
        "consistency": _consistency(estimator(arm, found.springs, rest, ImuCfg()), made, measured),
        "truth": {
            "gear_stiffness": gear,
            "believed_over_true": np.diag(arm.stiffness) / gear,
            "identified_over_true": np.diag(found.springs.stiffness) / gear,
            "clock_offset": unit.unit.clock_offset,
            "locked_modes": modes,
            "identified_modes": frozen(found.springs.on(arm), rest).locked_modes()[:4],
            "believed_modes": frozen(arm, rest).locked_modes()[:4],
        },
    }


def _consistency(known: "ArmEstimator", made: "Pass", measured: "Run") -> dict[str, Any]:
    """Whether the filter is right about its own errors: of innovations, and of the tool's path.

    NIS and NEES are 6 and 3 on average where it is. Gear errors that it does not model show in the
    second: they are slow, and hardly disturb an innovation.
    """
    from armside.ilc.estimation.consistency import bounds, normalised_squared
    from armside.sim.estimation.tool_path import relative_to_start

    log, truth = made.recording, made.recording.truth
    states = known.deviations(measured)
    seen = np.isfinite(states.innovation).all(axis=1)
    nis = normalised_squared(states.innovation[seen], states.innovation_covariance[seen])

    tool = known.model.tool[:3]
    P = tool @ known.smoother(measured).smoothed_covariance @ tool.T
    period = measured.period
    rows = np.rint((measured.imu_time + known.clock_offset) / period).astype(int)
    inside = (rows >= 0) & (rows < len(log.time))
    true = relative_to_start(truth.tool_position[:: round(period / float(truth.time[1]))])
    estimate = known(log.time, log.motor_angle, made.imu).displacement
    nees = normalised_squared((estimate - true)[rows[inside], :3], P[inside])
    return {
        "nis": float(nis.mean()),
        "nis_expected": bounds(len(nis), 6),
        "nees": float(nees.mean()),
        "nees_expected": 3.0,
    }


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
