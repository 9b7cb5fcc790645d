"""A search that takes a second: one pose, one update of each trial."""

from armside.scripts.studies.options import TuneCfg
from armside.sim.tuning.objective import Objective, prepare

QUICK = "--pose p1 --speed 60 --payload 40 --episodes 1 --iterations 1"


def objective_at_p1(**options) -> Objective:
    """At p1 and 60 mm/s, with other options of `tune` as given."""
    cfg = TuneCfg(pose="p1", speed=60.0, **options)
    return Objective(cfg.rules, prepare(cfg.rules, range(cfg.episodes), cfg.fixed))
