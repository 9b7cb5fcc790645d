"""Methods of others on our arms, beside our own: what `armside reproduce papers` runs."""
