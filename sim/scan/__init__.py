"""The cut part as the sensor: what a flatbed scan says of the contours that were cut.

SI units; in the plane of the sheet. An image is read as edges (extra `scan`: scikit-image), the
edges are placed on the drawing, and what is left across each contour is where the beam has been.
"""
