"""Figures of the thesis and of reports read as their captions say: what a stranger asks of each."""

from types import SimpleNamespace

import numpy as np
import pytest

from armside.scripts.figures import calibration, commission, imu, tuning
from armside.scripts.figures.canvas import COLORS, new_figure
from armside.scripts.thesis.chapter9 import ENTRIES, figures
from armside.scripts.thesis.report import Asked
from armside.sim.evaluation.check import Table

from ..claims import estimation_controls
from .test_chapter9 import thesis_like


@pytest.fixture
def section(drawn, tmp_path):
    """Figure and caption of a section of chapter 9."""

    def made(id):
        (entry,) = (entry for entry in ENTRIES if entry.id == id)
        caption = entry.make(Asked()).draw(thesis_like, tmp_path).caption
        return drawn[-1], caption

    return made


def test_the_shift_is_an_axis_and_motors_are_the_six_lines(section):
    figure, _ = section("9.12")
    for axes in figure.axes:
        assert axes.get_xlabel() == "time shift δ [samples]"
        assert [line.get_label() for line in axes.lines] == list(figures.MOTORS)
        for line in axes.lines:
            np.testing.assert_array_equal(line.get_xdata(), range(1, 9))
    first, last = figure.axes
    assert first.lines[0].get_ydata()[0] > last.lines[0].get_ydata()[0]  # k = 1 and k = 5


@pytest.mark.parametrize(("id", "kinds"), [("9.13", (2, 2)), ("F09", (3, 2))])
def test_colours_are_poses_and_dashes_methods(section, id, kinds):
    for axes in section(id)[0].axes:
        looks = {}
        for line in axes.lines:
            pose, method = line.get_label().split(", ")
            looks.setdefault(("pose", pose), set()).add(line.get_color())
            looks.setdefault(("method", method), set()).add(line.get_linestyle())
        assert all(len(look) == 1 for look in looks.values())
        for kind, n in zip(("pose", "method"), kinds, strict=True):
            assert len(set.union(*(v for k, v in looks.items() if k[0] == kind))) == n


def test_cutoff_and_robots_are_drawn_over_what_their_captions_name(section):
    figure, caption = section("9.14")
    assert "infinity norm" in caption
    assert {axes.get_ylabel() for axes in figure.axes} == {"error (9.5), ∞-norm", ""}
    lowest = section("F07")[0].axes[-3:]
    assert {axes.get_xlabel() for axes in lowest} == {"error at k = 5 over that at k = 0"}


@pytest.mark.parametrize(
    ("value", "band", "text"),
    [
        (0.9512, (0.95, None), "0.951"),
        (0.9496, (0.95, None), "0.9496"),
        (0.4999, (0.2, 0.5), "0.4999"),
        (0.42, (0.2, 0.5), "0.42"),
        (1.0, (None, None), "1.00"),
    ],
)
def test_a_value_is_shown_on_its_own_side_of_a_band(value, band, text):
    assert figures._beside(value, band) == text


def test_a_path_shows_where_it_starts_and_which_way(tmp_path, monkeypatch):
    figure = new_figure(6.0, 5.0)
    monkeypatch.setattr(imu, "new_figure", lambda *size: figure)
    position = np.linspace([1.0, 0.0, 1.0], [1.0, 0.4, 1.3], 50)
    imu.path(tmp_path / "p.png", position)
    (axes,) = figure.axes
    start = np.array(axes.lines[1].get_data_3d()).ravel()
    np.testing.assert_array_equal(start, position[0])
    (arrow,) = axes.collections
    shaft = np.array(arrow._segments3d[0])
    ahead = np.sort(np.abs((shaft - position[0]) @ [0.0, 0.8, 0.6]))
    assert ahead[-1] == pytest.approx(0.15, abs=0.02)  # 0.3 of half a metre, along the path
    assert "direction" in axes.get_legend().get_texts()[0].get_text()


def test_what_the_estimate_uses_is_ordered_over_a_grid_that_is_behind(tmp_path, monkeypatch):
    kept = []
    monkeypatch.setattr(estimation_controls, "save", lambda figure, file: kept.append(figure))
    rows = [["a", 1.0, 2.0, 3.0], ["b", 9.0, 9.0, 9.0], ["c", 5.0, np.nan, 5.0]]
    estimation_controls.draw(tmp_path / "e.png", Table("", ["", *"123"], rows))
    (axes,) = kept[0].axes
    assert [label.get_text() for label in axes.get_yticklabels()] == ["b", "c", "a"]
    assert [bar.get_width() for bar in axes.containers[0]] == [9.0, 5.0, 1.0]
    assert axes.get_axisbelow() is True
    assert "[µm]" in axes.get_xlabel()


def test_importance_says_what_it_is_a_share_of(tmp_path, drawn):
    tuning.importance(tmp_path / "i.png", {"gamma": {"share": 0.6, "by_chance": 0.2}})
    (axes,) = drawn[0].axes
    assert axes.get_xlabel().startswith("share in what sets the best designs apart")
    assert [bar.get_width() for bar in axes.containers[0]] == [0.6]


def test_residuals_of_a_twin_are_titled_by_what_is_subtracted(tmp_path, drawn, monkeypatch):
    left = np.full((50, 3), 1e-4 / np.sqrt(3.0))
    cases = SimpleNamespace(residuals=lambda mean: SimpleNamespace(tool=left))
    monkeypatch.setattr(commission, "Against", lambda *case: cases)
    quality = SimpleNamespace(held_out=[5e-5, 4e-5], within=[2e-5, 3e-5])
    parameters = SimpleNamespace(mean=np.zeros(1))
    twin = SimpleNamespace(sensor="tracker", design=None, parameters=parameters)
    found = SimpleNamespace(twin=twin, identified=quality)
    cuts = [SimpleNamespace(name=name, scan=None) for name in ("a", "b")]
    commission.residuals(tmp_path / "r.png", found, cuts)
    (axes,) = drawn[0].axes
    assert drawn[0].get_suptitle().endswith("in each cut: measured less predicted, by model")
    heights = [[bar.get_height() for bar in bars] for bars in axes.containers]
    assert axes.get_ylabel() == "RMS [µm]"
    np.testing.assert_allclose(heights, [[100, 100], [50, 40], [20, 30]], rtol=1e-12)


def test_residuals_of_a_calibration_have_the_colours_of_all_figures(tmp_path, drawn):
    error = np.linspace(1e-4, 1e-3, 20)[:, None]
    scale = {"nominal": 3.0, "geometry": 1.0, "full": 1.0}
    pose = np.tile(np.eye(4), (20, 1, 1))
    model = SimpleNamespace(nominal_pose=lambda phi: pose)
    done = SimpleNamespace(
        residuals=lambda name: scale[name] * error,
        nominal=SimpleNamespace(problem=SimpleNamespace(model=model)),
        held_out=SimpleNamespace(phi=None),
    )
    calibration.draw_residuals(tmp_path / "r.png", done)
    lines = drawn[0].axes[0].lines
    assert [line.get_color() for line in lines] == list(COLORS[:3])
    assert drawn[0].axes[0].get_xlabel() == "held-out error [mm]"
    assert [line.get_xdata()[-1] for line in lines] == pytest.approx([3.0, 1.0, 1.0])
