"""A report is resumable, shows its failures, and never loses finished results."""

import json
import os
import re
import resource
import shutil
import signal
import subprocess
import sys
import time
from pathlib import Path

import numpy as np
import pytest

from armside.scripts.commands import reproduce
from armside.scripts.jobs import store as store_module
from armside.scripts.jobs.grid import Point
from armside.scripts.jobs.store import Store, code_fingerprint, digest
from armside.scripts.shell.console import Report
from armside.scripts.shell.errors import InputError
from armside.scripts.shell.options import Common
from armside.scripts.thesis import entries
from armside.scripts.thesis.entries import select
from armside.sim.evaluation.check import Check

HERE = Path(__file__).parent
PROBES = ("three", "one_killed", "one_raised", "slow", "large")
START = f"""
import sys
sys.path.insert(0, {str(HERE)!r})
from armside.scripts import cli
from armside.scripts.thesis import entries
import probe_part
entries.chapters = lambda: {{"probes": probe_part.entries({PROBES!r})}}
sys.exit(cli.main())
"""


class Serial:
    """In place of worker processes, where these are not what a test is about."""

    def __enter__(self):
        return self

    def __exit__(self, *_):
        pass

    def results(self, function, items):
        for item in items:
            try:
                outcome = function(item)
            except Exception as error:
                outcome = error
            yield item, outcome


def parts(folder: Path) -> list[Path]:
    """Files of finished results in the folder of a report."""
    return sorted((folder / "results").glob("*.npz"))


@pytest.fixture
def reproduced_by_workers(armside, monkeypatch):
    """Runs `armside reproduce` on probe sections, in an empty working folder."""
    from probe_part import entries as of_probes  # the fixture `armside` makes it importable

    monkeypatch.setattr(entries, "chapters", lambda: {"probes": of_probes(PROBES)})

    def run(line: str):
        return armside(f"reproduce {line} --out report")

    return run


@pytest.fixture
def reproduced(reproduced_by_workers, monkeypatch):
    """The same without the seconds that processes take to start."""
    monkeypatch.setattr(reproduce, "Workers", Serial)
    return reproduced_by_workers


def ran() -> list[str]:
    log = Path("ran.log")
    return log.read_text().split() if log.exists() else []


@pytest.mark.parametrize("seed", [0, 12])
def test_a_report_is_made_with_the_seed_given_and_says_so(reproduced, seed):
    from probe_part import SEEDS

    SEEDS.clear()
    assert reproduced(f"three --seed {seed}").status == 0
    assert [seed] == SEEDS
    for page in ("report.md", "report.html"):
        assert f"`armside reproduce three --seed {seed}`" in Path("report", page).read_text()
    assert json.loads(Path("report/report.json").read_text())["config"]["seed"] == seed


def test_a_report_is_two_pages_of_which_one_needs_nothing_else(reproduced):
    status, _, err = reproduced("three")
    assert (status, err) == (0, "")
    page = Path("report/report.html").read_text()
    assert "data:image/png;base64," in page
    assert "A &lt;probe&gt; &amp; more" in page
    assert not re.search(r"<script|https?://|src=\"(?!data:)|<link", page)
    text = Path("report/report.md").read_text()
    assert "(figures/probe.png)" in text
    assert Path("report/figures/probe.png").exists()


def test_what_fails_is_shown_as_failing_with_its_reason(reproduced):
    _, out, _ = reproduced("three")  # 2 + 2 + 2 is not <= 1
    assert "FAILS" in out
    assert "p1 fails: twos" in out
    for page in ("report.md", "report.html"):
        text = Path("report", page).read_text()
        assert "FAILS" in text
        assert "twos" in text
        assert "0 of 1 comparisons with the thesis hold" in text
    marker = json.loads(Path("report/report.json").read_text())
    assert marker["sections"][0]["checks"][0]["holds"] is False


@pytest.mark.parametrize(
    ("ours", "low", "high", "holds"),
    [
        (1.0, 1.0, None, True),
        (0.99, 1.0, None, False),
        (1.0, None, 1.0, True),
        (1.01, 0.0, 1.0, False),
        (float("nan"), 0.0, 1.0, False),
        (float("inf"), 0.0, None, False),
    ],
)
def test_a_verdict_follows_from_number_and_band(ours, low, high, holds):
    check = Check("c", "s", "t", ours, low=low, high=high)
    assert check.holds is holds


def test_a_comparison_without_a_band_is_refused():
    with pytest.raises(ValueError, match="needs a band"):
        Check("c", "s", "t", 1.0)


def test_what_is_done_is_not_run_again(reproduced):
    reproduced("three")
    assert sorted(ran()) == ["a", "b", "c"]
    status, out, _ = reproduced("three")
    assert status == 0
    assert sorted(ran()) == ["a", "b", "c"]
    assert "0 experiments run, 3 known from before" in " ".join(out.split())


def test_a_damaged_result_is_run_again_and_a_second_call_adds_its_section(reproduced):
    reproduced("three")
    first = parts(Path("report"))[0]
    first.write_bytes(first.read_bytes()[:100])
    assert reproduced("three")[0] == 0
    assert len(ran()) == 4
    reproduced("large")
    assert Path("report/report.md").read_text().count("## A <probe>") == 2


def test_a_killed_worker_is_reported_and_what_finished_stays(reproduced_by_workers):
    status, _, err = reproduced_by_workers("one_killed")
    assert status == 1
    assert "worker process was killed" in err
    assert "are kept in report" in err
    assert not Path("report/report.html").exists()
    assert len(parts(Path("report"))) == 3
    Path("ran.log.spare").touch()  # from now on nothing is killed
    before = len(ran())
    assert reproduced_by_workers("one_killed")[0] == 0
    assert len(ran()) == before + 1


def test_an_experiment_that_fails_is_named_and_the_others_stay(reproduced):
    status, _, err = reproduced("one_raised")
    assert status == 1
    assert "1 of 2 experiments failed" in err
    assert "this experiment cannot be done" in err
    assert len(parts(Path("report"))) == 1


def start(line: str, folder: Path, **options) -> subprocess.Popen:
    command = [sys.executable, "-c", START, *line.split()]
    return subprocess.Popen(command, cwd=folder, stderr=subprocess.PIPE, text=True, **options)


def wait_for_results(folder: Path, count: int) -> None:
    deadline = time.monotonic() + 30.0
    while time.monotonic() < deadline:
        if len(parts(folder / "report")) >= count:
            return
        time.sleep(0.02)
    raise AssertionError("no results in time")


def test_what_was_finished_before_kill_9_or_ctrl_c_is_not_run_again(tmp_path):
    """At most what was under way is lost, and Ctrl-C says how to go on."""

    def begun_and_kept() -> tuple[int, int]:
        return len((tmp_path / "ran.log").read_text().split()), len(parts(tmp_path / "report"))

    running = start("reproduce slow --out report --quiet", tmp_path)
    wait_for_results(tmp_path, 3)
    running.kill()
    running.wait()
    running.communicate()  # the pipe closes when the workers have ended too
    begun, kept = begun_and_kept()
    assert 3 <= kept < 12
    assert begun - kept <= len(os.sched_getaffinity(0)) + 1  # one may be queued beyond the cores
    running = start("reproduce slow --out report", tmp_path)
    wait_for_results(tmp_path, kept + 1)
    running.send_signal(signal.SIGINT)
    _, err = running.communicate(timeout=30)
    assert running.returncode == 130
    assert err == (
        "armside: interrupted; what is finished is kept in report, repeat the command to go on\n"
    )
    begun, kept = begun_and_kept()
    again = start("reproduce slow --out report --quiet", tmp_path)
    assert again.communicate(timeout=60)[1] == ""
    assert again.returncode == 0
    assert begun_and_kept() == (begun + 12 - kept, 12)


def test_a_full_disk_is_reported_and_what_was_written_before_stays(tmp_path):
    def small_files() -> None:
        resource.setrlimit(resource.RLIMIT_FSIZE, (200_000, 200_000))

    running = start("reproduce large --out report --quiet", tmp_path, preexec_fn=small_files)
    _, err = running.communicate(timeout=60)
    assert running.returncode == 1
    assert "File too large" in err
    assert err.count("\n") == 1
    assert len(parts(tmp_path / "report")) == 1  # the small one
    assert not list((tmp_path / "report" / "results").glob(".*.partial"))
    assert start("reproduce large --out report --quiet", tmp_path).communicate(timeout=60)[1] == ""
    assert len((tmp_path / "ran.log").read_text().split()) == 3


def test_two_reports_in_one_folder_share_the_work(tmp_path):
    both = [start("reproduce slow --out report --quiet", tmp_path) for _ in range(2)]
    assert [process.communicate(timeout=60)[1] for process in both] == ["", ""]
    assert len((tmp_path / "ran.log").read_text().split()) == 12


@pytest.mark.parametrize(
    ("name", "content", "message"),
    [
        ("thesis.txt", "mine", "report is not empty"),
        ("report.json", "not json", "report cannot be read as a report"),
        ("report.json", '{"kind": "other"}', "not of ours"),
    ],
)
def test_a_foreign_folder_is_refused_by_name_and_left_alone(reproduced, name, content, message):
    Path("report").mkdir()
    Path("report", name).write_text(content)
    status, _, err = reproduced("three")
    assert status == 2
    assert message in err
    assert err.count("\n") == 1
    assert [file.name for file in Path("report").iterdir()] == [name]
    assert Path("report", name).read_text() == content


def test_an_unreadable_section_of_an_earlier_report_is_named(reproduced):
    reproduced("three")
    Path("report/sections/three.json").write_text("{")
    status, _, err = reproduced("large")
    assert status == 2
    assert "three.json is not a section of a report" in err


def test_ids_select_chapters_figures_and_rows():
    chapter = {entry.id for entry in select(["9"])}
    assert chapter >= {"9.5", "9.6", "9.17", "repeatability"}
    assert not chapter & {"F07", "9-map"}  # minutes: only by name
    assert [entry.id for entry in select(["X08"])] == ["9.9", "9.10", "9.11"]
    assert [entry.id for entry in select(["9.10"])] == ["repeatability", "9.10"]
    assert [entry.id for entry in select(["F07", "9.5"])] == ["9.5", "F07"]
    chapters = entries.chapters()
    numbered = [entry for name in "589" for entry in chapters[name]]
    assert select([]) == [entry for entry in numbered if not entry.alone]
    assert [entry.id for entry in select(["S02", "E10"])] == ["5.10", "8.4", "8.5"]
    assert [entry.id for entry in select(["8.7", "5.6"])] == ["5.5", "8.7"]
    with pytest.raises(InputError, match=r"Unknown figure, chapter or row '9.4'.*9.5"):
        select(["9.4"])


def test_every_row_of_its_chapters_and_every_command_of_the_page_of_the_thesis_is_known():
    page = (HERE.parents[1] / "docs" / "thesis.md").read_text(encoding="utf-8")
    rows = re.findall(r"^\| ([ESX]\d\d) \|", page, re.MULTILINE)
    assert len(rows) == 26
    commands = re.findall(r"`armside reproduce ([^`]+)`", page)
    without_numbers = {"X01", "X02", "X03"}  # how the experiments are made
    for names in [*commands, *(set(rows) - without_numbers)]:
        assert select(names.split())
    assert len(set(entries.order())) == len(entries.order())


def test_each_file_of_a_chapter_is_a_chapter():
    folder = Path(entries.__file__).parent
    names = {file.stem for file in folder.iterdir() if file.stem.startswith("chapter")}
    assert names == {"chapter5", "chapter8", "chapter9", "chapter_papers", "chapter_real"}
    assert list(entries.chapters()) == ["5", "8", "9", "papers", "real"]


def test_a_changed_constant_in_any_package_makes_the_store_ask_again(tmp_path, monkeypatch):
    monkeypatch.syspath_prepend(HERE)
    from probe_part import ProbeJob

    for package in store_module.PACKAGES:
        skipped = shutil.ignore_patterns("__pycache__", "*.xml")
        shutil.copytree(store_module.OURS / package, tmp_path / package, ignore=skipped)
    monkeypatch.setattr(store_module, "OURS", tmp_path)
    store, job = Store(tmp_path / "results"), ProbeJob("a", "log")
    for package in store_module.PACKAGES:
        code_fingerprint.cache_clear()
        store.keep(digest(job), job, {"value": np.arange(3.0)})
        row = Point("0" * 16, {}, 0).failed(ValueError())
        assert np.array_equal(store.load(job)["value"], np.arange(3.0))
        assert store.status(digest(job)) == "done"
        assert store.status(digest(ProbeJob("b", "log"))) is None
        with sorted((tmp_path / package).rglob("*.py"))[-1].open("a") as module:
            module.write("CONSTANT = 2\n")
        code_fingerprint.cache_clear()
        assert store.status(digest(job)) is None, package
        assert Point("0" * 16, {}, 0).failed(ValueError())["code"] != row["code"], package
    code_fingerprint.cache_clear()


def test_progress_counts_weights_without_a_terminal():
    with Report(Common(quiet=True)).progress("working", 3.0, weighted=True) as step:
        step(1.5)
        step(1.5)
