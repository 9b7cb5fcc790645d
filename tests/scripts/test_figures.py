"""Figures are functions of arrays: what they are given is what they draw."""

from functools import partial
from types import SimpleNamespace

import numpy as np
import pytest
from PIL import Image

from armside.ilc.workbench.predicted import Prediction
from armside.scripts.figures import canvas, convergence
from armside.scripts.figures import imu as imu_figures
from armside.scripts.figures import laser as figures

RADIUS = 5e-3
ANGLE = np.linspace(0.0, 2.0 * np.pi, 400, endpoint=False)
UNIT = np.column_stack([np.cos(ANGLE), np.sin(ANGLE)])
CIRCLE = RADIUS * UNIT


def wavy(amplitude):
    return (RADIUS + amplitude * np.cos(3 * ANGLE))[:, None] * UNIT


def draw_circles(file, amplitudes):
    figures.circles(file, CIRCLE, [wavy(a) for a in amplitudes], rms=amplitudes, maxdev=amplitudes)


@pytest.mark.parametrize("amplitudes", [[0.0], [2e-4, 1e-4], 2e-4 * 0.5 ** np.arange(40)])
def test_circles_draw_a_perfect_path_and_any_number_of_iterations(tmp_path, amplitudes):
    draw_circles(tmp_path / "c.png", np.array(amplitudes))
    with Image.open(tmp_path / "c.png") as image:
        assert image.width > 300
        assert np.asarray(image.convert("L")).min() < 128


def test_the_same_arrays_give_the_same_bytes_and_others_do_not(tmp_path):
    for name, last in (("a", 1e-4), ("b", 1e-4), ("c", 1.5e-4)):
        draw_circles(tmp_path / f"{name}.png", np.array([2e-4, last]))
    a, b, c = ((tmp_path / f"{name}.png").read_bytes() for name in "abc")
    assert a == b != c


def test_circles_draw_the_deviation_magnified(tmp_path, drawn):
    draw_circles(tmp_path / "c.png", np.array([2e-4, 1e-4]))
    (figure,) = drawn
    for axes, amplitude in zip(figure.axes, (2e-4, 1e-4), strict=True):
        reference, measured, bar = (np.asarray(line.get_xydata()) * 1e-3 for line in axes.lines)
        np.testing.assert_allclose(np.ptp(bar, axis=0), [10 * 100e-6, 0.0], atol=1e-15)
        np.testing.assert_allclose(reference[:-1], CIRCLE, rtol=1e-12)
        # 0.6 R / 0.2 mm = 15, so 10 times. The foot is on a 400-gon: its sides turn by 2 pi / 400
        # and lie below the circle by up to R (pi / 400)^2 / 2.
        turn = np.pi / len(CIRCLE)
        atol = 9 * (amplitude * turn + 0.5 * RADIUS * turn**2)
        np.testing.assert_allclose(measured, wavy(10 * amplitude), atol=atol)
    assert "magnified 10 times" in figure.get_suptitle()
    assert "RMS 200 µm, max 200 µm" in figure.axes[0].get_title()


def test_large_deviations_are_drawn_to_scale(tmp_path, drawn):
    draw_circles(tmp_path / "c.png", np.array([4e-3]))
    assert "to scale" in drawn[0].get_suptitle()


def test_what_is_not_finite_leaves_a_gap_and_nothing_else(tmp_path, drawn):
    path = wavy(1e-4)
    path[10:20] = np.nan
    path[30, 0] = np.inf
    lost = np.full_like(path, np.nan)
    numbers = [1e-4, np.nan]
    figures.circles(tmp_path / "c.png", CIRCLE, [path, lost], rms=numbers, maxdev=numbers)
    first, second = drawn[0].axes
    shown = np.isfinite(np.asarray(first.lines[1].get_xydata())).all(axis=1)
    np.testing.assert_array_equal(shown, np.isfinite(path).all(axis=1))
    assert first.get_xlim() == second.get_xlim()
    assert 5.0 < first.get_xlim()[1] < 10.0


def test_errors_of_a_run_that_diverged_can_be_drawn(tmp_path):
    motor = np.full((3, 6), 0.1)
    motor[2] = np.inf
    motor[1, 0] = 0.0
    figures.errors(tmp_path / "e.png", motor, [1e-4, np.inf, np.nan], [2e-4, np.nan, np.inf])
    assert (tmp_path / "e.png").exists()


def test_the_magnification_is_a_round_number():
    at_most = 0.3, 1.9, 2.0, 9.99, 12.5, 6000, 999.9999999999999  # its logarithm is rounded up
    assert [*map(canvas.magnification, at_most)] == [1, 1, 2, 5, 10, 5000, 1000]


def test_the_nearest_point_of_a_closed_square_is_on_its_nearest_side():
    square = np.array([[0.0, 0.0], [1.0, 0.0], [1.0, 1.0], [0.0, 1.0]])
    points = np.array([[0.5, -0.2], [1.3, 0.25], [-0.1, 0.5], [2.0, 2.0]])
    expected = [[0.5, 0.0], [1.0, 0.25], [0.0, 0.5], [1.0, 1.0]]
    np.testing.assert_array_equal(figures._nearest(points, square), expected)


def test_many_iterations_show_the_first_and_the_last():
    shown = figures._panels(40)
    assert len(shown) == figures.MOST_PANELS
    assert (shown[0], shown[-1]) == (0, 39)
    assert figures._panels(6) == [0, 1, 2, 3, 4, 5]


@pytest.mark.parametrize("n", [1, 6])
def test_errors_draw_six_motors_and_the_arm(tmp_path, n):
    figures.errors(tmp_path / "e.png", np.full((n, 6), 0.1), [1e-4] * n, [2e-4] * n)
    with Image.open(tmp_path / "e.png") as image:
        colors = {tuple(c) for c in np.unique(np.asarray(image)[..., :3].reshape(-1, 3), axis=0)}
    for color in canvas.COLORS:
        assert tuple(bytes.fromhex(color[1:])) in colors


def test_every_law_and_its_prediction_can_be_told_from_the_others(tmp_path, drawn):
    expected = Prediction(errors=np.ones(3), contraction=None, spectral_radius=None)
    shown = {"noise": 0.0, "first_k": 0, "norms": np.ones(3), "prediction": expected}
    runs = [SimpleNamespace(law=f"law {i}", state=None, **shown) for i in range(20)]
    convergence.draw_convergence(tmp_path / "c.png", "laws", runs)
    lines = [line for line in drawn[0].axes[0].lines if len(line.get_xdata())]
    kinds = {(line.get_color(), line.get_marker(), line.get_linestyle()) for line in lines}
    assert len(kinds) == len(lines) == 40
    solid = [line.get_markersize() for line in lines if line.get_linestyle() == "-"]
    dashed = [line.get_markersize() for line in lines if line.get_linestyle() == "--"]
    assert len(solid) == len(dashed)
    assert min(dashed) > 1.5 * max(solid)  # seen around equal ones


@pytest.mark.parametrize("moving", [[0, 1, 2, 3, 4, 5], [3, 4, 5], [1], []])
def test_motors_that_move_have_a_panel_and_those_at_rest_are_named(tmp_path, drawn, moving):
    time = np.linspace(0.0, 1.0, 100)
    angle = np.zeros((100, 6))
    angle[:, moving] = np.sin(6.0 * time)[:, None]
    resting = sorted({*range(6)} - {*moving})
    angle[50:, resting] += 12e-6 if moving else 0.0
    imu_figures.motor_angles(tmp_path / "m.png", time, angle)
    (figure,) = drawn
    panels = [axes for axes in figure.axes if axes.get_visible()]
    for i, axes in zip(moving or range(6), panels, strict=True):
        np.testing.assert_array_equal(axes.lines[0].get_ydata(), angle[:, i])
        assert axes.get_title(loc="left") == f"Motor {i + 1}"
    said = [text.get_text() for text in figure.texts if "rest" in text.get_text()]
    names = ", ".join(str(i + 1) for i in resting)
    assert said == ([f"Motors at rest, within 12 µrad: {names}"] if moving and resting else [])


def test_a_slide_has_metres_and_a_scale_of_its_own(tmp_path, drawn):
    time = np.linspace(0.0, 1.0, 50)
    angle = np.column_stack([np.sin(9.0 * time), 0.05 * time, np.cos(9.0 * time)])
    imu_figures.motor_angles(tmp_path / "m.png", time, angle, (False, True, False))
    first, slide, third, *_ = drawn[0].axes
    assert [axes.get_ylabel() for axes in (first, slide, third)] == [
        *("angle [rad]", "position [m]", "angle [rad]"),
    ]
    assert np.ptp(slide.get_ylim()) < 0.1  # not 0.15 of the radians beside it


@pytest.mark.parametrize(
    "draw", [imu_figures.position, partial(imu_figures.vector, quantity="acceleration")]
)
def test_the_legend_of_predicted_and_measured_lies_over_no_panel(tmp_path, drawn, draw):
    time = np.linspace(0.0, 1.0, 50)
    values = np.column_stack([np.sin(40.0 * time)] * 3)
    draw(tmp_path / "p.png", time, values, values)
    drawn[0].canvas.draw()
    (legend,) = drawn[0].legends
    box = legend.get_window_extent()
    assert len(legend.get_texts()) == 2
    assert not any(box.overlaps(axes.get_window_extent()) for axes in drawn[0].axes)
