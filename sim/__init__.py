"""Virtual hardware: robots in MuJoCo with motor encoders, an IMU and a laser tracker.

`armside.sim.laser` is the cutting experiment, `armside.sim.imu` the one of thesis chapter 5,
`armside.sim.tuning` the Gymnasium env.
"""
