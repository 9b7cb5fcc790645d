"""Predicted tool error of a corrected first run, with an interval.

    r^2 = e^2 + b^2 (s^2 - e^2) + (a h)^2        expected and interval: r (middle, low, high)
    upper end, of ten cuts by the tracker: high (r^2 + c^2 (h^2 - h0^2))^1/2 where h > h0

e is the error inside the twin, s the root mean square error of the individuals around it, h the
residual of cuts that the twin was not identified from. a, b and the factors were fitted to cuts of
individuals among `DEVELOPMENT` of `make claims NAME=first-cut`, which are not the judged ones.
Errors of one individual resemble each other.

By the tracker the factors are such that 90 % of the errors of each are inside those of the others:
fourteen cuts each of 1001, 1003, 1004, 1006, 1007, 1009, 1010 and 1012. Of fewer cuts h, the
residual of twins of one cut less, says more than the twin leaves. By an IMU and ten cuts the
geometry that it does not see makes individuals differ more: log(error / r) of sixteen cuts each of
all twelve has a standard deviation of 0.31 within an individual and 0.18 between them, and low and
high are those of a normal prediction for another individual (Student's t, eleven degrees of
freedom, for the part between). Those with a scanned coupon are made likewise of twelve cuts each of
1001 to 1006 (`make claims NAME=scan-twin-development`): by coupon alone individuals differ by 0.27,
and cuts of one by 0.38.

The individuals are drawn from the posterior of the parameters. What bends in a way that no
parameter knows shows as the residual of held-out cuts: the larger it is, the more the compliances
of the members differ. Damping, which is not identified, has the spread of the production line.

What leaves more of the held-out cuts than usual, h0, is a robot of other physics: c was chosen on
the first cuts of individual 8000 with each of five effects of `armside.sim.robot.alien` that twins
do not know, or know in part. The correction is used or not by the upper end without that.

The covariance of identification is that of its linearised model. A robot differs from that model in
what no parameter stands for, such as a shifted centre of mass, and the estimates of mass, ripple
and stiffness take it in: `standard_deviation` is wider, at most that of the prior.
"""

from collections.abc import Mapping, Sequence
from dataclasses import dataclass, field

import numpy as np

from armside.arrays import Array

from ..laser.experiment import Experiment
from ..robot.individual import Individual
from .correction import learn_in_twin, twin_error
from .parameters import Parameters
from .recordings import TwinSensor
from .simulation import RobotDesign, motor_path

WIDER = 4.0
"""Smallest whole factor with which, of the identified parameters of individuals 1001 and 1004, four
cuts by tracker and by IMU, more than 92 % lie within 1.96 standard deviations by each sensor.
Individuals from 2001 on, of which nothing was chosen, test it."""
_IDENTIFIED = 0.7
"""Standard deviation of the linearised model over that of the prior, up to which the cuts tell of a
parameter. ESTIMATE."""
SAMPLES_AT_ONCE = 20_000
"""Samples of the log of all runs of one rollout together: 80 s of motion, 250 MB."""
_RESIDUAL, _SPREAD = 0.3, 0.4
"""a and b. Individuals differ from the twin by less than the draws: b < 1."""

_UNUSUAL, _USUAL = 1.4, 5e-6
"""c, and h0 [m]: the median of individuals 1004, 1011, 1017 and 8000."""


def standard_deviation(parameters: Parameters, covariance: Array) -> Array:
    """(m,), of the parameters of a robot about its twin's, for covariance (m, m)."""
    return np.minimum(WIDER * np.sqrt(np.diag(covariance)), parameters.standard_deviation)


def is_identified(parameters: Parameters, covariance: Array) -> np.ndarray:
    """(m,) bool: the cuts tell of a parameter, beyond the prior."""
    return np.sqrt(np.diag(covariance)) <= _IDENTIFIED * parameters.standard_deviation


_FACTORS: Mapping[TwinSensor, Mapping[int, tuple[float, float, float]]] = {
    "tracker": {10: (0.53, 1.0, 1.7), 4: (0.36, 0.84, 1.42), 2: (0.24, 0.5, 0.94)},
    "imu": {10: (0.57, 1.0, 1.92)},
    "imu and scan": {14: (0.76, 1.33, 2.34)},
    "scan": {8: (0.60, 1.43, 3.37)},
}
"""Lower end of the interval of 90 %, expected error and upper end, over r; by the sensor and the
number of cuts that the twin was identified from: by IMU and scan six and the eight of a coupon."""


@dataclass(frozen=True, kw_only=True)
class Evidence:
    """What a twin was identified from, and what it leaves of a cut that it was not."""

    sensor: TwinSensor
    n_cuts: int
    residual: float
    """[m]."""


@dataclass(frozen=True, kw_only=True)
class FirstCutPrediction:
    """Errors of the tool to expect of a first run [m]."""

    uncorrected: float
    """Without correction, by the twin."""
    inside: float
    """With correction, inside the twin."""
    expected: float
    low: float
    high: float
    """With correction, in the robot: expectation and interval of 90 %."""
    high_of_type: float
    """Upper end for a robot of the type, which is not above `high`."""
    calibrated: bool
    """The interval was fitted to twins like this one."""


def factors(evidence: Evidence) -> tuple[float, float, float]:
    """Lower end, expectation and upper end over r."""
    known = _FACTORS[evidence.sensor]
    # Of the largest number of cuts that is not above this twin's; of the most below all.
    return known[max((n for n in known if n <= evidence.n_cuts), default=max(known))]


def predicted(
    uncorrected: float, inside: float, around: Array, evidence: Evidence
) -> FirstCutPrediction:
    """Prediction from errors in the twin and around it, (n,), all in m."""
    spread = max(float(np.mean(around**2)) - inside**2, 0.0)
    variance = inside**2 + _SPREAD**2 * spread + (_RESIDUAL * evidence.residual) ** 2
    r = float(np.sqrt(variance))
    low, middle, high = factors(evidence)
    by_ten = evidence.sensor == "tracker" and evidence.n_cuts >= max(_FACTORS["tracker"])
    unusual = _UNUSUAL**2 * max(evidence.residual**2 - _USUAL**2, 0.0) if by_ten else 0.0
    return FirstCutPrediction(
        uncorrected=uncorrected,
        inside=inside,
        expected=middle * r,
        low=low * r,
        high=high * float(np.sqrt(variance + unusual)),
        high_of_type=high * r,
        calibrated=evidence.n_cuts >= min(_FACTORS[evidence.sensor]),
    )


@dataclass(frozen=True, kw_only=True, eq=False)
class Corrected:
    """Correction for the first run of a cut."""

    correction: Array
    """(N, 6) [rad], arm side; of a program (N, 3) [m]. Zero where the twin is not trusted."""
    learned: Array = field(repr=False)
    """As `correction`, what the twin learned, trusted or not."""
    motor_path: Array = field(repr=False)
    """(N, 6) [rad], arm side: the twin's motors with the correction in use."""
    prediction: FirstCutPrediction
    reason: str | None
    """Why the twin's correction is not used; None where it is."""

    @property
    def trusted(self) -> bool:
        """The twin's correction is used."""
        return self.reason is None


LARGEST_FRACTION = 0.3
"""`high_of_type` over the error without correction, from which on none is used."""


def correct(
    design: RobotDesign,
    individual: Individual,
    around: Sequence[Individual],
    experiment: Experiment,
    evidence: Evidence,
) -> Corrected:
    """Learn the motion of an experiment inside a twin, and predict what its correction leaves by
    individuals that commissioning cannot tell from it."""
    learned, rms = learn_in_twin(design, individual, experiment)
    reference, spread = experiment.loaded.reference, list[float]()
    at_once = max(1, int(SAMPLES_AT_ONCE / len(reference)))
    for i in range(0, len(around), at_once):
        runs = design.run(around[i : i + at_once], reference, learned)
        spread += [twin_error(experiment, run) for run in runs]
    prediction = predicted(float(rms[0]), float(rms.min()), np.array(spread), evidence)
    reason = objection(prediction)
    used = learned if reason is None else np.zeros_like(learned)
    return Corrected(
        correction=used,
        learned=learned,
        motor_path=motor_path(design.run([individual], reference, used)[0]),
        prediction=prediction,
        reason=reason,
    )


def objection(prediction: FirstCutPrediction) -> str | None:
    """Why a correction with that prediction is not used; None where it is."""
    if not np.isfinite(prediction.high):
        return "the twin becomes unstable with its correction"
    fraction = prediction.high_of_type / prediction.uncorrected
    if fraction > LARGEST_FRACTION:
        return f"up to {100 * fraction:.0f} % of the error would be left"
    return None
