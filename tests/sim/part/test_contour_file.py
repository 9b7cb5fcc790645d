"""Contour files have the drawn shape; an error names what cannot be cut."""

import ezdxf
import numpy as np
import pytest
from ezdxf import units

from armside.sim.motion.contour import Circle
from armside.sim.part.contour_file import read_contour, rounded

HOUSE = np.array([[-10, -6], [10, -6], [10, 6], [0, 9], [-10, 6]]) * 1e-3
CORNER = 1.5e-3
L_SHAPE = np.array([[0, 0], [20, 0], [20, 8], [8, 8], [8, 20], [0, 20]]) * 1e-3


def along(contour, n=4001):
    return contour.point(np.linspace(0.0, contour.length, n))


@pytest.mark.parametrize("points", [HOUSE, L_SHAPE], ids=["convex", "with an inner corner"])
def test_a_rounded_polygon_touches_its_sides_and_misses_its_corners_as_radii_ask(points):
    contour = rounded(points, CORNER)
    curve = along(contour)
    a, b = points, np.roll(points, -1, axis=0)
    middle = 0.5 * (a + b)
    distance = np.linalg.norm(curve[:, None] - middle, axis=2).min(axis=0)
    np.testing.assert_allclose(distance, 0.0, atol=2e-5)  # half of a step between samples
    before = np.roll(points, 1, axis=0) - points
    after = b - a
    cosine = np.einsum("ij,ij->i", before, after) / (
        np.linalg.norm(before, axis=1) * np.linalg.norm(after, axis=1)
    )
    half = 0.5 * np.arccos(cosine)
    missed = np.linalg.norm(curve[:, None] - points, axis=2).min(axis=0)
    np.testing.assert_allclose(missed, CORNER * (1 / np.sin(half) - 1), atol=1e-6)
    assert contour.smallest_radius == pytest.approx(CORNER)


@pytest.mark.parametrize("order", [1, -1])
def test_it_starts_on_its_right_along_plus_y_and_is_counter_clockwise_in_either_order(order):
    contour = rounded(HOUSE[::order], CORNER)
    np.testing.assert_allclose(contour.tangent(0.0), [0.0, 1.0], atol=1e-12)
    assert contour.point(0.0)[0] == pytest.approx(0.010)
    x, y = along(contour).T
    assert np.sum(x[:-1] * np.diff(y) - y[:-1] * np.diff(x)) > 0.0


def test_a_contour_without_an_upright_side_starts_on_an_arc():
    diamond = np.array([[10, 0], [0, 7], [-10, 0], [0, -7]]) * 1e-3
    contour = rounded(diamond, CORNER)
    np.testing.assert_allclose(contour.tangent(0.0), [0.0, 1.0], atol=1e-12)
    assert along(contour)[:, 0].max() == pytest.approx(contour.point(0.0)[0])


def write(path, text):
    path.write_text(text)
    return path


def test_toml_is_in_millimetres_and_the_option_wins_over_its_corner(tmp_path):
    file = write(tmp_path / "c.toml", f"corner = 2\npoints = {(HOUSE * 1e3).tolist()}")
    assert read_contour(file).smallest_radius == pytest.approx(2e-3)
    assert read_contour(file, 1e-3).smallest_radius == pytest.approx(1e-3)


@pytest.mark.parametrize(
    ("text", "said"),
    [
        ("points = [[0, 0], [1, 0]]", "three or more pairs"),
        ("points = [[0, 0], [1, 0], [1, 1]]", "too short for corners of 1.5 mm"),
        ("points = [[0, 0], [9, 0], [9, 0], [0, 9]]", "the same: (9, 0) mm"),
        ("points = [[0, 0], [20, 0], [10, 0]]", "turns back on itself"),
        ("points = [[0, 0], ['a', 0], [1, 1]]", "could not convert"),
        ("corner = true\npoints = []", "corner must be a number"),
        ("corner = 0\npoints = [[0, 0], [20, 0], [0, 20]]", "corner must be > 0"),
        ("corner = 1", "points are missing"),
        ("radius = 1", "radius is not known here. Known: corner, points"),
        ("points = [", "c.toml"),
    ],
)
def test_what_cannot_be_cut_is_named(text, said, tmp_path):
    with pytest.raises(ValueError, match=r"c\.toml") as caught:
        read_contour(write(tmp_path / "c.toml", text))
    assert said in str(caught.value)


def test_another_kind_of_file_is_refused(tmp_path):
    with pytest.raises(ValueError, match=r"\.toml or a \.dxf"):
        read_contour(tmp_path / "c.svg")


# Drawings


def drawn(tmp_path, draw, unit=0, metric=1):
    drawing = ezdxf.new()  # pyright: ignore[reportPrivateImportUsage]
    drawing.units = unit
    drawing.header["$MEASUREMENT"] = metric
    draw(drawing.modelspace())
    drawing.saveas(tmp_path / "c.dxf")
    return tmp_path / "c.dxf"


def test_a_drawn_polygon_is_the_polygon_around_its_middle(tmp_path):
    points = (HOUSE * 1e3 + [100, 50]).tolist()
    file = drawn(tmp_path, lambda space: space.add_lwpolyline(points, close=True))
    middle = 0.5 * (HOUSE.min(axis=0) + HOUSE.max(axis=0))
    np.testing.assert_allclose(
        along(read_contour(file)), along(rounded(HOUSE - middle, CORNER)), atol=1e-12
    )


@pytest.mark.parametrize("order", [1, -1])
def test_a_drawn_slot_has_its_arcs_in_either_order(tmp_path, order):
    # 20 mm long, 10 mm wide: two lines of 10 mm, two half circles (bulge 1).
    points = [(-5, -5, 0), (5, -5, 1), (5, 5, 0), (-5, 5, 1)]
    if order < 0:
        points = [(-5, 5, 0), (5, 5, -1), (5, -5, 0), (-5, -5, -1)]
    file = drawn(tmp_path, lambda space: space.add_lwpolyline(points, format="xyb", close=True))
    contour = read_contour(file)
    assert contour.length == pytest.approx(1e-3 * (20 + 10 * np.pi))
    assert contour.smallest_radius == pytest.approx(5e-3)
    np.testing.assert_allclose(contour.point(0.0), [0.010, 0.0], atol=1e-12)


def test_a_drawing_in_inches_is_cut_in_inches(tmp_path):
    file = drawn(tmp_path, lambda space: space.add_circle((3, 3), 0.2), units.IN)
    contour = read_contour(file)
    assert isinstance(contour, Circle)
    assert contour.radius == pytest.approx(0.2 * 25.4e-3)


def kinked(space):
    points = [(-5, -5, 0), (5, -5, 0.5), (5, 5, 0), (-5, 5, 1)]
    space.add_lwpolyline(points, format="xyb", close=True)


@pytest.mark.parametrize(
    ("draw", "said"),
    [
        (kinked, "corner of .* deg at .* must be smooth"),
        (lambda s: None, "one closed line, it has none"),
        (lambda s: s.add_line((0, 0), (9, 9)), r"it has open LINE #\w+$"),
        (lambda s: s.add_lwpolyline([(0, 0), (20, 0), (20, 20)]), r"it has open LWPOLYLINE #\w+$"),
    ],
    ids=["kink", "none", "line", "open"],
)
def test_a_drawing_has_exactly_one_smooth_contour(tmp_path, draw, said):
    with pytest.raises(ValueError, match=rf"^c\.dxf: .*{said}"):
        read_contour(drawn(tmp_path, draw))


def test_a_file_that_is_no_drawing_is_refused(tmp_path):
    with pytest.raises(ValueError, match=r"d\.dxf: this is no DXF drawing"):
        read_contour(write(tmp_path / "d.dxf", "nothing"))


@pytest.mark.parametrize(
    ("draw", "said"),
    [
        (lambda s: s.add_circle((20, 0), 5), "closed CIRCLE"),
        (lambda s: [s.add_line((0, 0), (x, 9)) for x in (1, 2)], "open LINE .* and 1 more"),
        (lambda s: s.add_arc((0, 0), 3, 0, 90), "open ARC"),
        (lambda s: s.add_spline([(0, 0, 0), (1, 2, 0), (3, 1, 0)]), "open SPLINE|SPLINE"),
        (lambda s: s.add_polyline2d([(0, 0), (9, 0), (9, 9)], close=True), "closed POLYLINE"),
        (lambda s: s.add_text("cut me"), "TEXT .* cannot be cut"),
        (lambda s: s.doc.layers.add("OFF").off() or s.add_point((1, 1), {"layer": "OFF"}), "OFF"),
    ],
    ids=["circle", "lines", "arc", "spline", "old polyline", "text", "layer that is off"],
)
def test_nothing_beside_the_contour_is_dropped(tmp_path, draw, said):
    file = drawn(tmp_path, lambda space: (space.add_circle((0, 0), 5), draw(space)))
    with pytest.raises(ValueError, match=rf"^c\.dxf: .*{said}"):
        read_contour(file)


def test_lines_and_arcs_that_meet_are_a_contour(tmp_path):
    def slot(space):
        for y in (-5, 5):
            space.add_line((-5, y), (5, y))
        space.add_arc((5, 0), 5, -90, 90)
        space.add_arc((-5, 0), 5, 90, 270)

    contour = read_contour(drawn(tmp_path, slot))
    assert contour.length == pytest.approx(1e-3 * (20 + 10 * np.pi))
    np.testing.assert_allclose(contour.point(0.0), [0.010, 0.0], atol=1e-12)


def test_an_imperial_drawing_without_a_unit_is_refused(tmp_path):
    file = drawn(tmp_path, lambda space: space.add_circle((0, 0), 0.2), metric=0)
    with pytest.raises(ValueError, match="imperial and has no unit"):
        read_contour(file)
