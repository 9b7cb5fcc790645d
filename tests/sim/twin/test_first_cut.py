"""What learning goes on from after a first cut by a twin: along a long path, its own."""

from types import SimpleNamespace
from typing import Any

import numpy as np

from armside.sim.instruments.imu import ImuCfg
from armside.sim.laser.experiment import prepare
from armside.sim.laser.specification import Cut
from armside.sim.laser.tool_measure import ToolPath
from armside.sim.motion.contour import Circle
from armside.sim.twin.first_cut import FirstCut

RUN: Any = object()


def by_twin() -> FirstCut:
    twin: Any = SimpleNamespace(run=lambda *_: RUN)
    found: Any = SimpleNamespace(trusted=True, correction=np.zeros(0))
    return FirstCut(twin, found)


def test_a_short_cut_learns_what_its_estimate_sees_of_the_twin():
    experiment = prepare(Cut(pose="p2", imu=ImuCfg()))
    found = by_twin().around(ToolPath(), experiment)
    assert isinstance(found, ToolPath)
    assert found.target is RUN


def test_a_long_path_learns_what_is_programmed_with_a_twin_too():
    experiment, measure = (
        prepare(Cut(pose="p2", contour=Circle(0.05), imu=ImuCfg())),
        ToolPath(),
    )
    found = by_twin().around(measure, experiment)
    assert found is measure
