"""One file for each command of `armside`."""
