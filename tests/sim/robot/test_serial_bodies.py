"""Masses on the D-H links of the robots, beside the mass matrix of their MJCF."""

from pathlib import Path

import mujoco
import numpy as np
import pytest

from armside import assets
from armside.kinematics import InertialModel, compile_dynamics
from armside.sim.arm_with_masses import arm_with_masses
from armside.sim.cell_file import find_cell
from armside.sim.robot.cell_model import cell_model
from armside.sim.robot.model import RobotModel, robot_model
from armside.sim.robot.serial_bodies import serial_bodies

TWO_LINK = str(Path(assets.LARGE_ROBOT_XML).with_name("two_link.toml"))


def without_rotors(model: RobotModel, phi: np.ndarray) -> np.ndarray:
    """Mass matrix of the motor angles with springs at rest, less the rotors'."""
    mj, data = model.mj, mujoco.MjData(model.mj)
    data.qpos[:] = model.posture @ phi
    mujoco.mj_forward(mj, data)
    D = np.zeros((mj.nv, mj.nv))
    mujoco.mj_fullM(mj, data, D)
    return model.posture.T @ (D - np.diag(mj.dof_armature)) @ model.posture


@pytest.mark.parametrize("name", ["large", TWO_LINK], ids=["large", "two-link"])
def test_the_mass_matrix_is_that_of_the_hardware_at_rest(name):
    cell = find_cell(name)
    model = cell_model(cell)
    found = serial_bodies(model, cell.robot)
    assert found.left_out == ()
    dynamics = compile_dynamics(InertialModel(cell.robot, found.bodies))
    for phi in np.random.default_rng(0).uniform(-1, 1, (3, cell.robot.n_joints)):
        expected = without_rotors(model, phi)
        np.testing.assert_allclose(dynamics.mass_matrix(phi), expected, rtol=1e-10, atol=1e-10)


def test_the_linkage_of_the_irb1400_is_left_out_by_name():
    """Its crank and rod made light, the rest is the mass matrix of the hardware."""
    cell = find_cell("irb1400")
    model = cell_model(cell)
    found = serial_bodies(model, cell.robot)
    assert set(found.left_out) == {"crank", "rod"}
    assert any("crank" in note for note in arm_with_masses("irb1400").notes)
    spec = model.parsed()
    for name in found.left_out:
        body = spec.body(name)
        body.mass, body.inertia = 1e-9, np.full(3, 1e-9)
    phi = np.array([0.3, -0.2, 0.4, 0.5, -0.6, 0.7])
    expected = without_rotors(robot_model(spec), phi)
    dynamics = compile_dynamics(InertialModel(cell.robot, found.bodies))
    np.testing.assert_allclose(dynamics.mass_matrix(phi), expected, rtol=0, atol=1e-7)
