"""Searched designs, their storage, and learned policies."""
