"""Evaluation of runs: tool error, path accuracy, kerf."""
