"""Angular velocity of the IMU, measured and predicted from the motor angles."""

LINE = "reproduce 5.8"
DRAWN = "figures/5.8.png"
