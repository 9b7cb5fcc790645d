"""A scanner is calibrated by a grid, or refused."""

import json
from dataclasses import replace

import numpy as np
import pytest

from armside.sim.part.arcs import MM
from armside.sim.scan.calibration import Calibration, calibrated, read_calibration
from armside.sim.scan.image import ScanImage
from armside.sim.scan.virtual import Scanner, grid, scanned

PITCH, CELLS, SIZE = 2.5 * MM, (10, 10), (32 * MM, 32 * MM)
CHEAP = Scanner(scale=(6e-3, -1e-3), skew=5e-4, wobble=((20e-6, 6e-3, 1.0), (8e-6, 15e-3, 2.0)))
LEFT = 1.5e-6
"""[m] RMS of a grid of 25 mm: half of what the trial takes a calibration to leave."""


def scan_of_grid(degrees: float, scanner: Scanner = CHEAP, seed: int = 0) -> ScanImage:
    angle = np.radians(degrees)
    c, s = np.cos(angle), np.sin(angle)
    middle = 0.5 * PITCH * np.array(CELLS)
    x, y = 0.5 * np.array(SIZE) - np.array([[c, -s], [s, c]]) @ middle
    rng = np.random.default_rng(seed)
    place = (float(x), float(y), angle)
    return scanned(grid(PITCH, CELLS, 0.08 * MM), scanner, SIZE, rng, place=place)


@pytest.fixture(scope="module")
def turned() -> ScanImage:
    return scan_of_grid(8.0)


@pytest.fixture(scope="module")
def calibration(turned) -> Calibration:
    return calibrated([turned], PITCH)


def left(calibration: Calibration, scanner: Scanner) -> np.ndarray:
    """(N, 2) [m], of points of the glass, seen and corrected, but for a motion of all."""
    p = np.random.default_rng(1).uniform(5 * MM, 27 * MM, (500, 2))
    off = calibration.corrected(scanner.seen(p, SIZE, np.random.default_rng(0))) - p
    one, none = np.ones(len(p)), np.zeros(len(p))
    J = np.vstack([np.column_stack([one, none, -p[:, 1]]), np.column_stack([none, one, p[:, 0]])])
    every = off.T.ravel()
    return (every - J @ np.linalg.lstsq(J, every, rcond=None)[0]).reshape(2, -1).T


def test_scale_skew_and_wobble_are_taken_off(calibration):
    assert np.sqrt(np.mean(left(calibration, CHEAP) ** 2, axis=0)).max() < LEFT
    # What is left without is fifteen times as much.
    nothing = replace(calibration, matrix=np.eye(2), wobble=0.0 * calibration.wobble)
    assert np.sqrt(np.mean(left(nothing, CHEAP) ** 2)) > 15 * LEFT
    assert calibration.residual < 3e-6


def test_a_straight_grid_is_refused_and_two_that_are_turned_are_not():
    # At 1 deg, 25 mm of line pass 0.4 mm of the 2.5 to the next.
    straight = scan_of_grid(1.0)
    with pytest.raises(ValueError, match="turn the grid"):
        calibrated([straight], PITCH)
    both = calibrated([straight, scan_of_grid(96.0, seed=2)], PITCH)
    assert np.sqrt(np.mean(left(both, CHEAP) ** 2, axis=0)).max() < LEFT


def test_the_folds_of_a_contact_image_sensor_are_refused():
    folded = Scanner(folds=((10 * MM, 60e-6), (20 * MM, -60e-6)))
    with pytest.raises(ValueError, match=r"CIS.*CCD"):
        calibrated([scan_of_grid(8.0, folded)], PITCH)


@pytest.mark.parametrize("pitch", [5 * MM, 2 * MM])
def test_a_grid_of_another_pitch_is_refused(turned, pitch):
    with pytest.raises(ValueError, match="cells"):
        calibrated([turned], pitch)


def test_a_file_keeps_every_bit_and_its_area(calibration, turned, tmp_path):
    file = tmp_path / "scanner.json"
    file.write_text(json.dumps(calibration.as_json()))
    again = read_calibration(file)
    assert again.as_json() == calibration.as_json()
    again.check(turned)
    with pytest.raises(ValueError, match="same area"):
        again.check(replace(turned, grey=turned.grey[:-100]))
    with pytest.raises(ValueError, match="the grid lay at"):
        again.corrected(np.array([[0.01, 0.0]]))


@pytest.mark.parametrize(
    "change",
    [
        {"armside_scanner": 9},
        {"matrix": [[1.0, 0.0]]},
        {"wobble": [[0.0, 0.0]]},
        {"y": [0.0] * 4},
        {"residual": "small"},
        {"scale": None},
        {"gamma": 0.0},
    ],
    ids=lambda change: next(iter(change)),
)
def test_a_damaged_calibration_is_refused(calibration, tmp_path, change):
    file = tmp_path / "scanner.json"
    file.write_text(json.dumps(calibration.as_json() | change))
    with pytest.raises(ValueError, match=r"scanner\.json"):
        read_calibration(file)
