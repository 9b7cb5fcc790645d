"""Numbers, lengths, transforms and shapes of SVG, each refused in words where it is in doubt."""

import re
from typing import Any
from xml.etree.ElementTree import Element

import numpy as np
import svgelements

from armside.arrays import Array

from .arcs import place
from .expansion import check_points
from .svg_style import NUMBER

PIXELS = {"": 1.0, "px": 1.0, "in": 96.0, "mm": 96 / 25.4, "cm": 96 / 2.54, "q": 24 / 25.4}
PIXELS |= {"pt": 96 / 72, "pc": 16.0}
"""User units of each unit of length."""
TRANSFORMS = {"matrix": (6,), "translate": (1, 2), "scale": (1, 2), "rotate": (1, 3)}
TRANSFORMS |= {"skewX": (1,), "skewY": (1,)}
"""Numbers of arguments."""
ALIGNED = {"Min": 0.0, "Mid": 0.5, "Max": 1.0}
SHAPES = {"path", "rect", "circle", "ellipse", "line", "polyline", "polygon"}
Size = tuple[float, float]
"""Width and height."""


def numbers(text: str, name: str) -> list[float]:
    """Numbers of a list. Raises ValueError for anything else in it."""
    found = [float(number) for number in re.findall(NUMBER, text)]
    if re.sub(NUMBER, " ", text).strip(", \t\r\n\f") or not np.isfinite(found).all():
        raise ValueError(f"its {name} is {_short(text)}")
    return found


def length(text: str, name: str, viewport: Size) -> float:
    """A length in user units; per cent are of the viewport, by the name's direction."""
    found = re.fullmatch(rf"\s*({NUMBER})\s*(%|[a-zA-Z]*)\s*", text)
    if not found or found[2].lower() not in (*PIXELS, "%"):
        raise ValueError(f"its {name} is {_short(text)}, which is no length")
    along = {"x": viewport[0], "w": viewport[0], "y": viewport[1], "h": viewport[1]}
    whole = along.get(name.lstrip("cr")[:1], float(np.sqrt(np.mean(np.square(viewport)))))
    value = float(found[1]) * (whole / 100.0 if found[2] == "%" else PIXELS[found[2].lower()])
    if not np.isfinite(value):
        raise ValueError(f"its {name} is {_short(text)}, which is no finite length")
    return value


def transform(element: Element) -> Array:
    """(3, 3) of an element's attribute."""
    text = element.get("transform", "")
    call = r"\s*,?\s*(\w+)\s*\(([^()]*)\)"
    if re.sub(call, "", text).strip():
        raise ValueError(f"its transform is {_short(text)}")
    whole: Array = np.eye(3)
    for name, inside in re.findall(call, text):
        values = numbers(inside, "transform")
        if len(values) not in TRANSFORMS.get(name, ()):
            raise ValueError(f"its transform is {_short(text)}")
        m = svgelements.Matrix(f"{name}({','.join(map(repr, values))})")
        own = [[m.a, m.c, m.e], [m.b, m.d, m.f], [0.0, 0.0, 1.0]]
        whole = whole @ np.array(own, dtype=np.float64)
    return whole


def viewbox(element: Element) -> list[float] | None:
    """x, y, width and height of a viewBox."""
    if "viewBox" not in element.attrib:
        return None
    values = numbers(element.attrib["viewBox"], "viewBox")
    if len(values) != 4 or min(values[2:]) <= 0.0:
        raise ValueError(f"its viewBox is {_short(element.attrib['viewBox'])}")
    return values


def fitted_in(element: Element, size: Size) -> Array:
    """(3, 3), from the coordinates inside a viewport of this size to those around it."""
    box = viewbox(element)
    if box is None:
        return np.eye(3)
    text = element.get("preserveAspectRatio", "xMidYMid")
    found = re.fullmatch(r"\s*(none|x(M..)Y(M..))(?:\s+(meet|slice))?\s*", text)
    if not found or not {found[2], found[3]} <= {None, *ALIGNED}:
        raise ValueError(f"its preserveAspectRatio is {_short(text)}")
    corner, own = np.array(box[:2]), np.array(box[2:])
    scale = np.array(size) / own
    if found[1] == "none":
        return np.diag([*scale, 1.0]) @ moved(*-corner)
    scale = np.full(2, scale.max() if found[4] == "slice" else scale.min())
    align = np.array([ALIGNED[found[2]], ALIGNED[found[3]]])
    free = align * (np.array(size) - scale * own)
    return moved(*free) @ np.diag([*scale, 1.0]) @ moved(*-corner)


def moved(x: float, y: float) -> Array:
    """(3, 3) of a translation."""
    return np.array([[1.0, 0.0, x], [0.0, 1.0, y], [0.0, 0.0, 1.0]])


def shape(tag: str, element: Element, matrix: Array, viewport: Size) -> Any:
    """Path of svgelements in its own coordinates; matrix (3, 3), from those to metres."""
    given = element.attrib

    def of(name: str) -> float:
        return length(given.get(name, "0"), name, viewport)

    def size(name: str) -> float:
        if not (value := of(name)) > 0.0:
            at = place((matrix @ [*corner, 1.0])[:2])
            raise ValueError(f"its {name} is {value:g}, at {at}")
        return value

    if tag == "path":
        return _path(given.get("d", ""))
    if tag in ("polyline", "polygon"):
        values = numbers(given.get("points", ""), "points")
        if len(values) % 2:
            raise ValueError("its points end with an x that has no y")
        ends = f"M{' '.join(map(repr, values))}" if values else ""
        return _path(ends + ("z" if ends and tag == "polygon" else ""))
    if tag == "line":
        return _path("M" + " ".join(repr(of(name)) for name in ("x1", "y1", "x2", "y2")))
    corner = (of("x"), of("y")) if tag == "rect" else (of("cx"), of("cy"))
    whole = (size("width"), size("height")) if tag == "rect" else (np.inf, np.inf)
    if tag == "circle":
        radii = [size("r")] * 2
    else:
        known = {name: of(name) for name in ("rx", "ry") if given.get(name, "auto") != "auto"}
        for name, value in known.items():
            if value < 0.0:
                raise ValueError(f"its {name} is {value:g}")
        # Each is that of the other where it is not given.
        radii = [known.get(name, max(known.values(), default=0.0)) for name in ("rx", "ry")]
    if tag == "rect":
        rx, ry = (min(radius, side / 2.0) for radius, side in zip(radii, whole, strict=True))
        return svgelements.Path(svgelements.Rect(*corner, *whole, rx, ry))
    rx, ry = (radius or size(name) for radius, name in zip(radii, ("rx", "ry"), strict=True))
    return svgelements.Path(svgelements.Ellipse(cx=corner[0], cy=corner[1], rx=rx, ry=ry))


def _path(d: str) -> Any:
    """Raises ValueError for what a viewer would draw in part only."""
    check_points(len(re.findall(NUMBER, d)) // 2)
    rest = re.sub(NUMBER, " ", d).strip()
    if rest and (rest[0] not in "Mm" or re.search(r"[^\s,MmZzLlHhVvCcSsQqTtAa]", rest)):
        raise ValueError(f"its d is {_short(d)}, which is no path")
    # A smooth curve goes on from one of its own kind alone; svgelements lets it from any.
    d = re.sub(r"([QqTt][-+.,\d\seE]*)(?=[Ss])|([CcSs][-+.,\d\seE]*)(?=[Tt])", r"\1\2l0 0", d)
    try:
        return svgelements.Path(d)
    except (ValueError, IndexError, TypeError) as error:
        raise ValueError(f"its d is {_short(d)}, which is no path") from error


def _short(text: str) -> str:
    return repr(text if len(text) <= 40 else f"{text[:37]}...")
