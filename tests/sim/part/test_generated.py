"""Drawings at random: every contour where an independent renderer has it, nothing else dropped."""

import io
import os
import re
from collections import Counter

import numpy as np
import pytest
import resvg_py
import shapely
from PIL import Image, ImageDraw

from armside.sim.part.drawing import Reading
from armside.sim.part.dxf import read_dxf
from armside.sim.part.svg import read_svg

from . import generated_dxf, generated_svg

NEAR = 3
"""Distance of a contour from its colour [pixels]."""
WIDE = 14
"""Largest half width of a stroke [pixels]."""


SEEDS = 300 if os.environ.get("ARMSIDE_CI") else 40
OFF = 5e-6
"""Distance of a curve from its arcs, and from the chords of its samples [m]."""


def picture(made):
    """(H, W) colours of the picture of resvg, -1 where empty; and pixels per millimetre (2,)."""
    width = int(generated_svg.PIXELS)
    png = resvg_py.svg_to_bytes(
        svg_string=made.text, width=width, dpi=96.0, shape_rendering="crisp_edges"
    )
    rgba = np.asarray(Image.open(io.BytesIO(bytes(png))).convert("RGBA")).astype(int)
    code = (rgba[..., 0] << 16) + (rgba[..., 1] << 8) + rgba[..., 2]
    scale = np.array([rgba.shape[1] / made.width, rgba.shape[0] / made.height])
    return np.where(rgba[..., 3] > 127, code, -1), scale


def grown(mask, n):
    """The mask and what is at most n pixels from it, by rows and columns."""
    from scipy.ndimage import maximum_filter

    return maximum_filter(mask.astype(np.uint8), size=2 * n + 1).astype(bool)


def region(polygon, shape):
    image = Image.new("1", (shape[1], shape[0]))
    points = [(float(x), float(y)) for x, y in polygon]
    ImageDraw.Draw(image).polygon(points, fill=1, outline=1)
    return np.asarray(image)


def differences(made, drawing):
    """What the picture and the contours have against each other, in words."""
    colours, scale = picture(made)
    contours = []
    for entity in drawing.entities:
        owner = re.search(r"#(s\d+)", entity.name)[1]
        s = np.arange(0.0, entity.chain.length, 1e-3 / scale[0])
        points = 1e3 * scale * entity.chain.point(s) * [1.0, -1.0]
        contours.append((points, owner, entity.chain.closed))
    covered = np.zeros(colours.shape, dtype=bool)
    allowed = {}
    found, compared = [], 0
    for polygon, owner, closed in reversed(contours):
        area = region(polygon, colours.shape)
        own = np.isin(colours, list(made.colours[owner] | {0}))
        at = np.round(polygon - 0.5).astype(int)[:, ::-1]
        inside = (at >= NEAR).all(axis=1) & (at < np.array(colours.shape) - NEAR).all(axis=1)
        at = at[inside]
        seen = grown(own, NEAR)[tuple(at.T)] | covered[tuple(at.T)]
        thick = grown(~grown(~area, 1), NEAR + 2)[tuple(at.T)]
        seen |= closed & ~thick  # a needle whose fill is narrower than a pixel
        compared += len(at) - int(covered[tuple(at.T)].sum())
        if not seen.all():
            found.append(f"{owner} does not show at {at[~seen][0][::-1] / scale} mm")
        covered |= grown(area, WIDE)
        for code in made.colours[owner]:
            allowed[code] = allowed.get(code, np.zeros(colours.shape, bool)) | area
    for code in np.unique(colours[colours > 0]).tolist():
        stray = (colours == code) & ~grown(allowed.get(code, np.zeros(colours.shape, bool)), WIDE)
        if stray.any():
            who = [name for name, codes in made.colours.items() if code in codes]
            at = np.argwhere(stray)[0][::-1] / scale
            found.append(f"{who} shows at {at} mm, where no contour of it is")
    return found, compared


def unnoted(made, drawing):
    """Shapes that are neither cut nor counted in a note."""
    cut = Counter(re.search(r"#(s\d+)", entity.name)[1] for entity in drawing.entities)
    whole = sum(n / made.parts[name] for name, n in cut.items())
    counts = [int(n) for note in drawing.notes for n in re.findall(r"not cut: (\d+)$", note)]
    return made.shapes - whole - sum(counts)


def judge_svg(seed, folder):
    """Verdict on the drawing of a seed: '', 'refused: ...' or what is wrong; points compared."""
    made, file = generated_svg.generated(seed), folder / f"{seed}.svg"
    file.write_text(made.text)
    try:
        drawing = read_svg(file, Reading())
    except ValueError as error:
        named = set(re.findall(r"#(\w+)", str(error)))
        placed = "clips it at (" in str(error) or named & made.doubtful
        return (f"refused: {error}" if placed else f"wrongly refused: {error}"), 0
    found, compared = differences(made, drawing)
    if left := unnoted(made, drawing):
        found.append(f"{left} shapes are dropped without a note")
    return "; ".join(found), compared


def judge_dxf(seed, folder):
    """As `judge_svg`, against the curves by formulas."""
    made, file = generated_dxf.generated(seed), folder / f"{seed}.dxf"
    made.document.saveas(file)
    try:
        drawing = read_dxf(file, Reading())
    except ValueError as error:
        kind = re.match(r"(\w+) (?:#|of INSERT #)\w+ on layer \w+ cannot be cut", str(error))
        return (
            "refused" if kind and kind[1] in made.refused else "wrongly refused"
        ) + f": {error}", 0
    if made.refused:
        return f"dropped without a note: {made.refused}", 0
    counts = [int(n) for note in drawing.notes for n in re.findall(r"(\d+) entit", note)]
    if sum(counts) < made.hidden:
        return f"{made.hidden - sum(counts)} hidden entities have no note", 0
    own = [entity.chain.polygon(1e-7) for entity in drawing.entities]
    wanted, found = (shapely.MultiLineString(each) for each in (made.curves, own))
    if len(made.curves) == 0 or len(own) == 0:
        return ("" if len(made.curves) == len(own) else "all curves, or none"), 0
    for one, other, what in ((wanted, found, "is missing"), (found, wanted, "is not drawn")):
        points = shapely.points(shapely.get_coordinates(one))
        shapely.prepare(other)
        near = shapely.dwithin(points, other, OFF)
        if not near.all():
            return f"a curve at {points[~near][0]} m {what}", 0
    lengths = sum(entity.chain.length for entity in drawing.entities)
    if abs(lengths - wanted.length) > 1e-4 * wanted.length:
        return f"the curves are {lengths} m long, not {wanted.length}", 0
    return "", len(made.curves)


@pytest.mark.parametrize("judge", [judge_svg, judge_dxf], ids=["svg", "dxf"])
def test_contours_of_drawings_at_random_are_where_they_are_drawn(judge, tmp_path):
    verdicts = {seed: judge(seed, tmp_path) for seed in range(SEEDS)}
    wrong = {seed: v for seed, (v, _) in verdicts.items() if v and not v.startswith("refused")}
    assert not wrong
    refused = sum(bool(verdict) for verdict, _ in verdicts.values())
    assert refused < 0.4 * SEEDS
    assert sum(compared for _, compared in verdicts.values()) > 3 * SEEDS
