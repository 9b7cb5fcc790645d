"""One cut of the large robot, the arm that is assumed for it, and what it makes known."""

from dataclasses import replace

import numpy as np

from armside.assets import LARGE_ROBOT_XML
from armside.sim.estimation.commissioning import Commissioning, commission
from armside.sim.instruments.imu import ImuCfg
from armside.sim.laser import Cut, ToolPath, prepare
from armside.sim.robot.effects import Effect
from armside.sim.robot.model import load_model

IMU = ImuCfg()
CUT = Cut(pose="p2", without=tuple(Effect), imu=IMU)
MEASURE = ToolPath()


def assumed():
    """The arm with stiffnesses that are wrong."""
    return MEASURE.assumed(prepare(CUT))


def commissioned(run, cfg=Commissioning()):
    robot = load_model(LARGE_ROBOT_XML)
    return commission(robot, assumed(), IMU, run.recording, run.imu, cfg)


def spread(a, b):
    """3D RMS distance of two paths from rest [m]."""
    return float(np.sqrt(np.square((a - b)[:, :3]).sum(axis=1).mean()))


def kept(imu, keep):
    """The samples of an IMU at some rows."""
    return replace(imu, **{name: value[keep] for name, value in vars(imu).items()})
