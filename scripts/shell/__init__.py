"""Shared by all commands: options, console, errors, interrupts."""
