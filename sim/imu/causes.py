"""Causes of the acceleration error, each switched off or on by itself."""

from collections.abc import Callable, Iterator
from dataclasses import replace

from ..robot.flexibility import Flexibility
from .differences import Scheme
from .evaluation import Measures
from .experiment import ImuResult, prepare, reprocessed, run_one
from .prediction import Order
from .processing import Compensation
from .specification import ImuExperiment


def causes(
    experiment: ImuExperiment, seed: int, each: Callable[[ImuResult], None] = lambda run: None
) -> Iterator[tuple[str, Measures]]:
    """Measures of the first program with each cause of the error changed, by its name.

    each: called with each run, of which there are two: the others process one of them again.
    """
    cfg = experiment.processing
    base = run_one(experiment, prepare(experiment)[0], seed)
    each(base)
    yield "as chosen", base.measures
    for name, processing in (
        ("processed as in the thesis", cfg.as_in_the_thesis),
        ("sensor delays left in", replace(cfg, accelerometer_delay=0.0, gyroscope_delay=0.0)),
        ("central differences", replace(cfg, scheme=Scheme.CENTRAL)),
        ("mapped, then filtered", replace(cfg, order=Order.MAP_THEN_FILTER)),
        ("both", cfg.best),
        ("gravity by the mean at rest", replace(cfg, compensation=Compensation.MEAN_AT_REST)),
    ):
        yield name, reprocessed(base, processing).measures
    rigid = replace(experiment, flexibility=Flexibility.RIGID)
    stiff = run_one(rigid, prepare(rigid)[0], seed)
    each(stiff)
    yield "rigid robot", stiff.measures
    yield "rigid robot, both", reprocessed(stiff, cfg.best).measures
