"""Benchmarks of `armside bench`, one subject a file."""
