"""Iterative learning control: laws, filters, analysis, the learning loop and its measures."""
