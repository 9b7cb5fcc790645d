"""`armside serve`: the virtual robot behind the protocol of a robot controller."""

import time
from collections.abc import Callable, Sequence
from dataclasses import dataclass
from typing import TYPE_CHECKING, Any, Literal

from armside.sim.records.summary import summary

from ..shell.console import Report, run_folder
from ..shell.errors import RunFailed, checking_input, needs
from ..shell.options import Common, Limits, options
from ..workbench.controllers import PORTS, whole_port

if TYPE_CHECKING:
    from armside.sim.controller import VirtualController
    from armside.sim.controller.server import Server
    from armside.sim.robot.recording import Recording

LOOPBACK = ("127.0.0.1", "localhost", "::1")


@options
@dataclass(frozen=True, kw_only=True)
class ServeCfg:
    """Protocol, robot and program."""

    protocol: Literal["egm", "rsi"] = "egm"
    """Protocol. egm: ABB's Externally Guided Motion (absolute joint angles); rsi: KUKA's Robot
    Sensor Interface (corrections of the program)."""
    host: str = "127.0.0.1"
    """Host of the client. The controller speaks first, as real ones do."""
    port: int | None = None
    """UDP port of the client [default: 6510 for EGM, 59152 for RSI]."""
    robot: str = "large"
    """Robot: large, irb1400, or a robot file (.toml)."""
    program: str | None = None
    """hold[:pose=p2] (stand until guided) or cut[:pose=p2,speed=60] (options of laser)
    [default: hold for EGM, cut for RSI]."""
    real_time: bool = False
    """Cycles of 4 ms by the clock; otherwise as fast as the client answers."""
    runs: int | None = None
    """End after so many runs [default: at Ctrl-C]."""
    idle: float | None = None
    """End when no client has answered for so long [s; default: never]."""
    seconds: float = 60.0
    """Longest run of a robot that is guided."""
    relative: bool = False
    """Corrections of RSI add up."""

    def __post_init__(self) -> None:
        if self.port is not None:
            whole_port(self.port, least=1)
        Limits(1).check("runs", self.runs)
        Limits(0.0, 1e7, "s", above=True).check("idle", self.idle)
        Limits(0.1, 600.0).check("seconds", self.seconds)
        if self.relative and self.protocol != "rsi":
            raise ValueError("relative corrections are those of RSI: --protocol rsi")


def serve(*, cfg: ServeCfg = ServeCfg(), common: Common = Common()) -> None:
    """Put the virtual robot behind a robot controller's protocol, for any client that speaks it.

    Each run starts at rest at the program's start, with the first answer of the client. Prints a
    line for each new client and run, and for the first of each kind of message that is refused or
    none of the protocol; with --real-time between runs. Writes summary.json.
    """
    report = Report(common)
    records = list[dict[str, Any]]()
    with checking_input():
        controller = _controller(cfg, common.seed, records.append)
        server = _server(cfg, controller)
    if cfg.host not in LOOPBACK:
        report.line(f"Warning: {cfg.host} is another machine, and nothing protects the connection.")
    host, port = server.client
    pace = "in real time" if cfg.real_time else "as fast as the client answers"
    report.line(f"Speaking {cfg.protocol.upper()} to {host}:{port}, {pace}. Ctrl-C ends it.")
    interrupted = _run(cfg, server, controller, report, records)
    outcome = summary(
        "serve",
        cfg,
        common,
        status="done" if controller.runs else "no client",
        runs=records,
        late=server.late,
        longest_delay=server.longest if cfg.real_time else None,
        prioritised=server.prioritised,
        wrong_messages=server.wrong_count,
        reasons=[*server.wrong, *controller.refusals],
    )
    if not controller.runs:
        waited = "before Ctrl-C" if interrupted else f"within {cfg.idle:g} s"
        raise RunFailed(f"no client completed a run {waited}")
    with run_folder(outcome, common) as folder:
        pass
    columns = ("run", "seconds", "missed", "motor error RMS [rad]")
    rows = [(i, row["seconds"], row["missed"], row["motor_rms"]) for i, row in enumerate(records)]
    report.table("Runs", columns, rows[-20:])
    if cfg.real_time:
        late = f"{server.late} answers came after their cycle or twice"
        most = f"cycles began at most {1e3 * server.longest:.2g} ms late"
        unfair = "" if server.prioritised else " (the system grants no real-time priority)"
        report.line(f"Real time: {late}; {most}{unfair}")
    report.results(outcome, folder.path)


def _told(run: Any) -> str:
    lost = f"{run['missed']} answers lost, late or refused"
    end = "; the client fell silent" if run["abandoned"] else ""
    rms = f"motor error RMS {1e3 * run['motor_rms']:.4g} mrad"
    return f"Run of {run['seconds']:.4g} s: {rms}, {lost}{end}"


def _run(
    cfg: ServeCfg,
    server: "Server",
    controller: "VirtualController",
    report: Report,
    runs: list[dict[str, Any]],
) -> bool:
    """Serve to the end that the options name, and print what comes, a line each. True if Ctrl-C
    ended it."""
    from armside.sim.controller import Phase

    sources: tuple[tuple[Sequence[Any], Callable[[Any], str]], ...] = (
        (server.clients, lambda client: f"Client at {client[0]}:{client[1]}"),
        (server.wrong, lambda reason: f"Not a message: {reason}"),
        (controller.refusals, lambda reason: f"Refused: {reason}"),
        (runs, _told),
    )
    printed, heard = [0] * len(sources), time.monotonic()

    def news() -> None:
        for i, (found, line) in enumerate(sources):
            report.lines(line(one) for one in found[printed[i] :])
            printed[i] = len(found)

    def over() -> bool:
        nonlocal heard
        if controller.phase is Phase.WAITING or not cfg.real_time:
            news()
        if controller.phase is not Phase.WAITING:
            heard = time.monotonic()
        elif cfg.idle is not None and time.monotonic() - heard > cfg.idle:
            return True
        return cfg.runs is not None and controller.runs >= cfg.runs

    try:
        server.serve(over)
    except KeyboardInterrupt:
        return True
    finally:
        news()
    return False


def _server(cfg: ServeCfg, controller: "VirtualController") -> "Server":
    from armside.sim.controller.rsi import RsiWire
    from armside.sim.controller.server import Server, resolved

    if cfg.protocol == "rsi":
        wire: Any = RsiWire(cfg.relative)
    else:
        with needs("controllers", "armside serve by EGM", "protobuf"):
            from armside.sim.controller.egm import EgmWire

            wire = EgmWire()
    client = resolved(cfg.host, PORTS[cfg.protocol] if cfg.port is None else cfg.port)
    return Server(controller, wire, client, real_time=cfg.real_time)


def _controller(
    cfg: ServeCfg, seed: int, keep: Callable[[dict[str, Any]], None]
) -> "VirtualController":
    import numpy as np

    from armside.ilc.workbench.words import Words, unknown_name
    from armside.sim.controller import Hold, VirtualController
    from armside.sim.laser.experiment import prepare

    from ..cutting.options import LaserCfg
    from ..cutting.specification import cut
    from ..workbench.controllers import laser_values

    words = Words.parse(cfg.program or ("cut" if cfg.protocol == "rsi" else "hold"))
    if words.name not in ("hold", "cut"):
        raise ValueError(unknown_name("program", words.text, ("hold", "cut")))
    made = cut(LaserCfg(robot=cfg.robot, **laser_values(words)))
    experiment = prepare(made, seed=seed)
    loaded, rng = experiment.loaded, np.random.default_rng((seed, 1))
    if words.name == "cut":
        controller = VirtualController(loaded, made.cell, rng)
    else:
        program = Hold(start=loaded.reference[0], seconds=cfg.seconds)
        controller = VirtualController.standing(loaded.model, made.cell, program, rng)
    guided = words.name == "hold"
    controller.on_end = lambda run, missed: keep(
        _row(run, missed, guided) | {"abandoned": controller.abandoned}
    )
    return controller


def _row(run: "Recording", missed: int, guided: bool) -> dict[str, Any]:
    import numpy as np

    error = (run.reference + run.correction if guided else run.reference) - run.motor_angle
    rms = float(np.sqrt(np.mean(error**2)))
    return {"seconds": float(run.time[-1]), "missed": missed, "motor_rms": rms}
