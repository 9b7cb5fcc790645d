"""One run of the virtual robot whose correction arrives sample by sample.

The physics advances in pieces of one log period, and gives the same bits as `LoadedReference.run`
with the whole correction known: noise is drawn before the start, the correction takes the same path
to the servo, and a sample acts only after the correction's delay, which is longer than a period.
"""

from dataclasses import dataclass

import mujoco
import numpy as np

from armside.arrays import Array

from ..robot.drives import friction_torque
from ..robot.recording import Recording
from ..robot.run import LoadedReference, measured_angle, recorded
from ..robot.servo import CorrectionTiming, Setpoints, extend_path
from ..robot.statics import Statics

_FULL_STATE = int(mujoco.mjtState.mjSTATE_FULLPHYSICS)


@dataclass
class StreamedRun:
    """A run in progress. `advance` takes the correction of one sample and runs one period."""

    loaded: LoadedReference
    rng: np.random.Generator | None = None
    guiding: Statics | None = None
    """Nominal robot whose rigid torque follows the guided motion; None: the torque of the program.
    A robot that stands still until it is guided needs one."""
    sample: int = 0
    """Log sample that the robot has reached."""

    def __post_init__(self) -> None:
        loaded, model = self.loaded, self.loaded.model
        if model.drives.correction_delay < loaded.log_period + model.timestep:
            raise ValueError(
                f"a correction can be streamed when it acts after {loaded.log_period:g} s or more, "
                f"that of this robot acts after {model.drives.correction_delay:g} s"
            )
        rows, still, drives = len(loaded.controls), np.zeros(model.n_axes), model.drives
        self._noise = loaded.noise(self.rng)
        position, velocity = np.empty((2, rows, model.n_axes))
        self._path = Setpoints(position=position, velocity=velocity)
        self._timing = CorrectionTiming(
            loaded.log_period, loaded.ratio, drives.correction_delay, drives.correction_lag
        )
        self._correction = np.zeros_like(loaded.reference)
        self._controls = np.empty_like(loaded.controls)
        self._states = np.empty((rows, len(loaded.initial_state)))
        self._sensors = np.empty((rows, model.mj.nsensordata))
        self._reached = self._written = 0
        self._guided_torque = self._at_rest = still
        if self.guiding is not None:
            self._at_rest = self._rigid(self.guiding, loaded.reference[0], still, still)
        self._data = mujoco.MjData(model.mj)
        mujoco.mj_setState(model.mj, self._data, loaded.initial_state, _FULL_STATE)
        self._extend(1)

    @property
    def finished(self) -> bool:
        """The last sample of the reference is reached."""
        return self.sample == len(self.loaded.reference) - 1

    @property
    def planned(self) -> Array:
        """Motor angles (n,) [rad] of the program at this sample."""
        return self.loaded.reference[self.sample]

    @property
    def motor_angle(self) -> Array:
        """Measured motor angles (n,) [rad] at this sample."""
        model, noise = self.loaded.model, self._noise.encoder
        angle = self._state_before(self._row)[1 + model.motor]
        noise = None if noise is None else noise[self._row : self._row + 1]
        return measured_angle(model, angle[None], noise)[0]

    @property
    def speed(self) -> Array:
        """Speeds (n,) [rad/s] of the motors at this sample, arm side."""
        model = self.loaded.model
        return self._state_before(self._row)[1 + model.mj.nq + model.motor]

    @property
    def _row(self) -> int:
        """Physics step of this sample."""
        return self.sample * self.loaded.ratio

    def ahead(self) -> None:
        """Run the period after this sample now, where a correction acts after two periods or more.

        Not after the first sample. `advance` then takes the correction alone, and signals stay as
        they are until it does.
        """
        loaded = self.loaded
        late_enough = 2.0 * loaded.log_period + loaded.model.timestep
        if self.sample and loaded.model.drives.correction_delay >= late_enough:
            self._run_period()

    def _run_period(self) -> None:
        if not self.finished and self._reached == self._row:
            self._step(self.loaded.ratio)

    def advance(self, correction: Array) -> None:
        """Run one period with u (n,) [rad] of this sample; ArithmeticError when the physics is
        unstable."""
        if self.finished:
            raise RuntimeError("the run is finished")
        self._correction[self.sample] = correction
        self._run_period()
        self.sample += 1

    def recording(self) -> Recording:
        """Record of the samples so far, and of the last one if the run is finished."""
        whole = self.finished
        if whole and self._reached < len(self._states):
            self._step(1)
        rows, encoder = self._reached if whole else self._row, self._noise.encoder
        return recorded(
            self.loaded,
            self._correction[: self.sample + whole],
            self._controls[:rows],
            None if encoder is None else encoder[:rows],
            self._states[:rows],
            self._sensors[:rows],
        )

    def _step(self, steps: int) -> None:
        rows = slice(self._reached, min(self._reached + steps, len(self._states)))
        self._extend(rows.stop + 1)
        controls = self._controls[rows] = self._controls_of(rows)
        mj, data = self.loaded.model.mj, self._data
        for row, ctrl in zip(range(rows.start, rows.stop), controls, strict=True):
            data.ctrl[:] = ctrl
            mujoco.mj_step(mj, data)
            mujoco.mj_getState(mj, data, self._states[row], _FULL_STATE)
            self._sensors[row] = data.sensordata
        if not np.isfinite(self._states[rows]).all() or data.time < 0.5 * mj.opt.timestep:
            raise ArithmeticError(f"the physics is unstable at {rows.stop * mj.opt.timestep:.3f} s")
        self._reached = rows.stop

    def _extend(self, stop: int) -> None:
        """Take the correction's path to row `stop` (exclusive)."""
        rows = self._written, min(stop, len(self._states))
        extend_path(self._path, self._correction, rows, self._timing)
        self._written = rows[1]

    def _controls_of(self, rows: slice) -> Array:
        loaded, path, drives = self.loaded, self._path, self.loaded.model.drives
        controls = loaded.controls[rows].copy().reshape(rows.stop - rows.start, -1, 3)
        ahead = np.arange(rows.start, rows.stop) + loaded.model.implicit
        position = path.position[rows]
        velocity = path.velocity[np.minimum(ahead, len(self._states) - 1)]
        loaded.add(controls, rows, position, velocity, self._noise)
        if self.guiding is not None:
            controls[:, :, 2] += self._guided(self.guiding, rows) / drives.gear
            if (gear_error := loaded.model.gear_error) is not None:
                start = loaded.reference[0]
                change = gear_error(start + position) - gear_error(start[None])
                controls[:, :, 0] += drives.gear * change
                controls[:, :, 1] += drives.gear * gear_error.rate(start + position, velocity)
        return controls.reshape(len(controls), -1)

    def _guided(self, guiding: Statics, rows: slice) -> Array:
        """(m, n) [N m], arm side: change of the rigid torque since rest, linear over a period."""
        path, period = self._path, self.loaded.log_period
        before, after = path.velocity[rows.start], path.velocity[rows.stop - 1]
        position = self.loaded.reference[0] + path.position[rows.stop - 1]
        torque = self._rigid(guiding, position, after, (after - before) / period) - self._at_rest
        share = np.arange(1, rows.stop - rows.start + 1)[:, None] / (rows.stop - rows.start)
        ramp = self._guided_torque + share * (torque - self._guided_torque)
        self._guided_torque = torque
        return ramp

    def _rigid(self, guiding: Statics, phi: Array, phi_dot: Array, phi_ddot: Array) -> Array:
        drives = guiding.model.drives
        forces = guiding.rigid_forces(phi[None], phi_dot[None], phi_ddot[None])
        torque = guiding.motor_torque(forces)[0]
        if drives.friction_feedforward > 0.0:
            torque = torque + friction_torque(drives, phi_dot[None])[0]
        return drives.torque_feedforward * torque

    def _state_before(self, row: int) -> Array:
        return self.loaded.initial_state if row == 0 else self._states[row - 1]
