"""Leaves of an SVG document as a viewer draws them: uses, symbols, viewports, styles resolved."""

from collections import Counter
from collections.abc import Iterator, Mapping
from dataclasses import dataclass, field, replace
from typing import NamedTuple
from xml.etree.ElementTree import Element

import numpy as np

from armside.arrays import Array

from .expansion import check_expansion
from .svg_shape import SHAPES, Size, fitted_in, length, moved, transform, viewbox
from .svg_style import INITIAL, Styles, opaque, painted

SVG = "{http://www.w3.org/2000/svg}"
INKSCAPE = "{http://www.inkscape.org/namespaces/inkscape}"
HREF = ("href", "{http://www.w3.org/1999/xlink}href")
VIEWPORTS = {"svg", "symbol"}
GROUPS = {"g", "a", "switch", *VIEWPORTS}
SILENT = {
    *("defs", "title", "desc", "metadata", "style", "script", "symbol", "clipPath", "mask"),
    *("filter", "marker", "pattern", "linearGradient", "radialGradient", "view"),
}
"""Tags that draw nothing where they stand."""
MOVING = {"set", "animate", "animateTransform", "animateMotion"}
CHANGES = ("clip-path", "mask", "filter")
CLIPPED = "clipped shapes cannot be cut; release the clip, or draw without it"
HIDDEN, UNSEEN = "hidden elements", "elements without stroke and fill"
Clip = tuple[Array, Size, str]
"""Viewport that ends what is drawn in it: matrix from its coordinates, size, name."""


@dataclass(frozen=True, eq=False)
class Place:
    """What an element has from where it stands."""

    matrix: Array
    """(3, 3), from its own coordinates to those of the page [m], y up."""
    viewport: Size
    style: Mapping[str, str] = field(default_factory=lambda: INITIAL)
    layer: str = ""
    hidden: str = ""
    """What it counts as where it does not show."""
    trouble: str = ""
    """Why it cannot be cut."""
    within: str = ""
    clips: tuple[Clip, ...] = ()


class Leaf(NamedTuple):
    """An element that is no group, at one of the places where it is drawn."""

    tag: str
    element: Element
    name: str
    at: Place
    filled: bool
    stroked: bool


class Document:
    """A parsed drawing. ValueError for a cycle, too many elements or styles in doubt."""

    def __init__(self, root: Element) -> None:
        self.root = root
        self._prefix = SVG if root.tag.startswith(SVG) else ""
        self._ids: dict[str, Element] = {}
        self._count = Counter(element.get("id", "") for element in root.iter())
        for element in root.iter():
            self._ids.setdefault(element.get("id", ""), element)
        check_expansion(root, self._parts, self._label)
        self._styles = Styles(root)
        self._of_tag = Counter[str]()

    def leaves(self, page: Size, metres: float) -> Iterator[Leaf]:
        """Elements that are no groups, as they are drawn. page: [pixels]; metres: of a pixel."""
        at = self._inside(self.root, Place(np.diag([metres, -metres, 1.0]), page))
        at = _fitted(self.root, at, page)
        for child in self.root:
            yield from self._leaves(child, at)

    def tag(self, element: Element) -> str:
        """Without the namespace of the drawing; with any other."""
        tag = element.tag.removeprefix(self._prefix)
        return f"{{}}{tag}" if self._prefix and tag == element.tag and tag[0] != "{" else tag

    def _label(self, element: Element) -> str:
        known = element.get("id")
        return f"{self.tag(element)} {f'#{known}' if known else '(without id)'}"

    def _parts(self, element: Element) -> Iterator[tuple[int, Element]]:
        yield from ((1, child) for child in element)
        if self.tag(element) == "use":
            target = self._ids.get(_reference(element)[1:])
            yield from [] if target is None else [(1, target)]

    def _leaves(self, element: Element, at: Place, use: Element | None = None) -> Iterator[Leaf]:
        tag = self.tag(element)
        if tag in SILENT and not (tag == "symbol" and use is not None):
            return
        if not tag.startswith("{"):
            at = self._inside(element, at, use)
        if tag == "use":
            yield from self._used(element, at)
        elif tag in GROUPS:
            at = at if at.within else replace(at, layer=layer_of(element, at.layer))
            shown = next((e for e in element if "requiredExtensions" not in e.attrib), None)
            other = replace(at, hidden=at.hidden or "alternatives of a switch")
            for child in element:
                yield from self._leaves(child, at if tag != "switch" or child is shown else other)
        else:
            yield self._leaf(element, tag, at)

    def _inside(self, element: Element, at: Place, use: Element | None = None) -> Place:
        """What is inside of an element, or the element itself, has from it."""
        tag = self.tag(element)
        try:
            style = self._styles.computed(element, at.style)
            at = replace(at, style=style, matrix=at.matrix @ transform(element))
            if style["display"] == "none" and tag != "symbol":
                at = replace(at, hidden=at.hidden or HIDDEN)
            if not opaque(style, "opacity"):
                at = replace(at, hidden=at.hidden or UNSEEN)
            if changes := [name for name in CHANGES if style[name] not in ("none", "")]:
                raise ValueError(f"it has a {changes[0]}: {CLIPPED}")
            if {"systemLanguage", "requiredExtensions"} & element.attrib.keys():
                raise ValueError("only some programs show it")
            if tag in VIEWPORTS and element is not self.root:
                at = self._viewport(element, at, use)
            if element is self.root and "transform" in element.attrib:
                raise ValueError("it has a transform, which only some programs read")
        except ValueError as error:
            group = f"{self._label(element)}: " if tag in GROUPS or tag == "use" else ""
            at = replace(at, trouble=at.trouble or f"{group}{error}")
        return at

    def _viewport(self, element: Element, at: Place, use: Element | None) -> Place:
        names = ("x", "y", "width", "height")
        own = {name: element.attrib[name] for name in names if name in element.attrib}
        unread = {"transform", *own} if self.tag(element) == "symbol" else {"transform"}
        if found := sorted(unread & element.attrib.keys()):
            raise ValueError(f"it has a {found[0]}, which only some programs read")
        if use is not None:
            own |= {name: use.attrib[name] for name in names[2:] if name in use.attrib}
        x, y, w, h = (
            length(own.get(n, "100%" if n in names[2:] else "0"), n, at.viewport) for n in names
        )
        if min(w, h) <= 0.0:
            raise ValueError(f"its width and height are {w:g} and {h:g}")
        at = replace(at, matrix=at.matrix @ moved(x, y))
        if at.style["overflow"] not in ("visible", "auto"):
            clip = (at.matrix, (w, h), f"{self._label(element)}{at.within}")
            at = replace(at, clips=(*at.clips, clip))
        return _fitted(element, at, (w, h))

    def _used(self, use: Element, at: Place) -> Iterator[Leaf]:
        reference = _reference(use)
        target = self._ids.get(reference[1:]) if reference[:1] == "#" else None
        trouble, tag = "", "" if target is None else self.tag(target)
        if target is None or self._count[reference[1:]] > 1:
            what = "is not in the drawing" if target is None else "is more than one element"
            trouble = f"it refers to {reference!r}, which {what}"
        elif tag in SILENT - {"symbol"} or tag[0] == "{":
            trouble = f"it refers to a {tag}"
        if target is None or trouble:
            yield self._leaf(use, "use", replace(at, trouble=at.trouble or trouble))
            return
        try:
            x, y = (length(use.get(name, "0"), name, at.viewport) for name in ("x", "y"))
            at = replace(at, matrix=at.matrix @ moved(x, y))
        except ValueError as error:
            trouble = f"{self._label(use)}: {error}"
        layer = at.layer if at.within else layer_of(use, at.layer)
        within, trouble = at.within or f" of {self._label(use)}", at.trouble or trouble
        at = replace(at, layer=layer, within=within, trouble=trouble)
        yield from self._leaves(target, at, use)

    def _leaf(self, element: Element, tag: str, at: Place) -> Leaf:
        self._of_tag[tag] += 1
        name = f"#{element.get('id')}" if element.get("id") else f"{self._of_tag[tag]} (without id)"
        trouble, filled, stroked = "", False, False
        if tag not in SHAPES | {"use"}:
            trouble = "it cannot be cut; choose the layers to cut, or remove it"
        elif any(self.tag(child) in MOVING for child in element):
            trouble = "it is animated"
        try:
            filled, stroked = (painted(at.style, each, self._ids) for each in ("fill", "stroke"))
        except ValueError as error:
            trouble = trouble or str(error)
        hidden = at.hidden or ("" if at.style["visibility"] == "visible" else HIDDEN)
        at = replace(at, hidden=hidden, trouble=at.trouble or trouble)
        return Leaf(tag, element, f"{tag} {name}{at.within}", at, filled, stroked)


def _fitted(element: Element, at: Place, size: Size) -> Place:
    box = viewbox(element)
    inner = at.matrix @ fitted_in(element, size)
    return replace(at, matrix=inner, viewport=(box[2], box[3]) if box else size)


def layer_of(group: Element, outer: str) -> str:
    """Layer of what is inside a group."""
    if group.get(f"{INKSCAPE}groupmode") == "layer":
        return group.get(f"{INKSCAPE}label") or group.get("id") or outer
    return outer or group.get("id") or ""


def _reference(use: Element) -> str:
    return next((use.attrib[name] for name in HREF if name in use.attrib), "").strip()
