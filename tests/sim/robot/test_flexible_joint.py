"""One flexible joint in MJCF is the two-mass joint of chapter 8: measured from torque to angle.

The joint is modelled as everywhere in this project: two hinges on one body, the motor as
armature on the arm side of the gear, the gear as the stiffness of the second hinge.
"""

import mujoco
import numpy as np
import pytest
from mujoco import rollout

from armside.ilc.models.two_mass import TwoMassJoint

JOINT = TwoMassJoint()
STEP = 1e-4
"""[s]; Euler shifts phase by omega h / 2 and no more."""
RESONANCE = np.sqrt(JOINT.k / JOINT.Ja) / (2 * np.pi)
"""[Hz], of the arm on its spring: 1.13."""


def mjcf():
    """In arm-side coordinates the motor angle is rg q_m, its inertia Jm / rg^2."""
    rg2 = JOINT.rg**2
    small = 1e-9  # MuJoCo wants an inertia in every moving body
    return f"""
    <mujoco>
      <option timestep="{STEP}" integrator="Euler" gravity="0 0 0">
        <flag contact="disable"/>
      </option>
      <worldbody>
        <body>
          <joint name="motor" axis="0 0 1" armature="{JOINT.Jm / rg2}" damping="{JOINT.fm / rg2}"/>
          <joint name="flex" axis="0 0 1" stiffness="{JOINT.k}" damping="{JOINT.d}"/>
          <inertial pos="0 0 0" mass="1" diaginertia="{JOINT.Ja} {JOINT.Ja} {JOINT.Ja + small}"/>
        </body>
      </worldbody>
      <actuator><motor joint="motor" gear="{JOINT.kt / JOINT.rg}"/></actuator>
    </mujoco>"""


def swept_response(hertz):
    """Complex response from voltage to (q_m, q_a) at one frequency, after the transient."""
    model = mujoco.MjModel.from_xml_string(mjcf())
    data = mujoco.MjData(model)
    # The slowest poles of G_m besides the integrator decay with 2.5 1/s: 12 s leave nothing.
    settle, periods = 12.0, 4
    n_settle = round(settle / STEP)
    n = round(periods / hertz / STEP)
    omega = 2 * np.pi * periods / (n * STEP)
    t = np.arange(n_settle + n) * STEP
    voltage = np.cos(omega * t)
    state = np.empty(mujoco.mj_stateSize(model, mujoco.mjtState.mjSTATE_FULLPHYSICS))
    mujoco.mj_getState(model, data, state, mujoco.mjtState.mjSTATE_FULLPHYSICS)
    states, _ = rollout.rollout(model, data, initial_state=state, control=voltage[:, None])
    # states follow the step: row i belongs to t = (i + 1) h
    time = states[0, n_settle:, 0]
    angles = states[0, n_settle:, 1:3]
    motor, arm = angles[:, 0] / JOINT.rg, angles.sum(axis=1)
    # The integrator keeps a constant: it is orthogonal to whole periods.
    turn = np.exp(-1j * omega * time)
    return omega, 2 * np.mean(motor * turn), 2 * np.mean(arm * turn)


@pytest.mark.parametrize("part", [0.3, 0.7, 1.0, 1.3, 2.0])
def test_the_mjcf_joint_has_the_response_of_8_6_and_8_7_up_to_twice_the_resonance(part):
    omega, motor, arm = swept_response(part * RESONANCE)
    s = 1j * omega
    num, den = JOINT.motor_transfer
    G_m = np.polyval(num, s) / np.polyval(den, s)
    num, den = JOINT.arm_transfer
    G_a = np.polyval(num, s) / np.polyval(den, s)
    assert abs(motor / G_m - 1) < 0.01
    assert abs(arm / (G_m * G_a) - 1) < 0.01
    assert abs((arm / motor) / G_a - 1) < 0.01


def test_the_response_shows_two_masses_and_not_one():
    """What a plain actuator on a hinge cannot: the motor's notch at the arm's resonance."""
    _, motor, arm = swept_response(RESONANCE)
    omega, rigid = 2 * np.pi * RESONANCE, JOINT.Jm + JOINT.rg**2 * JOINT.Ja
    one_mass = JOINT.kt / abs(-rigid * omega**2 + 1j * JOINT.fm * omega)
    assert abs(motor) < 0.75 * one_mass
    assert abs(arm) > 2.5 * JOINT.rg * abs(motor)
