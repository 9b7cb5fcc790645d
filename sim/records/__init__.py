"""Runs on disk: signals, tables, summaries, and the folders that hold them."""
