"""Many robots at once are the same robots."""

import os
import re
import subprocess
import sys
from pathlib import Path

import gymnasium
import numpy as np
import pytest
from gymnasium.vector import SyncVectorEnv

import armside.sim.tuning  # noqa: F401 - registers the env
from armside.sim.cell import ToolPose
from armside.sim.robot.spread import Drawn
from armside.sim.tuning.vector_env import IlcTuningVectorEnv

ID = "armside/IlcTuning-v0"


def _same(one, other):
    if isinstance(one, dict):
        assert one.keys() == other.keys()
        for key in one:
            _same(one[key], other[key])
    elif isinstance(one, np.ndarray) and one.dtype == object:
        for a, b in zip(one, other, strict=True):
            _same(a, b)
    elif isinstance(one, ToolPose):
        assert one == other
    elif one is not None or other is not None:
        a, b = np.asarray(one), np.asarray(other)
        assert a.dtype == b.dtype
        assert a.tobytes() == b.tobytes()


def in_a_fresh_process(code, **environment):
    command, env = [sys.executable, "-c", code], os.environ | environment
    done = subprocess.run(command, env=env, capture_output=True, text=True, check=False)
    assert done.returncode == 0, done.stderr
    return done


def test_the_pages_own_lines_make_many_robots_in_a_fresh_process():
    page = (Path(__file__).parents[3] / "docs" / "tuning.md").read_text(encoding="utf-8")
    (lines,) = (b for b in re.findall(r"```python\n(.*?)```", page, re.S) if "make_vec" in b)
    done = in_a_fresh_process(lines + "print(observations.shape, type(cells.unwrapped).__name__)")
    assert done.stdout == "(4, 53) IlcTuningVectorEnv\n"


def test_what_only_the_first_use_of_a_robot_waits_for_is_a_line(tmp_path):
    code = """
import gymnasium
gymnasium.make("armside:armside/IlcTuning-v1")
from armside.kinematics.cache import cached_module
for _ in range(2):
    cached_module("of_a_test", "key", lambda: "one = 1\\n")
"""
    for lines in (1, 0):
        done = in_a_fresh_process(code, XDG_CACHE_HOME=str(tmp_path))
        assert done.stderr.count("armside: compiling of_a_test") == lines


@pytest.mark.parametrize("mode", ["NextStep", "SameStep"])
@pytest.mark.parametrize("name", [ID, "armside/IlcTuning-v1"])
def test_rows_are_bitwise_those_of_the_single_env_through_resets(name, mode):
    """Against Gymnasium's own vector env over single ones: observations, rewards, ends, infos."""
    one = SyncVectorEnv([lambda: gymnasium.make(name, iterations=1)] * 3, autoreset_mode=mode)
    how = {"vectorization_mode": "vector_entry_point", "iterations": 1, "threads": 2}
    many = gymnasium.make_vec(name, num_envs=3, autoreset_mode=mode, **how)
    assert isinstance(many.unwrapped, IlcTuningVectorEnv)
    assert many.action_space == one.action_space
    assert many.observation_space == one.observation_space
    _same(many.reset(seed=5)[0], one.reset(seed=5)[0])
    actions = np.random.default_rng(0).uniform(-1, 1, (2, 3, 3)).astype(np.float32)
    for action in actions:
        for ours, theirs in zip(many.step(action), one.step(action), strict=True):
            _same(ours, theirs)
    many.close()


def test_a_mask_resets_the_robots_it_names_only(quick):
    cells = IlcTuningVectorEnv(2, iterations=1, autoreset_mode="Disabled")
    first, _ = cells.reset(seed=0, options=quick)
    cells.step(np.zeros((2, 3), np.float32))
    assert cells.episodes_over.tolist() == [True, True]
    mask = np.array([False, True])
    again, info = cells.reset(seed=[None, 1], options=quick | {"reset_mask": mask})
    assert cells.episodes_over.tolist() == [True, False]
    assert np.array_equal(again[1], first[1])
    assert not np.array_equal(again[0], first[0])
    assert info["_k"].tolist() == [False, True]
    with pytest.raises(RuntimeError, match="reset_mask"):
        cells.step(np.zeros((2, 3), np.float32))


@pytest.mark.parametrize(
    ("options", "said"),
    [
        ({"num_envs": 0}, "num_envs must be a whole number >= 1, got 0"),
        ({"num_envs": "2"}, "num_envs must be a whole number >= 1"),
        ({"num_envs": 1.5}, "num_envs must be a whole number >= 1"),
        ({"threads": 0}, "threads must be a whole number >= 1"),
        ({"threads": 1.5}, "threads must be a whole number >= 1"),
        ({"threads": "2"}, "threads must be a whole number >= 1"),
        ({"motors": "none"}, "Unknown motors"),
        ({"autoreset_mode": "x"}, "It can be: NextStep, SameStep, Disabled"),
        ({"sealed": True}, "a sealed env cannot start episodes by itself"),
    ],
)
def test_options_of_cells_that_make_no_sense_are_refused(options, said):
    with pytest.raises(ValueError, match=said):
        IlcTuningVectorEnv(**options)


@pytest.mark.parametrize(
    ("given", "said"),
    [
        *(({"seed": bad}, "seed must be a whole number >= 0") for bad in (1.5, "ab", -1, True)),
        *(({"seed": bad}, "seed must be a whole number >= 0") for bad in ([3, -1], [3, 4.0])),
        ({"seed": [1, 2, 3]}, "2 robots need as many seeds, got 3"),
        ({"seed": 900_000_000}, "sealed test seeds"),
        ({"options": {"reset_mask": np.zeros(2, dtype=bool)}}, "reset_mask must be 2 booleans"),
        ({"options": [1]}, "options of reset must be a dict"),
    ],
)
def test_a_reset_of_cells_that_makes_no_sense_is_refused(given, said):
    with pytest.raises(ValueError, match=said):
        IlcTuningVectorEnv(2).reset(**given)


def test_bad_steps_are_one_clear_error(quick):
    cells = IlcTuningVectorEnv(2)
    with pytest.raises(RuntimeError, match="call reset"):
        cells.step(np.zeros((2, 3), np.float32))
    cells.reset(seed=0, options=quick)
    with pytest.raises(ValueError, match=r"robot 1: an action must .* got nan at index 1"):
        cells.step(np.array([[0, 0, 0], [0, np.nan, 0]], np.float32))
    with pytest.raises(ValueError, match="actions must have shape"):
        cells.step(np.zeros((3, 3), np.float32))
    cells.close()
    with pytest.raises(RuntimeError, match="closed"):
        cells.step(np.zeros((2, 3), np.float32))


def test_a_reset_that_is_refused_leaves_the_robots_as_they_were(quick):
    cells = IlcTuningVectorEnv(2, iterations=1)
    after = []
    for refused in (False, True):
        cells.reset(seed=0, options=quick)
        if refused:
            with pytest.raises(ValueError, match="speed"):
                cells.reset(seed=50, options={"speed": 9})
            with pytest.raises(ValueError, match="cannot carry its load"):
                cells.reset(seed=np.array([50, 51]), options={"payload": 900.0})
        cells.step(np.zeros((2, 3), np.float32))
        after.append(cells.step(np.zeros((2, 3), np.float32))[0])  # drawn anew
    assert np.array_equal(*after)
    cells.close()


def test_seeds_of_numpy_are_seeds(quick):
    cells = IlcTuningVectorEnv(2)
    observed = cells.reset(seed=np.array([3, 4]), options=quick)[0]
    assert np.array_equal(observed, cells.reset(seed=3, options=quick)[0])
    cells.close()


def test_cells_of_one_individual_are_that_robot_with_noise_of_their_own(quick):
    cells = IlcTuningVectorEnv(2, individual=Drawn(6), autoreset_mode="Disabled")
    one = gymnasium.make(ID, individual=Drawn(6))
    rows, infos = cells.reset(seed=0, options=quick)
    assert np.array_equal(rows[0], one.reset(seed=0, options=quick)[0])
    assert not np.array_equal(rows[0], rows[1])
    assert list(infos["individual"]) == [Drawn(6)] * 2
    cells.close()


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
