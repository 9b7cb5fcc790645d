"""Residuals of a cut against a twin, and their sensitivity to the twin's parameters.

Torque: residual of each drive, to the constants of its own friction law, which all axes vary at
once, since the friction of one axis hardly moves another; and to the masses. Tool: displacement
less that of the motor angles, to springs, lost motion and masses by simulation, to gear errors and
geometry by kinematics.
"""

from collections.abc import Iterator, Sequence
from dataclasses import dataclass
from functools import cached_property

import numpy as np

from armside.arrays import Array

from ..robot.effects import gear_phases
from ..robot.mjcf import N_AXES
from ..robot.recording import Recording
from .parameters import BENDING, FRICTION, HYSTERESIS, SPRINGS, Parameters
from .recordings import MeasuredCut
from .simulation import RobotDesign
from .tool_sensor import TRACKER, CutComparison, ToolSensor

_STEP = 0.05
"""Of log factors, compliances and relative amplitudes in difference quotients."""
_BATCH = 12
"""Runs in memory at once, each at the rate of the physics."""


@dataclass(frozen=True, eq=False)
class Residuals:
    """One cut against a twin, at the log rate."""

    torque: Array
    """(N, 6) [N m], motor side, measured less simulated."""
    tool: Array
    """(K, C) of the tool's sensor, beyond what the motor angles explain; (N, 3) [m] of a tracker.
    """
    moving: np.ndarray
    """(N,) bool: samples whose torque counts."""


@dataclass(frozen=True, eq=False)
class Columns:
    """Sensitivities of the residuals of one cut to all parameters, zero where none."""

    torque: Array
    """(N, 6, m)."""
    tool: Array
    """(K, C, m)."""


@dataclass(frozen=True)
class Against:
    """Comparison of a cut with simulations of it."""

    design: RobotDesign
    parameters: Parameters
    cut: MeasuredCut
    sensor: ToolSensor = TRACKER

    @cached_property
    def _tool(self) -> CutComparison:
        return self.sensor.comparison(self.design.model, self.cut)

    def _simulated(self, thetas: Sequence[Array]) -> Iterator[Recording]:
        """Runs of the cut by twins of several parameter vectors, a batch in memory at a time."""
        phases = gear_phases(self.design.model)
        for start in range(0, len(thetas), _BATCH):
            batch = thetas[start : start + _BATCH]
            twins = [self.parameters.individual(theta, phases) for theta in batch]
            yield from self.design.run(twins, self.cut.reference, self.cut.correction)

    def residuals(self, theta: Array) -> Residuals:
        """Residuals against one twin."""
        return self._residuals(next(self._simulated([theta])), theta)

    def linearised(self, theta: Array, *, tool: bool = True) -> tuple[Residuals, Columns]:
        """Residuals against one twin, and their sensitivities around it.

        tool: those of the tool too, which take three quarters of the simulations; else 0.
        """
        parameters = self.parameters
        m, unit = parameters.size, np.eye(parameters.size)
        # For each constant of the friction law and each part of the ripple, of all axes at once:
        # the entry of the first axis, and the entries from one axis to the next.
        friction = {
            (start + part, parts): unit[start + part : start + block.size : parts].sum(axis=0)
            for block in FRICTION
            for start, parts in [(parameters.at(block.name).start, block.size // N_AXES)]
            for part in range(parts)
        }
        known = (HYSTERESIS.name,) * self.design.hysteresis
        names = ("mass", *(*SPRINGS, *BENDING, "lost_motion", *known) * tool)
        springs = [parameters.at(name) for name in names]
        rest = [i for block in springs for i in range(block.start, block.stop)]
        directions = (*friction.values(), *(unit[i] for i in rest))
        variants = [theta, *(theta + _STEP * direction for direction in directions)]
        runs = self._simulated(variants)
        base = next(runs)
        torque = np.zeros((*base.motor_torque.shape, m))
        for (first, parts), run in zip(friction, runs, strict=False):
            change = (run.motor_torque - base.motor_torque) / _STEP
            for axis in range(N_AXES):
                torque[:, axis, first + axis * parts] = change[:, axis]
        residuals = self._residuals(base, theta)
        moved = np.zeros((*residuals.tool.shape, m))
        for entry, run in zip(rest, runs, strict=True):
            moved[:, :, entry] = tool * self._tool.change(base, run) / _STEP
            if entry in range(m)[parameters.at("mass")]:
                torque[:, :, entry] = (run.motor_torque - base.motor_torque) / _STEP
        for block, sensitive in self._tool.by_kinematics().items() if tool else ():
            moved[:, :, parameters.at(block)] = sensitive
        return residuals, Columns(torque, moved)

    def _residuals(self, run: Recording, theta: Array) -> Residuals:
        torque = self.cut.motor_torque - run.motor_torque
        tool = self._tool.residual(run)
        if self.sensor.own(self.cut):
            entries = np.concatenate(
                [theta[self.parameters.at(block.name)] for block in self.sensor.own(self.cut)]
            )
            tool = tool - self.of_sensor @ entries
        return Residuals(torque, tool, self.cut.moving)

    @cached_property
    def of_sensor(self) -> Array:
        """(K, C, e), columns of what is unknown of the sensor itself."""
        columns = self._tool.by_kinematics()
        return np.concatenate([columns[b.name] for b in self.sensor.own(self.cut)], axis=2)
