"""What learning goes on from after a first cut by a twin: along a long path, its own."""

from types import SimpleNamespace
from typing import Any

import numpy as np
import pytest

from armside.sim.instruments.imu import ImuCfg
from armside.sim.laser.experiment import prepare
from armside.sim.laser.specification import Cut
from armside.sim.laser.tool_measure import ToolPath
from armside.sim.motion.contour import Circle
from armside.sim.twin.first_cut import FirstCut

RUN: Any = object()


@pytest.mark.parametrize("long", [False, True])
def test_a_short_cut_learns_what_its_estimate_sees_of_the_twin_a_long_one_the_program(long):
    twin: Any = SimpleNamespace(run=lambda *_: RUN)
    found: Any = SimpleNamespace(trusted=True, correction=np.zeros(0))
    experiment = prepare(Cut(pose="p2", contour=Circle(0.05) if long else None, imu=ImuCfg()))
    measure = ToolPath()
    goes_on = FirstCut(twin, found).around(measure, experiment)
    assert goes_on is measure if long else isinstance(goes_on, ToolPath) and goes_on.target is RUN
