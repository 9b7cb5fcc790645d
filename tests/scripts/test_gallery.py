"""The pictures of the docs are those that the code makes, and small."""

from pathlib import Path

import numpy as np
import pytest
from PIL import Image

from armside.scripts import cli
from armside.scripts.commands import laser
from armside.scripts.figures.gallery import PICTURES
from armside.scripts.shell.errors import InputError

IMAGES = Path(__file__).parents[2] / "docs" / "images"
ALIKE = 1.0
"""Mean difference of grey values, of 255, that another font or antialiasing makes."""


def pixels(file):
    with Image.open(file) as image:
        return np.asarray(image.convert("L"), dtype=float)


@pytest.mark.parametrize("name", ["circles"])
def test_a_picture_made_again_is_the_committed_one(name, tmp_path):
    assert cli.main(["gallery", name, "--images", str(tmp_path), "--quiet"]) == 0
    made, committed = pixels(tmp_path / f"{name}.png"), pixels(IMAGES / f"{name}.png")
    assert made.shape == committed.shape
    assert np.abs(made - committed).mean() < ALIKE


def test_every_picture_is_committed_and_all_are_small():
    assert all((IMAGES / f"{name}.png").is_file() for name in PICTURES)
    assert sum(file.stat().st_size for file in IMAGES.iterdir()) < 1.5e6


def test_a_picture_that_cannot_be_drawn_leaves_no_folder(tmp_path, monkeypatch, capsys):
    def without_chromium(run, file):
        raise InputError("replay needs chromium and chromedriver")

    monkeypatch.setattr(laser, "laser", lambda **_: None)
    monkeypatch.setitem(PICTURES, "replay", without_chromium)
    assert cli.main(["gallery", "replay", "--images", str(tmp_path / "new")]) == 2
    assert "needs chromium" in capsys.readouterr().err
    assert not list(tmp_path.iterdir())


def test_an_unknown_picture_names_those_there_are(capsys):
    assert cli.main(["gallery", "mona-lisa"]) == 2
    assert "circles, errors" in capsys.readouterr().err
