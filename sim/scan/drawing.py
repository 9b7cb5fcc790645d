"""The drawing of a sheet, as the contours that a scan is compared with."""

from collections import Counter
from pathlib import Path
from typing import NamedTuple

from ..part.curve import ChainCurve
from ..part.drawing import DrawnChain, Reading, shapely
from ..part.part import read_chains


class SheetDrawing(NamedTuple):
    """Contours of a drawing by name, in its coordinates."""

    contours: dict[str, ChainCurve]
    pieces: frozenset[str]
    """Those whose material lies inside."""
    notes: tuple[str, ...]


def read_drawing(
    file: Path, reading: Reading | None = None, *, piece: bool | None = None
) -> SheetDrawing:
    """Contours of a drawing (DXF, SVG, TOML): a part, if one contour lies around all others;
    else holes of a sheet.

    piece: whether a drawing of a single contour is the piece that was cut out, not its hole.

    Raises as `read_part` does, and for contours around each other that are no part.
    """

    def made(chains: list[DrawnChain], notes: tuple[str, ...]) -> SheetDrawing:
        contours, seen = dict[str, ChainCurve](), Counter[str]()
        on = Counter(each.layer for each in chains)
        for each in chains:  # by a layer of its own, as of a coupon
            alone = on[each.layer] == 1 < len(chains) and each.layer not in ("", "0")
            own = each.layer if alone else each.name
            seen[own] += 1
            n = seen[own]
            name = own if n == 1 else f"{own} ({n})"
            chain = each.chain.reversed if each.chain.closed and each.chain.area < 0 else each.chain
            contours[name] = ChainCurve(chain)
        lines = [shapely.LineString(curve.chain.polygon()) for curve in contours.values()]
        closed = [i for i, curve in enumerate(contours.values()) if curve.chain.closed]
        areas = {i: shapely.Polygon(lines[i]) for i in closed}
        around = {i: sum(areas[i].contains(line) for line in lines) for i in closed}
        outer = [i for i in closed if around[i]]
        pieces = list[str]()
        if len(outer) == 1 and around[outer[0]] == len(lines) - 1 and piece is not False:
            pieces = [list(contours)[outer[0]]]
        elif outer:
            raise ValueError(
                "its contours lie around each other: draw one part, or a sheet of separate holes"
            )
        elif piece:
            pieces = list(contours)
        return SheetDrawing(contours, frozenset(pieces), notes)

    return read_chains(file, reading or Reading(), made)
