"""Claims of `armside verify` by name. Only the module of the chosen one is imported."""

from collections.abc import Callable, Sequence
from functools import partial
from typing import NamedTuple

from armside.sim.evaluation.check import Table

from ..shell.errors import unknown

Function = Callable[[Sequence[int]], Table]
"""Called with the seeds."""


class Claim(NamedTuple):
    """Number of seeds of the full instance, and the import of the claim's function."""

    n_seeds: int
    load: Callable[[], Function]


def _load(name: str) -> Function:
    match name:
        case "kinematics":
            from .kinematics import kinematics as claim
        case "urdf":
            from .urdf import urdf as claim
        case "laser":
            from .laser import laser as claim
        case "ablations":
            from .ablations import ablations as claim
        case "env":
            from .env import env as claim
        case "tuning":
            from .tuning import tuning as claim
        case "tuning-iterations":
            from .tuning import iterations as claim
        case "sweep":
            from .sweep import sweep as claim
        case "sweep-memory":
            from .sweep import memory as claim
        case "chapter9":
            from .chapter9 import chapter9 as claim
        case "imu":
            from .irb1400 import imu as claim
        case "estimation":
            from .estimation import estimation as claim
        case "estimation-irb1400":
            from .estimation_arms import irb1400 as claim
        case "estimation-arms":
            from .estimation_arms import arms as claim
        case "estimation-controls":
            from .controls import controls as claim
        case "estimation-gears":
            from .estimation_gears import estimation_gears as claim
        case "long-way":
            from .long_way import long_way as claim
        case "imu-causes":
            from .irb1400 import imu_causes as claim
        case "imu-large":
            from .imu_large import imu_large as claim
        case "imu-rest":
            from .irb1400 import rest as claim
        case "laser-irb1400-poses":
            from .irb1400_poses import poses as claim
        case "laser-irb1400":
            from .irb1400_laser import laser as claim
        case "first-cut":
            from .first_cut import first_cut as claim
        case "first-cut-imu":
            from .first_cut_imu import first_cut_imu as claim
        case "imu-twin":
            from .imu_twin import imu_twin as claim
        case "laser-irb1400-design":
            from .irb1400_laser import design as claim
        case "robots":
            from .robots import robots as claim
        case "robots-design":
            from .robots import design as claim
        case "basis-functions":
            from .basis_functions import basis_functions as claim
        case "knob-free":
            from .knob_free import knob_free as claim
        case _:
            raise unknown("claim", name, CLAIMS)
    return claim


_SEEDS = {
    **{"long-way": 10, "knob-free": 100, "basis-functions": 2},
    **{"kinematics": 10, "urdf": 5, "laser": 20, "ablations": 3, "env": 1000},
    **{"tuning": 100, "tuning-iterations": 100, "sweep": 10, "sweep-memory": 10_000},
    **{"chapter9": 5, "imu": 20, "estimation": 10, "estimation-controls": 10},
    **{"estimation-gears": 10},
    **{"imu-causes": 5, "imu-large": 10, "imu-rest": 10},
    **{"first-cut": 6, "first-cut-imu": 6, "imu-twin": 2},
    **{"estimation-irb1400": 10, "estimation-arms": 2},
    **{"robots": 5, "robots-design": 3},
    **{"laser-irb1400": 20, "laser-irb1400-design": 20, "laser-irb1400-poses": 20},
}
"""A new claim is one entry here and two lines in `_load`."""
CLAIMS = {name: Claim(n_seeds, partial(_load, name)) for name, n_seeds in _SEEDS.items()}
