"""A robot without a run: MuJoCo's viewer with a slider for each motor, and a picture."""

import copy
from pathlib import Path

import mujoco
import numpy as np

from armside.sim.cell import Cell
from armside.sim.replay.offscreen import Offscreen, drawn_model, named_camera
from armside.sim.robot.kinematics_check import cell_model
from armside.sim.robot.model import RobotModel
from armside.sim.robot_file.find import find_cell

from ..shell.errors import checking_input
from .web_viewer import check_display

SERVO = 2.0 * np.pi * 5.0
"""Bandwidth of the sliders' servos [rad/s], far below the resonances of the arm."""
WIDTH, HEIGHT = 960, 720
AMBIENT, DIFFUSE = 0.35, 0.6
"""Light at the camera, of a robot without a scene beside its file."""


def view_robot(robot: str, model: Path | None = None) -> None:
    """Open MuJoCo's viewer. Raises as `posable`, and InputError where there is no display."""
    with checking_input():
        mj = posable(robot, model)
    check_display("`armside replay DIR --web` shows a run in a browser, --png as a picture")
    from mujoco import viewer  # looks for a display when it is imported

    data = mujoco.MjData(mj)
    hold(mj, data)
    viewer.launch(mj, data)


def posable(robot: str, model: Path | None = None) -> mujoco.MjModel:
    """The robot, or another model (MJCF), on its floor, each motor held by a stiff position servo
    with a slider: drives need the torques of a controller, which the viewer has not.

    Raises ValueError where the file is no model, has no joints motor_1, motor_2 ..., or a robot of
    a file disagrees with its model.
    """
    cell = find_cell(robot)
    source = model or cell.xml
    if model is None:
        cell_model(cell)  # raises for a model of another geometry
    scene = source.with_name(f"{source.stem}_scene.xml")
    spec = mujoco.MjSpec.from_file(str(scene if scene.is_file() else source))
    motors = [joint for joint in spec.joints if joint.name.startswith("motor_")]
    if not motors:
        raise ValueError(f"{source} has no joints motor_1, motor_2, ...")
    for element in [*spec.actuators, *spec.sensors, *spec.keys]:
        spec.delete(element)
    mj = spec.compile()
    data, M = mujoco.MjData(mj), np.zeros((mj.nv, mj.nv))
    mujoco.mj_forward(mj, data)
    mujoco.mj_fullM(mj, data, M)
    inertia = {mj.joint(i).name: float(M[a, a]) for i, a in enumerate(mj.jnt_dofadr)}  # [kg m^2]
    for joint in motors:
        servo = spec.add_actuator(name=joint.name.replace("motor", "axis"), target=joint.name)
        servo.trntype = mujoco.mjtTrn.mjTRN_JOINT
        stiffness = inertia[joint.name] * SERVO**2
        servo.gainprm[0], servo.biastype = stiffness, mujoco.mjtBias.mjBIAS_AFFINE
        servo.biasprm[1], servo.biasprm[2] = -stiffness, -2.0 * inertia[joint.name] * SERVO
        servo.ctrlrange = joint.range
    return spec.compile()


def hold(mj: mujoco.MjModel, data: mujoco.MjData) -> None:
    """Set every slider to the angle of its motor."""
    angles = data.qpos[mj.jnt_qposadr[mj.actuator_trnid[:, 0]]]
    data.ctrl[:] = np.clip(angles, *mj.actuator_ctrlrange.T)


def draw_robot(file: Path, model: RobotModel, cell: Cell) -> None:
    """Write a PNG. Raises NoGraphicsError where nothing can be drawn."""
    import matplotlib.image

    mj = drawn_model(model.mj, cell.xml)
    alone = mj is model.mj
    if alone:
        mj = copy.copy(mj)
        mj.vis.headlight.ambient[:], mj.vis.headlight.diffuse[:] = AMBIENT, DIFFUSE
    data = mujoco.MjData(mj)
    home = np.zeros(cell.robot.n_joints) if cell.home is None else np.array(cell.home)
    for i, angle in enumerate(np.clip(home, cell.limits.lower, cell.limits.upper), 1):
        data.qpos[mj.joint(f"motor_{i}").qposadr[0]] = angle
    mujoco.mj_forward(mj, data)
    with Offscreen(mj, WIDTH, HEIGHT) as screen:
        image = screen.draw(data, named_camera(mj, "overview"))
    if alone:  # nothing is behind it: black, which no lit shape is
        image = np.where(image.any(axis=2, keepdims=True), image, np.uint8(255))
    matplotlib.image.imsave(file, image)
