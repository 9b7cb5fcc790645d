"""What an episode is about: drawn, or given."""

import numpy as np
import pytest

from armside.sim.cell import CELLS, LARGE_ROBOT_POSES
from armside.sim.laser import Cut
from armside.sim.robot.individual import Individual, with_payload
from armside.sim.robot.model import load_model
from armside.sim.robot.spread import Drawn
from armside.sim.robot.statics import Statics
from armside.sim.tuning import episode_task as task
from armside.sim.tuning.episode_task import PAYLOADS, POSE_SPREAD, RANGES, SPEEDS, Shapes, draw
from armside.sim.tuning.rules import Rules


@pytest.fixture(scope="module")
def nominal():
    return load_model(CELLS["large"].xml)


def _drawn(robot="large", n=200, **options):
    return [draw(robot, np.random.default_rng(seed), options) for seed in range(n)]


def test_draws_fill_the_documented_ranges_and_no_more():
    drawn = _drawn()
    for values, (low, high) in (
        (np.array([d.speed for d in drawn]), SPEEDS),
        (np.array([d.payload for d in drawn]), PAYLOADS["large"]),
    ):
        assert low <= values.min() < low + 0.05 * (high - low)
        assert high - 0.05 * (high - low) < values.max() <= high
    places = np.array([p.position for p in LARGE_ROBOT_POSES.values()])
    away = np.array([np.abs(places - d.pose.position).max(axis=1).min() for d in drawn])
    assert 0.9 * POSE_SPREAD < away.max() <= POSE_SPREAD
    assert len({d.individual for d in drawn}) == len(drawn)


def test_version_1_draws_wider_and_evenly_in_turns_per_second():
    shapes, ranges = Shapes(("circle",), RANGES[1].radius, True), RANGES[1]
    rngs = (np.random.default_rng(seed) for seed in range(400))
    drawn = [draw("large", rng, {}, shapes, ranges) for rng in rngs]
    for values, (low, high) in (
        (np.array([d.speed for d in drawn]), (0.02, 0.1)),
        (np.array([d.radius for d in drawn]), (0.002, 0.012)),
    ):
        assert low <= values.min()
        assert values.max() <= high
        # Half of the draws lie below the geometric mean: three deviations of 400 are 0.075.
        assert np.mean(values < np.sqrt(low * high)) == pytest.approx(0.5, abs=0.075)
    away = [np.abs(np.subtract(d.pose.position, d.near.position)).max() for d in drawn if d.near]
    assert len(away) == len(drawn)
    assert 0.22 < max(away) <= 0.25


def test_a_pose_of_version_1_out_of_reach_comes_closer_and_a_given_one_does_not():
    rules = Rules(version=1, robot="irb1400")
    far = [rules.draw(np.random.default_rng(seed)) for seed in range(8)]
    made = [rules.prepared(task)[0] for task in far]  # raises out of reach
    assert any(task.pose != one.pose for task, one in zip(far, made, strict=True))
    assert rules.draw(np.random.default_rng(0), {"pose": "p1"}).near is None


def test_what_is_given_is_taken_and_the_rest_stays_as_drawn():
    free, fixed = _drawn(n=5), _drawn(n=5, speed=0.04, pose="p3")
    for one, other in zip(free, fixed, strict=True):
        assert other.speed == 0.04
        assert other.pose == LARGE_ROBOT_POSES["p3"]
        assert (other.payload, other.individual) == (one.payload, one.individual)


@pytest.mark.parametrize("robot", ["large", "irb1400"])
def test_every_draw_is_within_reach(robot):
    nominal = load_model(CELLS[robot].xml)
    for drawn in _drawn(robot, n=12):
        model = nominal if drawn.payload is None else with_payload(nominal, drawn.payload)
        cut = Cut(robot=robot, pose=drawn.pose, speed=drawn.speed)
        cut.planned(Statics(model))  # raises out of reach


def test_the_controller_is_told_the_payload_and_the_individual_differs_from_what_it_knows(nominal):
    light, heavy = (
        task.experiment("large", nominal, draw("large", np.random.default_rng(1), given))
        for given in ({"payload": 20.0, "pose": "p1"}, {"payload": 80.0, "pose": "p1"})
    )
    mass = [e.loaded.model.mj.body("tool").mass[0] for e in (light, heavy)]
    assert mass == pytest.approx([20.0, 80.0])
    assert not np.array_equal(light.loaded.reference, heavy.loaded.reference)
    springs = [e.loaded.model.mj.jnt_stiffness for e in (light, heavy)]
    assert np.array_equal(*springs)  # one individual
    assert not np.allclose(springs[0], nominal.mj.jnt_stiffness, rtol=0.01)


@pytest.mark.parametrize(
    ("options", "message"),
    [
        ({"sped": 0.04}, "Unknown option 'sped' of reset. Options: pose, speed, payload, indiv"),
        ({"speed": -1.0}, "speed must be a number from 0.001 to 0.1 m/s, got -1.0"),
        ({"speed": 40}, "speed must be a number from 0.001 to 0.1 m/s, got 40"),
        ({"speed": True}, "speed must be"),
        ({"speed": np.nan}, "speed must be"),
        ({"payload": "heavy"}, "payload must be a number >= 0 kg, got 'heavy'"),
        ({"pose": "p9"}, "Unknown pose 'p9'"),
        ({"pose": 3}, "a name or a ToolPose"),
        ([1], "options of reset must be a dict, got"),
        ({"speed": 0.04 + 0j}, "speed must be"),
    ],
)
def test_options_that_do_not_exist_or_make_no_sense_are_refused(options, message):
    with pytest.raises(ValueError, match=message):
        draw("large", np.random.default_rng(0), options)


def test_a_load_that_the_drives_cannot_hold_is_refused(nominal):
    heavy = draw("large", np.random.default_rng(1), {"payload": 500.0, "pose": "p1"})
    with pytest.raises(ValueError, match=r"cannot carry its load: at rest axis \d would have to"):
        task.experiment("large", nominal, heavy)


def test_an_individual_of_the_line_leaves_every_other_draw_and_the_noise_to_the_seed(nominal):
    (free,), (one,), (same,) = (
        _drawn(n=1, **given) for given in ({}, {"individual": Drawn(3)}, {"individual": 17})
    )
    assert (one.pose, one.speed, one.payload) == (free.pose, free.speed, free.payload)
    assert (free.seed, one.seed, same.seed) == (free.individual, free.individual, 17)
    made = task.experiment("large", nominal, one)
    assert made.seed == one.seed
    assert np.array_equal(made.individual.mass, Drawn(3).of(nominal).mass)


@pytest.mark.parametrize("individual", [-1, 1.5, "p1", True])
def test_what_is_no_individual_is_refused(individual):
    with pytest.raises(ValueError, match="individual must be a whole number >= 0, got"):
        _drawn(n=1, individual=individual)
    with pytest.raises(ValueError, match="individual must be a whole number >= 0, got"):
        Rules(individual=individual)


def test_an_individual_that_does_not_fit_the_robot_is_refused_by_the_env():
    worn = Individual(lost_motion=np.full(6, 2.0))
    with pytest.raises(ValueError, match="lost_motion does not apply to a robot without"):
        Rules(robot="irb1400", individual=worn)


def test_the_robot_of_an_env_is_that_of_its_episodes_unless_reset_gives_another():
    rules = Rules(individual=Drawn(3))
    rng = np.random.default_rng
    assert rules.draw(rng(0)).individual == Drawn(3)
    assert rules.draw(rng(0), {"speed": 0.05}).individual == Drawn(3)
    assert rules.draw(rng(0), {"individual": 4}).individual == 4
