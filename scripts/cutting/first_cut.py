"""The first cut of a robot that has a twin: its correction, and what its run says of the twin."""

from dataclasses import dataclass, replace
from typing import Any

from armside.sim.laser.experiment import Experiment
from armside.sim.laser.measures import MotorAngles, SetUp
from armside.sim.laser.plant import Pass
from armside.sim.notes import Cause, Note
from armside.sim.twin.correction import Corrected
from armside.sim.twin.drift import Refreshed, refreshed
from armside.sim.twin.measured import measured
from armside.sim.twin.twin import Twin

from .options import LaserCfg
from .specification import measure


@dataclass(frozen=True, eq=False)
class ByTwin:
    """A twin, its correction, and the measure that learning goes on with."""

    twin: Twin
    found: Corrected
    set_up: SetUp


def corrected(cfg: LaserCfg, experiment: Experiment) -> ByTwin:
    """Twin of the options, its correction, and the measure that learning goes on with.

    Learning from motor angles then follows the twin's motors, not the reference. Raises ValueError
    for a folder without a twin, or one of another robot.
    """
    assert cfg.twin is not None
    twin = Twin.load(cfg.twin)
    found = twin.correction(experiment.cut)
    chosen = measure(cfg)
    if isinstance(chosen, MotorAngles):
        chosen = replace(chosen, target=found.motor_path)
    return ByTwin(twin, found, chosen.prepare(experiment))


def outcome(by_twin: ByTwin, first: Pass, cfg: LaserCfg) -> tuple[dict[str, Any], list[Note]]:
    """Entries of summary.json: the predicted error, and the friction that the run shows; notes."""
    found, expected = by_twin.found, by_twin.found.prediction
    after = refreshed(by_twin.twin, [measured(first)], cfg.payload)
    entries = {
        "predicted": {
            "arm_rms": expected.expected,
            "interval": [expected.low, expected.high],
            "uncorrected": expected.uncorrected,
            "trusted": found.trusted,
            "reason": found.reason,
        },
        "twin": {
            "folder": cfg.twin,
            "friction": after.twin.friction,
            "torque_growth": after.growth,
            "advice": after.advice,
        },
    }
    return entries, notes(found, after)


def notes(found: Corrected, after: Refreshed) -> list[Note]:
    """Notes of a first cut: a twin that was not trusted, or that should be made again."""
    made = []
    if found.reason is not None:
        text = f"the twin is not trusted here: {found.reason}; the first run is not corrected"
        made.append(Note(cause=Cause.TWIN, text=text))
    if after.advice is not None:
        made.append(Note(cause=Cause.TWIN, text=f"commission the robot again: {after.advice}"))
    return made


def line(predicted: dict[str, Any], rows: list[dict[str, Any]]) -> str:
    """What was predicted of the first run and what was measured, in one line."""
    low, high = (1e6 * value for value in predicted["interval"])
    first = 1e6 * rows[0]["arm_rms"]
    return (
        f"First cut by the twin: {first:.1f} um of {1e6 * predicted['uncorrected']:.0f} um without "
        f"correction; predicted {1e6 * predicted['arm_rms']:.1f} um, {low:.1f} to {high:.1f} um"
    )
