"""Where each finding of chapter 9 holds: payload and speed."""

LINE = "reproduce 9-map"
DRAWN = "figures/9-map-payload.png"
