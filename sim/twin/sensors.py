"""Sensors of the tool by their name."""

from collections.abc import Mapping
from typing import Literal

from .imu_residuals import ImuSensor
from .tool_sensor import ToolSensor
from .tracker_residuals import TRACKER

Measure = Literal["tracker", "imu"]
SENSORS: Mapping[Measure, ToolSensor] = {"tracker": TRACKER, "imu": ImuSensor()}
