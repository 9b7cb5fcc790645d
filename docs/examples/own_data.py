"""Your own recorded data: write a table with these columns, and measure it as a run of armside.

Here the data are made up: two motors with a constant error, and a tool on a circle that is 20 um
too large. The last line reads the file as `armside measure mine.csv --gear 100 50 --radius 5` does.
"""

from pathlib import Path

import numpy as np

from armside import CircleTurn, measure_table, read_table

time = np.arange(500) * 0.004
turn = np.pi * time
reference = np.column_stack([np.sin(time), np.cos(time)])  # rad, arm side of the gear
motor_angle = reference - [1e-3, -2e-3]
tracker = 0.00502 * np.column_stack([np.cos(turn), np.sin(turn), 0 * turn]) + [0.3, 0.0, 1.2]

header = "time,reference_1,reference_2,motor_angle_1,motor_angle_2,tracker_x,tracker_y,tracker_z"
rows = np.column_stack([time, reference, motor_angle, tracker])
np.savetxt("mine.csv", rows, delimiter=",", header=header, comments="", fmt="%.12g")

circle = CircleTurn(radius=0.005)
(measured,) = measure_table(read_table(Path("mine.csv")), gear=[100, 50], turn=circle)
print(measured.motor_inf, f"tool {1e6 * measured.arm_rms:.1f} um")
