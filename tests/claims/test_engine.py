"""A claim over many seeds becomes a page of the docs, and its verdict an exit status."""

import json
import os
from dataclasses import replace
from pathlib import Path

import pytest

from armside.sim.evaluation.check import Check, Table, all_hold
from armside.sim.notes import Cause, Note

from .. import evidence
from . import __main__ as command
from ._engine import JUDGED, ROOT, Claim, Rows, code, judged
from ._pages import index, page
from ._seeds import held

HIT = Note(cause=Cause.SATURATION, text="drives saturate")
RAN: list[int] = []


def run(seed, tally):
    RAN.append(seed)
    tally.add([HIT] if seed == 1 else [])
    yield {"seed": seed, "error": 0.5 * seed, "_hidden": os.getpid()}


def checks(rows: Rows):
    yield all_hold("every error is below 1", rows["error"] < 1.0)


SMALL = Claim(title="Errors of {n} seeds stay small", seeds=2, run=run, checks=checks)
DOCS = ROOT / "docs" / "claims"
WITHOUT_A_PAGE = {"imu-twin", "scan-twin-development"}
"""Claims whose full instance is not in the docs."""


@pytest.fixture(autouse=True)
def nothing_ran():
    RAN.clear()


@pytest.fixture
def small(monkeypatch, tmp_path):
    """`python -m tests.claims` where "small" is the only claim; in a folder of its own."""
    monkeypatch.chdir(tmp_path)
    monkeypatch.setattr(evidence, "names", lambda folder: ["small"])
    monkeypatch.setattr(evidence, "claim", lambda name: replace(SMALL, processes=1))
    monkeypatch.setattr(command, "claim_file", lambda name: Path(__file__))


def test_a_claim_that_holds_writes_its_page_and_the_index(small, capsys):
    assert command.main(["small"]) == 0
    assert RAN == [0, 1]  # the full instance
    text = Path("docs/claims/small.md").read_text()
    assert text.startswith("# Errors of 2 seeds stay small\n")
    assert "Written by `make claims NAME=small SEEDS=2 SEED=0` with armside" in text
    assert "| seed | error |" in text
    assert "| 1 | 0.5 |" in text
    assert "- holds: every error is below 1" in text
    assert f"Note: {HIT.text} (in 1 of 2 runs)" in capsys.readouterr().out
    row = "| [Errors of 2 seeds stay small](small.md) | 1 of 1 | `make claims NAME=small SEEDS=2"
    assert row in Path("docs/claims/index.md").read_text()
    assert not any(path.is_file() for path in Path("runs").rglob("*"))


def test_a_claim_that_fails_writes_its_page_too_and_ends_with_status_1(small, capsys):
    assert command.main(["--seeds", "3", "--seed", "40"]) == 1
    assert RAN == [40, 41, 42]
    text = Path("docs/claims/small.md").read_text()
    assert "**fails**: every error is below 1" in text
    assert "`make claims NAME=small SEEDS=3 SEED=40`" in text
    assert "0 of 1" in Path("docs/claims/index.md").read_text()


def test_the_same_seeds_write_the_same_page_and_json_has_its_rows(small, capsys):
    for folder in "ab":
        command.main(["--docs", folder, "--json"])
    assert Path("a/small.md").read_bytes() == Path("b/small.md").read_bytes()
    first, _ = map(json.loads, capsys.readouterr().out.splitlines())
    assert first["table"]["rows"] == [[0, 0.0], [1, 0.5]]
    assert first["notes"][0]["text"] == f"{HIT.text} (in 1 of 2 runs)"


@pytest.mark.parametrize(
    ("words", "said"), [(["smal"], "Did you mean small?"), (["--seeds", "-1"], "must be >= 0")]
)
def test_bad_input_is_named(small, words, said, capsys):
    with pytest.raises(SystemExit) as ended:
        command.main(words)
    assert ended.value.code == 2
    assert said in capsys.readouterr().err
    assert not Path("docs").exists()


def test_a_claim_that_was_stopped_goes_on_where_it_was(tmp_path):
    def stopped(seed, tally):
        if seed == 2:
            raise KeyboardInterrupt
        yield from run(seed, tally)

    with pytest.raises(KeyboardInterrupt):
        judged(replace(SMALL, run=stopped), range(3), kept=tmp_path)
    table = judged(SMALL, range(3), kept=tmp_path)
    assert RAN == [0, 1, 2]
    assert [row[0] for row in table.rows] == [0, 1, 2]
    assert [note.text for note in table.notes] == [f"{HIT.text} (in 1 of 3 runs)"]


def test_cases_on_several_processes_come_in_order_with_their_notes():
    one, two = (judged(SMALL, range(4), processes=n) for n in (1, 2))
    assert (one.rows, one.notes) == (two.rows, two.notes)
    assert RAN == [0, 1, 2, 3]  # the others ran elsewhere


def test_results_that_are_kept_are_those_of_the_code(tmp_path):
    for folder in JUDGED:
        (tmp_path / folder).mkdir(parents=True)
        (tmp_path / folder / "one.py").write_text("1")
    before = code(tmp_path)
    (tmp_path / "sim" / "one.md").write_text("prose")
    assert code(tmp_path) == before
    for folder in JUDGED:
        (tmp_path / folder / "one.py").write_text("2")
        assert before != (before := code(tmp_path))


def test_the_page_has_its_command_versions_rows_and_verdicts():
    verdicts = [all_hold("one", [True]), all_hold("other", [False])]
    text = page(Table("T", ["seed", "x"], [[3, 0.25]], verdicts), "made by", {"mujoco": "4.0.0"})
    assert "Written by `made by` with mujoco 4.0.0." in text
    assert "- holds: one" in text
    assert "- **fails**: other" in text
    assert "| 3 | 0.25 |" in text


def test_every_claim_is_a_file_with_a_page_and_the_index_lists_them():
    names = evidence.names("claims")
    assert len(names) == 44
    for name in names:
        assert isinstance(evidence.claim(name), Claim)
        if name not in WITHOUT_A_PAGE:
            text = (DOCS / f"{name}.md").read_text("utf-8")
            assert f"`make claims NAME={name} SEEDS=" in text
    assert {file.stem for file in DOCS.glob("*.md")} == {*names, "index"} - WITHOUT_A_PAGE
    assert (DOCS / "index.md").read_text("utf-8") == index(DOCS)


def test_a_row_of_the_wrong_length_is_refused():
    with pytest.raises(ValueError, match="1 cells for 2 columns"):
        Table("t", ["a", "b"], [[1]], [])


@pytest.mark.parametrize(("fraction", "holds"), [(1.0, False), (0.75, True)])
def test_a_check_must_hold_for_a_fraction_of_the_seeds(fraction, holds):
    by_seed = {seed: [Check("a", "error", "small", seed, high=2.0)] for seed in range(4)}
    (verdict,) = held(by_seed, fraction)
    assert verdict.holds is holds
    assert "(3 of 4)" in verdict.statement


def test_exceptions_to_a_statement_are_counted():
    assert all_hold("all", [True, True]).holds
    assert all_hold("all", [[True, False], [False, True]]).ours == 2.0
    assert not all_hold("one", False).holds
