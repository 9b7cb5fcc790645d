"""Bands and individuals of `armside reproduce papers`, stated before the first judged run.

Bands are our choice around one measured session of each paper (docs/papers.md). Assumed numbers
are chosen on the individuals of development; only those of judgement are reported.
"""

from collections.abc import Mapping

from .report import Band

DEVELOPMENT = tuple(range(3))
JUDGEMENT = tuple(range(100, 110))
"""Seeds of individuals: what no paper prints is drawn with them."""

BANDS: Mapping[str, Band] = {
    "bench-first": Band("first run, RMS [mrad]", "0.354", 0.3009, 0.4071),
    "bench-first-peak": Band("first run, peak [mrad]", "0.91", 0.7735, 1.0465),
    "bench-ten": Band("run 10, right model, worst of three laws, RMS [mrad]", "0.058", high=0.10),
    "bench-wrong": Band(
        "stated errors of 15 % after which torque M > reference > torque L does not hold, of 6",
        "0.50 > 0.23 > 0.15 of the first run, error not printed",
        high=0,
    ),
    "bench-wrong-load": Band(
        "run 10, worst stated error, torque L over first run", "0.15", high=0.30
    ),
    "T3-dkf": Band("DKF, 20 % off (k, Jl opposite) over right", "1.7", 1.4, 2.8),
    "T3-kkf": Band("KKF with gyroscope over without", "0.58", high=0.95),
    "T1-acceleration-motor": Band("acceleration, motor side, last / first", "1.40", 1.1, 1.7),
    "T1-acceleration-load": Band("acceleration, estimate, last / first", "0.48", high=0.60),
    "T1-tcp": Band("TCP, estimate, last / first, static part in", "0.49", high=0.50),
    "T1-tcp-order": Band(
        "individuals whose TCP is no better by the estimate than by motors", "0 of 1", high=0
    ),
    "T1-rest": Band("acceleration at rest, motor side, last / first", "2.65", 1.5),
    "T1-peak": Band("TCP peak, estimate, last / first", "0.40", high=0.50),
    "T1-peak-motor": Band("TCP peak, motor side, last / first", "1.00", 0.8),
    "T1-two-stage-motor": Band("acceleration, two-stage M, last / first", "1.40", 1.1, 1.7),
    "T1-two-stage-load": Band("acceleration, two-stage L, last / first", "0.48", high=0.60),
    "T1-two-stage-tcp": Band("TCP, two-stage L, last / first, static part in", "0.49", high=0.50),
    "T1-two-stage-peak": Band("TCP peak, two-stage L, last / first", "0.40", high=0.50),
    "T1-two-stage-rest": Band("acceleration at rest, two-stage M, last / first", "2.65", 1.5),
    "T2-smoother": Band("smoother over motor angles, position, static part in", "0.42", high=0.42),
    "T2-online": Band("causal filter over motor angles, position", "0.55", high=0.55),
    "T2-doubled": Band(
        "smoother over motor angles, stiffness and damping doubled in the model", "0.53", high=0.53
    ),
    "T2-doubled-loss": Band("smoother, doubled model over nominal", "1.27", high=1.30),
    "L1": Band("position along the path, RMS, unseen edge over uncorrected", "0.47", high=0.47),
    "L1-peak": Band("its peak over that of the uncorrected run", "0.56", high=0.56),
    "L1-acceleration": Band("acceleration along the path, the same", "0.70", high=0.70),
    "N1": Band("share of one learning step, tool position, moving, unseen speed", "0.70", 0.70),
}
"""Medians over the individuals, ratios where the robot is another one."""
