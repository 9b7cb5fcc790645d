"""Where the tool is, from motor angles and an IMU; what is learned from it."""
