"""What the model says of a design, and version 1, whose reward looks past the last update."""

from dataclasses import replace

import gymnasium
import numpy as np
import pytest

from armside.ilc.analysis import heuristic_criterion
from armside.sim.laser.design import THESIS, Design
from armside.sim.laser.learning_task import SERVO
from armside.sim.tuning import outlook
from armside.sim.tuning import rules as tuning_rules
from armside.sim.tuning.action import Motors, action_of, design_of
from armside.sim.tuning.observation import HEAVIEST
from armside.sim.tuning.rules import WORST_REWARD, Rules

GROWING = Design(gamma=(0.298,), delta=(19,), cutoff=(13.0,))
"""A design that `armside tune` returned: the tool is best after five updates, and the motors
diverge."""
TOO_FAST = replace(THESIS, gamma=(1.5,), delta=(25,), cutoff=(30.0,))


def episode(version, design, options, **more):
    """Rewards and infos of an episode with one design."""
    env = gymnasium.make(f"armside/IlcTuning-v{version}", **more)
    motors = Motors(more.get("motors", "shared"))
    env.reset(seed=0, options=options)
    steps = [env.step(action_of(design, motors)) for _ in range(env.unwrapped.rules.iterations)]  # type: ignore[attr-defined]
    return [s[1] for s in steps], [s[4] for s in steps]


def test_the_criterion_is_the_one_that_learn_prints():
    rng = np.random.default_rng(0)
    for action in rng.uniform(-1.0, 1.0, (20, 3)):
        design = design_of(action, Motors.SHARED)
        law = design.law
        exact = heuristic_criterion(SERVO, law.gamma, law.delta, law.Q).contraction
        assert outlook.contraction(SERVO, design) == pytest.approx(exact, rel=1e-3)  # of its grid


@pytest.mark.parametrize("version", [0, 1])
def test_info_has_the_criterion_of_the_worst_motor(version, quick):
    values = (0.9,) * 5 + (1.5,)
    design = Design(gamma=values, delta=(3,) * 5 + (25,), cutoff=(10.0,) * 5 + (30.0,))
    _, infos = episode(version, design, quick, motors="each", iterations=1)
    assert infos[0]["criterion"] == pytest.approx(outlook.contraction(SERVO, TOO_FAST))
    assert infos[0]["criterion"] > 1.0


def test_motors_end_where_the_model_says(quick):
    """From one update on; what is left is the model's fault, and friction."""
    rules = Rules(version=1)
    before = rules.begin(rules.draw(np.random.default_rng(0), quick))
    now = rules.advance(before, THESIS)
    predicted = rules.step(before, now, THESIS)[4]["motor_error_predicted"]
    for _ in range(19):
        now = rules.advance(now, THESIS)
    assert now.two_norm == pytest.approx(predicted, rel=0.35)
    assert (predicted < 0.05 * now.first_norm).all()


def test_a_design_that_grows_wins_in_version_0_and_never_in_version_1(quick):
    quick = quick | {"radius": 0.005}
    before, _ = episode(0, GROWING, quick)
    now, infos = episode(1, GROWING, quick)
    assert sum(before) > 0.5
    assert infos[-1]["criterion"] > 1.0
    assert now == [*before[:-1], WORST_REWARD]  # the same runs, and the same noise
    assert sum(now) < 0.0


def test_the_last_reward_is_that_of_the_worse_of_two_runs(quick, monkeypatch):
    rules = Rules(version=1, iterations=1)
    before = rules.begin(rules.draw(np.random.default_rng(0), quick))
    after = rules.advance(before, THESIS)
    now = after.measured.rms
    for later in (0.5 * now, 2.0 * now):
        worse = replace(after, measured=replace(after.measured, rms=later))
        monkeypatch.setattr(Rules, "_at_horizon", lambda *_, worse=worse: worse)
        _, reward, *_, info = rules.step(before, after, THESIS)
        assert info["rms_held"] == later
        assert info["rms_held_true"] == after.true.rms != later
        assert reward == pytest.approx(np.log(before.measured.rms / max(now, later)))


def test_a_design_is_held_by_the_model_nearly_as_by_the_robot(quick):
    """A run of the robot ends the prediction: the tool's RMS, not a model of it."""
    rules = Rules(version=1)
    now = rules.begin(rules.draw(np.random.default_rng(0), quick))
    for _ in range(5):
        now = rules.advance(now, THESIS)
    held, again = (rules.held(now, THESIS) for _ in range(2))
    assert held.measured.rms == again.measured.rms  # the noise of the episode is not used up
    for _ in range(15):
        now = rules.advance(now, THESIS)
    assert held.k == now.k
    assert held.true.rms == pytest.approx(now.true.rms, rel=0.03)


def test_looking_past_the_last_update_at_most_doubles_the_runs_of_a_step(quick, monkeypatch):
    runs, run = [], tuning_rules.run
    monkeypatch.setattr(tuning_rules, "run", lambda *given: runs.append(given) or run(*given))
    episode(1, THESIS, quick, iterations=3)
    assert [k for *_, k in runs] == [1, 2, 3, 20]


def test_version_1_observes_payload_and_radius(quick):
    rules = Rules(version=1)
    task = rules.draw(np.random.default_rng(0), quick)
    names = [f.name for f in rules.layout.features for _ in range(f.size)]
    seen = rules.observe(rules.begin(task))
    assert seen[names.index("payload")] == pytest.approx(2.0 * task.payload / HEAVIEST - 1.0)
    assert 0.002 < task.radius < 0.012
    assert -1.0 < seen[names.index("radius of the contour")] < 1.0
    assert "payload" not in [f.name for f in Rules().layout.features]


def test_a_correction_has_no_criterion_and_is_not_held(quick):
    env = gymnasium.make("armside/IlcTuning-v1", action="correction", iterations=1)
    env.reset(seed=0, options=quick)
    *_, info = env.step(np.zeros(env.action_space.shape, np.float32))
    assert not {"criterion", "motor_error_predicted", "rms_held", "rms_held_true"} & set(info)


def test_another_robot_is_modelled_from_two_updates_of_its_nominal_arm():
    T_u = Rules(robot="irb1400").T_u
    assert outlook.contraction(T_u, THESIS) < 1.0 < outlook.contraction(T_u, TOO_FAST)
    assert T_u.static_gain == pytest.approx(1.0, abs=0.25)
