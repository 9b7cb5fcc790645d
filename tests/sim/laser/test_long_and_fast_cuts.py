"""Cuts at the edges of what an estimate serves: fast ones are learned, long ones are said."""

import pytest
from tests.claims._estimates import path_error, rigid_path

from armside.scripts.cutting.cut_run import fail_unless_done
from armside.scripts.shell.errors import RunFailed
from armside.sim.estimation.commissioning import Commissioning
from armside.sim.estimation.tool_law import ToolLaw
from armside.sim.instruments.imu import ImuCfg
from armside.sim.laser import Cut, ToolPath, learn, prepare
from armside.sim.laser.loop import first_run
from armside.sim.laser.results import results
from armside.sim.motion.contour import slot
from armside.sim.motion.timing import PathLimits
from armside.sim.notes import GROWTH, Cause

pytestmark = pytest.mark.usefixtures("quick_identification")


def test_a_sound_imu_is_not_refused_on_a_fast_cut():
    """149 mm/s and 8 m/s^2: the search once turned the IMU for what its springs left."""
    cut = Cut(speed=0.149, limits=PathLimits(acceleration=8.0), imu=ImuCfg())
    experiment, measure = prepare(cut), ToolPath()
    run = first_run(experiment)
    output = measure.commissioned(experiment, measure.assumed(experiment), run)
    assert output.known.fault is None
    assert path_error(output(run), run) < 0.3 * path_error(rigid_path(run), run)


def test_an_outline_on_which_the_estimate_misleads_is_never_done_in_silence():
    """Springs that were not identified, and a law that corrects too much on them."""
    cut = Cut(contour=slot(0.3, 0.08), speed=0.08, imu=ImuCfg())
    misled = ToolPath(
        law=ToolLaw(gamma=1.9, guarded=False), commissioning=Commissioning(identified=False)
    )
    iterations = list(learn(cut, measure=misled, iterations=1))
    first, last = iterations[0].tool_true.rms, iterations[-1].tool_true.rms
    assert last > GROWTH * first  # a cut on which the tool improves shows nothing here
    found = results(prepare(cut), iterations, of_tool=True)
    assert found["status"] == "worse"
    with pytest.raises(RunFailed, match="learning made the tool worse than before"):
        fail_unless_done(found)
    (note,) = [note for note in found["notes"] if note.cause is Cause.TOOL]
    measured = [1e6 * iteration.tool.rms for iteration in (iterations[0], iterations[-1])]
    assert note.text == "learning made the tool worse: RMS {:.4g} to {:.4g} um".format(*measured)
    assert measured == pytest.approx([1e6 * first, 1e6 * last], abs=2.0)  # noise of the tracker
