"""A search that takes a second: one pose, one update of each trial."""

from armside.scripts.studies.options import TuneCfg
from armside.scripts.studies.study import Pruner, Sampler, open_study
from armside.sim.tuning.objective import Objective, prepare

QUICK = "--pose p1 --speed 60 --payload 40 --episodes 1 --iterations 1 --alone"


def opened(folder, config=None, sampler: Sampler = "tpe", pruner: Pruner = "none"):
    """The study `a` of the database `a.db` in a folder."""
    url, config = f"sqlite:///{folder}/a.db", config or {}
    return open_study(url, "a", config, sampler=sampler, pruner=pruner, seed=0)


def objective_at_p1(**options) -> Objective:
    """At p1 and 60 mm/s, with other options of `tune` as given."""
    cfg = TuneCfg(pose="p1", speed=60.0, **options)
    return Objective(cfg.rules, prepare(cfg.rules, range(cfg.episodes), cfg.fixed))
