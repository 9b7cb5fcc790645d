"""Tool deviation over learning, by what is learned from."""

LINE = "compare"
DRAWN = "compare.png"
