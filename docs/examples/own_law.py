"""Your own learning law: ten lines. It forgets a little in each iteration instead of filtering."""

from dataclasses import dataclass

from armside.ilc.filters import ZeroPhaseButterworth
from armside.ilc.laws.law import FirstOrderLaw
from armside.sim.cell import LARGE_CELL
from armside.sim.cut.task import CircleTask
from armside.sim.laser.experiment import iterate, prepare
from armside.sim.robot.model import load_model


@dataclass(frozen=True)
class Forgetful(FirstOrderLaw):
    """u_{k+1} = (1 - forget) u_k + gain F e_k; F is a low-pass of the error alone."""

    forget: float = 0.05
    gain: float = 0.6
    cutoff: float = 8.0  # Hz

    def __call__(self, correction, error, /):
        low_pass = ZeroPhaseButterworth(self.cutoff, 0.004)
        return (1.0 - self.forget) * correction + self.gain * low_pass(error)


task = CircleTask(pose=LARGE_CELL.poses["p1"], radius=0.005, speed=0.040)
experiment = prepare(LARGE_CELL, load_model(LARGE_CELL.xml), task, seed=0)
rms = []
for iteration in iterate(experiment, Forgetful(), 5):
    rms.append(iteration.arm.rms)
    worst = abs(iteration.motor_error).max()
    print(f"k = {iteration.trial.k}: motors {1e3 * worst:.1f} mrad, tool {1e6 * rms[-1]:.0f} um")
