"""The env's entries in Gymnasium's registry, made by importing this module."""

import gymnasium

ENV_ID = "armside/IlcTuning-v0"

for _version in (0, 1):
    gymnasium.register(
        id=f"armside/IlcTuning-v{_version}",
        entry_point="armside.sim.tuning.env:IlcTuningEnv",
        vector_entry_point="armside.sim.tuning.vector_env:IlcTuningVectorEnv",
        kwargs={"version": _version} if _version else {},
    )
