"""Options, plants and results of `armside learn`."""
