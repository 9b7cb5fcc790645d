"""500 iterations on the two-mass joint, with Q = 1 and with Q."""

LINE = "reproduce 8.8"
DRAWN = "figures/8.8.png"
