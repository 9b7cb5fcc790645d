"""First runs of motions that nothing was learned on: another edge of a box, another speed.

L1: C.-Y. Lin, W. Chen, M. Tomizuka, IEEE CDC 2016, a payload of 210 kg. N1: J. Asensio, W. Chen,
M. Tomizuka, ASME J. Dyn. Syst. Meas. Control 136(3) 031002, 2014. There a model of the correction
is learned, here a twin of the robot: from uncorrected runs under a tracker.
"""

from collections.abc import Sequence
from dataclasses import dataclass, replace

import numpy as np

from armside.arrays import Array

from ..cell import TOOL_QUATERNION, ToolPose
from ..evaluation.motion_error import accelerations, motion_error
from ..laser.experiment import Experiment, Pass, prepare
from ..laser.loop import learn
from ..laser.strokes import Strokes
from ..motion.timing import PathLimits
from ..twin.commission import commission
from ..twin.recordings import measured

PAYLOAD = 210.0
"""[kg], as in L1."""
FACE = (1.6, 0.1, 1.2)
"""[m], middle of a face of the box, which lies across z. ESTIMATE"""
HALF = 0.15
"""[m], of an edge: three strokes of 0.1 m, whose edges in L1 have 8 to 10 points."""
EDGES = (
    ((-HALF, -HALF), (HALF, -HALF)),
    ((HALF, -HALF), (HALF, HALF)),
    ((HALF, HALF), (-HALF, HALF)),
)
"""[m], trained; the edge that is not lies across the face."""
UNSEEN = ((-0.7 * HALF, -0.7 * HALF), (0.7 * HALF, 0.7 * HALF))
HEAVY = PathLimits(acceleration=2.5, jerk=200.0)
"""Below torque limits on these edges with 210 kg, as found on individual 0; 8 m/s^2 in L1."""
LINE = ((-0.4, 0.0), (0.4, 0.0))
"""[m], of 80 cm in x; 60 to 100 cm in N1."""
LINE_LIMITS = PathLimits(acceleration=2.0, jerk=100.0)
TRAINED, TESTED = (0.4, 0.6, 0.8), (0.5, 0.7)
"""[m/s], of the line. Speeds and accelerations of N1 are not printed. ESTIMATE"""


def edge(individual: int, ends: Sequence[tuple[float, float]]) -> Strokes:
    """An edge in three strokes, with the payload of L1."""
    first, last = np.array(ends)
    places = np.linspace(first, last, 4)
    return Strokes(
        robot="large",
        pose=ToolPose(FACE, TOOL_QUATERNION),
        corners=tuple((float(x), float(y)) for x, y in places),
        period=1.2,
        payload=PAYLOAD,
        speed=0.72,
        limits=HEAVY,
        individual=individual,
    )


def line(individual: int, speed: float) -> Strokes:
    """The line of N1, without its payload."""
    return Strokes(
        robot="large",
        pose=ToolPose(FACE, TOOL_QUATERNION),
        corners=LINE,
        period=5.0,
        speed=speed,
        limits=LINE_LIMITS,
        individual=individual,
    )


def first_runs(
    trained: Sequence[Strokes], tested: Sequence[Strokes], seed: int
) -> list[tuple[Experiment, Pass, Pass]]:
    """Each tested motion without a correction and with that of a twin of the trained ones."""
    cuts = []
    for i, cut in enumerate(trained):
        experiment = prepare(cut, seed=seed)
        plain = np.zeros_like(experiment.loaded.reference)
        cuts.append(measured(experiment.plant.run(plain), f"motion {i + 1}"))
    twin = commission(cuts, payload=trained[0].payload, checked=False).twin
    found = []
    for cut in tested:
        nominal = prepare(replace(cut, individual=None, friction_spread=0.0))
        correction = twin.correction_of(nominal).correction
        experiment = prepare(cut, seed=seed)
        runs = (experiment.plant.run(u) for u in (np.zeros_like(correction), correction))
        found.append((experiment, *runs))
    return found


@dataclass(frozen=True)
class UnseenEdge:
    """L1 on the large robot: the twin of three edges makes the first run of a fourth."""

    individual: int

    cost = 120.0

    def run(self) -> dict[str, Array]:
        """Without a correction and with the twin's, (2,): `position` and `peak` [m] of the signed
        error along the path less its mean, `acceleration` [m/s^2] of its RMS; `limits`, number
        reached."""
        trained = [edge(self.individual, ends) for ends in EDGES]
        ((experiment, *runs),) = first_runs(
            trained, [edge(self.individual, UNSEEN)], self.individual
        )
        errors = [along(experiment, run) for run in runs]
        return {
            "position": np.array([rms(position) for position, _ in errors]),
            "peak": np.array([np.abs(position).max() for position, _ in errors]),
            "acceleration": np.array([rms(acceleration) for _, acceleration in errors]),
            "limits": np.array([len(run.recording.limits_hit) for run in runs]),
            "speed": np.array(experiment.motion.cuts[0].reached_speed),
        }


def along(experiment: Experiment, run: Pass) -> tuple[Array, Array]:
    """(M,) errors along a straight path at 1 kHz: position [m] less its mean, acceleration
    [m/s^2]."""
    truth = run.recording.truth
    truth = truth.every(round(1e-3 / float(truth.time[1])))
    time, h, motion = truth.time, float(truth.time[1]), experiment.motion
    before, now, after = (motion.position_at(time + dt) for dt in (-h, 0.0, h))
    direction = now[-1] - now[0]
    direction /= np.linalg.norm(direction)
    position = (truth.tool_position - now) @ direction
    wanted = (after - 2.0 * now + before) / h**2
    acceleration = accelerations(truth, experiment.loaded.model.mj) - wanted
    return position - position.mean(), acceleration @ direction


@dataclass(frozen=True)
class UnseenSpeed:
    """N1 on the large robot: the twin of three speeds makes the first run at two others."""

    individual: int

    cost = 120.0

    def run(self) -> dict[str, Array]:
        """(2,) [m] by tested speed, RMS of the tool's position while it moves, static part in:
        `basic` without learning, `twin`, and `step` after one update by the estimate."""
        tested = [line(self.individual, speed) for speed in TESTED]
        trained = [line(self.individual, speed) for speed in TRAINED]
        found = dict[str, list[float]](basic=[], twin=[], step=[])
        for (experiment, *runs), cut in zip(
            first_runs(trained, tested, self.individual), tested, strict=True
        ):
            for name, run in zip(("basic", "twin"), runs, strict=True):
                found[name].append(moving(experiment, run))
            *_, last = learn(cut, measure="estimate", iterations=1, seed=self.individual)
            found["step"].append(last.motion_error.moving_tcp_rms)
        return {name: np.array(values) for name, values in found.items()}


def moving(experiment: Experiment, run: Pass) -> float:
    """RMS [m] of the tool's position while it is to move."""
    known = experiment.motion, run.recording.truth, experiment.loaded.model.mj
    return motion_error(*known).moving_tcp_rms


def rms(signal: Array) -> float:
    """Root of the mean square."""
    return float(np.sqrt(np.mean(signal**2)))
