"""The cut of a task as its controller knows it: what `task.nominal` says, on the nominal robot.

Entries may import this too; it knows nothing of the individual.
"""

from collections.abc import Callable, Mapping
from typing import Any

import numpy as np

from armside.arrays import Array

from ..cell import ToolPose
from ..instruments.imu import ImuCfg, ImuSamples
from ..instruments.laser_tracker import TrackerSamples
from ..laser.experiment import Pass
from ..laser.specification import Cut
from ..motion.contour import Circle, ClosedCurve, hexagon, slot, square
from ..robot.recording import Recording, Truth
from ..robot.virtual_robot import LOG_PERIOD

SHAPES: Mapping[str, Callable[[float], ClosedCurve]] = {
    "circle": lambda size: Circle(0.5 * size),
    "square": lambda size: square(size, 0.15 * size),
    "hexagon": lambda size: hexagon(size, 0.15 * size),
    "slot": lambda size: slot(size, size / 3.0),
}
"""Contours by their width [m]."""


def cut_of(nominal: Mapping[str, Any]) -> Cut:
    """The cut of robot, position, quaternion, shape, size [m], speed [m/s], payload [kg], imu."""
    return Cut(
        robot=nominal["robot"],
        pose=ToolPose(tuple(nominal["position"]), tuple(nominal["quaternion"])),
        contour=SHAPES[nominal["shape"]](nominal["size"]),
        speed=nominal["speed"],
        payload=nominal["payload"],
        friction_spread=0.0,
        imu=ImuCfg() if nominal["imu"] else None,
    )


def pass_of(reference: Array, records: Mapping[str, Any]) -> Pass:
    """The run of an entry's records, as laws and estimators of armside take it.

    Its ground truth is NaN. Without a tracker there are no samples of one.
    """
    none, nothing = np.full((1, 3), np.nan), np.zeros(1)
    truth = Truth(
        time=nothing,
        gear_angle=np.full((1, reference.shape[1]), np.nan),
        spring_angle=np.full((1, reference.shape[1]), np.nan),
        motor_torque=np.full((1, reference.shape[1]), np.nan),
        tool_position=none,
        tool_quaternion=np.full((1, 4), np.nan),
        imu_acceleration=none,
        imu_angular_velocity=none,
        qpos=none,
    )
    log = Recording(
        time=np.asarray(LOG_PERIOD * np.arange(len(reference)), dtype=np.float64),
        reference=reference,
        correction=records["correction"],
        motor_angle=records["motor_angle"],
        motor_torque=records["motor_torque"],
        truth=truth,
    )
    seen = records.get("tracker", {"time": nothing, "position": none})
    valid = np.isfinite(seen["position"]).all(axis=1)
    tracker = TrackerSamples(time=seen["time"], position=seen["position"], valid=valid)
    imu = None
    if (of := records.get("imu")) is not None:
        clipped = {name: of[name] > 0.5 for name in of if name.endswith("clipped")}
        imu = ImuSamples(**{**of, **clipped})
    return Pass(recording=log, tracker=tracker, imu=imu)
