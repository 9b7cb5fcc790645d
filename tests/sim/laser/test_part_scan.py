"""One update by the scan of a part, as a person with a real robot makes it."""

from pathlib import Path

import numpy as np
import pytest

from armside.ilc.laws.wrappers import Around
from armside.ilc.learning import LoopState
from armside.ilc.workbench.compare import RunState
from armside.sim.controller.programs import PlannedProgram, ProgramPlant
from armside.sim.controller.programs.target_learning import contour_measure
from armside.sim.laser import prepare
from armside.sim.laser.loop import iterate, loop_law
from armside.sim.laser.part_cut import PartCut
from armside.sim.laser.part_scan import along_cuts, pieces, sheet_drawing, updated
from armside.sim.laser.scan_measure import ScannedPart, VirtualScans, places
from armside.sim.part.part import read_part
from armside.sim.part.plan import Cutting

DRAWING = """<svg xmlns="http://www.w3.org/2000/svg" width="40mm" height="30mm" viewBox="0 0 40 30">
<g fill="none" stroke="black"><path d="M8 5h24v20h-24z"/><circle cx="14" cy="11" r="4"/>
<path d="M19 12h10v9h-10z"/></g></svg>
"""


@pytest.fixture(scope="module")
def experiment(tmp_path_factory):
    pytest.importorskip("svgelements")
    file = Path(tmp_path_factory.mktemp("part")) / "plate.svg"
    file.write_text(DRAWING, encoding="utf-8")
    part = PartCut(part=read_part(file), cutting=Cutting(speed=0.06, corner=2e-3), pose="p2")
    return prepare(part, seed=4)


@pytest.fixture(scope="module")
def first(experiment):
    return experiment.plant.run(np.zeros_like(experiment.loaded.reference))


def begun(experiment, columns):
    u = np.zeros((len(experiment.loaded.reference), columns))
    return RunState(loop=LoopState(0, u, u, None, np.zeros(1)))


def test_contours_of_the_drawing_run_counter_clockwise_and_lie_where_the_part_has_them(experiment):
    drawn, cuts = sheet_drawing(experiment), experiment.motion.cuts
    middle = np.array(experiment.motion.middle)
    assert [one.name for one in places(experiment)] == list(drawn)
    (outline,) = pieces(experiment)
    for cut, (name, curve) in zip(cuts, drawn.items(), strict=True):
        assert curve.chain.area > 0.0
        s = np.linspace(0.0, cut.turn.length, 60)
        points = cut.turn.point(s) - middle
        away = points - curve.point(curve.nearest(points))
        assert np.linalg.norm(away, axis=1).max() < 1e-6
        assert (name == outline) == (cut.kind.value == "outline")


def test_deviations_stay_where_they_are_along_a_contour_that_is_cut_the_other_way(
    experiment, first
):
    """By their places in the plane; and twice turned it is the scan again."""
    as_cut = VirtualScans()(experiment, first)
    drawn, curves = along_cuts(as_cut, experiment), sheet_drawing(experiment)
    for one in places(experiment):
        a, b = as_cut.contours[one.name], drawn.contours[one.name]
        at = one.curve.point(a.arc_length) + one.middle
        order = np.argsort(curves[one.name].nearest(at))
        foot = curves[one.name].point(b.arc_length)
        np.testing.assert_allclose(np.sort(b.arc_length), b.arc_length)
        np.testing.assert_allclose(foot, at[order], atol=2e-6)
        np.testing.assert_allclose(np.abs(b.deviation), np.abs(a.deviation[order]))
        again = along_cuts(drawn, experiment).contours[one.name]
        np.testing.assert_allclose(again.deviation, a.deviation)
        np.testing.assert_allclose(again.arc_length, a.arc_length, atol=1e-12)


@pytest.mark.parametrize("as_program", [False, True])
def test_an_update_by_hand_is_that_of_the_loop(experiment, as_program):
    """But for the noise of the virtual robot's motors, which stand for those of the real one."""
    if as_program:
        program = PlannedProgram.of(experiment, 2e-3)
        plant = ProgramPlant.of(program)
        inputs = 3

        def set_up_of(measure):
            return contour_measure(program, measure)
    else:
        plant, inputs = experiment.plant, 6

        def set_up_of(measure):
            return measure.prepare(experiment)

    measure = ScannedPart(stiffness_error=0.0)
    steps = iterate(experiment, set_up_of(measure), 1, plant=plant, inputs=inputs)
    before = next(steps)
    scan = along_cuts(VirtualScans()(experiment, before.run), experiment)
    found = updated(experiment, set_up_of, plant, (scan, scan), begun(experiment, inputs))
    after = next(steps)
    cut, motion = experiment.cut, experiment.motion
    true = cut.errors(motion, *plant.run(found.state.loop.correction).true)
    assert cut.whole(motion, true).rms == pytest.approx(after.tool_true.rms, rel=0.25)
    assert found.state.loop.k == 1
    assert after.tool_true.rms < 0.35 * before.tool_true.rms
    if not as_program:
        return
    again = updated(experiment, set_up_of, plant, (scan, scan), found.state)
    assert again.state.loop.k == 2
    assert again.state.loop.first_size == found.state.loop.first_size


def test_a_law_on_a_model_is_given_the_whole_correction_guarded_or_not(experiment, first):
    """Around a first correction, as a twin's; another law learns the change alone."""
    start = np.zeros((len(experiment.loaded.reference), 3))
    program = PlannedProgram.of(experiment, 2e-3)
    run = ProgramPlant.of(program).run(start)
    output = contour_measure(program, ScannedPart(identified=False))(run)
    assert loop_law(output.law, output, experiment, start) is output.law
    by_samples = ScannedPart(identified=False).prepare(experiment)(first)
    assert isinstance(loop_law(by_samples.law, by_samples, experiment, start), Around)
