"""`armside view`: MuJoCo's own viewer on a robot, with a slider for each motor."""

from dataclasses import dataclass
from pathlib import Path
from typing import Literal

import mujoco
import numpy as np

from armside.sim.cell import CELLS

from ..shell.errors import checking_input
from ..shell.options import Common, options
from ..viewers.display import check_display

SERVO = 2.0 * np.pi * 5.0
"""Bandwidth of the sliders' servos [rad/s]: quick to the eye, slow beside the arm's modes."""


@options
@dataclass(frozen=True, kw_only=True)
class ViewCfg:
    """What to look at."""

    robot: Literal["large", "irb1400"] = "large"
    """Which robot."""
    model: Path | None = None
    """MJCF file to look at in place of that robot's own."""


def view(*, cfg: ViewCfg = ViewCfg(), common: Common = Common()) -> None:
    """Look at a robot in MuJoCo's own viewer; sliders move its motors under gravity.

    Needs a display. Without one: armside replay --web, --png.
    """
    with checking_input():
        mj = posable(cfg)
    check_display("`armside replay DIR --web` shows a run in a browser, --png as a picture")
    from mujoco import viewer  # looks for a display when it is imported

    data = mujoco.MjData(mj)
    hold(mj, data)
    viewer.launch(mj, data)


def posable(cfg: ViewCfg) -> mujoco.MjModel:
    """The robot on its floor, each motor held by a stiff position servo with a slider.

    The drives of the asset take torques of a controller that is not there: they would let the arm
    fall. The springs between motors and links stay as they are.

    Raises:
        ValueError: the file is no model, or has no joints motor_1, motor_2 ...
    """
    source = cfg.model or CELLS[cfg.robot].xml
    if not source.is_file():
        raise ValueError(f"{source} is no file")
    scene = source.with_name(f"{source.stem}_scene.xml")
    spec = mujoco.MjSpec.from_file(str(scene if scene.is_file() else source))
    motors = [joint for joint in spec.joints if joint.name.startswith("motor_")]
    if not motors:
        raise ValueError(f"{source} has no joints motor_1, motor_2, ...")
    for actuator in list(spec.actuators):
        spec.delete(actuator)
    for sensor in list(spec.sensors):
        spec.delete(sensor)
    for key in list(spec.keys):
        spec.delete(key)
    inertia = _inertia(spec)
    for joint in motors:
        servo = spec.add_actuator(name=joint.name.replace("motor", "axis"), target=joint.name)
        servo.trntype = mujoco.mjtTrn.mjTRN_JOINT
        stiffness = inertia[joint.name] * SERVO**2
        servo.gainprm[0], servo.biastype = stiffness, mujoco.mjtBias.mjBIAS_AFFINE
        servo.biasprm[1], servo.biasprm[2] = -stiffness, -2.0 * inertia[joint.name] * SERVO
        servo.ctrlrange = joint.range
    return spec.compile()


def _inertia(spec: mujoco.MjSpec) -> dict[str, float]:
    """Inertia of each joint in the zero pose [kg m^2]."""
    mj = spec.compile()
    data = mujoco.MjData(mj)
    mujoco.mj_forward(mj, data)
    M = np.zeros((mj.nv, mj.nv))
    mujoco.mj_fullM(mj, data, M)
    return {mj.joint(i).name: float(M[a, a]) for i, a in enumerate(mj.jnt_dofadr)}


def hold(mj: mujoco.MjModel, data: mujoco.MjData) -> None:
    """Set every slider to where its motor is."""
    data.ctrl[:] = np.clip(
        data.qpos[mj.jnt_qposadr[mj.actuator_trnid[:, 0]]], *mj.actuator_ctrlrange.T
    )
