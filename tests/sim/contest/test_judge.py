"""Tasks by the seal, and entries that lose one task and no other."""

import hashlib
import json
from dataclasses import replace
from pathlib import Path

import numpy as np
import pytest

from armside.sim.contest import worker
from armside.sim.contest.entry_process import ISOLATED, EntryProcess
from armside.sim.contest.joint_track import RANGES, TRACK, draw, left
from armside.sim.contest.judge import LARGEST, begun, checked, judged, play, read_result
from armside.sim.contest.seal import Round, new_round, read_round
from armside.sim.contest.task import Limits
from armside.sim.contest.tracks import NAMES
from armside.sim.records.files import InputError

WORKER = worker.__file__
SALT = b"s" * 32
SEALED = Round("2026-a", hashlib.sha256(SALT).hexdigest(), SALT)
SHORT = replace(TRACK, runs=3, seconds=2.0)
ENTRY = """
import numpy as np, os, time
class Entry:
    k = 0
    def start(self, task):
        self.shape = task.reference.shape
        return np.zeros(self.shape)
    def update(self, records):
        self.k += 1
        {body}
"""
LOSING = {
    "raise ValueError('no')": "ValueError: no",
    "time.sleep(60)": "no answer in time",
    "return np.full(self.shape, np.nan)": "not finite",
    "return np.zeros((5, 2))": "returned the shape (5, 2), not (800, 1)",
    "return np.full(self.shape, 1e3)": "beyond the robot's limits",
    "return 'text'": "ValueError: could not convert",
    "os._exit(0)": "the process ended",
    "import sys; sys.exit()": "SystemExit",
}


def test_a_task_is_that_of_hmac_sha256_of_salt_round_track_and_index():
    import hmac

    text = b"2026-a/joint/7"
    first = int(hmac.new(SALT, text, hashlib.sha256).hexdigest(), 16)
    assert SEALED.key("joint", 7) == first
    one, same, next_ = (draw(SEALED, i).given["reference"] for i in (7, 7, 8))
    assert np.array_equal(one, same)
    assert not np.array_equal(one, next_)
    assert not np.array_equal(one, draw(Round(), 7).given["reference"])


def test_judged_ranges_contain_those_of_development_and_exceed_most():
    for public, sealed in RANGES.values():
        assert sealed[0] <= public[0] < public[1] <= sealed[1]
    assert np.mean([public != sealed for public, sealed in RANGES.values()]) > 0.5


def test_a_round_is_published_without_its_salt_and_refuses_another(tmp_path):
    made = new_round("2026-b", tmp_path)
    text = (tmp_path / "2026-b.json").read_text()
    assert made.salt.hex() not in text
    assert hashlib.sha256(made.salt).hexdigest() in text
    assert (tmp_path / "2026-b.salt").stat().st_mode & 0o077 == 0
    for salt in (str(tmp_path / "2026-b.salt"), made.salt.hex()):
        assert read_round(tmp_path / "2026-b.json", salt) == made
    with pytest.raises(InputError, match="not that of the round"):
        read_round(tmp_path / "2026-b.json", "00" * 32)
    with pytest.raises(InputError, match="exists already"):
        new_round("2026-b", tmp_path)


def test_what_an_entry_is_given_holds_no_truth():
    given = draw(Round(), 0).given
    assert set(given) == {
        "track",
        "reference",
        "path",
        "runs",
        "sample_time",
        "seed",
        "nominal",
        "limits",
    }
    assert given["nominal"] == draw(Round(), 1).given["nominal"]


@pytest.mark.parametrize(("body", "why"), LOSING.items())
def test_an_entry_at_fault_loses_that_task_alone(body, why):
    task = draw(Round(), 0)
    moved = []
    watched = replace(task, run=lambda k, u: moved.append(np.abs(u).max()) or task.run(k, u))
    with EntryProcess() as process:
        lost = play(ENTRY.format(body=body), watched, SHORT, process)
        assert why in lost["reason"]
        assert (lost["left"], lost["harm"], lost["runs"]) == (LARGEST, True, 1)
        assert max(moved) == 0.0  # nothing but the run without correction
        well = play(ENTRY.format(body="return np.zeros(self.shape)"), task, SHORT, process)
    assert (well["reason"], well["runs"]) == ("", 3)
    assert well["left"] == pytest.approx(1.0, abs=0.02)  # the encoder's noise acts on the joint
    assert not well["harm"]


def test_a_process_that_does_not_start_is_no_fault_of_the_entry(tmp_path, monkeypatch):
    monkeypatch.setattr(worker, "__file__", str(tmp_path / "none.py"))
    with EntryProcess() as process, pytest.raises(InputError, match=r"does not start .*python"):
        play(ENTRY, draw(Round(), 0), SHORT, process)


KINDS = {
    "raise ValueError(repr(vars(task)))": "raised",
    "time.sleep(60)": "hung",
    "return np.zeros((5, 2))": "wrong shape",
    "return np.full(task.reference.shape, np.nan)": "not finite",
    "return np.full(task.reference.shape, 1e3)": "beyond limits",
    "os._exit(0)": "ended",
}
SAYING = "import numpy as np, os, time\nclass Entry:\n def start(self, task):\n  "


@pytest.mark.parametrize(("body", "kind"), KINDS.items())
def test_a_judged_round_gives_no_reason_in_the_words_of_the_entry(body, kind):
    with EntryProcess(judged=True) as process:
        assert play(SAYING + body, draw(SEALED, 0), SHORT, process)["reason"] == kind


@pytest.mark.parametrize("again", [False, True])
def test_a_judged_round_without_isolation_runs_nothing_of_an_entry(again, tmp_path, monkeypatch):
    entry, file = tmp_path / "e.py", tmp_path / "e.json"
    entry.write_text(f"open({str(tmp_path / 'ran')!r}, 'w')\n" + ENTRY.format(body="return None"))
    monkeypatch.setattr(worker, "__file__", str(tmp_path / "worker.py"))
    text = Path(WORKER).read_text()
    text = text.replace('if asked["isolate"]:', "if False:").replace("os.getuid() == 0", "False")
    (tmp_path / "worker.py").write_text(text)
    result = begun("e", entry.read_text(), "joint", SEALED)
    row = {"index": 0, "left": 1.0, "curve": [1.0], "harm": False, "reason": ""}
    result["tasks"] = [row | {"isolation": [*ISOLATED]}]
    ways = {
        False: lambda: judged(file, entry, "joint", SEALED, 1, lambda: None),
        True: lambda: list(checked(result, entry.read_text(), SEALED, 1)),
    }
    with pytest.raises(InputError, match="a judged round needs a system that grants namespaces"):
        ways[again]()
    assert not (tmp_path / "ran").exists()


@pytest.mark.parametrize(
    ("u", "beyond"),
    [
        ([[0.0], [1.0], [1.9]], ""),
        ([[0.0], [1.0], [2.1]], "correction of column 1 is 2.1 rad, at most 2"),
        ([[1.6], [1.6], [1.6]], "change in one sample of column 1 is 1.6 rad, at most 1.5"),
    ],
)
def test_limits_are_of_size_and_of_change(u, beyond):
    limits = Limits(correction=np.array([2.0]), change=np.array([1.5]))
    assert limits.exceeded(np.array(u)) == beyond


def test_the_joint_is_scored_at_5_10_and_40_and_by_the_last_run_of_one_that_stops():
    errors, plain = np.full(41, 9.0), np.array([2.0])
    errors[[5, 10, 40]] = 1.0, 2.0, 4.0
    assert left(errors, plain) == pytest.approx((1.0 * 2.0 * 4.0) ** (1 / 3) / 2.0)
    assert left(np.array([9.0, 3.0]), plain) == pytest.approx(1.5)


def test_the_true_error_is_that_without_the_noise_of_the_encoder():
    task = draw(Round(), 3)
    records, true = task.run(0, np.zeros_like(task.given["reference"]))
    seen = np.sqrt(np.mean(records["error"] ** 2))
    assert true == pytest.approx(seen, rel=0.05)
    assert true != seen


def test_a_result_is_gone_on_from_and_checked(tmp_path):
    entry, file = tmp_path / "e.py", tmp_path / "e.json"
    entry.write_text(ENTRY.format(body="return None"))
    steps = []
    judged(file, entry, "joint", SEALED, 2, lambda: steps.append(1))
    before = read_result(file)["tasks"]
    after = judged(file, entry, "joint", SEALED, 3, lambda: steps.append(1))["tasks"]
    assert before == after[:2]
    assert [row["index"] for row in after] == [0, 1, 2]
    assert len(steps) == 5
    result, source = read_result(file), entry.read_text()
    assert list(checked(result, source, SEALED, 3)) == []
    assert "another one" in next(checked(result, "class Entry: pass", SEALED, 3))
    file.write_text(file.read_text().replace('"numpy": "', '"numpy": "0.'))
    with pytest.raises(InputError, match="something else"):
        judged(file, entry, "joint", SEALED, 3, lambda: None)
    entry.write_text(ENTRY.format(body="return 0"))
    file.write_text(file.read_text().replace('"numpy": "0.', '"numpy": "'))
    with pytest.raises(InputError, match=r"result of another e\.py: .* has changed since"):
        judged(file, entry, "joint", SEALED, 3, lambda: None)


CHANGED = {
    "left": 0.5,
    "harm": True,
    "runs": 2,
    "curve": [0.5],
}


def test_a_result_that_lacks_a_task_or_says_other_than_its_replay_is_found(tmp_path):
    entry, file = tmp_path / "e.py", tmp_path / "e.json"
    entry.write_text(ENTRY.format(body="return None"))
    result, source = judged(file, entry, "joint", SEALED, 2, lambda: None), entry.read_text()
    for name, value in CHANGED.items():
        forged = result | {"tasks": [row | {name: value} for row in result["tasks"]]}
        said = "left is" if name == "curve" else f"{name} is "
        assert said in next(checked(forged, source, SEALED, 2))
    bare = result | {"tasks": [row | {"isolation": []} for row in result["tasks"]]}
    assert "without the isolation" in next(checked(bare, source, SEALED, 2))
    for kept in (result["tasks"][:1], result["tasks"][1:], []):
        assert "lacks" in next(checked(result | {"tasks": kept}, source, SEALED, 2))
    assert "lacks" in next(checked(result, source, SEALED, 3))


def test_every_task_of_a_result_is_held_against_its_own_curve(tmp_path):
    """Not the tenth alone that is played again."""
    entry, file = tmp_path / "e.py", tmp_path / "e.json"
    entry.write_text(ENTRY.format(body="return None"))
    result, source = judged(file, entry, "joint", SEALED, 2, lambda: None), entry.read_text()
    rows = [*result["tasks"], *(result["tasks"][0] | {"index": i} for i in range(2, 40))]
    rows[30] = rows[30] | {"left": 1e-4}
    forged = result | {"tasks": rows}
    assert "task 30: left is 0.0001, which" in next(checked(forged, source, SEALED, 40))


BROKEN = [
    {"curve": [[1.0], [2.0, 3.0]]},
    {"curve": "x"},
    {"curve": [-1.0]},
    {"harm": -7},
    {"seconds": -5.0},
    {"seconds": float("nan")},
    {"reason": "\x1b[31m"},
    {"isolation": "all"},
    {"runs": 1.5},
]


@pytest.mark.parametrize("change", BROKEN, ids=str)
def test_a_result_with_a_task_that_is_none_is_refused_in_a_line(tmp_path, change):
    entry, file = tmp_path / "e.py", tmp_path / "e.json"
    entry.write_text(ENTRY.format(body="return None"))
    result = judged(file, entry, "joint", SEALED, 1, lambda: None)
    file.write_text(json.dumps(result | {"tasks": [result["tasks"][0] | change]}))
    with pytest.raises(InputError, match="has a task that is none"):
        read_result(file)
    for name in (["a"], "[bold]best[/bold]", ""):
        file.write_text(json.dumps(result | {"entry": result["entry"] | {"name": name}}))
        with pytest.raises(InputError, match="the name of an entry"):
            read_result(file)


def test_tracks_are_those_of_the_rules():
    assert NAMES == ("joint", "motor", "imu", "tracker", "first", "drift", "part")


def test_a_run_that_is_not_finite_loses_the_task_and_none_at_first_is_no_correction():
    task = draw(Round(), 0)
    with EntryProcess() as process:
        source = ENTRY.format(body="return np.zeros(self.shape)")
        lost = play(source, replace(task, run=lambda k, u: ({}, np.nan)), SHORT, process)
        assert (lost["reason"], lost["left"]) == ("a run of the robot is not finite", LARGEST)
        stopped = play("class Entry:\n def start(self, task): pass", task, SHORT, process)
    assert stopped["runs"] == 0
    assert stopped["left"] == pytest.approx(1.0, abs=0.02)
