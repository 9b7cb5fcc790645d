"""Options of the laws for the tool's path: what they build, and their documented defaults."""

from dataclasses import replace
from types import SimpleNamespace

import numpy as np
import pytest

from armside.ilc.laws import Heuristic
from armside.ilc.laws.model_based import RegularisedInverse, ScheduledInverse
from armside.ilc.laws.norm_optimal import RecordOptimal
from armside.ilc.laws.wrappers import Guarded, JointSpace
from armside.sim.estimation.arm_plant import PathPlants, fading
from armside.sim.estimation.tool_law import CUTOFF, ToolLaw, ToolLawKind, pass_band

SIZE = np.linspace(0.5, 1.0, 6)
PLANT = SimpleNamespace(
    input_size=SIZE,
    response=lambda omega: np.tile(np.eye(6, dtype=complex), (len(omega), 1, 1)),
    arm=SimpleNamespace(tool_jacobian=np.diag(np.arange(1.0, 7.0)), axes=np.arange(6)),
)


def law_of(law, turn_rate=1.27, *, rotations=True, lowest_mode=0.0):
    """A law on one plant; of the inverse, that of its place."""
    plants = PathPlants(plants=(PLANT,), weights=np.ones((9, 1)), lowest_mode=lowest_mode)
    made = law.along(plants, turn_rate, rotations=rotations)
    return made.laws[0] if isinstance(made, ScheduledInverse) else made


def test_errors_are_learned_from_under_a_guard_unless_said_otherwise():
    law = law_of(ToolLaw())
    assert isinstance(law, Guarded)
    assert isinstance(law.law, ScheduledInverse)
    assert isinstance(law_of(ToolLaw(guarded=False)), RegularisedInverse)
    assert (law.tolerance, law.back_off, law.patience) == (1.2, 0.5, 3)


def test_an_orientation_error_of_a_milliradian_counts_as_a_tenth_of_a_millimetre():
    law = law_of(ToolLaw())
    assert law.weight == (1.0, 1.0, 1.0, 0.1, 0.1, 0.1)
    assert law.law.laws[0].output_weight == law.weight
    seen = law_of(ToolLaw(), rotations=False)
    assert seen.weight == (1.0, 1.0, 1.0, 0.0, 0.0, 0.0)


def test_the_design_variables_reach_the_law():
    law = law_of(ToolLaw(gamma=0.7, cutoff=12.0, guarded=False))
    assert (law.gamma, law.cutoff, law.limit) == (0.7, 12.0, 0.02)
    assert law.input_size == pytest.approx(SIZE)
    default = ToolLaw(guarded=False)
    assert (default.gamma, default.delta) == (0.9, 3)
    assert law_of(default).cutoff == pass_band(1.27)


def test_a_stiff_arm_is_learned_up_to_its_lowest_mode():
    law = ToolLaw(guarded=False)
    assert law_of(law, lowest_mode=14.0).cutoff == 14.0
    assert law_of(law, lowest_mode=45.0).cutoff == 20.0
    assert law_of(law, 3.2, lowest_mode=12.0).cutoff == pass_band(3.2)
    assert law_of(replace(law, cutoff=10.0), lowest_mode=14.0).cutoff == 10.0
    assert law_of(law, lowest_mode=6.0).cutoff == pass_band(1.27) == CUTOFF


def test_a_hard_motion_is_learned_up_to_25_hz_on_any_arm():
    assert [pass_band(1.27, 6.0, excitation) for excitation in (1.9, 2.0)] == [CUTOFF, 25.0]
    places = PathPlants(plants=(PLANT,), weights=np.ones((9, 1)), lowest_mode=6.0, excitation=2.0)
    assert ToolLaw(guarded=False).along(places, 1.27).laws[0].cutoff == 25.0
    assert ToolLaw(guarded=False, cutoff=9.0).along(places, 1.27).laws[0].cutoff == 9.0


def test_each_kind_is_its_law():
    optimal = law_of(ToolLaw(kind=ToolLawKind.NORM_OPTIMAL, guarded=False))
    assert isinstance(optimal, RecordOptimal)
    heuristic = ToolLaw(kind=ToolLawKind.HEURISTIC, guarded=False, gamma=0.5, delta=4)
    law = law_of(heuristic, rotations=False)
    assert isinstance(law, JointSpace)
    assert isinstance(law.law, Heuristic)
    assert (law.law.gamma, law.law.delta) == (0.5, 4)
    # without orientations only three rows of the Jacobian are inverted
    expected = np.linalg.pinv(np.diag([1.0, 2.0, 3.0, 0.0, 0.0, 0.0]))
    assert law.inverse == pytest.approx(expected)


@pytest.mark.parametrize(
    ("turn_rate", "cutoff"), [(0.5, 13.0), (3.25, 13.0), (3.3, 13.2), (3.75, 15.0), (10.0, 15.0)]
)
def test_the_pass_band_is_four_turns_a_second_between_13_and_15_hz(turn_rate, cutoff):
    assert pass_band(turn_rate) == pytest.approx(cutoff)


def test_weights_fade_between_centres_and_have_the_sum_one():
    time = np.arange(0.0, 2.0, 0.004)
    weights = fading(np.array([0.0, 1.0, 1.5]), time)
    assert weights.sum(axis=1) == pytest.approx(np.ones(len(time)))
    assert weights[125] == pytest.approx([0.5, 0.5, 0.0])
    assert weights[-1] == pytest.approx([0.0, 0.0, 1.0])


def test_along_a_path_each_place_has_its_inverse_and_other_kinds_the_middle_one():
    weights = fading(np.array([0.0, 1.0]), np.arange(0.0, 1.0, 0.004))
    places = PathPlants(plants=(PLANT, PLANT), weights=weights, lowest_mode=14.0)
    law = ToolLaw(gamma=0.7).along(places, 1.27, rotations=False)
    assert isinstance(law, Guarded)
    assert law.weight == (1.0, 1.0, 1.0, 0.0, 0.0, 0.0)
    assert isinstance(law.law, ScheduledInverse)
    assert [(each.gamma, each.cutoff) for each in law.law.laws] == [(0.7, 14.0)] * 2
    assert np.array_equal(law.law.weights, weights)
    optimal = ToolLaw(kind=ToolLawKind.NORM_OPTIMAL, guarded=False).along(places, 1.27)
    assert isinstance(optimal, RecordOptimal)
    assert optimal.G is places.middle
