"""The env's entry in Gymnasium's registry, made by importing this module."""

import gymnasium

ENV_ID = "armside/IlcTuning-v0"

gymnasium.register(
    id=ENV_ID,
    entry_point="armside.sim.tuning.env:IlcTuningEnv",
    vector_entry_point="armside.sim.tuning.vector_env:IlcTuningVectorEnv",
)
