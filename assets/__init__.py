"""MJCF models of the robots, as paths. Data only."""
