"""The error of input that cannot be used: a file, a folder, an option."""


class InputError(ValueError):
    """Bad input. The message says what was given and what is allowed."""
