"""Phase of L T_u for shifts and for rough models."""

LINE = "reproduce why-q"
DRAWN = "figures/why-q.png"
