"""What a controller or another program takes over: the learned correction, as angles or poses.

Angles are of the motors, on the arm side of the gear [rad]; positions of the tool in base axes [m].
"""
