"""SVG drawings at random: what may nest, move, style, hide and clip, with colours that tell whose.

Each shape has colours of its own, so that a picture says which shape shows where, by no rule of
the reader's.
"""

from dataclasses import dataclass, field

import numpy as np

from .drawings import Chances

NAMESPACES = (
    'xmlns="http://www.w3.org/2000/svg" xmlns:xlink="http://www.w3.org/1999/xlink" '
    'xmlns:inkscape="http://www.inkscape.org/namespaces/inkscape"'
)
UNITS = {"": 1.0, "px": 1.0, "mm": 96 / 25.4, "cm": 96 / 2.54, "in": 96.0, "pt": 4 / 3, "pc": 16.0}
SHAPES = ("path", "rect", "circle", "ellipse", "line", "polygon", "polyline")
ALIGNED = ("none", *(f"x{a}Y{b}" for a in ("Min", "Mid", "Max") for b in ("Min", "Mid", "Max")))
PIXELS = 900.0
"""Width of the picture."""


@dataclass
class Generated:
    """A drawing and what is known of it."""

    text: str = ""
    width: float = 0.0
    """[mm], of the page."""
    height: float = 0.0
    shapes: int = 0
    """Instances of shapes in the document, hidden ones too."""
    parts: dict[str, int] = field(default_factory=dict)
    """Contours of one instance, by id."""
    colours: dict[str, set[int]] = field(default_factory=dict)
    """Colours that a shape may have, by id."""
    doubtful: set[str] = field(default_factory=set)
    """Identifiers that a refusal may name."""


class Generator(Chances):
    """Random elements; each method returns text and number of instances of shapes."""

    def __init__(self, seed: int) -> None:
        super().__init__(seed)
        self.made = Generated()
        self.rules: list[str] = []
        self.defs: list[str] = []
        self.targets: list[tuple[str, int, str]] = []
        """Identifier, instances and tag of what a use may refer to."""
        self.names = 0
        self.pixels = 1.0
        """Of a unit, about."""

    def number(self, value: float) -> str:
        return self.pick(f"{value:.4f}", f"{value:.5e}", f"{value:+.3f}", f"{value:.4g}")

    def length(self, value: float, whole: float | None = None) -> str:
        """A length in any unit; whole: of what it may be per cent."""
        if whole and self.chance(0.2):
            return f"{100.0 * value / whole:.5f}%"
        unit = self.pick("", "", "", *UNITS)
        return f"{value / UNITS[unit]:.6f}{unit}"

    def id(self, kind: str) -> str:
        self.names += 1
        return f"{kind}{self.names}"

    def colour(self, *owners: str) -> str:
        number = 1 + sum(len(c) for c in self.made.colours.values())
        code = (number * 7919) % 0xFFFFFF
        for owner in owners:
            self.made.colours.setdefault(owner, set()).add(code)
        return f"#{code:06x}"

    def transform(self) -> str:
        """An attribute that leaves shapes about where they are, and about as large."""
        words = []
        for _ in range(self.rng.integers(0, 3)):
            a, b, c = self.rng.uniform(-1.0, 1.0, 3)
            words.append(
                self.pick(
                    f"translate({15 * a:.3f},{15 * b:.3f})",
                    f"translate({15 * a:.3f})",
                    f"rotate({180 * a:.3f} 50 50)",
                    f"rotate({40 * a:.3f} , 50, 35)",
                    f"scale({1 + 0.3 * a:.3f} {1 + 0.3 * b:.3f})",
                    "translate(100 0)scale(-1,1)",
                    f"skewX({25 * a:.3f})",
                    f"skewY({25 * a:.3f})",
                    f"matrix({1 + 0.2 * a:.4f} {0.3 * b:.4f} {0.3 * c:.4f} {1 - 0.2 * b:.4f} 3 -4)",
                )
            )
        return f' transform="{self.pick(" ", "", ", ").join(words)}"' if words else ""

    def paint(self, name: str, *owners: str, stroked: bool = False) -> str:
        """Attributes that style an element in up to three ways, the winner by the cascade."""
        ways = self.rng.permutation(["attribute", "style", "class", "id", "classes"])
        stated, attributes = "", ""
        for way in ways[: self.rng.integers(1, 4)]:
            shade = self.colour(*owners)
            fill, stroke = self.pick((shade, shade if stroked else "none"), ("none", shade))
            if self.chance(0.06):
                fill = stroke = "none"
            width = self.rng.uniform(3.0, 5.0) / self.pixels
            pairs = [("fill", fill), ("stroke", stroke), ("stroke-width", f"{width:.4f}")]
            if self.chance(0.1):
                pairs.append(self.pick(("stroke-opacity", "0"), ("fill-opacity", "0")))
            if self.chance(0.1):
                pairs.append(self.pick(("display", "none"), ("display", "inline")))
            if self.chance(0.1):
                pairs.append(self.pick(("visibility", "hidden"), ("visibility", "visible")))
            if self.chance(0.04):
                pairs.append(("opacity", "0"))
            pairs = [pairs[i] for i in self.rng.permutation(len(pairs))]
            if way == "attribute":
                attributes += "".join(f' {key}="{value}"' for key, value in pairs)
                continue
            loud = " !important" if self.chance(0.1) else ""
            body = "; ".join(f"{key}:{value}{loud}" for key, value in pairs)
            if way == "style":
                stated = f' style="{body}"'
            elif way == "classes":  # not [id=...], which resvg takes to be as narrow as #...
                self.rules.append(f".x.k{name} {{{body}}}")
            else:
                self.rules.append(f"{'.k' if way == 'class' else '#'}{name} {{ {body} }}")
        return f'{attributes} class="x k{name}"{stated}'

    def path(self, x: float, y: float, r: float) -> tuple[str, bool]:
        """Data of one closed or open contour of curves and lines, and whether it is closed."""
        n = int(self.rng.integers(3, 6))
        turn = np.linspace(0.0, 2.0 * np.pi, n, endpoint=False) + self.rng.uniform(0.0, 6.0)
        radius = r * self.rng.uniform(0.6, 1.0, n)
        ends = np.column_stack([x + radius * np.cos(turn), y + radius * np.sin(turn)])
        d, at = f"M{self.number(ends[0, 0])},{self.number(ends[0, 1])}", ends[0]
        for i in range(1, n):
            relative = self.chance(0.5)
            origin = at if relative else np.zeros(2)
            at = np.round(ends[i], 3)
            mid = origin * -1.0 + 0.5 * (ends[i - 1] + ends[i]) + self.rng.uniform(-0.2, 0.2, 2) * r
            (u, v), (p, q) = at - origin, mid
            flag = self.pick("0", "1")
            word = self.pick(
                f"L{u:.6f} {v:.6f}",
                f"C{p:.4f},{q:.4f} {p:.4f},{q:.4f} {u:.6f},{v:.6f}",
                f"S{p:.4f} {q:.4f},{u:.6f} {v:.6f}",
                f"Q{p:.4f} {q:.4f} {u:.6f} {v:.6f}",
                f"A{r:.4f} {0.8 * r:.4f} {self.rng.uniform(0, 90):.2f} 0{flag}{u:.6f} {v:.6f}",
                f"A{r:.4f},{r:.4f},0,0,{flag},{u:.6f},{v:.6f}",
            )
            d += word[0].lower() + word[1:] if relative else word
        closed = self.chance(0.8)
        return d + (self.pick("z", "Z", " Z ") if closed else ""), closed

    def shape(self, view: tuple[float, float] | None, owner: str) -> tuple[str, int]:
        """One shape; owner: group whose colours it takes where it has none."""
        name, tag = self.id("s"), self.pick(*SHAPES)
        x, y = self.rng.uniform(20.0, 80.0), self.rng.uniform(15.0, 55.0)
        r, s = self.rng.uniform(4.0, 11.0, 2)
        w, h = view or (None, None)
        self.made.parts[name] = 1
        self.made.colours.setdefault(name, set())
        if tag == "path":
            d, closed = self.path(x, y, r)
            if self.chance(0.3):
                more, also = self.path(x + 2.5 * r, y, 0.6 * r)
                d, closed, self.made.parts[name] = d + more, closed and also, 2
            form = f'd="{d}"'
            if not closed:
                self.made.doubtful.add(name)
        elif tag == "rect":
            corner = self.pick("", f' rx="{r / 3:.3f}"', f' ry="{self.length(s)}" rx="1"')
            form = (
                f'x="{self.length(x, w)}" y="{self.length(y, h)}" '
                f'width="{self.length(r, w)}" height="{self.length(s, h)}"{corner}'
            )
        elif tag == "line":
            form = f'x1="{self.length(x, w)}" y1="{y:.3f}" x2="{x + r:.3f}" y2="{y + s:.3f}"'
        elif tag in ("polygon", "polyline"):
            ends = [(x, y), (x + r, y - s / 2), (x + 1.5 * r, y + s), (x + r / 3, y + s)]
            form = f'points="{self.pick(" ", ", ").join(f"{p:.4f},{q:.4f}" for p, q in ends)}"'
            if tag == "polyline":
                self.made.doubtful.add(name)
        else:
            diagonal = float(np.hypot(w, h)) / np.sqrt(2.0) if w and h else None
            form = f'cx="{self.length(x, w)}" cy="{self.length(y, h)}"'
            if tag == "circle":
                form += f' r="{self.length(r, diagonal)}"'
            else:
                form += f' rx="{self.length(r, w)}" ry="{self.length(s, h)}"'
        if owner and self.chance(0.25):
            self.made.colours[name] |= self.made.colours[owner]
            style = ""
        else:
            style = self.paint(name, name, stroked=name in self.made.doubtful)
        clip = ""
        if self.chance(0.01):
            clip = ' clip-path="url(#clip)"'
            self.made.doubtful.add(name)
        return f'<{tag} id="{name}" {form}{style}{self.transform()}{clip}/>', 1

    def group(self, depth: int, view, owner: str = "") -> tuple[str, int]:
        name, tag = self.id("g"), self.pick("g", "g", "g", "a")
        self.made.colours.setdefault(name, set())
        style = self.paint(name, name) if self.chance(0.5) else ""
        owner = name if style else owner
        inside = [self.element(depth - 1, view, owner) for _ in range(self.rng.integers(1, 4))]
        extra = ""
        if self.chance(0.01):
            extra = ' clip-path="url(#clip)"'
            self.made.doubtful.add(name)
        if self.chance(0.1):
            extra += f' inkscape:groupmode="layer" inkscape:label="L{name}"'
        text = "".join(each for each, _ in inside)
        return (
            f'<{tag} id="{name}"{style}{self.transform()}{extra}>{text}</{tag}>',
            sum(n for _, n in inside),
        )

    def aspect(self) -> str:
        align = self.pick(*ALIGNED)
        return self.pick(
            "", f' preserveAspectRatio="{align}"', f' preserveAspectRatio="{align} slice"'
        )

    def viewport(self, depth: int, tag: str, owner: str = "") -> tuple[str, int, str]:
        """A nested svg or a symbol."""
        name = self.id("v")
        size = (100.0, 70.0)
        box, place = "", ""
        if tag == "svg":
            w, h = self.rng.uniform(50.0, 90.0), self.rng.uniform(40.0, 60.0)
            x, y = self.rng.uniform(0.0, 20.0, 2)
            place = f' x="{self.length(x)}" y="{y:.2f}" width="{w:.2f}" height="{self.length(h)}"'
            size = (w, h)
        if tag == "symbol" or self.chance(0.7):
            box = f' viewBox="0 0 100 70"{self.aspect()}'
            size = (100.0, 70.0)
        over = self.pick(*[' overflow="visible"', ' style="overflow:visible"'] * 3, "")
        if not over:
            self.made.doubtful.add(name)
        view = None if tag == "symbol" else size  # resvg takes per cent in symbols of their use
        self.pixels *= 0.65
        inside = [self.element(depth - 1, view, owner) for _ in range(self.rng.integers(1, 3))]
        self.pixels /= 0.65
        text = "".join(each for each, _ in inside)
        return (
            f'<{tag} id="{name}"{place}{box}{over}>{text}</{tag}>',
            sum(n for _, n in inside),
            name,
        )

    def use(self, owner: str) -> tuple[str, int]:
        target, n, tag = self.targets[self.rng.integers(len(self.targets))]
        name, size = self.id("u"), ""
        x, y = self.rng.uniform(-15.0, 15.0, 2)
        if tag == "symbol":
            w, h = self.rng.uniform(50.0, 90.0), self.rng.uniform(40.0, 60.0)
            size = f' width="{w:.2f}" height="{h:.2f}"'
        style = ""
        if self.chance(0.4):  # of what the referenced shapes may take from it
            shapes = [s for s in self.made.parts if s not in self.placed]
            style = self.paint(name, name, *shapes)
        href = self.pick("href", "xlink:href")
        return (
            f'<use {href}="#{target}" id="{name}" x="{self.length(x)}" y="{y:.3f}"{size}{style}'
            f"{self.transform()}/>",
            n,
        )

    def element(self, depth: int, view, owner: str) -> tuple[str, int]:
        kind = self.rng.random()
        if depth > 0 and kind < 0.35:
            return self.group(depth, view, owner)
        if depth > 0 and kind < 0.45:
            return self.viewport(depth, "svg", owner)[:2]
        if self.targets and kind < 0.62:
            return self.use(owner)
        if kind < 0.635:
            name = self.id("t")
            self.made.doubtful.add(name)
            hidden = self.pick("", *[' display="none"', ' style="display:none"'] * 3)
            return f'<text id="{name}" x="20" y="20"{hidden}>M6</text>', 1
        if kind < 0.67:
            first, n = self.shape(view, owner)
            second, m = self.shape(view, owner)
            odd = '<foreignObject requiredExtensions="http://a.b"/>'
            return f"<switch>{odd}{first}{second}</switch>", n + m + 1
        return self.shape(view, owner)

    def drawing(self) -> Generated:
        """The drawing of a seed."""
        made = self.made
        made.width, made.height = self.rng.uniform(80.0, 300.0), self.rng.uniform(60.0, 200.0)
        unit = self.pick("mm", "cm", "in", "pt", "pc")
        size = [f"{v * UNITS['mm'] / UNITS[unit]:.6f}{unit}" for v in (made.width, made.height)]
        x, y = self.pick((0.0, 0.0), (-10.0, 5.0), (3.5, -8.0))
        aspect = self.aspect()
        scales = PIXELS / 100.0, PIXELS * made.height / made.width / 70.0
        self.pixels = max(scales) if "slice" in aspect or "none" in aspect else min(scales)
        self.placed: set[str] = set()
        for _ in range(self.rng.integers(1, 4)):
            if self.chance(0.5):
                text, n, name = self.viewport(1, "symbol")
                tag = "symbol"
            else:
                text, n = self.pick(lambda: self.group(2, None), lambda: self.shape(None, ""))()
                name, tag = text.partition('id="')[2].partition('"')[0], ""
            self.defs.append(text)
            self.targets.append((name, n, tag))
        in_defs = set(made.parts)
        inside = []
        for _ in range(self.rng.integers(2, 6)):
            before = set(made.parts)
            inside.append(self.element(3, (100.0, 70.0), ""))
            self.placed |= set(made.parts) - before
        assert in_defs.isdisjoint(self.placed)
        made.shapes = sum(n for _, n in inside)
        clip = '<clipPath id="clip"><rect x="20" y="20" width="40" height="30"/></clipPath>'
        order = self.rng.permutation(len(self.rules))
        sheet = "\n".join(self.rules[i] for i in order)
        sheet = f"<style>{self.pick(sheet, f'<![CDATA[{sheet}]]>')}</style>"
        defs = f"<defs>{clip}{''.join(self.defs)}</defs>"
        body = "".join(text for text, _ in inside)
        whole = self.pick(sheet + defs + body, defs + body + sheet, body + defs + sheet)
        root = f'width="{size[0]}" height="{size[1]}" viewBox="{x} {y} 100 70"{aspect}'
        width = 2.0 / self.pixels
        base = f'fill="none" stroke="#000" stroke-width="{width:.4f}"'
        made.text = f"<svg {NAMESPACES} {root} {base}>{whole}</svg>"
        return made


def generated(seed: int) -> Generated:
    """The drawing of a seed."""
    return Generator(seed).drawing()
