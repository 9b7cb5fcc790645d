"""Replay of runs: scenes for Rerun, pictures and films."""
