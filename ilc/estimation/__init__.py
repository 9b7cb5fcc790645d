"""Estimation from noisy records: filters, smoothers, identification, consistency. Row F03.

Signals are records (N, p), time along the first axis; NaN rows are missing. Generic mathematics:
what is estimated, and of which robot, is said by the models that are handed in. The modules are
imported one by one, since filters bring numba and identification does not.
"""
