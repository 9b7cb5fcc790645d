"""`armside robot`: a robot described, examined, shown, moved or built, and a new robot file."""

from dataclasses import asdict, dataclass
from pathlib import Path
from typing import Annotated, Any, Literal

from cyclopts import Parameter

from armside.sim.evaluation.robot_examination import Examination
from armside.sim.records.summary import summary
from armside.sim.robot.kinematics_check import cell_model
from armside.sim.robot.model import load_model
from armside.sim.robot_file.find import find_cell, load_robot

from ..figures.robot_tables import (
    axes_of,
    estimates_of,
    numbers,
    print_check,
    print_data,
    print_description,
    table_of,
)
from ..shell.console import Report, run_folder
from ..shell.errors import RunFailed, checking_input
from ..shell.options import Common, check_read, options

_ACTION = (
    "Describe the kinematics, examine a model, show its data, move it by sliders, build an MJCF "
    "from a robot file, or write a new one."
)
Action = Annotated[
    Literal["model", "check", "show", "view", "build", "new"], Parameter(help=_ACTION)
]
_MODEL = (
    "check, show, view: MJCF in place of that robot's own, or a robot file (.toml). build: a robot "
    "file. model: a robot file, URDF or MJCF. new: URDF, MJCF or D-H table (.toml) to start from "
    "[default: a template]."
)
Model = Annotated[Path | None, Parameter(help=_MODEL, validator=check_read)]


@options
@dataclass(frozen=True, kw_only=True)
class RobotCfg:
    """The robot."""

    robot: str | None = None
    """Robot whose D-H table, limits and poses the controller has: large, irb1400, or a robot file
    (.toml). model: also irb1400-imu with the links to its IMU, ur10, irb120, aubo_i5, FILE.urdf,
    FILE.urdf#TIP_LINK, FILE.xml (MJCF), FILE.xml#TIP [default: large; model: irb1400]."""
    tip: str | None = None
    """new: last link of a URDF, or last body or site of an MJCF, that is a tree."""
    latex: bool = False
    """model: print the table and the zero pose as LaTeX."""
    plot: bool = False
    """model: draw the link frames in the zero pose (frames.png), as thesis Fig 5.3."""

    def __post_init__(self) -> None:
        if self.tip == "":
            raise ValueError("tip must name a link, a body or a site, got ''")

    def check(self, action: str) -> None:
        """Raise ValueError for an option of another action."""
        for name, home in (("tip", "new"), ("latex", "model"), ("plot", "model")):
            if getattr(self, name) not in (None, False) and action != home:
                raise ValueError(f"--{name} is for {home}, got robot {action}")


def robot(
    action: Action,
    model: Model = None,
    /,
    *,
    cfg: RobotCfg = RobotCfg(),
    common: Common = Common(),
) -> None:
    """Describe, check, show, move, build or start a robot.

    model: D-H table, T in the zero pose, reach, singular configurations. check: D-H table against
    MJCF, drives and time step; status 1 if a verdict fails. show: D-H table, limits and drives; a
    picture with --out. view: sliders in MuJoCo's own viewer move the motors under gravity; needs a
    display. build: MJCF and a robot file that names it. new: a robot file with every default as a
    comment.
    """
    report = Report(common)
    with checking_input():
        cfg.check(action)
    named, other = cfg.robot or "large", model
    if model is not None and model.suffix == ".toml":
        named, other = str(model), None
    if action == "new":
        _new(model, cfg, report, common)
    elif action == "model":
        _describe(str(model or cfg.robot or "irb1400"), cfg, report, common)
    elif action == "build":
        _build(str(model or cfg.robot or "large"), report, common)
    elif action == "show":
        _show(named, other, report, common)
    elif action == "view":
        from ..viewers.sliders import view_robot

        view_robot(named, other)
    else:
        _check(named, other, report, common)


def _describe(named: str, cfg: RobotCfg, report: Report, common: Common) -> None:
    from armside.kinematics.symbolic.description import as_latex, as_text, describe

    with checking_input():
        found = describe(load_robot(named).arm.robot)
    singular = found.singularities
    values: dict[str, Any] = {
        "table": [[as_text(value) for value in row] for row in found.table],
        "zero_pose": [[float(x) for x in found.zero_pose.row(i)] for i in range(4)],
        "reach": found.reach,
        "singular": {k: str(value) for k, value in vars(singular).items()} if singular else {},
    }
    if cfg.latex:
        report.lines(as_latex(found).splitlines())
    else:
        print_description(report, found.robot, values)
    outcome = _summary("model", named, None, common, values)
    if cfg.plot or common.out is not None:
        with run_folder(outcome, common) as folder:
            if cfg.plot:
                from ..figures.frames import draw

                draw(folder / "frames.png", found.robot)
        report.line(str(folder.path))
    report.summary(outcome)


def _check(named: str, model: Path | None, report: Report, common: Common) -> None:
    with checking_input():
        cell = find_cell(named)
        loaded = load_model(cell.xml if model is None else model)
    examined = Examination(loaded, cell)
    checks, found = examined.checks(), numbers(examined)
    found["checks"] = [asdict(check) | {"holds": check.holds} for check in checks]
    failed = [check for check in checks if not check.holds]
    outcome = _summary("check", named, model, common, found)
    outcome["status"] = "failed" if failed else "done"
    report.keep(outcome)
    print_check(report, found, checks)
    report.summary(outcome)
    if failed:
        fail = ", ".join(f"{check.statement} is {check.ours:.4g}" for check in failed)
        axis = examined.first_axis
        where = "" if axis is None else f"; axis {axis} is the first that moves the tool otherwise"
        raise RunFailed(f"{len(failed)} of {len(checks)} verdicts fail: {fail}{where}")


def _show(named: str, model: Path | None, report: Report, common: Common) -> None:
    with checking_input():
        cell = find_cell(named)
        loaded = cell_model(cell, model)
    examined = Examination(loaded, cell)
    found = {"table": table_of(cell.robot), "axes": axes_of(examined)}
    found["estimates"] = estimates_of(examined)
    print_data(report, cell.robot.name, found)
    outcome = _summary("show", named, model, common, found)
    if common.out is not None:
        from ..viewers.sliders import draw_robot

        with run_folder(outcome, common) as folder:
            draw_robot(folder / "robot.png", loaded, cell)
    report.summary(outcome)


def _build(named: str, report: Report, common: Common) -> None:
    from armside.sim.robot_file.written import built_files

    with checking_input():
        cell = find_cell(named)
        examined = Examination(cell_model(cell), cell)
        files = built_files(cell, Path(named).stem)
    found = {"files": sorted(files), "estimates": estimates_of(examined)}
    report.texts(files, _summary("build", named, None, common, found))


def _new(model: Path | None, cfg: RobotCfg, report: Report, common: Common) -> None:
    from armside.sim.robot_file.new_file import commented, read_source, template

    with checking_input():
        source = template() if model is None else read_source(model, cfg.tip)
        files = {"robot.toml": commented(source)}
    found = {"files": sorted(files), "axes": source.arm.robot.n_joints, "assumed": source.assumed}
    report.notes([source.assumed] if source.assumed else [])
    report.texts(files, _summary("new", source.origin, model, common, found))


def _summary(
    action: str, named: str, model: Path | None, common: Common, found: dict[str, Any]
) -> dict[str, Any]:
    asked = {"action": action, "model": model, "robot": named}
    return summary("robot", asked, common, **{"status": "done"} | found)
