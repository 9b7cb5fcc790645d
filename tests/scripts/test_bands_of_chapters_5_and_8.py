"""Bands of chapters 5 and 8 have their ends where the thesis says: see `test_bands`."""

import numpy as np
import pytest

from armside.scripts.figures import two_mass as two_mass_figures
from armside.scripts.thesis import chapter5 as figures_of_chapter5
from armside.scripts.thesis import imu_checks as chapter5
from armside.scripts.thesis.chapter8 import ENTRIES
from armside.scripts.thesis.report import Asked

from .verdicts import assert_band

COUNT = 1e3 * 2.0 * np.pi / (2**12 - 1)  # [mrad] of the motor, thesis 5.3.1
CHAPTER_5 = {
    "E01.1": (None, 1e-9), "E01.2": (None, 1e-12), "E01.3": (None, 1e-3),
    "E02.1": (0.009, 0.014), "E02.2": (3.0, None), "E02.3": (0.15, 0.45), "E02.4": (0.15, 0.45),
    "E02.5": (25.0, 30.0), "E02.6": (0.2, 0.5),
    "E03.1": (COUNT - 1e-4, COUNT + 1e-4),
    "E04.1": (None, 1.0), "E04.2": (None, 0.3), "E04.3": (None, 1.0),
    "E05.1": (0.399, 0.401), "E05.2": (0.499, 0.501), "E05.3": (2.5, 10.0), "E05.4": (2.5, 10.0),
    "E06.1": (0.495, 0.505), "E06.2": (0.99, 1.01), "E06.3": (None, 1e-3),
    "E07.1": (0.2, 1.5), "E07.2": (0.2, 1.5), "E07.3": (0.2, 1.5),
    "E07.4": (None, COUNT / 50.0 * 1.5), "E07.5": (None, 1e-14),
    "E08.1": (None, 0.025), "E08.2": (None, 0.15),
    "E09.1": (None, 0.15), "E09.2": (5.0, 10.0), "E09.3": (None, 1.0), "E09.4": (None, 1e-3),
    "E10.1": (None, 0.8), "E10.2": (None, 1.0), "E10.3": (2, None), "E10.4": (3.0, None),
    "E10.5": (0.15, 0.8), "E10.6": (0.15, 0.8), "E10.7": (None, 0.35), "E10.8": (None, 1.0),
    "E10.9": (2, None),
}  # fmt: skip


def around(value, off):
    return value - off, value + off


CHAPTER_8 = {
    "S01.1": around(1.1978, 0.0022), "S01.2": around(-19.5, 1e-3),
    "S01.3": around(1.0983, 0.0022), "S01.4": around(1.1305, 1e-4),
    "S02.1": (2.0, 3.0), "S02.2": around(5.0, 1e-6), "S02.3": around(5.32128, 5.32128 * 2e-3),
    "S02.4": around(1.46962, 1.46962 * 2e-3), "S02.5": around(0.0413, 1e-4),
    "S03.1": (1e-3, None), "S03.2": (None, 0.0), "S03.3": (10.5, 11.5), "S03.4": (21.5, 22.5),
    "S03.5": (37.5, 38.5),
    "S04.1": around(2.0, 2e-4), "S04.2": around(1.9987, 1e-4), "S04.3": around(9.7856, 5e-3),
    "S04.4": around(5.4308, 5e-3), "S04.5": (None, 1.0), "S04.6": (5, 5), "S04.7": (5, 5),
    "S04.8": (15, 15),
    "S05.1": around(5.32128, 5.32128 * 2e-3), "S05.2": around(1.557, 1.557e-2),
    "S05.3": around(0.548, 0.548e-3), "S05.4": around(0.19854, 0.19854 * 2e-3),
    "S05.5": (None, 0.01), "S05.6": (None, 1.0), "S05.7": (1.0, 100.0), "S05.8": (None, 1.0),
    "S05.9": (1.0, 100.0),
    **{
        f"S06.{i}": around(norm, 2e-3 * norm)
        for i, norm in enumerate((1.31447, 0.6645, 0.27668, 1.46962, 0.52199, 0.13409), start=1)
    },
    "S06.7": (0.9, 1.1), "S06.8": around(1.46962 / 0.12913, 4e-3 * 1.46962 / 0.12913),
    "S06.9": around(2.04878 / 1.0285, 4e-3 * 2.04878 / 1.0285),
    "S06.10": around(0.1555, 1e-4), "S06.11": around(0.1456, 1e-4),
}  # fmt: skip


def ours(checks):
    return {check.id: check.ours for check in checks}


@pytest.fixture
def imu_result():
    rng = np.random.default_rng(2)
    angle = 1.5344e-3 / 50 * np.cumsum(rng.integers(-3, 4, (400, 6)), axis=0)
    return {
        "off_rms": np.array([0.010, 0.012, 0.011]),
        "on_rms": np.array([0.010, 0.048, 0.055]),
        "on_level": np.array([0.1, 0.2, 0.3]),
        "frequency": np.arange(51.0),
        "on_spectrum": np.exp(-((np.arange(51.0)[:, None] - [10, 27, 40]) ** 2) / 4),
        "clock_offset_error": np.array(-4e-4),
        "clock_errors": 1e-4 * rng.standard_normal(50),
        "motor_angle": angle,
        "gear": np.array([-118, 118, 118, 60, 55, 50.0]),
        "move_speed": np.array([np.nan, 0.5, 0.5, 1.0, 1.0]),
        "move_reached": np.array([2.0, 0.5, 0.49, 1.0, 0.98]),
        "tool_distance": np.array(7e-4),
        "angular_velocity_rms": np.array([0.01, -0.02, 0.005]),
        "angular_velocity_max": np.array([0.05, 0.1, 0.08]),
        "acceleration_rms": np.array([0.05, 0.1, 0.08]),
        "acceleration_peak": np.array([6.0, 9.0, 5.5]),
        "clipped_share": np.array(2e-4),
        "acceleration_window_max": np.array([0.3, 0.5, 0.2]),
        "as_thesis_acceleration_window_max": np.array([0.4, 0.6, 0.3]),
        "largest_in_rectangle": np.array([True, False, True]),
        "as_thesis_largest_in_rectangle": np.array([True, True, False]),
        "fast_over_slow": np.array(4.0),
    }


@pytest.fixture
def checks_5(imu_result):
    r = imu_result
    turned = {"motor_angle": np.array([[0.4, -0.3995, 0.4, 0.5, -0.5, 0.5004]] * 2) * [[1], [-1]]}
    four = {
        "one": {"tool_distance": 3e-4},
        "two": {"tool_distance": 4e-4},
        "three": {"tool_distance": 5e-4},
        chapter5.RIGID: {"tool_distance": 6e-6},
    }
    moved = np.eye(4)
    moved[:3, 3] = 1e-3 * np.array([32.0, -26.0, 90.5])
    return [
        *chapter5.noise(r),
        *chapter5.mounted(np.eye(4), moved, moved[:3, 3] + [0, 2e-6, 0]),
        *chapter5.clocks(r),
        *chapter5.one_at_a_time(turned, turned, np.array([1.0, 3.0]), np.array([4.0, 5.0])),
        *chapter5.all_at_once(r),
        *chapter5.distances(four),
        chapter5.toolbox_poses({"another toolbox": 1e-15, "not installed": None}),
        *chapter5.rates(r),
        *chapter5.accelerations(r),
        *chapter5.windows(r),
    ]


def test_every_number_of_chapter_5_is_judged_by_its_band(checks_5):
    assert {check.id for check in checks_5} == set(CHAPTER_5)
    for check in checks_5:
        assert_band(check, *CHAPTER_5[check.id])


def test_numbers_of_chapter_5_are_those_of_their_statements(checks_5, imu_result):
    r, found = imu_result, ours(checks_5)
    steps = np.abs(np.diff(r["motor_angle"] * np.abs(r["gear"]), axis=0))
    assert found == pytest.approx(
        {
            "E01.1": 0.5, "E01.2": 0.0, "E01.3": 2e-3,
            "E02.1": 0.012, "E02.2": 4.0, "E02.3": 0.2, "E02.4": 0.3, "E02.5": 27.0, "E02.6": 1.0,
            "E03.1": 1e3 * steps[steps > 1e-9].min(),
            "E04.1": 0.4, "E04.2": 1e3 * r["clock_errors"].std(),
            "E04.3": 1e3 * np.abs(r["clock_errors"]).max(),
            "E05.1": 0.3995, "E05.2": 0.5004, "E05.3": 3.0, "E05.4": 5.0,
            "E06.1": 0.49, "E06.2": 0.98, "E06.3": np.abs(r["motor_angle"][[0, -1]]).max(),
            "E07.1": 0.3, "E07.2": 0.4, "E07.3": 0.5, "E07.4": 6e-3, "E07.5": 1e-15,
            "E08.1": 0.02, "E08.2": 0.1,
            "E09.1": 0.1, "E09.2": 9.0, "E09.3": 5.5 / 6.0, "E09.4": 2e-4,
            "E10.1": 0.5, "E10.2": 0.2 / 0.3, "E10.3": 1.0, "E10.4": 4.0, "E10.5": 0.4,
            "E10.6": 0.6, "E10.7": 0.3, "E10.8": 0.75, "E10.9": 2.0,
        },
        abs=1e-12,
    )  # fmt: skip


class Numbers:
    """A table whose every number is one."""

    rows = (("motor", 0.5), ("arm", 0.5))

    def value(self, *_):
        return 1.0


@pytest.fixture(scope="module")
def checks_8(tmp_path_factory):
    folder, found = tmp_path_factory.mktemp("none"), []
    with pytest.MonkeyPatch.context() as patch:
        for entry in ENTRIES:
            if not entry.alone:
                patch.setitem(two_mass_figures.FIGURES, entry.id, lambda *_: Numbers())
                found += entry.make(Asked()).draw(None, folder).checks
    return found


def test_every_number_of_chapter_8_is_judged_by_its_band(checks_8):
    assert {check.id for check in checks_8} == set(CHAPTER_8)
    for check in checks_8:
        assert_band(check, *CHAPTER_8[check.id])


def test_the_error_of_figure_5_10_is_drawn_from_the_synchronisation_on(monkeypatch, tmp_path):
    shown = {}
    monkeypatch.setattr(
        figures_of_chapter5.figures,
        "acceleration_error",
        lambda _, time, curves, *__: shown.update(curves, time=time),
    )
    monkeypatch.setattr(figures_of_chapter5.checks, "windows", lambda _: [])
    speeds = np.array(list(figures_of_chapter5.PARTS.values()))
    result = {
        "time": np.arange(4.0), "since": 2.0,
        "move_speed": speeds, "move_start": 0.0 * speeds, "move_end": 1.0 + 0.0 * speeds,
    }  # fmt: skip
    for prefix in figures_of_chapter5.PROCESSED.values():
        result[f"{prefix}window_rms"] = np.arange(12.0).reshape(4, 3)
        for key in ("max", "time"):
            result[f"{prefix}acceleration_window_{key}"] = np.ones(3)
    figures_of_chapter5.error_along(tmp_path, result)
    assert shown.pop("time").tolist() == [2.0, 3.0]
    for curve in shown.values():
        assert curve[:, 0].tolist() == [6.0, 9.0]
