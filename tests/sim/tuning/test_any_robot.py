"""The env for robots of files, and for contours beyond a circle of 5 mm."""

import numpy as np
import pytest
from tests.claims._policies import always, run_episode

from armside import assets
from armside.sim.motion.contour import RADII
from armside.sim.robot_file.find import read_cell
from armside.sim.tuning.action import Motors, design_of
from armside.sim.tuning.episode_task import Shapes, candidates, draw, movable, shapes_of
from armside.sim.tuning.rules import Rules

TWO_LINK = assets.LARGE_ROBOT_XML.with_name("two_link.toml")


@pytest.fixture(scope="module")
def two_axes():
    return Rules(robot=TWO_LINK, motors="each", iterations=1)


@pytest.mark.parametrize(
    ("options", "actions", "observed"),
    [
        ({"motors": "shared"}, 3, 50),
        ({"motors": "each"}, 18, 50),
        ({"robot": TWO_LINK, "motors": "each"}, 6, 8 * 2 + 2),
        ({"shape": ("circle", "slot")}, 3, 50 + 1 + 2),
        ({"robot": TWO_LINK, "action": "correction", "functions": 8}, 16, 8 * 2 + 2 + 2 * 2 * 8),
    ],
)
def test_the_spaces_follow_the_axes_of_the_robot(options, actions, observed):
    rules = Rules(**options)
    assert rules.observation_space.shape == (observed,)
    space = rules.action_space
    assert (space.shape, space.dtype) == ((actions,), np.float32)
    assert (space.low == -1).all()
    assert (space.high == 1).all()


def test_an_arm_in_a_plane_is_moved_within_it_and_every_draw_can_be_cut(two_axes):
    for seed in range(4):
        drawn = two_axes.draw(np.random.default_rng(seed))
        task, made = two_axes.prepared(drawn)
        assert task.pose.position[2] == pytest.approx(1.0, abs=1e-12)
        assert task.near in two_axes.cell.poses.values()
        assert np.isfinite(made.loaded.reference).all()


def test_a_drawn_place_out_of_reach_comes_closer_to_the_named_pose_until_it_is_that():
    cell = read_cell(TWO_LINK)
    near = cell.poses["p2"]
    task = draw(cell, np.random.default_rng(0))
    places = [np.array(p.position) for p in candidates(cell, near, task.pose)]
    away = [np.linalg.norm(place - near.position) for place in places]
    assert away == sorted(away, reverse=True)
    assert away[-1] == 0.0
    assert movable(cell, near) == pytest.approx(np.diag([1.0, 1.0, 0.0]), abs=1e-9)


def test_an_episode_learns():
    design = design_of(np.array([0.2, -0.7, 0.3]), Motors.SHARED)
    episode = run_episode(Rules(robot=TWO_LINK, iterations=1), 4, always(design, Motors.SHARED))
    assert episode.ratio < 1.0


@pytest.mark.parametrize("shape", RADII)
def test_each_shape_is_cut_with_its_own_size_unless_a_radius_is_given(shape):
    drawn = [draw("large", np.random.default_rng(0), {}, shapes_of(shape, r)) for r in (None, 0.02)]
    assert [task.shape for task in drawn] == [shape] * 2
    assert [task.radius for task in drawn] == [RADII[shape], 0.02]


def test_choosing_contours_leaves_every_other_draw_as_it_was():
    plain, chosen = (
        draw("large", np.random.default_rng(3), {}, shapes)
        for shapes in (Shapes(), shapes_of(("slot", "hexagon"), (0.004, 0.02)))
    )
    names = ("pose", "speed", "payload", "individual", "seed")
    assert [getattr(plain, n) for n in names] == [getattr(chosen, n) for n in names]
    assert chosen.shape in ("slot", "hexagon")
    assert 0.004 <= chosen.radius <= 0.02


HERE = TWO_LINK.parent
ARMS = (*sorted(HERE.glob("*_like.toml")), HERE / "scara.toml")


@pytest.mark.parametrize("file", ARMS, ids=lambda file: file.stem)
def test_an_episode_of_each_shipped_arm_lies_in_its_spaces(file):
    rules = Rules(robot=file, motors="each", shape=("circle", "hexagon"), iterations=1)
    n = rules.cell.robot.n_joints
    assert rules.action_space.shape == (3 * n,)
    before = rules.begin(rules.draw(np.random.default_rng(1)))
    after = rules.advance(before, rules.decision(np.full(3 * n, -0.5)))
    assert rules.observe(before) in rules.observation_space
    assert rules.observe(after) in rules.observation_space
    assert not after.diverged
