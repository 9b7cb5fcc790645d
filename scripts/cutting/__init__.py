"""The cut of `armside laser`: its options, and their meaning in SI."""
