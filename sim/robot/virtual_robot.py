"""Virtual robot: a flexible arm with its servo, run as one rollout of the physics.

A run is open loop for the program: reference r and correction u are known before it, so the whole
run, servo included, is one call of `mujoco.rollout` with no Python in the step loop.
"""

import copy
from dataclasses import dataclass, replace

import mujoco
import numpy as np

from armside.arrays import Array

from .drives import friction_torque
from .model import RobotModel
from .recording import Recording
from .run import LoadedReference, checked_signal
from .servo import at_step_end, interpolate, motor_controls, substeps
from .statics import Statics

LOG_PERIOD = 0.004
"""[s], of the motor log, r and u. Thesis 5.1.2; numbers.md section 4 confirms it for chapter 9."""

_FULL_STATE = mujoco.mjtState.mjSTATE_FULLPHYSICS


@dataclass(frozen=True, eq=False)
class Commanded:
    """What a controller makes of a reference, whichever individual it drives; arm side."""

    reference: Array
    """(N, n) [rad], at the log rate."""
    position: Array
    velocity: Array
    """(M, n) [rad] and [rad/s], the reference at each physics step."""
    torque: Array
    """(M, n) [N m], feedforward."""


class VirtualRobot:
    """A robot individual with its controller. `load` a reference, then run it repeatedly."""

    def __init__(
        self, model: RobotModel, *, nominal: Statics | None = None, log_period: float = LOG_PERIOD
    ) -> None:
        """nominal: model of the torque feedforward; that of the robot itself if None. log_period:
        [s], a whole number of physics steps."""
        self.model = model
        self.log_period = log_period
        self._statics = Statics(model)
        self._nominal = nominal or self._statics
        self._ratio = substeps(model.timestep, log_period)

    def commanded(self, reference: Array) -> Commanded:
        """The controller's part of `load`. Raises ValueError as it does for a reference."""
        reference = checked_signal(reference, "reference", self.model.n_axes)
        position, velocity, _ = interpolate(reference, self.log_period, self._ratio)
        torque = self._feedforward(reference, velocity)
        return Commanded(reference, position, velocity, torque)

    def load(self, reference: Array | Commanded, *, motors_on_at: float = 0.0) -> LoadedReference:
        """Prepare the servo's inputs for a reference, starting at rest in static equilibrium.

        reference: (N, n) [rad], r at the log rate, arm-side motor angles, at rest at both ends; or
        what the controller of another individual made of it. motors_on_at: [s]; before it the
        brakes hold the arm. Raises ValueError for a wrong reference, a robot without brakes, or a
        load that its drives cannot hold.
        """
        asked = reference if isinstance(reference, Commanded) else self.commanded(reference)
        model, drives = self.model, self.model.drives
        position, velocity, torque = asked.position, asked.velocity, asked.torque
        hinge_speed = drives.velocity_feedforward * velocity
        if model.gear_error is not None:
            # The servo brings the measured angle q - epsilon(q) to the reference.
            hinge_speed += model.gear_error.rate(position, velocity)
            position = position + model.gear_error(position)
        start = self._statics.equilibrium(position[0])
        limit = np.abs(drives.gear) * drives.torque_limit
        axis = int((np.abs(start.holding_torque) / limit).argmax())
        if not abs(held := float(start.holding_torque[axis])) < limit[axis]:
            raise ValueError(
                f"the robot cannot carry its load: at rest axis {axis + 1} would have to hold "
                f"{abs(held):.0f} N m, and its drive holds {limit[axis]:.0f} N m"
            )
        applied = None
        if (own := model.own_drive) is not None:
            load = torque - torque[0] + start.holding_torque
            time = model.timestep * np.arange(float(len(torque)))
            applied = own.applied(drives, load, velocity, time)
            torque = own.feedforward(drives, torque, velocity)
        torque = torque + (start.holding_torque - _ripple(model, start.qpos) - torque[0])
        powered = np.arange(len(position)) * model.timestep >= motors_on_at
        if not powered.all():
            if not len(model.brakes):
                brakes = f"brake_1..{model.n_axes}"
                raise ValueError(
                    f"this robot has no brakes: its model lacks the equalities {brakes}"
                )
            model = replace(model, mj=copy.copy(model.mj))
            model.mj.eq_data[model.brakes, 0] = position[0]  # where they hold the motors
            torque[~powered] = 0.0
        if model.implicit:
            hinge_speed = at_step_end(hinge_speed)
        return LoadedReference(
            model=model,
            log_period=self.log_period,
            ratio=self._ratio,
            reference=asked.reference,
            controls=motor_controls(model, position, hinge_speed, torque),
            powered=powered,
            initial_state=_initial_state(model.mj, start.qpos),
            applied=applied,
        )

    def run(
        self,
        reference: Array,
        correction: Array | None = None,
        rng: np.random.Generator | None = None,
    ) -> Recording:
        """Load a reference and run it once; see `LoadedReference.run`."""
        return self.load(reference).run(correction, rng)

    def _feedforward(self, reference: Array, velocity: Array) -> Array:
        """(M, n) [N m], arm side: rigid computed torque, evaluated at the log rate and splined."""
        statics, drives = self._nominal, self._nominal.model.drives
        if drives.torque_feedforward == 0.0:
            return np.zeros_like(velocity)
        _, phi_dot, phi_ddot = interpolate(reference, self.log_period, 1)
        forces = statics.rigid_forces(reference, phi_dot, phi_ddot)
        torque, _, _ = interpolate(statics.motor_torque(forces), self.log_period, self._ratio)
        if drives.friction_feedforward > 0.0:
            torque += friction_torque(drives, velocity)
        return drives.torque_feedforward * torque


def _ripple(model: RobotModel, qpos: Array) -> Array:
    """(n,) [N m], arm side, that drives at rest deliver without current: their torque ripple."""
    data = mujoco.MjData(model.mj)
    data.qpos[:] = qpos
    still = np.zeros((1, model.n_axes))
    data.ctrl[:] = motor_controls(model, qpos[None, model.motor], still, still)[0]
    mujoco.mj_forward(model.mj, data)
    return data.qfrc_actuator[model.motor]


def _initial_state(mj: mujoco.MjModel, qpos: Array) -> Array:
    data = mujoco.MjData(mj)
    data.qpos[:] = qpos
    state = np.empty(mujoco.mj_stateSize(mj, int(_FULL_STATE)))
    mujoco.mj_getState(mj, data, state, int(_FULL_STATE))
    return state
