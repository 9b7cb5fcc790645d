"""Memory of a benchmark."""

import resource


def peak_memory() -> float:
    """Largest memory of this process so far [GB]."""
    return resource.getrusage(resource.RUSAGE_SELF).ru_maxrss * 1024e-9
