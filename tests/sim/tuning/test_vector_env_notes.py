"""Limits that changed the runs of many robots are counted."""

import numpy as np

from armside.sim.tuning.vector_env import IlcTuningVectorEnv


def test_runs_of_episodes_that_restart_are_counted_too():
    env = IlcTuningVectorEnv(1, iterations=1, autoreset_mode="SameStep")
    env.reset(seed=0, options={"speed": 0.1})
    env.step(np.zeros((1, 3), np.float32))
    (drawn,) = env.situations
    assert drawn.k == 0
    lowered = 2 + (drawn.experiment.motion.reached_speed < drawn.task.speed)
    (note,) = env.notes
    assert note.text.endswith(f"(in {lowered} of 3 runs)")
    env.close()
