"""Claims of `armside verify` by name. Only the module of the chosen one is imported."""

from collections.abc import Callable, Sequence
from typing import NamedTuple

from armside.sim.evaluation.check import Table


def _kinematics():
    from . import kinematics

    return kinematics


def _laser():
    from . import laser

    return laser


def _chapter9():
    from . import chapter9

    return chapter9


def _ablations():
    from . import ablations

    return ablations


def _irb1400_laser():
    from . import irb1400_laser

    return irb1400_laser


def _estimation():
    from . import estimation

    return estimation


def _controls():
    from . import controls

    return controls


def _irb1400():
    from . import irb1400

    return irb1400


def _imu_large():
    from . import imu_large

    return imu_large


def _env():
    from . import env

    return env


def _tuning():
    from . import tuning

    return tuning


def _sweep():
    from . import sweep

    return sweep


class Claim(NamedTuple):
    """A function `(seeds) -> Table`, and the number of seeds of its full instance."""

    n_seeds: int
    load: Callable[[], Callable[[Sequence[int]], Table]]
    """Import the function."""


CLAIMS: dict[str, Claim] = {
    "kinematics": Claim(10, lambda: _kinematics().kinematics),
    "laser": Claim(20, lambda: _laser().laser),
    "ablations": Claim(3, lambda: _ablations().ablations),
    "env": Claim(1000, lambda: _env().env),
    "tuning": Claim(100, lambda: _tuning().tuning),
    "tuning-iterations": Claim(100, lambda: _tuning().iterations),
    "sweep": Claim(10, lambda: _sweep().sweep),
    "sweep-memory": Claim(10_000, lambda: _sweep().memory),
    "chapter9": Claim(5, lambda: _chapter9().chapter9),
    "imu": Claim(20, lambda: _irb1400().imu),
    "estimation": Claim(10, lambda: _estimation().estimation),
    "estimation-controls": Claim(10, lambda: _controls().controls),
    "imu-causes": Claim(5, lambda: _irb1400().imu_causes),
    "imu-large": Claim(10, lambda: _imu_large().imu_large),
    "imu-rest": Claim(10, lambda: _irb1400().rest),
    "laser-irb1400": Claim(20, lambda: _irb1400_laser().laser),
    "laser-irb1400-design": Claim(20, lambda: _irb1400_laser().design),
}
