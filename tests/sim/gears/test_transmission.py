"""Deviations of a term's amplitude and phase are those of its coefficients."""

import numpy as np
import pytest

from armside.sim.gears.transmission import Transmission


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
