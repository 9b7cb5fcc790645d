"""The whole nominal arm dragged along by its motors in one rollout: what estimates are held to."""

from typing import NamedTuple

import mujoco
import numpy as np
from mujoco.rollout import Rollout

from armside.arrays import Array
from armside.ilc.filters import ZeroPhaseButterworth
from armside.sim.estimation.linearised_arm import at_rest
from armside.sim.estimation.nominal import NominalArm
from armside.sim.estimation.rigid_motion import ENCODER_FILTER
from armside.sim.robot.servo import interpolate, substeps


class Motion(NamedTuple):
    """Angles of the free joints (M, n) [rad] and the tool (M, 3) [m] at every physics step."""

    q: Array
    tool_position: Array


def observe(arm: NominalArm, motor_angle: Array, period: float) -> Motion:
    """The arm's motion from logged motor angles (N, a) [rad], every `period` [s], from rest."""
    smooth = arm.gear_output(ZeroPhaseButterworth(ENCODER_FILTER, period)(motor_angle))
    phi, phi_dot, _ = interpolate(smooth, period, substeps(float(arm.mj.opt.timestep), period))
    return dragged(arm, phi, phi_dot)


def dragged(arm: NominalArm, phi: Array, phi_dot: Array) -> Motion:
    """The arm's motion from motor angles and rates (M, a) at every physics step."""
    mj, data, whole = arm.mj, mujoco.MjData(arm.mj), int(mujoco.mjtState.mjSTATE_FULLPHYSICS)
    arm.motion.place(data, at_rest(arm, phi[0]))
    initial = np.empty(mujoco.mj_stateSize(mj, whole))
    mujoco.mj_getState(mj, data, initial, whole)
    with Rollout(nthread=0) as rollout:
        # K (phi - q) + D (phi' - q') = K (control - q) - D q'
        controls = phi + arm.damping / arm.stiffness * phi_dot
        result = rollout.rollout([mj], [data], initial[None], controls[None])
    states, sensors = (np.asarray(part, dtype=np.float64)[0] for part in result)
    moved = np.vstack((initial, states[:-1]))  # a state row belongs to the end of its step
    place = int(mj.sensor("tool0_pos").adr[0]) + np.arange(3)
    return Motion(moved[:, 1 + arm.motion.joints], sensors[:, place])
