"""The law without design variables, and the impulse response that it identifies."""

from dataclasses import replace

import numpy as np
import pytest

from armside.ilc import ZeroPhaseButterworth, learn
from armside.ilc.identification.impulse_response import (
    Sums,
    correlation_time,
    impulse_response,
)
from armside.ilc.laws.knob_free import KnobFree, expected_best
from armside.ilc.models.linear_plant import LinearPlant
from armside.ilc.models.system import System
from armside.ilc.models.system_matrix import SystemMatrix
from armside.ilc.models.two_mass import TwoMassLoop

from .signals import bump, error_norms

T_S = 0.004
ARX = System(np.array([0, 0, 0, 0, 0, 0.5083]), np.array([1, -0.4884]), T_S)
LAW = KnobFree(Q=ZeroPhaseButterworth(25.0, T_S))


def noisy(n_samples: int, noise: float, seed: int = 0):
    rng = np.random.default_rng(seed)
    u = rng.standard_normal((n_samples, 2))
    return u, ARX.simulate(u) + noise * rng.standard_normal(u.shape)


def test_the_impulse_response_lies_within_its_uncertainty():
    truth = ARX.impulse(40)
    inside = []
    for seed in range(20):
        found = impulse_response(Sums.none(40).with_records(*noisy(300, 0.2, seed)))
        inside.append(abs(found.taps - truth) <= 1.96 * np.sqrt(np.diag(found.covariance)))
    assert 0.90 <= np.mean(inside) <= 0.99


def test_without_noise_the_impulse_response_is_exact():
    u, y = noisy(200, 0.0)
    found = impulse_response(Sums.none(40).with_records(u, y))
    np.testing.assert_allclose(found.taps, ARX.impulse(40), atol=1e-5)
    np.testing.assert_allclose(found.simulate(u), y, atol=1e-4)


def test_records_without_input_have_no_impulse_response():
    with pytest.raises(ValueError, match="input and output are not zero"):
        impulse_response(Sums.none(5).with_records(np.zeros((9, 1)), np.ones((9, 1))))


def test_white_noise_has_a_correlation_time_of_one_sample_and_a_low_pass_more():
    white = np.random.default_rng(0).standard_normal((20_000, 1))
    assert correlation_time(white) == pytest.approx(1.0, abs=0.1)
    slow = System(np.array([0.1]), np.array([1.0, -0.9]), T_S).simulate(white)
    assert correlation_time(slow) == pytest.approx(1.9 / 0.1, rel=0.3)  # (1 + a) / (1 - a)


def test_the_banded_solution_is_that_of_the_dense_criterion():
    found = impulse_response(Sums.none(12).with_records(*noisy(60, 0.2)))
    e = np.random.default_rng(1).standard_normal((50, 2))
    shifts = [np.eye(50, k=-i) for i in range(12)]
    G = np.einsum("i,ijk->jk", found.taps, np.stack(shifts))
    H = G.T @ G
    for i in range(12):
        for j in range(12):
            H = H + 3.0 * found.covariance[i, j] * shifts[i].T @ shifts[j]
    H = H + 1e-9 * H.diagonal().max() * np.eye(50)
    np.testing.assert_allclose(expected_best(found, 3.0, e), np.linalg.solve(H, G.T @ e), rtol=1e-6)


@pytest.mark.parametrize(
    "T_u",
    [ARX, ARX * 0.6, TwoMassLoop().T_motor, SystemMatrix.diagonal([ARX, ARX * 0.9])],
    ids=["servo", "low gain", "two-mass", "two motors"],
)
@pytest.mark.parametrize("noise", [0.0, 0.005])
@pytest.mark.parametrize("known", [False, True], ids=["", "reference known"])
def test_no_run_is_worse_than_run_0_and_five_reach_a_tenth(T_u, noise, known):
    reference = bump(250, 2)
    plant = LinearPlant(
        T_u=T_u, reference=reference, noise=noise, rng=np.random.default_rng(3) if noise else None
    )
    law = replace(LAW, reference=reference) if known else LAW
    norms = error_norms(plant, law, reference, 8)
    assert (norms[1:] < norms[0]).all()
    assert norms[:6].min() < 0.1 * norms[0]


def test_a_plant_of_the_other_sign_is_learned_after_one_worse_run():
    reference = bump(250)
    plant = LinearPlant(T_u=ARX * -1.0, T_r=ARX, reference=reference)
    norms = error_norms(plant, LAW, reference, 6)
    assert norms[1] > norms[0]
    assert norms[6] < 0.1 * norms[0]


def test_an_error_of_zero_leaves_the_correction():
    zero = np.zeros((50, 2))
    u, memory = LAW.step(zero, zero, None)
    u, memory = LAW.step(u, zero, memory)
    assert not u.any()


def test_an_update_after_a_worse_run_starts_from_the_best():
    reference = bump(250)
    plant = LinearPlant(T_u=ARX, reference=reference)
    good = list(learn(plant, LAW, reference, 3))[-1]
    rng = np.random.default_rng(0)
    spoilt = good.error + 0.5 * rng.standard_normal(good.error.shape)
    _, memory = LAW.step(good.correction, good.error, good.memory)
    u, after = LAW.step(good.correction, spoilt, memory)
    assert len(after.errors) - 1 - after.best == 1
    np.testing.assert_array_equal(after.errors[after.best], good.error)
    assert np.isfinite(u).all()
