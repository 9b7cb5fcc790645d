"""What a command leaves behind when something outside of it goes wrong: docs/faults.md."""

import os
import re
import signal
import subprocess
import sys
from pathlib import Path

import pytest

from armside.sim.records.atomic import STAGED, remove_stale, staged

ROOT = Path(__file__).parents[2]
INTERRUPTIONS = {
    "interrupted": (130, signal.SIGINT),
    "terminated": (143, signal.SIGTERM),
    "hung-up": (129, signal.SIGHUP),
}


@pytest.mark.parametrize("end", INTERRUPTIONS)
def test_a_signal_ends_a_run_in_one_line_and_leaves_nothing(armside_process, tmp_path, end):
    status, out, err = armside_process(f"probe --end {end}")
    assert (status, out) == (INTERRUPTIONS[end][0], "")
    assert err == "armside: interrupted, nothing was kept\n"
    assert [path.name for path in tmp_path.rglob("*")] == ["runs"]


def test_a_signal_after_the_results_are_there_says_where(armside_process, tmp_path):
    status, _, err = armside_process("probe --end late --out kept")
    assert (status, err) == (130, "armside: interrupted; the results are complete in kept\n")
    assert (tmp_path / "kept" / "summary.json").exists()


def test_below_nohup_a_terminal_that_closes_ends_nothing(armside_process):
    def ignore():
        signal.signal(signal.SIGHUP, signal.SIG_IGN)

    assert armside_process("probe --end hung-up-only", preexec_fn=ignore).status == 0


EARLY = """
import signal, sys
from armside.scripts import cli
signal.signal(signal.SIGALRM, lambda *_: signal.raise_signal(signal.SIGINT))
signal.setitimer(signal.ITIMER_REAL, 0.01)  # in the midst of the imports
sys.argv = ["armside", "--help"]
sys.exit(cli.main())
"""
SWALLOWED = """
import ctypes, os, signal, sys
from armside.scripts.shell import runner as process
process.begin(debug=False)
called = ctypes.CFUNCTYPE(None)(lambda: os.kill(os.getpid(), signal.SIGINT))
called()  # what is raised in a function that compiled code calls is lost
try:
    signal.pause()
except KeyboardInterrupt:
    sys.exit(130)
"""


def ended(code: str) -> tuple[int, str, str]:
    done = subprocess.run([sys.executable, "-c", code], capture_output=True, text=True, timeout=60)
    return done.returncode, done.stdout, done.stderr


def test_ctrl_c_while_python_imports_is_one_line():
    assert ended(EARLY) == (130, "", "armside: interrupted, nothing was kept\n")


def test_ctrl_c_that_compiled_code_swallows_comes_again():
    assert ended(SWALLOWED) == (130, "", "")


CLOSED = [(1,), (0, 1, 2)]
if os.environ.get("ARMSIDE_CI"):
    CLOSED += [(0,), (0, 1), (2,)]


@pytest.mark.parametrize("closed", CLOSED)
def test_closed_streams_lead_nowhere_and_the_run_is_kept(armside_process, tmp_path, closed):
    def close():
        for descriptor in closed:
            os.close(descriptor)

    status, _, err = armside_process("probe --out kept", preexec_fn=close)
    assert (status, err) == (0, "")
    assert (tmp_path / "kept" / "signals.parquet").read_bytes() == b""
    assert armside_process("probe --radius 0", preexec_fn=close).status == 2


def test_a_full_disk_behind_stderr_leaves_the_status(armside_process):
    with open("/dev/full", "w") as full:
        assert armside_process("probe --radius nan", stderr=full).status == 2
        assert armside_process("probe --end bug", stderr=full).status == 1


def test_what_a_killed_run_left_is_removed_by_the_next_one_there(armside_process, tmp_path):
    assert armside_process("probe --end killed --out a").status == -signal.SIGKILL
    (left,) = tmp_path.iterdir()
    assert STAGED.fullmatch(left.name)
    assert armside_process("probe --out b").status == 0
    assert [path.name for path in tmp_path.iterdir()] == ["b"]


@pytest.mark.parametrize("folder", [True, False])
def test_what_a_living_process_writes_stays(tmp_path, folder):
    with staged(tmp_path / "a", folder=folder) as ours:
        code = f"from armside.sim.records import atomic; atomic.remove_stale({str(tmp_path)!r})"
        done = [sys.executable, "-c", code.replace("(", "(__import__('pathlib').Path(", 1) + ")"]
        subprocess.run(done, check=True)
        assert ours.exists()
    assert not list(tmp_path.iterdir())


def test_names_of_others_are_left_alone(tmp_path):
    names = [".a.partial", ".a.123.partial", "a.0a1b2c3d.partial", ".a.0a1b2c3d.partial~"]
    for name in names:
        (tmp_path / name).touch()
    (tmp_path / "kept").mkdir()
    (tmp_path / "kept" / "file").touch()
    (tmp_path / ".a.0a1b2c3d.partial").symlink_to(tmp_path / "kept")
    remove_stale(tmp_path)
    assert (tmp_path / "kept" / "file").exists()  # a link is not followed
    assert {path.name for path in tmp_path.iterdir()} >= {*names, "kept"}


def test_a_working_folder_that_is_gone_is_one_line(armside_process, tmp_path):
    def leave():
        gone = tmp_path / "gone"
        gone.mkdir()
        os.chdir(gone)
        gone.rmdir()

    status, out, err = armside_process("probe", preexec_fn=leave)
    assert (status in (1, 2), out) == (True, "")
    assert err.startswith("armside: ")
    assert err.count("\n") == 1


def test_without_a_home_and_a_cache_it_works_in_silence(tmp_path):
    """In a fresh process: matplotlib tells of its folder when it is imported."""
    env = {"PATH": os.environ["PATH"], "HOME": "/proc/none", "XDG_CACHE_HOME": "/proc/none"}
    env |= {"XDG_CONFIG_HOME": "/proc/none", "MPLCONFIGDIR": "/proc/none"}
    command = [sys.executable, "-m", "armside", "robot", "model", "--plot", "--out", "a", "--quiet"]
    done = subprocess.run(
        command, cwd=tmp_path, env=env, capture_output=True, timeout=120, check=False
    )
    assert (done.returncode, done.stdout, done.stderr) == (0, b"", b"")
    assert (tmp_path / "a" / "frames.png").exists()


def test_of_several_processes_that_want_one_folder_one_gets_it_whole(armside_process, tmp_path):
    from concurrent.futures import ThreadPoolExecutor

    with ThreadPoolExecutor(3) as pool:
        ends = list(pool.map(armside_process, ["probe --out a"] * 3))
    assert sorted(end.status for end in ends)[0] == 0
    assert sum(end.status == 0 for end in ends) == 1
    assert all(end.err.count("\n") == 1 for end in ends if end.status)
    assert [path.name for path in tmp_path.iterdir()] == ["a"]


def test_each_promise_of_the_page_has_the_tests_that_it_names():
    page = (ROOT / "docs/faults.md").read_text(encoding="utf-8")
    written = "".join(file.read_text(encoding="utf-8") for file in (ROOT / "tests").rglob("*.py"))
    named = set(re.findall(r"`(test_\w+)`", page))
    assert len(named) > 20
    assert not [name for name in named if f"def {name}(" not in written]
