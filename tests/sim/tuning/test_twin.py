"""The env with a twin: a first run that is corrected, and learning around its correction."""

import gymnasium
import numpy as np
import pytest
from gymnasium.utils.env_checker import check_env

from armside.sim.laser.design import Design
from armside.sim.robot.individual import Individual
from armside.sim.tuning.action import Motors, action_of
from armside.sim.tuning.rules import Rules
from armside.sim.tuning.vector_env import IlcTuningVectorEnv
from armside.sim.twin.identification import parameters_of
from armside.sim.twin.twin import Twin, design_of, robot_digest

ID = "armside/IlcTuning-v0"
GENTLE = action_of(Design(gamma=(0.1,), delta=(3,), cutoff=(1.0,)), Motors.SHARED)
"""A law whose Q takes nearly all of a correction that it is not around."""
SURE = 0.01
"""Standard deviation of a well commissioned twin over that of the prior."""


@pytest.fixture(scope="module")
def folder(tmp_path_factory):
    """A twin of the design: what commissioning would find of a robot without any spread."""
    design = design_of("large", None)
    parameters = parameters_of(design)
    path = tmp_path_factory.mktemp("twin")
    Twin(
        robot="large",
        digest=robot_digest("large"),
        payload=None,
        sensor="tracker",
        theta=parameters.mean,
        covariance=np.diag((SURE * parameters.standard_deviation) ** 2),
        held_out=np.array([10e-6]),
        torque_residual=np.full(6, 1e-3),
        names=("cut-1",),
    ).save(path)
    return path


@pytest.fixture(scope="module")
def env(folder):
    return gymnasium.make(ID, individual=Individual(), twin=folder, iterations=2)


def test_the_first_run_of_an_episode_is_corrected(env, quick):
    _, plain = gymnasium.make(ID, individual=Individual()).reset(seed=0, options=quick)
    _, info = env.reset(seed=0, options=quick)
    assert info["trusted"]
    assert info["rms_true"] < 0.3 * plain["rms_true"]
    assert "trusted" not in plain


def test_learning_goes_around_the_correction_of_the_twin(env, quick):
    _, before = env.reset(seed=0, options=quick)
    *_, after = env.step(GENTLE)
    assert after["rms_true"] < 1.2 * before["rms_true"]


def test_a_twin_that_is_not_trusted_leaves_an_episode_as_it_is_without(folder, quick, monkeypatch):
    monkeypatch.setattr("armside.sim.twin.prediction.LARGEST_FRACTION", 0.0)
    options = quick | {"payload": 41.0}  # learned in no other test
    with_twin, without = (
        gymnasium.make(ID, individual=Individual(), **more) for more in ({"twin": folder}, {})
    )
    for env in (with_twin, without):
        env.reset(seed=3, options=options)
    ours, plain = with_twin.step(GENTLE), without.step(GENTLE)
    assert not ours[4]["trusted"]
    assert np.array_equal(ours[0], plain[0])
    assert ours[1:4] == plain[1:4]


def test_the_vector_env_is_the_single_one_row_by_row(env, folder, quick):
    cells = IlcTuningVectorEnv(2, individual=Individual(), twin=folder, iterations=2)
    observations, infos = cells.reset(seed=0, options=quick)
    stepped = cells.step(np.tile(GENTLE, (2, 1)))
    for i in range(2):
        observation, info = env.reset(seed=i, options=quick)
        assert np.array_equal(observations[i], observation)
        assert infos["rms_predicted"][i] == info["rms_predicted"]
        assert np.array_equal(stepped[0][i], env.step(GENTLE)[0])
    cells.close()


def test_the_env_checker_has_nothing_to_say(env, monkeypatch, quick):
    """On one task: each other one is learned in the twin first."""
    draw = Rules.draw
    monkeypatch.setattr(Rules, "draw", lambda rules, rng, _=None: draw(rules, rng, quick))
    check_env(env.unwrapped, skip_render_check=True)


@pytest.mark.parametrize(
    ("options", "said"),
    [
        ({}, "give its individual too"),
        ({"individual": 7, "twin": "nowhere"}, "nowhere holds no twin"),
        ({"individual": 7, "robot": "irb1400"}, "the twin is of the robot large"),
    ],
)
def test_a_twin_that_does_not_fit_is_refused(folder, options, said):
    with pytest.raises(ValueError, match=said):
        Rules(**{"twin": folder} | options)
