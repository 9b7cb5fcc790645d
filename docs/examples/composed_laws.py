"""Laws of `armside.ilc.laws` that are composed in Python, for `armside learn --laws`."""

import numpy as np

from armside.ilc import (
    FirstOrder,
    Guarded,
    Heuristic,
    LinearPlant,
    RegularisedInverse,
    Scheduled,
    SystemMatrix,
    ZeroPhaseButterworth,
)
from armside.ilc.laws.first_order import Blend, MatrixGain, PType
from armside.ilc.laws.norm_optimal import RecordOptimal
from armside.ilc.laws.wrappers import BySegment, Simulated


class Falling(Scheduled):
    """Gain 0.9, then 0.5."""

    def __init__(self, sample_time, cutoff, delta=4):
        Q = ZeroPhaseButterworth(cutoff, sample_time)
        super().__init__(laws=tuple(Heuristic(Q=Q, gamma=g, delta=delta) for g in (0.9, 0.5)))


class Along(FirstOrder):
    """Gain that rises from 0.3 to 0.9 along the record."""

    def __init__(self, reference, sample_time, cutoff, delta=4):
        weights = np.linspace(0.3, 0.9, len(reference))[:, None]
        L = Blend(filters=(PType(gamma=1.0, delta=delta),), weights=weights)
        super().__init__(L=L, Q=ZeroPhaseButterworth(cutoff, sample_time))


class Coupled(FirstOrder):
    """Gain matrix: 0.9 on the diagonal and a little between motors."""

    def __init__(self, reference, sample_time, cutoff, delta=4, between=0.02):
        n = reference.shape[1]
        L = MatrixGain(gamma=(0.9 - between) * np.eye(n) + between, delta=delta)
        super().__init__(L=L, Q=ZeroPhaseButterworth(cutoff, sample_time))


class Backtracking(Guarded):
    """Heuristic law that goes back to its best iteration where the error grows."""

    def __init__(self, reference, sample_time, cutoff, gamma=0.9, delta=4):
        law = Heuristic(Q=ZeroPhaseButterworth(cutoff, sample_time), gamma=gamma, delta=delta)
        super().__init__(law=law, weight=(1.0,) * reference.shape[1])


class Halves(BySegment):
    """Two halves of a record, each of which ends its learning by itself."""

    def __init__(self, reference, sample_time, cutoff, delta=4):
        n = len(reference)
        second = np.clip((np.arange(n) - 0.45 * n) / (0.1 * n), 0.0, 1.0)
        weight = np.stack((1.0 - second, second), axis=1).astype(np.float64)
        super().__init__(
            law=Heuristic(Q=ZeroPhaseButterworth(cutoff, sample_time), gamma=0.9, delta=delta),
            weight=weight,
            judged=((0, n // 2), (n // 2, n)),
            size_of=lambda error: np.sqrt(np.square(error).mean(axis=0)),
        )


class Regularised(RegularisedInverse):
    """Regularised inverse of the model's frequency response, each motor its own."""

    def __init__(self, reference, model, sample_time, cutoff):
        ones = (1.0,) * reference.shape[1]
        G = SystemMatrix.diagonal([model] * len(ones))
        shape = {"sample_time": sample_time, "cutoff": cutoff}
        super().__init__(G=G, output_weight=ones, input_size=ones, **shape)


class OnTheRecord(RecordOptimal):
    """Norm-optimal on the finite record, from the model's frequency response."""

    def __init__(self, reference, model, sample_time, cutoff):
        ones = (1.0,) * reference.shape[1]
        G, F = SystemMatrix.diagonal([model] * len(ones)), ZeroPhaseButterworth(cutoff, sample_time)
        super().__init__(G=G, F=F, output_weight=ones, input_size=ones)


class BetweenRuns(Simulated):
    """Ten updates of the heuristic law on the model between two runs."""

    def __init__(self, reference, model, sample_time, cutoff, delta=4):
        simulated = LinearPlant(T_u=model, reference=reference)
        super().__init__(
            simulation=lambda correction: reference - simulated.run(correction),
            law=Heuristic(Q=ZeroPhaseButterworth(cutoff, sample_time), gamma=0.9, delta=delta),
            weight=(1.0,) * reference.shape[1],
        )
