"""Symbolic expressions: exact constants, a grammar for parameters, names, rotations."""
