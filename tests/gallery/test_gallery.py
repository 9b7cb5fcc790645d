"""The pictures of the docs are those that the code makes, and small."""

from dataclasses import replace

import numpy as np
import pytest
from PIL import Image

from armside.scripts.figures import canvas
from armside.scripts.shell.errors import InputError
from armside.sim.cell import CELLS
from armside.sim.estimation.linearised_arm import linearised
from armside.sim.estimation.nominal import NominalCfg, nominal_arm
from armside.sim.laser.experiment import prepare
from armside.sim.laser.specification import Cut

from .. import evidence
from . import __main__ as gallery
from . import replay, robots, why

IMAGES = evidence.ROOT / "docs" / "images"
ALIKE = 1.0
"""Mean difference of grey values, of 255, that another font or antialiasing makes."""


def pixels(file):
    with Image.open(file) as image:
        return np.asarray(image.convert("L"), dtype=float)


@pytest.fixture(scope="module")
def made(tmp_path_factory):
    """Folder of two pictures, and the figure of the second."""
    folder, figures = tmp_path_factory.mktemp("images"), []
    with pytest.MonkeyPatch.context() as patch:
        save = canvas.save
        patch.setattr(canvas, "save", lambda *saved: (save(*saved), figures.append(saved[0])))
        assert gallery.main(["circles", "why", "--images", str(folder)]) == 0
    return folder, figures[-1]


@pytest.mark.parametrize("name", ["circles", "why"])
def test_a_picture_made_again_is_the_committed_one(made, name):
    again, committed = pixels(made[0] / f"{name}.png"), pixels(IMAGES / f"{name}.png")
    assert again.shape == committed.shape
    assert np.abs(again - committed).mean() < ALIKE


def test_why_shows_motors_that_learn_and_a_tool_that_oscillates_at_modes_left_undamped(made):
    motors, tool = made[1].axes
    band, modes = (5.5, 10.0), sorted({line.get_xdata()[0] for line in tool.lines[:3]})
    for axes, lowest, highest in ((motors, 0.0, 0.7), (tool, 1.8, 20.0)):
        first, last = (np.array(line.get_xydata()).T for line in axes.lines[3:])
        inside = (first[0] > band[0]) & (first[0] < band[1])
        growth = (last[1] / first[1])[inside]
        assert lowest < growth.min()
        assert growth.max() < highest
        assert (axes.get_xlabel(), motors.get_ylabel()) == ("frequency [Hz]", "amplitude [µm]")
    assert sum(band[0] < mode < band[1] for mode in modes) == 2


def test_modes_by_a_stiff_servo_are_those_of_held_motors_and_by_ours_are_damped():
    loaded = prepare(Cut()).loaded
    robot, phi = loaded.model, loaded.reference[0]
    arm = linearised(nominal_arm(robot, NominalCfg(structure=True)), phi)
    drives = robot.drives
    stiff = replace(robot, drives=replace(drives, kp=1e9 * drives.kp, kd=1e3 * drives.kd))
    held, by_stiff, by_ours = (
        why.held_modes(arm),
        why.servo_modes(arm, stiff),
        why.servo_modes(arm, robot),
    )
    np.testing.assert_allclose(held[:3, 0], arm.locked_modes()[:3], rtol=1e-3)  # damping shifts
    np.testing.assert_allclose(by_stiff[:3], held[:3], rtol=1e-3)
    assert (by_ours[:3, 1] > 5.0 * held[:3, 1]).all()


def test_every_picture_is_a_file_and_committed_and_all_are_small():
    names = evidence.names("gallery")
    assert {f"{name}.png" for name in names} == {file.name for file in IMAGES.glob("*.png")}
    for name in names:
        module = evidence.module("gallery", name)
        assert hasattr(module, "DRAWN") or callable(module.draw)
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
    assert "circles, compare, errors" in capsys.readouterr().err


def test_every_robot_in_the_picture_of_robots_is_named():
    assert robots.NAMES.keys() == CELLS.keys()
