"""`armside robot`: tables, pictures and files of a robot."""
