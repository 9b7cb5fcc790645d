"""Iterative learning control: laws, filters, analysis, the learning loop and its measures.

Signals are records of shape (N, n): time along the first axis, one column a motor. u_k is the
correction of iteration k, r the reference, y_k the measured output, e_k = r - y_k; iteration 0
is the one before any learning. Frequencies are Hz where a person gives them (cutoffs) and
rad/sample in responses. A plant is anything with `run(correction) -> output`.
"""

import lazy_loader

__getattr__, __dir__, __all__ = lazy_loader.attach_stub(__name__, __file__)
