"""Tables can be read at any width: no number is cut, and each row keeps its name."""

import numpy as np
import pytest

from armside.scripts.shell.console import Report, cell
from armside.scripts.shell.options import Common

WIDTHS = (40, 60, 80, 200)


def printed(capsys, monkeypatch, width, columns, rows) -> list[str]:
    monkeypatch.setenv("COLUMNS", str(width))
    Report(Common()).table("a title", columns, rows)
    return capsys.readouterr().out.splitlines()


@pytest.mark.parametrize("width", WIDTHS)
@pytest.mark.parametrize("seed", range(5))
def test_no_number_is_cut_and_no_line_is_too_long(capsys, monkeypatch, width, seed):
    rng = np.random.default_rng(seed)
    n = int(rng.integers(2, 14))
    columns = ["k", *(f"largest error of motor {i}" for i in range(n))]
    rows = [[k, *map(float, rng.lognormal(0.0, 8.0, n))] for k in range(3)]
    lines = printed(capsys, monkeypatch, width, columns, rows)
    assert max(map(len, lines)) <= width
    words = " ".join(lines).replace("│", " ").split()
    for row in rows:
        for value in row[1:]:
            assert words.count(cell(value)) >= 1


def test_each_fold_names_its_rows(capsys, monkeypatch):
    columns = ["pose", "seed", *(f"column {i}" for i in range(8))]
    rows = [["p1", 0, *[1.2345] * 8], ["p1", 1, *[2.3456] * 8]]
    lines = printed(capsys, monkeypatch, 45, columns, rows)
    data = [line.split("│")[1:3] for line in lines if "1.234" in line or "2.346" in line]
    assert len(data) > 2
    assert [[word.strip() for word in row] for row in data[:2]] == [["p1", "0"], ["p1", "1"]]
    assert data[2:4] == data[:2]


def test_without_a_terminal_a_table_has_80_columns(capsys, monkeypatch):
    monkeypatch.delenv("COLUMNS", raising=False)
    Report(Common()).table("", ["k", *"abcdefghijkl"], [[0, *[0.12345] * 12]])
    assert max(map(len, capsys.readouterr().out.splitlines())) <= 80


def test_a_long_text_wraps_and_loses_nothing(capsys, monkeypatch):
    text = "the beam was lost between the third and the fourth target of the part"
    lines = printed(capsys, monkeypatch, 40, ["case", "verdict"], [["p1", text], ["p2", "holds"]])
    words = " ".join(lines).replace("│", " ").split()
    assert set(text.split()) <= set(words)
