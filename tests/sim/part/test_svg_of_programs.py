"""SVG as other programs write it: their backgrounds are no contours, and nothing else is lost."""

from pathlib import Path

import numpy as np
import pytest
from ezdxf.addons.drawing import layout, svg
from ezdxf.addons.drawing.config import BackgroundPolicy, Configuration
from ezdxf.addons.drawing.frontend import Frontend
from ezdxf.addons.drawing.properties import RenderContext
from matplotlib.figure import Figure
from matplotlib.patches import Circle, Rectangle

from armside.sim.motion.contour import Circle as Circular
from armside.sim.part.curve import Kind, centred
from armside.sim.part.part import read_part

from .drawings import flange, new

EXAMPLE = Path(__file__).parents[3] / "docs/examples/flange.svg"


def by_ezdxf(file, background):
    document = flange(new())
    backend, how = svg.SVGBackend(), Configuration(background_policy=background)
    Frontend(RenderContext(document), backend, config=how).draw_layout(document.modelspace())
    page = layout.Page(0, 0, layout.Units.mm, margins=layout.Margins.all(5))
    file.write_text(backend.get_string(page))
    return read_part(file)


def check_flange(part):
    """Within the micrometres of its coordinates and 0.03 % of four Bezier curves for a circle."""
    areas = sorted(1e6 * contour.chain.area for contour in part.contours)
    wanted = np.pi * np.square([4.0] * 24 + [40.0, 100.0])
    np.testing.assert_allclose(areas, wanted, rtol=1e-3)
    assert [c.kind for c in part.contours].count(Kind.OUTLINE) == 1


def test_the_invisible_background_of_ezdxf_is_no_outline(tmp_path):
    part = by_ezdxf(tmp_path / "a.svg", BackgroundPolicy.OFF)
    check_flange(part)
    assert part.notes == ("elements without stroke and fill that are not cut: 1",)


@pytest.mark.parametrize("background", [BackgroundPolicy.DEFAULT, BackgroundPolicy.WHITE])
def test_a_filled_background_is_said(background, tmp_path):
    part = by_ezdxf(tmp_path / "a.svg", background)
    check_flange(part)
    assert part.notes == ("rect 1 (without id) fills the page: its background, which is not cut",)


def test_the_example_is_the_flange_and_its_curves_are_judged_as_circles():
    part = read_part(EXAMPLE)
    check_flange(part)
    assert all(isinstance(centred(contour.chain)[0], Circular) for contour in part.contours)


def test_a_figure_of_matplotlib_is_a_part(tmp_path):
    figure = Figure(figsize=(100 / 25.4, 100 / 25.4))
    plate = Rectangle((0.1, 0.2), 0.8, 0.5, fill=False, transform=figure.transFigure)
    hole = Circle((0.5, 0.45), 0.1, fill=False, transform=figure.transFigure)
    for artist in (plate, hole):
        figure.add_artist(artist)
    figure.savefig(tmp_path / "a.svg")
    part = read_part(tmp_path / "a.svg")
    areas = sorted(1e6 * contour.chain.area for contour in part.contours)
    np.testing.assert_allclose(areas, [np.pi * 100.0, 80.0 * 50.0], rtol=1e-3)
    assert any("fills the page" in note for note in part.notes)


def test_a_shape_that_is_clipped_is_refused_by_name(tmp_path):
    """As matplotlib draws within axes, unless a patch has clip_on=False."""
    figure = Figure(figsize=(100 / 25.4, 100 / 25.4))
    figure.add_axes((0.0, 0.0, 1.0, 1.0)).add_patch(Rectangle((0.2, 0.2), 0.5, 0.5, gid="plate"))
    figure.savefig(tmp_path / "a.svg")
    wanted = r"path \d+ \(without id\) on layer figure_1 has a clip-path: .* release the clip"
    with pytest.raises(ValueError, match=wanted):
        read_part(tmp_path / "a.svg")


PAINTS = {
    "": 1,
    'fill="red"': 1,
    'fill="none" stroke="red"': 1,
    'fill="none"': 0,
    'style="fill:none;stroke:#000;stroke-opacity:0"': 0,
    'opacity="0"': 0,
}


@pytest.mark.parametrize(("paint", "cut"), PAINTS.items())
def test_a_shape_is_cut_where_a_viewer_shows_it(paint, cut, tmp_path):
    hole = f'<circle cx="30" cy="20" r="5" {paint}/>'
    plate = '<rect x="5" y="5" width="60" height="30" fill="none" stroke="black"/>'
    head = '<svg xmlns="http://www.w3.org/2000/svg" width="80mm" height="40mm" viewBox="0 0 80 40">'
    (tmp_path / "a.svg").write_text(f"{head}{plate}{hole}</svg>")
    part = read_part(tmp_path / "a.svg")
    assert len(part.contours) == 1 + cut
    assert len(part.notes) == 1 - cut
