"""Style of SVG elements: presentation attributes, rules and inline styles in the order of CSS."""

import re
from collections.abc import Mapping
from typing import Any
from xml.etree.ElementTree import Element

import cssselect2
import tinycss2
from tinycss2 import color4

INHERITED = {
    "visibility": "visible",
    "fill": "black",
    "stroke": "none",
    "fill-opacity": "1",
    "stroke-opacity": "1",
    "stroke-width": "1",
    "color": "black",
    "marker": "none",
    "marker-start": "none",
    "marker-mid": "none",
    "marker-end": "none",
}
OWN = {
    "display": "inline",
    "opacity": "1",
    "overflow": "",
    "clip-path": "none",
    "mask": "none",
    "filter": "none",
}
INITIAL = INHERITED | OWN
"""Initial values of the properties that decide whether and where a shape is seen."""
UNREAD = {
    *("transform", "transform-origin", "transform-box", "translate", "rotate", "scale", "all"),
    *("x", "y", "width", "height", "cx", "cy", "r", "rx", "ry", "d"),
}
"""Properties that move a shape in some programs and not in others."""
SAME_EVERYWHERE = ("charset", "font-face", "keyframes", "-webkit-keyframes", "namespace")
"""At-rules that neither hide nor move a shape."""
NUMBER = r"[-+]?(?:\d+\.?\d*|\.\d+)(?:[eE][-+]?\d+)?"


class Styles:
    """Declared values of the elements of a document; ValueError for a rule in doubt."""

    def __init__(self, root: Element) -> None:
        self._matcher = cssselect2.Matcher()
        for sheet in (e for e in root.iter() if e.tag.rpartition("}")[2] == "style"):
            self._add(sheet)
        self._wrapped: dict[Element, Any] = {}
        if self._matcher.order:
            tree = cssselect2.ElementWrapper.from_xml_root(root)
            self._wrapped = {each.etree_element: each for each in tree.iter_subtree()}
        self._known: dict[Element, tuple[dict[str, str], set[str]]] = {}

    def _add(self, sheet: Element) -> None:
        if sheet.get("type", "text/css") not in ("", "text/css"):
            return
        if (media := sheet.get("media", "all")) not in ("", "all", "screen"):
            raise ValueError(f"its style for the medium {media!r} is not understood; remove it")
        rules = tinycss2.parse_stylesheet(sheet.text or "", True, True)
        for rule in rules:
            if rule.type == "at-rule" and rule.lower_at_keyword in SAME_EVERYWHERE:
                continue
            try:
                if rule.type != "qualified-rule":
                    raise cssselect2.SelectorError
                selectors = cssselect2.compile_selector_list(rule.prelude)
            except cssselect2.SelectorError:
                shown = re.sub(r"\s+", " ", rule.serialize())[:60]
                raise ValueError(f"its style {shown!r} is not understood; remove it") from None
            for selector in selectors:
                if selector.pseudo_element is None:
                    self._matcher.add_selector(selector, rule.content)

    def _declared(self, element: Element) -> tuple[dict[str, str], set[str]]:
        """Values by property, and the names of those that a style declares, not an attribute."""
        if known := self._known.get(element):
            return known
        values = {name: text for name, text in element.attrib.items() if name in INITIAL}
        blocks: list[Any] = [element.get("style", "")]
        if element in self._wrapped:
            blocks[:0] = [match[-1] for match in self._matcher.match(self._wrapped[element])]
        named = [d for block in blocks for d in tinycss2.parse_blocks_contents(block, True, True)]
        named = [d for d in named if d.type == "declaration"]
        for declaration in sorted(named, key=lambda d: d.important):
            values[declaration.lower_name] = tinycss2.serialize(declaration.value)
        values = {name: text.strip() for name, text in values.items()}
        self._known[element] = values, {declaration.lower_name for declaration in named}
        return self._known[element]

    def computed(self, element: Element, parent: Mapping[str, str]) -> dict[str, str]:
        """Values of an element by those of its parent. Raises ValueError for one in doubt."""
        declared, by_style = self._declared(element)
        if unread := sorted(by_style & UNREAD):
            raise ValueError(f"its {unread[0]} is set by a style, which programs read differently")
        if "transform-origin" in element.attrib:
            raise ValueError("it has a transform-origin, which programs read differently")
        found = {}
        for name, initial in INITIAL.items():
            value = declared.get(name, "unset")
            if "var(" in value:
                raise ValueError(f"its {name} is {value!r}, a variable")
            if value == "inherit" or (value in ("unset", "revert") and name in INHERITED):
                value = parent[name]
            found[name] = initial if value in ("unset", "revert", "initial") else value
        return found


def painted(style: Mapping[str, str], name: str, ids: Mapping[str, Element]) -> bool:
    """Whether fill or stroke shows. Raises ValueError for what is no colour."""
    value = style[name].partition(" icc-color")[0]
    if server := re.match(r"url\(\s*['\"]?#(.*?)['\"]?\s*\)\s*(.*)", value):
        value = "black" if server[1] in ids else server[2] or "none"
    if value.lower() in ("none", "context-fill", "context-stroke"):
        return value.lower() != "none"
    color: Any = color4.parse_color(value)
    if color == "currentcolor":
        color = color4.parse_color(style["color"])
    if color is None or isinstance(color, str):
        raise ValueError(f"its {name} is {value!r}, which is no colour")
    shows = color.alpha > 0.0 and opaque(style, f"{name}-opacity")
    return shows and (name == "fill" or opaque(style, "stroke-width"))


def opaque(style: Mapping[str, str], name: str) -> bool:
    """Whether a number is above 0, with any unit. Raises ValueError for what is no number."""
    found = re.fullmatch(rf"({NUMBER})\s*(?:%|[a-zA-Z]*)", style[name])
    if not found:
        raise ValueError(f"its {name} is {style[name]!r}")
    return float(found[1]) > 0.0
