"""The pictures of the docs are those that the code makes, and small."""

import numpy as np
import pytest
from PIL import Image

from armside.scripts.shell.errors import InputError

from .. import evidence
from . import __main__ as gallery
from . import replay

IMAGES = evidence.ROOT / "docs" / "images"
ALIKE = 1.0
"""Mean difference of grey values, of 255, that another font or antialiasing makes."""


def pixels(file):
    with Image.open(file) as image:
        return np.asarray(image.convert("L"), dtype=float)


def test_a_picture_made_again_is_the_committed_one(tmp_path):
    assert gallery.main(["circles", "--images", str(tmp_path)]) == 0
    made, committed = pixels(tmp_path / "circles.png"), pixels(IMAGES / "circles.png")
    assert made.shape == committed.shape
    assert np.abs(made - committed).mean() < ALIKE


def test_every_picture_is_a_file_and_committed_and_all_are_small():
    names = evidence.names("gallery")
    assert names == ["circles", "errors", "first-cut", "picture", "replay", "robots"]
    for name in names:
        assert callable(evidence.module("gallery", name).draw)
        assert (IMAGES / f"{name}.png").is_file()
    assert sum(file.stat().st_size for file in IMAGES.iterdir()) < 1.5e6


def test_a_picture_that_cannot_be_drawn_leaves_no_folder(tmp_path, monkeypatch, capsys):
    def without_chromium(run, file):
        raise InputError("replay needs chromium and chromedriver")

    monkeypatch.setattr(gallery, "armside", lambda words: 0)
    monkeypatch.setattr(replay, "draw", without_chromium)
    assert gallery.main(["replay", "--images", str(tmp_path / "new")]) == 1
    assert "needs chromium" in capsys.readouterr().err
    assert not list(tmp_path.iterdir())


def test_an_unknown_picture_names_those_there_are(capsys):
    with pytest.raises(SystemExit) as ended:
        gallery.main(["mona-lisa"])
    assert ended.value.code == 2
    assert "circles, errors" in capsys.readouterr().err
