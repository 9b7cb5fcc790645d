"""Your own laws and your own plant, for `armside learn`."""

import numpy as np


def half(correction, error):
    """P-type law with gain 0.5 and one sample of lead."""
    return correction + 0.5 * np.roll(error, -1, axis=0)


class Forgetful:
    """u_{k+1} = (1 - forget) u_k + gain_k e_k, the gain falling over the iterations."""

    def __init__(self, gain=0.6, forget=0.02):
        self.gain, self.forget = gain, forget

    def step(self, correction, error, memory=None):
        k = 0 if memory is None else memory
        gain = self.gain / (1.0 + 0.1 * k)
        return (1.0 - self.forget) * correction + gain * np.roll(error, -5, axis=0), k + 1


class Oven:
    """Temperature behind a lag of 2 s, heated only, with a noisy sensor."""

    sample_time = 0.1

    def __init__(self, rng, noise=0.002):
        self.rng, self.noise = rng, noise
        self.reference = np.clip(np.arange(200) / 100.0, 0.0, 1.0)

    def run(self, correction):
        temperature, log = 0.0, []
        for wanted, u in zip(self.reference, correction[:, 0], strict=True):
            log.append(temperature + self.noise * self.rng.normal())
            temperature += 0.05 * (max(wanted + u, 0.0) - temperature)
        return np.array(log)
