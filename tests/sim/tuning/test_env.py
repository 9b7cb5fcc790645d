"""`armside/IlcTuning-v0`: the contract of Gymnasium, and the rules of the thesis's budget."""

import inspect
import pickle
import re
import subprocess
import sys
from dataclasses import fields, replace
from pathlib import Path

import gymnasium
import numpy as np
import pytest
from gymnasium.utils.env_checker import check_env
from tests.claims._policies import always, run_episode

from armside import assets
from armside.sim import tuning
from armside.sim.laser.design import THESIS
from armside.sim.tuning.action import VARIABLES, Motors, action_of
from armside.sim.tuning.episode_task import OPTIONS, RANGES, TEST_SEEDS
from armside.sim.tuning.picture import LARGEST_SHOWN, MAGNIFICATIONS, magnification
from armside.sim.tuning.rules import HORIZON, WORST_REWARD, EnvCfg, Rules

ID, V1 = "armside/IlcTuning-v0", "armside/IlcTuning-v1"
ACTION = action_of(THESIS, Motors.SHARED)
BOLD = np.array([1.0, -1.0, 1.0], np.float32)
"""Large gain, no shift, high cutoff."""


def test_importing_sim_registers_the_env_and_imports_no_physics():
    code = f"import armside.sim.tuning, gymnasium, sys; gymnasium.spec({ID!r})"
    code += "; print('mujoco' in sys.modules)"
    done = subprocess.run([sys.executable, "-c", code], capture_output=True, text=True, check=True)
    assert done.stdout == "False\n"
    assert tuning.__doc__


TWO_LINK = assets.LARGE_ROBOT_XML.with_name("two_link.toml")
CORRECTION = {"robot": TWO_LINK, "action": "correction", "functions": 8, "iterations": 2}


@pytest.mark.parametrize(
    ("name", "options"),
    [
        (ID, {}),
        (V1, {}),
        (ID, {"robot": TWO_LINK, "shape": ("circle", "square"), "radius": (0.004, 0.012)}),
        (ID, CORRECTION | {"basis": "b-splines"}),
        (ID, CORRECTION | {"basis": "harmonics"}),
    ],
)
def test_the_env_checker_of_gymnasium_has_nothing_to_say(name, options):
    # Warnings are errors in this suite.
    check_env(gymnasium.make(name, render_mode="rgb_array", **options).unwrapped)


@pytest.fixture
def env():
    return gymnasium.make(ID, iterations=2)


def test_an_episode_is_truncated_after_its_budget_and_then_refuses_to_go_on(env, quick):
    env.reset(seed=0, options=quick)
    ends = [env.step(ACTION)[2:4] for _ in range(2)]
    assert ends == [(False, False), (False, True)]
    with pytest.raises(RuntimeError, match="over"):
        env.unwrapped.step(ACTION)


def test_a_run_that_diverges_terminates_with_the_worst_reward(quick):
    env = gymnasium.make(ID, iterations=10)
    env.reset(seed=0, options=quick)
    for _ in range(10):
        _, reward, terminated, truncated, info = env.step(BOLD)
        if terminated:
            break
    assert terminated
    assert not truncated
    assert reward == WORST_REWARD
    assert info["status"] == "diverged"


def test_rewards_add_up_to_the_decrease_of_the_log_error(env, quick):
    _, before = env.reset(seed=0, options=quick)
    steps = [env.step(ACTION) for _ in range(2)]
    after = steps[-1][4]
    assert [s[1] for s in steps] == [s[4]["log_decrease"] for s in steps]
    assert sum(s[1] for s in steps) == pytest.approx(np.log(before["rms_seen"] / after["rms_seen"]))
    assert after["rms_seen"] == pytest.approx(after["rms_true"], rel=0.02)


def test_seen_from_the_motors_the_tool_seems_better_than_it_is(quick, quick_identification):
    """The point of the thesis: the motors do not see what gives way behind them; an IMU does."""
    far = {}
    for reward in ("estimate", "motor"):
        env = gymnasium.make(ID, reward=reward)
        env.reset(seed=0, options=quick | {"pose": "p3", "speed": 0.04})
        *_, info = env.step(ACTION)
        far[reward] = abs(np.log(info["rms_seen"] / info["rms_true"]))
    assert far["estimate"] < min(0.25, 0.5 * far["motor"])
    for _ in range(4):
        *_, info = env.step(ACTION)
    assert info["rms_seen"] < 0.5 * info["rms_true"]


def test_the_observation_knows_nothing_of_the_tool(quick):
    """Two robots whose tools differ and whose motors do not look alike to a policy."""
    rules = Rules()
    now = rules.begin(rules.draw(np.random.default_rng(0), quick))
    worse = replace(now, measured=replace(now.measured, rms=1.0), true=replace(now.true, rms=1.0))
    assert np.array_equal(rules.observe(now), rules.observe(worse))


@pytest.mark.parametrize("motors", list(Motors))
def test_info_has_the_design_in_physical_units(quick, motors):
    env = gymnasium.make(ID, motors=motors.value)
    env.reset(seed=0, options=quick)
    *_, info = env.step(action_of(THESIS, motors))
    assert info["gamma"] == pytest.approx(np.full(6, 0.9))
    assert info["delta"].tolist() == [3.0] * 6
    assert info["cutoff"] == pytest.approx(np.full(6, 10.0))
    assert info["k"] == 1


def test_who_changes_an_info_does_not_change_the_episode(env, quick):
    _, info = env.reset(seed=0, options=quick)
    kept = info["motor_error_two"].copy()
    info["motor_error_two"][:] = 1e-9
    *_, terminated, _, info = env.step(ACTION)
    assert not terminated
    info["motor_error_inf"][:] = 0.0
    assert (kept > 0.0).all()
    assert np.array_equal(env.unwrapped._history[0].two_norm, kept)
    assert (env.unwrapped._history[1].inf_norm > 0.0).all()


@pytest.mark.parametrize(
    "options",
    [
        {"robot": "large"},
        {"robot": "irb1400"},
        {"robot": TWO_LINK, "shape": "slot", "radius": 8e-3},
    ],
)
def test_what_an_info_says_of_the_task_makes_the_episode_again(options):
    env = gymnasium.make(ID, **options)
    observed, info = env.reset(seed=4)
    again, same = env.reset(seed=5, options={name: info[name] for name in OPTIONS})
    assert np.array_equal(observed, again)
    assert same["rms_true"] == info["rms_true"]
    assert info["speed_reached"] <= info["speed"] + 1e-12


def test_a_reset_that_is_refused_leaves_the_env_as_it_was(env, quick):
    env.reset(seed=0)
    with pytest.raises(ValueError, match="speed"):
        env.reset(seed=7, options={"speed": 9})
    assert env.step(ACTION)[4]["k"] == 1
    after_refusal = env.reset()[0]
    env.reset(seed=0)
    assert np.array_equal(after_refusal, env.reset()[0])


def test_an_episode_can_be_sent_to_another_process(env, quick):
    env.reset(seed=0, options=quick)
    sent = pickle.loads(pickle.dumps(env.unwrapped))
    assert np.array_equal(sent.step(ACTION)[0], env.step(ACTION)[0])


def test_seeds_of_numpy_are_seeds_and_another_is_another_trajectory(env, quick):
    own, same, other = (env.reset(seed=n, options=quick)[0] for n in (np.int64(3), 3, 4))
    assert np.array_equal(own, same)
    assert not np.array_equal(own, other)


TRAJECTORY = f"""
import hashlib, sys, gymnasium, numpy as np, armside.sim.tuning
env = gymnasium.make({ID!r}, iterations=2)
bits = hashlib.sha256()
observed, info = env.reset(seed=7)
actions = np.random.default_rng(0).uniform(-0.5, 0.5, (2, 3)).astype(np.float32)
for action in actions:
    bits.update(observed.tobytes() + np.float64(info["rms_true"]).tobytes())
    observed, reward, *_, info = env.step(action)
    bits.update(np.float64(reward).tobytes())
print(bits.hexdigest())
"""


def test_the_same_seed_gives_the_same_bits_in_every_process(capsys):
    exec(TRAJECTORY, {})
    command = [sys.executable, "-c", TRAJECTORY]
    other = subprocess.run(command, capture_output=True, text=True, check=True)
    assert capsys.readouterr().out == other.stdout


def test_evaluation_runs_the_episodes_of_the_env(env):
    _, info = env.reset(seed=3)
    rms = [info["rms_true"]]
    rms += [env.step(ACTION)[4]["rms_true"] for _ in range(2)]
    episode = run_episode(Rules(iterations=2), 3, always(THESIS, Motors.SHARED))
    assert episode.rms_true.tolist() == rms


@pytest.mark.parametrize("action", [[0.0, np.nan, 0.0], [0.0], "abc", [0, 1j, 0]])
def test_a_bad_action_is_one_clear_error_and_leaves_the_episode_as_it_was(env, quick, action):
    env.reset(seed=0, options=quick)
    with pytest.raises(ValueError, match="an action must"):
        env.unwrapped.step(action)
    assert env.step(ACTION)[4]["k"] == 1


@pytest.mark.parametrize(
    ("options", "message"),
    [
        ({"robot": "r2d2"}, "Unknown robot 'r2d2'. Robots: large, irb1400, or a robot file"),
        ({"motors": "all"}, "Unknown motors 'all'. It can be: shared, each"),
        ({"reward": "luck"}, "Unknown reward 'luck'. It can be: tracker, estimate, motor"),
        ({"iterations": 0}, "iterations must be a whole number in 1 .. 10, got 0"),
        ({"iterations": 2.5}, "iterations must be a whole number in 1 .. 10, got 2.5"),
        ({"iterations": "5"}, "iterations must be a whole number in 1 .. 10, got '5'"),
        ({"iterations": True}, "iterations must be a whole number in 1 .. 10, got True"),
        ({"sealed": "no"}, "sealed must be True or False, got 'no'"),
        ({"render_mode": "human"}, "Unknown render_mode 'human'"),
        ({"picture": "oil"}, "Unknown picture 'oil'. It can be: drawing, mujoco"),
        ({"basis": "wavelets"}, "Unknown basis 'wavelets'. It can be: b-splines, harmonics"),
        ({"functions": 1}, "functions must be a whole number in 2 .. 60, got 1"),
        ({"action": "u"}, "Unknown action 'u'. It can be: design, correction"),
        ({"shape": "star"}, "Unknown shape 'star'. It can be: circle, square, slot, hexagon"),
        ({"shape": ("circle", "circle")}, "one or several different ones"),
        ({"shape": ()}, "one or several different ones"),
        ({"radius": 5.0}, "radius must be a number from 0.001 to 0.1 m, got 5.0"),
        ({"radius": (0.02, 0.01)}, "a range from low to high"),
        ({"radius": (0.01, 0.02, 0.03)}, "a number or a range of two"),
    ],
)
def test_options_of_the_env_that_do_not_exist_are_refused(options, message):
    from armside.sim.tuning.env import IlcTuningEnv

    with pytest.raises(ValueError, match=message):
        IlcTuningEnv(**options)


def test_the_test_seeds_are_sealed():
    sealed = gymnasium.make(ID, sealed=True).unwrapped
    refused = ((gymnasium.make(ID).unwrapped, TEST_SEEDS[0]), (sealed, 0), (sealed, None))
    for env, seed in refused:
        with pytest.raises(ValueError, match="sealed"):
            env.reset(seed=seed)
    sealed.reset(seed=TEST_SEEDS[0])


def test_step_and_render_before_reset_say_so():
    env = gymnasium.make(ID, render_mode="rgb_array").unwrapped
    for early in (lambda: env.step(ACTION), env.render):
        with pytest.raises(RuntimeError, match="reset"):
            early()


def test_the_picture_is_drawn_without_gl_and_changes_with_the_run(quick, monkeypatch):
    monkeypatch.setenv("MUJOCO_GL", "disable")
    env = gymnasium.make(ID, render_mode="rgb_array")
    env.reset(seed=0, options=quick)
    before = env.render()
    env.step(ACTION)
    after = env.render()
    assert before.shape == after.shape == (320, 640, 3)
    assert before.dtype == np.uint8
    assert not np.array_equal(before, after)


def test_the_drawing_magnifies_no_more_than_the_circle_bears():
    """A path beyond its own centre would be drawn on the other side."""
    env = gymnasium.make(ID, render_mode="rgb_array")
    env.reset(seed=0)
    history = env.unwrapped._history
    radius = history[0].experiment.cut.curve.smallest_radius
    factor = magnification(history, radius)
    assert factor * history[0].measured.maxdev <= LARGEST_SHOWN * radius
    assert factor in MAGNIFICATIONS
    lost = replace(history[0], measured=replace(history[0].measured, maxdev=np.nan))
    assert magnification([lost], radius) == MAGNIFICATIONS[0]


def test_mujoco_draws_the_robot(quick, graphics):
    env = gymnasium.make(ID, render_mode="rgb_array", picture="mujoco")
    env.reset(seed=0, options=quick)
    drawn = env.render().astype(int)
    assert drawn.shape == (320, 640, 3)
    red, green, blue = np.moveaxis(drawn, -1, 0)
    assert ((red > green + 50) & (green > blue)).sum() > 1000  # the arm is orange


PAGE = (Path(__file__).parents[3] / "docs" / "tuning.md").read_text(encoding="utf-8")


def test_the_page_has_the_numbers_of_version_1():
    ranges, n = RANGES[1], Rules(version=1).observation_space.shape[0]
    low, high = (f"{1e3 * v:g}" for v in ranges.speeds)
    small, large = (f"{1e3 * v:g}" for v in ranges.radius or ())
    light, heavy = (f"{m:g}" for m in ranges.payloads["large"])
    for words in (
        f"{n} with six axes",
        f"speed ({low} to {high} mm/s), payload ({light} to {heavy} kg)",
        f"radius ({small} to {large} mm",
        f"held to update {HORIZON} ",
        *(f"from {v.low:g} to {v.high:g}" for v in VARIABLES),
    ):
        assert words in PAGE, words


def test_the_page_names_everything_that_make_takes():
    table = PAGE.split("`gymnasium.make` takes, all by name:")[1].split("\n\n")[1]
    named = re.findall(r"`(\w+)`", " ".join(row.split("|")[1] for row in table.splitlines()))
    own = set(inspect.signature(tuning.env.IlcTuningEnv).parameters) - {"options"}
    assert set(named) == own | {field.name for field in fields(EnvCfg)}
