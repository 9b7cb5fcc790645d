"""Number of axes of the robots that have twins and tuning environments."""

N_AXES = 6
AXES = range(1, N_AXES + 1)
