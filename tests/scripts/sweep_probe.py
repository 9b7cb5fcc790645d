"""A task for worker processes to import."""

import math
import os


def root_or_end(value: float) -> float:
    """Square root; the process ends where there is none."""
    return math.sqrt(value) if value >= 0.0 else os._exit(1)
