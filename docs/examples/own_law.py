"""Your own learning law: ten lines. It forgets a little in each iteration instead of filtering."""

from dataclasses import dataclass

from armside import Cut, FirstOrderLaw, ZeroPhaseButterworth, learn


@dataclass(frozen=True)
class Forgetful(FirstOrderLaw):
    """u_{k+1} = (1 - forget) u_k + gain F e_k; F is a low-pass of the error alone."""

    forget: float = 0.05
    gain: float = 0.6
    cutoff: float = 8.0  # Hz

    def __call__(self, correction, error, /):
        low_pass = ZeroPhaseButterworth(self.cutoff, 0.004)
        return (1.0 - self.forget) * correction + self.gain * low_pass(error)


rms = []
for iteration in learn(Cut(pose="p1"), law=Forgetful(), seed=0):
    rms.append(iteration.tool.rms)
    worst = abs(iteration.motor_error).max()
    print(f"k = {iteration.k}: motors {1e3 * worst:.1f} mrad, tool {1e6 * rms[-1]:.0f} um")
