"""Estimation of the tool along a long way, where springs act differently from place to place.

An elastic structure in series with the gears has springs that are constants of the robot. What they
give way is small everywhere, so it is linear around the rigid motion of the measured motor angles,
with matrices that follow the pose. SI units; axes as in `armside.sim.estimation`.
"""
