"""Symbolic Denavit-Hartenberg procedures, Lagrangian dynamics, singular configurations."""
