"""Options of `armside tune` and `armside train` for the contours of their episodes."""

from typing import Annotated, Any, Literal

from cyclopts import Parameter

MM = 1e-3
_SEVERAL = Parameter(consume_multiple=True)
Shape = Literal["circle", "square", "slot", "hexagon"]
Shapes = Annotated[tuple[Shape, ...], _SEVERAL]
Radius = Annotated[tuple[float, ...], _SEVERAL]
"""[mm]: none, one, or smallest and largest."""


def contour_options(shape: tuple[Shape, ...], radius: tuple[float, ...]) -> dict[str, Any]:
    """Options of the env, [m]. Raises ValueError for more than two radii."""
    if len(radius) > 2:
        raise ValueError(f"radius takes one value, or smallest and largest, got {len(radius)}")
    ends = tuple(value * MM for value in radius)
    return {"shape": shape, "radius": None if not ends else ends[0] if len(ends) == 1 else ends}
