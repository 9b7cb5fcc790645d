"""`armside path-logs`: motor logs of a real robot on a path, beside the virtual large robot."""

from dataclasses import dataclass
from pathlib import Path

from armside.sim.records.summary import summary

from ..shell.console import Report, run_folder
from ..shell.errors import RunFailed, checking_input, one_line
from ..shell.options import Common, Limits, options


@options
@dataclass(frozen=True, kw_only=True)
class PathLogsOptions:
    """The robot, and the runs of the virtual one."""

    robot: str = "large"
    """Robot of the logs by name or a robot file; large has the geometry of an IRB6640."""
    runs: int = 3
    """Runs of the virtual large robot at each speed."""

    def __post_init__(self) -> None:
        Limits(2, 20).check("runs", self.runs)


def path_logs(
    data: Path, /, *, cfg: PathLogsOptions = PathLogsOptions(), common: Common = Common()
) -> None:
    """Compare repeated motor logs of a real robot with the virtual large robot on the same path.

    data: folder of waypoints (command.csv) and logs (docs/real.md). Writes summary.json and
    path-logs.png: error and scatter across the path by speed.
    """
    from armside.sim.recordings.paths import compare_logs
    from armside.sim.recordings.paths.waypoint_path import read_path_logs
    from armside.sim.robot_file.find import load_robot

    from ..figures import path_logs as shown

    report = Report(common)
    with checking_input():
        arm, logs = load_robot(cfg.robot).arm, read_path_logs(data)
        with report.progress("running", total=cfg.runs * len(logs.logs)) as step:
            try:
                done = compare_logs(arm, logs, cfg.runs, common.seed, step)
            except RuntimeError as error:
                raise RunFailed(one_line(error)) from error
    outcome = summary("path-logs", cfg, common, data=data, **shown.results(done))
    with run_folder(outcome, common) as folder:
        shown.draw(folder / "path-logs.png", done)
    shown.tables(report, done)
    report.results(outcome, folder.path)
