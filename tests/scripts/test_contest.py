"""`armside contest`: what is refused, in one line, and a round from its seal to its check."""

import json
from pathlib import Path

import pytest

from armside.scripts import cli

ENTRIES = Path(__file__).parents[2] / "docs" / "examples" / "contest"
NOTHING = str(ENTRIES / "nothing.py")
REFUSED = {
    "run": "needs the file of an entry",
    "run none.py": "none.py does not exist",
    f"run {NOTHING} --tasks 0": "Must be >= 1",
    f"run {NOTHING} --tasks 10001": "tasks must be 1 to 10000, got 10001",
    f"run {NOTHING} --track fast": "fast",
    f"run {NOTHING} --salt 00": "has no salt",
    f"run {NOTHING} --round a.json --salt {'0' * 64}": "a.json does not exist",
    f"judge {NOTHING}": "judge needs --round FILE and --salt",
    f"judge {NOTHING} --round a.json": "is sealed: judging it needs --salt",
    "table": "there is no result in contest",
    "table empty.json": "empty.json lacks the entry 'schema'",
    "run latin.py": "latin.py cannot be read: 'utf-8' codec",
    "run large.py": "large.py has 1.049 MB; at most 1.049 MB are read",
    "check": "one result and --entry",
    "new-round": "needs one name",
    "new-round development": "is public",
    "new-round ../a": "needs one name",
    "new-round a_b": "letters, digits and -",
    "fly": "fly",
}


@pytest.fixture(autouse=True)
def elsewhere(monkeypatch, tmp_path):
    monkeypatch.chdir(tmp_path)
    (tmp_path / "empty.json").write_text("{}")
    (tmp_path / "latin.py").write_bytes("# Größe".encode("latin-1"))
    (tmp_path / "large.py").write_text("#" * ((1 << 20) + 1))


@pytest.mark.parametrize("words", REFUSED)
def test_what_cannot_be_judged_is_refused_in_one_line(words, capsys):
    assert cli.main(["contest", *words.split()]) == 2
    said = capsys.readouterr().err
    assert REFUSED[words] in said
    assert said.count("\n") == 1
    assert not list(Path().glob("contest/*.json"))


def test_a_round_is_sealed_judged_ranked_and_checked(capsys):
    sealed = ["--round", "contest/2026-a.json", "--salt", "contest/2026-a.salt", "--json"]
    assert cli.main(["contest", "new-round", "2026-a"]) == 0
    files = [NOTHING, str(ENTRIES / "time_reversal.py")]
    capsys.readouterr()
    assert cli.main(["contest", "judge", *files, "--tasks", "2", *sealed]) == 0
    (table,) = json.loads(capsys.readouterr().out)["tables"]
    assert [row["entry"] for row in table["standings"]] == ["time_reversal", "nothing"]
    assert cli.main(["contest", "table", "--out", "t", "--quiet"]) == 0
    assert {f.name for f in Path("t").iterdir()} == {"summary.json", "joint-2026-a.png"}
    result = Path("contest/nothing-joint-2026-a.json")
    check = ["contest", "check", str(result), "--entry", NOTHING, "--tasks", "2", *sealed]
    assert cli.main(check) == 0
    found = json.loads(result.read_text())
    for row in found["tasks"]:
        row["left"] = 0.01
    result.write_text(json.dumps(found))
    assert cli.main(check) == 1
    assert "does not come out the same" in capsys.readouterr().err


def test_no_summary_holds_the_salt(capsys):
    assert cli.main(["contest", "new-round", "2026-a"]) == 0
    salt = Path("contest/2026-a.salt").read_text().strip()
    sealed = ["--round", "contest/2026-a.json", "--salt", salt, "--tasks", "1", "--json"]
    assert cli.main(["contest", "judge", NOTHING, *sealed, "--out", "o"]) == 0
    assert salt not in Path("o/summary.json").read_text()
    assert salt not in "".join(capsys.readouterr())


def test_every_entry_is_in_the_table_of_the_rules():
    text = (ENTRIES.parents[1] / "contest.md").read_text()
    assert {f.stem for f in ENTRIES.glob("*.py")} <= set(
        text.split("## Entries of ours")[1].split("`")
    )
