"""Ends of options, which belong to them or not, and options in the units of what they are for."""

from functools import partial

import pytest

from armside.ilc.models.two_mass import TwoMassLoop
from armside.kinematics.calibration import CalibrationCfg
from armside.scripts.commands.calibrate_arm import LIMITS, CalibrateArmCfg
from armside.scripts.commands.imu import AT_MOST, ImuOptions
from armside.scripts.commands.reproduce import JointCfg
from armside.scripts.cutting.comparison import CompareCfg, refuse_absurd_comparison
from armside.scripts.cutting.options import BEAM
from armside.scripts.shell import effort
from armside.scripts.shell.errors import InputError, needs
from armside.scripts.shell.options import Limits
from armside.scripts.studies.options import TuneCfg
from armside.scripts.workbench import plant_option
from armside.scripts.workbench.controllers import whole_port
from armside.scripts.workbench.joint import FACTOR, loop_of
from armside.scripts.workbench.options import LearnCfg
from armside.sim.imu import ImuExperiment

FM = TwoMassLoop().joint.fm
ENDS = {
    "off": (partial(AT_MOST["off"].check, "off"), (0.001, 600.0), (0.0, 600.1), r"600\] s"),
    "on": (partial(AT_MOST["on"].check, "on"), (0.001, 600.0), (0.0, 600.1), r"600\] s"),
    "harmonics": (
        partial(LIMITS["harmonics"].check, "harmonics"),
        *((0, 200), (-1, 201), "harmonics must be 0 to 200"),
    ),
    "beam": (
        partial(BEAM.check, "beam"),
        *((0.01, 100.0), (0.0099, 100.1), r"beam must be 0\.01 to 100 mm"),
    ),
    "gamma": (lambda value: JointCfg(gamma=value), (1e-9, 100.0), (0.0, 100.1), "gamma"),
    "delta": (lambda value: JointCfg(delta=value), (1, 100), (0, 101), "delta"),
    "cutoff": (lambda value: JointCfg(cutoff=value), (0.1, 49.0), (0.09, 49.1), "cutoff"),
    "speed": (
        lambda value: TuneCfg(speed=value),
        *((1.0, 100.0), (0.99, 100.1), "speed must be from 1 to 100 mm/s"),
    ),
    "fm": (
        lambda value: loop_of([f"fm={value!r}"]),
        *((FM / FACTOR, FM * FACTOR), (FM / FACTOR**1.01, FM * FACTOR**1.01), "fm must be"),
    ),
    "port": (whole_port, (0, 65535), (-1, 65536, 0.5), "from 0 to 65535"),
    "a certain port": (lambda value: whole_port(value, 1), (1,), (0,), "from 1 to 65535"),
    "both": (partial(Limits(1.0, 2.0).check, "width"), ((1.0, 2.0),), ((1.5, 2.1), 0.9), "^width"),
    "above": (partial(Limits(1.0, 2.0, above=True).check, "width"), (2.0,), (1.0,), "^width must"),
    "below": (partial(Limits(1.0, 2.0, below=True).check, "width"), (1.0,), (2.0,), "^width must"),
    "none given": (partial(Limits(1.0).check, "width"), (None,), (), ""),
}


@pytest.mark.parametrize("name", ENDS)
def test_an_end_belongs_to_an_option_and_what_is_beyond_does_not(name):
    check, ends, beyond, said = ENDS[name]
    for value in ends:
        check(value)
    for value in beyond:
        with pytest.raises(ValueError, match=said):
            check(value)


def test_calibration_fits_half_of_the_poses_at_random():
    cfg, library = CalibrateArmCfg(robot="ur10"), CalibrationCfg()
    assert (cfg.fraction, cfg.in_order) == (0.5, False)
    assert library.in_order == cfg.in_order


def test_delays_are_given_in_milliseconds():
    options = ImuOptions(accelerometer_delay=3.0, gyroscope_delay=2.0).experiment()
    assert isinstance(options, ImuExperiment)
    made = options.processing
    assert made.accelerometer_delay == pytest.approx(0.003)
    assert made.gyroscope_delay == pytest.approx(0.002)


def test_what_is_fixed_for_all_episodes_is_in_metres_and_kilograms():
    assert TuneCfg().fixed == {}
    fixed = TuneCfg(pose="p1", speed=60.0, payload=40.0).fixed
    assert fixed == {"pose": "p1", "speed": 0.06, "payload": 40.0}


def test_the_runs_of_comparisons_are_of_each_way_or_law_case_and_iteration(monkeypatch):
    """Four ways (motor, estimate, tracker, oracle) x 5 x (3 + 1), where a twin is a fifth; and
    laws x noise x repeats x iterations: 3 x 2 x 5 x (7 + 1)."""
    monkeypatch.setattr(effort, "LONGEST", 0.0)
    with pytest.raises(InputError, match=r"^80 runs at 20 mm/s and more"):
        refuse_absurd_comparison(CompareCfg(iterations=3, speeds=(40.0, 20.0)), 5)
    cfg = LearnCfg(laws=("p", "pd", "bfgs"), noise=(0.0, 1.0), repeats=5, iterations=7)
    with pytest.raises(InputError, match=r"^240 runs of \d+ numbers"):
        plant_option.named_task(cfg, 0)


def test_packages_of_others_are_asked_for_by_their_extra_and_ours_are_our_fault():
    said = r"^armside tune needs It: pip install 'armside\[rl\]'"
    for name in ("aaa", "zzz.part", "armsides"):
        with pytest.raises(InputError, match=said), needs("rl", "armside tune", "It"):
            raise ModuleNotFoundError(name=name)
    with pytest.raises(ModuleNotFoundError), needs("rl", "armside tune", "It"):
        raise ModuleNotFoundError(name="armside.sim.none")
