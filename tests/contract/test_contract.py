"""No command line hurts: lines at random, and those that once did, against the contract."""

import os
import re
import shlex
from pathlib import Path

import pytest

from armside.scripts import cli
from armside.scripts.shell.options import FileToRead, FileToWrite, Folder

from .claim import RULES, broken, judged
from .findings import FINDINGS
from .isolated import Outcome
from .lines import Kind, Line, line, options_of

PATIENCE = 0.3
"""[s]: what runs that long is interrupted, and must then end in one line like everything else."""
GOOD = Outcome(status=2, out="", err="armside: no\n", interrupted=False, seconds=0.1, memory=1e8)


def test_300_command_lines_keep_the_contract():
    """In CI; else those that once went wrong, and thirty at random."""
    n = 300 if os.environ.get("ARMSIDE_CI") else len(FINDINGS) + 30
    found = [one for one in judged(range(n), PATIENCE) if one.broken]
    assert not [
        (shlex.join(one.line.words), one.broken, one.outcome.status, one.outcome.err)
        for one in found
    ]


@pytest.mark.parametrize(
    ("rule", "kind", "changes", "left"),
    [
        (0, Kind.ABSURD, {"err": "Traceback (most recent call last):\narmside: no\n"}, []),
        (1, Kind.ABSURD, {"status": -11}, []),
        (1, Kind.ABSURD, {"status": 120}, []),
        (2, Kind.MALFORMED, {"status": 0, "err": ""}, []),
        (3, Kind.ABSURD, {"status": 1, "err": "armside: failed with KeyError: x\n"}, []),
        (3, Kind.ABSURD, {"status": 1, "err": "armside: [Errno 2] No such file\n"}, []),
        (4, Kind.ABSURD, {"err": ""}, []),
        (4, Kind.ABSURD, {"err": "warning\narmside: no\n"}, []),
        (4, Kind.ABSURD, {"err": "no prefix\n"}, []),
        (4, Kind.ABSURD, {"status": 0, "err": "RuntimeWarning: overflow\n"}, []),
        (5, Kind.ABSURD, {"status": 0, "err": "", "out": "RMS nan µm"}, []),
        (5, Kind.ABSURD, {"status": 0, "err": "", "out": '"rms": NaN,'}, []),
        (6, Kind.ABSURD, {}, ["a.csv"]),
        (7, Kind.ABSURD, {"memory": 3e9}, []),
        (7, Kind.ABSURD, {"interrupted": True, "status": 130, "seconds": 61.0}, []),
        (8, Kind.ABSURD, {"status": None}, []),
    ],
)
def test_the_contract_notices_each_way_to_break_it(rule, kind, changes, left):
    asked = Line(("laser",), kind)
    assert not broken(asked, GOOD, [], 60.0)
    assert RULES[rule] in broken(asked, GOOD._replace(**changes), left, 60.0)


def test_a_line_may_say_what_it_waits_for():
    slow = GOOD._replace(status=0, err="armside: waiting for storage 'x'\n")
    assert not broken(Line(("tune",), Kind.ABSURD), slow, [], 60.0)
    assert broken(Line(("tune",), Kind.ABSURD), slow._replace(err=slow.err + "more\n"), [], 60.0)


@pytest.mark.parametrize("text", ["financial", "banana", "Infineon", "runs/nan.csv", "info"])
def test_a_word_is_not_taken_for_a_number(text):
    done = GOOD._replace(status=0, err="", out=text)
    assert not broken(Line(("laser",), Kind.ABSURD), done, [], 60.0)


@pytest.mark.parametrize("name", cli.COMMANDS)
def test_every_option_of_a_command_is_tried(name, capsys):
    """Those of its help are found in its signature, but for the one that asks for tracebacks."""
    assert cli.main([name, "--help-all"]) == 0
    shown = capsys.readouterr().out
    written = [option.name for option in options_of(cli.load(name)) if option.name]
    assert "--seed" in written
    assert all(option in shown for option in written)
    listed = set(re.findall(r"^│ +(?:\* +)?(--[\w-]+)", shown, re.MULTILINE))
    assert listed - set(written) <= {"--debug"}


def test_files_are_known_by_what_they_are_for():
    roles = {option.name: option.role for option in options_of(cli.load("replay"))}
    assert (roles["--save"], roles["--png"], roles["--out"]) == ("write", "write", "")
    roles = {option.name: option.role for option in options_of(cli.load("laser"))}
    assert (roles["--contour"], roles["--model"]) == ("read", "read")
    assert len({FileToRead, FileToWrite, Folder}) == 3


def test_lines_are_the_same_for_the_same_seed_and_cover_kinds_and_commands():
    lines = [line(seed) for seed in range(len(FINDINGS), len(FINDINGS) + 500)]
    assert lines == [line(seed) for seed in range(len(FINDINGS), len(FINDINGS) + 500)]
    assert {one.words[0] for one in lines} == set(cli.COMMANDS)
    assert {one.kind for one in lines} == {Kind.BOUNDARY, Kind.ABSURD, Kind.MALFORMED}
    assert [line(seed).words for seed in range(len(FINDINGS))] == list(FINDINGS)


def test_findings_name_files_that_are_made():
    from .files import READ, RUNS, TWINS

    words = [word for line in FINDINGS for word in line if word.startswith("../files/")]
    named = {Path(word).name for word in words}
    assert named <= {*READ, *RUNS, *TWINS}
