"""Tool error by iteration at three positions."""

LINE = "reproduce 9.11"
DRAWN = "figures/9.11.png"
