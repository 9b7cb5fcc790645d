"""Virtual hardware: robots in MuJoCo with motor encoders, an IMU and a laser tracker.

`armside.sim.laser` is the cutting experiment, `armside.sim.imu` the one of thesis chapter 5,
`armside.sim.tuning` the Gymnasium env.
"""

import lazy_loader

__getattr__, __dir__, __all__ = lazy_loader.attach_stub(__name__, __file__)
