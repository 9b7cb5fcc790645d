"""Tuning of a learning law as a task for search and reinforcement learning.

One episode is one job of one robot individual; one step is one ILC iteration with a design
(gamma, delta, cutoff) of the law Q(u + gamma q^delta e), thesis (9.2).
`gymnasium.make("armside:armside/IlcTuning-v1")` makes it without an import; without the prefix once
this package is imported. Units are SI and radians inside; angles of error
features are those of the motor shaft, as thesis 9.2.3 has them.
"""

from .registration import ENV_ID as ENV_ID
