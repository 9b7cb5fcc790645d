"""Experiments: one a file, one command each.

An experiment is a function `name(*, cfg: NameCfg, common: Common) -> None` and one line in
`armside.scripts.cli.COMMANDS`. Whatever is wrong with its input is found before anything is written
(`armside.scripts.shell.errors`), and its results appear as one finished folder
(`armside.sim.records.run_folder`).
"""
