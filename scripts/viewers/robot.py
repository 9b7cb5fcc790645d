"""`armside robot view`: MuJoCo's viewer of a robot, with a slider for each motor."""

from dataclasses import dataclass

import mujoco
import numpy as np

from armside.sim.robot.kinematics_check import cell_model
from armside.sim.robot_file.find import find_cell

from ..shell.errors import checking_input
from ..shell.options import Common, FileToRead, options
from ..viewers.web_viewer import check_display

SERVO = 2.0 * np.pi * 5.0
"""Bandwidth of the sliders' servos [rad/s], far below the resonances of the arm."""


@options
@dataclass(frozen=True, kw_only=True)
class ViewCfg:
    """The robot to show."""

    robot: str = "large"
    """Robot: large, irb1400, or a robot file (.toml)."""
    model: FileToRead = None
    """MJCF file to show in place of that robot's own."""


def view(*, cfg: ViewCfg = ViewCfg(), common: Common = Common()) -> None:
    """Show a robot in MuJoCo's own viewer; sliders move its motors under gravity.

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

    The drives of the asset need the torques of a controller, which the viewer has not. The springs
    between motors and links stay as they are.

    Raises ValueError where the file is no model, has no joints motor_1, motor_2 ..., or a robot of
    a file disagrees with its model.
    """
    cell = find_cell(cfg.robot)
    source = cfg.model or cell.xml
    if cfg.model is None:
        cell_model(cell)  # raises for a model of another geometry
    scene = source.with_name(f"{source.stem}_scene.xml")
    spec = mujoco.MjSpec.from_file(str(scene if scene.is_file() else source))
    motors = [joint for joint in spec.joints if joint.name.startswith("motor_")]
    if not motors:
        raise ValueError(f"{source} has no joints motor_1, motor_2, ...")
    for element in [*spec.actuators, *spec.sensors, *spec.keys]:
        spec.delete(element)
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
    """Set every slider to the angle of its motor."""
    angles = data.qpos[mj.jnt_qposadr[mj.actuator_trnid[:, 0]]]
    data.ctrl[:] = np.clip(angles, *mj.actuator_ctrlrange.T)
