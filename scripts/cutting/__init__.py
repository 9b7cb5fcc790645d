"""The cut of `armside laser`: its options, their meaning in SI, its files and tables."""
