"""Experiments: one a file, one command each."""
