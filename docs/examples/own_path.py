"""Your own path: points in TOML, a drawing (DXF), or a contour made in Python.

From the command line: armside laser --contour house.toml, or --contour drawing.dxf.
"""

from pathlib import Path

import ezdxf
import numpy as np

from armside import read_contour, rounded

house = read_contour(Path(__file__).parent / "house.toml")

drawing = ezdxf.new()
drawing.units = ezdxf.units.MM
slot = [(-10, -4, 0), (10, -4, 1), (10, 4, 0), (-10, 4, 1)]  # x, y, bulge: two half circles
drawing.modelspace().add_lwpolyline(slot, format="xyb", close=True)
drawing.saveas("slot.dxf")

angle = np.linspace(0, 2 * np.pi, 10, endpoint=False)
star = 0.012 * np.column_stack([np.cos(angle), np.sin(angle)])
star[1::2] *= 0.6

for name, contour in (
    ("house", house),
    ("slot", read_contour(Path("slot.dxf"))),
    ("star", rounded(star, 0.0015)),
):
    print(f"{name}: {1e3 * contour.length:.1f} mm around")
