"""Identification of T_u from records: ARX, output error, learning data."""
