"""No number is read from an image that is no whole, sharp scan of the drawing's sheet."""

import os

import pytest

from armside.scripts import cli

from .scans import KINDS, case, drawing_file, np, save, sheet
from .scans import drawing as drawn

N = 304 if os.environ.get("ARMSIDE_CI") else 16
"""Images, of each kind as many; in CI 300 and a few."""


@pytest.mark.parametrize("number", range(N), ids=lambda i: f"{list(KINDS)[i % len(KINDS)]}-{i}")
def test_an_image_that_cannot_be_read_is_refused_in_a_line(number, tmp_path, capsys):
    files = case(number, tmp_path)
    line = ["scan", "read", str(files.image), "--contours", str(files.drawing)]
    status = cli.main([*line, "--out", str(tmp_path / "out")])
    out, err = capsys.readouterr()
    assert (status, out, err.count("\n")) == (2, "", 1), out + err
    assert err.startswith("armside: ")
    assert not (tmp_path / "out").exists()


def test_the_same_sheets_are_read_where_nothing_is_wrong(tmp_path, capsys):
    """Else any refusal would do."""
    for seed in range(2):
        rng = np.random.default_rng(seed)
        of = drawn(rng)
        seen, dxf = save(sheet(rng, of), tmp_path / "a.png"), drawing_file(tmp_path / "a.dxf", of)
        line = ["scan", "read", str(seen), "--contours", str(dxf), "--quiet"]
        assert cli.main([*line, "--out", str(tmp_path / f"{seed}")]) == 0, capsys.readouterr().err
