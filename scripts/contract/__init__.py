"""Command lines made at random from the commands' own options, run and held against a contract."""
