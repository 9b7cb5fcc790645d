"""Virtual hardware: robots in MuJoCo with motor encoders, an IMU and a laser tracker.

Importing it registers the env `armside/IlcTuning-v0` with Gymnasium; see `sim.tuning`.
"""

import gymnasium

gymnasium.register(
    id="armside/IlcTuning-v0",
    entry_point="sim.tuning.env:IlcTuningEnv",
    vector_entry_point="sim.tuning.vector_env:IlcTuningVectorEnv",
)
