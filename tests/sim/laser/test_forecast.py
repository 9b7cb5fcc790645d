"""What is said before the first run: intervals of an ensemble, and what they are blind to."""

from dataclasses import replace

import numpy as np
import pytest
from scipy.stats import norm

from armside.sim.estimation.tool_law import OF_HARD, ToolLaw
from armside.sim.instruments.imu import ImuCfg
from armside.sim.laser import forecast as ahead
from armside.sim.laser.experiment import prepare
from armside.sim.laser.forecast import CALIBRATION, Calibration, Member, forecast, summarised
from armside.sim.laser.specification import Cut
from armside.sim.laser.tool_measure import Source, ToolPath
from armside.sim.motion.contour import square
from armside.sim.motion.timing import PathLimits
from armside.sim.robot.spread import Drawn

HARD = Cut(
    pose="p2",
    contour=square(0.100, 0.015),
    speed=1.0,
    limits=PathLimits(acceleration=12.5),
)


def ensemble(motor, unseen=0.0):
    """Robots of 100 um at k = 0 that end at these shares by motors, and at 0.1 by a tracker."""
    one, two = np.full(2, 1e-4), np.full(2, 1e-5)
    return [Member(1e-4, share * one, two, unseen * one, 3e-5, 1e-6) for share in motor]


@pytest.fixture
def plain(monkeypatch):
    """No calibration: the ensemble itself."""
    monkeypatch.setattr(
        ahead, "CALIBRATION", dict.fromkeys(CALIBRATION, Calibration(1.0, 1.0, 1e-6))
    )


def test_the_interval_is_that_of_a_normal_logarithm(plain):
    logs = np.array([-0.3, 0.1, 0.2, 0.8])
    found = summarised(ensemble(np.exp(logs))).of("motor", 5)
    mean, width = 0.2, np.std(logs, ddof=1)
    assert found.median == pytest.approx(np.exp(mean))
    assert (found.low, found.high) == pytest.approx(np.exp(norm.interval(0.9, mean, width)))
    assert found.worse == pytest.approx(norm.cdf(mean / width))


def test_an_estimate_leaves_what_a_tracker_leaves_and_what_it_does_not_see(plain):
    found = summarised(ensemble([1.0, 1.0, 1.0], unseen=0.24))
    assert found.of("tracker", 5).median == pytest.approx(0.1)
    assert found.of("estimate", 5).median == pytest.approx(0.26)
    assert found.of("twin", 0).median == pytest.approx(np.hypot(0.01, 0.3))


def test_a_hard_cut_is_forecast_with_the_band_that_it_is_learned_with():
    base = prepare(HARD)
    first = base.plant.run(np.zeros_like(base.loaded.reference))
    plants = ahead._known_arm(base, first, ToolPath(source=Source.TRACKER)).plants
    assert ToolLaw().band(plants, base.turn_rate) == OF_HARD


def test_calibration_moves_the_median_and_widens_the_interval(monkeypatch):
    monkeypatch.setattr(ahead, "CALIBRATION", {"motor": Calibration(1.0, 1.5, 0.4)})
    found = summarised(ensemble([0.5, 0.5, 0.5])).of("motor", 20)
    assert found.median == pytest.approx(0.75)
    assert np.log(found.high / found.low) == pytest.approx(2.0 * 1.6449 * 0.4, rel=1e-3)


def test_learning_that_diverges_counts_as_tenfold(plain):
    assert summarised(ensemble([np.inf, np.inf, np.inf])).of("motor", 5).median == pytest.approx(10)


@pytest.mark.usefixtures("plain")
@pytest.mark.parametrize(
    ("share", "updates", "refused"), [(1.1, 5, True), (0.9, 5, False), (1.1, 0, False)]
)
def test_learning_that_makes_most_robots_worse_is_objected_to(share, updates, refused):
    found = summarised(ensemble(share * np.array([0.99, 1.0, 1.01])))
    why = found.objection("motor", updates)
    assert (why is not None) == refused
    if why is not None:
        assert "tracker 10 %" in why


def test_the_hard_square_at_p2_is_caught_before_its_first_run():
    """Motor learning reached 268 % there in a trial with other robots."""
    found = forecast(HARD, robots=3, measures=("motor",))
    assert found.objection("motor", 5)
    assert 1.5 < found.of("motor", 5).median < 4.0


def test_nothing_is_read_of_the_robot_that_cuts():
    plain, own = (
        forecast(replace(Cut(radius=0.002, speed=0.06), **state), robots=3, measures=("tracker",))
        for state in ({}, {"individual": Drawn(5), "friction_drift": 0.5, "temperature": 60.0})
    )
    assert plain == own
    assert plain.of("tracker", 5).median < 0.5 < 1e6 * plain.uncorrected


@pytest.mark.parametrize(
    ("options", "text"),
    [
        ({"robots": 2}, "robots must be >= 3, got 2"),
        ({"measures": ("ears",)}, "Unknown measure 'ears'"),
    ],
)
def test_a_forecast_of_nothing_is_refused(options, text):
    with pytest.raises(ValueError, match=text):
        forecast(Cut(), **options)


@pytest.mark.parametrize(
    ("options", "assumed", "calibrated"),
    [
        ({}, [], True),
        (
            {"robot": "irb1400", "pose": "p1"},
            ["not calibrated for this robot: fitted on large"],
            False,
        ),
        ({"payload": 60.0, "payload_known": False}, ["that of 60 kg is unknown"], True),
        ({"payload": 60.0}, [], True),
    ],
)
def test_an_interval_is_called_calibrated_on_the_robots_it_was_fitted_on(
    options, assumed, calibrated
):
    cut = Cut(radius=0.002, speed=0.06, **options)
    found = forecast(cut, robots=3, measures=("motor",))
    assert found.of("motor", 5).calibrated is calibrated
    assert len(found.assumed) == len(assumed)
    assert all(text in said for text, said in zip(assumed, found.assumed, strict=True))


def test_a_twins_interval_is_wider_than_the_ensemble_by_what_nine_robots_showed():
    """log: 1.645 times 0.55, of an ensemble without spread."""
    found = summarised(ensemble([0.6, 0.6, 0.6])).of("twin", 0)
    assert found.calibrated
    assert np.log(found.high / found.median) == pytest.approx(1.645 * 0.55, rel=1e-3)


def test_an_estimate_is_forecast_by_the_unit_at_the_tool():
    """One of 20 Hz sees less of what springs do at 10 Hz and more."""
    of_file, slow = (
        forecast(Cut(radius=0.002, speed=0.06, imu=imu), robots=3, measures=("estimate",))
        for imu in (None, ImuCfg(rate=20.0))
    )
    assert of_file.of("estimate", 5).median < slow.of("estimate", 5).median


@pytest.mark.parametrize("fitted", [True, False])
def test_an_objection_says_that_it_is_not_calibrated(plain, fitted):
    why = summarised(ensemble([1.2, 1.3, 1.4]), fitted=fitted).objection("motor", 5)
    assert why is not None
    assert ("not calibrated for this robot" in why) != fitted
