"""The tool itself: it mutates one place, restores the tree, and counts what it saw."""

import subprocess
import sys
from dataclasses import replace

import pytest

from . import month, session
from .generic import _program
from .mutant import ROOT, Mutant, curated
from .page import page, score
from .session import Session, Trial, trial
from .warm import TIMED_OUT
from .workspace import commit, copied, mutated

MUTANT = Mutant(name="sum", file="ilc/a.py", old="a + b", new="a - b", tests=("tests/ilc",))


@pytest.fixture
def tree(tmp_path):
    file = tmp_path / "ilc/a.py"
    file.parent.mkdir()
    file.write_text("def f(a, b):\n    return a + b\n\n\ndef g(a, b):\n    return 2 * a\n")
    return tmp_path


def test_a_fault_is_in_the_file_during_its_trial_and_gone_afterwards(tree):
    file = tree / "ilc/a.py"
    before, stamp = file.read_text(), file.stat().st_mtime_ns
    with mutated(MUTANT, tree):
        assert "a - b" in file.read_text()
        assert file.stat().st_mtime_ns != stamp
    assert (file.read_text(), file.stat().st_mtime_ns) == (before, stamp)
    with pytest.raises(KeyError), mutated(MUTANT, tree):
        raise KeyError
    assert file.read_text() == before


def test_compiled_code_of_a_folder_is_put_aside(tree):
    file = tree / "ilc/a.py"
    file.write_text("from numba import njit\n" + file.read_text())
    kept = tree / "ilc/__pycache__/a.nbi"
    kept.parent.mkdir()
    kept.write_text("old")
    with mutated(MUTANT, tree):
        assert not kept.exists()
    assert kept.read_text() == "old"


def test_a_place_is_the_first_behind_its_anchor():
    at = replace(MUTANT, at="def g", old="a", new="b")
    assert at.applied("def f: a\ndef g: a a") == "def f: a\ndef g: b a"
    for text in ("def f: a", "def g: a\ndef g: a", "a\ndef g: c"):
        with pytest.raises(ValueError, match=r"ilc/a\.py"):
            at.applied(text)
    with pytest.raises(ValueError, match="changes nothing"):
        replace(MUTANT, new="a + b")


def test_the_list_names_its_nearest_tests_file_by_file(tmp_path):
    (tmp_path / "one.toml").write_text(
        '[[file]]\npath = "ilc/a.py"\ntests = ["tests/x"]\nfaults = [\n'
        '  {name = "a", old = "1", new = "2"},\n'
        '  {name = "b", old = "3", new = "4", tests = ["tests/y"], found = true},\n]\n'
    )
    first, second = curated(tmp_path)
    assert (first.tests, second.tests) == (("tests/x",), ("tests/y",))
    assert (first.found, second.found) == (False, True)
    assert first.package == "ilc"
    assert len({first.key, second.key, replace(first, name="other").key}) == 2


@pytest.mark.parametrize(
    ("outcomes", "wider", "found"),
    [
        ([(1, "FAILED tests/ilc/t.py::a - x")], True, Trial(True, "tests/ilc/t.py::a")),
        ([(2, "ERROR tests/ilc/t.py")], True, Trial(True, "tests/ilc/t.py")),
        ([(0, ""), (1, "FAILED tests/ilc/w.py::b")], True, Trial(True, "tests/ilc/w.py::b")),
        ([(0, ""), (0, "")], True, Trial(False, "tests/ilc")),
        ([(0, "")], False, Trial(False, "tests/near")),
        (
            [(4, "ImportError while loading conftest '/a/tests/ilc/conftest.py'.")],
            True,
            Trial(True, "tests/ilc/conftest.py"),
        ),
        ([(TIMED_OUT, "")], True, Trial(True, "time limit")),
        ([(-11, "")], True, Trial(True, "signal 11")),
    ],
)
def test_nearest_tests_come_first_and_the_first_failure_ends_a_trial(
    tree, monkeypatch, outcomes, wider, found
):
    left = list(outcomes)
    monkeypatch.setattr(session, "run_pytest", lambda *_: left.pop(0))
    assert trial(replace(MUTANT, tests=("tests/near",)), tree, wider=wider) == found
    assert not left


def test_a_run_without_end_is_ended_by_its_processor_time_and_one_that_waits_is_not(tmp_path):
    """In a fresh process, as a worker of mutants is: collecting what hundreds of tests have left in
    this one takes seconds of its own."""
    (tmp_path / "test_endless.py").write_text("def test_it():\n    while True: pass\n")
    (tmp_path / "test_slow.py").write_text("import time\ndef test_it(): time.sleep(6.0)\n")
    code = (
        "import sys; from tests.mutation.warm import run_pytest; endless, slow = sys.argv[1:]; "
        "print(run_pytest([endless], 1.0)[0], run_pytest([slow], 5.0)[0])"
    )
    files = (str(tmp_path / f"test_{name}.py") for name in ("endless", "slow"))
    done = subprocess.run(
        [sys.executable, "-c", code, *files], cwd=ROOT, capture_output=True, text=True, check=True
    )
    assert done.stdout.split() == [str(TIMED_OUT), "0"]


def test_results_are_kept_between_sessions(tmp_path):
    Session(tmp_path)._keep(MUTANT, Trial(True, "t"))
    Session(tmp_path)._keep(MUTANT, Trial(False, "u", "1234abcd"))
    assert Session(tmp_path).results() == {MUTANT.key: Trial(False, "u", "1234abcd")}


def test_a_page_counts_what_was_tried_and_says_what_survives():
    survivor = replace(MUTANT, name="other", new="a * b", survives="too small to see")
    same = replace(MUTANT, name="same", new="b + a", equivalent="addition commutes")
    untried = replace(MUTANT, name="untried", new="0", found=True)
    results = {
        MUTANT.key: Trial(True, "tests/ilc/t.py::a[x|y]", "1234abcd"),
        survivor.key: Trial(False, "tests/ilc", "5678efab"),
        same.key: Trial(False, "tests/ilc"),
    }
    mutants = [MUTANT, survivor, same, untried]
    assert score(mutants, results) == (1, 2)
    text = page(mutants, {}, results)
    assert "| ilc | 1 | 2 | 50 % | 1 |" in text
    assert "of 1234abcd (1 faults), 5678efab (1 faults)." in text
    assert "| a.py | sum | ilc/t.py::a |" in text
    assert "**survives**: too small to see" in text
    assert "ilc/a.py: same. addition commutes" in text
    assert "| a.py | untried (†) | not tried |" in text


def test_a_month_keeps_first_outcomes_and_reasons_and_stands_beside_curated_faults(tmp_path):
    rows = [replace(MUTANT, name=name, new=name) for name in ("mended", "same", "lost")]
    first = month.updated([], [MUTANT, *rows], {m.key: Trial(False, "t") for m in rows})
    reasons = {"same": {"equivalent": "a sum"}, "lost": {"survives": "too small"}}
    first = [replace(fate, **reasons.get(fate.name, {})) for fate in first]
    month.write("202611", month.updated(first, rows, {rows[0].key: Trial(True, "t::a")}), tmp_path)
    kept = month.fates("202611", tmp_path)
    assert [fate.noticed for fate in kept] == ["", "t::a", "", ""]
    assert [m.equivalent for m in month.with_reasons(rows, kept)] == ["", "a sum", ""]
    before = page([MUTANT], {}, {MUTANT.key: Trial(True, "tests/ilc/t.py::a")})
    for _ in range(2):  # a second page replaces the section of the first
        before = page([MUTANT], {"202611": kept}, {}, before)
    assert before.count("| ilc | 0 | 1 | 2 | 50 % | 1 | 1 |") == 1
    assert "- ilc/a.py: `lost`. too small" in before
    assert "| a.py | sum | ilc/t.py::a |" in before


@pytest.mark.parametrize(
    ("text", "other", "same"),
    [
        ("def f(a: int, *, b=1): return a", "def f(a: str, /, b=1): return a", True),
        ("if TYPE_CHECKING: import a", "if not TYPE_CHECKING: import a", True),
        ("x: int | None = 1", "x: int & None = 1", True),
        ("x: int = 1", "x: int = 2", False),
        ("def f(a=1): return a", "def f(a=2): return a", False),
    ],
)
def test_what_only_types_read_is_no_fault(text, other, same):
    assert (_program(text) == _program(other)) == same
    assert _program("def f(//, a): pass") == ""


@pytest.mark.skipif(not (ROOT / ".git").exists(), reason="needs the history")
def test_a_copy_has_the_files_that_git_knows_and_their_times(tmp_path):
    copy, name = copied(tmp_path / "copy"), "tests/mutation/session.py"
    assert (copy / "src/armside/ilc").is_symlink()
    assert (copy / "src/armside/ilc/filters.py").exists()
    assert (copy / name).read_bytes() == (ROOT / name).read_bytes()
    assert (copy / name).stat().st_mtime_ns == (ROOT / name).stat().st_mtime_ns
    assert not (copy / ".git").exists()


def test_the_commit_of_a_tree_is_known_where_it_has_one(tmp_path):
    assert commit(tmp_path) == ""

    def git(*command):
        author = ("-c", "user.name=a", "-c", "user.email=a@b.c")
        subprocess.run(("git", *author, *command), cwd=tmp_path, check=True, capture_output=True)

    (tmp_path / "a").write_text("one")
    for command in (("init",), ("add", "a"), ("commit", "-m", "one")):
        git(*command)
    clean = commit(tmp_path)
    assert len(clean) == 10
    (tmp_path / "a").write_text("two")
    assert commit(tmp_path) == clean + "+"
