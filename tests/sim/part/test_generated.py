"""Drawings at random: every contour where an independent renderer has it, nothing else dropped."""

import io
import re
from collections import Counter

import numpy as np
import pytest
import resvg_py
from PIL import Image, ImageDraw

from armside.sim.part.drawing import Reading
from armside.sim.part.svg import read_svg

from . import generated_svg

NEAR = 3
"""Distance of a contour from its colour [pixels]."""
TIP = 15
"""Points of one contour where its fill may be narrower than a pixel."""
WIDE = 14
"""Largest half width of a stroke [pixels]."""


def picture(made):
    """(H, W) colours of the picture of resvg, -1 where it is empty; and pixels per millimetre."""
    width = int(generated_svg.PIXELS)
    png = resvg_py.svg_to_bytes(svg_string=made.text, width=width, dpi=96.0, shape_rendering="crisp_edges")
    rgba = np.asarray(Image.open(io.BytesIO(bytes(png))).convert("RGBA")).astype(int)
    code = (rgba[..., 0] << 16) + (rgba[..., 1] << 8) + rgba[..., 2]
    return np.where(rgba[..., 3] > 127, code, -1), rgba.shape[1] / made.width


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
    polygons, owners = [], []
    for entity in drawing.entities:
        owners.append(re.search(r"#(s\d+)", entity.name)[1])
        s = np.arange(0.0, entity.chain.length, 1e-3 / scale)
        polygons.append(1e3 * scale * entity.chain.point(s) * [1.0, -1.0])
    covered = np.zeros(colours.shape, dtype=bool)
    allowed = {}
    found, compared = [], 0
    for polygon, owner in reversed(list(zip(polygons, owners, strict=True))):
        area = region(polygon, colours.shape)
        own = np.isin(colours, list(made.colours[owner] | {0}))
        at = np.round(polygon - 0.5).astype(int)[:, ::-1]
        inside = (at >= NEAR).all(axis=1) & (at < np.array(colours.shape) - NEAR).all(axis=1)
        at = at[inside]
        seen = grown(own, NEAR)[tuple(at.T)] | covered[tuple(at.T)]
        compared += len(at) - int(covered[tuple(at.T)].sum())
        if (~seen).sum() > TIP:
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
