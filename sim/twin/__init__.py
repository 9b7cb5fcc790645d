"""Digital twin of a robot individual: commissioned from a few cuts, it learns in the robot's place.

A twin is the `Individual` that explains recordings of a robot, with what is uncertain about it. For
a new contour the learning happens inside the twin; its correction is used in the robot's first run.
"""

from .twin import Twin as Twin
