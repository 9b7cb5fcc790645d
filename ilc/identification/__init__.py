"""Identification of linear models from records."""
