"""Experiments with the IMU at the tool, as claims judge them."""

from dataclasses import replace

from armside.arrays import Array
from armside.sim.imu import ImuExperiment

BASE = ImuExperiment()
SEQUENTIAL = replace(BASE, motion="sequential")
UNAIDED = replace(SEQUENTIAL, torque_feedforward=False)
LARGE = ImuExperiment(robot="large")
ACCELERATION = " [m/s^2]"


def by_axis(name: str, vector: Array, unit: str = ACCELERATION) -> dict[str, float]:
    """Cells of a vector (3,)."""
    return {f"{name} {axis}{unit}": float(v) for axis, v in zip("xyz", vector, strict=True)}


def axes(name: str, unit: str = ACCELERATION) -> list[str]:
    """Keys of the cells of `by_axis`."""
    return [f"{name} {axis}{unit}" for axis in "xyz"]
