"""Laws for several outputs and inputs, and the guard around them."""

import numpy as np
import pytest

from armside.ilc.filters import ZeroPhaseButterworth
from armside.ilc.laws.first_order import FirstOrderLaw
from armside.ilc.laws.model_based import RegularisedInverse, tapered
from armside.ilc.laws.norm_optimal import RecordOptimal
from armside.ilc.laws.wrappers import Guarded, JointSpace

N, STEP = 400, 0.004
MIX = np.array([[1.0, 0.3, 0.2], [-0.2, 0.8, 0.5]])


class Lag:
    """Two outputs of three inputs through a lag of 12 Hz and 12 ms of delay."""

    def __init__(self, mix=MIX):
        self.mix = mix

    def response(self, omega):
        s = 1j * np.asarray(omega) / STEP
        one = np.exp(-0.012 * s) / (1.0 + s / (2 * np.pi * 12.0))
        return one[:, None, None] * self.mix

    def run(self, u):
        U = np.fft.rfft(u, 2 * N, axis=0)
        Y = (self.response(2 * np.pi * np.fft.rfftfreq(2 * N)) @ U[:, :, None])[:, :, 0]
        return np.fft.irfft(Y, 2 * N, axis=0)[:N]


def reference():
    t = np.arange(N) / N
    bump = np.sin(np.pi * np.clip((t - 0.15) / 0.7, 0, 1)) ** 2
    return np.stack([bump * np.sin(6 * np.pi * t), bump * np.cos(4 * np.pi * t)], axis=1)


def inverse(**options):
    return RegularisedInverse(
        **{
            "G": Lag(),
            "sample_time": STEP,
            "cutoff": 20.0,
            "output_weight": (1.0, 1.0),
            "input_size": (1.0, 1.0, 1.0),
            "regularisation": 1e-4,
        }
        | options
    )


def optimal(**options):
    return RecordOptimal(
        G=Lag(),
        F=ZeroPhaseButterworth(20.0, STEP),
        output_weight=(1.0, 1.0),
        input_size=(1.0, 1.0, 1.0),
        correction_weight=1e-6,
        change_weight=1e-4,
        **options,
    )


def learn(law, plant, iterations):
    u, sizes = np.zeros((N, 3)), []
    for _ in range(iterations + 1):
        e = reference() - plant.run(u)
        sizes.append(np.sqrt(np.square(e).mean()))
        u = law(u, e)
    return u, np.array(sizes)


@pytest.mark.parametrize("make", [inverse, optimal])
def test_a_known_plant_is_learned_in_a_few_iterations(make):
    _, sizes = learn(make(), Lag(), 5)
    assert sizes[-1] < 0.02 * sizes[0]


def test_redundant_inputs_take_the_smallest_correction():
    u, _ = learn(inverse(), Lag(), 5)
    kernel = np.linalg.svd(MIX)[2][-1]
    assert np.abs(u @ kernel).max() < 1e-3 * np.abs(u).max()


def test_a_plant_within_a_third_of_the_model_contracts_and_a_reversed_one_does_not():
    law = inverse()
    omega = np.linspace(0.0, 2 * np.pi * 15.0 * STEP, 50)
    gain = law.contraction(omega, Lag(1.3 * MIX))
    # In the kernel nothing moves, so the norm is Q there: look at what the outputs do.
    assert gain.max() <= 1.0 + 1e-9
    _, sizes = learn(law, Lag(1.3 * MIX), 5)
    assert (np.diff(sizes) < 0.0).all()
    assert law.contraction(omega, Lag(-MIX)).max() > 1.5


def test_corrections_stay_within_their_limit():
    u, _ = learn(inverse(limit=0.1), Lag(), 3)
    assert np.abs(u).max() <= 0.1


def test_the_extension_has_no_step():
    ramp = np.linspace(0.0, 1.0, 50)[:, None]
    extended = tapered(ramp)
    assert np.abs(np.diff(np.vstack((extended, extended[:1])), axis=0)).max() < 0.05


class Bold(FirstOrderLaw):
    """Goes the wrong way as soon as there is a correction."""

    def __call__(self, correction, error):
        return correction + 0.8 * np.pad(error, ((0, 0), (0, 1))) * (-1 if correction.any() else 1)


def test_the_guard_returns_to_the_best_and_then_stops():
    plant = Lag(np.array([[1.0, 0.0, 0.0], [0.0, 1.0, 0.0]]))
    guarded = Guarded(law=Bold(), weight=(1.0, 1.0), tolerance=1.0)
    u, memory, sizes = np.zeros((N, 3)), None, []
    for _ in range(12):
        e = reference() - plant.run(u)
        sizes.append(guarded.size(e))
        u, memory = guarded.step(u, e, memory)
    assert memory.setbacks == 3
    assert sizes[-1] == pytest.approx(min(sizes))
    assert max(sizes[2:]) <= 2.0 * sizes[0]


def test_joint_space_maps_the_tool_error_to_motors_by_the_inverse_jacobian():
    class Identity(FirstOrderLaw):
        def __call__(self, correction, error):
            return correction + error

    J = np.array([[2.0, 0.0], [0.0, 4.0], [0.0, 0.0]])
    law = JointSpace(law=Identity(), inverse=np.linalg.pinv(J))
    e = np.array([[1.0, 1.0, 9.0]])
    assert law(np.zeros((1, 2)), e) == pytest.approx(np.array([[0.5, 0.25]]))
    with pytest.raises(ValueError, match="2 motors"):
        law.check(1, 6)


@pytest.mark.parametrize(
    ("options", "said"),
    [
        ({"cutoff": 125.0}, "cutoff"),
        ({"gamma": 2.0}, "gamma"),
        ({"regularisation": 0.0}, "regularisation"),
        ({"output_weight": (0.0, 0.0)}, "output_weight"),
        ({"input_size": (1.0, 0.0, 1.0)}, "input_size"),
        ({"limit": 0.0}, "limit"),
    ],
)
def test_an_inverse_refuses_options_out_of_range_by_name(options, said):
    with pytest.raises(ValueError, match=said):
        inverse(**options)
