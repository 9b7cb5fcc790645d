"""State estimation from noisy records: Kalman filters, smoothers, prediction error, consistency.

Signals are records (N, p), time along the first axis; NaN rows are missing. The models passed in
define the states and the robot. Modules are imported one by one: filters need numba,
identification does not. Row F03 of docs/thesis.md.
"""
