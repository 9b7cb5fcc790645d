"""Plants of `armside learn` behind a controller's protocol, and programs of `armside serve`."""

from dataclasses import fields
from pathlib import Path
from typing import TYPE_CHECKING, Any

from armside.ilc.workbench.words import Words, number, unknown_name

from ..shell.errors import needs

if TYPE_CHECKING:
    from armside.ilc.workbench.task import Task
    from armside.sim.controller.client import Udp

PROTOCOLS = ("egm", "rsi")
PORTS = {"egm": 6510, "rsi": 59152}
"""Defaults of ABB's and KUKA's own examples."""
OF_CUT = ("pose", "speed", "radius", "payload", "shape", "size", "plane", "friction_spread")
"""Options of `armside laser` that the words of a plant or program may set."""


def laser_values(words: Words) -> dict[str, Any]:
    """Options of `armside laser` from words such as `cut:pose=p2,speed=60`. Raises ValueError."""
    from ..cutting.options import LaserCfg

    types, values = {each.name: each.type for each in fields(LaserCfg)}, dict[str, Any]()
    for key, text in words.parameters.items():
        if key not in OF_CUT:
            raise ValueError(unknown_name("parameter", key, OF_CUT))
        numeric = types[key] in (float, float | None)
        values[key] = float(number(text, key)) if numeric else text
    return values


def link(words: Words) -> "Udp":
    """Link that `egm:port=6510,host=127.0.0.1,wait=10` names; relative=1 for RSI that adds up.
    Raises ValueError, OSError when the port cannot be listened at, InputError without the extra."""
    known = ("host", "port", "wait", *(("relative",) if words.name == "rsi" else ()))
    for key in words.parameters:
        if key not in known:
            raise ValueError(unknown_name("parameter", key, known))
    given = words.parameters
    host = given.get("host", "127.0.0.1")
    port = whole_port(number(given.get("port", str(PORTS[words.name])), "port"))
    patience = float(number(given.get("wait", "10"), "wait"))
    if not 0.01 <= patience <= 3600.0:
        raise ValueError(f"wait must be 0.01 to 3600 s, got {patience:g}")
    if words.name == "rsi":
        from armside.sim.controller import Rsi

        relative = bool(number(given.get("relative", "0"), "relative"))
        return Rsi(host, port, relative=relative, patience=patience)
    with needs("controllers", "EGM", "protobuf"):
        from armside.sim.controller import Egm

        return Egm(host, port, patience=patience)


def whole_port(value: float, least: int = 0) -> int:
    """A UDP port; 0 is any that is free. Raises ValueError."""
    if not (least <= value <= 65535 and value == int(value)):
        raise ValueError(f"port must be a whole number from {least} to 65535, got {value:g}")
    return int(value)


def controller_task(
    words: Words, record: Any, followed: Path | None = None, beyond: tuple[str, ...] = ()
) -> "Task":
    """Task on the controller that speaks to us: its program, or the path of --reference or of an
    earlier run (`followed`), so that the program is not listened to again. beyond: names that the
    gate lets through. Raises ValueError, TimeoutError when no controller speaks."""
    from armside.ilc.workbench.signals import file_reference
    from armside.ilc.workbench.task import Task
    from armside.sim.controller import StreamedPlant
    from armside.sim.controller.plant import program_of
    from armside.sim.robot.virtual_robot import LOG_PERIOD

    if record.sample_time not in (None, LOG_PERIOD):
        raise ValueError(f"a controller's samples are {LOG_PERIOD:g} s apart: leave the time out")
    speaking = link(words)
    try:
        if record.reference or followed is not None:
            path = file_reference(Path(record.reference or str(followed)), None, LOG_PERIOD)
        else:
            path = program_of(speaking)
        plant = StreamedPlant(speaking, path, beyond=beyond)
    except BaseException:
        speaking.close()
        raise
    return Task(
        name=words.text,
        reference=plant.path,
        sample_time=LOG_PERIOD,
        start=lambda repetition: plant,
        check=plant.check,
        close=speaking.close,
        model=record.model,
    )
