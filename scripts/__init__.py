"""The command `armside`: its commands, one a file, and what they share.

A command is a function `name(*, cfg: NameCfg, common: Common) -> None` in a file of its name in
`commands/`, and one line in `armside.scripts.cli.COMMANDS`. Bad input is found before anything is
written (`armside.scripts.shell.errors`), and results appear as one finished folder
(`armside.sim.records.run_folder`).
"""
