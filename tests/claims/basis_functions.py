"""Basis functions learned on three contours, used on ten unseen ones of each individual, at p1.

Three contours of the large robot are learned from a laser tracker, and parameters of basis
functions of the reference are fitted to their corrections. Ten other contours at the same pose are
then cut once, without learning runs: by the basis functions, by a ridge regression from windows of
the reference fitted to the same three corrections, and by a twin commissioned from four cuts.
"Left" is the true tool RMS over that of a run without correction.

Basis and weights were chosen on `DEVELOPMENT`, with contours of the seed 5; seeds from 0 judge.
"""

from collections.abc import Iterator, Sequence
from dataclasses import replace

import numpy as np

from armside.arrays import Array
from armside.ilc.identification.friction import stops
from armside.ilc.laws.transfer import across, correction_of, derivatives, fitted, led
from armside.sim.instruments.imu import ImuCfg
from armside.sim.laser.experiment import Experiment, prepare, true_tool_error
from armside.sim.laser.specification import Cut
from armside.sim.robot.spread import Drawn
from armside.sim.robot.virtual_robot import LOG_PERIOD
from armside.sim.twin.commission import commission

from ._engine import Check, Claim, Row, Rows, Tally, all_hold
from ._estimates import BY_TRACKER, Case
from ._tasks import SHAPES
from ._twins import commissioning_cuts

DEVELOPMENT = (1001,)
"""Individuals that the basis was chosen on."""
LEARNED = (("circle", 0.010, 0.04), ("square", 0.030, 0.03), ("slot", 0.050, 0.06))
"""Shape, width [m] and speed [m/s] of the contours that are learned."""
N_UNSEEN, UPDATES, CUTS = 10, 5, 4
WIDTHS, LEADS = (3e-6, 3e-5, 3e-4, 3e-3, 3e-2), (0, 5, 10)
"""Of the stop operators [rad], and of their effect on the correction [samples]: ESTIMATES."""
RIDGE = 0.03
WINDOW = tuple(range(-20, 21, 4))
"""[samples] around each, that the ridge regression sees."""
LEFT = {
    "basis functions": "left: basis functions",
    "ridge regression of windows": "left: ridge regression",
    "twin of four cuts": "left: twin",
}
"""Columns by what corrects the run."""
REPORTED = 0.33
"""Upper end of what a ridge regression left near its pose in a trial."""


def basis(reference: Array) -> Array:
    """(N, 6, p): reference, three derivatives and hysteresis of all motors, for each motor."""
    moved = (reference - reference[0])[:, :, None]
    smooth = np.concatenate((moved, derivatives(reference, LOG_PERIOD, 3)), axis=2)
    friction = led(stops(reference, WIDTHS), LEADS)
    return across(np.concatenate((smooth, friction), axis=2))


def windows(reference: Array) -> Array:
    """(N, 6, p): positions and directions of all motors around each sample, for each motor."""
    moved = (reference - reference[0])[:, :, None]
    speed = np.gradient(reference, LOG_PERIOD, axis=0)[:, :, None]
    direction = np.where(np.abs(speed) > 1e-4, np.sign(speed), 0.0)
    return across(np.concatenate((led(moved, WINDOW), led(direction, WINDOW)), axis=2))


def cut(shape: str, width: float, speed: float, robot: Drawn) -> Cut:
    return Cut(contour=SHAPES[shape](width), speed=speed, individual=robot, imu=ImuCfg())


def unseen(seed: int, count: int = N_UNSEEN) -> list[tuple[str, float, float]]:
    """Contours 8 to 60 mm wide at 20 to 80 mm/s."""
    rng = np.random.default_rng(seed)
    found = list[tuple[str, float, float]]()
    for _ in range(count):
        shape = str(rng.choice(list(SHAPES)))
        width = float(np.exp(rng.uniform(np.log(0.008), np.log(0.06))))
        found.append((shape, width, float(rng.uniform(0.02, 0.08))))
    return found


def corrections(robot: Drawn, contours: Sequence[tuple[str, float, float]]) -> list[Array]:
    """Corrections of the best run of each contour by the tracker; springs identified once."""
    found, known = list[Array](), None
    for contour in contours:
        case = Case(cut=cut(*contour, robot), seed=robot.number)
        output, learning = case.from_tool(UPDATES, BY_TRACKER, known)
        known = output.known.parameters
        found.append(min(learning, key=lambda one: one.tool.rms).correction)
    return found


def individual(seed: int) -> Iterator[Row]:
    """A row for each unseen contour."""
    robot, learned = Drawn(seed), [prepare(cut(*one, Drawn(seed))) for one in LEARNED]
    references = [one.loaded.reference for one in learned]
    targets = corrections(robot, LEARNED)
    fits = [(of, fitted([of(r) for r in references], targets, RIDGE)) for of in (basis, windows)]
    twin = commission(commissioning_cuts(robot, CUTS)).twin
    for contour in unseen(seed):
        experiment = prepare(cut(*contour, robot), seed=seed)
        r = experiment.loaded.reference
        first = error(experiment, np.zeros_like(r))
        tried = [correction_of(of(r), parameters) for of, parameters in fits]
        bare = replace(cut(*contour, robot), individual=None, imu=None)
        tried.append(twin.correction(bare).correction)
        left = [error(experiment, u) / first for u in tried]
        shape, width, speed = contour
        yield {
            **{"individual": seed, "contour": shape},
            **{"width [mm]": 1e3 * width, "speed [mm/s]": 1e3 * speed, "without [um]": 1e6 * first},
            **dict(zip(LEFT.values(), left, strict=True)),
        }


def error(experiment: Experiment, correction: Array) -> float:
    """True tool RMS of a run [m]."""
    return true_tool_error(experiment.motion, experiment.plant.run(correction)).rms


def run(seed: int, _: Tally) -> Iterator[Row]:
    yield from individual(seed)


def checks(rows: Rows) -> Iterator[Check]:
    left = rows.of(*LEFT.values())
    median, worst = np.median(left, axis=0), left.max(axis=0)
    words = "; ".join(f"{n} {m:.3f}, {w:.3f}" for n, m, w in zip(LEFT, median, worst, strict=True))
    statement = f"left, median and worst: {words}"
    yield Check("", statement, "", float(median[0]), high=REPORTED)
    worse = "no unseen contour is worse by basis functions than without"
    yield all_hold(worse, left[:, 0] <= 1)


CLAIM = Claim(
    title="Unseen contours cut once: basis functions of three contours, a regression and a twin",
    seeds=2,
    run=run,
    checks=checks,
)
