"""Jobs on many processes: queue, store of results, grids of configurations."""
