"""`--forecast` of `armside laser` and `cut`: what learning would leave, before the first run."""

from dataclasses import asdict, dataclass
from typing import TYPE_CHECKING, Any

from armside.sim.laser.measures import MotorAngles
from armside.sim.notes import Cause, Note

from ..shell.console import Report
from ..shell.options import options
from .cut_run import Ready

if TYPE_CHECKING:
    from armside.sim.laser.forecast import Forecast, Left

    from .options import LaserCfg
    from .part_options import CutCfg


@options
@dataclass(frozen=True, kw_only=True)
class ForecastCfg:
    """What to say before the first run."""

    forecast: bool = False
    """Say what learning would leave of the error. From motors, estimate and tracker, by eight
    robots of the type, some seconds for a circle. Where motors would make the tool of most robots
    worse, learning from them is refused unless --measure motor is given."""


def foreseen(
    report: Report, made: Ready, asked: ForecastCfg, cfg: "LaserCfg | CutCfg"
) -> "Forecast | None":
    """Forecast of a cut, if asked for. Raises ValueError where motors, not asked for by name, would
    make most robots worse, and beside --from or --twin."""
    if not asked.forecast:
        return None
    if made.earlier is not None or cfg.twin is not None:
        option = "--twin" if made.earlier is None else "--from"
        raise ValueError(f"forecast is of a first run without correction: leave out {option}")
    from armside.sim.laser.forecast import ROBOTS, forecast
    from armside.sim.laser.tool_measure import ToolPath

    measure = made.measure
    motor = measure if isinstance(measure, MotorAngles) else MotorAngles()
    law = (measure if isinstance(measure, ToolPath) else ToolPath()).law
    with report.progress("forecast", total=ROBOTS) as step:
        found = forecast(made.experiment.cut, motor=motor, law=law, step=step)
    why = found.objection(cfg.measure, cfg.iterations)
    if why is not None and cfg.measure == "motor" and not cfg.motor_by_name:
        raise ValueError(f"{why}; choose one of them, or ask for --measure motor by name")
    return found


def entries(
    found: "Forecast | None", cfg: "LaserCfg | CutCfg"
) -> tuple[dict[str, Any], list[Note]]:
    """Entry of summary.json, and notes of what it assumed and where most robots would end worse."""
    if found is None:
        return {}, []
    why = found.objection(cfg.measure, cfg.iterations)
    texts = [*(f"forecast: {each}" for each in found.assumed), *([] if why is None else [why])]
    return {"forecast": asdict(found)}, [Note(cause=Cause.FORECAST, text=text) for text in texts]


def _name(one: "Left") -> str:
    return one.measure if one.calibrated else f"{one.measure} (not calibrated)"


def show_forecast(report: Report, found: "Forecast | None") -> None:
    """Print a forecast."""
    if found is None:
        return
    rows = [
        [_name(one), one.updates, *(100.0 * x for x in (one.median, one.low, one.high, one.worse))]
        for one in found.left
    ]
    columns = ["learned from", "k", "median [%]", "5 %", "95 %", "robots that end worse [%]"]
    first = f"{1e6 * found.uncorrected:.3g} µm at k = 0"
    report.table(f"Forecast of the tool RMS, per cent of {first}", columns, rows)
