"""Intervals of amplitude, phase and order: as often right as they say, on known gears."""

import os

import numpy as np
import pytest

from armside.sim.gears.fit import fit, softened
from armside.sim.gears.residual_spectra import Observation
from armside.sim.gears.several_observations import reweighted
from armside.sim.gears.transmission import CONFIDENCE, Transmission

SAMPLING, DURATION, BAND = 10.5, 120.0, (0.6, 3.5)
TERMS = ((0, 220.0), (1, 240.0))
AMPLITUDE, PHASE = np.array([11e-6, 11e-6]), np.array([0.7, 4.0])
NOISE = 6e-6
"""[m] rms, of a sample."""
REACH = 2.0
"""[m]"""
RESONANCE = 7.0
"""[Hz]"""
ROBOTS = 150 if os.environ.get("ARMSIDE_CI") else 50


def seen(seed, softness):
    """Observation by a tracker of two joints that move a point along x and y."""
    rng = np.random.default_rng(seed)
    time = np.arange(0.0, DURATION, 1.0 / SAMPLING)
    phi, rate = np.zeros((2, len(time), 2))
    for joint in range(2):
        for _ in range(3):
            f, a, start = rng.uniform(0.015, 0.05), rng.uniform(0.13, 0.26), rng.uniform(0.0, 6.0)
            angle = 2.0 * np.pi * f * time + start
            phi[:, joint] += a * np.sin(angle)
            rate[:, joint] += a * 2.0 * np.pi * f * np.cos(angle)
    J = np.zeros((len(time), 3, 2))
    J[:, 0, 0] = J[:, 1, 1] = REACH
    orders = np.array([order for _, order in TERMS])
    error = AMPLITUDE * np.sin(orders * phi + PHASE)
    moved = np.einsum("nij,nj->ni", J, error)
    f = np.fft.rfftfreq(len(time), 1.0 / SAMPLING)[:, None]
    spectrum = np.fft.rfft(moved, axis=0) / (1.0 - softness * f**2)
    amplified = np.fft.irfft(spectrum, len(time), axis=0)
    return Observation(
        phi=phi,
        rate=rate,
        J_point=J,
        J_rotation=np.zeros_like(J),
        residual=amplified + rng.normal(0.0, NOISE, moved.shape),
        band=BAND,
        sampling=SAMPLING,
    )


def found(seed, softness=0.0):
    """Fit of the known terms, with the arm's softness where it has one."""
    observations, spread = reweighted([seen(seed, softness)], TERMS), np.inf
    if softness:
        observations, _, spread = softened(observations, TERMS)
    return fit(observations, TERMS, spread)


@pytest.mark.parametrize("softness", [0.0, RESONANCE**-2])
def test_intervals_hold_the_truth_as_often_as_they_say(softness):
    """95 % intervals of two terms; 0.04 is three standard deviations of the count."""
    fits = [found(seed, softness) for seed in range(ROBOTS)]
    inside: list[bool] = []
    for one in fits:
        for term, amplitude, phase in zip(one.terms, AMPLITUDE, PHASE, strict=True):
            off = (term.phase - phase + np.pi) % (2.0 * np.pi) - np.pi
            inside.append(abs(term.amplitude - amplitude) < CONFIDENCE * term.amplitude_deviation)
            inside.append(abs(off) < CONFIDENCE * term.phase_deviation)
    assert abs(np.mean(inside) - 0.95) < 0.04


def test_an_elastic_arm_does_not_enlarge_what_is_found():
    rigid = fit([seen(0, RESONANCE**-2)], TERMS)
    elastic = found(0, RESONANCE**-2)
    enlarged, right = ([t.amplitude for t in one.terms] / AMPLITUDE for one in (rigid, elastic))
    assert enlarged.mean() > 1.06
    assert np.abs(right - 1.0).max() < 0.06


def test_deviations_are_the_scatter_of_amplitude_and_phase_of_drawn_coefficients():
    """A covariance that is wide along the coefficients and narrow across them."""
    mean, along = np.array([30e-6, 40e-6]), np.array([0.6, 0.8])
    covariance = (0.2e-6) ** 2 * np.eye(2) + (2e-6) ** 2 * np.outer(along, along)
    drawn = np.random.default_rng(0).multivariate_normal(mean, covariance, 4000)
    found = Transmission(
        joints=(0,),
        orders=np.array([120.0]),
        coefficients=mean[None],
        covariance=covariance,
        order_deviations=np.array([0.1]),
    )
    (term,) = found.terms
    amplitude, phase = np.hypot(*drawn.T), np.arctan2(drawn[:, 1], drawn[:, 0])
    # the scatter of 4000 draws is known to 1.1 %
    assert term.amplitude_deviation == pytest.approx(amplitude.std(), rel=0.05)
    assert term.phase_deviation == pytest.approx(phase.std(), rel=0.05)
