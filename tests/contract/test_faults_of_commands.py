"""Every command that writes, on a full disk and killed: nothing looks finished, and it goes on.

Commands that take longer than seconds (identify, compare, commission, train) write
through the same two doors, `RunFolder` and `atomic`.
"""

import os
import signal

import pytest

from armside.sim.records.atomic import STAGED

from . import files
from . import isolated as faults
from .claim import WAITING, prepared
from .isolated import run

SECONDS = 60.0
COMMANDS = {
    "laser": "laser --iterations 0 --out a",
    "cut": "cut ../files/contour.toml --plan-only --out a",
    "imu": "imu --motion rest --off 3 --on 3 --out a",
    "csv": "convert ../files/run --file a.csv",
    "mat": "convert ../files/run --to mat --file a.mat",
    "hdf5": "convert ../files/run --to hdf5 --file a.h5",
    "mcap": "convert ../files/run --to mcap --file a.mcap",
    "replay": "replay ../files/run --save a.rrd",
    "tune": "tune --trials 1 --episodes 1 --iterations 1 --pose p1 --out a",
    "sweep": "sweep iterations=0 --workers 1 --into a",
    "robot-model": "robot model --plot --out a",
    "robot": "robot check --out a",
    "export": "export --out a",
    "calibrate-arm": f"calibrate-arm ../files/{files.POSES} --robot ur10 --harmonics 0 --out a",
    "gears": f"gears ../files/{files.MOTION} --robot ur10 --largest-order 60 --out a",
    "reproduce": "reproduce 8.3 --out a",
    "measure": "measure ../files/data.csv --gear 1 --out a",
    "design": "design --out a",
}
TRIED = (
    tuple(COMMANDS)
    if os.environ.get("ARMSIDE_CI")
    else ("laser", "csv", "mcap", "replay", "tune", "sweep", "reproduce", "robot-model", "export")
)
"""In CI every command; else one for each way to write."""
GO_ON = {"tune": "runs", "sweep": "a", "reproduce": "a"}
"""Commands that keep what is done on the way, and where."""


@pytest.fixture(scope="module")
def isolated(tmp_path_factory):
    """Runs a command line in a process of its own, in a folder beside that of the files."""
    root = tmp_path_factory.mktemp("faults")
    context = prepared(root)

    def one(name, folder, fault=None):
        where = root / folder
        where.mkdir(exist_ok=True)
        done = run(context, (*COMMANDS[name].split(), "--quiet"), where, SECONDS, fault)
        return where, done._replace(err=WAITING.sub("", done.err))

    return one


def finished(folder, name):
    """Names of files that a person takes for results, in a folder of that command."""
    kept = folder / GO_ON.get(name, "none")
    names = [path for path in folder.rglob("*") if path.is_file() and kept not in path.parents]
    return [path for path in names if not any(map(STAGED.fullmatch, path.parts))]


@pytest.mark.parametrize("name", TRIED)
def test_a_full_disk_is_one_line_and_leaves_no_short_file(isolated, name):
    folder, done = isolated(name, f"full-{name}", faults.disk_full)
    status = 2 if name == "tune" else 1  # whose database is opened before work begins
    assert (done.status, done.err.count("\n"), done.err[:9]) == (status, 1, "armside: ")
    assert not finished(folder, name)
    assert not [path for path in folder.rglob("*") if STAGED.fullmatch(path.name)]


@pytest.mark.parametrize("name", TRIED)
def test_a_killed_command_leaves_nothing_finished_and_can_be_repeated(isolated, name):
    folder, killed = isolated(name, f"killed-{name}", faults.killed)
    assert (killed.status, killed.err) == (-signal.SIGKILL, "")
    assert not finished(folder, name)
    folder, again = isolated(name, f"killed-{name}")
    assert (again.status, again.err) == (0, "")
    assert finished(folder, name) or name in GO_ON
    assert not [path for path in folder.rglob("*") if STAGED.fullmatch(path.name)]


@pytest.mark.parametrize("name", ["laser", "csv", "replay", "reproduce"])
@pytest.mark.parametrize(
    ("fault", "status"), [(faults.terminated, 143), (faults.hung_up, 129), (faults.removed, 1)]
)
def test_a_signal_or_a_removed_folder_at_the_last_moment_is_one_line(isolated, name, fault, status):
    folder, done = isolated(name, f"{status}-{name}", fault)
    assert (done.status, done.err.count("\n"), done.err[:9]) == (status, 1, "armside: ")
    assert not finished(folder, name)


@pytest.mark.parametrize("name", ["laser", "tune", "robot-model"])
def test_without_stdout_home_and_cache_the_results_are_there(isolated, name):
    for fault in (faults.no_stdout, faults.no_home):
        folder, done = isolated(name, f"{fault.__name__}-{name}", fault)
        assert (done.status, done.err) == (0, "")
        assert (folder / "a" / "summary.json").is_file()


@pytest.mark.parametrize("name", ["laser", "robot-model", "calibrate-arm", "measure"])
def test_of_two_runs_into_one_folder_the_first_is_kept_whole(isolated, name):
    folder, done = isolated(name, f"overtaken-{name}", faults.overtaken)
    assert (done.status, done.err.count("\n"), done.err[:9]) == (1, 1, "armside: ")
    assert [path.name for path in folder.rglob("*") if path.is_file()] == ["theirs"]


@pytest.mark.parametrize("name", ["laser", "csv", "tune", "sweep"])
def test_a_clock_that_goes_back_changes_nothing(isolated, name):
    folder, done = isolated(name, f"clock-{name}", faults.clock_set_back)
    assert (done.status, done.err) == (0, "")
    assert finished(folder, name) or name in GO_ON
    assert not [path for path in folder.rglob("*") if STAGED.fullmatch(path.name)]
