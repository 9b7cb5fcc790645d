"""Whole parts: drawing -> contours -> plan of the cut.

SI units. A drawing (DXF, SVG, TOML) is read as chains of lines and arcs, exact where it has lines
and arcs and otherwise within `chain.TOLERANCE`. They are joined to contours, checked, and told
apart as outline, holes and open cuts. Errors are one line each and name the place in the drawing.
Reading needs the extra `parts`: ezdxf, svgelements and shapely.
"""
