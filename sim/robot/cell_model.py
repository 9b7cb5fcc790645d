"""Robot model of a cell, or of a file in its place, that has the kinematics of the cell."""

from pathlib import Path

import mujoco

from ..cell import Cell
from .kinematics_check import check_kinematics
from .mjcf import ModelError
from .model import RobotModel, load_model


def cell_model(cell: Cell, source: Path | mujoco.MjModel | None = None) -> RobotModel:
    """Load a robot model and compare it with the cell's D-H model.

    source: MJCF file in place of the cell's own, or a compiled variant of that.

    Raises ModelError for a file that is no robot model, or one of another geometry.
    """
    source = cell.xml if source is None else source
    model = load_model(source)
    try:
        check_kinematics(model, cell.robot, cell.limits, cell.with_imu)
    except ModelError as error:
        file = source if isinstance(source, Path) else cell.xml
        raise ModelError(f"{file}: {error}") from error
    return model
